//! PNG and JPEG, of 8 and 16 bits a channel.
//!
//! Numbers are taken as they are: what the file says of its colours (`gAMA`, `cHRM`, `cICP`, ICC profiles) is not followed, since a
//! scene says how numbers mean light; where it differs from sRGB, a note tells so. A photograph is turned upright as its EXIF data say.

use super::{check_size, texels};
use bhs_core::image::{Image, Texels};
use image::ImageDecoder;
use image::codecs::jpeg::JpegDecoder;
use image::metadata::Orientation;
use png::{BitDepth, ColorType};
use std::io::Cursor;

/// Bytes of scan lines that a byte of a PNG can stand for: what deflate reaches (zlib's technical details).
const DEFLATE_RATIO: usize = 1032;
/// Texels that a byte of a JPEG can stand for: each block of 8x8 takes a bit at least, that of its mean.
const JPEG_TEXELS_A_BYTE: usize = 512;
/// Memory of the PNG decoder besides the picture (bytes): a few rows and an ICC profile.
const PNG_WORKING_MEMORY: usize = 1 << 26;

/// A picture in PNG; of an animated one the picture that programs show which know no animation.
pub(super) fn decode_png(bytes: &[u8]) -> Result<Image, String> {
    let explain = |e: png::DecodingError| format!("it is damaged: {e}");
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), png::Limits { bytes: PNG_WORKING_MEMORY });
    decoder.set_transformations(png::Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    let info = decoder.read_header_info().map_err(explain)?;
    let size = [info.width as usize, info.height as usize];
    // Room for the file's own rows, which may have fewer bits.
    let row = info.bits_per_pixel().saturating_mul(size[0]).div_ceil(8);
    check_size(size, usize::MAX, 1)?;
    if row.saturating_mul(size[1]) > bytes.len().saturating_mul(DEFLATE_RATIO) {
        return Err(format!("it is damaged: {} bytes cannot hold {} x {} texels", bytes.len(), size[0], size[1]));
    }
    let mut reader = decoder.read_info().map_err(explain)?;
    let (colour, depth) = reader.output_color_type();
    let samples = colour.samples();
    let is_interlaced = reader.info().interlaced;
    // Rows of an interlaced picture come in pieces: it is decoded as a whole.
    let whole = if is_interlaced {
        let length = reader.output_buffer_size().ok_or("it is too large")?;
        let mut whole: Vec<u8> = texels([length, 1])?;
        reader.next_frame(&mut whole).map_err(explain)?;
        whole
    } else {
        Vec::new()
    };
    let mut rows = whole.chunks_exact(size[0] * samples * if depth == BitDepth::Sixteen { 2 } else { 1 });
    let mut each_row = |put: &mut dyn FnMut(usize, &[u8])| -> Result<(), String> {
        for y in 0..size[1] {
            if is_interlaced {
                put(y, rows.next().ok_or("it is damaged: rows are missing")?);
            } else {
                put(y, reader.next_row().map_err(explain)?.ok_or("it is damaged: rows are missing")?.data());
            }
        }
        Ok(())
    };
    let is_grey = matches!(colour, ColorType::Grayscale | ColorType::GrayscaleAlpha);
    let has_alpha = matches!(colour, ColorType::GrayscaleAlpha | ColorType::Rgba);
    let mut alpha: Vec<u8> = if has_alpha { texels(size)? } else { Vec::new() };
    let texels = if depth == BitDepth::Sixteen {
        let mut words = texels::<[u16; 3]>(size)?;
        each_row(&mut |y, row| {
            opacity(&mut alpha, y, row, (2 * samples, 2));
            for (texel, from) in words[y * size[0]..][..size[0]].iter_mut().zip(row.chunks_exact(2 * samples)) {
                *texel = [0, 1, 2].map(|c| if is_grey { 0 } else { 2 * c }).map(|i| u16::from_be_bytes([from[i], from[i + 1]]));
            }
        })?;
        Texels::Words(words)
    } else {
        let mut out = texels::<[u8; 3]>(size)?;
        each_row(&mut |y, row| {
            opacity(&mut alpha, y, row, (samples, 1));
            for (texel, from) in out[y * size[0]..][..size[0]].iter_mut().zip(row.chunks_exact(samples)) {
                *texel = if is_grey { [from[0]; 3] } else { [from[0], from[1], from[2]] };
            }
        })?;
        Texels::Bytes(out)
    };
    let info = reader.info();
    let mut image = Image::new([info.width, info.height], texels).with_alpha(alpha);
    image.encoding_note = png_colours(info);
    if let Some(o) = info.exif_metadata.as_deref().and_then(Orientation::from_exif_chunk) {
        image = upright(image, o);
    }
    Ok(image)
}

/// Notes how opaque the texels of row `y` are, of so many bytes each with so many for the last channel; nothing without room for it.
fn opacity(alpha: &mut [u8], y: usize, row: &[u8], (bytes, last): (usize, usize)) {
    let width = row.len() / bytes;
    let Some(to) = alpha.get_mut(y * width..(y + 1) * width) else { return };
    for (to, from) in to.iter_mut().zip(row.chunks_exact(bytes)) {
        *to = from[bytes - last];
    }
}

/// What the chunks of a PNG say against sRGB; the first of those that have precedence (PNG, third edition, section 4.3).
fn png_colours(info: &png::Info) -> Option<String> {
    if let Some(cicp) = info.coding_independent_code_points {
        // ITU-T H.273: primaries 1 and the curve 13 (sRGB) or 1 (BT.709, which displays show as sRGB).
        let is_srgb = cicp.color_primaries == 1 && [1, 13].contains(&cicp.transfer_function);
        let codes = [cicp.color_primaries, cicp.transfer_function];
        return (!is_srgb).then(|| format!("its chunk cICP says primaries {} and curve {} of ITU-T H.273", codes[0], codes[1]));
    }
    if let Some(profile) = &info.icc_profile {
        return profile_note(profile);
    }
    if info.srgb.is_some() {
        return None;
    }
    let gamma = info.gama_chunk.map(png::ScaledFloat::into_value);
    // The curve of sRGB is near a power of 2.2.
    if let Some(gamma) = gamma.filter(|g| (g * 2.2 - 1.0).abs() > 0.05) {
        return Some(format!("its chunk gAMA says that numbers are light to the power {gamma:.3}, sRGB being near 0.455"));
    }
    let chroma = info.chrm_chunk?;
    let numbers = [chroma.red, chroma.green, chroma.blue, chroma.white].map(|(x, y)| [x.into_value(), y.into_value()]);
    let srgb = [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.3127, 0.3290]];
    let off = numbers.as_flattened().iter().zip(srgb.as_flattened()).any(|(a, b)| (a - b).abs() > 5e-3);
    off.then(|| "its chunk cHRM says primaries that are not those of sRGB".into())
}

/// A note on an ICC profile, unless it is sRGB's.
fn profile_note(profile: &[u8]) -> Option<String> {
    let name = profile_name(profile).unwrap_or_else(|| "without a name".into());
    let is_srgb = name.to_lowercase().contains("srgb");
    (!is_srgb).then(|| format!("it has the colour profile `{name}`"))
}

/// The description in an ICC profile (ICC.1:2022 and ICC.1:2001-04: tag `desc`, of the type `desc` or `mluc`).
fn profile_name(profile: &[u8]) -> Option<String> {
    let word = |at: usize| Some(u32::from_be_bytes(*profile.get(at..)?.first_chunk()?) as usize);
    let tags = word(128)?.min(100);
    let tag = (0..tags).map(|i| 132 + 12 * i).find(|at| profile.get(*at..at + 4) == Some(b"desc"))?;
    let data = profile.get(word(tag + 4)?..)?;
    let number = |at: usize| Some(u32::from_be_bytes(*data.get(at..)?.first_chunk()?) as usize);
    let text: String = match data.get(..4)? {
        b"desc" => String::from_utf8_lossy(data.get(12..)?.get(..number(8)?)?).into_owned(),
        b"mluc" => {
            let units = data.get(number(24)?..)?.get(..number(20)?)?;
            char::decode_utf16(units.as_chunks().0.iter().map(|b| u16::from_be_bytes(*b))).filter_map(Result::ok).collect()
        }
        _ => return None,
    };
    let text: String = text.chars().filter(|c| !c.is_control()).take(60).collect();
    Some(text.trim().to_owned()).filter(|t| !t.is_empty())
}

/// A picture in JPEG: grey, colours, and four inks (CMYK, YCCK).
pub(super) fn decode_jpeg(bytes: &[u8]) -> Result<Image, String> {
    let explain = |e: image::ImageError| format!("it is damaged: {e}");
    let mut decoder = JpegDecoder::new(Cursor::new(bytes)).map_err(explain)?;
    let (width, height) = decoder.dimensions();
    let size = [width as usize, height as usize];
    check_size(size, bytes.len(), JPEG_TEXELS_A_BYTE)?;
    let orientation = decoder.orientation().unwrap_or(Orientation::NoTransforms);
    let profile = decoder.icc_profile().ok().flatten();
    let mut out = texels::<[u8; 3]>(size)?;
    match decoder.color_type() {
        image::ColorType::Rgb8 => decoder.read_image(out.as_flattened_mut()).map_err(explain)?,
        image::ColorType::L8 => {
            let mut grey: Vec<u8> = texels(size)?;
            decoder.read_image(&mut grey).map_err(explain)?;
            out.iter_mut().zip(grey).for_each(|(texel, v)| *texel = [v; 3]);
        }
        other => return Err(format!("its colours ({other:?}) are not read: save it as RGB")),
    }
    let mut image = Image::new([width, height], Texels::Bytes(out));
    image.encoding_note = profile.as_deref().and_then(profile_note);
    Ok(upright(image, orientation))
}

/// Turns a picture as its camera was held.
fn upright(image: Image, orientation: Orientation) -> Image {
    let Texels::Bytes(from) = &image.texels else { return image };
    let (w, h) = (image.width as usize, image.height as usize);
    // For a column and a row of the upright picture, those of the stored one.
    let place: fn(usize, usize, usize, usize) -> (usize, usize) = match orientation {
        Orientation::NoTransforms => return image,
        Orientation::FlipHorizontal => |x, y, w, _| (w - 1 - x, y),
        Orientation::FlipVertical => |x, y, _, h| (x, h - 1 - y),
        Orientation::Rotate180 => |x, y, w, h| (w - 1 - x, h - 1 - y),
        Orientation::Rotate90 => |x, y, _, h| (y, h - 1 - x),
        Orientation::Rotate270 => |x, y, w, _| (w - 1 - y, x),
        Orientation::Rotate90FlipH => |x, y, _, _| (y, x),
        Orientation::Rotate270FlipH => |x, y, w, h| (w - 1 - y, h - 1 - x),
    };
    let [width, height] = if orientation.to_exif() > 4 { [h, w] } else { [w, h] };
    let source = |i: usize| {
        let (x, y) = place(i % width, i / width, w, h);
        y * w + x
    };
    let texels = (0..width * height).map(|i| from[source(i)]);
    let alpha = image.alpha.as_ref().map(|alpha| (0..width * height).map(|i| alpha[source(i)]).collect());
    Image { width: width as u32, height: height as u32, texels: Texels::Bytes(texels.collect()), alpha, ..image }
}
