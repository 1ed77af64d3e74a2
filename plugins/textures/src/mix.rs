//! `mix`: a value between two others: `(1 - amount) tex1 + amount tex2`.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `tex1` | spectrum, texture | 0 | | the value where `amount` is 0; a float in a texture of floats |
//! | `tex2` | spectrum, texture | 1 | | the value where `amount` is 1 |
//! | `amount` | float, texture | 0.5 | | 0 to 1 |
//!
//! ```bhs
//! WorldBegin
//! Texture "orange" "spectrum" "mix" "rgb tex1" [1 0 0] "rgb tex2" [1 1 0] "float amount" 0.4
//! ```

use bhs_core::Plugin;
use bhs_core::material::Shading;
use bhs_core::params::Params;
use bhs_core::spectrum::SampledSpectrum;
use bhs_core::texture::composite::{Composite, KnownParts, evaluations};
use bhs_core::texture::{FloatParameter, Texture, TextureInput};

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Texture> = Plugin { name: "mix", summary: "a value between two others", build };

struct Mix {
    tex1: TextureInput,
    tex2: TextureInput,
    amount: FloatParameter,
    evaluations: u64,
}

fn build(p: &Params) -> Option<Box<dyn Texture>> {
    let tex1 = p.texture_input("tex1", 0.0, "the value where `amount` is 0");
    let tex2 = p.texture_input("tex2", 1.0, "the value where `amount` is 1");
    let amount = p.float_parameter("amount", 0.5, 0.0..=1.0, "", "0 to 1");
    let evaluations = evaluations([tex1.evaluations(), tex2.evaluations(), amount.evaluations()]);
    Some(Box::new(Mix { tex1, tex2, amount, evaluations }))
}

impl Composite for Mix {
    fn evaluations(&self) -> u64 {
        self.evaluations
    }

    fn spectrum_with(&self, at: &Shading, known: &mut KnownParts) -> SampledSpectrum {
        let amount = self.amount.at_with(at, known);
        self.tex1.spectrum_with(at, known) * (1.0 - amount) + self.tex2.spectrum_with(at, known) * amount
    }

    fn float_with(&self, at: &Shading, known: &mut KnownParts) -> f32 {
        let amount = self.amount.at_with(at, known);
        self.tex1.float_with(at, known) * (1.0 - amount) + self.tex2.float_with(at, known) * amount
    }
}
