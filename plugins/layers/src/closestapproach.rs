//! `closestapproach`: the smallest distance from the hole's centre on the way, as the areal radius: the periapsis if the ray has passed it, else
//! the nearer end; the horizon for a ray that falls in.
//!
//! ```bhs
//! Film "rgb" "string layers" "closestapproach"
//! WorldBegin
//! ```

use crate::orbit::{Bending, round_impact_parameter};
use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_core::ray::Arrival;
use bhs_core::spacetime::Spherical;
use bhs_elementary::Elementary;
use bhs_engine::layer::{Layer, LayerFormat, Value, VisibleSurface, scalar};
use glam::DVec3;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Layer> =
    Plugin { name: "closestapproach", summary: "smallest distance from the hole's centre on the way", build };

struct ClosestApproach;

fn build(_: &Params) -> Option<Box<dyn Layer>> {
    Some(Box::new(ClosestApproach))
}

impl Layer for ClosestApproach {
    fn format(&self) -> LayerFormat {
        LayerFormat::new(&["closestapproach"], "scene")
    }

    fn value(&self, seen: &VisibleSurface) -> Option<Value> {
        match Bending::of(seen) {
            Bending::Straight => Some(scalar(0.0)),
            Bending::Hole(hole) => closest_approach(seen, &hole).map(scalar),
            Bending::Spinning(_) | Bending::Otherwise => None,
        }
    }
}

fn closest_approach(seen: &VisibleSurface, hole: &Spherical) -> Option<f64> {
    let outward = |point: DVec3, direction: DVec3| (point - hole.center).dot(direction) > 0.0;
    let start = (seen.ray.origin - hole.center).length();
    let (end, leaves) = match seen.end.arrival {
        Arrival::Surface(h) => ((h.point - hole.center).length(), outward(h.point, h.direction)),
        Arrival::Sky(..) => (f64::INFINITY, true),
        Arrival::Captured => return Some(hole.horizon()),
        Arrival::OutOfSteps => return None,
    };
    if leaves && !outward(seen.ray.origin, seen.ray.direction) {
        return Some(periapsis(hole, round_impact_parameter(seen, hole)));
    }
    Some(start.min(end))
}

/// Corrections of a periapsis at most.
const CORRECTIONS: u32 = 100;

/// The smallest distance from the centre of light around `hole` with the impact parameter `b` that comes from far away and turns: the largest root of
/// `r^2 = b^2 f(r)`, or, where there is none for rounding near the critical one, where light goes round.
fn periapsis(hole: &Spherical, b: f64) -> f64 {
    let Spherical { rs, charge_squared, .. } = *hole;
    if charge_squared == 0.0 {
        // That of r^3 - b^2 r + b^2 rs (Viete).
        let critical = 1.5 * 3f64.sqrt() * rs;
        return 2.0 * b / 3f64.sqrt() * ((-critical / b).max(-1.0).arccosine() / 3.0).cosine();
    }
    // Newton's method from outside comes down to it.
    let mut r = b;
    for _ in 0..CORRECTIONS {
        let value = r * r * r * r - b * b * (r * (r - rs) + charge_squared);
        let change = value / (4.0 * r * r * r - b * b * (2.0 * r - rs));
        if change.is_nan() || change <= 1e-15 * r {
            break;
        }
        r -= change;
    }
    r.max(0.75 * rs + (0.5625 * rs * rs - 2.0 * charge_squared).max(0.0).sqrt())
}
