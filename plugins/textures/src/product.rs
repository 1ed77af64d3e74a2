//! `product`: two textures, each of which may be a plain value, multiplied with one another.
//!
//! Of spectra it is the product at each wavelength: a colour that tints a picture, a picture on another one. Of light, `tex1` is the light and `tex2` a
//! filter before it. pbrt has no such texture.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `tex1`, `tex2` | spectrum, texture | 1 | | the two; floats in a texture of floats |
//!
//! ```bhs
//! WorldBegin
//! Texture "tiles" "spectrum" "checkerboard" "rgb tex1" [1 1 1] "rgb tex2" [0.5 0.5 0.5] "float uscale" 8 "float vscale" 8
//! Texture "red tiles" "spectrum" "product" "texture tex1" "tiles" "rgb tex2" [0.8 0.1 0.1]
//! ```

use bhs_core::Plugin;
use bhs_core::material::Shading;
use bhs_core::params::Params;
use bhs_core::spectrum::SampledSpectrum;
use bhs_core::texture::composite::{Composite, KnownParts, evaluations};
use bhs_core::texture::{Texture, TextureInput};

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Texture> = Plugin { name: "product", summary: "two textures or values, multiplied", build };

struct Product {
    factors: [TextureInput; 2],
    evaluations: u64,
}

fn build(p: &Params) -> Option<Box<dyn Texture>> {
    let factors = [p.texture_input("tex1", 1.0, "one of the two"), p.texture_factor("tex2", 1.0, "the other one")];
    let evaluations = evaluations(factors.iter().map(TextureInput::evaluations));
    Some(Box::new(Product { factors, evaluations }))
}

impl Composite for Product {
    fn evaluations(&self) -> u64 {
        self.evaluations
    }

    fn spectrum_with(&self, at: &Shading, known: &mut KnownParts) -> SampledSpectrum {
        let [a, b] = &self.factors;
        // As of `scale`: what two large numbers make stays one.
        (a.spectrum_with(at, known) * b.spectrum_with(at, known)).map(|v| v.min(f32::MAX))
    }

    fn float_with(&self, at: &Shading, known: &mut KnownParts) -> f32 {
        let [a, b] = &self.factors;
        (a.float_with(at, known) * b.float_with(at, known)).clamp(f32::MIN, f32::MAX)
    }
}
