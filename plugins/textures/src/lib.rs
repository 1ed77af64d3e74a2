//! Textures: values that vary over surfaces. One file, one plugin; `decode` reads pictures, `mapping` places them, `wrap` says what lies outside of them, `pyramid` blurs them, `noise` is what the noisy ones have in common.

use bhs_core::Plugin;
use bhs_core::texture::Texture;

mod bilerp;
mod checkerboard;
mod constant;
pub mod decode;
mod directionmix;
mod dots;
mod fbm;
mod imagemap;
mod mapping;
mod marble;
mod mix;
mod noise;
mod product;
mod pyramid;
mod scale;
mod threshold;
mod vertexcolor;
mod windy;
mod wrap;
mod wrinkled;

/// All textures.
pub const ALL: &[Plugin<dyn Texture>] = &[
    bilerp::PLUGIN,
    checkerboard::PLUGIN,
    constant::PLUGIN,
    directionmix::PLUGIN,
    dots::PLUGIN,
    fbm::PLUGIN,
    imagemap::PLUGIN,
    marble::PLUGIN,
    mix::PLUGIN,
    product::PLUGIN,
    scale::PLUGIN,
    threshold::PLUGIN,
    vertexcolor::PLUGIN,
    windy::PLUGIN,
    wrinkled::PLUGIN,
];

#[cfg(test)]
mod tests {
    use super::*;
    bhs_core::every_file_is_listed!([ALL], helpers: ["decode", "mapping", "noise", "pyramid", "wrap"]);
}
