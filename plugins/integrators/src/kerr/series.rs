//! Steps of light around a hole that spins, as polynomials: Taylor series, or those through the ends of a Runge-Kutta step.
//!
//! All right-hand sides are polynomials but that of the twist, which is a quotient of polynomials: each coefficient follows from seven short sums
//! over the former (`docs/physics.md`, section 5).

use crate::arithmetic::polynomial::{TERMS, cos_sin, value, value_and_slope};
use crate::kerr::orbit::{Orbit, State};
use crate::spherical::plane::OVERSHOOT;
use crate::spherical::series::{LONGEST, LONGEST_POWER, root};
use bhs_core::lanes::{LANES, set_bits};
use bhs_core::real::{Mask, Real, Vector};

/// Largest turn about the axis in a step (rad): cosine and sine are found from a power series.
const MOST_TWIST: f64 = 1.5;

/// Dense output of a step: what [`State`] has, and the turn about the axis since its start, as polynomials in `s` since its start.
#[derive(Clone, Copy, Debug)]
pub struct Series<F> {
    /// u
    pub u: [F; TERMS],
    /// n, along the axes of the hole.
    pub n: [[F; TERMS]; 3],
    /// The turn (rad).
    pub twist: [F; TERMS],
}

/// The turn `angle`, if a step has no longer one.
#[inline(always)]
fn limited<F: Real>(angle: F) -> F {
    let most = F::splat(MOST_TWIST);
    angle.min(most).max(-most)
}

/// Coefficient number n of the product of two series.
#[inline(always)]
fn product<F: Real>(a: &[F; TERMS], b: &[F; TERMS], n: usize) -> F {
    let mut sum = a[0] * b[n];
    for i in 1..=n {
        sum = a[i].times_plus(b[n - i], sum);
    }
    sum
}

/// The same of the square of a series.
#[inline(always)]
fn square<F: Real>(a: &[F; TERMS], n: usize) -> F {
    let mut pairs = if n.is_multiple_of(2) { F::splat(0.5) * a[n / 2] * a[n / 2] } else { F::splat(0.0) };
    for i in 0..n.div_ceil(2) {
        pairs = a[i].times_plus(a[n - i], pairs);
    }
    pairs + pairs
}

impl<F: Real> Series<F> {
    /// A step of no length.
    #[inline(always)]
    pub fn nowhere(state: &State<F>) -> Self {
        let first = |x: F| {
            let mut c = [F::splat(0.0); TERMS];
            c[0] = x;
            c
        };
        let State { u, n, .. } = state;
        Self { u: first(*u), n: [first(n.x), first(n.y), first(n.z)], twist: first(F::splat(0.0)) }
    }

    /// The Taylor series of the light `orbit` that is at `state`.
    #[inline(always)]
    pub fn taylor(orbit: &Orbit<F>, state: &State<F>) -> Self {
        let c = F::splat;
        let mut series = Self::nowhere(state);
        let Self { u, n, twist } = &mut series;
        let slopes = [state.dn.x, state.dn.y, state.dn.z];
        u[1] = state.du;
        for (n, slope) in n.iter_mut().zip(slopes) {
            n[1] = slope;
        }
        let a2 = orbit.a * orbit.a;
        let twice = c(2.0) * a2;
        // The quotient of the twist: up over 1 + down.
        let (linear_up, square_up) = (c(2.0) * orbit.mass * orbit.a, orbit.a * (orbit.a * orbit.l + orbit.charge_squared));
        let (linear_down, square_down) = (c(-2.0) * orbit.mass, a2 + orbit.charge_squared);
        let zero = [c(0.0); TERMS];
        let (mut squares, mut heights, mut down, mut quotient) = (zero, zero, zero, zero);
        let first = state.u * (square_down * state.u + linear_down) + c(1.0);
        let per_first = c(1.0) / first;
        for k in 0..TERMS - 1 {
            squares[k] = square(u, k);
            let up = linear_up * u[k] - square_up * squares[k];
            if k > 0 {
                down[k] = linear_down.times_plus(u[k], square_down * squares[k]);
            }
            let mut rest = up;
            for j in 1..=k {
                rest -= down[j] * quotient[k - j];
            }
            quotient[k] = rest * per_first;
            twist[k + 1] = quotient[k] * c(1.0 / (k + 1) as f64);
            if k + 2 == TERMS {
                break;
            }
            let over = c(1.0 / ((k + 1) * (k + 2)) as f64);
            let cubes = product(&squares, u, k);
            u[k + 2] = orbit.linear.times_plus(u[k], orbit.square.times_plus(squares[k], -(orbit.cube * cubes))) * over;
            heights[k] = square(&n[2], k);
            let straight = n[2][k] * a2;
            for (i, n) in n.iter_mut().enumerate() {
                let pulled = -(twice * product(&heights, n, k) + orbit.k * n[k]);
                n[k + 2] = if i == 2 { pulled + straight } else { pulled } * over;
            }
        }
        series
    }

    /// The length of the step that has errors of at most `error` of u, n, and the twist.
    #[inline(always)]
    pub fn length(&self, error: F) -> F {
        let c = F::splat;
        // As for round holes: pairs, for one of two may vanish, and two pairs, for both may be small by chance.
        let largest = |k: usize| {
            let of_n = self.n[0][k].abs() + self.n[1][k].abs() + self.n[2][k].abs();
            self.u[k].abs().max(of_n).max(self.twist[k].abs())
        };
        let pair = |k: usize| c(LONGEST).times_plus(largest(k + 1), largest(k));
        let share = error / pair(TERMS - 4).times_plus(c(0.125), pair(TERMS - 2));
        let shorter = (!share.ge(c(LONGEST_POWER))).bits();
        let mut longest = [LONGEST; LANES];
        let shares = share.to_array();
        for i in set_bits(shorter) {
            longest[i] = root(shares[i].max(1e-300));
        }
        F::from_fn(|i| longest[i])
    }

    /// The polynomials of degree 5 that have values, slopes and second derivatives of both ends of a step of the length `h`; `twists` are those of
    /// the twist: its slope and second derivative at the start, its value, slope and second derivative at the end.
    #[inline(always)]
    fn through(orbit: &Orbit<F>, [from, to]: [&State<F>; 2], (twists, end): ([F; 2], [F; 3]), h: F) -> Self {
        let mut series = Self::nowhere(from);
        let [(pull, turn), (pull_end, turn_end)] = [from, to].map(|state| orbit.forces(state));
        quintic(&mut series.u, [from.du, pull], [to.u, to.du, pull_end], h);
        let parts = |v: Vector<F>| [v.x, v.y, v.z];
        let (starts, ends) = ([from.dn, turn].map(parts), [to.n, to.dn, turn_end].map(parts));
        for (i, c) in series.n.iter_mut().enumerate() {
            quintic(c, starts.map(|v| v[i]), ends.map(|v| v[i]), h);
        }
        quintic(&mut series.twist, twists, end, h);
        series
    }

    /// One step of the classic Runge-Kutta method of the length `h`, and the state at its end before it is turned.
    #[inline(always)]
    pub fn runge_kutta(orbit: &Orbit<F>, state: &State<F>, h: F) -> (Self, State<F>) {
        let half = h * F::splat(0.5);
        let slope = |s: &State<F>| {
            let (pull, turn) = orbit.forces(s);
            (State { u: s.du, du: pull, n: s.dn, dn: turn }, orbit.twist(s.u))
        };
        let moved = |by: &State<F>, h: F| State {
            u: by.u.times_plus(h, state.u),
            du: by.du.times_plus(h, state.du),
            n: state.n.plus(by.n, h),
            dn: state.dn.plus(by.dn, h),
        };
        let (k1, t1) = slope(state);
        let (k2, t2) = slope(&moved(&k1, half));
        let (k3, t3) = slope(&moved(&k2, half));
        let (k4, t4) = slope(&moved(&k3, h));
        let sixth = h * F::splat(1.0 / 6.0);
        let mean = |a: F, b: F, c: F, d: F| a + F::splat(2.0) * (b + c) + d;
        let means = |a: Vector<F>, b: Vector<F>, c: Vector<F>, d: Vector<F>| a + (b + c) * F::splat(2.0) + d;
        let sum = State {
            u: mean(k1.u, k2.u, k3.u, k4.u),
            du: mean(k1.du, k2.du, k3.du, k4.du),
            n: means(k1.n, k2.n, k3.n, k4.n),
            dn: means(k1.dn, k2.dn, k3.dn, k4.dn),
        };
        let end = moved(&sum, sixth);
        let turn = mean(t1, t2, t3, t4) * sixth;
        let twists = [t1, orbit.twist_slope(state)];
        let at_end = [turn, orbit.twist(end.u), orbit.twist_slope(&end)];
        (Self::through(orbit, [state, &end], (twists, at_end), h), end)
    }

    /// The state after `t`, without the turn, cosine and sine of the turn, and its derivative.
    #[inline(always)]
    pub fn at(&self, t: F) -> (State<F>, (F, F), F) {
        let (u, du) = value_and_slope(&self.u, t);
        let [x, y, z] = [0, 1, 2].map(|i| value_and_slope(&self.n[i], t));
        let state = State { u, du, n: Vector { x: x.0, y: y.0, z: z.0 }, dn: Vector { x: x.1, y: y.1, z: z.1 } };
        let (turn, twist) = value_and_slope(&self.twist, t);
        (state, cos_sin(limited(turn)), twist)
    }

    /// u and n after `t` (the derivatives are 0), and cosine and sine of the turn.
    #[inline(always)]
    pub fn place(&self, t: F) -> (State<F>, (F, F)) {
        let zero = F::splat(0.0);
        let n = Vector { x: value(&self.n[0], t), y: value(&self.n[1], t), z: value(&self.n[2], t) };
        let dn = Vector { x: zero, y: zero, z: zero };
        (State { u: value(&self.u, t), du: zero, n, dn }, cos_sin(limited(value(&self.twist, t))))
    }

    /// That of ray number `i`.
    pub fn lane(&self, i: usize) -> Series<f64> {
        let one = |c: &[F; TERMS]| c.map(|c| c.lane(i));
        Series { u: one(&self.u), n: [0, 1, 2].map(|k| one(&self.n[k])), twist: one(&self.twist) }
    }
}

/// `length`, or less where the light at `state` reaches u = `deepest` or infinity before.
#[inline(always)]
pub fn room<F: Real>(state: &State<F>, deepest: F, length: F) -> F {
    let c = F::splat;
    let room = F::select(state.du.gt(c(0.0)), deepest - state.u, -state.u) / state.du;
    F::select(room.gt(c(0.0)), length.min(c(OVERSHOOT) * room), length)
}

/// Completes the polynomial `c`, the value of which at 0 is known, by slope and second derivative there, and value, slope and second derivative at
/// `h`.
#[inline(always)]
fn quintic<F: Real>(c: &mut [F; TERMS], [slope, bend]: [F; 2], [value, slope_end, bend_end]: [F; 3], h: F) {
    let of = F::splat;
    let per_h = of(1.0) / h;
    // In shares of h.
    let (d0, b0, d1, b1) = (slope * h, bend * h * h, slope_end * h, bend_end * h * h);
    let gain = value - c[0];
    let third = of(10.0) * gain - of(6.0) * d0 - of(4.0) * d1 + (b1 - of(3.0) * b0) * of(0.5);
    let fourth = of(-15.0) * gain + of(8.0) * d0 + of(7.0) * d1 + of(1.5) * b0 - b1;
    let fifth = of(6.0) * gain - of(3.0) * (d0 + d1) + (b1 - b0) * of(0.5);
    let per = [per_h, per_h * per_h, per_h * per_h * per_h];
    (c[1], c[2]) = (slope, bend * of(0.5));
    (c[3], c[4], c[5]) = (third * per[2], fourth * per[2] * per[0], fifth * per[2] * per[1]);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kerr::orbit::{Hole, Light};
    use bhs_core::lanes::Lanes;
    use bhs_core::spacetime::{Kerr, Spherical};
    use glam::DVec3;

    fn hole(spin: f64, charge: f64) -> Hole {
        let round = Spherical { center: DVec3::new(0.1, -0.2, 0.3), rs: 2.0, charge_squared: charge * charge };
        Hole::new(&Kerr::new(round, DVec3::new(0.6, 0.0, 0.8), spin), true)
    }

    fn rays() -> impl Iterator<Item = (DVec3, DVec3)> {
        (0..40).map(|i| {
            let angle = 0.4 + 0.37 * f64::from(i);
            let x = DVec3::new(3.0 + angle, -1.0 - angle, 2.0);
            (x, DVec3::new(-angle.cos(), angle.sin(), 0.3 - 0.02 * f64::from(i)).normalize())
        })
    }

    /// First integrals along one step, and the tangent where it starts.
    #[test]
    fn steps_keep_what_is_conserved() {
        for (spin, charge) in [(0.5, 0.0), (0.9, 0.3), (0.998, 0.0), (-0.7, 0.2)] {
            let hole = hole(spin, charge);
            for (x, d) in rays() {
                let Light { orbit, state, norm } = hole.light::<f64>(x.into(), d.into());
                assert!(norm > 0.0);
                let series = Series::taylor(&orbit, &state);
                let h = room(&state, f64::INFINITY, series.length(1e-12));
                for t in [0.0, 0.3 * h, h] {
                    let (at, turn, twist) = series.at(t);
                    let n2 = at.n.length_squared();
                    let drift = [
                        n2 - 1.0,
                        at.du * at.du - orbit.barrier(at.u),
                        at.dn.length_squared() - orbit.k - orbit.a * orbit.a * at.n.z * at.n.z,
                        at.n.x * at.dn.y - at.n.y * at.dn.x - orbit.l,
                    ];
                    assert!(drift.iter().all(|d| d.abs() < 1e-10), "{spin} {x} {d} {t}: {drift:?}");
                    let (point, tangent) = orbit.point_and_tangent(&at, turn, twist);
                    if t == 0.0 {
                        let back = DVec3::from(hole.chart(point)) + hole.kerr.round().center;
                        let along = DVec3::from(hole.chart(tangent)).normalize();
                        assert!((back - x).length() < 1e-13 && (along - d).length() < 1e-13, "{back} {x} {along} {d}");
                    }
                }
            }
        }
    }

    #[test]
    fn series_and_small_steps_agree() {
        let hole = hole(0.9, 0.2);
        for (x, d) in rays() {
            let Light { orbit, state, .. } = hole.light::<f64>(x.into(), d.into());
            let h = room(&state, f64::INFINITY, 0.05);
            let (a, turn_a, _) = Series::taylor(&orbit, &state).at(h);
            let (small, _) = Series::runge_kutta(&orbit, &state, h);
            let (b, turn_b, _) = small.at(h);
            assert!((a.u - b.u).abs() < 1e-7 && (a.n - b.n).length() < 1e-7 && (turn_a.1 - turn_b.1).abs() < 1e-7);
            let (middle, smooth) = (Series::taylor(&orbit, &state).at(0.5 * h).0, small.at(0.5 * h).0);
            assert!((middle.u - smooth.u).abs() < 1e-7 && (middle.dn - smooth.dn).length() < 1e-5);
        }
    }

    #[test]
    fn eight_are_as_one() {
        let hole = hole(0.9, 0.0);
        let all: Vec<_> = rays().take(LANES).collect();
        let lanes = hole.light::<Lanes>(Vector::from_fn(|i| all[i].0), Vector::from_fn(|i| all[i].1));
        let series = Series::taylor(&lanes.orbit, &lanes.state);
        for (i, (x, d)) in all.iter().enumerate() {
            let one = hole.light::<f64>((*x).into(), (*d).into());
            let alone = Series::taylor(&one.orbit, &one.state);
            let lane = series.lane(i);
            assert_eq!((lane.u, lane.n, lane.twist), (alone.u, alone.n, alone.twist));
        }
    }
}
