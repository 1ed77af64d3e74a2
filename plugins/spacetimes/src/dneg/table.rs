//! The square of the index as a function of the square of the isotropic radius: polynomials in pieces, in units of the throat's areal radius.
//!
//! Pieces lie closer where the mouth begins and grow with the distance from there, eight to each doubling; the number of a piece is read from
//! the bits of its place. The derivative that rays need is that of the polynomial, so that the two belong together.

use super::profile::Profile;
use bhs_core::lanes::LANES;
use bhs_core::real::Real;
use bhs_elementary::Elementary;
use std::f64::consts::{FRAC_2_PI, FRAC_PI_2, PI};

/// Coefficients of a piece.
const TERMS: usize = 12;

/// The logarithm to base 2 of how many pieces there are to a doubling.
const SPLITS: u32 = 3;

/// Of a place above 1, the bits that number its piece begin here.
const SHIFT: u32 = f64::MANTISSA_DIGITS - 1 - SPLITS;

/// A polynomial in `t = (place - middle) over_half`.
#[derive(Clone, Copy, Debug)]
struct Piece {
    middle: f64,
    over_half: f64,
    coefficients: [f64; TERMS],
}

/// `n^2` by `q = rho^2`.
#[derive(Debug)]
pub struct Table {
    /// `q` where the cylinder ends.
    end: f64,
    /// `q` there in the chart of the other side.
    other_end: f64,
    /// Square of `q` in the middle of the throat.
    fold: f64,
    /// The place of `q` in the table is `1 + (q - end) over`.
    over: f64,
    pieces: Vec<Piece>,
    /// The table ends here, in `q` and in places.
    far: f64,
    last_place: f64,
    /// Beyond: `n^2 = 1 + far_terms[0] / rho + far_terms[1] / q`.
    far_terms: [f64; 2],
}

impl Table {
    /// The index of a profile.
    pub fn new(profile: &Profile) -> Self {
        let (end, throat) = (profile.cylinder_end().powi(2), profile.throat().powi(2));
        // About where, in q / end - 1 and off the real numbers, the index is singular.
        let scale = (2.0 * profile.m()).min(1.0);
        let over = 1.0 / (end * scale);
        // To some million times the larger of the throat and the mouths.
        let doublings = (1e12 * (1.0 + profile.m()).powi(2) * over).logarithm2().ceil() as u32;
        let mut table = Self {
            end,
            other_end: throat * throat / end,
            fold: throat * throat,
            over,
            pieces: Vec::new(),
            far: f64::INFINITY,
            last_place: f64::INFINITY,
            far_terms: [0.0; 2],
        };
        let mut x = 0.0;
        for number in 0..doublings << SPLITS {
            let edge = |n: u32| f64::from_bits(1.0_f64.to_bits() + (u64::from(n) << SHIFT));
            let (a, b) = (edge(number), edge(number + 1));
            table.pieces.push(Piece::fit(a, b, |place| {
                // ln rho is a concave function of x, so that Newton's iteration comes from one side.
                let wanted = ((place - 1.0) * scale).logarithm_1p();
                for _ in 0..50 {
                    let step = (wanted - 2.0 * profile.log_growth(x)) * profile.radius(x) / (PI * profile.m());
                    x = f64::max(x + step, 0.0);
                    if step.abs() <= 4e-16 * x {
                        break;
                    }
                }
                let excess = (2.0 * profile.log_index(x)).exponential_m1();
                let slope = -(1.0 + excess) * FRAC_2_PI * 1.0_f64.arctangent2(x) / (end + (place - 1.0) / over);
                (excess, slope / over)
            }));
        }
        // The table goes on with its value and slope.
        let last_place = f64::from_bits(1.0_f64.to_bits() + (u64::from(doublings << SPLITS) << SHIFT) - 1);
        let far = end + (last_place - 1.0) / over;
        let (value, slope) = table.beyond(far);
        let rho = far.sqrt();
        table.far_terms = [2.0 * rho * (value + slope * far), -far * (value + 2.0 * slope * far)];
        (table.far, table.last_place) = (far, last_place);
        table
    }

    /// `n^2 - 1` and its derivative by `q`, beyond the cylinder.
    #[inline(always)]
    fn beyond<F: Real>(&self, q: F) -> (F, F) {
        let one = F::splat(1.0);
        let place = (q - F::splat(self.end)).times_plus(F::splat(self.over), one).max(one).min(F::splat(self.last_place));
        let mut pieces = [&self.pieces[0]; LANES];
        for (i, piece) in pieces.iter_mut().enumerate().take(F::COUNT) {
            let number = (place.lane(i).to_bits() - 1.0_f64.to_bits()) >> SHIFT;
            // NaN has the last one.
            *piece = &self.pieces[(number as usize).min(self.pieces.len() - 1)];
        }
        let over_half = F::from_fn(|i| pieces[i].over_half);
        let t = (place - F::from_fn(|i| pieces[i].middle)) * over_half;
        let mut value = F::from_fn(|i| pieces[i].coefficients[TERMS - 1]);
        let mut slope = F::splat(0.0);
        for k in (0..TERMS - 1).rev() {
            slope = slope.times_plus(t, value);
            value = value.times_plus(t, F::from_fn(|i| pieces[i].coefficients[k]));
        }
        slope = slope * over_half * F::splat(self.over);
        // Far away.
        let over_q = one / q;
        let terms = [F::splat(self.far_terms[0]) * over_q.sqrt(), F::splat(self.far_terms[1]) * over_q];
        let is_far = q.gt(F::splat(self.far));
        let far_slope = -(F::splat(0.5).times_plus(terms[0], terms[1])) * over_q;
        (F::select(is_far, terms[0] + terms[1], value), F::select(is_far, far_slope, slope))
    }

    /// `n^2` and its derivative by `q`.
    #[inline(always)]
    pub fn index<F: Real>(&self, q: F) -> (F, F) {
        let over_q = F::splat(1.0) / q;
        let mirrored = q.lt(F::splat(self.other_end));
        // On the other side of the throat lengths are the same: n^2 q is, at the mirrored place.
        let ratio = F::splat(self.fold) * over_q;
        let (excess, slope) = self.beyond(F::select(mirrored, ratio, q));
        let square = F::splat(1.0) + excess;
        let ratio_by_q = ratio * over_q;
        let there = square * ratio_by_q;
        let there_slope = -(slope * ratio_by_q * ratio_by_q) - (there + there) * over_q;
        // Along the cylinder n = 1 / rho.
        let along = q.lt(F::splat(self.end));
        let square = F::select(mirrored, there, F::select(along, over_q, square));
        (square, F::select(mirrored, there_slope, F::select(along, -(over_q * over_q), slope)))
    }
}

impl Piece {
    /// The polynomial for `f`, which yields value and derivative, between `a` and `b`. The derivative agrees at Chebyshev's points, which are asked
    /// for in their order: of a polynomial through the values it would lose four digits.
    fn fit(a: f64, b: f64, mut f: impl FnMut(f64) -> (f64, f64)) -> Self {
        const POINTS: usize = TERMS - 1;
        let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
        let angle = |i: usize| FRAC_PI_2 * (2 * i + 1) as f64 / POINTS as f64;
        let found: [(f64, f64); POINTS] = std::array::from_fn(|i| f(middle - half * angle(i).cosine()));
        let mut slope = [0.0; POINTS];
        // Chebyshev's polynomials T_(k-1) and T_k in powers of t.
        let (mut last, mut now) = ([0.0; POINTS], [0.0; POINTS]);
        now[0] = 1.0;
        for k in 0..POINTS {
            // T_k(-cos angle) = (-1)^k cos(k angle)
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            let sum: f64 = (0..POINTS).map(|i| found[i].1 * sign * (k as f64 * angle(i)).cosine()).sum();
            let factor = if k == 0 { 1.0 } else { 2.0 };
            for (c, t) in slope.iter_mut().zip(now) {
                *c += sum * factor / POINTS as f64 * t;
            }
            let times_t = |i: usize| if i == 0 { 0.0 } else { now[i - 1] };
            let next = std::array::from_fn(|i| factor * times_t(i) - last[i]);
            (last, now) = (now, next);
        }
        let mut coefficients: [f64; TERMS] = std::array::from_fn(|k| if k == 0 { 0.0 } else { half * slope[k - 1] / k as f64 });
        let value = |t: f64| coefficients.iter().rev().fold(0.0, |sum, c| sum * t + c);
        let off = |i: usize| found[i].0 - value(-angle(i).cosine());
        coefficients[0] = (0..POINTS).map(off).sum::<f64>() / POINTS as f64;
        Self { middle, over_half: 1.0 / half, coefficients }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bhs_core::dual::Dual;
    use glam::DVec3;

    /// Index and two derivatives by q, from the profile: with `q' = dq/dx = pi m q / r`.
    fn right(profile: &Profile, x: f64) -> (f64, [f64; 3]) {
        let q = (2.0 * profile.log_rho(x)).exp();
        let r = profile.radius(x);
        let square = (2.0 * profile.log_index(x)).exp();
        // n^2 = r^2 / q: d(n^2)/dq = n^2 (2 (dr/dl) - 2) / (2 q), as dr/dq = (dr/dl) r / (2 q).
        let lean = std::f64::consts::FRAC_2_PI * x.atan();
        let slope = -square * std::f64::consts::FRAC_2_PI * f64::atan2(1.0, x) / q;
        let lean_by_q = std::f64::consts::FRAC_2_PI / (1.0 + x * x) * r / (PI * profile.m() * q);
        let second = slope * (lean - 1.0) / q + square * lean_by_q / q - slope / q;
        (q, [square, slope, second])
    }

    #[test]
    fn pieces_agree_with_the_profile() {
        for (half, width) in [(0.5, 0.1), (0.0, 1e-4), (0.01, 1e-5), (2.0, 1.0), (0.1, 10.0)] {
            let profile = Profile::new(half, width).unwrap();
            let table = Table::new(&profile);
            let mut worst = [0.0_f64; 3];
            for i in 0..20_000 {
                let x = if i == 0 { 0.0 } else { 10.0_f64.powf(-4.0 + 13.0 * f64::from(i) / 20_000.0) };
                let (q, [square, slope, second]) = right(&profile, x);
                // The ends of the interval of q belong to the cylinder by rounding.
                let q = q.max(table.end);
                let (found, found_slope) = table.index(Dual { value: q, gradient: DVec3::X });
                worst[0] = worst[0].max((found.value / square - 1.0).abs());
                let (off, off_second) = ((found_slope.value - slope).abs(), (found_slope.gradient.x - second).abs());
                if q > table.far {
                    // There is nothing more that bends light.
                    assert!(off * q < 1e-13 && off_second * q * q < 1e-12, "{half} {width} {x}: {off} {off_second}");
                } else {
                    worst[1] = worst[1].max(off / slope.abs());
                    worst[2] = worst[2].max(off_second / second.abs().max(slope.abs() / q));
                }
                assert!((found.gradient.x / found_slope.value - 1.0).abs() < 1e-13, "the slope is that of the value");
            }
            // Places are rounded, which counts by the width of the pieces.
            let rounding = 2e-16 / profile.m().min(1.0);
            assert!(worst[0] < 1e-13 && worst[1] < 2e-14 + rounding && worst[2] < 1e-10, "{half} {width}: {worst:?}");
        }
    }
}
