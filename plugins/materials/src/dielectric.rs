//! `dielectric`: glass, water, diamond: smooth or rough, with dispersion or without.
//!
//! Light is reflected and refracted in the shares that Fresnel's equations give, for the refractive index `eta` of the inside
//! over that of the outside; the outside is where the surface normal points. Reflection or refraction is chosen with those
//! shares as probabilities. Refracted radiance changes with the square of the index: `1/eta^2` for light that leaves the
//! glass towards the camera, `eta^2` for light that enters it. Roughness makes the surface one of many small facets (see
//! `rough_interface`). An alpha below 0.001 counts as smooth; a texture of roughness never does.
//!
//! Where the index depends on the wavelength, a smooth surface reflects all wavelengths of a path and refracts the first alone, which
//! goes on for the others. A rough one refracts them all: the direction is that of one of them, drawn evenly, and counts for each as
//! much as it would have chosen it (Wilkie et al. 2014, "Hero Wavelength Spectral Sampling").
//!
//! Source: Born and Wolf 1999; the factor: Veach 1997, "Robust Monte Carlo Methods", section 5.2. Names and defaults of pbrt-v4.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `eta` | spectrum | 1.5 | | refractive index, 0.001 to 1000; one that depends on the wavelength disperses light |
//! | `roughness` | float, texture | 0 | | 0 (polished) to 1 |
//! | `uroughness`, `vroughness` | float, texture | `roughness` | | along dp/du and dp/dv, instead of that of both |
//! | `remaproughness` | bool | true | | whether alpha is the square root of the roughness, or the roughness itself |
//!
//! ```bhs
//! Material "dielectric" "spectrum eta" "glass-SF11"
//! ```

use crate::fresnel;
use crate::microfacet::Ggx;
use crate::rough_interface::Interface;
use crate::roughness::Facets;
use bhs_core::Plugin;
use bhs_core::material::{BsdfSample, Material, Shading, estimated_reflectance};
use bhs_core::params::Params;
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, Spectrum, SpectrumRole};
use glam::{Vec2, Vec3};
use std::ops::RangeInclusive;
use std::sync::Arc;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Material> =
    Plugin { name: "dielectric", summary: "glass or water, smooth or rough: reflects, refracts and disperses", build };

/// The range of indices. No substance lies outside; beyond it, squares that radiance is multiplied with soon leave single precision.
const INDICES: RangeInclusive<f32> = 1e-3..=1e3;

/// A wavelength in the middle of what is visible (nm).
const MIDDLE: f32 = 550.0;

/// Refractive index of the inside over that of the outside.
enum Index {
    /// The same for all wavelengths.
    Constant(f32),
    /// By wavelength.
    Dispersive(Arc<dyn Spectrum>),
}

struct Dielectric {
    index: Index,
    facets: Facets,
}

fn build(p: &Params) -> Option<Box<dyn Material>> {
    let eta =
        p.spectrum("eta", 1.5, SpectrumRole::Unbounded, "", "refractive index, 0.001 to 1000; it may depend on the wavelength");
    let [lo, hi] = p.context().lambda_range;
    let wavelengths = (0..=64).map(|i| lo + (hi - lo) * i as f32 / 64.0);
    if let Some(bad) = wavelengths.map(|l| eta.at(l)).find(|eta| !INDICES.contains(eta)) {
        let (least, most) = (INDICES.start(), INDICES.end());
        p.reject("eta", format!("`eta` is {bad:?}"), format!("a refractive index lies between {least} and {most}"));
    }
    let index = if eta.is_constant() { Index::Constant(eta.at(lo)) } else { Index::Dispersive(eta) };
    Some(Box::new(Dielectric { index, facets: Facets::read(p) }))
}

impl Dielectric {
    /// The index at the wavelengths of a path.
    fn indices(spectrum: &dyn Spectrum, at: &Shading) -> SampledSpectrum {
        // A table may leave the range beyond that of the film, from where shifted light comes.
        spectrum.sample(at.lambda_nm).map(|eta| eta.clamp(*INDICES.start(), *INDICES.end()))
    }

    /// The BSDF times |cos(theta_i)|, and the density of `wi`, on a rough surface.
    fn rough(&self, facets: Ggx, at: &Shading, wo: Vec3, wi: Vec3) -> (SampledSpectrum, f32) {
        match &self.index {
            Index::Constant(eta) => {
                let (value, pdf) = Interface { eta: *eta, facets }.evaluate(wo, wi);
                (SampledSpectrum::splat(value), pdf)
            }
            Index::Dispersive(eta) => {
                let each = Self::indices(&**eta, at).0.map(|eta| Interface { eta, facets }.evaluate(wo, wi));
                let pdf = each.iter().map(|e| e.1).sum::<f32>() / N_LAMBDA as f32;
                (SampledSpectrum(each.map(|e| e.0)), pdf)
            }
        }
    }

    fn sample_rough(&self, facets: Ggx, at: &Shading, wo: Vec3, choice: f32, u: Vec2) -> Option<BsdfSample> {
        let (eta, choice) = match &self.index {
            Index::Constant(eta) => (*eta, choice),
            Index::Dispersive(eta) => {
                let scaled = choice * N_LAMBDA as f32;
                let i = (scaled as usize).min(N_LAMBDA - 1);
                (Self::indices(&**eta, at)[i], scaled - i as f32)
            }
        };
        let wi = Interface { eta, facets }.sample(wo, choice, u)?;
        let (value, pdf) = self.rough(facets, at, wo, wi);
        let usable = pdf > 0.0 && pdf.is_finite() && value.is_finite();
        let eta = if wi.z * wo.z < 0.0 { relative(eta, wo) } else { 1.0 };
        usable.then(|| BsdfSample { wi, weight: value / pdf, pdf, specular: false, drops_wavelengths: false, eta })
    }

    fn sample_smooth(&self, at: &Shading, wo: Vec3, choice: f32) -> Option<BsdfSample> {
        let cos_o = wo.z.abs().min(1.0);
        let relative = |eta: f32| relative(eta, wo);
        let mirrored = Vec3::new(-wo.x, -wo.y, wo.z);
        let refracted = |eta: f32, cos_t: f32| Vec3::new(-wo.x / eta, -wo.y / eta, -cos_t.copysign(wo.z)).normalize();
        let specular = |wi, weight, pdf, eta, drops_wavelengths| {
            Some(BsdfSample { wi, weight, pdf, specular: true, drops_wavelengths, eta })
        };
        match &self.index {
            Index::Constant(eta) => {
                let eta = relative(*eta);
                let (reflected, cos_t) = fresnel::dielectric(cos_o, eta);
                if choice < reflected {
                    specular(mirrored, SampledSpectrum::ONE, reflected, 1.0, false)
                } else {
                    specular(refracted(eta, cos_t), SampledSpectrum::splat(1.0 / (eta * eta)), 1.0 - reflected, eta, false)
                }
            }
            Index::Dispersive(eta) => {
                let eta = Self::indices(&**eta, at).map(relative);
                let reflected = eta.map(|eta| fresnel::dielectric(cos_o, eta).0);
                // What all are reflected with on average, so that none counts for more than it should.
                let mean = reflected.mean();
                if choice < mean {
                    return specular(mirrored, reflected * (1.0 / mean), mean, 1.0, false);
                }
                let (eta, (reflected, cos_t)) = (eta[0], fresnel::dielectric(cos_o, eta[0]));
                if reflected >= 1.0 {
                    return None;
                }
                let weight = (1.0 - reflected) / ((1.0 - mean) * eta * eta);
                specular(refracted(eta, cos_t), SampledSpectrum::splat(weight), 1.0 - mean, eta, true)
            }
        }
    }
}

/// The index beyond the surface over that on the side of `wo`, where that of the inside is `eta`.
fn relative(eta: f32, wo: Vec3) -> f32 {
    if wo.z >= 0.0 { eta } else { 1.0 / eta }
}

impl Material for Dielectric {
    fn evaluate(&self, at: &Shading, wo: Vec3, wi: Vec3) -> SampledSpectrum {
        self.facets.at(at).map_or(SampledSpectrum::ZERO, |facets| self.rough(facets, at, wo, wi).0)
    }

    fn pdf(&self, at: &Shading, wo: Vec3, wi: Vec3) -> f32 {
        self.facets.at(at).map_or(0.0, |facets| self.rough(facets, at, wo, wi).1)
    }

    fn sample(&self, at: &Shading, wo: Vec3, choice: f32, u: Vec2) -> Option<BsdfSample> {
        match self.facets.at(at) {
            Some(facets) => self.sample_rough(facets, at, wo, choice, u),
            None => self.sample_smooth(at, wo, choice),
        }
    }

    fn reflectance(&self, at: &Shading, wo: Vec3) -> SampledSpectrum {
        if !self.facets.is_smooth() {
            return estimated_reflectance(self, at, wo);
        }
        let whole = |eta: f32| {
            let eta = relative(eta, wo);
            let (reflected, _) = fresnel::dielectric(wo.z.abs().min(1.0), eta);
            reflected + (1.0 - reflected) / (eta * eta)
        };
        match &self.index {
            Index::Constant(eta) => SampledSpectrum::splat(whole(*eta)),
            Index::Dispersive(eta) => Self::indices(&**eta, at).map(whole),
        }
    }

    fn is_uniform(&self) -> bool {
        // That of a smooth one is not steady where reflection becomes total.
        matches!(self.facets, Facets::Rough(_))
    }

    fn refractive_index(&self) -> Option<f32> {
        Some(match &self.index {
            Index::Constant(eta) => *eta,
            Index::Dispersive(eta) => eta.at(MIDDLE),
        })
    }

    fn is_oriented(&self) -> bool {
        self.facets.is_oriented()
    }

    fn is_specular(&self) -> bool {
        self.facets.is_smooth()
    }

    fn chooses_directions(&self) -> bool {
        true
    }
}
