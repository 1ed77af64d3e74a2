//! Pieces of curves that are looked at in parts: how far chords of each may stray is known apart, as it differs much along a piece.

use bhs_core::real::{Mask, Real};

/// Parts of a piece.
pub const PARTS: usize = 4;

/// How much more curved than at its ends a part may be in between.
pub const BETWEEN: f64 = 1.2;

/// Of which curves the stretch between the shares `a` and `b` of the piece touches part number `i`. The first and the last part go on for ever.
#[inline(always)]
pub fn touched<F: Real>(i: usize, a: F, b: F) -> F::Mask {
    let [from, to] = [i, i + 1].map(|i| F::splat(i as f64 / PARTS as f64));
    (if i == 0 { F::Mask::ALL } else { b.gt(from) }) & (if i + 1 == PARTS { F::Mask::ALL } else { a.lt(to) })
}

/// The length of a chord that strays by `gap`, if one of the length h strays by `h^2 largest(h)` at most, where `largest` grows.
#[inline(always)]
pub fn longest<F: Real>(gap: F, largest: impl Fn(F) -> F) -> F {
    // As if all were as curved as here, if that is so as far as this goes; else as if all were as curved as what is to come.
    let hopeful = (gap / largest(F::splat(0.0))).sqrt();
    let bend = largest(hopeful);
    let careful = (gap / bend).sqrt();
    F::select((hopeful * hopeful * bend).le(gap * F::splat(1.0 + 1e-9)), hopeful, careful)
}
