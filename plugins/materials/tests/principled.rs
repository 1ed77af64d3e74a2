//! The material of glTF: its samples, its energy, its symmetry, and its limits, in which it is other materials.

mod support;

use bhs_core::material::{Material, Shading};
use bhs_core::value::Param;
use glam::{Vec2, Vec3};
use std::f64::consts::PI;
use support::{
    AT, boolean, build, direction, float, outgoing, over_sphere, principled_rows, random, rough_glass, rough_white, texture,
};

fn made(values: &[(&str, f64)], more: &[Param]) -> Box<dyn Material> {
    let params: Vec<Param> = values.iter().map(|(name, value)| float(name, *value)).collect();
    build("principled", &[&params[..], more].concat())
}

fn numbers(k: u64) -> (f32, Vec2) {
    (random(31, 3 * k), Vec2::new(random(31, 3 * k + 1), random(31, 3 * k + 2)))
}

#[test]
fn weight_is_value_over_density() {
    for (name, material) in principled_rows() {
        for wo in outgoing() {
            for k in 0..2000 {
                let (choice, u) = numbers(k);
                let Some(s) = material.sample(&AT, wo, choice, u) else { continue };
                let (value, pdf) = (material.evaluate(&AT, wo, s.wi), material.pdf(&AT, wo, s.wi));
                assert!(!s.specular && (s.pdf / pdf - 1.0).abs() < 2e-3, "{name}: {} and {pdf}", s.pdf);
                let off = (s.weight - value / pdf).max().abs();
                assert!(off <= 1e-4 * s.weight.max().max(1.0), "{name}: {:?} and {:?}", s.weight, value / pdf);
            }
        }
    }
}

/// What comes back from even light, as power: radiance that is refracted has a factor, which power has not.
fn sent(material: &dyn Material, wo: Vec3, eta: f64) -> f64 {
    let power = |wi: Vec3| if wi.z * wo.z < 0.0 { if wo.z > 0.0 { eta * eta } else { 1.0 / (eta * eta) } } else { 1.0 };
    over_sphere(&|wi| f64::from(material.evaluate(&AT, wo, wi).max()) * power(wi), 1e-5)
}

#[test]
fn no_light_is_created() {
    for (name, material) in principled_rows() {
        let eta = if name.contains("glass") || name.contains("solid") { 1.5 } else { 1.0 };
        for wo in outgoing() {
            let share = sent(&*material, wo, eta);
            // Tables of the facets' shares are interpolated.
            assert!(share <= 1.0 + 1e-3 && share > 0.2, "{name} from {wo}: {share}");
        }
    }
    // A white ground sends all light back that its facets let through, and facets what they reflect: also what they lose to one another counts as let
    // through then.
    for roughness in [0.2, 0.5, 1.0] {
        let white = made(&[("reflectance", 1.0), ("roughness", roughness)], &[]);
        for wo in outgoing() {
            let share = sent(&*white, wo, 1.0);
            assert!((share - 1.0).abs() < 4e-3, "{roughness} from {wo}: {share}");
        }
    }
}

#[test]
fn the_mean_weight_is_the_share_and_smooth_parts_count_in_full() {
    let smooth: [(&[(&str, f64)], f64); 5] = [
        (&[("reflectance", 1.0), ("roughness", 0.0)], 1.0),
        (&[("reflectance", 1.0), ("roughness", 0.0), ("metallic", 1.0)], 1.0),
        (&[("reflectance", 1.0), ("roughness", 0.0), ("transmission", 1.0)], 1.0),
        (&[("reflectance", 1.0), ("roughness", 0.0), ("transmission", 0.5), ("metallic", 0.2)], 1.0),
        (&[("reflectance", 0.0), ("roughness", 0.0), ("specular", 0.0)], 0.0),
    ];
    for (values, expected) in smooth {
        let material = made(values, &[boolean("thin", true)]);
        for wo in outgoing() {
            let n = 40_000;
            let sum: f64 =
                (0..n).filter_map(|k| material.sample(&AT, wo, numbers(k).0, numbers(k).1)).map(|s| f64::from(s.weight[0])).sum();
            assert!((sum / n as f64 - expected).abs() < 0.01, "{values:?} from {wo}: {}", sum / n as f64);
        }
    }
    for (name, material) in principled_rows() {
        for wo in outgoing() {
            let n = 40_000;
            let sum: f64 =
                (0..n).filter_map(|k| material.sample(&AT, wo, numbers(k).0, numbers(k).1)).map(|s| f64::from(s.weight[0])).sum();
            let share = over_sphere(&|wi| f64::from(material.evaluate(&AT, wo, wi)[0]), 1e-5);
            assert!((sum / n as f64 - share).abs() < 0.012, "{name} from {wo}: {} and {share}", sum / n as f64);
            let reflectance = f64::from(material.reflectance(&AT, wo)[0]);
            let tolerance = if material.chooses_directions() || name.contains("lacquer") { 0.12 } else { 4e-3 };
            assert!((reflectance - share).abs() < tolerance, "{name} from {wo}: {reflectance} and {share}");
        }
    }
}

#[test]
fn light_may_run_backwards() {
    for (name, material) in principled_rows() {
        let eta: f32 = if name.contains("glass") || name.contains("solid") { 1.5 } else { 1.0 };
        for k in 0..3000u64 {
            let z = |i: u64| 0.02 + 0.96 * f64::from(random(7, 4 * k + i));
            let azimuth = |i: u64| 2.0 * PI * f64::from(random(7, 4 * k + i));
            let (a, b) = (direction(z(0), azimuth(1)), direction(z(2), azimuth(3)));
            for b in [b, -b] {
                let (there, back) = (material.evaluate(&AT, a, b) / b.z.abs(), material.evaluate(&AT, b, a) / a.z.abs());
                // Of radiance that is refracted: Veach 1997, eq. 5.14.
                let there = if b.z < 0.0 { there * (eta * eta) } else { there };
                let off = (there - back).map(f32::abs).max();
                assert!(off <= 2e-3 * back.max().max(1e-3), "{name} {a} {b}: {there:?} {back:?}");
            }
        }
    }
}

#[test]
fn its_limits_are_other_materials() {
    let same = |a: &dyn Material, b: &dyn Material, tolerance: f32| {
        for wo in outgoing() {
            for k in 0..200 {
                let wi = direction(2.0 * f64::from(numbers(k).0) - 1.0, 6.3 * f64::from(numbers(k).1.x));
                let (a, b) = (a.evaluate(&AT, wo, wi), b.evaluate(&AT, wo, wi));
                assert!((a - b).map(f32::abs).max() <= tolerance * b.max().max(1e-3), "{wo} {wi}: {a:?} {b:?}");
            }
        }
    };
    // Without what is reflected at facets, Lambert's law; a white metal; glass.
    same(&*made(&[("specular", 0.0), ("reflectance", 0.7)], &[]), &*build("diffuse", &[float("reflectance", 0.7)]), 1e-5);
    same(&*made(&[("metallic", 1.0), ("reflectance", 1.0), ("roughness", 0.5)], &[]), &*rough_white(0.25), 1e-3);
    let glass = made(&[("transmission", 1.0), ("reflectance", 1.0), ("roughness", 0.3f64.sqrt())], &[]);
    same(&*glass, &*rough_glass(0.3), 1e-4);
    assert_eq!(glass.refractive_index(), Some(1.5));
}

#[test]
fn parts_may_be_smooth_or_absent() {
    let mirror = made(&[("metallic", 1.0), ("roughness", 0.0)], &[]);
    assert!(mirror.is_specular() && !made(&[("roughness", 0.0)], &[]).is_specular());
    let wo = outgoing()[1];
    let s = mirror.sample(&AT, wo, 0.5, Vec2::splat(0.5)).expect("light");
    assert!(s.specular && (s.wi - Vec3::new(-wo.x, -wo.y, wo.z)).length() < 1e-6);
    // A pane lets light go straight on; a body refracts it.
    let clear = |thin| made(&[("transmission", 1.0), ("roughness", 0.0)], &[boolean("thin", thin)]);
    let through = |m: &dyn Material| m.sample(&AT, wo, 0.99, Vec2::splat(0.5)).expect("light");
    assert!((through(&*clear(true)).wi + wo).length() < 1e-6);
    let refracted = through(&*clear(false));
    assert!((refracted.wi.truncate().length() * 1.5 - wo.truncate().length()).abs() < 1e-5 && refracted.eta == 1.5);
    // Seen from behind, what is not there is not there.
    let sheet = made(&[], &[boolean("twosided", false)]);
    let s = sheet.sample(&AT, -wo, 0.5, Vec2::splat(0.5)).expect("light");
    assert!(s.specular && s.wi == wo && s.weight[0] == 1.0 && sheet.chooses_directions());
    assert!(!sheet.evaluate(&AT, wo, Vec3::Z).is_zero() && sheet.evaluate(&AT, -wo, -Vec3::Z).is_zero());
}

#[test]
fn every_number_may_be_a_texture() {
    let at = |u| Shading { uv: Vec2::new(u, 0.0), ..AT };
    for name in ["metallic", "roughness", "eta", "specular", "clearcoat", "clearcoatroughness", "transmission", "reflectance"] {
        let others = [("roughness", 0.6), ("clearcoat", 0.5), ("clearcoatroughness", 0.5), ("transmission", 0.3)];
        let others: Vec<(&str, f64)> = others.into_iter().filter(|(other, _)| *other != name).collect();
        let textured = made(&others, &[texture(name, "ramp")]);
        let plain = made(&[&others[..], &[(name, 0.7)]].concat(), &[]);
        let (wo, wi) = (outgoing()[1], outgoing()[2]);
        let off = (textured.evaluate(&at(0.7), wo, wi) - plain.evaluate(&AT, wo, wi)).map(f32::abs).max();
        assert!(off < 1e-5, "{name}");
        assert!(!textured.is_uniform());
    }
}

#[test]
fn grazing_directions_give_numbers() {
    let smooth = [made(&[("roughness", 0.0), ("clearcoat", 1.0), ("transmission", 0.5)], &[])];
    for material in principled_rows().into_iter().map(|row| row.1).chain(smooth) {
        for z in [0.0f32, -0.0, 1e-30, 1e-10, 1e-5, -1e-20, -1e-7] {
            let wo = Vec3::new((1.0 - z * z).sqrt(), 0.0, z);
            for k in 0..200 {
                let (choice, u) = numbers(k);
                if let Some(s) = material.sample(&AT, wo, choice, u) {
                    assert!(s.weight.is_finite() && s.pdf.is_finite() && s.pdf > 0.0 && s.wi.is_finite(), "{wo}: {s:?}");
                    assert!(material.evaluate(&AT, wo, s.wi).is_finite() && material.pdf(&AT, wo, s.wi).is_finite());
                }
            }
            assert!(material.evaluate(&AT, wo, -wo).is_finite() && material.evaluate(&AT, wo, wo).is_finite());
        }
    }
}
