//! TGA, WebP and QOI by the `image` crate, and PFM.
//!
//! A TGA has no first bytes of its own: it is told by a header that makes sense.

use super::{check_size, texels};
use bhs_core::image::{Image, Texels};
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader};
use std::io::Cursor;

/// Texels that a byte of a TGA can stand for: a run of 128 takes two bytes at least.
const TGA_TEXELS_A_BYTE: usize = 64;
/// Of a QOI: a run of 62 takes one byte.
const QOI_TEXELS_A_BYTE: usize = 62;
/// Of a WebP: large even patches take next to nothing.
const WEBP_TEXELS_A_BYTE: usize = 1 << 16;

/// Whether the bytes begin as a TGA does (Truevision TGA file format 2.0).
pub(super) fn is_tga(bytes: &[u8]) -> bool {
    let Some(&[_, map, kind, _, _, _, _, depth_of_map, _, _, _, _, w0, w1, h0, h1, depth, _]) = bytes.first_chunk::<18>() else {
        return false;
    };
    let mapped = matches!((map, kind, depth), (1, 1 | 9, 8)) && matches!(depth_of_map, 15 | 16 | 24 | 32);
    let coloured = map <= 1 && matches!(kind, 2 | 10) && matches!(depth, 15 | 16 | 24 | 32);
    let grey = map <= 1 && matches!(kind, 3 | 11) && matches!(depth, 8 | 16);
    (mapped || coloured || grey) && [w0, w1] != [0; 2] && [h0, h1] != [0; 2]
}

/// A picture in TGA, WebP or QOI: a QOI may say that it is linear.
pub(super) fn decode(bytes: &[u8], format: ImageFormat) -> Result<Image, String> {
    let explain = |e: image::ImageError| format!("it is damaged: {e}");
    let texels_a_byte = match format {
        ImageFormat::Tga => TGA_TEXELS_A_BYTE,
        ImageFormat::Qoi => QOI_TEXELS_A_BYTE,
        _ => WEBP_TEXELS_A_BYTE,
    };
    let decoder = ImageReader::with_format(Cursor::new(bytes), format).into_decoder().map_err(explain)?;
    let (width, height) = decoder.dimensions();
    check_size([width as usize, height as usize], bytes.len(), texels_a_byte)?;
    let picture = DynamicImage::from_decoder(decoder).map_err(explain)?;
    let as_light = |p: [u8; 3]| p.map(|v| f32::from(v) / 255.0);
    let texels = |colours: Vec<[u8; 3]>| match format {
        // The last byte of its header says so.
        ImageFormat::Qoi if bytes.get(13) == Some(&1) => Texels::Floats(colours.into_iter().map(as_light).collect()),
        _ => Texels::Bytes(colours),
    };
    if picture.color().has_alpha() {
        let picture = picture.into_rgba8();
        let colours = picture.pixels().map(|p| [p.0[0], p.0[1], p.0[2]]).collect();
        let alpha = picture.pixels().map(|p| p.0[3]).collect();
        return Ok(Image::new([width, height], texels(colours)).with_alpha(alpha));
    }
    let colours = picture.into_rgb8().pixels().map(|p| p.0).collect();
    Ok(Image::new([width, height], texels(colours)))
}

/// A picture in PFM: floats, the lowest row first.
pub(super) fn decode_pfm(bytes: &[u8]) -> Result<Image, String> {
    // The type, width, height and scale, each ended by one blank.
    let mut words = Vec::new();
    let mut at = 0;
    while words.len() < 4 {
        let rest = bytes.get(at..).filter(|r| !r.is_empty()).ok_or("it ends in its header")?;
        let length = rest.iter().take(64).position(u8::is_ascii_whitespace).ok_or("its header cannot be read")?;
        // Some programs write more than one blank, but before the floats there is one only.
        if length > 0 {
            words.push(std::str::from_utf8(&rest[..length]).map_err(|_| "its header cannot be read")?);
        }
        at += length + 1;
    }
    // Lines that end with two bytes end so before the floats, too.
    let crlf = bytes.get(at - 1) == Some(&b'\r') && bytes.get(at) == Some(&b'\n');
    at += usize::from(crlf);
    let channels = if words[0] == "PF" { 3 } else { 1 };
    let number = |word: &str| word.parse::<usize>().map_err(|_| format!("its header says `{word}` where a size stands"));
    let size = [number(words[1])?, number(words[2])?];
    let scale: f32 = words[3].parse().map_err(|_| format!("its header says `{}` where the scale stands", words[3]))?;
    if !scale.is_finite() || scale == 0.0 {
        return Err("its scale is no number".into());
    }
    let data = &bytes[at.min(bytes.len())..];
    check_size(size, data.len(), 1)?;
    let needed = size[0] * size[1] * channels * 4;
    if data.len() < needed {
        return Err(format!("it is damaged: it ends after {} of {needed} bytes", data.len()));
    }
    let value = |i: usize| {
        let four = [data[4 * i], data[4 * i + 1], data[4 * i + 2], data[4 * i + 3]];
        // As pbrt-v4: the size of the scale counts, its sign says the order of bytes.
        scale.abs() * if scale < 0.0 { f32::from_le_bytes(four) } else { f32::from_be_bytes(four) }
    };
    let mut out = texels::<[f32; 3]>(size)?;
    let mut odd = 0usize;
    for (y, row) in out.chunks_exact_mut(size[0]).enumerate() {
        let first = (size[1] - 1 - y) * size[0];
        for (x, texel) in row.iter_mut().enumerate() {
            let i = (first + x) * channels;
            *texel = std::array::from_fn(|c| value(if channels == 3 { i + c } else { i }));
            for v in texel {
                if !v.is_finite() {
                    odd += 1;
                    *v = if *v == f32::INFINITY { super::BRIGHTEST } else { 0.0 };
                }
            }
        }
    }
    let mut image = Image::new(size.map(|s| s as u32), Texels::Floats(out));
    if odd > 0 {
        image.notes.push(format!("{odd} values are infinite or no numbers, and are read as {} and 0", super::BRIGHTEST));
    }
    Ok(image)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texel(image: &Image, i: usize) -> [f32; 3] {
        match &image.texels {
            Texels::Floats(t) => t[i],
            Texels::Bytes(t) => t[i].map(f32::from),
            Texels::Words(t) => t[i].map(f32::from),
        }
    }

    #[test]
    fn pfm_has_its_lowest_row_first_in_both_orders_of_bytes() {
        let values = [1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0];
        let le: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let be: Vec<u8> = values.iter().flat_map(|v| v.to_be_bytes()).collect();
        for (header, data) in [("PF\n1 2\n-1.0\n", &le), ("PF 1 2 1\n", &be), ("PF\r\n1 2\r\n-1\r\n", &le)] {
            let image = super::super::decode(&[header.as_bytes(), data].concat()).expect(header);
            assert_eq!([texel(&image, 0), texel(&image, 1)], [[4.0, 5.0, 6.0], [1.0, 2.0, 3.0]], "{header}");
        }
        let grey = super::super::decode(&[b"Pf\n1 2\n-2\n".as_slice(), &le[..8]].concat()).expect("grey");
        assert_eq!(texel(&grey, 0), [4.0; 3]);
        for damaged in ["PF\n9 9\n-1\n", "PF\n1 2\n", "PF\n1 -2 1\n", "PF\n1 1 nan\n        ", "PF", "Pf\n0 0\n1\n"] {
            super::super::decode(damaged.as_bytes()).expect_err(damaged);
        }
    }

    #[test]
    fn a_qoi_that_says_that_it_is_linear_is_light() {
        let qoi =
            |linear: u8| [b"qoif\0\0\0\x01\0\0\0\x01\x03", &[linear][..], &[0xfe, 51, 102, 255, 0, 0, 0, 0, 0, 0, 0, 1]].concat();
        let image = super::super::decode(&qoi(1)).expect("a picture");
        assert!(matches!(image.texels, Texels::Floats(_)));
        assert_eq!(texel(&image, 0), [0.2, 0.4, 1.0]);
        assert_eq!(texel(&super::super::decode(&qoi(0)).expect("a picture"), 0), [51.0, 102.0, 255.0]);
    }

    #[test]
    fn a_tga_is_read_without_first_bytes_of_its_own() {
        // 2 x 1, 24 bits, blue first; lowest row first, of which there is one.
        let mut bytes = vec![0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 2, 0, 1, 0, 24, 0];
        bytes.extend([3, 2, 1, 6, 5, 4]);
        let image = super::super::decode(&bytes).expect("a picture");
        assert_eq!([texel(&image, 0), texel(&image, 1)], [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
        super::super::decode(&bytes[..20]).expect_err("cut off");
        super::super::decode(b"nothing at all, in many words").expect_err("no picture");
    }
}
