//! `conductor`: a metal, polished or rough.
//!
//! Each wavelength is reflected as Fresnel's equations say for the complex refractive index `eta + i k`. Roughness makes
//! the surface one of many small mirrors (GGX; see `microfacet`): BSDF `F D G2 / (4 cos_o cos_i)`. Light that is reflected
//! more than once between facets is lost. Both sides reflect. An alpha below 0.001 counts as smooth, and is a mirror.
//!
//! Source: Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces"; names and defaults of pbrt-v4.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `eta` | spectrum, texture | `metal-Cu-eta` | | refractive index |
//! | `k` | spectrum, texture | `metal-Cu-k` | | absorption index |
//! | `reflectance` | spectrum, texture | none | | reflectance at normal incidence, instead of `eta` and `k` |
//! | `roughness` | float, texture | 0 | | 0 (polished) to 1 |
//! | `uroughness`, `vroughness` | float, texture | `roughness` | | along dp/du and dp/dv, instead of that of both |
//! | `remaproughness` | bool | true | | whether alpha is the square root of the roughness, or the roughness itself |
//!
//! ```bhs
//! Material "conductor" "spectrum eta" "metal-Au-eta" "spectrum k" "metal-Au-k" "float roughness" 0.05
//! ```

use crate::fresnel;
use crate::roughness::Facets;
use bhs_core::Plugin;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::material::{BsdfSample, Material, Shading, estimated_reflectance, same_hemisphere};
use bhs_core::params::Params;
use bhs_core::spectrum::{SampledSpectrum, SpectrumRole};
use bhs_core::texture::SpectrumParameter;
use glam::{Vec2, Vec3};

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Material> =
    Plugin { name: "conductor", summary: "a metal, polished or rough, of measured complex refractive index", build };

/// What decides how much is reflected.
pub(crate) enum Optics {
    /// Real and imaginary part of the refractive index.
    Index { eta: SpectrumParameter, k: SpectrumParameter },
    /// The reflectance at normal incidence, of an index with real part 1.
    Reflectance(SpectrumParameter),
}

struct Conductor {
    optics: Optics,
    facets: Facets,
}

fn build(p: &Params) -> Option<Box<dyn Material>> {
    let optics = Optics::read(p, ["eta", "k"]);
    Some(Box::new(Conductor { optics, facets: Facets::read(p) }))
}

impl Optics {
    /// Reads `reflectance`, or the two indices.
    pub(crate) fn read(p: &Params, [eta, k]: [&'static str; 2]) -> Self {
        const ETA: (&str, &str) = ("metal-Cu-eta", "refractive index");
        const K: (&str, &str) = ("metal-Cu-k", "absorption index");
        let role = SpectrumRole::Unbounded;
        let about = "reflectance at normal incidence, instead of `eta` and `k`";
        let Some(reflectance) = p.optional_spectrum_parameter("reflectance", "none".into(), SpectrumRole::Reflectance, "", about)
        else {
            let eta = p.named_spectrum_parameter(eta, ETA.0, role, "", ETA.1);
            let k = p.named_spectrum_parameter(k, K.0, role, "", K.1);
            return Optics::Index { eta, k };
        };
        for (name, (default, about)) in [(eta, ETA), (k, K)] {
            if p.optional_spectrum_parameter(name, format!("\"{default}\""), role, "", about).is_some() {
                p.report(
                    Diagnostic::error("conflicting-parameters", format!("`{name}` and `reflectance` exclude each other"))
                        .at(p.span_of(name), "given here")
                        .and(p.span_of("reflectance"), "and this describes the metal too")
                        .help(format!("give `{eta}` and `{k}`, or `reflectance`")),
                );
            }
        }
        Optics::Reflectance(reflectance)
    }

    /// The share of the light that a facet reflects at `cos_i`.
    pub(crate) fn fresnel(&self, at: &Shading, cos_i: f32) -> SampledSpectrum {
        self.fresnel_in(at, cos_i, 1.0)
    }

    /// The same in a medium of the refractive index `outer`: the indices of the metal count over it.
    pub(crate) fn fresnel_in(&self, at: &Shading, cos_i: f32, outer: f32) -> SampledSpectrum {
        let cos_i = cos_i.clamp(0.0, 1.0);
        let share = |eta: f32, k: f32| fresnel::conductor(cos_i, eta / outer, k / outer);
        match self {
            Self::Index { eta, k } => eta.sample(at).zip(k.sample(at), share),
            Self::Reflectance(r) => r.sample(at).map(|r| {
                // Just below 1, where k would be infinite (as in pbrt-v4).
                let r = r.min(0.9999);
                share(1.0, 2.0 * (r / (1.0 - r)).sqrt())
            }),
        }
    }

    /// Whether it is the same everywhere.
    pub(crate) fn is_uniform(&self) -> bool {
        match self {
            Self::Index { eta, k } => eta.is_uniform() && k.is_uniform(),
            Self::Reflectance(reflectance) => reflectance.is_uniform(),
        }
    }
}

/// Both directions seen from the side of `wo`, and the normal of the facets that mirror one into the other. `None` if no facet
/// does.
pub(crate) fn upwards(wo: Vec3, wi: Vec3) -> Option<(Vec3, Vec3, Vec3)> {
    if !same_hemisphere(wo, wi) {
        return None;
    }
    let side = Vec3::new(1.0, 1.0, wo.z.signum());
    let (wo, wi) = (wo * side, wi * side);
    Some((wo, wi, (wo + wi).try_normalize()?))
}

impl Material for Conductor {
    fn evaluate(&self, at: &Shading, wo: Vec3, wi: Vec3) -> SampledSpectrum {
        let (Some(facets), Some((wo, wi, m))) = (self.facets.at(at), upwards(wo, wi)) else {
            return SampledSpectrum::ZERO;
        };
        self.optics.fresnel(at, wo.dot(m)) * (facets.mirrored_density(wo, m) * facets.shadowing(wo, wi))
    }

    fn pdf(&self, at: &Shading, wo: Vec3, wi: Vec3) -> f32 {
        let (Some(facets), Some((wo, _, m))) = (self.facets.at(at), upwards(wo, wi)) else {
            return 0.0;
        };
        facets.mirrored_density(wo, m)
    }

    fn sample(&self, at: &Shading, wo: Vec3, _: f32, u: Vec2) -> Option<BsdfSample> {
        let Some(facets) = self.facets.at(at) else {
            let wi = Vec3::new(-wo.x, -wo.y, wo.z);
            return Some(BsdfSample {
                wi,
                weight: self.optics.fresnel(at, wo.z.abs()),
                pdf: 1.0,
                specular: true,
                drops_wavelengths: false,
                eta: 1.0,
            });
        };
        if wo.z == 0.0 {
            return None;
        }
        let side = Vec3::new(1.0, 1.0, wo.z.signum());
        let up = wo * side;
        let m = facets.sample_visible(up, u);
        let wi = fresnel::reflect(up, m);
        if wi.z <= 0.0 {
            // The mirror image lies inside the metal: another facet is in the way.
            return None;
        }
        let weight = self.optics.fresnel(at, up.dot(m)) * facets.shadowing(up, wi);
        Some(BsdfSample {
            wi: wi * side,
            weight,
            pdf: facets.mirrored_density(up, m),
            specular: false,
            drops_wavelengths: false,
            eta: 1.0,
        })
    }

    fn reflectance(&self, at: &Shading, wo: Vec3) -> SampledSpectrum {
        if self.facets.is_smooth() { self.optics.fresnel(at, wo.z.abs()) } else { estimated_reflectance(self, at, wo) }
    }

    fn is_uniform(&self) -> bool {
        self.optics.is_uniform() && self.facets.is_uniform()
    }

    fn is_oriented(&self) -> bool {
        self.facets.is_oriented()
    }

    fn is_specular(&self) -> bool {
        self.facets.is_smooth()
    }
}
