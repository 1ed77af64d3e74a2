//! `coateddiffuse`: a matt surface under a clear coat: plastic, varnish, glazed clay.
//!
//! The coat reflects as a dielectric does, smooth or rough; what it lets through meets Lambert's law on the ground, and light goes to
//! and fro between the two. A matt ground forgets where light came from, so that the sum over all ways has a closed form: besides the
//! coat's own reflection, the BSDF is `r/pi T(o) T(i) / (eta^2 (1 - r K))`, with the share T that the coat lets through and the share K
//! of the ground's light that it sends back. This is what the random walk of pbrt-v4's `coateddiffuse` estimates; here the sum is
//! exact. It is reciprocal, and a white ground under a smooth coat without thickness loses no light.
//!
//! Source: Jakob et al. 2014, "A Comprehensive Framework for Rendering Layered Materials", section 4; names and defaults of pbrt-v4.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `reflectance` | spectrum, texture | 0.5 | | share of the light that the ground reflects |
//! | `roughness` | float, texture | 0 | | of the coat: 0 (polished) to 1; that of a texture counts in 32 steps of alpha |
//! | `uroughness`, `vroughness` | float, texture | `roughness` | | along dp/du and dp/dv, instead of that of both |
//! | `remaproughness` | bool | true | | whether alpha is the square root of the roughness, or the roughness itself |
//! | `thickness` | float | 0.01 | | of the coat: light that crosses it straight keeps exp(-thickness) |
//! | `eta` | spectrum | 1.5 | | the coat's refractive index, 0.1 to 10; the same at all wavelengths |
//! | `albedo` | spectrum | 0 | | must be 0: a coat that scatters light is not supported yet |
//! | `g` | float | 0 | | no effect in a clear coat |
//! | `maxdepth`, `nsamples` | integer | 10, 1 | | no effect: all ways of the light are summed |
//!
//! ```bhs
//! Material "coateddiffuse" "rgb reflectance" [0.6 0.1 0.1] "float roughness" 0.05
//! ```

use crate::coat::Coat;
use crate::fresnel;
use crate::microfacet::{Ggx, SMOOTH};
use crate::roughness::Facets;
use bhs_core::Plugin;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::material::{BsdfSample, Material, Shading, same_hemisphere};
use bhs_core::params::Params;
use bhs_core::sampling::cosine_hemisphere;
use bhs_core::spectrum::{SampledSpectrum, SpectrumRole};
use bhs_core::texture::SpectrumParameter;
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;
use std::ops::RangeInclusive;
use std::sync::OnceLock;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Material> =
    Plugin { name: "coateddiffuse", summary: "a matt surface under a clear coat, such as plastic or varnish", build };

/// The range of indices: beyond it, what gets through a coat is so little that the sums over its ways say nothing.
const INDICES: RangeInclusive<f32> = 0.1..=10.0;

struct CoatedDiffuse {
    reflectance: SpectrumParameter,
    eta: f32,
    coats: Coats,
}

/// A coat with its surface; `None`: smooth.
struct Layer {
    facets: Option<Ggx>,
    coat: Coat,
}

/// The coats of all points.
enum Coats {
    One(Layer),
    /// By a texture; what gets through, in equal steps of alpha, each of which is made when it is first needed.
    Textured {
        facets: Facets,
        thickness: f32,
        steps: Vec<OnceLock<Layer>>,
    },
}

/// Steps of alpha between 0 and 1.
const STEPS: usize = 32;

fn build(p: &Params) -> Option<Box<dyn Material>> {
    let about = "share of the light that the ground reflects";
    let reflectance = p.spectrum_parameter("reflectance", 0.5, SpectrumRole::Reflectance, "", about);
    let facets = Facets::read(p);
    let thickness =
        p.get_in("thickness", 0.01, 0.0..=1e6, "", "of the coat: light that crosses it straight keeps exp(-thickness)");
    let spectrum = p.spectrum(
        "eta",
        1.5,
        SpectrumRole::Unbounded,
        "",
        "refractive index of the coat, 0.1 to 10, the same at all wavelengths",
    );
    let mut eta = spectrum.at(p.context().lambda_range[0]);
    if !spectrum.is_constant() {
        p.report(
            Diagnostic::error("unsupported", "dispersion in a coat is not supported yet")
                .at(p.span_of("eta"), "this refractive index depends on the wavelength")
                .help("give a number"),
        );
    }
    if !INDICES.contains(&eta) {
        let (least, most) = (INDICES.start(), INDICES.end());
        p.reject("eta", format!("`eta` is {eta:?}"), format!("the refractive index of a coat lies between {least} and {most}"));
        eta = 1.5;
    }
    let albedo = p.spectrum("albedo", 0.0, SpectrumRole::Reflectance, "", "must be 0: a coat that scatters is not supported yet");
    if albedo.max(1.0, 1e6) > 0.0 {
        p.report(
            Diagnostic::error("unsupported", "a coat that scatters light is not supported yet")
                .at(p.span_of("albedo"), "only 0 is possible")
                .help("remove `albedo`"),
        );
    }
    p.get_in("g", 0.0, -1.0..=1.0, "", "no effect in a clear coat");
    p.get_in("maxdepth", 10, 1..=1_000_000, "", "no effect: all ways of the light are summed");
    p.get_in("nsamples", 1, 1..=1_000_000, "", "no effect: all ways of the light are summed");
    let thickness = thickness as f32;
    // What gets through facets that are wider along one tangent is taken for that of as wide ones in the mean.
    let layer = |facets: Option<Ggx>| {
        let mean = facets.map(|f| Ggx::isotropic(f.mean_alpha()));
        Coats::One(Layer { facets, coat: Coat::new(eta, mean, thickness) })
    };
    let coats = match facets {
        Facets::Smooth => layer(None),
        Facets::Rough(facets) => layer(Some(facets)),
        facets => Coats::Textured { facets, thickness, steps: (0..=STEPS).map(|_| OnceLock::new()).collect() },
    };
    Some(Box::new(CoatedDiffuse { reflectance, eta, coats }))
}

impl CoatedDiffuse {
    /// The coat at a point, and its facets.
    #[inline]
    fn layer(&self, at: &Shading) -> (&Coat, Option<Ggx>) {
        match &self.coats {
            Coats::One(layer) => (&layer.coat, layer.facets),
            Coats::Textured { facets, thickness, steps } => {
                let here = facets.at(at);
                let alpha = here.map_or(0.0, Ggx::mean_alpha);
                let step = ((alpha * STEPS as f32).round() as usize).min(STEPS);
                let layer = steps[step].get_or_init(|| {
                    let facets = Some(Ggx::isotropic((step as f32 / STEPS as f32).max(SMOOTH)));
                    Layer { facets, coat: Coat::new(self.eta, facets, *thickness) }
                });
                (&layer.coat, if facets.is_oriented() { here } else { layer.facets })
            }
        }
    }

    /// The ground's part of the BSDF times pi, over the share that gets through from `wi`.
    fn ground(&self, coat: &Coat, at: &Shading, wo: Vec3) -> SampledSpectrum {
        let through = coat.through(wo.z.abs()) / (self.eta * self.eta);
        self.reflectance.sample(at).map(|r| r * through / (1.0 - r * coat.back))
    }

    /// Probability that a direction is chosen by the coat.
    fn chooses_coat(coat: &Coat, ground: SampledSpectrum, wo: Vec3) -> f32 {
        let mean_through = coat.mean_through;
        let coat = coat.reflected(wo.z.abs());
        let whole = coat + ground.mean() * mean_through;
        if whole > 0.0 { coat / whole } else { 1.0 }
    }

    /// The BSDF times |cos(theta_i)|, and the density of `wi`, but for a smooth coat's reflection; both on the side z > 0.
    fn both(
        &self,
        (coat, facets): (&Coat, Option<Ggx>),
        (ground, by_coat): (SampledSpectrum, f32),
        wo: Vec3,
        wi: Vec3,
    ) -> (SampledSpectrum, f32) {
        let cos_per_pi = wi.z * FRAC_1_PI;
        let mut value = ground * (coat.through(wi.z) * cos_per_pi);
        let mut pdf = (1.0 - by_coat) * cos_per_pi;
        if let (Some(facets), Some(m)) = (facets, (wo + wi).try_normalize()) {
            let mirrored = facets.mirrored_density(wo, m);
            let (reflected, _) = fresnel::dielectric(wo.dot(m).clamp(0.0, 1.0), self.eta);
            value += SampledSpectrum::splat(reflected * mirrored * facets.shadowing(wo, wi));
            pdf += by_coat * mirrored;
        }
        (value, pdf)
    }

    /// What [`CoatedDiffuse::both`] says, on either side; nothing crosses the ground.
    fn evaluate_both(&self, at: &Shading, wo: Vec3, wi: Vec3) -> (SampledSpectrum, f32) {
        if !same_hemisphere(wo, wi) {
            return (SampledSpectrum::ZERO, 0.0);
        }
        let side = Vec3::new(1.0, 1.0, wo.z.signum());
        let layer = self.layer(at);
        let ground = self.ground(layer.0, at, wo);
        let by_coat = Self::chooses_coat(layer.0, ground, wo);
        self.both(layer, (ground, by_coat), wo * side, wi * side)
    }
}

impl Material for CoatedDiffuse {
    fn evaluate(&self, at: &Shading, wo: Vec3, wi: Vec3) -> SampledSpectrum {
        self.evaluate_both(at, wo, wi).0
    }

    fn pdf(&self, at: &Shading, wo: Vec3, wi: Vec3) -> f32 {
        self.evaluate_both(at, wo, wi).1
    }

    fn sample(&self, at: &Shading, wo: Vec3, choice: f32, u: Vec2) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let side = Vec3::new(1.0, 1.0, wo.z.signum());
        let up = wo * side;
        let (coat, facets) = self.layer(at);
        let ground = self.ground(coat, at, wo);
        let by_coat = Self::chooses_coat(coat, ground, wo);
        let wi = if choice >= by_coat {
            cosine_hemisphere(u)
        } else if let Some(facets) = facets {
            fresnel::reflect(up, facets.sample_visible(up, u))
        } else {
            let wi = Vec3::new(-wo.x, -wo.y, wo.z);
            let weight = SampledSpectrum::splat(coat.reflected(up.z) / by_coat);
            return Some(BsdfSample { wi, weight, pdf: by_coat, specular: true, drops_wavelengths: false, eta: 1.0 });
        };
        if wi.z <= 0.0 {
            return None;
        }
        let (value, pdf) = self.both((coat, facets), (ground, by_coat), up, wi);
        (pdf > 0.0).then(|| BsdfSample {
            wi: wi * side,
            weight: value / pdf,
            pdf,
            specular: false,
            drops_wavelengths: false,
            eta: 1.0,
        })
    }

    fn reflectance(&self, at: &Shading, wo: Vec3) -> SampledSpectrum {
        let coat = self.layer(at).0;
        let reflected = coat.reflected(wo.z.abs());
        self.ground(coat, at, wo).map(|ground| reflected + ground * coat.mean_through)
    }

    fn is_uniform(&self) -> bool {
        self.reflectance.is_uniform() && matches!(self.coats, Coats::One(_)) && !self.is_oriented()
    }

    fn is_oriented(&self) -> bool {
        match &self.coats {
            Coats::One(layer) => layer.facets.is_some_and(|f| !f.is_isotropic()),
            Coats::Textured { facets, .. } => facets.is_oriented(),
        }
    }

    fn is_specular(&self) -> bool {
        false
    }

    fn chooses_directions(&self) -> bool {
        matches!(self.coats, Coats::One(Layer { facets: None, .. }))
    }
}
