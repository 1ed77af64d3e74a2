//! A hole that spins, with or without charge, in the Boyer-Lindquist chart drawn as oblate spheroids (`docs/physics.md`, section 5).

use super::{Ball, Class, Fields, Inverse, Metric, Normal, Place, Side, Spacetime, Spherical, Stationary, Stretch};
use crate::dual::Dual;
use crate::real::{Real, Vector};
use glam::DVec3;
use std::sync::Arc;

/// A Kerr-Newman hole (`docs/physics.md`, section 5).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kerr {
    /// Centre, mass and charge.
    round: Spherical,
    /// Unit vector.
    axis: DVec3,
    /// Angular momentum over mass (scene units): space is dragged along `a axis x x`.
    a: f64,
    /// Radius of the innermost orbit of light, within which light that moves inwards is captured.
    capture: f64,
}

/// What the metric is made of at a point, in one number or several: lengths in scene units, vectors along the axes of the chart.
#[derive(Clone, Copy, Debug)]
pub struct Oblate<F> {
    /// Boyer and Lindquist's radius.
    pub r: F,
    /// `r^2 + a^2`
    pub square: F,
    /// `S = r^2 + a^2 cos^2 theta`
    pub sigma: F,
    /// `2 M r - q^2`
    pub m: F,
    /// Cosine of theta.
    pub cos: F,
    /// What of the unit vector `n` of the angles theta and phi lies across the axis, of length sin theta.
    pub across: Vector<F>,
    /// Unit normal of the ellipsoid of equal radius.
    pub e_r: Vector<F>,
    /// `axis x n`, of length sin theta.
    pub w: Vector<F>,
}

impl Kerr {
    /// The hole with this mass, charge and centre that spins about the unit vector `axis` with `a = spin M`; `spin^2` and the square of the
    /// charge's share are together at most 1, the mass is above 0.
    pub fn new(round: Spherical, axis: DVec3, spin: f64) -> Self {
        let mut kerr = Self { round, axis, a: 0.5 * round.rs * spin, capture: 0.0 };
        kerr.capture = kerr.innermost_light_orbit();
        kerr
    }

    /// Mass and charge, at the centre.
    pub fn round(&self) -> Spherical {
        self.round
    }

    /// Unit vector along the axis.
    pub fn axis(&self) -> DVec3 {
        self.axis
    }

    /// Angular momentum over mass (scene units).
    pub fn a(&self) -> f64 {
        self.a
    }

    /// Boyer and Lindquist's radius of the outer horizon (scene units): half the short axis of its ellipsoid.
    pub fn horizon(&self) -> f64 {
        let m = 0.5 * self.round.rs;
        m + (m * m - self.a * self.a - self.round.charge_squared).max(0.0).sqrt()
    }

    /// Boyer and Lindquist's radius at the point `x` (scene units).
    pub fn radius(&self, x: DVec3) -> f64 {
        self.oblate::<f64>(x.into()).r
    }

    /// Radius of the circular orbit of light that moves with the spin: `r^2 - 3 M r + 2 q^2 + 2 |a| sqrt(M r - q^2) = 0`, the largest root.
    fn innermost_light_orbit(&self) -> f64 {
        let (m, q2, a) = (0.5 * self.round.rs, self.round.charge_squared, self.a.abs());
        let f = |r: f64| r * r - 3.0 * m * r + 2.0 * q2 + 2.0 * a * (m * r - q2).max(0.0).sqrt();
        // Without spin the orbit is the upper end; the polynomial is not above 0 on the horizon.
        let (mut low, mut high) = (self.horizon(), 0.5 * (3.0 * m + (9.0 * m * m - 8.0 * q2).max(0.0).sqrt()));
        for _ in 0..100 {
            let r = 0.5 * (low + high);
            if f(r) <= 0.0 {
                low = r;
            } else {
                high = r;
            }
        }
        low
    }

    /// What the metric is made of at `x` (scene units).
    #[inline(always)]
    pub fn oblate<F: Real>(&self, x: Vector<F>) -> Oblate<F> {
        let x = x - Vector::all(self.round.center);
        let axis = Vector::all(self.axis);
        let (a2, half) = (F::splat(self.a * self.a), F::splat(0.5));
        let z = axis.dot(x);
        let az2 = a2 * z * z;
        let c = x.length_squared() - a2;
        let s = (c * c + F::splat(4.0) * az2).sqrt();
        let r2 = F::select(c.gt(F::splat(0.0)), half * (c + s), F::splat(2.0) * az2 / (s - c));
        let r = r2.sqrt();
        let square = r2 + a2;
        let root = square.sqrt();
        let (across, cos) = ((x - axis * z) * (F::splat(1.0) / root), z / r);
        let sigma = r2 + a2 * cos * cos;
        let e_r = (across * r + axis * (root * cos)) * (F::splat(1.0) / sigma.sqrt());
        let m = F::splat(self.round.rs) * r - F::splat(self.round.charge_squared);
        Oblate { r, square, sigma, m, cos, across, e_r, w: axis.cross(across) }
    }
}

impl Spacetime for Kerr {
    fn at(&self, place: Place) -> Option<Stationary> {
        let Oblate { r, square, sigma, m, e_r, w, .. } = self.oblate::<f64>(place.x.into());
        let lapse_squared = (sigma - m) / sigma;
        let outside = place.side == Side::Near && r > self.horizon() && square > m && lapse_squared > 0.0;
        if !outside || !lapse_squared.is_finite() {
            return None;
        }
        let (e_r, w) = (DVec3::from(e_r), DVec3::from(w));
        let radial = (square / (square - m)).sqrt();
        let around = (1.0 + m * self.a * self.a * w.length_squared() / (square * (sigma - m))).sqrt();
        // On the axis the factor is 1 and any direction will do.
        let beside = w.try_normalize().unwrap_or_else(|| e_r.any_orthonormal_vector());
        let root = Stretch::along_two([e_r, beside], [radial, around]);
        let beta = w * (m * self.a / (square.sqrt() * (sigma - m)));
        (radial.is_finite() && around.is_finite()).then_some(Stationary { lapse: lapse_squared.sqrt(), root, beta })
    }

    fn normal(&self, place: Place) -> Option<Normal> {
        let Oblate { r, square, sigma, m, e_r, w, .. } = self.oblate::<f64>(place.x.into());
        let outside = place.side == Side::Near && r > self.horizon() && square > m && r.is_finite();
        if !outside {
            return None;
        }
        let (e_r, w) = (DVec3::from(e_r), DVec3::from(w));
        let around = m * self.a * self.a * w.length_squared();
        let beside = w.try_normalize().unwrap_or_else(|| e_r.any_orthonormal_vector());
        let factors = [(square / (square - m)).sqrt(), (1.0 + around / (square * sigma)).sqrt()];
        let whole = sigma * square + around;
        let lapse = (sigma * (square - m) / whole).sqrt();
        let root = Stretch::along_two([e_r, beside], factors);
        factors[0].is_finite().then(|| Normal { lapse, root, drag: w * (m * self.a * square.sqrt() / whole) })
    }

    /// The largest ball within the horizon, which is an ellipsoid: light that comes from outside is followed by [`Metric::swallows`].
    fn captures(&self) -> Vec<Ball> {
        vec![Ball { center: self.round.center, radius: self.horizon() }]
    }

    fn class(&self) -> Class<'_> {
        Class::Kerr(*self)
    }

    fn metric(&self) -> &dyn Metric {
        self
    }

    fn reversed(&self) -> Option<Arc<dyn Spacetime>> {
        Some(Arc::new(Self { a: -self.a, ..*self }))
    }

    fn moved(&self, origin: DVec3) -> Arc<dyn Spacetime> {
        Arc::new(Self { round: Spherical { center: self.round.center - origin, ..self.round }, ..*self })
    }
}

impl Metric for Kerr {
    fn fields(&self, x: [Dual; 3]) -> Fields {
        let Oblate { square, sigma, m, e_r, w, .. } = self.oblate(variables(x));
        let over = (sigma - m).recip();
        let gamma = one_and([(m / (square - m), e_r), (m * (self.a * self.a) / square * over, w)]);
        let twist = m * self.a / square.sqrt() * over;
        Fields { lapse_squared: (sigma - m) / sigma, gamma, beta: [w.x * twist, w.y * twist, w.z * twist] }
    }

    /// Regular in the ergosphere, up to the horizon.
    fn inverse(&self, x: [Dual; 3]) -> Inverse {
        let Oblate { square, sigma, m, e_r, w, .. } = self.oblate(variables(x));
        let over = (sigma * (square - m)).recip();
        let spread = m * (self.a * self.a) * over;
        let twist = -(m * self.a * square.sqrt() * over);
        Inverse {
            tt: -(square / (square - m)) - spread * w.length_squared(),
            t: [w.x * twist, w.y * twist, w.z * twist],
            space: one_and([(-(m / square), e_r), (-spread, w)]),
        }
    }

    fn swallows(&self, x: DVec3, d: DVec3) -> bool {
        let here = self.oblate::<f64>(x.into());
        here.r < self.capture && d.dot(here.e_r.into()) < 0.0
    }
}

/// Coordinates as a vector.
fn variables([x, y, z]: [Dual; 3]) -> Vector<Dual> {
    Vector { x, y, z }
}

/// The unit matrix and multiples of dyads: xx, yy, zz, yz, xz, xy.
fn one_and(terms: [(Dual, Vector<Dual>); 2]) -> [Dual; 6] {
    let one = Dual::constant(1.0);
    let mut sum = [one, one, one, Dual::constant(0.0), Dual::constant(0.0), Dual::constant(0.0)];
    for (factor, v) in terms {
        for (s, product) in sum.iter_mut().zip([v.x * v.x, v.y * v.y, v.z * v.z, v.y * v.z, v.x * v.z, v.x * v.y]) {
            *s += factor * product;
        }
    }
    sum
}
