//! Pictures in files: what comes back of those that the codecs' own encoders write, and what comes of damaged ones.

use bhs_core::image::{Image, Texels};
use bhs_core::sampling::mix64;
use bhs_textures::decode::decode;
use exr::prelude::write_rgb_file;
use image::{DynamicImage, ImageBuffer, ImageFormat, Luma, Rgb, Rgba};
use std::io::Cursor;

const SIZE: [u32; 2] = [5, 3];

/// A value for every texel and channel that tells them apart.
fn value(x: u32, y: u32, c: u32) -> u8 {
    (10 + 40 * x + 15 * y + 5 * c) as u8
}

fn written(picture: &DynamicImage, format: ImageFormat) -> Vec<u8> {
    let mut bytes = Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format).expect("the encoder works");
    bytes.into_inner()
}

fn bytes_picture() -> DynamicImage {
    let [w, h] = SIZE;
    ImageBuffer::from_fn(w, h, |x, y| Rgb([0, 1, 2].map(|c| value(x, y, c)))).into()
}

fn float_picture() -> DynamicImage {
    let [w, h] = SIZE;
    ImageBuffer::from_fn(w, h, |x, y| Rgb([0, 1, 2].map(|c| f32::from(value(x, y, c)) / 32.0))).into()
}

fn exr_bytes() -> Vec<u8> {
    let [w, h] = SIZE.map(|s| s as usize);
    let folder = tempfile::tempdir().expect("a folder for a file");
    let path = folder.path().join("picture.exr");
    let texel = |x: usize, y: usize, c| f32::from(value(x as u32, y as u32, c)) / 32.0;
    write_rgb_file(&path, w, h, |x, y| (texel(x, y, 0), texel(x, y, 1), texel(x, y, 2))).expect("the encoder works");
    std::fs::read(&path).expect("the file is there")
}

fn files() -> Vec<(&'static str, Vec<u8>)> {
    vec![
        ("png", written(&bytes_picture(), ImageFormat::Png)),
        ("jpeg", written(&bytes_picture(), ImageFormat::Jpeg)),
        ("hdr", written(&float_picture(), ImageFormat::Hdr)),
        ("exr", exr_bytes()),
    ]
}

/// The texel in a column and a row, in parts of the largest value of a byte or in light.
fn texel(image: &Image, x: u32, y: u32) -> [f32; 3] {
    let i = (y * image.width + x) as usize;
    match &image.texels {
        Texels::Bytes(t) => t[i].map(f32::from),
        Texels::Words(t) => t[i].map(|v| f32::from(v) / 257.0),
        Texels::Floats(t) => t[i].map(|v| v * 32.0),
    }
}

#[test]
fn pictures_come_back() {
    for (name, bytes) in files() {
        let image = decode(&bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!([image.width, image.height], SIZE, "{name}");
        let tolerance = match name {
            "png" => 0.0,
            "jpeg" => 30.0,
            // Eight bits of a common exponent.
            "hdr" => 2.0,
            _ => 1e-4,
        };
        for (x, y) in (0..SIZE[0]).flat_map(|x| (0..SIZE[1]).map(move |y| (x, y))) {
            for (c, v) in texel(&image, x, y).into_iter().enumerate() {
                let wanted = f32::from(value(x, y, c as u32));
                assert!((v - wanted).abs() <= tolerance, "{name} {x} {y} {c}: {v} {wanted}");
            }
        }
    }
}

#[test]
fn grey_deep_and_transparent_pictures_are_read() {
    let [w, h] = SIZE;
    let grey: DynamicImage = ImageBuffer::from_fn(w, h, |x, y| Luma([value(x, y, 0)])).into();
    let deep: DynamicImage = ImageBuffer::from_fn(w, h, |x, y| Rgb([0, 1, 2].map(|c| u16::from(value(x, y, c)) * 257))).into();
    let clear: DynamicImage = ImageBuffer::from_fn(w, h, |x, y| Rgba([value(x, y, 0), value(x, y, 1), value(x, y, 2), 7])).into();
    let read = |picture| decode(&written(&picture, ImageFormat::Png)).expect("a picture");
    assert_eq!(texel(&read(grey), 3, 1), [f32::from(value(3, 1, 0)); 3]);
    let colour = [0, 1, 2].map(|c| f32::from(value(3, 1, c)));
    let deep = read(deep);
    assert!(matches!(deep.texels, Texels::Words(_)));
    assert_eq!(texel(&deep, 3, 1), colour);
    assert_eq!(texel(&read(clear), 3, 1), colour);
}

#[test]
fn what_is_no_picture_says_so() {
    for bytes in [&b""[..], b"# a scene", b"\x89PNG\r\n\x1a\n", b"\x76\x2f\x31\x01\x02\x00\x00\x00", b"GIF89a\x01\x00\x01\x00"] {
        let error = decode(bytes).expect_err("no picture");
        assert!(!error.is_empty(), "{bytes:?}");
    }
    // A header that promises more than there may be is no reason to ask for memory.
    let mut huge = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n".to_vec();
    huge.extend([1; 64]);
    decode(&huge).expect_err("too large");
}

#[test]
fn sizes_have_limits() {
    // Wider than a picture may be, and small all the same.
    let wide: DynamicImage = ImageBuffer::from_fn(65_537, 1, |_, _| Luma([0u8])).into();
    let error = decode(&written(&wide, ImageFormat::Png)).expect_err("too wide");
    assert_eq!(error, "it is too large: 65537 x 1, at most 65536 a side");
    // An EXR file that claims to be larger than it is.
    let mut exr = exr_bytes();
    let window = b"dataWindow\0box2i\0";
    let at = exr.windows(window.len()).position(|w| w == window).expect("it has one") + window.len() + 4;
    exr[at..at + 16].copy_from_slice([0i32, 0, 99_999, 99_999].map(i32::to_le_bytes).as_flattened());
    assert_eq!(decode(&exr).expect_err("too large"), "it is too large: 100000 x 100000, at most 65536 a side");
    exr[at..at + 16].copy_from_slice([0i32, 0, 9_999, 9_999].map(i32::to_le_bytes).as_flattened());
    let error = decode(&exr).expect_err("more than it holds");
    assert_eq!(error, format!("it is damaged: {} bytes cannot hold 10000 x 10000 texels", exr.len()));
}

#[test]
fn damaged_pictures_are_errors_or_other_pictures() {
    for (name, whole) in files() {
        for k in 0..1500u64 {
            let mut bytes = whole.clone();
            let number = |i: u64| mix64(mix64(k) ^ i) as usize;
            for i in 0..1 + number(0) % 4 {
                let at = number(3 * i as u64 + 1) % bytes.len();
                match number(3 * i as u64 + 2) % 4 {
                    0 => bytes.truncate(at.max(1)),
                    1 => {
                        bytes.remove(at);
                        if bytes.is_empty() {
                            bytes.push(0);
                        }
                    }
                    _ => bytes[at] = number(3 * i as u64 + 3) as u8,
                }
            }
            if let Ok(image) = decode(&bytes) {
                let count = image.width as usize * image.height as usize;
                let texels = match &image.texels {
                    Texels::Bytes(t) => t.len(),
                    Texels::Words(t) => t.len(),
                    Texels::Floats(t) => t.len(),
                };
                assert!(count == texels && count > 0, "{name} {k}");
            }
        }
    }
}
