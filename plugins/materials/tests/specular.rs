//! Mirrors, polished metal and glass against the closed forms of optics.

mod support;

use bhs_core::spectrum::SampledSpectrum;
use bhs_materials::fresnel;
use glam::{Vec2, Vec3};
use support::{AT, build, direction, float, named, outgoing};

/// A complex number, for the computation apart.
#[derive(Clone, Copy)]
struct Complex(f64, f64);

impl Complex {
    fn mul(self, o: Self) -> Self {
        Self(self.0 * o.0 - self.1 * o.1, self.0 * o.1 + self.1 * o.0)
    }
    fn div(self, o: Self) -> Self {
        let n = o.norm();
        Self((self.0 * o.0 + self.1 * o.1) / n, (self.1 * o.0 - self.0 * o.1) / n)
    }
    fn sub(self, o: Self) -> Self {
        Self(self.0 - o.0, self.1 - o.1)
    }
    fn add(self, o: Self) -> Self {
        Self(self.0 + o.0, self.1 + o.1)
    }
    fn norm(self) -> f64 {
        self.0 * self.0 + self.1 * self.1
    }
    fn sqrt(self) -> Self {
        let (r, angle) = (self.norm().sqrt().sqrt(), self.1.atan2(self.0) / 2.0);
        Self(r * angle.cos(), r * angle.sin())
    }
}

/// Fresnel's amplitudes with a complex angle of refraction by Snell's law.
fn by_amplitudes(cos_i: f64, eta: f64, k: f64) -> f64 {
    let (one, n, ci) = (Complex(1.0, 0.0), Complex(eta, k), Complex(cos_i, 0.0));
    let sine = Complex((1.0 - cos_i * cos_i).sqrt(), 0.0).div(n);
    let ct = one.sub(sine.mul(sine)).sqrt();
    let rs = ci.sub(n.mul(ct)).div(ci.add(n.mul(ct)));
    let rp = n.mul(ci).sub(ct).div(n.mul(ci).add(ct));
    0.5 * (rs.norm() + rp.norm())
}

#[test]
fn dielectric_reflectance_has_its_landmarks() {
    for eta in [1.33f32, 1.5, 2.42, 1.0 / 1.5] {
        let (normal, cos_t) = fresnel::dielectric(1.0, eta);
        assert!((normal - ((eta - 1.0) / (eta + 1.0)).powi(2)).abs() < 1e-6 && cos_t == 1.0);
        // Brewster's angle, tan = eta: the parallel part vanishes, the rest is half of ((1 - eta^2)/(1 + eta^2))^2.
        let brewster = (1.0 / (1.0 + eta * eta)).sqrt();
        let (r, _) = fresnel::dielectric(brewster, eta);
        assert!((r - 0.5 * ((1.0 - eta * eta) / (1.0 + eta * eta)).powi(2)).abs() < 1e-6);
        assert!((fresnel::dielectric(0.0, eta).0 - 1.0).abs() < 1e-6);
        // From the other side the refracted ray sees the same reflectance.
        for i in 1..100 {
            let cos_i = i as f32 / 100.0;
            let (there, cos_t) = fresnel::dielectric(cos_i, eta);
            if cos_t > 0.0 {
                let (back, cos_back) = fresnel::dielectric(cos_t, 1.0 / eta);
                // A cosine near 0 comes back as the root of a small difference, hence not to the last digit.
                assert!((there - back).abs() < 3e-4 && (cos_back - cos_i).abs() < 1e-4, "{eta} {cos_i}: {there} {back}");
                assert!((f64::from(there) - by_amplitudes(f64::from(cos_i), f64::from(eta), 0.0)).abs() < 1e-5);
            }
        }
    }
    // Total reflection inside glass sets in at sin = 1/1.5.
    let critical = (1.0f32 - 1.0 / 2.25).sqrt();
    assert_eq!(fresnel::dielectric(critical - 1e-3, 1.0 / 1.5), (1.0, 0.0));
    let (below, cos_t) = fresnel::dielectric(critical + 1e-3, 1.0 / 1.5);
    assert!(below < 0.9 && cos_t > 0.0);
    assert!(fresnel::dielectric(0.3, 1.0).0 < 1e-12);
}

#[test]
fn conductor_reflectance_is_that_of_the_amplitudes() {
    for (eta, k) in [(0.2, 3.0), (1.5, 1.9), (0.05, 8.0), (1.0, 0.0), (1.5, 0.0), (0.6, 0.0), (2.9, 3.1)] {
        for i in 0..=100 {
            let cos_i = f64::from(i) / 100.0;
            let ours = f64::from(fresnel::conductor(cos_i as f32, eta as f32, k as f32));
            // Where total reflection sets in, the slope is infinite.
            if k == 0.0 && (1.0 - cos_i * cos_i - eta * eta).abs() < 1e-3 {
                continue;
            }
            let amplitudes = by_amplitudes(cos_i, eta, k);
            assert!((ours - amplitudes).abs() < 2e-6, "{eta} + i {k} at {cos_i}: {ours}, not {amplitudes}");
        }
    }
}

#[test]
fn polished_gold_reflects_as_measured() {
    let gold = [named("eta", "metal-Au-eta"), named("k", "metal-Au-k")];
    let polished = build("conductor", &gold);
    assert!(polished.is_specular());
    // Johnson and Christy's rows at 450.9, 520.9, 582.1 and 659.5 nm.
    let rows = [(450.9, 1.38, 1.914), (520.9, 0.62, 2.081), (582.1, 0.29, 2.863), (659.5, 0.14, 3.697)];
    let at = bhs_core::material::Shading { lambda_nm: rows.map(|r| r.0), ..AT };
    for degrees in [0.0f64, 45.0, 80.0] {
        let cos = degrees.to_radians().cos();
        for side in [1.0, -1.0] {
            let wo = direction(side * cos, 0.7);
            let s = polished.sample(&at, wo, 0.5, Vec2::splat(0.5)).expect("metal reflects");
            assert!(s.specular && s.pdf == 1.0 && s.wi == Vec3::new(-wo.x, -wo.y, wo.z));
            for (i, (_, eta, k)) in rows.into_iter().enumerate() {
                let exact = by_amplitudes(cos, eta, k);
                assert!((f64::from(s.weight[i]) - exact).abs() < 1e-5, "{degrees} degrees, {i}: {} {exact}", s.weight[i]);
            }
        }
    }
    assert!(polished.evaluate(&AT, Vec3::Z, Vec3::Z).is_zero() && polished.pdf(&AT, Vec3::Z, Vec3::Z) == 0.0);
}

#[test]
fn reflectance_in_place_of_an_index_is_met_at_normal_incidence() {
    let half = build("conductor", &[float("reflectance", 0.5)]);
    let s = half.sample(&AT, Vec3::Z, 0.5, Vec2::splat(0.5)).expect("metal reflects");
    assert!((s.weight[0] - 0.5).abs() < 1e-6);
}

#[test]
fn mirror_reflects_all_or_what_it_is_told() {
    for (reflectance, share) in [(None, 1.0), (Some(0.3), 0.3)] {
        let mirror = build("mirror", &reflectance.map(|r| float("reflectance", r)).into_iter().collect::<Vec<_>>());
        for z in [0.9, 0.1, -0.4] {
            let wo = direction(z, 1.0);
            let s = mirror.sample(&AT, wo, 0.5, Vec2::splat(0.5)).expect("a mirror reflects");
            assert!(s.specular && s.wi == Vec3::new(-wo.x, -wo.y, wo.z));
            assert!(s.weight == SampledSpectrum::splat(share as f32) && mirror.is_specular());
        }
    }
}

#[test]
fn glass_divides_light_without_loss() {
    let glass = build("dielectric", &[float("eta", 1.5)]);
    for z in [1.0, 0.8, 0.5, 0.1, -1.0, -0.9, -0.8, -0.7, -0.3] {
        let wo = direction(z, 2.0);
        let eta = if z > 0.0 { 1.5f64 } else { 1.0 / 1.5 };
        let exact = by_amplitudes(z.abs(), eta, 0.0);
        let n = 10_000;
        let (mut reflected, mut power) = (0.0, 0.0);
        for k in 0..n {
            let choice = (k as f32 + 0.5) / n as f32;
            let s = glass.sample(&AT, wo, choice, Vec2::splat(0.5)).expect("glass absorbs nothing");
            assert!(s.specular && (s.wi.length() - 1.0).abs() < 1e-6);
            let weight = f64::from(s.weight[0]);
            if s.wi.z * wo.z > 0.0 {
                assert_eq!((s.wi, weight), (Vec3::new(-wo.x, -wo.y, wo.z), 1.0));
                reflected += 1.0;
                power += weight;
            } else {
                // Snell's law, and radiance over the squared index is what a refraction keeps.
                assert!((f64::from(s.wi.x) * eta + f64::from(wo.x)).abs() < 1e-6);
                assert!((f64::from(s.wi.y) * eta + f64::from(wo.y)).abs() < 1e-6);
                assert!((weight * eta * eta - 1.0).abs() < 1e-5);
                power += weight * eta * eta;
            }
        }
        assert!((reflected / f64::from(n) - exact).abs() < 2e-4, "{z}: {reflected} {exact}");
        assert!((power / f64::from(n) - 1.0).abs() < 1e-5);
    }
}

#[test]
fn through_a_pane_radiance_is_unchanged() {
    let glass = build("dielectric", &[float("eta", 1.7)]);
    for z in [0.99, 0.5, 0.05] {
        let wo = direction(z, 0.4);
        let first = glass.sample(&AT, wo, 0.999_999, Vec2::splat(0.5)).expect("refracted");
        // The far side's normal points away from the pane, so in its frame the ray inside comes from z < 0.
        let turn = |w: Vec3| Vec3::new(w.x, -w.y, -w.z);
        let second = glass.sample(&AT, turn(-first.wi), 0.999_999, Vec2::splat(0.5)).expect("refracted");
        assert!((turn(second.wi) + wo).length() < 1e-5, "{:?} {wo}", second.wi);
        assert!((first.weight[0] - 1.0 / (1.7 * 1.7)).abs() < 1e-6);
        assert!((first.weight[0] * second.weight[0] - 1.0).abs() < 1e-6);
    }
}

#[test]
fn reflectance_of_smooth_surfaces_is_the_mean_of_their_samples() {
    let metal = build("conductor", &[named("eta", "metal-Au-eta"), named("k", "metal-Au-k")]);
    let glasses = [build("dielectric", &[float("eta", 1.7)]), build("dielectric", &[named("eta", "glass-SF11")])];
    for material in glasses.iter().chain([&metal]) {
        for wo in outgoing() {
            let n = 100_000;
            // Of the first wavelength: where glass disperses, a sample that is refracted is of that one alone.
            let mean = (0..n).filter_map(|i| material.sample(&AT, wo, (i as f32 + 0.5) / n as f32, Vec2::splat(0.5)));
            let mean = mean.map(|s| f64::from(s.weight[0])).sum::<f64>() / f64::from(n);
            let found = f64::from(material.reflectance(&AT, wo)[0]);
            assert!((found - mean).abs() < 1e-4 * mean.max(1.0), "{wo}: {found} {mean}");
        }
    }
}
