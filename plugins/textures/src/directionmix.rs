//! `directionmix`: one value where a surface lies across a direction, another where it lies along it: snow on rocks.
//!
//! The value is `a tex1 + (1 - a) tex2`, where a is the magnitude of the product of the surface's own unit normal and the unit direction `dir`,
//! which is turned by the current transform. The surface's own normal is that of its triangles, not the one that shading uses.
//!
//! Names, defaults and meaning of pbrt-v4.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `tex1` | spectrum, texture | 0 | | the value where the surface faces along `dir`; a float in a texture of floats |
//! | `tex2` | spectrum, texture | 1 | | the value where `dir` lies in the surface |
//! | `dir` | vector3 | 0 1 0 | | the direction |
//!
//! ```bhs
//! WorldBegin
//! Texture "snowy" "spectrum" "directionmix" "float tex1" 0.9 "rgb tex2" [0.2 0.15 0.1] "vector3 dir" [0 0 1]
//! ```

use bhs_core::Plugin;
use bhs_core::material::Shading;
use bhs_core::params::{Params, Vector3};
use bhs_core::spectrum::SampledSpectrum;
use bhs_core::texture::composite::{Composite, KnownParts, evaluations};
use bhs_core::texture::{Texture, TextureInput};
use glam::{DVec3, Vec3};

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Texture> =
    Plugin { name: "directionmix", summary: "a value between two others, by the direction that a surface faces", build };

struct DirectionMix {
    tex1: TextureInput,
    tex2: TextureInput,
    /// World space.
    direction: Vec3,
    evaluations: u64,
}

fn build(p: &Params) -> Option<Box<dyn Texture>> {
    let tex1 = p.texture_input("tex1", 0.0, "the value where the surface faces along `dir`");
    let tex2 = p.texture_input("tex2", 1.0, "the value where `dir` lies in the surface");
    let Vector3(dir) = p.get("dir", Vector3(DVec3::Y), "", "the direction, in current coordinates");
    let direction = p.context().world_from_object.transform_vector3(dir).try_normalize();
    if direction.is_none() {
        p.reject("dir", "`dir` has no direction", "it needs a length, and a transform that leaves it one");
    }
    let evaluations = evaluations([tex1.evaluations(), tex2.evaluations()]);
    Some(Box::new(DirectionMix { tex1, tex2, direction: direction?.as_vec3(), evaluations }))
}

impl DirectionMix {
    /// The share of the first value.
    fn share(&self, at: &Shading) -> f32 {
        at.normal.dot(self.direction).abs().min(1.0)
    }
}

impl Composite for DirectionMix {
    fn evaluations(&self) -> u64 {
        self.evaluations
    }

    fn spectrum_with(&self, at: &Shading, known: &mut KnownParts) -> SampledSpectrum {
        let share = self.share(at);
        self.tex1.spectrum_with(at, known) * share + self.tex2.spectrum_with(at, known) * (1.0 - share)
    }

    fn float_with(&self, at: &Shading, known: &mut KnownParts) -> f32 {
        let share = self.share(at);
        self.tex1.float_with(at, known) * share + self.tex2.float_with(at, known) * (1.0 - share)
    }
}
