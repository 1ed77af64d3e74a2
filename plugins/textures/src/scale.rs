//! `scale`: a texture times a number that may be a texture too.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `tex` | spectrum, texture | 1 | | what is scaled; a float in a texture of floats |
//! | `scale` | float, texture | 1 | | the factor |
//!
//! ```bhs
//! WorldBegin
//! Texture "dark" "spectrum" "scale" "rgb tex" [0.8 0.4 0.1] "float scale" 0.5
//! ```

use bhs_core::Plugin;
use bhs_core::material::Shading;
use bhs_core::params::Params;
use bhs_core::spectrum::SampledSpectrum;
use bhs_core::texture::composite::{Composite, KnownParts, evaluations};
use bhs_core::texture::{FloatParameter, Texture, TextureInput};

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Texture> = Plugin { name: "scale", summary: "a texture times a number or another texture", build };

struct Scale {
    tex: TextureInput,
    scale: FloatParameter,
    evaluations: u64,
}

fn build(p: &Params) -> Option<Box<dyn Texture>> {
    let tex = p.texture_input("tex", 1.0, "what is scaled");
    let scale = p.float_parameter("scale", 1.0, 0.0..=f64::from(f32::MAX), "", "the factor");
    let evaluations = evaluations([tex.evaluations(), scale.evaluations()]);
    Some(Box::new(Scale { tex, scale, evaluations }))
}

impl Composite for Scale {
    fn evaluations(&self) -> u64 {
        self.evaluations
    }

    fn spectrum_with(&self, at: &Shading, known: &mut KnownParts) -> SampledSpectrum {
        // Two large numbers: what they make would be no number where another texture multiplies it by 0.
        (self.tex.spectrum_with(at, known) * self.scale.at_with(at, known)).map(|v| v.min(f32::MAX))
    }

    fn float_with(&self, at: &Shading, known: &mut KnownParts) -> f32 {
        (self.tex.float_with(at, known) * self.scale.at_with(at, known)).clamp(f32::MIN, f32::MAX)
    }
}
