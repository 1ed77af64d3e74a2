//! Taylor steps of several orbits side by side: `taylor.rs` in lanes.

use crate::arithmetic::polynomial::{TERMS, cos_sin, small_arc_tangent, value, value_and_slope};
use crate::spherical::Attraction;
use crate::spherical::orbit::{Dense, OVERSHOOT, OrbitPlane, Polar, State};
use crate::spherical::taylor::{LONGEST, LONGEST_POWER, SAFETY, TaylorStep, coefficients, root};
use bhs_core::lanes::{LANES, Lanes, Vectors, pick, set_bits};
use glam::DVec3;

/// States of orbits, with cosines and sines of their angles.
#[derive(Clone, Copy, Debug)]
pub struct Polars {
    /// Angles swept (rad).
    pub phi: Lanes,
    /// 1/r.
    pub u: Lanes,
    /// du/dphi.
    pub du: Lanes,
    /// cos(phi).
    pub cos: Lanes,
    /// sin(phi).
    pub sin: Lanes,
}

impl Polars {
    /// The state of ray number `i`.
    pub fn lane(&self, i: usize) -> Polar {
        let [phi, u, du, cos, sin] = [self.phi, self.u, self.du, self.cos, self.sin].map(|l| l.to_array()[i]);
        Polar { state: State { phi, u, du }, cos, sin }
    }

    /// Of the rays in `which` those of `self`, of the others those of `o`.
    #[inline(always)]
    pub fn or(&self, o: &Self, which: Lanes) -> Self {
        Self {
            phi: pick(which, self.phi, o.phi),
            u: pick(which, self.u, o.u),
            du: pick(which, self.du, o.du),
            cos: pick(which, self.cos, o.cos),
            sin: pick(which, self.sin, o.sin),
        }
    }

    /// The states further on by small angles: [`Polar::moved`].
    #[inline(always)]
    pub fn moved(&self, hole: impl Into<Attraction>, by: Lanes) -> Self {
        let hole = hole.into();
        let Self { phi, u, du, cos, sin } = *self;
        let c = Lanes::splat;
        let half = c(0.5) * by;
        let mut force = u * u.mul_add(c(1.5 * hole.rs), c(-1.0));
        let mut slope = u.mul_add(c(3.0 * hole.rs), c(-1.0));
        if hole.is_charged() {
            let repulsion = c(-2.0 * hole.charge_squared) * u * u;
            force = repulsion.mul_add(u, force);
            slope = repulsion.mul_add(c(3.0), slope);
        }
        Self {
            phi: phi + by,
            u: by.mul_add(half.mul_add(force, du), u),
            du: by.mul_add((half * du).mul_add(slope, force), du),
            cos: cos - by * half.mul_add(cos, sin),
            sin: sin + by * half.mul_neg_add(sin, cos),
        }
    }
}

/// The planes of orbits, around one centre.
#[derive(Clone, Copy, Debug)]
pub struct Planes {
    /// The hole's centre.
    pub center: DVec3,
    /// Unit vectors from the centre to where the orbits begin.
    pub e1: Vectors,
    /// Unit vectors across them.
    pub e2: Vectors,
}

/// Newton's corrections of the angle at which an orbit reaches infinity.
const MOST_CORRECTIONS: u32 = 8;

/// Least sine of the angle between a ray and the radius of a ray that is followed side by side with others.
const LEAST_SINE: f64 = 1e-9;

impl Planes {
    /// The planes and initial states of rays with unit chart directions ([`OrbitPlane::of_ray`]), and of which of them they are right: not
    /// of rays from the centre or along the radius.
    #[inline(always)]
    pub fn of_rays(center: DVec3, origin: Vectors, direction: Vectors) -> (Self, Polars, Lanes) {
        let c = Lanes::splat;
        let one = c(1.0);
        let from_center = origin - Vectors::all(center);
        // Rounded as those of one ray, operation by operation: critical orbits feel that.
        let dot = |a: Vectors, b: Vectors| a.x * b.x + a.y * b.y + a.z * b.z;
        let r0 = dot(from_center, from_center).sqrt();
        let e1 = from_center.over(r0);
        let cos = dot(direction, e1);
        let across = direction - e1 * cos;
        let across = across - e1 * dot(across, e1);
        let sin = dot(across, across).sqrt();
        let start = Polars { phi: c(0.0), u: one / r0, du: -cos / (sin * r0), cos: one, sin: c(0.0) };
        let e2 = across.over(sin);
        (Self { center, e1, e2 }, start, sin.simd_gt(c(LEAST_SINE)) & start.u.simd_gt(c(0.0)))
    }

    /// The points at 1/r = `u`, where cosine and sine of the angle are these.
    #[inline(always)]
    pub fn points(&self, u: Lanes, cos: Lanes, sin: Lanes) -> Vectors {
        let r = Lanes::splat(1.0) / u;
        Vectors::all(self.center).plus(self.e1, cos * r).plus(self.e2, sin * r)
    }

    /// The unit chart tangents: [`OrbitPlane::direction_of`].
    #[inline(always)]
    pub fn directions(&self, p: &Polars) -> Vectors {
        let (x, y) = (-(p.u * p.sin) - p.du * p.cos, p.u * p.cos - p.du * p.sin);
        let scale = Lanes::splat(1.0) / x.mul_add(x, y * y).sqrt();
        (self.e1 * (x * scale)).plus(self.e2, y * scale)
    }

    /// The angles, of less than half a turn, from the points `from` to the points `to` of the planes (rad): to 1e-5 for those of less than 0.8.
    #[inline(always)]
    pub fn angles(&self, from: Vectors, to: Vectors) -> Lanes {
        let center = Vectors::all(self.center);
        let (from, to) = (from - center, to - center);
        let (x0, y0) = (from.dot(self.e1), from.dot(self.e2));
        let (x, y) = (to.dot(self.e1), to.dot(self.e2));
        let (along, across) = (x0 * x + y0 * y, x0 * y - y0 * x);
        // Twice the angle whose tangent is that of half the angle.
        Lanes::splat(2.0) * small_arc_tangent(across / (along + along.mul_add(along, across * across).sqrt()))
    }

    /// The plane of ray number `i`.
    pub fn lane(&self, i: usize) -> OrbitPlane {
        OrbitPlane { center: self.center, e1: self.e1.lane(i), e2: self.e2.lane(i) }
    }
}

/// Largest errors of u in a step: [`crate::spherical::taylor::TaylorOrbit::new`].
#[inline(always)]
pub fn errors(hole: impl Into<Attraction>, start: &Polars, relative: Lanes) -> Lanes {
    let c = Lanes::splat;
    let (hole, Polars { u, du, .. }) = (hole.into(), *start);
    if hole.is_charged() {
        let barrier = u * u * u.mul_add(u.mul_add(c(hole.charge_squared), c(-hole.rs)), c(1.0));
        let inverse_b_squared = du.mul_add(du, barrier);
        let closeness = ((inverse_b_squared - c(hole.critical)).abs() / inverse_b_squared).fast_min(c(1.0));
        return inverse_b_squared.sqrt() * (c(SAFETY) * relative * closeness).fast_max(c(0.5 * f64::EPSILON));
    }
    let rs = hole.rs;
    let inverse_b_squared = du.mul_add(du, u * u * u.mul_add(c(-rs), c(1.0)));
    let scaled = inverse_b_squared * c(rs * rs);
    let closeness = ((scaled - c(4.0 / 27.0)).abs() / scaled).fast_min(c(1.0));
    inverse_b_squared.sqrt() * (c(SAFETY) * relative * closeness).fast_max(c(0.5 * f64::EPSILON))
}

/// One Taylor step of each orbit.
#[derive(Clone, Copy)]
pub struct Steps {
    c: [Lanes; TERMS],
    /// Where they begin.
    pub start: Polars,
    /// Where they end.
    pub end: Polars,
}

impl Steps {
    /// The steps from `start` of the orbits around `hole`, with errors of u of at most `error`.
    #[inline]
    pub fn from(hole: impl Into<Attraction>, start: &Polars, error: Lanes) -> Self {
        let (one, hole) = (Lanes::splat, hole.into());
        let c = coefficients(&hole, start.u, start.du);
        let pair = |n: usize| one(LONGEST).mul_add(c[n + 1].abs(), c[n].abs());
        let share = error / pair(TERMS - 4).mul_add(one(0.125), pair(TERMS - 2));
        let shorter = (!share.simd_ge(one(LONGEST_POWER))).to_bitmask();
        let mut longest = [LONGEST; LANES];
        let shares = share.to_array();
        for i in set_bits(shorter) {
            longest[i] = root(shares[i]);
        }
        // As `room` has it.
        let down = start.du.simd_gt(one(0.0));
        let room = pick(down, one(hole.horizon) - start.u, -start.u) / start.du;
        let longest = Lanes::from(longest);
        let h = pick(room.simd_gt(one(0.0)), longest.fast_min(one(OVERSHOOT) * room), longest);
        let mut steps = Self { c, start: *start, end: *start };
        steps.end = steps.polar(start.phi + h);
        steps
    }

    /// Coefficients of 1/r as polynomials in the angles since the start.
    #[inline(always)]
    pub fn coefficients(&self) -> &[Lanes; TERMS] {
        &self.c
    }

    /// Which orbits have reached infinity.
    pub fn escaped(&self) -> Lanes {
        self.end.u.simd_le(Lanes::splat(0.0))
    }

    /// The angles at which the orbits reach infinity, and of which of them they are right (Newton's method; [`Dense::crossing`] finds the others).
    #[inline(always)]
    pub fn angles_at_infinity(&self) -> (Polars, Lanes) {
        let c = Lanes::splat;
        let width = self.end.phi - self.start.phi;
        let mut t = width * (self.start.u / (self.start.u - self.end.u)).fast_clamp(c(0.0), c(1.0));
        let mut right = c(0.0);
        for _ in 0..MOST_CORRECTIONS {
            let (u, du) = value_and_slope(&self.c, t);
            let change = u / du;
            t -= change;
            right = change.abs().simd_le(c(1e-8) * width) & t.simd_ge(c(0.0)) & t.simd_le(width);
            if (right | !self.escaped()).all() {
                break;
            }
        }
        (self.polar(self.start.phi + t), right)
    }

    /// Which orbits have reached the horizon.
    pub fn captured(&self, hole: impl Into<Attraction>) -> Lanes {
        self.end.u.simd_ge(Lanes::splat(hole.into().horizon))
    }

    /// Shortens those steps that go on beyond the angles `limit`; which end there.
    #[inline]
    pub fn limit(&mut self, limit: Lanes) -> Lanes {
        let beyond = self.end.phi.simd_ge(limit);
        if beyond.any() {
            self.end = self.polar(limit).or(&self.end, beyond);
        }
        beyond
    }

    /// Cosines and sines of the angles `t` after the start.
    #[inline(always)]
    fn cos_sin(&self, t: Lanes) -> (Lanes, Lanes) {
        let (cos, sin) = cos_sin(t);
        let Polars { cos: c0, sin: s0, .. } = self.start;
        (c0 * cos - s0 * sin, s0.mul_add(cos, c0 * sin))
    }

    /// 1/r at the angles `phi`, with their cosines and sines.
    #[inline(always)]
    pub fn place(&self, phi: Lanes) -> (Lanes, Lanes, Lanes) {
        let t = phi - self.start.phi;
        let (cos, sin) = self.cos_sin(t);
        (value(&self.c, t), cos, sin)
    }

    /// The states at the angles `phi`.
    #[inline(always)]
    pub fn polar(&self, phi: Lanes) -> Polars {
        let t = phi - self.start.phi;
        let (cos, sin) = self.cos_sin(t);
        let (u, du) = value_and_slope(&self.c, t);
        Polars { phi, u, du, cos, sin }
    }

    /// The step of ray number `i`.
    pub fn lane(&self, i: usize) -> TaylorStep {
        TaylorStep::from_parts(self.c.map(|c| c.to_array()[i]), self.start.lane(i), self.end.lane(i).state)
    }

    /// Cuts the step of ray number `i` short at the horizon, which it reaches.
    #[cold]
    pub fn end_at_horizon(&mut self, hole: impl Into<Attraction>, i: usize) {
        let step = self.lane(i).within_space(hole);
        let Polar { state, cos, sin } = step.polar(step.end().phi);
        let Polars { phi, u, du, cos: cosines, sin: sines } = &mut self.end;
        // The horizon itself, not what the series gives for it.
        for (lanes, value) in [(phi, state.phi), (u, step.end().u), (du, state.du), (cosines, cos), (sines, sin)] {
            let mut values = lanes.to_array();
            values[i] = value;
            *lanes = Lanes::from(values);
        }
    }
}
