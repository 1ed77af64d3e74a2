//! Where an orbit meets a surface that its chord meets, in full precision. Knows no differential equation.

use crate::chords::Place;
use crate::orbit::{Dense, OrbitPlane, State};
use bhs_core::geometry::{Analytic, Segment};
use glam::{DVec2, DVec3};

/// An orbit on a surface.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// The orbit's state there.
    pub state: State,
    /// The point of the surface.
    pub point: DVec3,
    /// Weights of the facet's second and third corner; zero on an analytic surface.
    pub barycentric: DVec2,
    /// Distance from the orbit to the point: how far beside the facet the orbit meets its plane.
    pub beside: f64,
}

/// Where an orbit meets the plane of a facet that the chord between the places `ends` crosses: the root of
/// `n.e_r(phi) - u(phi) n.(a - center)`, u times the distance from the plane, near `guess`; and the nearest point of the facet.
///
/// The two ends of a chord that crosses a plane lie on both sides of it, and so there is a root between them: Newton's
/// method, kept between them by bisection, finds it. (At the start of a ray that leaves the plane itself the function is
/// small but not zero, since rays begin off their surface: the root found is the one where the orbit comes back.) If both
/// ends lie on one side, the hit is just beyond an end, where chords overlap, and Newton's method alone goes there.
pub fn on_facet<D: Dense>(plane: &OrbitPlane, step: &D, ends: [&Place; 2], guess: f64, corners: [DVec3; 3]) -> Meeting {
    let [a, b, c] = corners;
    let (ab, ac) = (b - a, c - a);
    let n = ab.cross(ac);
    let [mut lo, mut hi] = ends.map(|p| p.phi);
    let [from, to] = ends.map(|p| n.dot(p.point - a));
    let bracketed = (from < 0.0) != (to < 0.0);
    let (n1, n2, d) = (n.dot(plane.e1), n.dot(plane.e2), n.dot(a - plane.center));
    let (nearest, small) = (if from.abs() < to.abs() { lo } else { hi }, 1e-8 * (hi - lo));
    let beyond = if bracketed { 0.0 } else { 0.5 * (hi - lo) };
    let mut state = step.at(guess);
    for _ in 0..60 {
        let (sin, cos) = state.phi.sin_cos();
        let value = n1 * cos + n2 * sin - d * state.u;
        let slope = n2 * cos - n1 * sin - d * state.du;
        if bracketed && (value < 0.0) == (from < 0.0) {
            lo = state.phi;
        } else if bracketed {
            hi = state.phi;
        }
        let newton = state.phi - value / slope;
        if newton > lo - beyond && newton < hi + beyond {
            let change = (newton - state.phi).abs();
            state = step.at(newton);
            // What is left is of second order in the last correction.
            if change <= small {
                break;
            }
        } else if bracketed {
            state = step.at(0.5 * (lo + hi));
        } else {
            state = step.at(nearest);
            break;
        }
    }

    let met = plane.point(&state);
    let nn = n.length_squared();
    let p = met - a;
    let v = (n.dot(p.cross(ac)) / nn).clamp(0.0, 1.0);
    let w = (n.dot(ab.cross(p)) / nn).clamp(0.0, 1.0 - v);
    let point = a + ab * v + ac * w;
    Meeting { state, point, barycentric: DVec2::new(v, w), beside: (point - met).length() }
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
    let mut state = step.at(guess);
    let mut half = near;
    for _ in 0..20 {
        let (middle, direction) = (plane.point(&state), plane.direction(&state));
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
        state = step.at(state.phi + ahead * state.u * sin);
        // What is left is of second order in the last correction.
        if ahead.abs() * state.u <= 1e-9 {
            return Some(Meeting { state, point, barycentric: DVec2::ZERO, beside: 0.0 });
        }
        half = 4.0 * ahead.abs();
    }
    None
}
