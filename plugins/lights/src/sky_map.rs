//! A picture of the whole sky, and how to draw directions from it by brightness.
//!
//! The picture is in a space of its own whose z axis points up. An equirectangular one has +z in its top row, +x at its left edge, and goes on
//! towards +y; one of equal areas is square, and the octahedral map of Clarberg (2008), as pbrt-v4's skies are, with +z in its middle. Pixels are patches of one radiance each, so that the density can be proportional to the radiance everywhere.

use crate::picture::Picture;
use bhs_colour::luminance;
use bhs_core::equal_area::{equal_area_direction, equal_area_point};
use bhs_core::image::Image;
use bhs_core::sampling::{Discrete, ONE_MINUS_EPSILON};
use bhs_elementary::Elementary;
use glam::{DVec2, DVec3, Vec2};
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

/// Pixels of a row that share an entry of the table of columns: it takes a quarter of a byte a pixel, and a drawing or a density adds up
/// the luminances of as many.
const BLOCK: usize = 16;

/// How directions are laid out in a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// Columns are longitudes, rows are polar angles.
    Equirectangular,
    /// Pixels have equal solid angles.
    EqualArea,
}

/// A sky. Directions are unit vectors of its own space.
pub struct SkyMap {
    /// Width and height (pixels).
    size: [usize; 2],
    layout: Layout,
    /// What it shows.
    picture: Picture,
    /// Choice of a row: by its luminance times its solid angle.
    rows: Discrete,
    /// For each row, the share of its pixels up to and including those of each block.
    blocks: Vec<f32>,
}

impl SkyMap {
    /// The sky of a picture, encoded in sRGB if it has bytes or words; all its values are finite, and negative ones count as 0.
    pub fn new(image: Arc<Image>, layout: Layout) -> Self {
        let picture = Picture::new(image);
        let [width, height] = picture.size();
        let mut map = Self { size: [width, height], layout, picture, rows: Discrete::new(Vec::new()), blocks: Vec::new() };
        let mut blocks = Vec::with_capacity(width.div_ceil(BLOCK) * height);
        let mut rows = Vec::with_capacity(height);
        let mut totals = Vec::with_capacity(width.div_ceil(BLOCK));
        for y in 0..height {
            totals.clear();
            totals.extend((0..width).step_by(BLOCK).map(|x| map.block_total(x, y)));
            let total: f64 = totals.iter().sum();
            let mut sum = 0.0;
            blocks.extend(totals.iter().map(|t| {
                sum += t;
                if total > 0.0 { (sum / total) as f32 } else { 0.0 }
            }));
            rows.push(total * map.row_solid_angle(y) / width as f64);
        }
        map.rows = Discrete::new(rows);
        map.blocks = blocks;
        map
    }

    /// The colour of a pixel, by column and row.
    #[inline]
    fn texel(&self, x: usize, y: usize) -> [f32; 3] {
        self.picture.texel(x, y)
    }

    /// The pixels of a row that share a block with column `x`.
    fn block(&self, x: usize) -> std::ops::Range<usize> {
        let first = x - x % BLOCK;
        first..(first + BLOCK).min(self.size[0])
    }

    /// The luminance of a block.
    fn block_total(&self, x: usize, y: usize) -> f64 {
        self.block(x).map(|x| luminance(self.texel(x, y))).sum()
    }

    /// The colour in a direction.
    pub fn colour(&self, direction: DVec3) -> [f32; 3] {
        let [x, y] = self.pixel(direction);
        self.texel(x, y)
    }

    /// The greatest value of red, green or blue.
    pub fn greatest(&self) -> f32 {
        self.picture.greatest()
    }

    /// The integral of the luminance over all directions.
    pub fn total(&self) -> f64 {
        self.rows.total()
    }

    /// What falls on a horizontal surface from above: the integral of luminance times cosine over the upper half.
    pub fn illuminance(&self) -> f64 {
        let [width, height] = self.size;
        if self.layout == Layout::EqualArea {
            let up = |x: usize, y: usize| equal_area_direction(self.square(x, y, [0.5; 2])).z.max(0.0);
            let pixels = (0..height).flat_map(|y| (0..width).map(move |x| (x, y)));
            let sum: f64 = pixels.map(|(x, y)| luminance(self.texel(x, y)) * up(x, y)).sum();
            return sum * 2.0 * TAU / (width * height) as f64;
        }
        let row = |y| {
            // The integral of sin cos over what part of the row lies above the horizon.
            let [top, bottom] = [y, y + 1].map(|y| (y as f64 / height as f64 * PI).min(PI / 2.0).sine());
            let mean = (0..width).map(|x| luminance(self.texel(x, y))).sum::<f64>() / width as f64;
            mean * PI * (bottom * bottom - top * top)
        };
        (0..height).map(row).sum()
    }

    /// A direction and its density per solid angle. `None` if all is black.
    pub fn sample(&self, u: Vec2) -> Option<(DVec3, f64)> {
        let [width, height] = self.size;
        let (y, v) = self.rows.sample(u.y)?;
        let n = width.div_ceil(BLOCK);
        let block = self.blocks[y * n..][..n].partition_point(|c| *c <= u.x).min(n - 1);
        let (before, share) = self.block_share(block, y);
        if share <= 0.0 {
            return None;
        }
        // The part of the block's luminance that lies before the point, and the pixel in which it ends.
        let mut rest = f64::from((u.x - before) / share) * self.block_total(block * BLOCK, y);
        let (mut x, mut own) = (0, 0.0);
        for column in self.block(block * BLOCK) {
            let l = luminance(self.texel(column, y));
            // Black pixels are never drawn, whatever roundings do.
            if l > 0.0 {
                rest -= own;
                (x, own) = (column, l);
                if rest < own {
                    break;
                }
            }
        }
        if own <= 0.0 {
            return None;
        }
        let within = ((rest / own) as f32).clamp(0.0, ONE_MINUS_EPSILON);
        if self.layout == Layout::EqualArea {
            let direction = equal_area_direction(self.square(x, y, [f64::from(within), f64::from(v)]));
            return Some((direction, self.density(x, y)));
        }
        // Evenly over the solid angle of the pixel.
        let [top, bottom] = row_cosines(y, height);
        let z = top + (bottom - top) * f64::from(v);
        let (sin, phi) = ((1.0 - z * z).max(0.0).sqrt(), TAU * (x as f64 + f64::from(within)) / width as f64);
        Some((DVec3::new(sin * phi.cosine(), sin * phi.sine(), z), self.density(x, y)))
    }

    /// The density with which [`SkyMap::sample`] draws a direction, per solid angle.
    pub fn pdf(&self, direction: DVec3) -> f64 {
        if self.total() <= 0.0 {
            return 0.0;
        }
        let [x, y] = self.pixel(direction);
        self.density(x, y)
    }

    /// The density within a pixel.
    fn density(&self, x: usize, y: usize) -> f64 {
        let [width, _] = self.size;
        let total = self.block_total(x, y);
        if total <= 0.0 {
            return 0.0;
        }
        let share = f64::from(self.block_share(x / BLOCK, y).1) * luminance(self.texel(x, y)) / total;
        self.rows.probability(y) * share * width as f64 / self.row_solid_angle(y)
    }

    /// The share of its row that lies before a block, and its own: as drawn, roundings included.
    fn block_share(&self, block: usize, y: usize) -> (f32, f32) {
        let row = &self.blocks[y * self.size[0].div_ceil(BLOCK)..];
        let before = if block == 0 { 0.0 } else { row[block - 1] };
        (before, row[block] - before)
    }

    /// Solid angle of a row.
    fn row_solid_angle(&self, y: usize) -> f64 {
        match self.layout {
            Layout::Equirectangular => row_solid_angle(y, self.size[1]),
            Layout::EqualArea => 2.0 * TAU / self.size[1] as f64,
        }
    }

    /// The point of the unit square that lies within a pixel.
    fn square(&self, x: usize, y: usize, within: [f64; 2]) -> DVec2 {
        let [width, height] = self.size;
        DVec2::new((x as f64 + within[0]) / width as f64, (y as f64 + within[1]) / height as f64)
    }

    fn pixel(&self, direction: DVec3) -> [usize; 2] {
        let [width, height] = self.size;
        if self.layout == Layout::EqualArea {
            let p = equal_area_point(direction);
            return [(p.x, width), (p.y, height)].map(|(share, n)| ((share.max(0.0) * n as f64) as usize).min(n - 1));
        }
        let phi = direction.y.arctangent2(direction.x).rem_euclid(TAU);
        // The sine, too: near the poles the cosine alone is blunt.
        let theta = direction.x.hypotenuse(direction.y).arctangent2(direction.z);
        let at = |share: f64, n: usize| ((share * n as f64) as usize).min(n - 1);
        [at(phi / TAU, width), at(theta / PI, height)]
    }
}

/// Cosines of the polar angles of a row's upper and lower edge, in a picture of `height` rows.
fn row_cosines(y: usize, height: usize) -> [f64; 2] {
    [y, y + 1].map(|y| (PI * y as f64 / height as f64).cosine())
}

/// Solid angle of a row.
fn row_solid_angle(y: usize, height: usize) -> f64 {
    let [top, bottom] = row_cosines(y, height);
    TAU * (top - bottom)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bhs_core::image::Texels;
    use bhs_core::sampling::mix64;

    fn sky(size: [usize; 2]) -> SkyMap {
        // Anything from black to a sun.
        let pixel = |i: usize| match mix64(i as u64) % 7 {
            0 => [0.0; 3],
            1 => [20.0, 10.0, 5.0],
            k => [0.1 * k as f32, 0.2, 0.05 * k as f32],
        };
        map(size, (0..size[0] * size[1]).map(pixel).collect())
    }

    fn map(size: [usize; 2], pixels: Vec<[f32; 3]>) -> SkyMap {
        SkyMap::new(Arc::new(Image::new(size.map(|s| s as u32), Texels::Floats(pixels))), Layout::Equirectangular)
    }

    fn number(i: u64) -> f32 {
        (mix64(i) >> 40) as f32 / (1u64 << 24) as f32
    }

    #[test]
    fn directions_are_drawn_with_the_density_that_is_said() {
        // Chi-square over cells that are no multiple of the pixels; expected counts from what they have in common.
        // Rows of two blocks and a half.
        let (width, height) = (37, 7);
        let map = sky([width, height]);
        let (across, down, n) = (10, 8, 400_000);
        let common = |a: [f64; 2], b: [f64; 2]| (a[1].min(b[1]) - a[0].max(b[0])).max(0.0);
        let span = |i: usize, n: usize| [i as f64 / n as f64, (i + 1) as f64 / n as f64];
        let heights = |i: usize, n: usize| span(i, n).map(|v| -(PI * v).cos());
        let mut expected = vec![0.0; across * down];
        for (i, cell) in expected.iter_mut().enumerate() {
            for k in 0..width * height {
                let phi = TAU * common(span(i % across, across), span(k % width, width));
                let z = common(heights(i / across, down), heights(k / width, height));
                *cell += luminance(map.texel(k % width, k / width)) * phi * z / map.total();
            }
        }
        let total: f64 = expected.iter().sum();
        assert!((total - 1.0).abs() < 1e-9, "{total}");
        let mut counts = vec![0.0; across * down];
        for i in 0..n {
            let Some((d, pdf)) = map.sample(Vec2::new(number(2 * i), number(2 * i + 1))) else { continue };
            assert!((pdf / map.pdf(d) - 1.0).abs() < 1e-6);
            let phi = d.y.atan2(d.x).rem_euclid(TAU);
            let theta = d.z.clamp(-1.0, 1.0).acos();
            counts[(theta / PI * down as f64) as usize * across + (phi / TAU * across as f64) as usize] += 1.0;
        }
        let chi: f64 = expected.iter().zip(&counts).map(|(e, c)| (c - e * n as f64).powi(2) / (e * n as f64)).sum();
        // 79 degrees of freedom: once in a million is 153.
        assert!(chi < 153.0, "{chi}");
    }

    #[test]
    fn the_density_follows_the_luminance() {
        let map = sky([16, 8]);
        for i in 0..1000 {
            let (z, phi) = (2.0 * f64::from(number(i)) - 1.0, TAU * f64::from(number(i + 5000)));
            let s = (1.0 - z * z).sqrt();
            let d = DVec3::new(s * phi.cos(), s * phi.sin(), z);
            let (pdf, wanted) = (map.pdf(d), luminance(map.colour(d)) / map.total());
            assert!((pdf - wanted).abs() <= 1e-5 * wanted, "{d} {pdf} {wanted}");
        }
    }

    #[test]
    fn totals_are_those_of_quadrature() {
        let map = sky([16, 9]);
        let (mut total, mut from_above, n) = (0.0, 0.0, 1440);
        for k in 0..n * n {
            let (phi, theta) = (TAU * ((k % n) as f64 + 0.5) / n as f64, PI * ((k / n) as f64 + 0.5) / n as f64);
            let (sin, cos) = theta.sin_cos();
            let y = luminance(map.colour(DVec3::new(sin * phi.cos(), sin * phi.sin(), cos))) * sin * TAU * PI / (n * n) as f64;
            total += y;
            from_above += y * cos.max(0.0);
        }
        assert!((map.total() / total - 1.0).abs() < 1e-3, "{} {total}", map.total());
        assert!((map.illuminance() / from_above - 1.0).abs() < 1e-3, "{} {from_above}", map.illuminance());
    }

    #[test]
    fn the_top_row_is_up_and_the_left_edge_is_x() {
        let pixels = (0..8).map(|i| [i as f32, 0.0, 0.0]).collect();
        let map = map([4, 2], pixels);
        let at = |x: f64, y: f64, z: f64| map.colour(DVec3::new(x, y, z).normalize())[0];
        assert_eq!([at(1.0, 0.1, 0.1), at(-0.1, 1.0, 0.1), at(-1.0, -0.1, 0.1), at(0.1, -1.0, 0.1)], [0.0, 1.0, 2.0, 3.0]);
        assert_eq!([at(1.0, 0.1, -0.1), at(0.1, -1.0, -0.1)], [4.0, 7.0]);
        let black = self::map([2, 2], vec![[0.0; 3]; 4]);
        assert_eq!((black.sample(Vec2::splat(0.5)), black.pdf(DVec3::X)), (None, 0.0));
    }
}
