//! Wavelengths of samples, spread over a pixel's samples and over neighbouring pixels.
//!
//! A sample carries four wavelengths, at the numbers u, u + 1/4, u + 1/2 and u + 3/4 (modulo 1) of the cumulated density. What decides the noise of
//! colours is therefore `4 u mod 1`; what decides it where one wavelength alone goes on (dispersion) is u. The samples of a pixel are spread in
//! both: `4 u mod 1` is the radical inverse of their number, and the two bits before it are those of the second Sobol sequence, so that 2^m samples
//! have one in each of 2^m parts of the range of u, and of that of `4 u mod 1` (Sobol 1967; van der Corput 1935). From pixel to pixel u is shifted
//! by a lattice of rank 1 (Cranley and Patterson 1976), whose waves, and their multiples that 1, 2 and 4 samples leave, are short: a
//! neighbourhood has the wavelengths that a pixel lacks.

use bhs_core::sampling::{mix64, unit_f32};

/// Shift of u from a pixel to the next one to the right, and below (2^-32): 0.35067983 and 0.55928699. The 1st, 2nd, 3rd, 4th, 8th, 12th and 16th
/// multiples of this wave have at least 0.32 periods a pixel, by a search over random ones; the 1st, 4th and 8th, of one and two samples, 0.46.
const SHIFTS: [u32; 2] = [1_506_158_402, 2_402_119_335];

/// The shift of u in a pixel, uniform over seeds (2^-32).
pub fn shift(seed: u64, pixel: [u32; 2]) -> u32 {
    let first = (mix64(seed ^ 0x5741_5645_4c45_4e47) >> 32) as u32;
    first.wrapping_add(pixel[0].wrapping_mul(SHIFTS[0])).wrapping_add(pixel[1].wrapping_mul(SHIFTS[1]))
}

/// u of sample `index` of a pixel, of any number of samples.
#[inline]
pub fn progressive(seed: u64, pixel: [u32; 2], index: u32) -> f32 {
    // The first two digits of the second Sobol sequence: the parity of all bits, and that of every other one.
    let quarter = (index.count_ones() & 1) << 1 | (index & 0xaaaa_aaaa).count_ones() & 1;
    unit_f32((quarter << 30 | index.reverse_bits() >> 2).wrapping_add(shift(seed, pixel)))
}

/// u of the sample that is number `place` of `count` by u: multiples of `1 / count`, moved so that `4 u mod 1` has one in each of `count` parts too.
#[inline]
pub fn of_count(seed: u64, pixel: [u32; 2], place: u32, count: u32) -> f32 {
    // `4 u mod 1` of multiples of 1/count comes back to the same numbers `common` times; each time it is moved by one part more.
    let common = if count.is_multiple_of(4) { 4 } else { 2 - count % 2 };
    let moved = u64::from(place) * u64::from(common) / u64::from(count);
    let u = ((4 * u64::from(place) + moved) << 30) / u64::from(count);
    unit_f32((u as u32).wrapping_add(shift(seed, pixel)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Whether each of as many equal parts as there are numbers has one of them, in fixed point (2^-24), whatever shift they share.
    fn one_in_each_part(numbers: impl Iterator<Item = u32>) -> bool {
        let mut numbers: Vec<u32> = numbers.collect();
        numbers.sort_unstable();
        let part = f64::from(1 << 24) / numbers.len() as f64;
        let least = f64::from(numbers[0]);
        numbers.iter().enumerate().all(|(i, n)| ((f64::from(*n) - least) / part - i as f64).abs() < 1.0 - 1e-4)
    }

    fn check(name: &str, all: &[f32]) {
        let fixed = |u: f32| (u * 16_777_216.0) as u32;
        assert!(all.iter().all(|u| (0.0..1.0).contains(u)));
        // Equal steps need no grid: all are shifted together, so only the distances count.
        assert!(one_in_each_part(all.iter().map(|u| fixed(u * 4.0 % 1.0))), "{name}: {} samples, 4 u", all.len());
        assert!(one_in_each_part(all.iter().map(|u| fixed(*u))), "{name}: {} samples, u", all.len());
    }

    #[test]
    fn powers_of_two_have_one_in_each_part() {
        for m in 0..10 {
            // Without the shift, which wraps the parts of u as they lie.
            let all: Vec<f32> = (0..1 << m)
                .map(|i| {
                    let u = progressive(7, [3, 4], i) - unit_f32(shift(7, [3, 4]));
                    if u < 0.0 { u + 1.0 } else { u }
                })
                .collect();
            check("progressive", &all);
        }
    }

    #[test]
    fn any_count_has_one_in_each_part() {
        for count in [1, 2, 3, 4, 5, 6, 7, 8, 12, 15, 16, 18, 100, 128, 1000] {
            let all: Vec<f32> = (0..count)
                .map(|place| of_count(0, [0, 0], place, count))
                .map(|u| (u - unit_f32(shift(0, [0, 0]))).rem_euclid(1.0))
                .collect();
            check("of_count", &all);
        }
    }

    /// The mean over a few neighbouring pixels of waves of u that so many samples leave: independent numbers would leave an
    /// eighth.
    #[test]
    fn neighbours_have_what_a_pixel_lacks() {
        for (samples, wave) in [(1, 1), (1, 4), (2, 8), (4, 16)] {
            let mut sum = [0.0; 2];
            for (x, y) in (0..8).flat_map(|y| (0..8).map(move |x| (x, y))) {
                for i in 0..samples {
                    let phase = f64::from(progressive(1, [100 + x, 40 + y], i)) * f64::from(wave) * std::f64::consts::TAU;
                    sum[0] += phase.cos() / (64.0 * f64::from(samples));
                    sum[1] += phase.sin() / (64.0 * f64::from(samples));
                }
            }
            assert!(sum[0].hypot(sum[1]) < 1.0 / 24.0, "{samples} {wave}: {sum:?}");
        }
    }
}
