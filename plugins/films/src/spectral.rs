//! `spectral`: pictures with a channel for each part of the spectrum, beside linear sRGB.
//!
//! The range from `lambdamin` to `lambdamax` is divided into `nbuckets` equal parts; the channel of each is the mean spectral radiance over
//! it [W m^-2 sr^-1 nm^-1], as the camera receives it. Channels have the names of pbrt-v4: `S0.` and the middle of the bucket, with a comma
//! for the decimal point, such as `S0.374,688nm`. R, G and B and the PNG are those of the film `rgb`.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `nbuckets` | integer | 16 | | parts of the spectrum |
//!
//! and all parameters of the film `rgb`.
//!
//! ```bhs
//! Film "spectral" "integer nbuckets" 8 "integer xresolution" 64 "integer yresolution" 64
//! WorldBegin
//! ```

use crate::picture::Picture;
use bhs_core::Plugin;
use bhs_core::camera::{Film, Look};
use bhs_core::params::Params;
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, SampledWavelengths};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Film> =
    Plugin { name: "spectral", summary: "a channel for each part of the spectrum, beside linear sRGB", build };

struct Spectral {
    picture: Picture,
    buckets: usize,
}

fn build(p: &Params) -> Option<Box<dyn Film>> {
    let buckets = p.get_in("nbuckets", 16, 1..=4096, "", "parts of the spectrum") as usize;
    Some(Box::new(Spectral { picture: Picture::read(p)?, buckets }))
}

impl Spectral {
    /// Width of a bucket (nm).
    fn width(&self) -> f32 {
        (self.picture.range[1] - self.picture.range[0]) / self.buckets as f32
    }
}

impl Film for Spectral {
    fn resolution(&self) -> [u32; 2] {
        self.picture.resolution
    }

    fn crop(&self) -> [u32; 4] {
        self.picture.crop
    }

    fn filename(&self) -> &str {
        &self.picture.filename
    }

    fn lambda_range(&self) -> [f32; 2] {
        self.picture.range
    }

    fn channels(&self) -> Vec<String> {
        let middle = |i: usize| f64::from(self.picture.range[0]) + (i as f64 + 0.5) * f64::from(self.width());
        // A point would make a layer of what follows it.
        let bucket = |i: usize| format!("S0.{}nm", format!("{:.3}", middle(i)).replace('.', ","));
        ["R", "G", "B"].map(str::to_owned).into_iter().chain((0..self.buckets).map(bucket)).collect()
    }

    fn add(&self, radiance: SampledSpectrum, lambda: &SampledWavelengths, sums: &mut [f64]) {
        self.picture.add(radiance, lambda, sums);
        // Who asks for the colour alone has no room for more.
        let Some(buckets) = sums.get_mut(3..).filter(|b| !b.is_empty()) else { return };
        for i in 0..N_LAMBDA {
            let bucket = ((lambda.lambda_nm[i] - self.picture.range[0]) / self.width()) as usize;
            let density = f64::from(lambda.pdf[i]) * N_LAMBDA as f64 * f64::from(self.width());
            buckets[bucket.min(self.buckets - 1)] += self.picture.imaging_ratio() * f64::from(radiance[i]) / density;
        }
    }

    fn limited(&self, radiance: SampledSpectrum, lambda: &SampledWavelengths) -> SampledSpectrum {
        self.picture.limited(radiance, lambda)
    }

    fn look(&self) -> Look {
        self.picture.look
    }
}
