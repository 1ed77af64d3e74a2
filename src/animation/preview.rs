//! A small film for people to look at: the PNGs of the frames as one animated GIF or PNG.

use crate::output::Writer;
use anyhow::{Context, Result, bail};
use image::codecs::gif::{GifEncoder, Repeat};
use image::{Delay, Frame, RgbImage};
use std::io::Write;
use std::path::{Path, PathBuf};

/// How a preview is kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 256 colours a frame, time in hundredths of a second; shown everywhere.
    Gif,
    /// Animated PNG: all colours; shown by browsers.
    Apng,
}

impl Format {
    /// What the name of a file asks for.
    ///
    /// # Errors
    /// If it is neither.
    pub fn of(path: &Path) -> Result<Self, String> {
        let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
        match ending.as_str() {
            "gif" => Ok(Self::Gif),
            "png" | "apng" => Ok(Self::Apng),
            _ => Err("the name of a preview ends in .gif, or in .png or .apng for an animated PNG".to_owned()),
        }
    }
}

/// Writes the pictures `frames` one after the other, each shown for `seconds`. They have one size.
///
/// # Errors
/// If a picture cannot be read or the film cannot be written.
pub fn write(to: &mut Writer, format: Format, frames: &[PathBuf], seconds: f64) -> Result<()> {
    match format {
        Format::Gif => write_gif(to, frames, seconds),
        Format::Apng => write_apng(to, frames, seconds),
    }
}

/// A picture, of the size of those before it.
fn read(path: &Path, size: &mut Option<(u32, u32)>) -> Result<RgbImage> {
    let picture = image::open(path).with_context(|| format!("cannot read `{}`", path.display()))?.into_rgb8();
    let known = *size.get_or_insert(picture.dimensions());
    if picture.dimensions() != known {
        bail!("`{}` has another size than the frames before it: a preview has one", path.display());
    }
    Ok(picture)
}

fn write_gif(to: &mut Writer, frames: &[PathBuf], seconds: f64) -> Result<()> {
    // Colours are chosen for each frame; 10 is as good as the eye needs, and quick.
    let mut encoder = GifEncoder::new_with_speed(&mut *to, 10);
    encoder.set_repeat(Repeat::Infinite)?;
    let mut size = None;
    let end = |i: usize| (100.0 * seconds * i as f64).round();
    for (i, path) in frames.iter().enumerate() {
        let picture = image::DynamicImage::from(read(path, &mut size)?).into_rgba8();
        // Whole hundredths, such that the film as a whole has its length; programs take less than two for no time at all.
        let hundredths = (end(i + 1) - end(i)).clamp(2.0, 60_000.0) as u32;
        encoder.encode_frame(Frame::from_parts(picture, 0, 0, Delay::from_numer_denom_ms(10 * hundredths, 1)))?;
    }
    Ok(())
}

fn write_apng(to: &mut Writer, frames: &[PathBuf], seconds: f64) -> Result<()> {
    let mut size = None;
    let Some(first) = frames.first() else { bail!("there is no frame to show") };
    let (width, height) = read(first, &mut size)?.dimensions();
    let mut encoder = png::Encoder::new(&mut *to, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.add_text_chunk("Software".to_owned(), concat!("bhs ", env!("CARGO_PKG_VERSION")).to_owned())?;
    encoder.set_animated(frames.len() as u32, 0)?;
    // In ten thousandths of a second, or coarser for slow films.
    let per_second = (65_535.0 / seconds).clamp(1.0, 10_000.0).floor();
    encoder.set_frame_delay((seconds * per_second).round().clamp(1.0, 65_535.0) as u16, per_second as u16)?;
    let mut writer = encoder.write_header()?;
    for path in frames {
        writer.write_image_data(read(path, &mut size)?.as_raw())?;
    }
    writer.finish()?;
    to.flush()?;
    Ok(())
}
