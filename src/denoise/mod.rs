//! Takes the noise out of pictures with Intel's Open Image Denoise (`oidn`), which is loaded when it is needed (`library`).
//!
//! The filter is a trained network. It is guided by two layers, `albedo` and `normal`, which have noise of their own where a picture has few samples:
//! they are filtered first, each by itself, as the library's guide asks (`guides`). Light may have any brightness and is not clamped: the network sees it
//! scaled (`light`). It knows no negative light, which colours outside of sRGB have in some channel: that is filtered by itself, and taken off again, so
//! that it keeps its mean.
//! Stars that the picture draws are exact, and would be lost as noise: they are taken off before, and added afterwards.
//!
//! The same picture, library and machine give the same numbers for any number of threads.

mod guides;
mod library;
mod light;
mod oidn;

pub use library::Missing;

use crate::image::Picture;
use oidn::{Device, FilterSettings, Library};
use std::ffi::CStr;

/// The layers that guide the filter: names as `--aov` has them, and of their channels, in files of bhs and, in small letters, of others.
const GUIDES: [(&str, [&str; 3], [&str; 3]); 2] = [
    ("albedo", ["Albedo.R", "Albedo.G", "Albedo.B"], ["albedo.r", "albedo.g", "albedo.b"]),
    ("normal", ["N.X", "N.Y", "N.Z"], ["normal.x", "normal.y", "normal.z"]),
];

/// Names of the layers that guide the filter.
pub const LAYERS: [&str; 2] = [GUIDES[0].0, GUIDES[1].0];

/// Channels of the colours.
pub const COLORS: [&str; 3] = ["R", "G", "B"];
/// Channels that keep the colours as they were before.
pub const NOISY: [&str; 3] = ["noisy.R", "noisy.G", "noisy.B"];
/// Channels of what the stars that a picture draws add to its colours.
pub const STARS: [&str; 3] = ["stars.R", "stars.G", "stars.B"];

/// Share of all light from which on negative light is filtered by itself.
const NEGATIVE: f64 = 1e-4;

/// Memory that the library may use beyond the images (MB). With less it works on parts, one after the other, with the same result.
const MOST_MEGABYTES: u16 = 1000;

/// Why a picture cannot be denoised.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// It has no colours.
    #[error("it has no channels R, G and B")]
    NoColors,
    /// It lacks layers that guide the filter.
    #[error(
        "it has no layer {}, which {} the filter; render it with {}, or with `--denoise`, which records all that is needed",
        quoted(.0, "` and no layer `"),
        if .0.len() > 1 { "guide" } else { "guides" },
        quoted(&.0.iter().map(|name| format!("--aov {name}")).collect::<Vec<_>>(), " ")
    )]
    NoLayers(Vec<String>),
    /// There is not enough memory.
    #[error("there is not enough memory")]
    OutOfMemory,
    /// The library could not do it.
    #[error("Open Image Denoise says: {0}")]
    Library(String),
}

fn quoted(names: &[String], between: &str) -> String {
    format!("`{}`", names.join(between))
}

/// Memory that denoising a picture of so many pixels and channels takes, besides the picture itself (bytes).
pub fn bytes(pixels: u64, channels: usize) -> u64 {
    // Five images of three floats a pixel, the picture again as it is changed, and what the library uses: some 600 bytes a pixel, measured, and its
    // weights.
    let library = pixels.saturating_mul(600).min(u64::from(MOST_MEGABYTES) << 20);
    pixels.saturating_mul(5 * 12 + 3 * 4 * (channels as u64 + 6)).saturating_add(library).saturating_add(64 << 20)
}

/// Whether a picture has all that is needed to denoise it: the numbers of the channels of its colours, its albedo and its normals.
///
/// # Errors
/// What it lacks.
pub fn check(picture: &Picture) -> Result<[[usize; 3]; 3], Fault> {
    let colors = picture.find(COLORS).ok_or(Fault::NoColors)?;
    let guides = GUIDES.map(|(_, own, others)| picture.find(own).or_else(|| picture.find_ignoring_case(others)));
    match guides {
        [Some(albedo), Some(normal)] => Ok([colors, albedo, normal]),
        _ => {
            let missing = LAYERS.iter().zip(guides).filter(|(_, found)| found.is_none());
            Err(Fault::NoLayers(missing.map(|(name, _)| (*name).to_owned()).collect()))
        }
    }
}

/// Takes the noise out of pictures.
pub struct Denoiser {
    library: Library,
    threads: u16,
}

impl Denoiser {
    /// Loads the library, which is to use so many threads; all processors if not given.
    ///
    /// # Errors
    /// That there is none, and how to get it.
    pub fn load(threads: Option<u32>) -> Result<Self, Missing> {
        let threads = threads.map_or(0, |threads| threads.min(u32::from(u16::MAX)) as u16);
        library::load().map(|library| Self { library, threads })
    }

    /// What denoises, in words: for the header of files.
    pub fn name(&self) -> String {
        format!("Open Image Denoise {}", self.library.version())
    }

    /// The same picture with its colours denoised and, as channels [`NOISY`], as they were before. A picture that has these is denoised anew,
    /// from them.
    ///
    /// # Errors
    /// What it lacks, or what the library says went wrong.
    pub fn denoise(&self, picture: &Picture) -> Result<Picture, Fault> {
        let was_denoised = picture.find(NOISY).is_some();
        let [colors, albedo, normal] = check(picture)?;
        let source = picture.find(NOISY).unwrap_or(colors);
        let filtered = self.filter(picture, [source, albedo, normal], picture.find(STARS))?;
        let mut result = picture.clone();
        if !was_denoised {
            result = result.with_channels(&NOISY, |pixel, into| into.extend(colors.map(|c| pixel[c])));
        }
        let stride = result.channels.len();
        for (pixel, denoised) in result.data.chunks_exact_mut(stride).zip(filtered.as_chunks::<3>().0) {
            (0..3).for_each(|c| pixel[colors[c]] = denoised[c]);
        }
        Ok(result)
    }

    /// The colours without noise; `channels` are the numbers of the channels of the colours, the albedo and the normals.
    fn filter(
        &self,
        picture: &Picture,
        [colors, albedo, normal]: [[usize; 3]; 3],
        stars: Option<[usize; 3]>,
    ) -> Result<Vec<f32>, Fault> {
        let device = Device::new(&self.library, self.threads).map_err(Fault::Library)?;
        let size = picture.size;
        let numbers = size[0] * size[1] * 3;
        let room = || crate::memory::filled(numbers, 0.0f32).map_err(|_| Fault::OutOfMemory);
        let settings = FilterSettings { most_megabytes: MOST_MEGABYTES, ..FilterSettings::default() };
        let run = |inputs: &[(&CStr, &[f32])], output: &mut [f32], settings| {
            device.filter(size, inputs, output, settings).map_err(Fault::Library)
        };

        // ---- The guides, by themselves.
        let mut raw = room()?;
        let [mut clean_albedo, mut clean_normal] = [room()?, room()?];
        picture.extract(albedo, &mut raw, |v| if v.is_nan() { 0.0 } else { v.clamp(0.0, 1.0) });
        run(&[(c"albedo", &raw)], &mut clean_albedo, settings)?;
        guides::keep_what_has_no_noise(&mut clean_albedo, &raw, size);
        picture.extract(normal, &mut raw, |v| if v.is_nan() { 0.0 } else { v.clamp(-1.0, 1.0) });
        run(&[(c"normal", &raw)], &mut clean_normal, settings)?;
        guides::keep_what_has_no_noise(&mut clean_normal, &raw, size);

        // ---- The colours.
        let mut light = raw;
        picture.extract(colors, &mut light, |v| v);
        let lamps = light::fill_holes(&mut light, size);
        if let Some(stars) = stars {
            for (light, pixel) in light.as_chunks_mut::<3>().0.iter_mut().zip(picture.pixels()) {
                (0..3).for_each(|c| light[c] -= pixel[stars[c]]);
            }
        }
        let sum = |negative: bool| light.iter().filter(|v| (**v < 0.0) == negative).map(|v| f64::from(v.abs())).sum::<f64>();
        let [negative, positive] = [sum(true), sum(false)];
        let settings = FilterSettings { hdr: true, clean_guides: true, ..settings };
        let color = |light: &mut [f32], output: &mut [f32]| {
            let stops = light::stops_to_one(light);
            light::brighten(light, stops);
            run(&[(c"color", light), (c"albedo", &clean_albedo), (c"normal", &clean_normal)], output, settings)?;
            light::brighten(output, -stops);
            Ok(())
        };
        let mut filtered = room()?;
        if positive == 0.0 && negative == 0.0 {
            // Where nothing is, nothing is made.
        } else if negative <= NEGATIVE * positive {
            light.iter_mut().for_each(|v| *v = v.max(0.0));
            color(&mut light, &mut filtered)?;
        } else {
            let mut below: Vec<f32> = light.iter().map(|v| (-v).max(0.0)).collect();
            light.iter_mut().for_each(|v| *v = v.max(0.0));
            color(&mut light, &mut filtered)?;
            color(&mut below, &mut light)?;
            filtered.iter_mut().zip(&light).for_each(|(v, below)| *v -= below);
        }
        if let Some(stars) = stars {
            for (light, pixel) in filtered.as_chunks_mut::<3>().0.iter_mut().zip(picture.pixels()) {
                (0..3).for_each(|c| light[c] += pixel[stars[c]]);
            }
        }
        filtered.iter_mut().for_each(|v| *v = crate::image::single_precision(f64::from(*v)));
        lamps.into_iter().for_each(|i| filtered[i] = f32::MAX);
        Ok(filtered)
    }
}
