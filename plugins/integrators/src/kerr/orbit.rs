//! Light around a hole that spins: its constants, where it is, and what will become of it.
//!
//! In Mino's time light of energy 1 is an orbit in `u = 1/r`, times a top on the unit sphere, times a twist about the axis
//! (`docs/physics.md`, section 5). Here every length is measured in a length of the ray itself, `scale = sqrt(K + a^2 + M^2)`, and the
//! parameter `s` is Mino's time times that: it is about the angle that the ray sweeps, and u' is -1 far away.

use bhs_core::real::{Real, Vector};
use bhs_core::spacetime::{Kerr, Oblate};
use glam::DVec3;

/// A hole, axes around it, and the direction of time in which light is followed.
#[derive(Clone, Copy, Debug)]
pub struct Hole {
    /// The hole.
    pub kerr: Kerr,
    /// Unit vectors; the third is the axis of the spin, and the vector product of the first two.
    pub axes: [DVec3; 3],
    /// Angular momentum over mass that enters the equations (scene units): the opposite of the hole's where light is followed backward.
    pub a: f64,
}

impl Hole {
    /// The hole `kerr`, around which light is followed `backward` to where it comes from, or forward.
    pub fn new(kerr: &Kerr, backward: bool) -> Self {
        let axis = kerr.axis();
        let first = axis.any_orthonormal_vector();
        Self { kerr: *kerr, axes: [first, axis.cross(first), axis], a: if backward { -kerr.a() } else { kerr.a() } }
    }

    /// The components along the axes of the chart vectors `v`.
    #[inline(always)]
    pub fn components<F: Real>(&self, v: Vector<F>) -> Vector<F> {
        let [x, y, z] = self.axes.map(|axis| Vector::all(axis).dot(v));
        Vector { x, y, z }
    }

    /// The chart vectors with the components `v` along the axes.
    #[inline(always)]
    pub fn chart<F: Real>(&self, v: Vector<F>) -> Vector<F> {
        let [x, y, z] = self.axes.map(Vector::<F>::all);
        (x * v.x).plus(y, v.y).plus(z, v.z)
    }

    /// The light at the points `x` (render space) along the unit chart tangents `d`.
    ///
    /// Of light whose energy is not above 0, which exists in the ergosphere only, [`Light::norm`] is not above 0, and the rest has no meaning.
    #[inline(always)]
    pub fn light<F: Real>(&self, x: Vector<F>, d: Vector<F>) -> Light<F> {
        let c = F::splat;
        let (one, a) = (c(1.0), c(self.a));
        let axis = Vector::all(self.kerr.axis());
        let Oblate { r, square, sigma, m, cos, across, e_r, w } = self.kerr.oblate(x);
        let (root, a2, sine2) = (square.sqrt(), a * a, w.length_squared());
        let (along, around) = (e_r.dot(d), w.dot(d));
        // The metric along d: N^2 gamma(d, d), g_ti d^i, g_ij d^i d^j. The first is regular where N is 0.
        let shear = m * a2 / (square * sigma);
        let radial = d.dot(d) + m / (square - m) * along * along;
        let space = radial + shear * around * around;
        let norm = (one - m / sigma) * radial + shear * around * around;
        let mixed = -(m * a / (root * sigma)) * around;
        let speed = norm.sqrt();
        // dt along d, without a difference of what is nearly equal.
        let time = F::select(mixed.gt(c(0.0)), (mixed + speed) * sigma / (sigma - m), space / (speed - mixed));
        let per_speed = one / speed;
        let l = (root * around * shear.times_plus(sine2, one) - m * a * sine2 / sigma * time) * per_speed;
        // In Mino's time.
        let v = d * (sigma * per_speed);
        let slope = root * e_r.dot(v) / sigma.sqrt();
        let root_slope = r * slope / root;
        let up = axis.dot(v);
        let flat = (v - axis * up - across * root_slope) * (one / root);
        let whole = flat + axis * ((up - slope * cos) / r);
        let twist = a * (m - a * l) / (square - m);
        let n = across + axis * cos;
        let turning = whole - w * twist;
        let turning = turning - n * n.dot(turning);
        let carter = turning.length_squared() - a2 * cos * cos;
        let mass = c(0.5 * self.kerr.round().rs);
        let scale = (carter + a2 + mass * mass).sqrt();
        let per_scale = one / scale;
        let orbit = Orbit::new(self, scale, l * per_scale, carter * per_scale * per_scale);
        let state = State { u: scale / r, du: -slope / (r * r), n: self.components(n), dn: self.components(turning) * per_scale };
        Light { orbit, state, norm }
    }
}

/// Light that begins.
#[derive(Clone, Copy, Debug)]
pub struct Light<F> {
    /// Its constants.
    pub orbit: Orbit<F>,
    /// Where it is.
    pub state: State<F>,
    /// `N^2 gamma(d, d)` of its tangent; not above 0: there is no light of positive energy along it.
    pub norm: F,
}

/// The constants of light of energy 1, with all lengths in units of `scale`.
#[derive(Clone, Copy, Debug)]
pub struct Orbit<F> {
    /// The unit of length of this ray (scene units).
    pub scale: F,
    /// Mass, angular momentum over mass, square of the charge of the hole.
    pub mass: F,
    /// See [`Hole::a`].
    pub a: F,
    /// Square of the charge.
    pub charge_squared: F,
    /// Angular momentum about the axis.
    pub l: F,
    /// Carter's constant K.
    pub k: F,
    /// `K - 2 a L + a^2`, not below 0.
    pub kappa: F,
    /// `u'' = u (linear + u (square - cube u))`, and `u'^2 = 1 + linear u^2 + 2/3 square u^3 - 1/2 cube u^4`.
    pub linear: F,
    /// See [`Orbit::linear`].
    pub square: F,
    /// See [`Orbit::linear`].
    pub cube: F,
}

/// Where light is: u, the direction n without twist, along the axes of the hole, and their derivatives by `s`.
#[derive(Clone, Copy, Debug)]
pub struct State<F> {
    /// Scale over radius.
    pub u: F,
    /// Its derivative.
    pub du: F,
    /// Unit vector.
    pub n: Vector<F>,
    /// Its derivative.
    pub dn: Vector<F>,
}

impl<F: Real> Orbit<F> {
    #[inline(always)]
    fn new(hole: &Hole, scale: F, l: F, k: F) -> Self {
        let c = F::splat;
        let per_scale = c(1.0) / scale;
        let round = hole.kerr.round();
        let (mass, a) = (c(0.5 * round.rs) * per_scale, c(hole.a) * per_scale);
        let charge_squared = c(round.charge_squared) * per_scale * per_scale;
        let a2 = a * a;
        // Not above its true value, 0, by rounding.
        let kappa = (k - c(2.0) * a * l + a2).max(c(0.0));
        let cube = c(2.0) * (a2 * (k - l * l) + charge_squared * kappa);
        Self { scale, mass, a, charge_squared, l, k, kappa, linear: a2 - k, square: c(3.0) * mass * kappa, cube }
    }

    /// `u'^2` where u is this.
    #[inline(always)]
    pub fn barrier(&self, u: F) -> F {
        let c = F::splat;
        let inner = (c(-0.5) * self.cube * u + c(2.0 / 3.0) * self.square).times_plus(u, self.linear);
        (inner * u).times_plus(u, c(1.0))
    }

    /// u where `u'^2` is least, outside of all of its other extrema; infinite if it only grows inwards, or only falls.
    #[inline(always)]
    pub fn narrows(&self) -> F {
        let c = F::splat;
        // cube u^2 - square u - linear = 0
        let discriminant = self.square * self.square + c(4.0) * self.cube * self.linear;
        let u = c(-2.0) * self.linear / (self.square + discriminant.max(c(0.0)).sqrt());
        F::select(self.linear.lt(c(0.0)) & discriminant.ge(c(0.0)), u, c(f64::INFINITY))
    }

    /// Whether light at `state` falls into the hole whose horizon is at u = `horizon`: inwards it does unless `u'^2` vanishes before, outwards if it
    /// vanishes there. Between the least `u'^2` and the horizon it does not vanish. And how near that is to the light that winds for ever: 0 to 1.
    #[inline(always)]
    pub fn fate(&self, state: &State<F>, horizon: F) -> (F::Mask, F) {
        let c = F::splat;
        let narrows = self.narrows();
        let is_outside = narrows.lt(horizon);
        let least = F::select(is_outside, self.barrier(narrows), c(1.0));
        let turns = is_outside & least.le(c(0.0));
        let beyond = state.u.gt(narrows);
        let inwards = state.du.gt(c(0.0));
        let captured = (inwards & !(turns & !beyond)) | (turns & beyond);
        (captured, least.abs().min(c(1.0)))
    }

    /// The derivative of the twist where u is this.
    #[inline(always)]
    pub fn twist(&self, u: F) -> F {
        let c = F::splat;
        let up = c(2.0) * self.mass - (self.a * self.l + self.charge_squared) * u;
        let down = c(1.0) - u * (c(2.0) * self.mass - (self.a * self.a + self.charge_squared) * u);
        self.a * u * up / down
    }

    /// The second derivative of the twist at `state`.
    #[inline(always)]
    pub fn twist_slope(&self, state: &State<F>) -> F {
        let (c, u) = (F::splat, state.u);
        let linear = c(2.0) * self.mass;
        let (up, down) = (self.a * self.l + self.charge_squared, self.a * self.a + self.charge_squared);
        let below = c(1.0) - u * (linear - down * u);
        // The derivative of u (linear - up u) / below by u.
        let slope = (linear - c(2.0) * up * u) * below + u * (linear - up * u) * (linear - c(2.0) * down * u);
        self.a * slope / (below * below) * state.du
    }

    /// `u''` and `n''` at `state`.
    #[inline(always)]
    pub fn forces(&self, state: &State<F>) -> (F, Vector<F>) {
        let State { u, n, .. } = *state;
        let a2 = self.a * self.a;
        let pull = (u * (self.square - self.cube * u) + self.linear) * u;
        let mut turn = n * -(self.k + F::splat(2.0) * a2 * n.z * n.z);
        turn.z = a2.times_plus(n.z, turn.z);
        (pull, turn)
    }

    /// The point from the centre, along the axes of the hole, where light is at `state`, turned about the axis by the angle of this cosine and sine
    /// (scene units).
    #[inline(always)]
    pub fn point(&self, state: &State<F>, (cos, sin): (F, F)) -> Vector<F> {
        let n = turned(state.n, (cos, sin));
        let r = self.scale / state.u;
        let root = (self.a * state.u).times_plus(self.a * state.u, F::splat(1.0)).sqrt() * r;
        Vector { x: n.x * root, y: n.y * root, z: n.z * r }
    }

    /// The same, and its derivative by `s`; `twist` is [`Orbit::twist`].
    #[inline(always)]
    pub fn point_and_tangent(&self, state: &State<F>, turn: (F, F), twist: F) -> (Vector<F>, Vector<F>) {
        let one = F::splat(1.0);
        let State { u, du, n, dn } = *state;
        let (n, whole) = (turned(n, turn), turned(turning(n, dn, twist), turn));
        let r = self.scale / u;
        let stretch = (self.a * u).times_plus(self.a * u, one).sqrt();
        let (root, slope) = (stretch * r, -du * r / u);
        let root_slope = slope / stretch;
        let point = Vector { x: n.x * root, y: n.y * root, z: n.z * r };
        let tangent = Vector {
            x: whole.x.times_plus(root, n.x * root_slope),
            y: whole.y.times_plus(root, n.y * root_slope),
            z: whole.z.times_plus(r, n.z * slope),
        };
        (point, tangent)
    }

    /// Those of ray number `i`.
    pub fn lane(&self, i: usize) -> Orbit<f64> {
        Orbit {
            scale: self.scale.lane(i),
            mass: self.mass.lane(i),
            a: self.a.lane(i),
            charge_squared: self.charge_squared.lane(i),
            l: self.l.lane(i),
            k: self.k.lane(i),
            kappa: self.kappa.lane(i),
            linear: self.linear.lane(i),
            square: self.square.lane(i),
            cube: self.cube.lane(i),
        }
    }
}

impl<F: Real> State<F> {
    /// The same light, turned about the axis by the angle of this cosine and sine; n is made a unit vector again, and its derivative one across it.
    #[inline(always)]
    #[must_use]
    pub fn turned(&self, turn: (F, F)) -> Self {
        let n = turned(self.n, turn).normalize();
        let dn = turned(self.dn, turn);
        Self { n, dn: dn - n * n.dot(dn), ..*self }
    }

    /// Of the rays in `which` those of `self`, of the others those of `o`.
    #[inline(always)]
    #[must_use]
    pub fn or(&self, o: &Self, which: F::Mask) -> Self {
        let pick = |yes, no| F::select(which, yes, no);
        Self { u: pick(self.u, o.u), du: pick(self.du, o.du), n: self.n.or(o.n, which), dn: self.dn.or(o.dn, which) }
    }
}

/// `v` turned about the third axis by the angle of this cosine and sine.
#[inline(always)]
pub fn turned<F: Real>(v: Vector<F>, (cos, sin): (F, F)) -> Vector<F> {
    Vector { x: cos * v.x - sin * v.y, y: sin.times_plus(v.x, cos * v.y), z: v.z }
}

/// The derivative `dn + twist z x n`.
#[inline(always)]
pub fn turning<F: Real>(n: Vector<F>, dn: Vector<F>, twist: F) -> Vector<F> {
    Vector { x: dn.x - twist * n.y, y: twist.times_plus(n.x, dn.y), z: dn.z }
}
