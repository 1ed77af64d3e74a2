//! Pictures of light: how lights read them, and their texels as light.

use bhs_colour::srgb_decode;
use bhs_core::diagnostics::{Diagnostic, Spanned};
use bhs_core::image::{Image, Texels};
use bhs_core::params::Params;
use glam::{Vec2, Vec3};
use std::sync::Arc;

/// A picture whose texels are light, red, green and blue; encoded in sRGB if it has bytes or words. Negative values count as 0.
pub struct Picture {
    /// As it was read: a large one is kept once only.
    image: Arc<Image>,
    /// The light of each value of a byte or of a word; empty for a picture of light.
    light: Vec<f32>,
}

impl Picture {
    /// The light of `image`, all of whose values are finite.
    pub fn new(image: Arc<Image>) -> Self {
        let values = match &image.texels {
            Texels::Bytes(_) => 1 << 8,
            Texels::Words(_) => 1 << 16,
            Texels::Floats(_) => 0,
        };
        let light = (0..values).map(|i| srgb_decode(i as f32 / (values - 1) as f32)).collect();
        Self { image, light }
    }

    /// Width and height (texels).
    pub fn size(&self) -> [usize; 2] {
        [self.image.width as usize, self.image.height as usize]
    }

    /// The colour of a texel, by column and row from the top.
    #[inline]
    pub fn texel(&self, x: usize, y: usize) -> [f32; 3] {
        let i = y * self.image.width as usize + x;
        match &self.image.texels {
            Texels::Bytes(t) => t[i].map(|v| self.light[usize::from(v)]),
            Texels::Words(t) => t[i].map(|v| self.light[usize::from(v)]),
            Texels::Floats(t) => t[i].map(|v| v.max(0.0)),
        }
    }

    /// The greatest value of red, green or blue.
    pub fn greatest(&self) -> f32 {
        let [width, height] = self.size();
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| self.texel(x, y)));
        texels.flatten().fold(0.0, f32::max)
    }

    /// The mean luminance of all texels.
    pub fn mean_luminance(&self) -> f64 {
        let [width, height] = self.size();
        let texels = (0..height).flat_map(|y| (0..width).map(move |x| self.texel(x, y)));
        texels.map(bhs_colour::luminance).sum::<f64>() / (width * height) as f64
    }

    /// The colour at texture coordinates, bilinear; (0, 0) is the lower left corner, and outside the edge goes on.
    pub fn at(&self, uv: Vec2) -> [f32; 3] {
        let size = self.size();
        // A texel's value is that of its middle; rows are counted from the top.
        let p = Vec2::new(uv.x, 1.0 - uv.y) * Vec2::new(size[0] as f32, size[1] as f32) - 0.5;
        let (corner, f) = (p.floor(), p - p.floor());
        let within = |v: f32, n: usize| (v.max(0.0) as usize).min(n - 1);
        let texel = |dx: f32, dy: f32| Vec3::from(self.texel(within(corner.x + dx, size[0]), within(corner.y + dy, size[1])));
        let row = |dy| texel(0.0, dy).lerp(texel(1.0, dy), f.x);
        row(0.0).lerp(row(1.0), f.y).to_array()
    }
}

/// Reads the picture that the parameter `filename` names; says what is to be said of it.
pub fn read(p: &Params, filename: String) -> Option<Arc<Image>> {
    let span = p.span_of("filename");
    let path = Spanned::new(filename, span);
    let image = match p.context().named.image(&path, p.context()) {
        Ok(image) => image,
        Err(why) => {
            p.report(Diagnostic::error("bad-file", format!("cannot read `{}`: {why}", path.value)).at(span, ""));
            return None;
        }
    };
    for note in image.notes.iter().chain(&image.encoding_note) {
        p.report(Diagnostic::warning("picture-note", format!("`{}`: {note}", path.value)).at(span, ""));
    }
    let negative = match &image.texels {
        Texels::Floats(t) => t.as_flattened().iter().filter(|v| **v < 0.0).count(),
        _ => 0,
    };
    if negative > 0 {
        let message = format!("`{}` is taken as 0 where it is negative: {negative} values", path.value);
        p.report(Diagnostic::warning("negative-light", message).at(span, "light cannot be negative"));
    }
    Some(image)
}
