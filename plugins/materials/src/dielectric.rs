//! `dielectric`: smooth glass, water, diamond.
//!
//! Light is reflected and refracted in the shares that Fresnel's equations give, for the refractive index `eta` of the inside
//! over that of the outside; the outside is where the surface normal points. Reflection or refraction is chosen with those
//! shares as probabilities. Refracted radiance changes with the square of the index: `1/eta^2` for light that leaves the
//! glass towards the camera, `eta^2` for light that enters it.
//!
//! Source: Born and Wolf 1999; the factor: Veach 1997, "Robust Monte Carlo Methods", section 5.2. Names of pbrt-v4.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `eta` | spectrum | 1.5 | | refractive index; must be the same at all wavelengths: dispersion is not supported yet |
//! | `roughness`, `uroughness`, `vroughness` | float | 0 | | must be 0: rough glass is not supported yet |
//! | `remaproughness` | bool | true | | no effect on a roughness of 0 |
//!
//! ```bhs
//! Material "dielectric" "float eta" 1.5168
//! ```

use crate::fresnel;
use bhs_core::Plugin;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::material::{BsdfSample, Material, Shading};
use bhs_core::params::Params;
use bhs_core::spectrum::{SampledSpectrum, SpectrumRole};
use glam::{Vec2, Vec3};

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Material> =
    Plugin { name: "dielectric", summary: "smooth glass or water: reflects and refracts", build };

/// The yellow helium line (nm), at which catalogues state an index.
const HELIUM_D: f32 = 587.56;

struct Dielectric {
    /// Refractive index of the inside over that of the outside.
    eta: f32,
}

fn build(p: &Params) -> Option<Box<dyn Material>> {
    let spectrum = p.spectrum("eta", 1.5, SpectrumRole::Unbounded, "", "refractive index");
    let eta = spectrum.at(HELIUM_D);
    if !spectrum.is_constant() {
        p.report(
            Diagnostic::error("unsupported", "dispersion is not supported yet")
                .at(p.span_of("eta"), "this refractive index depends on the wavelength")
                .help(format!("write \"float eta\" {eta:.4}, its value at {HELIUM_D} nm")),
        );
    } else if eta <= 0.0 {
        p.reject("eta", format!("`eta` is {eta}"), "a refractive index is greater than 0");
    }
    for name in ["roughness", "uroughness", "vroughness"] {
        if p.get(name, 0.0, "", "must be 0: rough glass is not supported yet") != 0.0 {
            p.report(
                Diagnostic::error("unsupported", "rough glass is not supported yet")
                    .at(p.span_of(name), "only 0 is possible")
                    .help(format!("remove `{name}`")),
            );
        }
    }
    p.get("remaproughness", true, "", "no effect on a roughness of 0");
    Some(Box::new(Dielectric { eta }))
}

impl Material for Dielectric {
    fn evaluate(&self, _: &Shading, _: Vec3, _: Vec3) -> SampledSpectrum {
        SampledSpectrum::ZERO
    }

    fn pdf(&self, _: &Shading, _: Vec3, _: Vec3) -> f32 {
        0.0
    }

    fn sample(&self, _: &Shading, wo: Vec3, choice: f32, _: Vec2) -> Option<BsdfSample> {
        // The index beyond the surface over that on the side of `wo`.
        let eta = if wo.z >= 0.0 { self.eta } else { 1.0 / self.eta };
        let (reflected, cos_t) = fresnel::dielectric(wo.z.abs().min(1.0), eta);
        let (wi, weight) = if choice < reflected {
            (Vec3::new(-wo.x, -wo.y, wo.z), 1.0)
        } else {
            (Vec3::new(-wo.x / eta, -wo.y / eta, -cos_t.copysign(wo.z)).normalize(), 1.0 / (eta * eta))
        };
        Some(BsdfSample { wi, weight: SampledSpectrum::splat(weight), pdf: 1.0, specular: true, drops_wavelengths: false })
    }

    fn is_specular(&self) -> bool {
        true
    }
}
