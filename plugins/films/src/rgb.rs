//! `rgb`: linear sRGB pictures.
//!
//! Spectral samples go to CIE 1931 XYZ, `XYZ = integral(L xyz-bar) / integral(y-bar)`, and on to linear sRGB primaries: the
//! channels R, G, B of the EXR file. The PNG beside it shows the same after exposure, tone curve and sRGB encoding, which never
//! touch the EXR file; `bhs develop` makes another one of it. Colours out of sRGB's gamut keep hue and lightness. Wavelengths are recorded from `lambdamin` to `lambdamax`, as the camera receives them.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `xresolution` | integer | 1280 | pixels | width |
//! | `yresolution` | integer | 720 | pixels | height |
//! | `cropwindow` | float | [0 1 0 1] | | part that is rendered: x from, x to, y from, y to, of width and height |
//! | `filename` | string | "" | | file to write, seen from where the program is started; if empty, the scene's name with .exr |
//! | `lambdamin` | float | 360 | nm | least recorded wavelength |
//! | `lambdamax` | float | 830 | nm | greatest recorded wavelength |
//! | `exposure` | float | 0 | stops | brightness of the PNG |
//! | `tonecurve` | string | "clip" | | of the PNG: `clip`, `reinhard`, `aces` or `agx` |
//! | `bloom` | float | 0 | pixels | radius of the glare of an aperture in the PNG, at 550 nm; 0: none |
//! | `imagingratio` | float | 1 | | multiplies what is recorded, in the EXR file too |
//! | `whitebalance` | float | none | K | temperature of the daylight that is to look white |
//! | `maxcomponentvalue` | float | none | | largest X, Y or Z of a sample; a brighter one keeps its colour |
//!
//! What a picture records besides colour (`layers`) is read by the directive of the film.
//!
//! ```bhs
//! Film "rgb" "integer xresolution" 640 "integer yresolution" 480 "float exposure" 1
//! WorldBegin
//! ```

use crate::picture::Picture;
use bhs_core::Plugin;
use bhs_core::camera::{Film, Look};
use bhs_core::params::Params;
use bhs_core::spectrum::{SampledSpectrum, SampledWavelengths};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Film> = Plugin { name: "rgb", summary: "linear sRGB pictures", build };

struct Rgb(Picture);

fn build(p: &Params) -> Option<Box<dyn Film>> {
    Some(Box::new(Rgb(Picture::read(p)?)))
}

impl Film for Rgb {
    fn resolution(&self) -> [u32; 2] {
        self.0.resolution
    }

    fn crop(&self) -> [u32; 4] {
        self.0.crop
    }

    fn filename(&self) -> &str {
        &self.0.filename
    }

    fn lambda_range(&self) -> [f32; 2] {
        self.0.range
    }

    fn channels(&self) -> Vec<String> {
        ["R", "G", "B"].map(str::to_owned).to_vec()
    }

    fn add(&self, radiance: SampledSpectrum, lambda: &SampledWavelengths, sums: &mut [f64]) {
        self.0.add(radiance, lambda, sums);
    }

    fn limited(&self, radiance: SampledSpectrum, lambda: &SampledWavelengths) -> SampledSpectrum {
        self.0.limited(radiance, lambda)
    }

    fn look(&self) -> Look {
        self.0.look
    }
}
