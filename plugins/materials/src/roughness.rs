//! The parameters of roughness, the same in all materials that have facets.

use crate::microfacet::{Ggx, SMOOTH, alpha_of_roughness};
use bhs_core::material::Shading;
use bhs_core::params::Params;
use bhs_core::texture::FloatParameter;
use glam::Vec2;
use std::sync::Arc;

/// The least alpha along one tangent of a surface that is rough along the other (as in pbrt-v4).
const LEAST: f32 = 1e-4;

/// Roughness along dp/du and along dp/dv, 0 to 1.
pub type Roughness = [FloatParameter; 2];

/// How rough a surface is.
pub enum Facets {
    /// Not at all.
    Smooth,
    /// The same everywhere.
    Rough(Ggx),
    /// By textures; nowhere smooth.
    Textured {
        /// Along the two tangents.
        roughness: Roughness,
        /// Whether both are the same everywhere.
        is_isotropic: bool,
        /// Whether alpha is the root of it.
        remap: bool,
    },
}

impl Facets {
    /// Reads `roughness`, `uroughness`, `vroughness` and `remaproughness`.
    pub fn read(p: &Params) -> Self {
        let roughness = read_roughness(p, ["roughness", "uroughness", "vroughness"]);
        let remap = read_remap(p);
        Self::new(roughness, remap)
    }

    /// Of a roughness; `remap`: alpha is the root of it.
    pub fn new(roughness: Roughness, remap: bool) -> Self {
        if let [FloatParameter::Constant(u), FloatParameter::Constant(v)] = roughness {
            let alpha = Vec2::new(alpha(u, remap), alpha(v, remap));
            // Smooth is what is so along both tangents, as in pbrt-v4.
            return if alpha.max_element() >= SMOOTH {
                Self::Rough(Ggx { alpha: alpha.max(Vec2::splat(LEAST)) })
            } else {
                Self::Smooth
            };
        }
        Self::Textured { is_isotropic: same(&roughness), roughness, remap }
    }

    /// The facets at a point; `None`: it is smooth.
    #[inline]
    pub fn at(&self, at: &Shading) -> Option<Ggx> {
        match self {
            Self::Smooth => None,
            Self::Rough(facets) => Some(*facets),
            Self::Textured { roughness: [u, _], is_isotropic: true, remap } => {
                Some(Ggx::isotropic(alpha(u.at(at), *remap).max(SMOOTH)))
            }
            Self::Textured { roughness, remap, .. } => {
                let [u, v] = roughness.each_ref().map(|r| alpha(r.at(at), *remap).max(SMOOTH));
                Some(Ggx { alpha: Vec2::new(u, v) })
            }
        }
    }

    /// Whether it is the same everywhere, and all around the normal.
    pub fn is_uniform(&self) -> bool {
        !matches!(self, Self::Textured { .. }) && !self.is_oriented()
    }

    /// Whether it is smooth everywhere.
    pub fn is_smooth(&self) -> bool {
        matches!(self, Self::Smooth)
    }

    /// Whether it differs along the two tangents.
    pub fn is_oriented(&self) -> bool {
        match self {
            Self::Smooth => false,
            Self::Rough(facets) => !facets.is_isotropic(),
            Self::Textured { is_isotropic, .. } => !is_isotropic,
        }
    }
}

/// Reads `remaproughness`.
pub fn read_remap(p: &Params) -> bool {
    p.get("remaproughness", true, "", "whether alpha is the square root of the roughness, or the roughness")
}

/// Reads a roughness from three parameters: of both tangents, and of each.
pub fn read_roughness(p: &Params, [both, u_name, v_name]: [&'static str; 3]) -> Roughness {
    const RANGE: std::ops::RangeInclusive<f64> = 0.0..=1.0;
    let roughness = p.float_parameter(both, 0.0, RANGE, "", "0 (polished) to 1");
    [(u_name, "roughness along dp/du, instead of that of both"), (v_name, "roughness along dp/dv, likewise")]
        .map(|(name, about)| p.optional_float_parameter(name, RANGE, "", about).unwrap_or_else(|| roughness.clone()))
}

fn alpha(roughness: f32, remap: bool) -> f32 {
    if remap { alpha_of_roughness(roughness) } else { roughness }
}

/// Whether the roughness is the same along both tangents.
fn same([a, b]: &Roughness) -> bool {
    match (a, b) {
        (FloatParameter::Constant(a), FloatParameter::Constant(b)) => a == b,
        // One name is one texture.
        (FloatParameter::Texture { texture: a, .. }, FloatParameter::Texture { texture: b, .. }) => Arc::ptr_eq(a, b),
        _ => false,
    }
}
