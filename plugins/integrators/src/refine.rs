//! Where an orbit meets a surface that its chord meets, in full precision. Knows no differential equation.

use crate::chords::Place;
use crate::orbit::{Dense, OrbitPlane, Polar};
use bhs_core::geometry::{Analytic, Segment};
use glam::{DVec2, DVec3};

/// An orbit on a surface.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// The orbit's state there.
    pub orbit: Polar,
    /// The point of the surface.
    pub point: DVec3,
    /// Weights of the facet's second and third corner; zero on an analytic surface.
    pub barycentric: DVec2,
    /// Distance from the orbit to the point: how far beside the facet the orbit meets its plane.
    pub beside: f64,
}

/// A triangle with its normal, not of unit length.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    corners: [DVec3; 3],
    /// `(b - a) x (c - a)`.
    pub normal: DVec3,
}

impl Facet {
    /// The triangle with these corners.
    #[inline]
    pub fn new(corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        Self { corners, normal: (b - a).cross(c - a) }
    }

    /// The nearest point of the triangle to a point of its plane, and its weights of the second and third corner.
    #[inline]
    fn nearest(&self, point: DVec3) -> (DVec3, DVec2) {
        let [a, b, c] = self.corners;
        let (n, ab, ac, p) = (self.normal, b - a, c - a, point - a);
        let per_nn = 1.0 / n.length_squared();
        let v = (n.dot(p.cross(ac)) * per_nn).clamp(0.0, 1.0);
        let w = (n.dot(ab.cross(p)) * per_nn).clamp(0.0, 1.0 - v);
        (a + ab * v + ac * w, DVec2::new(v, w))
    }
}

/// A correction by Halley's method, whose error is of the third order, is the last one if it is smaller than this share of the chord.
pub(crate) const SMALL: f64 = 1e-4;

/// Where an orbit around a hole of radius `rs` meets the plane of a facet that the chord between the places `ends` crosses: the root of
/// `n.e_r(phi) - u(phi) n.(a - center)`, u times the distance from the plane, near `guess`; and the nearest point of the facet.
///
/// The two ends of a chord that crosses a plane lie on both sides of it, and so there is a root between them: Halley's method (the second
/// derivative comes for nothing, by the orbit's equation), kept between them by bisection, finds it. (At the start of a ray that leaves the
/// plane itself the function is small but not zero, since rays begin off their surface: the root found is the one where the
/// orbit comes back.) If both ends lie on one side, the hit is just beyond an end, where chords overlap, and Halley's method alone
/// goes there.
pub fn on_facet<D: Dense>(plane: &OrbitPlane, step: &D, rs: f64, ends: [&Place; 2], guess: f64, facet: &Facet) -> Meeting {
    let (n, a) = (facet.normal, facet.corners[0]);
    let [mut lo, mut hi] = ends.map(|p| p.phi);
    let [from, to] = ends.map(|p| n.dot(p.point - a));
    let bracketed = (from < 0.0) != (to < 0.0);
    let (n1, n2, d) = (n.dot(plane.e1), n.dot(plane.e2), n.dot(a - plane.center));
    let (nearest, small) = (if from.abs() < to.abs() { lo } else { hi }, SMALL * (hi - lo));
    let beyond = if bracketed { 0.0 } else { 0.5 * (hi - lo) };
    let mut orbit = step.polar(guess);
    for _ in 0..60 {
        let Polar { state, cos, sin } = orbit;
        let value = n1 * cos + n2 * sin - d * state.u;
        let slope = n2 * cos - n1 * sin - d * state.du;
        let curvature = -(value + 1.5 * rs * d * state.u * state.u);
        if bracketed && (value < 0.0) == (from < 0.0) {
            lo = state.phi;
        } else if bracketed {
            hi = state.phi;
        }
        let change = -value * slope / (slope * slope - 0.5 * value * curvature);
        let better = state.phi + change;
        if better > lo - beyond && better < hi + beyond {
            if change.abs() <= small {
                orbit = orbit.moved(rs, change);
                break;
            }
            orbit = step.polar(better);
        } else if bracketed {
            orbit = step.polar(0.5 * (lo + hi));
        } else {
            orbit = step.polar(nearest);
            break;
        }
    }

    let met = plane.point_of(&orbit);
    let (point, barycentric) = facet.nearest(met);
    Meeting { orbit, point, barycentric, beside: (point - met).length() }
}

/// Where an orbit meets an analytic surface near its place at the angle `guess`, at most `far` along its tangent from there:
/// Newton's method, by the surface's intersection with the tangent. `None` if that misses.
pub fn on_surface<D: Dense>(
    plane: &OrbitPlane,
    step: &D,
    guess: f64,
    surface: &dyn Analytic,
    near: f64,
    far: f64,
) -> Option<Meeting> {
    let mut orbit = step.polar(guess);
    let mut half = near;
    for _ in 0..20 {
        let (middle, direction) = (plane.point_of(&orbit), plane.direction_of(&orbit));
        let state = orbit.state;
        // The tangent from `half` before the place to as far behind it: no farther than need be, for the surface may
        // have another side.
        let ahead = loop {
            let tangent = Segment { origin: middle - direction * half, direction, t_min: 0.0, t_max: 2.0 * half };
            if let Some(t) = surface.intersect(&tangent) {
                break t - half;
            }
            half *= 8.0;
            if half > far {
                return None;
            }
        };
        let point = middle + direction * ahead;
        // d phi/d s = u sin(alpha)
        let sin = state.u / (state.u * state.u + state.du * state.du).sqrt();
        orbit = step.polar(state.phi + ahead * state.u * sin);
        // What is left is of second order in the last correction.
        if ahead.abs() * state.u <= 1e-9 {
            return Some(Meeting { orbit, point, barycentric: DVec2::ZERO, beside: 0.0 });
        }
        half = 4.0 * ahead.abs();
    }
    None
}
