//! From the linear colours of a picture to those of a screen: what `bhs render` and `bhs develop` both do, so that both write the same bytes.
//!
//! Glare (`crate::bloom`), white balance, exposure, tone curve, sRGB; formulas: docs/develop.md. What is decided by the picture itself (`auto`) is decided by the
//! numbers of its EXR file.

pub mod auto;
pub mod channels;
pub mod input;
mod texts;

use bhs_elementary::Elementary;
pub use texts::Texts;

use crate::bloom;
use crate::false_color::FalseColor;
use crate::image::{self, Picture};
use crate::layers::LayerPicture;
use crate::look::{Bits, Exposure, Look, White};
use anyhow::Result;
use bhs_colour::{Matrix, ToneCurve, balance_of, balance_of_colour, srgb_encode, times};
use bhs_textures::decode::exr_parts::{self, Shown, ShownColours};
use channels::Found;
use exr::meta::attribute::Chromaticities;
use std::borrow::Cow;
use std::io::Write;

/// A look with all that the picture decides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Developer {
    /// Brightness (stops).
    pub stops: f64,
    scale: f32,
    balance: Option<Matrix>,
    curve: ToneCurve,
}

impl Developer {
    /// That of a picture whose first three channels are red, green and blue.
    pub fn new(look: &Look, picture: &Picture) -> Self {
        let balance = match look.white {
            White::Kelvin(kelvin) => balance_of(kelvin),
            White::Auto => auto::white(picture).and_then(balance_of_colour),
        };
        let stops = match look.exposure {
            Exposure::Stops(stops) => stops,
            Exposure::Auto => auto::stops(picture).unwrap_or(0.0),
        };
        Self { stops, scale: 2f32.power(stops as f32), balance, curve: look.curve }
    }

    /// The colour on a screen (sRGB, encoded, 0 to 1) of linear red, green and blue.
    #[inline]
    pub fn display(&self, rgb: [f32; 3]) -> [f32; 3] {
        let rgb = rgb.map(f64::from);
        let rgb = self.balance.map_or(rgb, |m| times(m, rgb));
        let most = rgb.iter().fold(0.0f64, |most, x| most.max(x.abs())) * f64::from(self.scale);
        let scaled = match most > f64::from(f32::MAX) && most.is_finite() {
            false => rgb.map(|x| x as f32 * self.scale),
            // Brighter than single precision can say, where the ratios would be lost: as bright as it can.
            true => rgb.map(|x| (x * f64::from(self.scale) * (f64::from(f32::MAX) / most)) as f32),
        };
        self.curve.apply(scaled).map(srgb_encode)
    }
}

/// What a PNG file shows.
pub enum Content<'p> {
    /// Colours: the first three channels.
    Colours(Cow<'p, Picture>),
    /// A layer in false colours, and the size of the picture.
    FalseColor(LayerPicture, [usize; 2]),
}

impl Content<'_> {
    /// Some channels of a picture, and what was odd about them; `chromaticities` are those of its colours, sRGB if not given.
    pub fn of(all: &Picture, found: &Found, chromaticities: Option<Chromaticities>, false_color: bool) -> (Self, Vec<String>) {
        if false_color {
            return (Self::FalseColor(all.layer(found), all.size), Vec::new());
        }
        let (picture, notes) = colours(all, found.shown(), chromaticities);
        (Self::Colours(Cow::Owned(picture)), notes)
    }

    /// Width and height (pixels).
    pub fn size(&self) -> [usize; 2] {
        match self {
            Self::Colours(picture) => picture.size,
            Self::FalseColor(_, size) => *size,
        }
    }

    /// Red, green and blue of all pixels as the PNG file has them, row by row from the top: a byte each, or two with 16 bits, the higher one first; false
    /// colours have 8 bits.
    pub fn pixels(&self, look: &Look) -> Vec<u8> {
        match self {
            Self::Colours(picture) => {
                let developing = Developing::new(look, picture);
                let mut bytes = Vec::new();
                (0..picture.size[1]).for_each(|y| developing.push_row(y, &mut bytes));
                bytes
            }
            Self::FalseColor(layer, _) => FalseColor::new(layer).pixels().into_flattened(),
        }
    }

    /// Writes it as PNG.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write(&self, to: impl Write, look: &Look, texts: &Texts) -> Result<()> {
        match self {
            Self::Colours(picture) => write_png(to, picture, look, texts),
            Self::FalseColor(layer, size) => write_false_color(to, *size, &FalseColor::new(layer), texts),
        }
    }
}

/// Some channels of a picture as red, green and blue, and what was odd about them.
pub fn colours(all: &Picture, shown: Shown, chromaticities: Option<Chromaticities>) -> (Picture, Vec<String>) {
    let ShownColours { values, notes } = exr_parts::colours(&all.data, all.channels.len(), shown, chromaticities);
    (Picture { channels: ["R", "G", "B"].map(str::to_owned).to_vec(), data: values, ..*all }, notes)
}

/// A picture with its glare, about to be shown.
struct Developing<'p> {
    picture: Cow<'p, Picture>,
    developer: Developer,
    bits: Bits,
}

impl<'p> Developing<'p> {
    fn new(look: &Look, picture: &'p Picture) -> Self {
        let developer = Developer::new(look, picture);
        Self { picture: bloom::with_glare(picture, look.bloom), developer, bits: look.bits }
    }

    /// Appends the bytes of row `y`.
    fn push_row(&self, y: usize, row: &mut Vec<u8>) {
        let channels = self.picture.channels.len();
        let width = self.picture.size[0] * channels;
        for pixel in self.picture.data[y * width..][..width].chunks_exact(channels) {
            let colour = self.developer.display([pixel[0], pixel[1], pixel[2]]);
            match self.bits {
                Bits::Eight => row.extend(colour.map(|v| (v * 255.0 + 0.5) as u8)),
                Bits::Sixteen => colour.into_iter().for_each(|v| row.extend(((v * 65_535.0 + 0.5) as u16).to_be_bytes())),
            }
        }
    }
}

/// Writes a picture, whose first three channels are red, green and blue, as PNG.
///
/// # Errors
/// If it cannot be written.
pub fn write_png(to: impl Write, picture: &Picture, look: &Look, texts: &Texts) -> Result<()> {
    let developing = Developing::new(look, picture);
    let texts = texts.with_look(look, &developing.developer);
    let sixteen_bits = look.bits == Bits::Sixteen;
    image::write_rows(to, picture.size, sixteen_bits, texts.all(), |y, row| developing.push_row(y, row))
}

/// Writes a layer in false colours as PNG.
///
/// # Errors
/// If it cannot be written.
pub fn write_false_color(to: impl Write, size: [usize; 2], colors: &FalseColor, texts: &Texts) -> Result<()> {
    let pixels = colors.pixels();
    image::write_rows(to, size, false, texts.with_layer(colors).all(), |y, row| {
        row.extend_from_slice(pixels[y * size[0]..][..size[0]].as_flattened());
    })
}
