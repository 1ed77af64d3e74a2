//! The seed of a render, exact.

use crate::lang::source::SourceMap;
use bhs_core::diagnostics::{Span, shorten};
use bhs_core::params::Params;
use bhs_core::sampling::mix64;

/// The largest seed that a scene or a flag may give.
pub const LARGEST_SEED: u64 = i64::MAX as u64;

/// Below this one, each whole number has a double of its own; all numbers of a scene are kept as such.
const EXACT: i64 = 1 << f64::MANTISSA_DIGITS;

/// Reads the parameter `seed`. A seed of more digits than double precision holds is read from the text itself: others that round to the
/// same number are other seeds.
pub(super) fn read(p: &Params, sources: &SourceMap) -> u64 {
    let seed = p.get("seed", 0_i64, "", "seed of all random numbers");
    if (0..EXACT).contains(&seed) {
        return seed as u64;
    }
    let brackets = |c: char| c.is_whitespace() || "[]".contains(c);
    let digits = text_at(sources, p.span_of("seed")).map(|text| text.trim_matches(brackets));
    match digits.and_then(|d| d.parse::<u64>().ok()) {
        Some(seed) if seed <= LARGEST_SEED => seed,
        _ => {
            let found = digits.map_or_else(|| seed.to_string(), shorten);
            let cause = format!("expected a whole number from 0 to {LARGEST_SEED}, found {found}");
            p.reject("seed", "`seed` is out of range", cause);
            0
        }
    }
}

/// The seed of a frame of a scene with the seed `scene`: of so many bits that double precision holds it.
pub(super) fn of_frame(scene: u64, frame: u32) -> u64 {
    mix64(mix64(scene) ^ u64::from(frame)) >> (u64::BITS - f64::MANTISSA_DIGITS)
}

fn text_at(sources: &SourceMap, span: Span) -> Option<&str> {
    sources.get(span.file)?.text.get(span.start as usize..span.end as usize)
}
