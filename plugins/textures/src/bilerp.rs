//! `bilerp`: between four values, linearly along each of two coordinates.
//!
//! With (s, t), which are the texture coordinates by the mapping, the value is `(1-s)(1-t) v00 + s (1-t) v10 + (1-s) t v01 + s t v11`; beyond the unit
//! square it goes on so.
//!
//! Names, defaults and meaning of pbrt-v4.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `v00`, `v10` | spectrum, texture | 0 | | the values at (0, 0) and (1, 0); floats in a texture of floats |
//! | `v01`, `v11` | spectrum, texture | 1 | | the values at (0, 1) and (1, 1) |
//! | `mapping` | string | "uv" | | how a point is placed: `uv`, `spherical`, `cylindrical`, `planar` |
//! | `uvset` | integer | 0 | | which texture coordinates of the mesh: 0 the first, 1 the second |
//! | `uscale`, `vscale` | float | 1 | | factors of u and v |
//! | `udelta`, `vdelta` | float | 0 | | what is added to them |
//! | `v1`, `v2` | vector3 | x, y | | of `planar`: s and t are a point's products with them |
//!
//! ```bhs
//! WorldBegin
//! Texture "dusk" "spectrum" "bilerp" "rgb v00" [0.1 0.1 0.4] "rgb v10" [0.1 0.1 0.4] "rgb v01" [0.9 0.4 0.1] "rgb v11" [0.9 0.4 0.1]
//! ```

use crate::mapping::Mapping;
use bhs_core::Plugin;
use bhs_core::material::Shading;
use bhs_core::params::Params;
use bhs_core::spectrum::SampledSpectrum;
use bhs_core::texture::composite::{Composite, KnownParts, evaluations};
use bhs_core::texture::{Texture, TextureInput};

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Texture> = Plugin { name: "bilerp", summary: "between four values, linearly", build };

struct Bilerp {
    /// At 00, 10, 01, 11.
    values: [TextureInput; 4],
    mapping: Mapping,
    evaluations: u64,
}

fn build(p: &Params) -> Option<Box<dyn Texture>> {
    let values = [
        p.texture_input("v00", 0.0, "the value at (0, 0)"),
        p.texture_input("v10", 0.0, "the value at (1, 0)"),
        p.texture_input("v01", 1.0, "the value at (0, 1)"),
        p.texture_input("v11", 1.0, "the value at (1, 1)"),
    ];
    let mapping = Mapping::read(p);
    let evaluations = evaluations(values.iter().map(TextureInput::evaluations));
    Some(Box::new(Bilerp { values, mapping, evaluations }))
}

impl Bilerp {
    /// Each value with its share.
    fn shares(&self, at: &Shading) -> impl Iterator<Item = (&TextureInput, f32)> {
        let place = self.mapping.place(at);
        let (s, t) = (place.x, place.y);
        self.values.iter().zip([(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t])
    }
}

impl Composite for Bilerp {
    fn evaluations(&self) -> u64 {
        self.evaluations
    }

    fn spectrum_with(&self, at: &Shading, known: &mut KnownParts) -> SampledSpectrum {
        self.shares(at).fold(SampledSpectrum::ZERO, |sum, (value, share)| sum + value.spectrum_with(at, known) * share)
    }

    fn float_with(&self, at: &Shading, known: &mut KnownParts) -> f32 {
        self.shares(at).fold(0.0, |sum, (value, share)| sum + value.float_with(at, known) * share)
    }
}
