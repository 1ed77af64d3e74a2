//! Files of pictures to texels: PNG, JPEG, HDR (RGBE) and OpenEXR, told apart by their first bytes.
//!
//! Grey pictures get three equal channels; what is transparent counts as opaque.

use bhs_core::image::{Image, Texels};
use image::{DynamicImage, ImageFormat, ImageReader, Limits};
use std::io::Cursor;

/// Greatest width and height.
const MAX_SIDE: u32 = 1 << 16;
/// Most texels.
const MAX_TEXELS: u64 = 1 << 28;
/// More texels than a byte of an EXR file can stand for: deflate makes no more than 1032 bytes of one, and a texel has two at least.
const TEXELS_A_BYTE: u64 = 1024;

/// The picture that the bytes of a file hold.
///
/// # Errors
/// What is wrong with it, in words that can follow "cannot read `file`: ".
pub fn decode(bytes: &[u8]) -> Result<Image, String> {
    const EXR_MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
    if bytes.starts_with(&EXR_MAGIC) {
        return decode_exr(bytes);
    }
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| format!("it is no picture: {e}"))?;
    if !matches!(reader.format(), Some(ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::Hdr)) {
        return Err("it is no PNG, JPEG, HDR or EXR picture".into());
    }
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
    limits.max_alloc = Some(MAX_TEXELS * 4);
    reader.limits(limits);
    let picture = reader.decode().map_err(|e| e.to_string())?;
    let (width, height) = (picture.width(), picture.height());
    let texels = match picture {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            Texels::Floats(picture.into_rgb32f().pixels().map(|p| p.0.map(|c| if c.is_finite() { c } else { 0.0 })).collect())
        }
        DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_) => Texels::Words(picture.into_rgb16().pixels().map(|p| p.0).collect()),
        _ => Texels::Bytes(picture.into_rgb8().pixels().map(|p| p.0).collect()),
    };
    if width == 0 || height == 0 {
        return Err("it has no texels".into());
    }
    Ok(Image { width, height, texels })
}

fn decode_exr(bytes: &[u8]) -> Result<Image, String> {
    use exr::prelude::{AnyChannel, FlatSamples, MetaData, ReadChannels, ReadLayers, read};
    // The size that the file claims is looked at before anything is made of it.
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| e.to_string())?;
    for header in &meta.headers {
        let (w, h) = (header.layer_size.width(), header.layer_size.height());
        if (w as u64).saturating_mul(h as u64) > MAX_TEXELS {
            return Err(format!("it is too large: {w} x {h}, at most {MAX_TEXELS} texels"));
        }
        if w as u64 * h as u64 > TEXELS_A_BYTE * bytes.len() as u64 {
            return Err(format!("it is damaged: {} bytes cannot hold {w} x {h} texels", bytes.len()));
        }
    }
    let picture = read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|e| e.to_string())?;
    let layer = picture.layer_data;
    let (width, height) = (layer.size.width(), layer.size.height());
    let channel = |name: &str| {
        // Channels of a named layer are called `layer.R`.
        let is_it = |c: &&AnyChannel<FlatSamples>| c.name.to_string().rsplit('.').next().is_some_and(|n| n == name);
        layer.channel_data.list.iter().find(is_it).map(|c| c.sample_data.values_as_f32().collect::<Vec<f32>>())
    };
    let channels = match (channel("R"), channel("G"), channel("B")) {
        (Some(r), Some(g), Some(b)) => [r, g, b],
        _ => match channel("Y") {
            Some(y) => [y.clone(), y.clone(), y],
            None => return Err("it has no channels R, G and B, and no Y".into()),
        },
    };
    let count = width * height;
    if count == 0 || channels.iter().any(|c| c.len() != count) {
        return Err("its channels have different sizes".into());
    }
    // What is not a number is no light.
    let texel = |i| [0, 1, 2].map(|c: usize| Some(channels[c][i]).filter(|v: &f32| v.is_finite()).unwrap_or(0.0));
    Ok(Image { width: width as u32, height: height as u32, texels: Texels::Floats((0..count).map(texel).collect()) })
}
