//! Files of pictures to texels: PNG, JPEG, HDR (RGBE, XYZE), OpenEXR, PFM, TGA, WebP and QOI, told apart by their first bytes.
//!
//! Grey pictures get three equal channels; how opaque texels are is kept apart (of OpenEXR not at all). Pictures with their own primaries become linear sRGB
//! (OpenEXR, HDR), or a note says that they are taken for sRGB (PNG, JPEG). Memory goes to the picture itself and a few of its rows,
//! and only after the file has been found large enough to hold what its header says.

use bhs_core::image::Image;

pub mod exr;
mod exr_layer;
pub mod exr_parts;
mod hdr;
mod others;
mod primaries;
mod raster;

/// Greatest width and height.
const MAX_SIDE: usize = 1 << 16;
/// Most texels.
const MAX_TEXELS: usize = 1 << 28;
/// Largest number of a half, which stands for what is infinite in a file: mostly what was too bright for a half.
const BRIGHTEST: f32 = 65504.0;

/// The picture that the bytes of a file hold.
///
/// # Errors
/// What is wrong with it, in words that can follow "cannot read `file`: ".
pub fn decode(bytes: &[u8]) -> Result<Image, String> {
    match bytes {
        [0x76, 0x2f, 0x31, 0x01, ..] => exr::decode(bytes),
        [0x89, b'P', b'N', b'G', ..] => raster::decode_png(bytes),
        [0xff, 0xd8, 0xff, ..] => raster::decode_jpeg(bytes),
        [b'#', b'?', ..] => hdr::decode(bytes),
        [b'P', b'F' | b'f', b, ..] if b.is_ascii_whitespace() => others::decode_pfm(bytes),
        [b'q', b'o', b'i', b'f', ..] => others::decode(bytes, image::ImageFormat::Qoi),
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => others::decode(bytes, image::ImageFormat::WebP),
        [] => Err("it is empty".into()),
        _ if others::is_tga(bytes) => others::decode(bytes, image::ImageFormat::Tga),
        _ => Err("it is no PNG, JPEG, HDR, EXR, PFM, TGA, WebP or QOI picture".into()),
    }
}

/// Whether a picture of this width and height is neither empty nor too large, and whether `bytes` bytes can hold it, of which each can
/// stand for `texels_a_byte` texels at most.
fn check_size([width, height]: [usize; 2], bytes: usize, texels_a_byte: usize) -> Result<(), String> {
    if width == 0 || height == 0 {
        return Err("it has no texels".into());
    }
    if width > MAX_SIDE || height > MAX_SIDE {
        return Err(format!("it is too large: {width} x {height}, at most {MAX_SIDE} a side"));
    }
    // Neither product overflows: both sides are small.
    if width * height > MAX_TEXELS {
        return Err(format!("it is too large: {width} x {height}, at most {MAX_TEXELS} texels"));
    }
    if width * height > bytes.saturating_mul(texels_a_byte) {
        return Err(format!("it is damaged: {bytes} bytes cannot hold {width} x {height} texels"));
    }
    Ok(())
}

/// Room for a picture.
fn texels<T: Copy + Default>([width, height]: [usize; 2]) -> Result<Vec<T>, String> {
    let mut texels = Vec::new();
    reserve(&mut texels, [width, height])?;
    texels.resize(width * height, T::default());
    Ok(texels)
}

/// Makes room for a whole picture in an empty list.
fn reserve<T>(list: &mut Vec<T>, [width, height]: [usize; 2]) -> Result<(), String> {
    list.try_reserve_exact(width * height).map_err(|_| {
        let megabytes = (width * height * size_of::<T>()).div_ceil(1_000_000);
        format!("{width} x {height} texels take {megabytes} MB, more memory than there is")
    })
}
