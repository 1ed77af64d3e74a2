//! Materials: what surfaces do with light. One file, one plugin; `fresnel` and `microfacet` are shared by several.

use bhs_core::Plugin;
use bhs_core::material::Material;

mod conductor;
mod dielectric;
mod diffuse;
pub mod fresnel;
pub mod microfacet;
mod mirror;

/// All materials.
pub const ALL: &[Plugin<dyn Material>] = &[conductor::PLUGIN, dielectric::PLUGIN, diffuse::PLUGIN, mirror::PLUGIN];

#[cfg(test)]
mod tests {
    use super::*;
    bhs_core::every_file_is_listed!([ALL], helpers: ["fresnel", "microfacet"]);
}
