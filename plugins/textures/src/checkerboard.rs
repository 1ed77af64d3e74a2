//! `checkerboard`: squares of two values, alternating.
//!
//! A square is one unit wide in (s, t), which are the texture coordinates by the mapping; `tex1` is the one at the origin. With `dimension` 3
//! the board is one of cubes, in the coordinates in which the texture was defined. Edges are sharp: there is no filter but that of the picture.
//!
//! Names and defaults of pbrt-v4.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `tex1`, `tex2` | spectrum, texture | 1, 0 | | the two values; floats in a texture of floats |
//! | `dimension` | integer | 2 | | 2: squares; 3: cubes in space, and no mapping |
//! | `mapping` | string | "uv" | | how a point is placed: `uv`, `spherical`, `cylindrical`, `planar` |
//! | `uvset` | integer | 0 | | which texture coordinates of the mesh: 0 the first, 1 the second |
//! | `uscale`, `vscale` | float | 1 | | factors of u and v |
//! | `rotate` | float | 0 | deg | by which texture coordinates are turned around (0, 0), once they are scaled |
//! | `udelta`, `vdelta` | float | 0 | | what is added to them |
//! | `v1`, `v2` | vector3 | x, y | | of `planar`: s and t are a point's products with them |
//!
//! ```bhs
//! WorldBegin
//! Texture "board" "spectrum" "checkerboard" "float uscale" 8 "float vscale" 8 "float tex1" 0.8 "float tex2" 0.1
//! ```

use crate::mapping::{Mapping, Space};
use bhs_core::Plugin;
use bhs_core::material::Shading;
use bhs_core::params::Params;
use bhs_core::spectrum::SampledSpectrum;
use bhs_core::texture::composite::{Composite, KnownParts, evaluations};
use bhs_core::texture::{Texture, TextureInput};

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Texture> = Plugin { name: "checkerboard", summary: "squares of two values, alternating", build };

/// What the board is one of.
enum Board {
    Squares(Mapping),
    Cubes(Space),
}

struct Checkerboard {
    values: [TextureInput; 2],
    board: Board,
    evaluations: u64,
}

fn build(p: &Params) -> Option<Box<dyn Texture>> {
    let tex1 = p.texture_input("tex1", 1.0, "the value of the square at the origin");
    let tex2 = p.texture_input("tex2", 0.0, "the value of its neighbours");
    let dimension = p.get_in("dimension", 2, 2..=3, "", "2: squares; 3: cubes in space, and no mapping");
    let mapping = Mapping::read(p);
    let board = if dimension == 3 { Board::Cubes(Space::read(p)) } else { Board::Squares(mapping) };
    // One of the two is asked.
    let evaluations = evaluations([tex1.evaluations().max(tex2.evaluations())]);
    Some(Box::new(Checkerboard { values: [tex1, tex2], board, evaluations }))
}

impl Checkerboard {
    #[inline]
    fn value(&self, at: &Shading) -> &TextureInput {
        let number = match &self.board {
            Board::Squares(mapping) => {
                let square = mapping.place(at).floor();
                f64::from(square.x + square.y)
            }
            Board::Cubes(space) => space.place(at).floor().element_sum(),
        };
        let odd = number.rem_euclid(2.0) >= 1.0;
        &self.values[usize::from(odd)]
    }
}

impl Composite for Checkerboard {
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
