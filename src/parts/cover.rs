//! What a part of a picture covers: samples of a window.

use bhs_core::camera::{Film, Look};
use bhs_core::spectrum::{SampledSpectrum, SampledWavelengths};
use serde_json::{Value, json};
use std::fmt;

/// Some samples of all pixels of a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cover {
    /// x0, x1, y0, y1 in the whole frame (pixels), x1 and y1 excluded.
    pub window: [u32; 4],
    /// The first sample, and the one after the last.
    pub samples: [u32; 2],
}

impl Cover {
    /// All samples of a film.
    pub fn whole(film: &dyn Film, samples: u32) -> Self {
        Self { window: film.crop(), samples: [0, samples] }
    }

    /// Samples of all pixels together.
    pub fn size(&self) -> u64 {
        let [x0, x1, y0, y1] = self.window;
        u64::from(x1 - x0) * u64::from(y1 - y0) * u64::from(self.samples[1] - self.samples[0])
    }

    /// Ends of columns, rows and samples.
    fn sides(&self) -> [[u32; 2]; 3] {
        let [x0, x1, y0, y1] = self.window;
        [[x0, x1], [y0, y1], self.samples]
    }

    /// `None` if it holds nothing.
    fn of_sides([[x0, x1], [y0, y1], samples]: [[u32; 2]; 3]) -> Option<Self> {
        (x0 < x1 && y0 < y1 && samples[0] < samples[1]).then_some(Self { window: [x0, x1, y0, y1], samples })
    }

    /// What two have in common.
    pub fn common(&self, other: &Self) -> Option<Self> {
        let (own, others) = (self.sides(), other.sides());
        Self::of_sides(std::array::from_fn(|i| [own[i][0].max(others[i][0]), own[i][1].min(others[i][1])]))
    }

    /// What is left of it without `other`: samples before and after, and what lies around it at the same samples.
    fn without(&self, other: &Self, left: &mut Vec<Self>) {
        let Some(common) = self.common(other) else {
            left.push(*self);
            return;
        };
        let (mut rest, cut) = (self.sides(), common.sides());
        for side in [2, 1, 0] {
            for [from, to] in [[rest[side][0], cut[side][0]], [cut[side][1], rest[side][1]]] {
                let mut piece = rest;
                piece[side] = [from, to];
                left.extend(Self::of_sides(piece));
            }
            rest[side] = cut[side];
        }
    }

    /// What is left of it without all of `others`, in order, the pieces joined where that makes one.
    pub fn missing<'c>(&self, others: impl Iterator<Item = &'c Self>) -> Vec<Self> {
        let mut left = vec![*self];
        for other in others {
            let mut next = Vec::with_capacity(left.len());
            left.iter().for_each(|piece| piece.without(other, &mut next));
            left = next;
        }
        join(left)
    }

    /// As JSON.
    pub(super) fn to_json(self) -> Value {
        json!({ "window": self.window, "samples": self.samples })
    }

    /// From JSON; `None` if it is none, or holds nothing.
    pub(super) fn from_json(value: &Value) -> Option<Self> {
        let numbers = |name: &str| -> Option<Vec<u32>> {
            value[name].as_array()?.iter().map(|n| n.as_u64().and_then(|n| n.try_into().ok())).collect()
        };
        let (window, samples) = (numbers("window")?, numbers("samples")?);
        let ([x0, x1, y0, y1], [from, to]) = (window[..].try_into().ok()?, samples[..].try_into().ok()?);
        Self::of_sides([[x0, x1], [y0, y1], [from, to]])
    }
}

impl fmt::Display for Cover {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let ([x0, x1, y0, y1], [from, to]) = (self.window, self.samples);
        write!(f, "samples {from}..{to} of the window x {x0}..{x1}, y {y0}..{y1}")
    }
}

/// Pieces that differ in one side alone, where they meet, become one, as long as there are such.
fn join(mut pieces: Vec<Cover>) -> Vec<Cover> {
    loop {
        let before = pieces.len();
        for side in 0..3 {
            let others = |c: &Cover| (0..3).filter(|i| *i != side).map(|i| c.sides()[i]).collect::<Vec<_>>();
            pieces.sort_by_key(|c| (others(c), c.sides()[side]));
            let mut joined: Vec<Cover> = Vec::with_capacity(pieces.len());
            for piece in pieces {
                let last =
                    joined.last_mut().filter(|l| others(l) == others(&piece) && l.sides()[side][1] == piece.sides()[side][0]);
                match last {
                    Some(last) => {
                        let mut sides = last.sides();
                        sides[side][1] = piece.sides()[side][1];
                        *last = Cover::of_sides(sides).unwrap_or(*last);
                    }
                    None => joined.push(piece),
                }
            }
            pieces = joined;
        }
        if pieces.len() == before {
            pieces.sort_by_key(|c| (c.samples, c.window[2], c.window[0]));
            return pieces;
        }
    }
}

/// A film of which a window is rendered.
pub struct Windowed<'f> {
    film: &'f dyn Film,
    window: [u32; 4],
}

impl<'f> Windowed<'f> {
    /// The given window of a film.
    pub fn new(film: &'f dyn Film, window: [u32; 4]) -> Self {
        Self { film, window }
    }
}

impl Film for Windowed<'_> {
    fn resolution(&self) -> [u32; 2] {
        self.film.resolution()
    }

    fn crop(&self) -> [u32; 4] {
        self.window
    }

    fn filename(&self) -> &str {
        self.film.filename()
    }

    fn lambda_range(&self) -> [f32; 2] {
        self.film.lambda_range()
    }

    fn channels(&self) -> Vec<String> {
        self.film.channels()
    }

    #[inline]
    fn add(&self, radiance: SampledSpectrum, lambda: &SampledWavelengths, sums: &mut [f64]) {
        self.film.add(radiance, lambda, sums);
    }

    #[inline]
    fn limited(&self, radiance: SampledSpectrum, lambda: &SampledWavelengths) -> SampledSpectrum {
        self.film.limited(radiance, lambda)
    }

    fn look(&self) -> Look {
        self.film.look()
    }

    fn bloom(&self) -> f64 {
        self.film.bloom()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cover(x: [u32; 2], y: [u32; 2], samples: [u32; 2]) -> Cover {
        Cover { window: [x[0], x[1], y[0], y[1]], samples }
    }

    #[test]
    fn what_is_missing_is_all_that_is_not_there() {
        let whole = cover([2, 9], [1, 7], [0, 5]);
        let some = [cover([2, 5], [1, 7], [0, 2]), cover([5, 9], [1, 4], [1, 5]), cover([2, 3], [2, 3], [2, 4])];
        let left = whole.missing(some.iter());
        for (x, y, s) in (2..9).flat_map(|x| (1..7).flat_map(move |y| (0..5).map(move |s| (x, y, s)))) {
            let one = cover([x, x + 1], [y, y + 1], [s, s + 1]);
            let holds = |all: &[Cover]| all.iter().filter(|c| c.common(&one).is_some()).count();
            assert_eq!(holds(&some) + holds(&left), 1, "{x} {y} {s}");
        }
        assert!(whole.missing([whole].iter()).is_empty());
        assert_eq!(whole.missing([].iter()), [whole]);
    }

    #[test]
    fn pieces_that_make_one_are_said_as_one() {
        let whole = cover([0, 8], [0, 8], [0, 64]);
        let parts: Vec<Cover> = (0..64).flat_map(|s| [[0, 3], [3, 8]].map(|y| cover([0, 8], y, [s, s + 1]))).collect();
        let there = parts.iter().filter(|c| !(16..32).contains(&c.samples[0]));
        assert_eq!(whole.missing(there), [cover([0, 8], [0, 8], [16, 32])]);
        assert_eq!(Cover::from_json(&whole.to_json()), Some(whole));
    }
}
