//! `vertexcolor`: the colours that the vertices of a mesh have, between them what lies between.
//!
//! Only meshes of glTF files have such colours; elsewhere it is white. A texture of floats is how opaque the colour is. pbrt has no such texture.
//!
//! ```bhs
//! WorldBegin
//! Texture "painted" "spectrum" "vertexcolor"
//! Material "diffuse" "texture reflectance" "painted"
//! ```

use bhs_core::Plugin;
use bhs_core::material::Shading;
use bhs_core::params::Params;
use bhs_core::spectrum::SampledSpectrum;
use bhs_core::texture::Texture;
use bhs_spectra::SmoothSpectra;
use glam::Vec3;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Texture> =
    Plugin { name: "vertexcolor", summary: "the colours that the vertices of a glTF mesh have", build };

struct VertexColor {
    spectra: &'static SmoothSpectra,
}

fn build(_: &Params) -> Option<Box<dyn Texture>> {
    Some(Box::new(VertexColor { spectra: SmoothSpectra::get() }))
}

impl Texture for VertexColor {
    fn spectrum(&self, at: &Shading) -> SampledSpectrum {
        let rgb = at.colour.truncate().clamp(Vec3::ZERO, Vec3::ONE);
        if rgb == Vec3::ONE {
            return SampledSpectrum::ONE;
        }
        let smooth = self.spectra.of(rgb.to_array());
        SampledSpectrum(at.lambda_nm.map(|l| smooth.at(l)))
    }

    fn float(&self, at: &Shading) -> f32 {
        at.colour.w.clamp(0.0, 1.0)
    }
}
