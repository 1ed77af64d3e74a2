//! Vectors of several rays side by side: one arithmetic operation for all of them.
//!
//! Pictures have the same bits whatever vectors the program is built for. Of what `wide` offers, only operations that are rounded once, or not at all, are
//! used therefore: where a processor has more, its sums over lanes are of another order, and the last digits of its functions (`exp`, `sin_cos`, `atan2`) others.
//! Those of single numbers are taken lane by lane.

use wide::f64x8;

/// Rays that are followed side by side.
pub const LANES: usize = 8;

/// A number of each ray; or a yes or no of each, all bits set or none.
pub type Lanes = f64x8;

/// Nothing but no.
pub fn none() -> Lanes {
    Lanes::splat(0.0)
}

/// Yes of the first `count` rays.
pub fn first(count: usize) -> Lanes {
    let numbers = Lanes::from(std::array::from_fn::<f64, LANES, _>(|i| i as f64));
    numbers.simd_lt(Lanes::splat(count as f64))
}

/// Yes of the rays whose bits are set.
pub fn of_bits(bits: u32) -> Lanes {
    // All bits of a lane, or none.
    Lanes::from(std::array::from_fn::<f64, LANES, _>(|i| f64::from_bits(0_u64.wrapping_sub(u64::from(bits) >> i & 1))))
}

/// The sum of the numbers, from the first: in the same order whatever the processor.
pub fn total(numbers: Lanes) -> f64 {
    numbers.to_array().iter().sum()
}

/// The numbers of the bits that are set, from the lowest.
pub fn set_bits(mut bits: u32) -> impl Iterator<Item = usize> {
    std::iter::from_fn(move || {
        let i = bits.trailing_zeros() as usize;
        (i < LANES).then(|| {
            bits &= bits - 1;
            i
        })
    })
}

/// Of the rays in `which` the numbers `yes`, of the others `no`.
#[inline(always)]
pub fn pick(which: Lanes, yes: Lanes, no: Lanes) -> Lanes {
    which.select(yes, no)
}
