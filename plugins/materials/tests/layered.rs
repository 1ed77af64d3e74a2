//! Coats, mixes and sheets: against a random walk between the layers, and closed forms.

mod support;

use bhs_core::material::Material;
use bhs_core::sampling::cosine_hemisphere;
use bhs_materials::fresnel;
use bhs_materials::microfacet::Ggx;
use bhs_materials::rough_interface::Interface;
use glam::{Vec2, Vec3};
use std::f64::consts::PI;
use support::{AT, build, coated, direction, float, outgoing, over_sphere, random, texts};

fn near(a: f32, b: f32, tolerance: f32) -> bool {
    (a - b).abs() <= tolerance * b.abs().max(1e-6)
}

/// A random walk of light between a coat and a matt ground: the share that comes out again without the coat's own reflection, and the
/// share that the coat reflects.
fn walk(wo: Vec3, alpha: f32, thickness: f32, reflectance: f64, seed: u64) -> (f64, f64) {
    let (eta, n) = (1.5f32, 200_000u64);
    let interface = Interface { eta, facets: Ggx::isotropic(alpha) };
    let crossing = |z: f32| f64::from((-thickness / z.abs()).exp());
    let (mut ground, mut coat) = (0.0, 0.0);
    for k in 0..n {
        let mut next = 0u64;
        let mut number = || {
            next += 1;
            random(seed, 64 * k + next)
        };
        // Where the boundary sends light that comes from `from`, and what is left of its power.
        let mut boundary = |from: Vec3| -> Option<(Vec3, f64)> {
            let (choice, u) = (number(), Vec2::new(number(), number()));
            if alpha > 0.0 {
                let to = interface.sample(from, choice, u)?;
                let (value, pdf) = interface.evaluate(from, to);
                let inward = if from.z > 0.0 { eta * eta } else { 1.0 / (eta * eta) };
                return Some((to, f64::from(value / pdf * if from.z * to.z > 0.0 { 1.0 } else { inward })));
            }
            let relative = if from.z > 0.0 { eta } else { 1.0 / eta };
            let (reflected, cos_t) = fresnel::dielectric(from.z.abs(), relative);
            let mirrored = Vec3::new(-from.x, -from.y, from.z);
            let refracted = Vec3::new(-from.x / relative, -from.y / relative, -cos_t.copysign(from.z));
            Some((if choice < reflected { mirrored } else { refracted }, 1.0))
        };
        let Some((mut w, mut power)) = boundary(wo) else { continue };
        if w.z > 0.0 {
            coat += power;
            continue;
        }
        for bounce in 0..20u64 {
            let u = Vec2::new(random(seed + 1, 64 * k + 2 * bounce), random(seed + 1, 64 * k + 2 * bounce + 1));
            let up = cosine_hemisphere(u);
            power *= crossing(w.z) * reflectance * crossing(up.z);
            let Some((to, left)) = boundary(-up) else { break };
            power *= left;
            if to.z > 0.0 {
                ground += power;
                break;
            }
            w = to;
        }
    }
    (ground / n as f64, coat / n as f64)
}

#[test]
fn coated_surfaces_reflect_what_a_random_walk_does() {
    for (alpha, thickness, reflectance) in [(0.0, 0.01, 0.5), (0.0, 0.3, 0.9), (0.1, 0.01, 0.8), (0.4, 0.1, 0.9)] {
        let material = coated(reflectance, f64::from(alpha), f64::from(thickness));
        for (i, wo) in outgoing().into_iter().enumerate().filter(|(_, wo)| wo.z > 0.0) {
            let (ground, coat) = walk(wo, alpha, thickness, reflectance, 2 * i as u64 + 20);
            let total = f64::from(material.reflectance(&AT, wo)[0]);
            assert!((total - ground - coat).abs() < 0.006, "alpha {alpha}, {wo}: {total}, walk {ground} + {coat}");
            // The rough part by quadrature: all of it, but for the reflection of a smooth coat.
            let value = over_sphere(&|wi| f64::from(material.evaluate(&AT, wo, wi)[0]), 1e-4);
            let expected = ground + if alpha > 0.0 { coat } else { 0.0 };
            assert!((value - expected).abs() < 0.006, "alpha {alpha}, {wo}: {value}, walk {expected}");
        }
    }
}

#[test]
fn a_white_ground_under_a_smooth_coat_loses_nothing() {
    let material = coated(1.0, 0.0, 0.0);
    for wo in outgoing() {
        let total = material.reflectance(&AT, wo)[0];
        assert!((total - 1.0).abs() < 2e-3, "{wo}: {total}");
        // The mean weight of its samples is the same.
        let n = 40_000u64;
        let weight = |k: u64| material.sample(&AT, wo, random(3, 3 * k), Vec2::new(random(3, 3 * k + 1), random(3, 3 * k + 2)));
        let mean = (0..n).filter_map(weight).map(|s| f64::from(s.weight[0])).sum::<f64>() / n as f64;
        assert!((mean - 1.0).abs() < 6e-3, "{wo}: {mean}");
    }
    for alpha in [0.05, 0.3, 1.0] {
        let material = coated(1.0, alpha, 0.0);
        for wo in outgoing() {
            let total = material.reflectance(&AT, wo)[0];
            assert!(total < 1.0 + 2e-3 && total > 0.3, "alpha {alpha}, {wo}: {total}");
        }
    }
}

#[test]
fn weights_are_values_over_densities_and_light_may_run_backwards() {
    let mix = |a: &str, b: &str| build("mix", &[texts("materials", &[a, b]), float("amount", 0.3)]);
    let materials: [(&str, Box<dyn Material>); 6] = [
        ("smooth coat", coated(0.8, 0.0, 0.01)),
        ("rough coat", coated(0.8, 0.2, 0.01)),
        ("sheet", build("diffusetransmission", &[float("reflectance", 0.5), float("transmittance", 0.3)])),
        ("mix", mix("gold", "matt")),
        ("half a mirror", mix("matt", "mirror")),
        ("mixed glass", mix("matt", "glass")),
    ];
    for (name, material) in &materials {
        for wo in outgoing() {
            for k in 0..2000 {
                let u = Vec2::new(random(5, 3 * k + 1), random(5, 3 * k + 2));
                let Some(s) = material.sample(&AT, wo, random(5, 3 * k), u) else { continue };
                assert!((s.wi.length() - 1.0).abs() < 1e-5 && s.weight.is_finite());
                if s.specular {
                    assert!(s.wi == Vec3::new(-wo.x, -wo.y, wo.z), "{name}");
                    continue;
                }
                let (value, pdf) = (material.evaluate(&AT, wo, s.wi), material.pdf(&AT, wo, s.wi));
                assert!(near(s.pdf, pdf, 1e-3) && near(s.weight[0], value[0] / pdf, 1e-3), "{name}: {s:?} {value:?} {pdf}");
            }
        }
        if *name == "mixed glass" {
            continue;
        }
        for k in 0..2000u64 {
            let turn =
                |i: u64| direction(2.0 * f64::from(random(7, 4 * k + i)) - 1.0, 2.0 * PI * f64::from(random(7, 4 * k + i + 1)));
            let (a, b) = (turn(0), turn(2));
            let (there, back) = (material.evaluate(&AT, a, b) / b.z.abs(), material.evaluate(&AT, b, a) / a.z.abs());
            assert!(near(there[0], back[0], 1e-3), "{name} {a} {b}: {there:?} {back:?}");
        }
    }
}

#[test]
fn a_mix_is_made_of_its_parts() {
    let part = |amount: f64| build("mix", &[texts("materials", &["matt", "gold"]), float("amount", amount)]);
    let (first, second, third) = (part(0.0), part(1.0), part(0.3));
    for (wo, wi) in [(direction(0.8, 0.0), direction(0.7, 3.0)), (direction(0.3, 1.0), direction(0.9, 2.0))] {
        let (a, b, c) = (first.evaluate(&AT, wo, wi), second.evaluate(&AT, wo, wi), third.evaluate(&AT, wo, wi));
        assert_eq!(a, build("diffuse", &[float("reflectance", 1.0)]).evaluate(&AT, wo, wi));
        assert!((0..4).all(|i| near(c[i], 0.7 * a[i] + 0.3 * b[i], 1e-5)));
    }
    // Of half a mirror, the mirror's share of the samples is the mirror's share of the light.
    let half = build("mix", &[texts("materials", &["matt", "mirror"]), float("amount", 0.3)]);
    let n = 1000;
    let mirrored = (0..n).filter_map(|k| half.sample(&AT, direction(0.5, 0.0), (k as f32 + 0.5) / n as f32, Vec2::splat(0.3)));
    let weights: Vec<f32> = mirrored.filter(|s| s.specular).map(|s| s.weight[0]).collect();
    assert!(weights.len() == 300 && weights.iter().all(|w| near(*w, 1.0, 1e-5)));
    assert!(!half.is_specular() && half.chooses_directions());
}

#[test]
fn a_sheet_sends_no_more_than_it_gets() {
    for (r, t) in [(0.3, 0.5), (0.9, 0.9), (0.0, 1.0)] {
        let sheet = build("diffusetransmission", &[float("reflectance", r), float("transmittance", t)]);
        let total = over_sphere(&|wi| f64::from(sheet.evaluate(&AT, direction(0.7, 0.1), wi)[0]), 1e-5);
        assert!((total - (r + t).min(1.0)).abs() < 1e-4, "{r} {t}: {total}");
    }
}
