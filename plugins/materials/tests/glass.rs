//! Rough glass, and glass that disperses, against optics.

mod support;

use bhs_core::material::{Material, Shading};
use bhs_core::spectrum::SampledSpectrum;
use glam::{Vec2, Vec3};
use std::f64::consts::PI;
use support::{AT, boolean, build, direction, float, named, outgoing, over_sphere, random, rough_glass};

/// Radiance that is refracted counts as power where it arrives: times the squared index on that side over this one's.
fn power(value: f32, eta: f64, wo: Vec3, wi: Vec3) -> f64 {
    let through = if wo.z > 0.0 { eta * eta } else { 1.0 / (eta * eta) };
    f64::from(value) * if wo.z * wi.z > 0.0 { 1.0 } else { through }
}

#[test]
fn rough_glass_creates_no_light_and_loses_little() {
    for alpha in [0.1, 0.3, 0.7] {
        let glass = rough_glass(alpha);
        for wo in outgoing() {
            let total = over_sphere(&|wi| power(glass.evaluate(&AT, wo, wi)[0], 1.5, wo, wi), 1e-4);
            // What meets two facets is lost.
            let least = if alpha <= 0.1 && wo.z.abs() > 0.4 { 0.96 } else { 0.5 };
            assert!(total <= 1.0 + 1e-3 && total > least, "alpha {alpha}, {wo}: {total}");
        }
    }
}

#[test]
fn light_may_run_backwards_through_rough_glass() {
    // Veach 1997, eq. 5.14: f(o, i) / eta_o^2 = f(i, o) / eta_i^2, the index on the side of the light that leaves.
    for alpha in [0.05, 0.3, 0.8] {
        let glass = rough_glass(alpha);
        for k in 0..5000u64 {
            let turn =
                |i: u64| direction(2.0 * f64::from(random(8, 4 * k + i)) - 1.0, 2.0 * PI * f64::from(random(8, 4 * k + i + 1)));
            let (a, b) = (turn(0), turn(2));
            let index = |w: Vec3| if w.z > 0.0 { 1.0f32 } else { 1.5 };
            let there = glass.evaluate(&AT, a, b)[0] / b.z.abs() / index(a).powi(2);
            let back = glass.evaluate(&AT, b, a)[0] / a.z.abs() / index(b).powi(2);
            assert!((there - back).abs() <= 2e-3 * there.max(5e-4), "alpha {alpha} {a} {b}: {there} {back}");
        }
    }
}

#[test]
fn weight_is_value_over_density() {
    let dispersive =
        |alpha| build("dielectric", &[named("eta", "glass-SF11"), float("roughness", alpha), boolean("remaproughness", false)]);
    for glass in [rough_glass(0.1), rough_glass(0.6), dispersive(0.1), dispersive(0.5)] {
        for wo in outgoing() {
            let mut seen = 0;
            for k in 0..3000 {
                let u = Vec2::new(random(6, 3 * k + 1), random(6, 3 * k + 2));
                let Some(s) = glass.sample(&AT, wo, random(6, 3 * k), u) else { continue };
                let (value, pdf) = (glass.evaluate(&AT, wo, s.wi), glass.pdf(&AT, wo, s.wi));
                assert!((s.pdf / pdf - 1.0).abs() < 1e-3 && !s.specular && !s.drops_wavelengths);
                let near = |a: f32, b: f32| (a - b).abs() <= 1e-3 * b.abs().max(1e-3);
                assert!((0..4).all(|i| near(s.weight[i], value[i] / pdf)), "{:?} {:?}", s.weight, value / pdf);
                // No wavelength counts for more than it should, but for the factor of refraction.
                assert!(s.weight.max() <= 4.0 * 1.81 * 1.81 * 1.001, "{:?}", s.weight);
                seen += 1;
            }
            assert!(seen > 1500, "{seen} of 3000 from {wo}");
        }
    }
}

#[test]
fn hardly_rough_glass_is_smooth_glass() {
    // Around the direction of Snell's law: nearly all that is refracted.
    let glass = rough_glass(0.002);
    for z in [0.9, 0.5, -0.9] {
        let wo = direction(z, 0.3);
        let smooth = build("dielectric", &[float("eta", 1.5)]);
        let n = 4000;
        let (mut refracted, mut near) = (0.0, 0);
        for k in 0..n {
            let s = glass.sample(&AT, wo, (k as f32 + 0.5) / n as f32, Vec2::new(random(9, 2 * k), random(9, 2 * k + 1)));
            let Some(s) = s else { continue };
            let one = smooth.sample(&AT, wo, if s.wi.z * wo.z > 0.0 { 0.0 } else { 0.999_999 }, Vec2::ZERO).expect("light");
            near += u32::from((s.wi - one.wi).length() < 0.05 && (s.weight[0] / one.weight[0] - 1.0).abs() < 1e-2);
            refracted += f32::from(s.wi.z * wo.z < 0.0);
        }
        // The distribution has a long tail.
        assert!(f64::from(near) > 0.97 * n as f64, "{z}: {near} of {n}");
        let eta = if z > 0.0 { 1.5 } else { 1.0 / 1.5 };
        let (reflected, _) = bhs_materials::fresnel::dielectric(wo.z.abs(), eta);
        assert!((refracted / n as f32 - (1.0 - reflected)).abs() < 2e-3);
    }
}

/// Schott's index of N-BK7 at the lines F (486.13 nm) and C (656.27 nm), and of SF11, from its catalogue.
const CATALOGUE: [(&str, [f64; 2]); 2] = [("glass-BK7", [1.522_38, 1.514_32]), ("glass-SF11", [1.806_45, 1.775_99])];

#[test]
fn each_wavelength_refracts_by_its_own_index() {
    for (name, indices) in CATALOGUE {
        let glass = build("dielectric", &[named("eta", name)]);
        for (line, index) in [486.13f32, 656.27].into_iter().zip(indices) {
            // The first wavelength is the one that goes on.
            let at = Shading { lambda_nm: [line, 520.0, 589.0, 700.0], ..AT };
            let wo = direction(0.6, 1.0);
            let s = glass.sample(&at, wo, 0.999, Vec2::ZERO).expect("refracted");
            assert!(s.specular && s.drops_wavelengths && s.wi.z < 0.0);
            let sine = f64::from(s.wi.x).hypot(f64::from(s.wi.y));
            assert!((0.8 / sine - index).abs() < 3e-5, "{name} at {line} nm: {} {index}", 0.8 / sine);
        }
    }
}

#[test]
fn dispersive_glass_keeps_the_mean_of_every_wavelength() {
    // Mean of what is reflected, by wavelength; and of what is refracted, by the first.
    let glass = build("dielectric", &[named("eta", "glass-SF11")]);
    for wo in [direction(0.8, 0.2), direction(0.2, 2.0), direction(-0.85, 0.0)] {
        let n = 20_000;
        let (mut reflected, mut refracted) = (SampledSpectrum::ZERO, 0.0);
        for k in 0..n {
            let Some(s) = glass.sample(&AT, wo, (k as f32 + 0.5) / n as f32, Vec2::ZERO) else { continue };
            if s.wi.z * wo.z > 0.0 {
                assert!(!s.drops_wavelengths);
                reflected += s.weight;
            } else {
                refracted += s.weight[0];
            }
        }
        let index = |l: f32| {
            let at = Shading { lambda_nm: [l; 4], ..AT };
            let s = glass.sample(&at, Vec3::Z, 0.999, Vec2::ZERO).expect("refracted");
            s.weight[0].powf(-0.5)
        };
        let relative = |l: f32| if wo.z > 0.0 { index(l) } else { 1.0 / index(l) };
        for i in 0..4 {
            let exact = bhs_materials::fresnel::dielectric(wo.z.abs(), relative(AT.lambda_nm[i])).0;
            let mean = reflected[i] / n as f32;
            assert!((mean - exact).abs() < 1e-3, "{wo} {i}: {mean} {exact}");
        }
        let eta = relative(AT.lambda_nm[0]);
        let exact = (1.0 - bhs_materials::fresnel::dielectric(wo.z.abs(), eta).0) / (eta * eta);
        assert!((refracted / n as f32 - exact).abs() < 2e-3, "{wo}: {} {exact}", refracted / n as f32);
    }
}

#[test]
fn grazing_directions_give_numbers() {
    let glasses: [Box<dyn Material>; 3] = [rough_glass(0.002), rough_glass(0.3), rough_glass(1.0)];
    for glass in &glasses {
        for z in [0.0f32, -0.0, 1e-30, 1e-10, 1e-5, -1e-20, -1e-7] {
            let wo = Vec3::new((1.0 - z * z).sqrt(), 0.0, z);
            for (x, y) in [(0.0, 0.0), (0.5, 0.5), (0.999_999_9, 0.999_999_9), (0.0, 0.999_999_9), (0.25, 0.0)] {
                for choice in [0.0, 0.5, 0.999_999] {
                    if let Some(s) = glass.sample(&AT, wo, choice, Vec2::new(x, y)) {
                        assert!(s.weight.is_finite() && s.pdf.is_finite() && s.pdf > 0.0 && s.wi.is_finite(), "{wo}: {s:?}");
                    }
                }
                assert!(glass.evaluate(&AT, wo, -wo).is_finite() && glass.evaluate(&AT, wo, wo).is_finite());
            }
        }
    }
}
