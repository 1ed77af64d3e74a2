//! Pictures in memory, and their EXR and PNG files.

use anyhow::{Context, Result, bail};
use exr::meta::attribute::{AttributeValue, Chromaticities, Matrix4x4};
use exr::prelude as exrs;
use std::io::Write;
use std::path::Path;

/// A picture of any number of channels, 32-bit floats.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width and height (pixels).
    pub size: [usize; 2],
    /// Offset of the picture in the whole frame, and the frame's size (pixels).
    pub frame: Frame,
    /// Names of the channels.
    pub channels: Vec<String>,
    /// Values, row by row from the top, channels of a pixel together.
    pub data: Vec<f32>,
}

/// Where a picture lies in its frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frame {
    /// Column and row of the picture's first pixel.
    pub offset: [usize; 2],
    /// Width and height of the frame.
    pub size: [usize; 2],
}

/// The value of an attribute of an EXR file.
#[derive(Clone, Debug, PartialEq)]
pub enum Attribute {
    /// Words.
    Text(String),
    /// A number.
    Number(f64),
    /// A number that OpenEXR keeps in single precision.
    Single(f32),
    /// A matrix for row vectors, row by row: points are multiplied from the left, as OpenEXR and Imath do.
    Matrix(Matrix4x4),
    /// Primaries and white of red, green and blue.
    Chromaticities(Chromaticities),
}

impl Attribute {
    /// Puts it into the header of a picture that is about to be written, under `name`.
    pub(crate) fn put_into<C>(&self, image: &mut exrs::Image<exrs::Layer<C>>, name: &str) {
        let layer = &mut image.layer_data.attributes;
        match (name, self) {
            ("chromaticities", Self::Chromaticities(c)) => image.attributes.chromaticities = Some(*c),
            ("worldToCamera", Self::Matrix(m)) => layer.world_to_camera = Some(*m),
            ("worldToNDC", Self::Matrix(m)) => layer.world_to_normalized_device = Some(*m),
            ("capDate", Self::Text(t)) => layer.capture_date = Some(text(t)),
            ("utcOffset", Self::Single(x)) => layer.utc_offset = Some(*x),
            ("comments", Self::Text(t)) => layer.comments = Some(text(t)),
            (name, other) => {
                let value = match other {
                    Self::Text(t) => AttributeValue::Text(text(t)),
                    Self::Number(x) => AttributeValue::F64(*x),
                    Self::Single(x) => AttributeValue::F32(*x),
                    Self::Matrix(m) => AttributeValue::Matrix4x4(*m),
                    Self::Chromaticities(c) => AttributeValue::Chromaticities(*c),
                };
                layer.other.insert(name.into(), value);
            }
        }
    }
}

/// Words as OpenEXR keeps them, which has one byte a character: others are written as `\u{...}`, and then backslashes too, so that [`said`] reads what was
/// written.
fn text(words: &str) -> exr::meta::attribute::Text {
    use exr::meta::attribute::Text;
    let fits = |c: char| u8::try_from(c as u32).is_ok();
    let escaped = |c: char| if fits(c) && c != '\\' { c.to_string() } else { c.escape_unicode().to_string() };
    let plain = Some(words).filter(|words| words.chars().all(fits) && !words.contains("\\u{"));
    let words = plain.map_or_else(|| words.chars().map(escaped).collect(), str::to_owned);
    Text::new_or_none(words).unwrap_or_else(|| "".into())
}

/// The words that a text of a file means.
fn said(text: &str) -> String {
    let mut parts = text.split("\\u{");
    let mut said = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let escaped = part.split_once('}').and_then(|(digits, rest)| {
            let c = u32::from_str_radix(digits, 16).ok().and_then(char::from_u32)?;
            Some((c, rest))
        });
        match escaped {
            Some((c, rest)) => {
                said.push(c);
                said.push_str(rest);
            }
            // Somebody else's.
            None => {
                said.push_str("\\u{");
                said.push_str(part);
            }
        }
    }
    said
}

/// A value as files keep it: the largest number of its sign in place of what is larger, and 0 for what is no number. Where that happens,
/// [`crate::film::Framebuffer::beyond_single_precision`] tells.
pub fn single_precision(value: f64) -> f32 {
    if value.is_nan() { 0.0 } else { value.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32 }
}

/// What the header of an EXR file says besides what its pixels say.
#[derive(Clone, Debug)]
pub struct ExrHeader {
    image: exr::meta::header::ImageAttributes,
    layer: exr::meta::header::LayerAttributes,
}

impl ExrHeader {
    /// The same with an attribute.
    pub fn with_text(mut self, name: &str, text: &str) -> Self {
        self.layer.other.insert(name.into(), AttributeValue::Text(text.into()));
        self
    }

    /// The primaries and the white of its colours, if it names them.
    pub fn chromaticities(&self) -> Option<Chromaticities> {
        self.image.chromaticities
    }

    /// What an attribute says, as a word; `None` if there is none of this name, or it is no word or number.
    pub fn word(&self, name: &str) -> Option<String> {
        word(self.layer.other.iter().find(|(own, _)| *own == name)?.1)
    }
}

/// The value of an attribute as a word, if it is one or a number.
pub(crate) fn word(value: &AttributeValue) -> Option<String> {
    match value {
        AttributeValue::Text(text) => Some(said(&text.to_string())),
        AttributeValue::F64(x) => Some(x.to_string()),
        AttributeValue::F32(x) => Some(x.to_string()),
        AttributeValue::I32(x) => Some(x.to_string()),
        _ => None,
    }
}

/// An EXR file of one part, as it is read in order to be written with other pixels.
pub struct ExrFile {
    /// Its channels.
    pub picture: Picture,
    /// Its header.
    pub header: ExrHeader,
}

impl ExrFile {
    /// Reads it.
    ///
    /// # Errors
    /// If there is no such file, or it is not a flat EXR picture of one part.
    pub fn read(path: &Path) -> Result<Self> {
        let picture = Picture::read_exr(path)?;
        let meta = exr::meta::MetaData::read_from_file(path, false)?;
        let [header] = &meta.headers[..] else {
            let parts = meta.headers.len();
            bail!("`{}` has {parts} parts; save the one that holds the picture as a file of its own", path.display());
        };
        let (image, layer) = (header.shared_attributes.clone(), header.own_attributes.clone());
        Ok(Self { picture, header: ExrHeader { image, layer } })
    }
}

impl Picture {
    /// Whether it has the same channels, pixels and place in its frame as another one; in whatever order the channels are.
    pub fn same_channels(&self, other: &Self) -> bool {
        let n = self.channels.len();
        self.size == other.size && self.frame == other.frame && n == other.channels.len() && {
            let there = self.channels.iter().map(|name| other.channels.iter().position(|c| c == name));
            there.enumerate().all(|(c, there)| {
                there.is_some_and(|there| {
                    let (own, others) = (self.data.iter().skip(c).step_by(n), other.data.iter().skip(there).step_by(n));
                    own.map(|v| v.to_bits()).eq(others.map(|v| v.to_bits()))
                })
            })
        }
    }

    /// The values of a pixel.
    pub fn pixel(&self, x: usize, y: usize) -> &[f32] {
        let n = self.channels.len();
        &self.data[(y * self.size[0] + x) * n..][..n]
    }

    /// The pixels, row by row from the top.
    pub fn pixels(&self) -> impl Iterator<Item = &[f32]> {
        self.data.chunks_exact(self.channels.len())
    }

    /// The numbers of the channels of these names; `None` if one is not there.
    pub fn find<const N: usize>(&self, names: [&str; N]) -> Option<[usize; N]> {
        self.find_by(names, |channel, name| channel == name)
    }

    /// The same whatever the case of letters.
    pub fn find_ignoring_case<const N: usize>(&self, names: [&str; N]) -> Option<[usize; N]> {
        self.find_by(names, |channel, name| channel.eq_ignore_ascii_case(name))
    }

    fn find_by<const N: usize>(&self, names: [&str; N], is: impl Fn(&str, &str) -> bool) -> Option<[usize; N]> {
        let found = names.map(|name| self.channels.iter().position(|channel| is(channel, name)));
        found.iter().all(Option::is_some).then(|| found.map(Option::unwrap_or_default))
    }

    /// Writes what `of` makes of some channels of each pixel to `into`.
    pub fn extract<const N: usize>(&self, channels: [usize; N], into: &mut [f32], of: impl Fn(f32) -> f32) {
        for (pixel, into) in self.pixels().zip(into.chunks_exact_mut(N)) {
            into.iter_mut().zip(channels).for_each(|(into, c)| *into = of(pixel[c]));
        }
    }

    /// The same picture with further channels, which `of` finds for each pixel.
    pub fn with_channels(self, names: &[&str], mut of: impl FnMut(&[f32], &mut Vec<f32>)) -> Self {
        let mut data = Vec::with_capacity(self.size[0] * self.size[1] * (self.channels.len() + names.len()));
        for pixel in self.pixels() {
            data.extend_from_slice(pixel);
            of(pixel, &mut data);
        }
        let channels = self.channels.into_iter().chain(names.iter().map(|name| (*name).to_owned())).collect();
        Self { channels, data, ..self }
    }

    /// Writes the picture as 32-bit EXR.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_exr(&self, to: impl Write + std::io::Seek, attributes: &[(String, Attribute)]) -> Result<()> {
        let layer_attributes = exrs::LayerAttributes {
            layer_position: exrs::Vec2(self.frame.offset[0] as i32, self.frame.offset[1] as i32),
            software_name: Some(concat!("bhs ", env!("CARGO_PKG_VERSION")).into()),
            ..Default::default()
        };
        let mut image = exrs::Image::from_layer(self.exr_layer(layer_attributes));
        image.attributes.display_window =
            exrs::IntegerBounds::from_dimensions(exrs::Vec2(self.frame.size[0], self.frame.size[1]));
        for (name, value) in attributes {
            value.put_into(&mut image, name);
        }
        write_image(&image, to)
    }

    /// The same with the header of another file of the same size.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_exr_like(&self, to: impl Write + std::io::Seek, header: &ExrHeader) -> Result<()> {
        let mut image = exrs::Image::from_layer(self.exr_layer(header.layer.clone()));
        image.attributes = header.image.clone();
        write_image(&image, to)
    }

    fn exr_layer(&self, attributes: exrs::LayerAttributes) -> exrs::Layer<exrs::AnyChannels<exrs::FlatSamples>> {
        let n = self.channels.len();
        let channels = self.channels.iter().enumerate().map(|(c, name)| {
            let samples = self.data.iter().skip(c).step_by(n).copied().collect();
            exrs::AnyChannel::new(name.as_str(), exrs::FlatSamples::F32(samples))
        });
        let channels = exrs::AnyChannels::sort(channels.collect());
        exrs::Layer::new(exrs::Vec2(self.size[0], self.size[1]), attributes, exrs::Encoding::SMALL_LOSSLESS, channels)
    }

    /// Reads an EXR file as pictures for textures and skies are read: with all channels of the part that holds the colours.
    ///
    /// # Errors
    /// If there is no such file or it is not a flat EXR picture.
    pub fn read_exr(path: &Path) -> Result<Self> {
        if path.is_dir() {
            bail!("cannot read `{}`: it is a directory", path.display());
        }
        let shown = || format!("cannot read `{}` as an EXR picture", path.display());
        let bytes = std::fs::read(path).with_context(shown)?;
        let read = bhs_textures::decode::exr::read_all(&bytes).map_err(anyhow::Error::msg).with_context(shown)?;
        let offset = read.offset.map(|o| o.max(0) as usize);
        Ok(Self { size: read.size, frame: Frame { offset, size: read.frame }, channels: read.names, data: read.values })
    }
}

/// Writes an EXR file, by one thread, so that the bytes do not depend on how many there are.
fn write_image(
    image: &exrs::Image<exrs::Layer<exrs::AnyChannels<exrs::FlatSamples>>>,
    to: impl Write + std::io::Seek,
) -> Result<()> {
    use exrs::WritableImage;
    image.write().non_parallel().to_buffered(to)?;
    Ok(())
}

/// Writes an sRGB picture of 8 or 16 bits (big-endian) as PNG, row by row: `row` appends the bytes of row `y`, red, green and blue. `texts` are keywords and
/// what they say.
///
/// # Errors
/// If the file cannot be written.
pub fn write_rows(
    to: impl Write,
    size: [usize; 2],
    sixteen_bits: bool,
    texts: &[(&'static str, String)],
    mut row: impl FnMut(usize, &mut Vec<u8>),
) -> Result<()> {
    let mut encoder = png::Encoder::new(to, size[0] as u32, size[1] as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(if sixteen_bits { png::BitDepth::Sixteen } else { png::BitDepth::Eight });
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_compression(png::Compression::Balanced);
    encoder.set_filter(png::Filter::Adaptive);
    for (keyword, text) in texts {
        match text.is_ascii() {
            true => encoder.add_text_chunk((*keyword).to_owned(), text.clone())?,
            false => encoder.add_itxt_chunk((*keyword).to_owned(), text.clone())?,
        }
    }
    let mut writer = encoder.write_header()?;
    let mut stream = writer.stream_writer()?;
    let mut bytes = Vec::new();
    for y in 0..size[1] {
        bytes.clear();
        row(y, &mut bytes);
        stream.write_all(&bytes)?;
    }
    stream.finish()?;
    Ok(writer.finish()?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_of_exr_files_hold_any_words() {
        for words in [
            "",
            "left",
            "\u{e9}t\u{e9}",
            "\u{41a}\u{430} \u{1f600} \u{f6}",
            r"a\b",
            r"\u{41}",
            r"\u{41} \ \u{zz",
            "\u{41a}\\u{41}",
            "a\0b",
        ] {
            let kept = text(words).to_string();
            assert!(kept.chars().all(|c| (c as u32) < 256));
            assert_eq!(said(&kept), words, "{kept}");
        }
        // Those of others.
        for theirs in [r"\u{", r"\u{}", r"\u{d800}", r"\u{ffffffffff}x"] {
            assert_eq!(said(theirs), theirs);
        }
    }
}
