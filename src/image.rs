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
            ("capDate", Self::Text(t)) => layer.capture_date = Some(t.as_str().into()),
            ("utcOffset", Self::Single(x)) => layer.utc_offset = Some(*x),
            ("comments", Self::Text(t)) => layer.comments = Some(t.as_str().into()),
            (name, other) => {
                let value = match other {
                    Self::Text(t) => AttributeValue::Text(t.as_str().into()),
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

/// A value as files keep it: the largest number of its sign in place of what is larger, and 0 for what is no number. Where that happens,
/// [`crate::film::Framebuffer::beyond_single_precision`] tells.
pub fn single_precision(value: f64) -> f32 {
    if value.is_nan() { 0.0 } else { value.clamp(f64::from(f32::MIN), f64::from(f32::MAX)) as f32 }
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

    /// Writes the picture as 32-bit EXR.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_exr(&self, to: impl Write + std::io::Seek, attributes: &[(String, Attribute)]) -> Result<()> {
        let n = self.channels.len();
        let channels = self.channels.iter().enumerate().map(|(c, name)| {
            let samples = self.data.iter().skip(c).step_by(n).copied().collect();
            exrs::AnyChannel::new(name.as_str(), exrs::FlatSamples::F32(samples))
        });
        let channels = exrs::AnyChannels::sort(channels.collect());
        let layer_attributes = exrs::LayerAttributes {
            layer_position: exrs::Vec2(self.frame.offset[0] as i32, self.frame.offset[1] as i32),
            software_name: Some(concat!("bhs ", env!("CARGO_PKG_VERSION")).into()),
            ..Default::default()
        };
        let size = exrs::Vec2(self.size[0], self.size[1]);
        let layer = exrs::Layer::new(size, layer_attributes, exrs::Encoding::SMALL_LOSSLESS, channels);
        let mut image = exrs::Image::from_layer(layer);
        image.attributes.display_window =
            exrs::IntegerBounds::from_dimensions(exrs::Vec2(self.frame.size[0], self.frame.size[1]));
        for (name, value) in attributes {
            value.put_into(&mut image, name);
        }
        // One thread, so that the bytes do not depend on how many there are.
        use exrs::WritableImage;
        image.write().non_parallel().to_buffered(to)?;
        Ok(())
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

    /// Writes the picture as 8-bit PNG; `display` turns the channels of a pixel into sRGB between 0 and 1.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn write_png(&self, to: impl Write, display: impl Fn(&[f32]) -> [f32; 3]) -> Result<()> {
        let bytes: Vec<u8> = self
            .data
            .chunks_exact(self.channels.len())
            .flat_map(|pixel| display(pixel).map(|v| (v * 255.0 + 0.5) as u8))
            .collect();
        write_png(to, self.size, &bytes)
    }
}

/// Writes an 8-bit sRGB picture as PNG; `bytes` are red, green and blue, row by row from the top.
///
/// # Errors
/// If the file cannot be written.
pub fn write_png(to: impl Write, size: [usize; 2], bytes: &[u8]) -> Result<()> {
    use image::ImageEncoder;
    use image::codecs::png::{CompressionType, FilterType, PngEncoder};
    let encoder = PngEncoder::new_with_quality(to, CompressionType::Default, FilterType::Adaptive);
    encoder.write_image(bytes, size[0] as u32, size[1] as u32, image::ExtendedColorType::Rgb8)?;
    Ok(())
}
