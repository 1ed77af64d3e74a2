//! Means of a picture over the patch that a pixel sees: smaller pictures of it, each half as wide and high as the one before (Williams 1983, "Pyramidal
//! Parametrics"), of which those are asked whose texels are about as large as the patch.

use crate::wrap::{Wrap, index};
use bhs_elementary::Elementary;
use glam::{Vec2, Vec3};

/// The most that an ellipse may be longer than wide: its texels are counted one by one.
pub const MOST_LONGER: f32 = 64.0;

/// The exponent of the bell over an ellipse at its edge, as pbrt has it.
const BELL: f32 = 2.0;

/// How a patch is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Blur {
    /// As a square as wide as the patch is long.
    Round,
    /// As an ellipse (Heckbert 1989, "Fundamentals of Texture Mapping and Image Warping").
    Ellipse {
        /// Most that it may be longer than wide: what is thinner is made wider.
        most_longer: f32,
    },
}

/// One of the pictures: its width and height, and how to look up its texels.
struct Level<'a> {
    size: [i64; 2],
    texel: &'a dyn Fn(usize) -> Vec3,
}

/// The smaller pictures of a picture, down to one texel.
pub struct Pyramid {
    /// Width and height of the picture itself.
    size: [i64; 2],
    smaller: Vec<([i64; 2], Vec<Vec3>)>,
}

/// Width and height as numbers that places are multiplied with.
#[inline]
pub fn size_of(size: [i64; 2]) -> Vec2 {
    Vec2::new(size[0] as f32, size[1] as f32)
}

/// The mean of the four texels around a place in [0,1)^2, rows counted from the top, by how near they are.
#[inline]
pub fn bilinear(size: [i64; 2], place: Vec2, texel: impl Fn(i64, i64) -> Vec3) -> Vec3 {
    // A texel's value is that of its middle.
    let p = place * size_of(size) - 0.5;
    let (corner, f) = (p.floor(), p - p.floor());
    let (x, y) = (corner.x as i64, corner.y as i64);
    let row = |y| texel(x, y).lerp(texel(x + 1, y), f.x);
    row(y).lerp(row(y + 1), f.y)
}

impl Level<'_> {
    #[inline]
    fn texel(&self, wrap: [Wrap; 2], x: i64, y: i64) -> Vec3 {
        index(wrap, self.size, x, y).map_or(Vec3::ZERO, self.texel)
    }

    fn bilinear(&self, wrap: [Wrap; 2], place: Vec2) -> Vec3 {
        bilinear(self.size, place, |x, y| self.texel(wrap, x, y))
    }

    /// The picture at half the width and height: of an odd number of rows or columns each counts as far as it lies in the new one.
    fn halved(&self) -> ([i64; 2], Vec<Vec3>) {
        let [w, h] = self.size.map(|n| (n / 2).max(1));
        let along = |n: i64, of: i64| -> Vec<[(i64, f32); 3]> {
            let step = of as f64 / n as f64;
            (0..n)
                .map(|i| {
                    let (from, to) = (i as f64 * step, (i + 1) as f64 * step);
                    let first = from.floor() as i64;
                    std::array::from_fn(|k| {
                        let x = first + k as i64;
                        let share = (to.min((x + 1) as f64) - from.max(x as f64)).max(0.0) / step;
                        (x.min(of - 1), share as f32)
                    })
                })
                .collect()
        };
        let (columns, rows) = (along(w, self.size[0]), along(h, self.size[1]));
        let mean = |row: &[(i64, f32); 3], column: &[(i64, f32); 3]| {
            let of_row =
                |y: i64| -> Vec3 { column.iter().map(|(x, share)| (self.texel)((y * self.size[0] + x) as usize) * *share).sum() };
            row.iter().map(|(y, share)| of_row(*y) * *share).sum()
        };
        ([w, h], rows.iter().flat_map(|row| columns.iter().map(|column| mean(row, column)).collect::<Vec<_>>()).collect())
    }

    /// The mean over the ellipse with two half axes, or conjugate half diameters (texels of the first level, which is `larger` times this one), by a
    /// bell.
    fn ellipse(&self, wrap: [Wrap; 2], place: Vec2, axes: [Vec2; 2], larger: Vec2) -> Vec3 {
        // However large the ellipse is: smaller pictures there are none.
        if self.size == [1, 1] {
            return (self.texel)(0);
        }
        let middle = place * size_of(self.size) - 0.5;
        let [p, q] = axes.map(|axis| axis / larger);
        // a x^2 + b x y + c y^2 < 1, and a texel wider, so that there is one in it.
        let (a, b, c) = (p.y * p.y + q.y * q.y + 1.0, -2.0 * (p.x * p.y + q.x * q.y), p.x * p.x + q.x * q.x + 1.0);
        let f = a * c - 0.25 * b * b;
        let half = Vec2::new(c, a).map(f32::sqrt);
        let (from, to) = ((middle - half).ceil(), (middle + half).floor());
        let at_edge = (-BELL).exponential();
        let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
        for y in from.y as i64..=to.y as i64 {
            for x in from.x as i64..=to.x as i64 {
                let d = Vec2::new(x as f32, y as f32) - middle;
                let r2 = (a * d.x * d.x + b * d.x * d.y + c * d.y * d.y) / f;
                if r2 < 1.0 {
                    let weight = (-BELL * r2).exponential() - at_edge;
                    sum += self.texel(wrap, x, y) * weight;
                    weights += weight;
                }
            }
        }
        if weights > 0.0 { sum / weights } else { self.bilinear(wrap, place) }
    }
}

impl Pyramid {
    /// Of a picture of the given width and height with the texels `of`, row after row from the top.
    pub fn new([width, height]: [u32; 2], of: &dyn Fn(usize) -> Vec3) -> Self {
        let size = [width, height].map(i64::from);
        let mut smaller: Vec<([i64; 2], Vec<Vec3>)> = Vec::new();
        loop {
            let next = match smaller.last() {
                None if size == [1, 1] => break,
                None => Level { size, texel: of }.halved(),
                Some(([1, 1], _)) => break,
                Some((size, texels)) => Level { size: *size, texel: &|i| texels[i] }.halved(),
            };
            smaller.push(next);
        }
        Self { size, smaller }
    }

    /// The mean of the picture whose texels are `of` around a place in [0,1)^2, rows counted from the top, over the patch whose half axes are those that the place moves by; `None` where
    /// there is no patch that numbers can state.
    pub fn mean(&self, of: &dyn Fn(usize) -> Vec3, blur: Blur, wrap: [Wrap; 2], place: Vec2, axes: [Vec2; 2]) -> Option<Vec3> {
        let size = size_of(self.size);
        let axes = axes.map(|axis| axis * size);
        let lengths = axes.map(Vec2::length);
        let long = lengths[0].max(lengths[1]);
        if !(long.is_finite() && place.is_finite()) {
            return None;
        }
        Some(match blur {
            Blur::Round => self.between(of, (2.0 * long).logarithm2(), |level| level.bilinear(wrap, place)),
            Blur::Ellipse { most_longer } => {
                let short = lengths[0].min(lengths[1]);
                let wide = short.max(long / most_longer);
                if wide <= 0.0 {
                    return None;
                }
                let axes = if lengths[0] < lengths[1] { axes } else { [axes[1], axes[0]] };
                let across = axes[0].normalize_or_zero() * wide;
                let across = if across == Vec2::ZERO { axes[1].perp().normalize() * wide } else { across };
                let larger = |level: &Level| size / size_of(level.size);
                self.between(of, wide.logarithm2(), |level| level.ellipse(wrap, place, [across, axes[1]], larger(level)))
            }
        })
    }

    /// What `look` finds between the pictures whose texels are as large as two to the power of `level`.
    fn between(&self, of: &dyn Fn(usize) -> Vec3, level: f32, look: impl Fn(&Level) -> Vec3) -> Vec3 {
        let last = self.smaller.len();
        let level = level.clamp(0.0, last as f32);
        let (low, f) = (level as usize, level.fract());
        let at = |i: usize| match i.checked_sub(1).map(|i| &self.smaller[i]) {
            Some((size, texels)) => look(&Level { size: *size, texel: &|i| texels[i] }),
            None => look(&Level { size: self.size, texel: of }),
        };
        if f == 0.0 { at(low) } else { at(low).lerp(at(low + 1), f) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::vec2;

    const REPEAT: [Wrap; 2] = [Wrap::Repeat; 2];
    const ELLIPSE: Blur = Blur::Ellipse { most_longer: 8.0 };

    /// A number between 0 and 1 for each texel.
    fn texel(i: usize) -> Vec3 {
        Vec3::splat((i as u32).wrapping_mul(2_654_435_761) as f32 / u32::MAX as f32)
    }

    #[test]
    fn smaller_pictures_have_the_mean_of_the_picture() {
        for size in [[64, 32], [7, 5], [1, 9], [33, 64]] {
            let count = (size[0] * size[1]) as usize;
            let mean = (0..count).map(|i| f64::from(texel(i).x)).sum::<f64>() / count as f64;
            let pyramid = Pyramid::new(size, &texel);
            assert_eq!(pyramid.smaller.last().map(|level| level.0), Some([1, 1]));
            for (of, texels) in &pyramid.smaller {
                assert_eq!(texels.len() as i64, of[0] * of[1]);
                let here = texels.iter().map(|t| f64::from(t.x)).sum::<f64>() / texels.len() as f64;
                assert!((here - mean).abs() < 1e-6, "{size:?} {of:?}: {here}, {mean}");
            }
        }
        assert!(Pyramid::new([1, 1], &texel).smaller.is_empty());
    }

    /// What is left of a wave of 16 texels under a bell whose half axis along the wave is `half` (texels): the bell's Fourier transform, by the sum over
    /// a fine grid of its disk.
    fn left_under_a_bell(half: f64) -> f64 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (x, y) in (-200..=200).flat_map(|x| (-200..=200).map(move |y| (f64::from(x) / 200.0, f64::from(y) / 200.0))) {
            let weight = ((-2.0 * (x * x + y * y)).exp() - (-2.0_f64).exp()).max(0.0);
            sum += weight * (std::f64::consts::TAU / 16.0 * half * x).cos();
            weights += weight;
        }
        sum / weights
    }

    #[test]
    fn what_is_thin_is_blurred_along_itself_alone() {
        let size = 256_i64;
        let wave = |i: usize| Vec3::splat(((i as i64 % size) as f32 * std::f32::consts::TAU / 16.0).sin() * 0.5 + 0.5);
        let pyramid = Pyramid::new([size as u32; 2], &wave);
        let at = |blur, axes: [Vec2; 2]| {
            let found = (0..64).map(|i| {
                let place = vec2(i as f32 / 256.0 + 0.5 / 256.0, 0.4);
                pyramid.mean(&wave, blur, REPEAT, place, axes.map(|a| a / 256.0)).expect("a patch").x
            });
            // What is left of the wave.
            found.fold([f32::MAX, f32::MIN], |[lo, hi], x| [lo.min(x), hi.max(x)])
        };
        let left = |blur, axes| {
            let [lo, hi] = at(blur, axes);
            hi - lo
        };
        let (along, across) = ([vec2(8.0, 0.0), vec2(0.0, 1.0)], [vec2(1.0, 0.0), vec2(0.0, 8.0)]);
        // A texel wider than the patch.
        for (axes, half) in [(along, 65_f64.sqrt()), (across, 2_f64.sqrt())] {
            let (found, expected) = (left(ELLIPSE, axes), left_under_a_bell(half) as f32);
            assert!((found - expected).abs() < 0.03, "{axes:?}: {found}, expected {expected}");
        }
        // Whichever of the two is named first.
        assert_eq!(left(ELLIPSE, along), left(ELLIPSE, [along[1], along[0]]));
        // A square as wide as the patch is long knows no direction.
        assert!(left(Blur::Round, across) < 0.3 && left(Blur::Round, along) < 0.3);
        // Texels larger than pixels are not blurred by more than their own width.
        assert!(left(Blur::Round, [vec2(0.3, 0.0), vec2(0.0, 0.3)]) > 0.95);
    }

    #[test]
    fn patches_of_any_size_and_shape_have_a_mean_between_the_texels() {
        let pyramid = Pyramid::new([37, 21], &texel);
        let sizes = [0.0, 1e-30, 1e-6, 1e-3, 0.1, 3.0, 1e9, 1e30, f32::INFINITY, f32::NAN];
        for (i, a) in sizes.iter().enumerate() {
            for (k, b) in sizes.iter().enumerate() {
                for blur in [Blur::Round, ELLIPSE, Blur::Ellipse { most_longer: MOST_LONGER }] {
                    let axes = [vec2(*a, 0.3 * b), vec2(-b, 0.1 * a)];
                    let found = pyramid.mean(&texel, blur, [Wrap::Clamp; 2], vec2(0.1 * i as f32, 0.1 * k as f32), axes);
                    let lengths = axes.map(|axis| (axis * vec2(37.0, 21.0)).length());
                    let has_length = lengths.iter().all(|length| length.is_finite()) && lengths != [0.0; 2];
                    assert!(found.is_some() || !has_length || blur == Blur::Round, "{a} {b} {blur:?}");
                    assert!(found.is_none_or(|v| (0.0..=1.0 + 1e-6).contains(&v.x)), "{a} {b} {blur:?} {found:?}");
                }
            }
        }
    }
}
