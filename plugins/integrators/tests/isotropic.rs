//! Orbits against a tracer of graded-index media, which knows nothing of them.
//!
//! In isotropic radius, `r = rho (1 + rs/(4 rho))^2`, light goes as through glass of the index
//! `n = (1 + rs/(4 rho))^3 / (1 - rs/(4 rho))`, along straight Cartesian axes: `d/ds (n dx/ds) = grad n`. The map from areal to isotropic
//! coordinates keeps angles as static observers measure them.

mod common;

use bhs_core::ray::{Arrival, Ray};
use bhs_engine::integrator::Integrator;
use bhs_integrators::Tolerance;
use bhs_integrators::{Adaptive, Exact, Rk4};
use common::{Dice, ball, world};
use glam::DVec3;

/// Isotropic radius of the areal radius r, rs = 1.
fn isotropic(r: f64) -> f64 {
    0.5 * (r - 0.5 + (r * r - r).sqrt())
}

/// Refractive index, and its derivative by the isotropic radius, rs = 1.
fn index(rho: f64) -> (f64, f64) {
    let q = 0.25 / rho;
    let n = (1.0 + q).powi(3) / (1.0 - q);
    (n, -n * (3.0 / (1.0 + q) + 1.0 / (1.0 - q)) * q / rho)
}

/// Follows the ray from `x` in the direction `t` outwards to the isotropic radius `end`: point and direction there; or `None` if it
/// comes within 1.01 rs of the hole. With `dtau = ds/n` the equation is `x'' = grad(n^2)/2`; Runge and Kutta's method of order 4.
fn follow(x: DVec3, t: DVec3, end: f64) -> Option<(DVec3, DVec3)> {
    let force = |x: DVec3| {
        let rho = x.length();
        let (n, slope) = index(rho);
        x * (n * slope / rho)
    };
    let step = |x: DVec3, p: DVec3, h: f64| {
        let (k1, l1) = (p, force(x));
        let (k2, l2) = (p + l1 * (0.5 * h), force(x + k1 * (0.5 * h)));
        let (k3, l3) = (p + l2 * (0.5 * h), force(x + k2 * (0.5 * h)));
        let (k4, l4) = (p + l3 * h, force(x + k3 * h));
        (x + (k1 + k2 * 2.0 + k3 * 2.0 + k4) * (h / 6.0), p + (l1 + l2 * 2.0 + l3 * 2.0 + l4) * (h / 6.0))
    };
    let (mut x, mut p) = (x, t * index(x.length()).0);
    loop {
        let rho = x.length();
        // A two-thousandth of the distance from the hole, in arc length.
        let h = 5e-4 * rho / index(rho).0;
        let (next, next_p) = step(x, p, h);
        if next.length() > end {
            let (mut lo, mut hi) = (0.0, h);
            for _ in 0..60 {
                let middle = 0.5 * (lo + hi);
                if step(x, p, middle).0.length() > end { hi = middle } else { lo = middle }
            }
            let (x, p) = step(x, p, hi);
            return Some((x, p.normalize()));
        }
        (x, p) = (next, next_p);
        if x.length() < isotropic(1.01) {
            return None;
        }
    }
}

/// A direction with its radial part (along `e`) multiplied by `factor`.
fn stretched(d: DVec3, e: DVec3, factor: f64) -> DVec3 {
    (d + e * (d.dot(e) * (factor - 1.0))).normalize()
}

#[test]
fn orbits_are_the_rays_of_a_graded_index() {
    let around = 12.0;
    let shell = world(vec![ball(DVec3::ZERO, around)], DVec3::ZERO, 1.0);
    let b_crit = 1.5 * 3f64.sqrt();
    // Each with how far it may be from the truth (chart distance, rs = 1): two roundings short of nothing, its tolerance, its order.
    let tracers: [(&dyn Integrator, f64, &str); 3] = [
        (&Exact::new(Tolerance::Absolute(1e-3), 10_000), 1e-9, "exact"),
        (&Adaptive::new(Tolerance::Absolute(1e-6), 10_000), 1e-6, "adaptive"),
        (&Rk4::new(0.01, 1_000_000), 1e-6, "rk4"),
    ];
    let mut dice = Dice(7);
    let (mut worst, mut captured) = ([0.0f64; 3], 0);
    for case in 0..120 {
        let r = dice.within(1.1, 11.5);
        let e = dice.direction();
        let mut local = dice.direction();
        if case % 3 == 0 && r > 1.6 {
            // Inwards, and within some 1e-1 to 1e-4 of the critical impact parameter.
            let off = 10f64.powf(dice.within(-4.0, -1.0)) * if case % 2 == 0 { 1.0 } else { -1.0 };
            let sin = (b_crit * (1.0 + off) * (1.0 - 1.0 / r).sqrt() / r).min(1.0);
            local = e.any_orthonormal_vector() * sin - e * (1.0 - sin * sin).sqrt();
        }
        let truth = follow(e * isotropic(r), local, isotropic(around));
        // Local lengths along the radius are those of the chart times 1/sqrt(f).
        let ray = Ray::new(e * r, stretched(local, e, (1.0 - 1.0 / r).sqrt()));
        // Errors at the start grow by e per radian near the photon sphere: by 1/|b/b_crit - 1| in all.
        let sin = local.cross(e).length();
        let grown = 1.0 / (r * sin / (1.0 - 1.0 / r).sqrt() / b_crit - 1.0).abs().clamp(1e-6, 1.0);
        for (i, (tracer, tolerance, name)) in tracers.iter().enumerate() {
            match (tracer.trace(&shell, &ray).arrival, truth) {
                (Arrival::Surface(hit), Some((x, t))) => {
                    let point = x.normalize() * around;
                    let sqrt_f = (1.0 - 1.0 / around).sqrt();
                    let off = (hit.point - point).length();
                    let turned = (stretched(hit.direction, x.normalize(), 1.0 / sqrt_f) - t).length();
                    assert!(off < tolerance * grown.max(10.0), "{name} case {case}: {off:.1e}, {grown:.1e}");
                    assert!(turned < tolerance * grown.max(10.0), "{name} case {case}: turned by {turned:.1e}, {grown:.1e}");
                    worst[i] = worst[i].max(off / grown / tolerance);
                }
                (Arrival::Captured, None) => captured += 1,
                (found, truth) => panic!("{name} case {case}: {found:?}, but {truth:?}"),
            }
        }
    }
    eprintln!("worst distances, over their growth and tolerance: {worst:.5?}; captured {captured}");
    assert!(captured > 30);
}
