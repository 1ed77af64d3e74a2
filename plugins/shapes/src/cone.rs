//! Points of the unit sphere that an eye outside of it sees, even in the cone of directions in which it sees them.
//!
//! Shirley, Wang and Zimmerman 1996, Monte Carlo techniques for direct lighting calculations; Pharr, Jakob and Humphreys 2023, Physically Based
//! Rendering, section 6.2.4; docs/physics.md, section 10. With the distance d of the eye from the middle, the half angle of the cone has the sine 1/d. All is
//! written in `h = 1 - cos(half angle) = d^-2/(1 + sqrt(1 - d^-2))`, in which nothing cancels, so that a sphere far away needs no series.

use bhs_elementary::Elementary;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Least distance of the eye from the sphere (radii), known to seven digits then. Nearer ones see hardly more than one point of it, which rounding moves.
const LEAST_GAP: f64 = 1e-9;

/// The cone in which an eye sees the unit sphere around 0.
pub(crate) struct Cone {
    eye: DVec3,
    /// Of the eye from the middle of the sphere.
    distance: f64,
    /// One less the cosine of half the angle at the eye.
    h: f64,
}

impl Cone {
    /// That of `eye`; `None` on the sphere and inside of it, where the sphere is seen all around, and too far away for numbers.
    pub(crate) fn new(eye: DVec3) -> Option<Self> {
        let distance = eye.length();
        let sine = 1.0 / distance;
        let h = sine * sine / (1.0 + ((1.0 - sine) * (1.0 + sine)).max(0.0).sqrt());
        (distance > 1.0 + LEAST_GAP && h.is_normal()).then_some(Self { eye, distance, h })
    }

    /// The point that the eye sees in the direction that two numbers in [0,1) stand for, with its density by area.
    pub(crate) fn sample(&self, u: DVec2) -> (DVec3, f64) {
        let Self { eye, distance, h } = *self;
        // The angle theta from the middle of the cone has 1 - cos(theta) = u h. In the triangle of the eye, the middle and the point its sine over that
        // of the whole half angle is the sine of the angle gamma between normal and view.
        let cos_theta = 1.0 - u.x * h;
        let sin_gamma = (u.x * (2.0 - u.x * h) / (2.0 - h)).sqrt();
        let cos_gamma = ((1.0 - u.x) * (2.0 - h * (1.0 + u.x)) / (2.0 - h)).max(0.0).sqrt();
        let sin_theta = sin_gamma / distance;
        // From the axis, as seen from the middle: gamma - theta.
        let cos_alpha = cos_gamma * cos_theta + sin_gamma * sin_theta;
        let sin_alpha = sin_gamma * cos_theta - cos_gamma * sin_theta;
        let axis = eye / distance;
        let (s, t) = axis.any_orthonormal_pair();
        let (sin, cos) = (TAU * u.y).sine_cosine();
        let point = axis * cos_alpha + (s * cos + t * sin) * sin_alpha;
        let way = distance * cos_theta - cos_gamma;
        (point, self.by_area(cos_gamma, way * way))
    }

    /// The density by area with which [`Cone::sample`] draws `point`; 0 where the eye does not see it.
    pub(crate) fn density(&self, point: DVec3) -> f64 {
        let way = self.eye - point;
        let squared = way.length_squared();
        let cos_gamma = way.dot(point) / squared.sqrt();
        if cos_gamma > 0.0 { self.by_area(cos_gamma, squared) } else { 0.0 }
    }

    /// The density by area of what is seen at an angle to the normal of this cosine and at this squared distance: `cos_gamma` over `way_squared` is the solid
    /// angle of an area, and the cone has 2 pi h.
    fn by_area(&self, cos_gamma: f64, way_squared: f64) -> f64 {
        cos_gamma / (TAU * self.h * way_squared)
    }
}
