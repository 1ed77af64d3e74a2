//! Weights, energy and reciprocity: what a material says of itself agrees, and creates no light.

mod support;

use bhs_core::material::{BsdfSample, Material};
use bhs_core::spectrum::SampledSpectrum;
use bhs_materials::microfacet::Ggx;
use glam::{Vec2, Vec3};
use std::f64::consts::PI;
use support::{AT, brushed, build, direction, float, outgoing, over_sphere, random, rough_gold, rough_white};

fn rough_materials() -> Vec<(String, Box<dyn Material>)> {
    let mut all = vec![("diffuse".to_owned(), build("diffuse", &[float("reflectance", 0.8)]))];
    for alpha in [0.005, 0.05, 0.2, 0.6, 1.0] {
        all.push((format!("gold {alpha}"), rough_gold(alpha)));
        all.push((format!("white {alpha}"), rough_white(alpha)));
    }
    for alpha in [[0.05, 0.3], [0.8, 0.2], [0.1, 1.0]] {
        all.push((format!("brushed {alpha:?}"), brushed("conductor", "", alpha, &[float("reflectance", 1.0)])));
        all.push((format!("varnished {alpha:?}"), brushed("coateddiffuse", "", alpha, &[float("reflectance", 0.9)])));
    }
    all
}

/// Sample `k` of a random sequence.
fn sample(material: &dyn Material, wo: Vec3, k: u64) -> Option<BsdfSample> {
    material.sample(&AT, wo, random(5, 3 * k), Vec2::new(random(5, 3 * k + 1), random(5, 3 * k + 2)))
}

fn near(a: SampledSpectrum, b: SampledSpectrum, tolerance: f32) -> bool {
    a.0.iter().zip(b.0).all(|(a, b)| (a - b).abs() <= tolerance * b.abs().max(1e-6))
}

#[test]
fn weight_is_value_over_density() {
    for (name, material) in rough_materials() {
        for wo in outgoing() {
            for k in 0..2000 {
                let Some(s) = sample(&*material, wo, k) else { continue };
                let (value, pdf) = (material.evaluate(&AT, wo, s.wi), material.pdf(&AT, wo, s.wi));
                // The facet's normal is found again from two rounded directions: 1e-7 over its width.
                let slack = if name.contains("0.005") { 2e-2 } else { 2e-3 };
                assert!((s.pdf / pdf - 1.0).abs() < slack, "{name}: {} and {pdf}", s.pdf);
                assert!(near(s.weight, value / pdf, 1e-4), "{name}: {:?} and {:?}", s.weight, value / pdf);
                assert!(!s.specular && (s.wi.length() - 1.0).abs() < 1e-5 && s.wi.z * wo.z > 0.0);
                // Of two lobes at once, one may be drawn more seldom than it counts.
                assert!(name.starts_with("varnished") || s.weight.max() <= 1.0 + 1e-6);
            }
        }
    }
}

#[test]
fn no_light_is_created() {
    for (name, material) in rough_materials().into_iter().filter(|(name, _)| !name.contains("0.005")) {
        for wo in outgoing() {
            let reflected = over_sphere(&|wi| f64::from(material.evaluate(&AT, wo, wi).max()), 1e-5);
            assert!(reflected <= 1.0, "{name} from {wo}: {reflected}");
            // The mean weight of samples is the same integral.
            let n = 40_000;
            let total: f64 = (0..n).filter_map(|k| sample(&*material, wo, k)).map(|s| f64::from(s.weight.max())).sum();
            let mean = total / n as f64;
            assert!((mean - reflected).abs() < 0.006, "{name} from {wo}: {mean}, not {reflected}");
            if name == "diffuse" {
                assert!((reflected - 0.8).abs() < 1e-4);
            }
            // Narrow facets lose next to nothing.
            if name == "white 0.05" && wo.z.abs() > 0.4 {
                assert!(reflected > 0.99, "{reflected}");
            }
        }
    }
}

#[test]
fn light_may_run_backwards_and_both_sides_are_alike() {
    for (name, material) in rough_materials() {
        for k in 0..3000u64 {
            let z = |i: u64| 0.01 + 0.98 * f64::from(random(7, 4 * k + i));
            let azimuth = |i: u64| 2.0 * PI * f64::from(random(7, 4 * k + i));
            let (a, b) = (direction(z(0), azimuth(1)), direction(z(2), azimuth(3)));
            let (there, back) = (material.evaluate(&AT, a, b) / b.z, material.evaluate(&AT, b, a) / a.z);
            assert!(near(there, back, 1e-4), "{name} {a} {b}: {there:?} {back:?}");
            let flip = Vec3::new(1.0, 1.0, -1.0);
            assert_eq!(material.evaluate(&AT, a * flip, b * flip), material.evaluate(&AT, a, b));
            assert_eq!(material.pdf(&AT, a * flip, b * flip), material.pdf(&AT, a, b));
            assert!(material.evaluate(&AT, a, b * flip).is_zero() && material.pdf(&AT, a, b * flip) == 0.0);
        }
    }
}

#[test]
fn facets_are_those_of_the_textbook() {
    for alpha in [0.05f32, 0.3, 1.0] {
        let ggx = Ggx::isotropic(alpha);
        // Their areas project to the surface's, and what a viewer sees of them projects to what it sees of the surface.
        let upper = |f: &dyn Fn(Vec3) -> f32| over_sphere(&|m| if m.z > 0.0 { f64::from(f(m)) } else { 0.0 }, 1e-5);
        assert!((upper(&|m| ggx.density(m) * m.z) - 1.0).abs() < 1e-4);
        for wo in outgoing().into_iter().filter(|w| w.z > 0.0) {
            assert!((upper(&|m| ggx.visible_density(wo, m)) - 1.0).abs() < 1e-4, "alpha {alpha}, wo {wo}");
            // Walter et al. 2007 eq. 33 and 34 in double precision, Heitz 2014 eq. 99.
            let wi = direction(0.4, 2.5);
            let m = (wo + wi).normalize();
            let tan2 = |w: Vec3| (1.0 / f64::from(w.z).powi(2) - 1.0).max(0.0);
            let a2 = f64::from(alpha).powi(2);
            let lambda = |w: Vec3| ((1.0 + a2 * tan2(w)).sqrt() - 1.0) / 2.0;
            let density = a2 / (PI * f64::from(m.z).powi(4) * (a2 + tan2(m)).powi(2));
            let g1 = 1.0 / (1.0 + lambda(wo));
            let g2 = 1.0 / (1.0 + lambda(wo) + lambda(wi));
            assert!((f64::from(ggx.density(m)) / density - 1.0).abs() < 1e-4);
            assert!((f64::from(ggx.masking_per_cos(wo) * wo.z) / g1 - 1.0).abs() < 1e-5);
            assert!((f64::from(ggx.shadowing(wo, wi)) / (g2 / g1) - 1.0).abs() < 1e-5);
            let white = rough_white(f64::from(alpha)).evaluate(&AT, wo, wi).0[0];
            let whole = density * g2 / (4.0 * f64::from(wo.z));
            // The reflectance is 0.9999 at normal incidence, and nearly so elsewhere.
            assert!((f64::from(white) / whole - 1.0).abs() < 3e-4, "{white} {whole}");
        }
    }
}

#[test]
fn brushed_facets_are_those_of_the_textbook() {
    for [ax, ay] in [[0.05f32, 0.3], [0.6, 0.2], [0.3, 0.3]] {
        let ggx = Ggx { alpha: Vec2::new(ax, ay) };
        let upper = |f: &dyn Fn(Vec3) -> f32| over_sphere(&|m| if m.z > 0.0 { f64::from(f(m)) } else { 0.0 }, 1e-5);
        assert!((upper(&|m| ggx.density(m) * m.z) - 1.0).abs() < 1e-4);
        for wo in outgoing().into_iter().filter(|w| w.z > 0.0) {
            assert!((upper(&|m| ggx.visible_density(wo, m)) - 1.0).abs() < 1e-4, "{ax} {ay}, wo {wo}");
            // Heitz 2014 eqs. 85 and 87, by slopes and by the width along the azimuth, in double precision.
            let wi = direction(0.4, 2.5);
            let m = (wo + wi).normalize();
            let [ax, ay] = [ax, ay].map(f64::from);
            let slope = |v: Vec3| [f64::from(v.x / v.z), f64::from(v.y / v.z)];
            let [sx, sy] = slope(m);
            let of_slopes = 1.0 / (PI * ax * ay * (1.0 + sx * sx / (ax * ax) + sy * sy / (ay * ay)).powi(2));
            let density = of_slopes / f64::from(m.z).powi(4);
            let lambda = |w: Vec3| {
                let [x, y] = slope(w);
                ((1.0 + (x * ax).powi(2) + (y * ay).powi(2)).sqrt() - 1.0) / 2.0
            };
            let (g1, g2) = (1.0 / (1.0 + lambda(wo)), 1.0 / (1.0 + lambda(wo) + lambda(wi)));
            assert!((f64::from(ggx.density(m)) / density - 1.0).abs() < 1e-4);
            assert!((f64::from(ggx.masking_per_cos(wo) * wo.z) / g1 - 1.0).abs() < 1e-5);
            assert!((f64::from(ggx.shadowing(wo, wi)) / (g2 / g1) - 1.0).abs() < 1e-5);
        }
    }
    // A highlight is as long across as the roughness is large along: facets lean along x where u is rough.
    let ggx = Ggx { alpha: Vec2::new(0.4, 0.1) };
    assert!(ggx.density(direction(0.9, 0.0)) > 5.0 * ggx.density(direction(0.9, PI / 2.0)));
}

#[test]
fn grazing_directions_give_numbers() {
    for (name, material) in rough_materials() {
        for z in [0.0f32, -0.0, 1e-30, 1e-20, 1e-10, 1e-5, -1e-20, -1e-7] {
            let wo = Vec3::new((1.0 - z * z).sqrt(), 0.0, z);
            for (x, y) in [(0.0, 0.0), (0.5, 0.5), (0.999_999_9, 0.999_999_9), (0.0, 0.999_999_9), (0.25, 0.0)] {
                if let Some(s) = material.sample(&AT, wo, 0.5, Vec2::new(x, y)) {
                    let fine = s.weight.is_finite() && s.pdf.is_finite() && s.pdf > 0.0 && s.wi.is_finite();
                    assert!(fine && s.weight.max() <= 1.0 + 1e-5, "{name} {wo} {x} {y}: {s:?}");
                    let value = material.evaluate(&AT, wo, s.wi);
                    assert!(value.is_finite() && material.pdf(&AT, wo, s.wi).is_finite(), "{name} {wo}: {value:?}");
                }
                assert!(material.evaluate(&AT, wo, -wo).is_finite() && material.evaluate(&AT, wo, wo).is_finite());
            }
        }
    }
}
