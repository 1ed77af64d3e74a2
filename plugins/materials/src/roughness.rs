//! The parameters of roughness, the same in all materials that have facets.

use crate::microfacet::{Ggx, SMOOTH, alpha_of_roughness};
use bhs_core::diagnostics::Diagnostic;
use bhs_core::material::Shading;
use bhs_core::params::Params;
use bhs_core::texture::FloatParameter;
use std::sync::Arc;

/// How rough a surface is.
pub enum Facets {
    /// Not at all.
    Smooth,
    /// The same everywhere.
    Rough(Ggx),
    /// By a texture; nowhere smooth.
    Textured {
        /// 0 to 1.
        roughness: FloatParameter,
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
    pub fn new(roughness: FloatParameter, remap: bool) -> Self {
        match roughness {
            FloatParameter::Constant(roughness) => {
                let alpha = alpha(roughness, remap);
                if alpha >= SMOOTH { Self::Rough(Ggx { alpha }) } else { Self::Smooth }
            }
            roughness => Self::Textured { roughness, remap },
        }
    }

    /// The facets at a point; `None`: it is smooth.
    #[inline]
    pub fn at(&self, at: &Shading) -> Option<Ggx> {
        match self {
            Self::Smooth => None,
            Self::Rough(facets) => Some(*facets),
            Self::Textured { roughness, remap } => Some(Ggx { alpha: alpha(roughness.at(at), *remap).max(SMOOTH) }),
        }
    }

    /// Whether it is the same everywhere.
    pub fn is_uniform(&self) -> bool {
        !matches!(self, Self::Textured { .. })
    }

    /// Whether it is smooth everywhere.
    pub fn is_smooth(&self) -> bool {
        matches!(self, Self::Smooth)
    }
}

/// Reads `remaproughness`.
pub fn read_remap(p: &Params) -> bool {
    p.get("remaproughness", true, "", "whether alpha is the square root of the roughness, or the roughness")
}

/// Reads a roughness from three parameters: of both tangents, and of each.
pub fn read_roughness(p: &Params, [both, u_name, v_name]: [&'static str; 3]) -> FloatParameter {
    const RANGE: std::ops::RangeInclusive<f64> = 0.0..=1.0;
    let roughness = p.float_parameter(both, 0.0, RANGE, "", "0 (polished) to 1");
    // Along the two tangents; the shading frame's tangents are arbitrary, so they cannot differ.
    let [u, v] = [u_name, v_name].map(|name| {
        let along = p.optional_float_parameter(name, RANGE, "", "roughness along one tangent; both must be equal");
        along.unwrap_or_else(|| roughness.clone())
    });
    if !same(&u, &v) {
        let show = |r: &FloatParameter| match r {
            FloatParameter::Constant(r) => format!("{r}"),
            FloatParameter::Texture { .. } => "a texture".to_owned(),
        };
        p.report(
            Diagnostic::error("unsupported", "roughness that depends on direction is not supported yet")
                .at(p.span_of(u_name), format!("{} along one tangent", show(&u)))
                .and(p.span_of(v_name), format!("{} along the other", show(&v)))
                .help(format!("give one `{both}`")),
        );
    }
    u
}

fn alpha(roughness: f32, remap: bool) -> f32 {
    if remap { alpha_of_roughness(roughness) } else { roughness }
}

fn same(a: &FloatParameter, b: &FloatParameter) -> bool {
    match (a, b) {
        (FloatParameter::Constant(a), FloatParameter::Constant(b)) => a == b,
        // One name is one texture.
        (FloatParameter::Texture { texture: a, .. }, FloatParameter::Texture { texture: b, .. }) => Arc::ptr_eq(a, b),
        _ => false,
    }
}
