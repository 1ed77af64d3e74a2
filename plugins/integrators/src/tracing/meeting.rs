//! Where a curve meets a surface that a chord of it meets, in full precision.

use crate::tracing::arc::Arc;
use bhs_core::geometry::{Analytic, Segment};
use glam::{DVec2, DVec3};

/// A curve on a surface.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// The curve's parameter there.
    pub parameter: f64,
    /// The point of the surface.
    pub point: DVec3,
    /// Weights of the facet's second and third corner; zero on an analytic surface.
    pub barycentric: DVec2,
    /// Distance from the curve to the point: how far beside the facet the curve meets its plane.
    pub beside: f64,
}

/// Corrections at most.
const CORRECTIONS: u32 = 60;

/// Corrections of where a curve meets a facet, if the hit is as most are.
pub(crate) const CORRECTIONS_OF_PLAIN_HITS: u32 = 4;

/// A correction is the last one if it is smaller than this share of the chord: what is left is of the third order in it.
pub(crate) const SMALL: f64 = 1e-4;

/// The same of a method of second order.
const SMALLER: f64 = 1e-8;

/// The nearest point of the triangle `corners` with the normal `n`, of any length, to the point `point` of its plane, and its weights of the second
/// and third corner.
fn nearest([a, b, c]: [DVec3; 3], n: DVec3, point: DVec3) -> (DVec3, DVec2) {
    let (ab, ac, p) = (b - a, c - a, point - a);
    let per_nn = 1.0 / n.length_squared();
    let v = (n.dot(p.cross(ac)) * per_nn).clamp(0.0, 1.0);
    let w = (n.dot(ab.cross(p)) * per_nn).clamp(0.0, 1.0 - v);
    (a + ab * v + ac * w, DVec2::new(v, w))
}

/// Where a curve meets the plane of the facet `corners` that its chord between the parameters `ends` crosses, near `guess`; and the nearest point
/// of the facet.
///
/// If both ends of the curve lie on different sides of the plane, Halley's method, kept between them by bisection, finds the root. If they
/// do not, the hit is just beyond an end, where chords overlap, or beside the start of a ray; then Halley's method alone goes there, or fails.
pub fn on_facet<A: Arc<f64>>(arc: &A, ends: [f64; 2], guess: f64, corners: [DVec3; 3]) -> Option<Meeting> {
    let a = corners[0];
    let n = (corners[1] - a).cross(corners[2] - a);
    let [mut lo, mut hi] = ends;
    let width = hi - lo;
    let plane = arc.plane(n.into(), a.into());
    let height = |s: f64| arc.height(&plane, s)[0];
    let [from, to] = ends.map(height);
    let bracketed = (from < 0.0) != (to < 0.0);
    let nearest_end = if from.abs() < to.abs() { lo } else { hi };
    let beyond = if bracketed { 0.0 } else { 0.5 * width };
    let mut s = guess.clamp(lo, hi);
    for _ in 0..CORRECTIONS {
        let [value, slope, second] = arc.height(&plane, s);
        if bracketed && (value < 0.0) == (from < 0.0) {
            lo = s;
        } else if bracketed {
            hi = s;
        }
        let change = -(value * slope) / (slope * slope - 0.5 * value * second);
        let better = s + change;
        if better > lo - beyond && better < hi + beyond {
            s = better;
            if change.abs() <= SMALL * width {
                break;
            }
        } else if bracketed {
            s = 0.5 * (lo + hi);
        } else {
            s = nearest_end;
            break;
        }
    }
    let met = DVec3::from(arc.point(s));
    let (point, barycentric) = nearest(corners, n, met);
    let beside = (point - met).length();
    beside.is_finite().then_some(Meeting { parameter: s, point, barycentric, beside })
}

/// Where a curve meets an analytic surface near its point at the parameter `guess`, at most `far` along its tangent from there, if that lies between
/// the parameters `ends` or a little beyond: Newton's method, by the surface's intersection with the tangent. `None` if that misses.
pub fn on_surface<A: Arc<f64>>(
    arc: &A,
    ends: [f64; 2],
    guess: f64,
    surface: &dyn Analytic,
    near: f64,
    far: f64,
) -> Option<Meeting> {
    let slack = 0.5 * (ends[1] - ends[0]);
    let mut s = guess;
    let mut half = near;
    for _ in 0..20 {
        let (middle, tangent) = arc.point_and_tangent(s);
        let (middle, tangent) = (DVec3::from(middle), DVec3::from(tangent));
        let speed = tangent.length();
        let direction = tangent / speed;
        // The tangent from `half` before the place to as far behind it: no farther than need be, for the surface may
        // have another side.
        let ahead = loop {
            let piece = Segment { origin: middle - direction * half, direction, t_min: 0.0, t_max: 2.0 * half };
            if let Some(t) = surface.intersect(&piece) {
                break t - half;
            }
            half *= 8.0;
            if half.is_nan() || half > far {
                return None;
            }
        };
        s += ahead / speed;
        if !(s >= ends[0] - slack && s <= ends[1] + slack) {
            return None;
        }
        if ahead.abs() <= SMALLER * far {
            return Some(Meeting { parameter: s, point: middle + direction * ahead, barycentric: DVec2::ZERO, beside: 0.0 });
        }
        half = 4.0 * ahead.abs();
    }
    None
}
