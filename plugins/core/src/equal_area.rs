//! The octahedral map of equal solid angles, between the sphere and the unit square: skies, cameras and lights share it.

use bhs_elementary::Elementary;
use glam::{DVec2, DVec3, Vec2Swizzles};
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// A direction (z up) of a point of the unit square, by which equal areas are equal solid angles (Clarberg 2008, "Fast Equal-Area Mapping
/// of the (Hemi)Sphere using SIMD"); outside of the square the map goes on over its edges.
#[must_use]
pub fn equal_area_direction(mut p: DVec2) -> DVec3 {
    // Over an edge, one comes back half way along it.
    if !(0.0..=1.0).contains(&p.x) {
        p = DVec2::new(if p.x < 0.0 { -p.x } else { 2.0 - p.x }, 1.0 - p.y);
    }
    if !(0.0..=1.0).contains(&p.y) {
        p = DVec2::new(1.0 - p.x, if p.y < 0.0 { -p.y } else { 2.0 - p.y });
    }
    let uv = 2.0 * p - 1.0;
    let a = uv.abs();
    // Distance from the diagonal between the hemispheres; radius on the disk.
    let signed = 1.0 - (a.x + a.y);
    let r = 1.0 - signed.abs();
    let phi = if r == 0.0 { FRAC_PI_4 } else { ((a.y - a.x) / r + 1.0) * FRAC_PI_4 };
    let sin_theta = r * (2.0 - r * r).max(0.0).sqrt();
    let z = (1.0 - r * r).copysign(signed);
    DVec3::new(phi.cosine().copysign(uv.x) * sin_theta, phi.sine().copysign(uv.y) * sin_theta, z)
}

/// The point of the unit square whose [`equal_area_direction`] is the unit vector `d`.
#[must_use]
pub fn equal_area_point(d: DVec3) -> DVec2 {
    let r = (1.0 - d.z.abs()).max(0.0).sqrt();
    let phi = d.y.abs().arctangent2(d.x.abs()) / FRAC_PI_2;
    let upper = DVec2::new(r - r * phi, r * phi);
    let p = if d.z < 0.0 { 1.0 - upper.yx() } else { upper };
    0.5 * (p.copysign(d.truncate()) + 1.0)
}
