//! What all films share: size, crop and file, the range of wavelengths, linear sRGB, and how that is displayed.

use crate::sensor::Sensor;
use bhs_colour::{MatchingFunctions, ToneCurve, Y_INTEGRAL, srgb_from_xyz};
use bhs_core::camera::Look;
use bhs_core::params::Params;
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, SampledWavelengths};

/// A picture in linear sRGB.
pub(crate) struct Picture {
    pub resolution: [u32; 2],
    pub crop: [u32; 4],
    pub filename: String,
    pub range: [f32; 2],
    observer: MatchingFunctions,
    sensor: Sensor,
    pub look: Look,
}

impl Picture {
    /// Reads them.
    pub fn read(p: &Params) -> Option<Self> {
        let x = p.get_in("xresolution", 1280, 1..=65_536, "pixels", "width") as u32;
        let y = p.get_in("yresolution", 720, 1..=65_536, "pixels", "height") as u32;
        let window = p.get(
            "cropwindow",
            vec![0.0, 1.0, 0.0, 1.0],
            "",
            "part that is rendered: x from, x to, y from, y to, of width and height",
        );
        let filename = p.get(
            "filename",
            String::new(),
            "",
            "file to write, seen from where the program is started; if empty, the scene's name with .exr",
        );
        let lo = p.get_in("lambdamin", 360.0, 1.0..=1e7, "nm", "least recorded wavelength") as f32;
        let hi = p.get_in("lambdamax", 830.0, 1.0..=1e7, "nm", "greatest recorded wavelength") as f32;
        let exposure = p.get_in("exposure", 0.0, -64.0..=64.0, "stops", "brightness of the PNG");
        let curve = p.get("tonecurve", "clip".to_owned(), "", "of the PNG: `clip`, `reinhard`, `aces` or `agx`");
        let bloom =
            p.get_in("bloom", 0.0, 0.0..=1000.0, "pixels", "radius of the glare of an aperture in the PNG, at 550 nm; 0: none");
        let sensor = Sensor::read(p);
        if lo >= hi {
            p.reject("lambdamax", "`lambdamax` is not above `lambdamin`", format!("expected more than {lo} nm"));
            return None;
        }
        let curve = ToneCurve::find(&curve).unwrap_or_else(|| {
            p.reject("tonecurve", "unknown tone curve", "expected `clip`, `reinhard`, `aces` or `agx`");
            ToneCurve::default()
        });
        let crop = match window.as_slice() {
            &[x0, x1, y0, y1] if (0.0..x1).contains(&x0) && (0.0..y1).contains(&y0) && x1 <= 1.0 && y1 <= 1.0 => {
                // As in pbrt: from the first pixel at or after the start to the last before the end.
                let at = |f: f64, n: u32| (f * f64::from(n)).ceil() as u32;
                [at(x0, x), at(x1, x), at(y0, y), at(y1, y)]
            }
            _ => {
                p.reject(
                    "cropwindow",
                    "`cropwindow` expects 4 numbers",
                    "x from, x to, y from, y to, between 0 and 1, from below to",
                );
                [0, x, 0, y]
            }
        };
        if crop[0] >= crop[1] || crop[2] >= crop[3] {
            p.reject("cropwindow", "`cropwindow` holds no pixel", "expected a window that holds at least one pixel");
        }
        Some(Self {
            resolution: [x, y],
            crop,
            filename,
            range: [lo, hi],
            observer: MatchingFunctions::cie_1931(),
            sensor,
            look: Look { exposure, curve: curve.name(), bloom },
        })
    }

    /// Adds one sample of `radiance` (not yet divided by the wavelengths' densities) to red, green and blue.
    pub fn add(&self, radiance: SampledSpectrum, lambda: &SampledWavelengths, sums: &mut [f64]) {
        let xyz = self.sensor.developed(self.xyz(radiance, lambda));
        for (sum, value) in sums.iter_mut().zip(srgb_from_xyz(xyz)) {
            *sum += value;
        }
    }

    /// A sample as far as the sensor takes it.
    pub fn limited(&self, radiance: SampledSpectrum, lambda: &SampledWavelengths) -> SampledSpectrum {
        match self.sensor.is_limited() {
            true => radiance * self.sensor.limit(self.xyz(radiance, lambda)),
            false => radiance,
        }
    }

    /// The factor of the sensor.
    pub fn imaging_ratio(&self) -> f64 {
        self.sensor.ratio
    }

    /// XYZ of one sample of `radiance` (not yet divided by the wavelengths' densities).
    fn xyz(&self, radiance: SampledSpectrum, lambda: &SampledWavelengths) -> [f64; 3] {
        let mut xyz = [0.0; 3];
        for i in 0..N_LAMBDA {
            let weight = f64::from(radiance[i]) / (f64::from(lambda.pdf[i]) * N_LAMBDA as f64 * Y_INTEGRAL);
            let matching = self.observer.at(lambda.lambda_nm[i]);
            for k in 0..3 {
                xyz[k] += weight * f64::from(matching[k]);
            }
        }
        xyz
    }
}
