//! Sums that do not depend on the order in which their terms are added: nothing is rounded away.
//!
//! Sums of floating-point numbers depend on their order, and parts of a picture are added in another one than the whole. So each sum is kept
//! as the unevaluated sum of two doubles, `hi + lo`, where `hi` is the nearest double to both together: that is exact as long as no term is less
//! than some 1e-16 of the sum. Where one is, that sum alone goes on as an expansion of as many doubles as it takes (Shewchuk, "Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates", 1997), so that it is exact always.

use crate::memory;
use std::collections::{BTreeMap, TryReserveError};

/// Exact sums, by their number.
#[derive(Clone, Debug, Default)]
pub struct ExactSums {
    /// `[hi, lo]`; a `lo` that is no number says that the sum stands in `long`. A `hi` that is not finite stays so.
    pairs: Vec<[f64; 2]>,
    /// Nonoverlapping terms, the least first, none of them 0.
    long: BTreeMap<usize, Vec<f64>>,
}

impl ExactSums {
    /// Bytes of memory that a sum takes.
    pub const BYTES: usize = size_of::<[f64; 2]>();

    /// So many sums of nothing.
    ///
    /// # Errors
    /// If there is no room for them.
    pub fn new(count: usize) -> Result<Self, TryReserveError> {
        Ok(Self { pairs: memory::filled(count, [0.0; 2])?, long: BTreeMap::new() })
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.pairs.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// How many there is memory for.
    pub fn capacity(&self) -> usize {
        self.pairs.capacity()
    }

    /// Adds a term to the sum `i`.
    #[inline]
    pub fn add(&mut self, i: usize, term: f64) {
        let [hi, lo] = self.pairs[i];
        let (sum, error) = two_sum(hi, term);
        let (low, rest) = two_sum(lo, error);
        // Not so where one of them is not finite.
        if rest == 0.0 {
            let (hi, lo) = two_sum(sum, low);
            // Beyond all doubles there is nothing left.
            self.pairs[i] = [hi, if hi.is_finite() { lo } else { 0.0 }];
        } else {
            self.add_to_long(i, term);
        }
    }

    #[cold]
    fn add_to_long(&mut self, i: usize, term: f64) {
        let [hi, lo] = self.pairs[i];
        if !(hi.is_finite() && term.is_finite()) {
            self.long.remove(&i);
            self.pairs[i] = [hi + term, 0.0];
            return;
        }
        let terms = self.long.entry(i).or_insert_with(|| [lo, hi].into_iter().filter(|t| *t != 0.0).collect());
        self.pairs[i] = [0.0, f64::NAN];
        let mut carry = term;
        let mut kept = Vec::with_capacity(terms.len() + 1);
        for own in terms.iter() {
            // In this order nothing in between is beyond all doubles where the sum is not.
            let (sum, error) = if carry.abs() < own.abs() { two_sum(*own, carry) } else { two_sum(carry, *own) };
            if error != 0.0 {
                kept.push(error);
            }
            carry = sum;
        }
        if carry != 0.0 {
            kept.push(carry);
        }
        *terms = kept;
        // Beyond all doubles.
        if !carry.is_finite() {
            self.long.remove(&i);
            self.pairs[i] = [carry, 0.0];
        }
    }

    /// The terms whose sum is the sum `i`, the least first: at most two but for rare sums.
    fn terms(&self, i: usize) -> impl Iterator<Item = f64> {
        let [hi, lo] = self.pairs[i];
        let is_long = lo.is_nan();
        let (pair, long) = match is_long {
            true => (None, self.long.get(&i)),
            false => (Some([lo, hi]), None),
        };
        pair.into_iter().flatten().chain(long.into_iter().flatten().copied()).filter(|t| *t != 0.0)
    }

    /// Adds all of the sum `j` of `other` to the sum `i`.
    pub fn add_sum(&mut self, i: usize, other: &Self, j: usize) {
        other.terms(j).for_each(|term| self.add(i, term));
    }

    /// The nearest double to the sum `i`.
    #[inline]
    pub fn value(&self, i: usize) -> f64 {
        let [hi, lo] = self.pairs[i];
        if lo.is_nan() { self.long.get(&i).map_or(0.0, |terms| rounded(terms)) } else { hi }
    }

    /// The nearest double to the sum `i`, and the nearest one to what is left.
    pub fn value_and_rest(&self, i: usize) -> [f64; 2] {
        let [hi, lo] = self.pairs[i];
        if !lo.is_nan() {
            return [hi, lo];
        }
        let value = self.value(i);
        if !value.is_finite() {
            return [value, 0.0];
        }
        let mut rest = Self { pairs: vec![[0.0; 2]], long: BTreeMap::new() };
        rest.add_sum(0, self, i);
        rest.add(0, -value);
        [value, rest.value(0)]
    }

    /// Adds them to `bytes`, exactly (little-endian): of each the number that [`ExactSums::value`] is, but 0 for the rare long ones; of each how many
    /// more terms it has, a byte; and these.
    pub fn write_to(&self, bytes: &mut Vec<u8>) {
        let is_long = |pair: &[f64; 2]| pair[1].is_nan();
        self.pairs.iter().for_each(|pair| bytes.extend_from_slice(&if is_long(pair) { 0.0 } else { pair[0] }.to_le_bytes()));
        let more = |i: usize| match &self.pairs[i] {
            [_, 0.0] => &[],
            pair if is_long(pair) => self.long.get(&i).map_or(&[][..], |terms| terms),
            pair => &pair[1..],
        };
        bytes.extend((0..self.pairs.len()).map(|i| more(i).len() as u8));
        (0..self.pairs.len()).flat_map(more).for_each(|term| bytes.extend_from_slice(&term.to_le_bytes()));
    }

    /// As many sums as there are here, from the beginning of what [`ExactSums::write_to`] has written, which is cut off; `None` if it is not that.
    pub fn read_like(&self, bytes: &mut &[u8]) -> Option<Self> {
        let mut sums = Self { pairs: Vec::with_capacity(self.len()), long: BTreeMap::new() };
        for _ in 0..self.len() {
            sums.pairs.push([f64::from_le_bytes(take(bytes)?), 0.0]);
        }
        let (counts, rest) = bytes.split_at_checked(self.len())?;
        *bytes = rest;
        for (i, count) in counts.iter().enumerate() {
            for _ in 0..*count {
                let term = Some(f64::from_le_bytes(take(bytes)?)).filter(|t| t.is_finite())?;
                sums.add(i, term);
            }
        }
        Some(sums)
    }
}

/// Cuts off the first bytes.
fn take<const N: usize>(bytes: &mut &[u8]) -> Option<[u8; N]> {
    let (first, rest) = bytes.split_first_chunk()?;
    *bytes = rest;
    Some(*first)
}

/// The nearest double to the sum of two, and what is left, which is a double (Knuth, The Art of Computer Programming 2, section 4.2.2).
#[inline]
fn two_sum(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let b_there = sum - a;
    let a_there = sum - b_there;
    (sum, (a - a_there) + (b - b_there))
}

/// The nearest double to the sum of nonoverlapping terms, the least first; of two that are as near the even one, as Python's `math.fsum` rounds.
fn rounded(terms: &[f64]) -> f64 {
    let Some((mut sum, mut rest)) = terms.split_last().map(|(last, rest)| (*last, rest)) else { return 0.0 };
    let mut error = 0.0;
    while let Some((next, lower)) = rest.split_last() {
        (sum, error) = two_sum(sum, *next);
        rest = lower;
        if error != 0.0 {
            break;
        }
    }
    // Half way between two doubles as far as `error` tells: what is below decides.
    if rest.last().is_some_and(|below| (error < 0.0 && *below < 0.0) || (error > 0.0 && *below > 0.0)) {
        let twice = 2.0 * error;
        let other = sum + twice;
        if other - sum == twice {
            return other;
        }
    }
    sum
}

/// The nearest number of `BITS` significant bits, `BITS` at most 53.
#[inline]
pub fn significant<const BITS: u32>(x: f64) -> f64 {
    let dropped = 53 - BITS;
    if !x.is_finite() || dropped == 0 {
        return x;
    }
    let bits = x.to_bits();
    let half = (1u64 << (dropped - 1)) - 1 + (bits >> dropped & 1);
    f64::from_bits((bits + half) >> dropped << dropped)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in a row, some of which cancel, over so many powers of two.
    fn terms(count: usize, exponents: i32, seed: u64) -> Vec<f64> {
        let mut random = seed;
        let mut next = move || {
            random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            random >> 33
        };
        let one = |mut next: &mut dyn FnMut() -> u64| {
            let next = &mut next;
            let mantissa = significant::<24>(next() as f64);
            let sign = if next().is_multiple_of(3) { -1.0 } else { 1.0 };
            sign * mantissa * 2f64.powi((next() % exponents as u64) as i32 - exponents / 2)
        };
        (0..count).map(|_| one(&mut next)).collect()
    }

    fn sum(terms: impl IntoIterator<Item = f64>) -> ExactSums {
        let mut sums = ExactSums::new(1).unwrap();
        terms.into_iter().for_each(|t| sums.add(0, t));
        sums
    }

    #[test]
    fn the_order_of_terms_does_not_matter() {
        let mut long = 0;
        for (exponents, seed) in
            [1, 20, 60, 100, 300, 1500].into_iter().zip(1..).cycle().take(120).zip(0..).map(|((e, s), i)| (e, s * 1000 + i))
        {
            let all = terms(300, exponents, seed);
            let forwards = sum(all.iter().copied());
            let backwards = sum(all.iter().rev().copied());
            let mut sorted = all.clone();
            sorted.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
            let (one, other) = sorted.split_at(seed as usize % 299);
            let mut joined = sum(other.iter().copied());
            joined.add_sum(0, &sum(one.iter().copied()), 0);
            for others in [&backwards, &joined] {
                let bits = |s: &ExactSums| s.value_and_rest(0).map(f64::to_bits);
                assert_eq!(bits(&forwards), bits(others), "{exponents} {seed}");
            }
            // To nothing again.
            let mut none = forwards.clone();
            all.iter().for_each(|t| none.add(0, -t));
            assert_eq!(none.value(0), 0.0);
            long += usize::from(!forwards.long.is_empty());
        }
        assert!((20..100).contains(&long), "of 120 sums {long} are long");
    }

    #[test]
    fn sums_are_the_nearest_doubles() {
        // Above 1 by half a step, and by a little more.
        let half = 2f64.powi(-53);
        assert_eq!(sum([1.0, half]).value(0), 1.0);
        assert_eq!(sum([1.0, half, 2f64.powi(-200)]).value(0), 1.0 + 2.0 * half);
        assert_eq!(sum([1.0, half, -2f64.powi(-200)]).value(0), 1.0);
        assert_eq!(sum([1e300, 1.0, 1e-300, -1e300, -1.0]).value(0), 1e-300);
    }

    #[test]
    fn what_is_not_finite_stays_so_in_any_order() {
        for all in [[f64::INFINITY, 1.0, 2.0], [1.0, f64::INFINITY, 2.0], [1.0, 2.0, f64::INFINITY]] {
            assert_eq!(sum(all).value(0), f64::INFINITY);
        }
        assert!(sum([f64::INFINITY, 1.0, f64::NEG_INFINITY]).value(0).is_nan());
        assert!(sum([1.0, f64::NAN, 1.0]).value(0).is_nan());
    }

    #[test]
    fn just_beyond_all_doubles_is_infinite_and_just_below_is_not() {
        // Half a step of the largest double: with it, the sum is nearer to the next one, which is none.
        let half = 2f64.powi(970);
        for sign in [1.0, -1.0] {
            let all = |terms: &[f64]| sum(terms.iter().map(|t| sign * t)).value(0);
            let infinite = sign * f64::INFINITY;
            for beyond in [
                &[f64::MAX, half][..],
                &[half, f64::MAX],
                &[f64::MAX, 0.5 * half, 0.5 * half],
                &[0.5 * half, 0.5 * half, f64::MAX],
                &[0.5 * half, f64::MAX, 0.5 * half],
                &[f64::MAX, 0.5 * half, 1.0, 0.5 * half],
                &[f64::MAX, f64::MAX],
                &[1.0, f64::MAX, 1.0, f64::MAX],
            ] {
                assert_eq!(all(beyond), infinite, "{beyond:?}");
            }
            assert_eq!(all(&[f64::MAX, 0.5 * half, 0.25 * half, 1e-300]), sign * f64::MAX);
            assert_eq!(all(&[f64::MAX, 0.5 * half, 1.0, -f64::MAX, -0.5 * half]), sign * 1.0);
            // What is far less, before and after.
            for k in 0..2000 {
                let x = 2f64.powi(970 - k % 60) * (1.0 + f64::from(k) / 2048.0);
                assert_eq!(all(&[-x, f64::MAX, x]), sign * f64::MAX, "{x}");
                assert_eq!(all(&[1e-3, -x, f64::MAX, x, -1e-3]), sign * f64::MAX, "{x}");
            }
        }
    }

    #[test]
    fn bytes_hold_all_of_them() {
        let mut sums = ExactSums::new(40).unwrap();
        for i in 0..40 {
            terms(50, 1 + 40 * i as i32, i as u64 + 7).into_iter().for_each(|t| sums.add(i, t));
        }
        sums.add(3, f64::INFINITY);
        let mut bytes = Vec::new();
        sums.write_to(&mut bytes);
        let again = sums.read_like(&mut &bytes[..]).unwrap();
        for i in 0..40 {
            assert_eq!(sums.value_and_rest(i).map(f64::to_bits), again.value_and_rest(i).map(f64::to_bits), "{i}");
        }
        for cut in [0, 7, 8 * 40, 9 * 40, bytes.len() - 1] {
            assert!(sums.read_like(&mut &bytes[..cut]).is_none(), "{cut}");
        }
    }

    #[test]
    fn significant_bits_are_those_of_single_precision() {
        for x in [0.0, 1.0, -1.5, 0.1, 1e-30, 3.0e38, 16_777_217.0, 16_777_219.0, -1e-20 / 3.0] {
            assert_eq!(significant::<24>(x), f64::from(x as f32), "{x}");
        }
        assert_eq!(significant::<53>(0.1), 0.1);
        assert_eq!(significant::<24>(f64::MAX), f64::INFINITY);
    }
}
