//! `wrinkled`: the magnitude of noise of many sizes, each half as large as the one before and `roughness` times as strong: dark folds (Perlin's turbulence).
//! Values begin at `offset`.
//!
//! Names and defaults are pbrt-v4's, but for `offset`; there the noise is of points of space (the mapping "space"), here of the texture coordinates if nothing is said. Where `uscale` is a whole
//! number it has no seam between u = 1 and u = 0: around a disk, as a `modulation` of `thindisc`.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `octaves` | integer | 8 | | how many sizes of noise are added, each half of the one before |
//! | `roughness` | float | 0.5 | | strength of each over that of the one before |
//! | `offset` | float | 0 | | added to the sum |
//! | `mapping` | string | "uv" | | how a point is placed: `uv`, `spherical`, `cylindrical`, `planar`; or noise of points of `space` |
//! | `uvset` | integer | 0 | | which texture coordinates of the mesh: 0 the first, 1 the second |
//! | `uscale`, `vscale` | float | 1 | | factors of u and v |
//! | `rotate` | float | 0 | deg | by which texture coordinates are turned around (0, 0), once they are scaled |
//! | `udelta`, `vdelta` | float | 0 | | what is added to them |
//! | `v1`, `v2` | vector3 | x, y | | of `planar`: s and t are a point's products with them |
//!
//! ```bhs
//! WorldBegin
//! Texture "folds" "float" "wrinkled" "float uscale" 12 "float vscale" 6
//! ```

use crate::noise::Fractal;
use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_core::texture::Texture;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Texture> = Plugin { name: "wrinkled", summary: "fractal noise with sharp folds", build };

fn build(p: &Params) -> Option<Box<dyn Texture>> {
    Some(Box::new(Fractal::read(p, f64::abs)))
}
