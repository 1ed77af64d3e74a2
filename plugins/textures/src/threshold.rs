//! `threshold`: 1 where a texture reaches a value, 0 elsewhere; of spectra, wavelength by wavelength.
//!
//! With it a picture of how opaque something is cuts leaves and fences out of their cards: glTF's alpha mode MASK. pbrt has no such texture.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `tex` | spectrum, texture | 1 | | what is compared; a float in a texture of floats |
//! | `cutoff` | float | 0.5 | | the least value that becomes 1 |
//!
//! ```bhs
//! WorldBegin
//! Texture "waves" "float" "fbm"
//! Texture "islands" "float" "threshold" "texture tex" "waves" "float cutoff" 0.2
//! ```

use bhs_core::Plugin;
use bhs_core::material::Shading;
use bhs_core::params::Params;
use bhs_core::spectrum::SampledSpectrum;
use bhs_core::texture::composite::{Composite, KnownParts, evaluations};
use bhs_core::texture::{Texture, TextureInput};

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Texture> = Plugin { name: "threshold", summary: "1 where a texture reaches a value, else 0", build };

struct Threshold {
    tex: TextureInput,
    cutoff: f32,
    evaluations: u64,
}

fn build(p: &Params) -> Option<Box<dyn Texture>> {
    let tex = p.texture_input("tex", 1.0, "what is compared");
    let cutoff = p.get_in("cutoff", 0.5, -1e30..=1e30, "", "the least value that becomes 1") as f32;
    let evaluations = evaluations([tex.evaluations()]);
    Some(Box::new(Threshold { tex, cutoff, evaluations }))
}

impl Composite for Threshold {
    fn evaluations(&self) -> u64 {
        self.evaluations
    }

    fn spectrum_with(&self, at: &Shading, known: &mut KnownParts) -> SampledSpectrum {
        self.tex.spectrum_with(at, known).map(|v| if v >= self.cutoff { 1.0 } else { 0.0 })
    }

    fn float_with(&self, at: &Shading, known: &mut KnownParts) -> f32 {
        if self.tex.float_with(at, known) >= self.cutoff { 1.0 } else { 0.0 }
    }
}
