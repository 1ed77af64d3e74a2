//! Samplers: numbers in [0,1) as a pure function of (seed, pixel, sample, dimension). One file, one plugin; `amount` and `wavelengths` are shared.

mod amount;
mod independent;
mod sobol;
mod stratified;
mod wavelengths;

use bhs_core::Plugin;
use bhs_core::sampling::{Sampler, mix64};

/// All samplers, by name.
pub const ALL: &[Plugin<dyn Sampler>] = &[independent::PLUGIN, sobol::PLUGIN, stratified::PLUGIN];

/// A seed for one set of dimensions of one pixel.
fn hash(seed: u64, pixel: [u32; 2], set: u32) -> u64 {
    // Each in turn: the exclusive or of raw numbers would make neighbouring seeds share their pixels' numbers.
    mix64(mix64(mix64(seed) ^ (u64::from(pixel[0]) << 32 | u64::from(pixel[1]))) ^ u64::from(set))
}

#[cfg(test)]
mod tests {
    use super::amount::Amount;
    use bhs_core::sampling::Sampler;

    bhs_core::every_file_is_listed!([super::ALL], helpers: ["amount", "wavelengths"]);

    fn samplers() -> [(&'static str, Box<dyn Sampler>); 3] {
        [
            ("independent", Box::new(super::independent::Independent { amount: Amount::fixed(16), seed: 7 })),
            ("sobol", Box::new(super::sobol::Sobol::new(Amount::fixed(16), 7))),
            ("stratified", Box::new(super::stratified::Stratified { grid: [4, 4], jitter: true, seed: 7 })),
        ]
    }

    #[test]
    fn numbers_are_uniform_in_every_dimension_and_between_pixels() {
        for (name, sampler) in samplers() {
            for (set, k) in [(0, 0), (0, 1), (1, 2), (75, 3), (250, 0)] {
                let (mut mean, mut square) = (0.0, 0.0);
                let n = 4096;
                for i in 0..n {
                    // Over samples of one pixel in one half, over pixels in the other.
                    let x = if i % 2 == 0 { sampler.numbers([3, 4], i, set)[k] } else { sampler.numbers([i, 4], 0, set)[k] };
                    assert!((0.0..1.0).contains(&x), "{name}: {x}");
                    mean += f64::from(x) / f64::from(n);
                    square += f64::from(x * x) / f64::from(n);
                }
                assert!((mean - 0.5).abs() < 0.02 && (square - 1.0 / 3.0).abs() < 0.02, "{name} {set} {k}: {mean} {square}");
            }
        }
    }

    #[test]
    fn pairs_fill_the_square() {
        for (name, sampler) in samplers() {
            let mut cells = [0u32; 64];
            for i in 0..4096 {
                let [_, _, x, y] = sampler.numbers([9, 2], i, 6);
                cells[(x * 8.0) as usize * 8 + (y * 8.0) as usize] += 1;
            }
            let worst = cells.iter().map(|c| c.abs_diff(64)).max().unwrap_or(0);
            // Sobol points fill the cells almost evenly, independent ones within 5 standard deviations.
            let limit = if name == "sobol" { 2 } else { 40 };
            assert!(worst <= limit, "{name}: {worst}");
        }
    }

    #[test]
    fn seeds_do_not_share_numbers() {
        let first =
            |seed: u64, pixel: [u32; 2]| super::independent::Independent { amount: Amount::fixed(1), seed }.numbers(pixel, 0, 0);
        for y in 0..64 {
            for other in 0..64 {
                assert_ne!(first(7, [3, y]), first(8, [3, other]));
            }
        }
    }

    #[test]
    fn more_than_the_table_of_samples_still_differ() {
        let sobol = super::sobol::Sobol::new(Amount::fixed(16), 7);
        assert_ne!(sobol.numbers([1, 1], 0, 0), sobol.numbers([1, 1], 1 << 16, 0));
    }
}
