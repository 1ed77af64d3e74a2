//! `marble`: layers along y, folded by noise of many sizes, grey with dark veins.
//!
//! The pattern fills space, in the coordinates in which the texture was defined: at the point p, which is `scale` times that, the layer is
//! `1/2 + 1/2 sin(p.y + variation noise(p))`, and its colour is that place of a spline through greys. A texture of floats is the mean of the
//! channels.
//!
//! Names, defaults, colours and meaning of pbrt-v4 (Pharr, Jakob and Humphreys 2023, "Physically Based Rendering", section 10.5.5); its noise is
//! another one.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `octaves` | integer | 8 | | how many sizes of noise are added, each half of the one before |
//! | `roughness` | float | 0.5 | | strength of each over that of the one before |
//! | `scale` | float | 1 | | factor of coordinates: a large one makes the layers thin |
//! | `variation` | float | 0.2 | | how far noise moves the layers |
//!
//! ```bhs
//! WorldBegin
//! Texture "stone" "spectrum" "marble" "float scale" 4 "float variation" 3
//! ```

use crate::mapping::Space;
use crate::noise::Octaves;
use bhs_core::Plugin;
use bhs_core::material::Shading;
use bhs_core::params::Params;
use bhs_core::spectrum::{SampledSpectrum, SpectrumRole};
use bhs_core::texture::{Texture, TextureKind};
use bhs_elementary::Elementary;
use bhs_spectra::{SmoothSpectra, d65};
use glam::Vec3;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Texture> = Plugin { name: "marble", summary: "folded layers of grey stone, in space", build };

/// What the colours are multiplied with.
const STRENGTH: f32 = 1.5;

const LIGHT: Vec3 = Vec3::new(0.58, 0.58, 0.6);

/// Linear sRGB, from one side of a layer to the other.
const COLOURS: [Vec3; 9] =
    [LIGHT, LIGHT, LIGHT, Vec3::splat(0.5), Vec3::new(0.6, 0.59, 0.58), LIGHT, LIGHT, Vec3::new(0.2, 0.2, 0.33), LIGHT];

struct Marble {
    space: Space,
    octaves: Octaves,
    scale: f64,
    variation: f64,
    /// For what its spectra are.
    role: SpectrumRole,
    spectra: &'static SmoothSpectra,
}

fn build(p: &Params) -> Option<Box<dyn Texture>> {
    let octaves = Octaves::read(p);
    let scale = p.get_in("scale", 1.0, -1e9..=1e9, "", "factor of coordinates: a large one makes the layers thin");
    let variation = p.get_in("variation", 0.2, -1e6..=1e6, "", "how far noise moves the layers");
    let role = match p.context().named.kind() {
        TextureKind::Spectrum(role) => role,
        TextureKind::Float | TextureKind::Triple => SpectrumRole::Unbounded,
    };
    let space = Space::read(p);
    Some(Box::new(Marble { space, octaves, scale, variation, role, spectra: SmoothSpectra::get() }))
}

/// The colour at a place between 0 and 1: on a cubic Bezier curve of four colours, which begins with each of the first six.
fn colour(place: f32) -> Vec3 {
    const CURVES: usize = COLOURS.len() - 3;
    let along = place.clamp(0.0, 1.0) * CURVES as f32;
    let first = (along as usize).min(CURVES - 1);
    let (t, [a, b, c, d]) = (along - first as f32, std::array::from_fn(|i| COLOURS[first + i]));
    let (ab, bc, cd) = (a.lerp(b, t), b.lerp(c, t), c.lerp(d, t));
    ab.lerp(bc, t).lerp(bc.lerp(cd, t), t) * STRENGTH
}

impl Marble {
    fn rgb(&self, at: &Shading) -> Vec3 {
        let p = self.space.place(at) * self.scale;
        let layer = p.y + self.variation * self.octaves.in_space(p);
        colour((0.5 + 0.5 * layer.sine()) as f32)
    }
}

impl Texture for Marble {
    fn spectrum(&self, at: &Shading) -> SampledSpectrum {
        // At most 0.9 of each.
        let smooth = self.spectra.of(self.rgb(at).to_array());
        let values = SampledSpectrum(at.lambda_nm.map(|l| smooth.at(l)));
        if self.role == SpectrumRole::Emission { values * d65().sample(at.lambda_nm) } else { values }
    }

    fn float(&self, at: &Shading) -> f32 {
        self.rgb(at).element_sum() / 3.0
    }
}
