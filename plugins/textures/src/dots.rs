//! `dots`: round dots, one in every other cell of a grid, here and there in it.
//!
//! A cell is one unit wide in (s, t), which are the texture coordinates by the mapping; a dot has the radius 0.35, and lies wholly in its cell.
//!
//! Names and defaults of pbrt-v4; which cells have a dot is another choice.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `inside`, `outside` | spectrum, texture | 1, 0 | | the values of dots and of what is around them; floats in a texture of floats |
//! | `mapping` | string | "uv" | | how a point is placed: `uv`, `spherical`, `cylindrical`, `planar` |
//! | `uvset` | integer | 0 | | which texture coordinates of the mesh: 0 the first, 1 the second |
//! | `uscale`, `vscale` | float | 1 | | factors of u and v |
//! | `udelta`, `vdelta` | float | 0 | | what is added to them |
//! | `v1`, `v2` | vector3 | x, y | | of `planar`: s and t are a point's products with them |
//!
//! ```bhs
//! WorldBegin
//! Texture "polka" "spectrum" "dots" "float uscale" 10 "float vscale" 10 "rgb inside" [0.8 0.1 0.1] "float outside" 0.7
//! ```

use crate::mapping::Mapping;
use bhs_core::Plugin;
use bhs_core::material::Shading;
use bhs_core::params::Params;
use bhs_core::sampling::mix64;
use bhs_core::spectrum::SampledSpectrum;
use bhs_core::texture::composite::{Composite, KnownParts, evaluations};
use bhs_core::texture::{Texture, TextureInput};
use glam::Vec2;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Texture> = Plugin { name: "dots", summary: "round dots, here and there", build };

/// Of a dot, in units of a cell.
const RADIUS: f32 = 0.35;

struct Dots {
    inside: TextureInput,
    outside: TextureInput,
    mapping: Mapping,
    evaluations: u64,
}

fn build(p: &Params) -> Option<Box<dyn Texture>> {
    let inside = p.texture_input("inside", 1.0, "the value of dots");
    let outside = p.texture_input("outside", 0.0, "the value around them");
    let mapping = Mapping::read(p);
    // One of the two is asked.
    let evaluations = evaluations([inside.evaluations().max(outside.evaluations())]);
    Some(Box::new(Dots { inside, outside, mapping, evaluations }))
}

/// Whether a place lies in a dot.
fn is_inside(place: Vec2) -> bool {
    let cell = (place + 0.5).floor();
    let hash = mix64(mix64(cell.x as i64 as u64) ^ cell.y as i64 as u64);
    if hash & 1 == 0 {
        return false;
    }
    // How far the middle of the dot lies off that of its cell, -1 to 1.
    let share = |bits: u64| (bits & 0xffff) as f32 / 32768.0 - 1.0;
    let middle = cell + Vec2::new(share(hash >> 16), share(hash >> 32)) * (0.5 - RADIUS);
    (place - middle).length_squared() < RADIUS * RADIUS
}

impl Dots {
    #[inline]
    fn value(&self, at: &Shading) -> &TextureInput {
        if is_inside(self.mapping.place(at)) { &self.inside } else { &self.outside }
    }
}

impl Composite for Dots {
    fn evaluations(&self) -> u64 {
        self.evaluations
    }

    fn spectrum_with(&self, at: &Shading, known: &mut KnownParts) -> SampledSpectrum {
        self.value(at).spectrum_with(at, known)
    }

    fn float_with(&self, at: &Shading, known: &mut KnownParts) -> f32 {
        self.value(at).float_with(at, known)
    }
}
