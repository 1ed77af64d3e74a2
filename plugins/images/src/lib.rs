//! Pictures that scenes read, from the bytes of their files to linear colours.
//!
//! OpenEXR, Radiance HDR, PNG and JPEG, told apart by their first bytes, through the crate `image`. Integer samples are taken as encoded in
//! sRGB, floating-point ones as linear, as in pbrt-v4.

use image::{DynamicImage, ImageReader, Limits};
use std::io::Cursor;

/// A picture: linear sRGB.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Width and height (pixels), both above 0.
    pub size: [usize; 2],
    /// Red, green and blue, row by row from the top.
    pub pixels: Vec<[f32; 3]>,
}

/// Largest side of a picture (pixels).
pub const LARGEST_SIDE: u32 = 32_768;

/// Memory that reading a picture may take: so much (bytes), and this many times the size of its file, which no compression in use
/// exceeds by much.
const MEMORY: u64 = 64 << 20;
const MEMORY_PER_BYTE: u64 = 1100;

impl Image {
    /// Reads the picture in `bytes`.
    ///
    /// # Errors
    /// What is wrong with it, in words that can follow "cannot read `path`: ".
    pub fn decode(bytes: &[u8]) -> Result<Self, String> {
        let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format().map_err(|e| e.to_string())?;
        if reader.format().is_none() {
            return Err("it is no picture in OpenEXR, Radiance HDR, PNG or JPEG".into());
        }
        let mut limits = Limits::default();
        limits.max_image_width = Some(LARGEST_SIDE);
        limits.max_image_height = Some(LARGEST_SIDE);
        limits.max_alloc = Some(MEMORY + MEMORY_PER_BYTE * bytes.len() as u64);
        reader.limits(limits);
        let decoded = reader.decode().map_err(|e| e.to_string())?;
        let size = [decoded.width() as usize, decoded.height() as usize];
        if size.contains(&0) {
            return Err("it has no pixels".into());
        }
        let is_linear = matches!(decoded, DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_));
        let decode = |v: f32| if is_linear { v } else { srgb_decode(v) };
        let pixels = decoded.into_rgb32f().pixels().map(|p| p.0.map(decode)).collect();
        Ok(Self { size, pixels })
    }
}

/// The linear value of one encoded in sRGB, 0 to 1 (IEC 61966-2-1).
pub fn srgb_decode(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { ((encoded + 0.055) / 1.055).powf(2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ImageFormat, Rgb, Rgb32FImage, RgbImage};

    fn encoded(image: &DynamicImage, format: ImageFormat) -> Vec<u8> {
        let mut bytes = Vec::new();
        image.write_to(&mut Cursor::new(&mut bytes), format).expect("memory can be written");
        bytes
    }

    #[test]
    fn floating_point_pictures_come_back_as_they_are() {
        let picture = Rgb32FImage::from_fn(3, 2, |x, y| Rgb([x as f32 * 2.0, y as f32, 0.25]));
        for format in [ImageFormat::OpenExr, ImageFormat::Hdr] {
            let read = Image::decode(&encoded(&DynamicImage::ImageRgb32F(picture.clone()), format)).expect("a picture");
            assert_eq!(read.size, [3, 2]);
            // The first row comes first, the first pixel of it at the left.
            assert_eq!(read.pixels[2], [4.0, 0.0, 0.25]);
            assert_eq!(read.pixels[3], [0.0, 1.0, 0.25]);
        }
    }

    #[test]
    fn bytes_are_srgb() {
        let picture = RgbImage::from_fn(2, 1, |x, _| Rgb([if x == 0 { 188 } else { 255 }, 0, 10]));
        let read = Image::decode(&encoded(&DynamicImage::ImageRgb8(picture), ImageFormat::Png)).expect("a picture");
        // 188 is half of the light of 255; 10 lies on the straight part of the curve.
        assert!((read.pixels[0][0] - 0.5029).abs() < 1e-3 && read.pixels[0][1] == 0.0, "{:?}", read.pixels);
        assert!((read.pixels[0][2] - 10.0 / 255.0 / 12.92).abs() < 1e-6 && read.pixels[1][0] == 1.0, "{:?}", read.pixels);
    }

    #[test]
    fn what_is_no_picture_says_so() {
        assert!(Image::decode(b"ply\nformat ascii 1.0\n").expect_err("no picture").contains("no picture"));
        assert!(Image::decode(&[]).is_err());
        let picture = Rgb32FImage::from_pixel(8, 8, Rgb([1.0; 3]));
        let whole = encoded(&DynamicImage::ImageRgb32F(picture), ImageFormat::OpenExr);
        assert!(Image::decode(&whole[..whole.len() - 40]).is_err());
    }
}
