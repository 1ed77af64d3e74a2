//! `constant`: the same value everywhere.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `value` | spectrum, texture | 1 | | the value; a float in a texture of floats |
//!
//! ```bhs
//! WorldBegin
//! Texture "grey" "spectrum" "constant" "spectrum value" 0.5
//! ```

use bhs_core::Plugin;
use bhs_core::material::Shading;
use bhs_core::params::Params;
use bhs_core::spectrum::SampledSpectrum;
use bhs_core::texture::composite::{Composite, KnownParts, evaluations};
use bhs_core::texture::{Texture, TextureInput};

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Texture> = Plugin { name: "constant", summary: "the same value everywhere", build };

struct Constant {
    value: TextureInput,
}

fn build(p: &Params) -> Option<Box<dyn Texture>> {
    Some(Box::new(Constant { value: p.texture_input("value", 1.0, "the value") }))
}

impl Composite for Constant {
    fn evaluations(&self) -> u64 {
        evaluations([self.value.evaluations()])
    }

    fn spectrum_with(&self, at: &Shading, known: &mut KnownParts) -> SampledSpectrum {
        self.value.spectrum_with(at, known)
    }

    fn float_with(&self, at: &Shading, known: &mut KnownParts) -> f32 {
        self.value.float_with(at, known)
    }
}
