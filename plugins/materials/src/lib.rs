//! Materials: what surfaces do with light. One file, one plugin; `bumps`, `fresnel`, `microfacet`, `roughness`,
//! `rough_interface` and `coat` are shared by several.

use bhs_core::Plugin;
use bhs_core::material::Material;

pub mod bumps;
pub mod coat;
mod coatedconductor;
mod coateddiffuse;
mod conductor;
mod dielectric;
mod diffuse;
mod diffusetransmission;
pub mod fresnel;
mod interface;
pub mod microfacet;
mod mirror;
mod mix;
mod principled;
pub mod rough_interface;
mod roughness;
mod thindielectric;

/// All materials.
pub const ALL: &[Plugin<dyn Material>] = &[
    coatedconductor::PLUGIN,
    coateddiffuse::PLUGIN,
    conductor::PLUGIN,
    dielectric::PLUGIN,
    diffuse::PLUGIN,
    diffusetransmission::PLUGIN,
    interface::PLUGIN,
    mirror::PLUGIN,
    mix::PLUGIN,
    principled::PLUGIN,
    thindielectric::PLUGIN,
];

#[cfg(test)]
mod tests {
    use super::*;
    bhs_core::every_file_is_listed!([ALL], helpers: ["bumps", "coat", "fresnel", "microfacet", "rough_interface", "roughness"]);
}
