//! One sample of one pixel: its ray and wavelengths, and what the film receives of it.

use crate::job::Job;
use crate::not_finite::SampleId;
use bhs_core::sampling::SampleStream;
use bhs_core::spectrum::{SampledSpectrum, SampledWavelengths, VisibleWavelengths};
use bhs_engine::stats::PathLog;
use bhs_engine::transport::PathSample;
use glam::DVec2;

/// One sample of one pixel, as its observer sees it.
pub struct CameraSample {
    /// Which.
    pub id: SampleId,
    /// The filter's weight.
    pub weight: f32,
    /// Wavelengths where the ray starts.
    pub lambda: SampledWavelengths,
    /// Wavelength where the ray starts over wavelength at E = 1, of the light that arrives along it; `None` where there is no static observer.
    ratio: Option<f64>,
}

impl CameraSample {
    /// The sample, and the path that is to be followed for it.
    #[inline]
    pub fn new<'a>(
        job: &Job<'a>,
        wavelengths: &VisibleWavelengths,
        id: SampleId,
        mut stream: SampleStream<'a>,
    ) -> (Self, PathSample<'a>) {
        let (offset, weight) = job.filter.sample(stream.next_2d());
        let raster = DVec2::new(f64::from(id.pixel[0]) + 0.5, f64::from(id.pixel[1]) + 0.5) + offset.as_dvec2();
        let (ray, ratio) = job.camera_ray(raster, stream.next_2d());
        let lambda = wavelengths.sample(stream.wavelengths());
        let seen = Self { id, weight, lambda, ratio };
        let along = match seen.ratio {
            Some(ratio) if ratio != 1.0 => SampledWavelengths { lambda_nm: lambda.at(ratio.recip() as f32), ..lambda },
            _ => lambda,
        };
        (seen, PathSample::new(ray, along, stream))
    }

    /// Wavelength where the ray starts over wavelength at E = 1; 1 where there is no static observer.
    pub fn camera_ratio(&self) -> f64 {
        self.ratio.unwrap_or(1.0)
    }

    /// Adds what `path` has found to the pixel's sums and returns the weight that it has there; `None`, and adds nothing, if it is not
    /// finite.
    #[inline]
    pub fn add(&self, job: &Job, path: &PathSample, sums: &mut [f64], log: &mut PathLog) -> Option<f64> {
        log.counters.paths += 1;
        // Weighted, as it is added: that may overflow too.
        let received = job.film.limited(self.received(job, path.radiance, log), &self.lambda);
        let weighted = received * self.weight;
        if !weighted.is_finite() {
            log.counters.not_finite += 1;
            return None;
        }
        job.film.add(weighted, &self.lambda, sums);
        Some(f64::from(self.weight))
    }

    /// The spectral radiance `radiance` at E = 1 as the observer measures it where the ray starts.
    #[inline]
    pub fn received(&self, job: &Job, radiance: SampledSpectrum, log: &mut PathLog) -> SampledSpectrum {
        match self.ratio {
            Some(1.0) => radiance,
            Some(ratio) => radiance * job.scene.radiance_factor(ratio.recip()),
            None => {
                log.counters.no_static_observer += 1;
                SampledSpectrum::ZERO
            }
        }
    }
}
