//! `coatedconductor`: a metal under a clear coat: varnished brass, car paint.
//!
//! The coat reflects as a dielectric does; what it lets through is refracted, meets the metal, and is refracted again on its way out. Light that goes to and
//! fro between the two is summed as a geometric series, as if it kept its direction: so the sum is exact for a smooth coat on a smooth metal, and near
//! it otherwise. A rough coat widens what the metal reflects; what it lets through it lets through as a smooth one. pbrt-v4 estimates all of this by a random
//! walk. The metal's indices count over that of the coat, which it lies in. Both sides reflect.
//!
//! Source: Weidlich and Wilkie 2007, "Arbitrarily Layered Micro-Facet Surfaces"; names and defaults of pbrt-v4, but for its tables of copper.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `conductor.eta`, `conductor.k` | spectrum, texture | copper | | refractive and absorption index of the metal |
//! | `reflectance` | spectrum, texture | none | | of the bare metal at normal incidence, instead of these |
//! | `conductor.roughness` | float, texture | 0 | | of the metal: 0 (polished) to 1; also `conductor.uroughness` and `conductor.vroughness`, along dp/du and dp/dv |
//! | `interface.roughness` | float, texture | 0 | | of the coat, likewise |
//! | `remaproughness` | bool | true | | whether alpha is the square root of the roughness, or the roughness itself |
//! | `interface.eta` | spectrum | 1.5 | | refractive index of the coat, 1 to 10, the same at all wavelengths |
//! | `thickness` | float | 0.01 | | of the coat: light that crosses it straight keeps exp(-thickness) |
//!
//! ```bhs
//! Material "coatedconductor" "float conductor.roughness" 0.2 "float interface.roughness" 0.01
//! ```

use crate::conductor::{Optics, upwards};
use crate::fresnel;
use crate::microfacet::{Ggx, SMOOTH};
use crate::roughness::{Facets, read_remap, read_roughness};
use bhs_core::Plugin;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::material::{BsdfSample, Material, Shading, estimated_reflectance};
use bhs_core::params::Params;
use bhs_core::spectrum::{SampledSpectrum, SpectrumRole};
use bhs_elementary::Elementary;
use glam::{Vec2, Vec3};

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Material> =
    Plugin { name: "coatedconductor", summary: "a metal under a clear coat, such as varnished brass", build };

struct CoatedConductor {
    optics: Optics,
    metal: Facets,
    coat: Facets,
    eta: f32,
    thickness: f32,
}

fn build(p: &Params) -> Option<Box<dyn Material>> {
    let optics = Optics::read(p, ["conductor.eta", "conductor.k"]);
    let metal = read_roughness(p, ["conductor.roughness", "conductor.uroughness", "conductor.vroughness"]);
    let coat = read_roughness(p, ["interface.roughness", "interface.uroughness", "interface.vroughness"]);
    let remap = read_remap(p);
    let [metal, coat] = [metal, coat].map(|roughness| Facets::new(roughness, remap));
    let about = "refractive index of the coat, 1 to 10, the same at all wavelengths";
    let spectrum = p.spectrum("interface.eta", 1.5, SpectrumRole::Unbounded, "", about);
    let mut eta = spectrum.at(p.context().lambda_range[0]);
    if !spectrum.is_constant() {
        p.report(
            Diagnostic::error("unsupported", "dispersion in a coat is not supported yet")
                .at(p.span_of("interface.eta"), "this refractive index depends on the wavelength")
                .help("give a number"),
        );
    }
    if !(1.0..=10.0).contains(&eta) {
        p.reject("interface.eta", format!("`interface.eta` is {eta:?}"), "the refractive index of a coat lies between 1 and 10");
        eta = 1.5;
    }
    let about = "of the coat: light that crosses it straight keeps exp(-thickness)";
    let thickness = p.get_in("thickness", 0.01, 0.0..=1e6, "", about) as f32;
    Some(Box::new(CoatedConductor { optics, metal, coat, eta, thickness }))
}

impl CoatedConductor {
    /// A direction outside (z > 0) as it goes on inside, towards the metal's own half of space.
    fn inside(&self, w: Vec3) -> Vec3 {
        let (x, y) = (w.x / self.eta, w.y / self.eta);
        Vec3::new(x, y, (1.0 - x * x - y * y).max(0.0).sqrt())
    }

    /// A direction inside (z > 0) as it leaves; `None`: it does not.
    fn outside(&self, w: Vec3) -> Option<Vec3> {
        let (x, y) = (w.x * self.eta, w.y * self.eta);
        let z2 = 1.0 - x * x - y * y;
        (z2 > 0.0).then(|| Vec3::new(x, y, z2.sqrt()))
    }

    /// The share that the coat reflects at the cosine `cos` outside.
    fn reflected(&self, cos: f32) -> f32 {
        fresnel::dielectric(cos.clamp(0.0, 1.0), self.eta).0
    }

    /// What is left of light that crosses the coat at the cosine `cos` inside.
    fn crossing(&self, cos: f32) -> f32 {
        (-self.thickness / cos.max(1e-6)).exponential()
    }

    /// What gets in from `wo`, is reflected by the metal with the share of the cosine `cos` there, and gets out to `wi`, in any number of rounds.
    fn through(&self, at: &Shading, [wo, wi]: [Vec3; 2], [inner_o, inner_i]: [Vec3; 2], cos: f32) -> SampledSpectrum {
        let (ro, ri) = (self.reflected(wo.z), self.reflected(wi.z));
        let way = self.crossing(inner_o.z) * self.crossing(inner_i.z);
        let once = (1.0 - ro) * (1.0 - ri) * way;
        // The mean of the two, so that light may go either way.
        let back = (ro * ri).sqrt() * way;
        self.optics.fresnel_in(at, cos, self.eta).map(|metal| once * metal / (1.0 - (back * metal).min(0.999)))
    }

    /// The facets of the metal as they are seen through the coat's; `None`: it is a mirror.
    fn metal(&self, at: &Shading) -> Option<Ggx> {
        let metal = self.metal.at(at).map_or(Vec2::ZERO, |f| f.alpha);
        // Each crossing turns light by the share 1 - 1/eta of a facet's tilt, and a mirror by twice its own.
        let coat = self.coat.at(at).map_or(Vec2::ZERO, |f| f.alpha) * ((1.0 - 1.0 / self.eta) * 0.5);
        let squares = metal * metal + coat * coat * 2.0;
        let alpha = Vec2::new(squares.x.sqrt(), squares.y.sqrt());
        (alpha.max_element() >= SMOOTH).then_some(Ggx { alpha: alpha.clamp(Vec2::splat(0.1 * SMOOTH), Vec2::ONE) })
    }

    /// Probability that a direction is chosen by the coat.
    fn chooses_coat(&self, at: &Shading, wo: Vec3) -> f32 {
        let reflected = self.reflected(wo.z);
        let metal = (1.0 - reflected) * (1.0 - reflected) * self.optics.fresnel_in(at, 1.0, self.eta).mean();
        let whole = reflected + metal;
        if whole > 0.0 { (reflected / whole).clamp(0.05, 0.95) } else { 0.5 }
    }

    /// The BSDF times |cos(theta_i)|, and the density of `wi`, without what is mirrored exactly; both on the side z > 0.
    fn both(&self, at: &Shading, by_coat: f32, wo: Vec3, wi: Vec3) -> (SampledSpectrum, f32) {
        let (mut value, mut pdf) = (SampledSpectrum::ZERO, 0.0);
        if let (Some(facets), Some(m)) = (self.coat.at(at), (wo + wi).try_normalize()) {
            let mirrored = facets.mirrored_density(wo, m);
            value += SampledSpectrum::splat(self.reflected(wo.dot(m)) * mirrored * facets.shadowing(wo, wi));
            pdf += by_coat * mirrored;
        }
        let [inner_o, inner_i] = [wo, wi].map(|w| self.inside(w));
        if let (Some(facets), Some(m)) = (self.metal(at), (inner_o + inner_i).try_normalize()) {
            // Solid angle inside over that outside.
            let spread = wi.z / (self.eta * self.eta * inner_i.z);
            let mirrored = facets.mirrored_density(inner_o, m) * spread;
            let through = self.through(at, [wo, wi], [inner_o, inner_i], inner_o.dot(m));
            value += through * (mirrored * facets.shadowing(inner_o, inner_i));
            pdf += (1.0 - by_coat) * mirrored;
        }
        (value, pdf)
    }
}

impl Material for CoatedConductor {
    fn evaluate(&self, at: &Shading, wo: Vec3, wi: Vec3) -> SampledSpectrum {
        upwards(wo, wi).map_or(SampledSpectrum::ZERO, |(wo, wi, _)| self.both(at, self.chooses_coat(at, wo), wo, wi).0)
    }

    fn pdf(&self, at: &Shading, wo: Vec3, wi: Vec3) -> f32 {
        upwards(wo, wi).map_or(0.0, |(wo, wi, _)| self.both(at, self.chooses_coat(at, wo), wo, wi).1)
    }

    fn sample(&self, at: &Shading, wo: Vec3, choice: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let side = Vec3::new(1.0, 1.0, wo.z.signum());
        let up = wo * side;
        let mirrored = Vec3::new(-up.x, -up.y, up.z);
        let inner = self.inside(up);
        let specular = |weight, pdf| {
            Some(BsdfSample { wi: mirrored * side, weight, pdf, specular: true, drops_wavelengths: false, eta: 1.0 })
        };
        let coat = self.coat.at(at);
        let metal = self.metal(at);
        let through = || self.through(at, [up, mirrored], [inner, inner], inner.z);
        if coat.is_none() && metal.is_none() {
            return specular(through().map(|t| t + self.reflected(up.z)), 1.0);
        }
        let by_coat = self.chooses_coat(at, up);
        let wi = match (choice < by_coat, coat, metal) {
            (true, None, _) => return specular(SampledSpectrum::splat(self.reflected(up.z) / by_coat), by_coat),
            (true, Some(facets), _) => fresnel::reflect(up, facets.sample_visible(up, u)),
            (false, _, None) => return specular(through() * (1.0 / (1.0 - by_coat)), 1.0 - by_coat),
            (false, _, Some(facets)) => {
                let wi = fresnel::reflect(inner, facets.sample_visible(inner, u));
                if wi.z <= 0.0 {
                    return None;
                }
                self.outside(wi)?
            }
        };
        if wi.z <= 0.0 {
            return None;
        }
        let (value, pdf) = self.both(at, by_coat, up, wi);
        let usable = pdf > 0.0 && pdf.is_finite() && value.is_finite();
        usable.then(|| BsdfSample {
            wi: wi * side,
            weight: value / pdf,
            pdf,
            specular: false,
            drops_wavelengths: false,
            eta: 1.0,
        })
    }

    fn reflectance(&self, at: &Shading, wo: Vec3) -> SampledSpectrum {
        if !self.is_specular() {
            return estimated_reflectance(self, at, wo);
        }
        let up = Vec3::new(wo.x, wo.y, wo.z.abs());
        let inner = self.inside(up);
        self.through(at, [up, up], [inner, inner], inner.z).map(|t| t + self.reflected(up.z))
    }

    fn is_uniform(&self) -> bool {
        self.optics.is_uniform() && self.metal.is_uniform() && self.coat.is_uniform()
    }

    fn is_oriented(&self) -> bool {
        self.metal.is_oriented() || self.coat.is_oriented()
    }

    fn is_specular(&self) -> bool {
        self.metal.is_smooth() && self.coat.is_smooth()
    }

    fn chooses_directions(&self) -> bool {
        self.coat.is_smooth()
    }
}
