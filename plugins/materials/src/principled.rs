//! `principled`: the surface that modelling programs describe: a base colour, how metallic it is, how rough, and a few shares more.
//!
//! It is a mix of a metal and of what is none, by `metallic`. A metal reflects the base colour at normal incidence. The other one reflects, by its
//! refractive index, a share at facets, and below them the base colour evenly (Lambert); `transmission` lets that share pass through the body in
//! place of the ground. Reflectances follow Schlick, facets are GGX with alpha = roughness^2; light that meets a second facet is lost. What the
//! facets reflect in all is missing on the ground, on the way in and on the way out, so that no light is created and light may run backwards.
//!
//! A `thin` body is a sheet that does not refract; light that passes it is the base colour. Of a solid one, that is the colour of what crosses two of
//! its surfaces. `clearcoat` adds a layer of lacquer (index 1.5). Smooth surfaces (an alpha below 0.001) mirror; a texture of roughness never is
//! smooth. With `twosided` false, the surface is not there for who looks at its inner side, as where other programs cull faces.
//!
//! Source: Khronos 2021, "glTF 2.0 Specification", appendix B, and its extensions KHR_materials_ior, specular, transmission, clearcoat; the
//! ground: Ashikhmin and Shirley 2000, "An Anisotropic Phong BRDF Model", with the exact share in place of theirs.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `reflectance` | spectrum, texture | 0.5 | | base colour |
//! | `metallic` | float, texture | 0 | | share of the metal |
//! | `roughness` | float, texture | 0.5 | | 0 (polished) to 1; alpha is its square |
//! | `eta` | float, texture | 1.5 | | refractive index of what is no metal, 0.1 to 10 |
//! | `specular` | float, texture | 1 | | factor of what its facets reflect; a clear solid body has 1 always |
//! | `clearcoat` | float, texture | 0 | | share that has a coat of lacquer |
//! | `clearcoatroughness` | float, texture | 0 | | of that coat |
//! | `transmission` | float, texture | 0 | | share of what is no metal that is clear |
//! | `thin` | bool | false | | whether the clear body is a sheet, through which light goes straight on |
//! | `twosided` | bool | true | | whether the inner side is there |
//!
//! ```bhs
//! WorldBegin
//! Material "principled" "rgb reflectance" [0.9 0.6 0.2] "float metallic" 1 "float roughness" 0.3
//! ```

use crate::microfacet::{Ggx, SMOOTH};
use bhs_core::Plugin;
use bhs_core::material::{BsdfSample, Material, Shading, estimated_reflectance};
use bhs_core::params::Params;
use bhs_core::spectrum::{SampledSpectrum, SpectrumRole};
use bhs_core::texture::{FloatParameter, SpectrumParameter};
use glam::{Vec2, Vec3};
use lobes::Lobes;

mod albedo;
mod lobes;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Material> = Plugin {
    name: "principled",
    summary: "base colour, metallic, roughness: the material of glTF and of modelling programs",
    build,
};

struct Principled {
    reflectance: SpectrumParameter,
    metallic: FloatParameter,
    roughness: FloatParameter,
    eta: FloatParameter,
    specular: FloatParameter,
    clearcoat: FloatParameter,
    clearcoat_roughness: FloatParameter,
    transmission: FloatParameter,
    thin: bool,
    two_sided: bool,
}

fn build(p: &Params) -> Option<Box<dyn Material>> {
    let share = |name, default, about| p.float_parameter(name, default, 0.0..=1.0, "", about);
    Some(Box::new(Principled {
        reflectance: p.spectrum_parameter("reflectance", 0.5, SpectrumRole::Reflectance, "", "base colour"),
        metallic: share("metallic", 0.0, "share of the metal"),
        roughness: share("roughness", 0.5, "0 (polished) to 1; alpha is its square"),
        eta: p.float_parameter("eta", 1.5, 0.1..=10.0, "", "refractive index of what is no metal, 0.1 to 10"),
        specular: share("specular", 1.0, "factor of what its facets reflect; a clear solid body has 1 always"),
        clearcoat: share("clearcoat", 0.0, "share that has a coat of lacquer"),
        clearcoat_roughness: share("clearcoatroughness", 0.0, "of that coat"),
        transmission: share("transmission", 0.0, "share of what is no metal that is clear"),
        thin: p.get("thin", false, "", "whether the clear body is a sheet, through which light goes straight on"),
        two_sided: p.get("twosided", true, "", "whether the inner side is there"),
    }))
}

/// The facets of a roughness; `None`: smooth.
fn facets(roughness: &FloatParameter, at: &Shading) -> Option<Ggx> {
    let value = roughness.at(at);
    match roughness {
        FloatParameter::Constant(_) if value * value < SMOOTH => None,
        _ => Some(Ggx { alpha: Vec2::splat((value * value).max(SMOOTH)) }),
    }
}

fn constant(parameter: &FloatParameter) -> Option<f32> {
    match parameter {
        FloatParameter::Constant(value) => Some(*value),
        FloatParameter::Texture { .. } => None,
    }
}

impl Principled {
    fn lobes(&self, at: &Shading) -> Lobes {
        let (eta, specular) = (self.eta.at(at), self.specular.at(at));
        let one = (eta - 1.0) / (eta + 1.0);
        Lobes {
            base: self.reflectance.sample(at),
            metallic: self.metallic.at(at),
            transmission: self.transmission.at(at),
            coat: self.clearcoat.at(at),
            facets: facets(&self.roughness, at),
            coat_facets: facets(&self.clearcoat_roughness, at),
            f0: specular * one * one,
            f90: specular,
            eta,
            thin: self.thin,
        }
    }

    /// Whether light is not scattered but goes on, as it does at the inner side of what has none.
    fn is_absent(&self, wo: Vec3) -> bool {
        !self.two_sided && wo.z < 0.0
    }

    fn is_smooth(roughness: &FloatParameter) -> bool {
        constant(roughness).is_some_and(|r| r * r < SMOOTH)
    }

    fn has_coat(&self) -> bool {
        constant(&self.clearcoat) != Some(0.0)
    }

    fn is_clear(&self) -> bool {
        constant(&self.transmission) != Some(0.0)
    }
}

impl Material for Principled {
    fn evaluate(&self, at: &Shading, wo: Vec3, wi: Vec3) -> SampledSpectrum {
        if self.is_absent(wo) { SampledSpectrum::ZERO } else { self.lobes(at).evaluate(wo, wi).0 }
    }

    fn pdf(&self, at: &Shading, wo: Vec3, wi: Vec3) -> f32 {
        if self.is_absent(wo) { 0.0 } else { self.lobes(at).evaluate(wo, wi).1 }
    }

    fn sample(&self, at: &Shading, wo: Vec3, choice: f32, u: Vec2) -> Option<BsdfSample> {
        if self.is_absent(wo) {
            let weight = SampledSpectrum::ONE;
            return Some(BsdfSample { wi: -wo, weight, pdf: 1.0, specular: true, drops_wavelengths: false, eta: 1.0 });
        }
        self.lobes(at).sample(wo, choice, u)
    }

    fn reflectance(&self, at: &Shading, wo: Vec3) -> SampledSpectrum {
        if self.is_absent(wo) {
            return SampledSpectrum::ONE;
        }
        self.lobes(at).whole(wo.z.abs()).unwrap_or_else(|| estimated_reflectance(self, at, wo))
    }

    fn is_uniform(&self) -> bool {
        let all = [
            &self.metallic,
            &self.roughness,
            &self.eta,
            &self.specular,
            &self.clearcoat,
            &self.clearcoat_roughness,
            &self.transmission,
        ];
        self.reflectance.is_uniform() && all.iter().all(|p| constant(p).is_some()) && !self.is_clear()
    }

    fn refractive_index(&self) -> Option<f32> {
        let clear = constant(&self.transmission).is_some_and(|t| t > 0.0) && !self.thin;
        constant(&self.eta).filter(|_| clear)
    }

    fn is_specular(&self) -> bool {
        let no_ground = constant(&self.metallic) == Some(1.0) || constant(&self.transmission) == Some(1.0);
        let coat = !self.has_coat() || Self::is_smooth(&self.clearcoat_roughness);
        no_ground && coat && Self::is_smooth(&self.roughness)
    }

    fn chooses_directions(&self) -> bool {
        let coat = self.has_coat() && Self::is_smooth(&self.clearcoat_roughness);
        coat || self.is_clear() || Self::is_smooth(&self.roughness) || !self.two_sided
    }
}
