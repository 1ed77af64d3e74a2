//! `mix`: two materials at once, each with its share of the surface.
//!
//! The BSDF is `(1 - amount) f_1 + amount f_2`; a direction is chosen by one of the two, with these shares as probabilities.
//!
//! Names and defaults of pbrt-v4, which chooses one material for each ray by a hash of the point: the mean is the same.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `materials` | string | required | | the names of two materials |
//! | `amount` | float, texture | 0.5 | | share of the second one, 0 to 1 |
//!
//! ```bhs
//! MakeNamedMaterial "gold" "string type" "conductor" "float roughness" 0.1
//! MakeNamedMaterial "paint" "string type" "diffuse"
//! Material "mix" "string materials" ["gold" "paint"] "float amount" 0.3
//! ```

use bhs_core::Plugin;
use bhs_core::diagnostics::{Diagnostic, Spanned};
use bhs_core::material::{BsdfSample, Material, Shading};
use bhs_core::params::Params;
use bhs_core::sampling::ONE_MINUS_EPSILON;
use bhs_core::spectrum::SampledSpectrum;
use bhs_core::texture::FloatParameter;
use glam::{Vec2, Vec3};
use std::sync::Arc;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Material> = Plugin { name: "mix", summary: "two materials at once", build };

struct Mix {
    materials: [Arc<dyn Material>; 2],
    amount: FloatParameter,
}

fn build(p: &Params) -> Option<Box<dyn Material>> {
    let names = p.require::<Vec<Spanned<String>>>("materials", "", "the names of two materials");
    let amount = p.float_parameter("amount", 0.5, 0.0..=1.0, "", "share of the second material, 0 to 1");
    let names = names?;
    let [first, second] = names.as_slice() else {
        let message = format!("`materials` has {} names", names.len());
        p.report(Diagnostic::error("wrong-count", message).at(p.span_of("materials"), "a mix is of two materials"));
        return None;
    };
    let find = |name| match p.context().named.material(name, p.context()) {
        Ok(material) => Some(material),
        Err(fault) => {
            p.report(*fault);
            None
        }
    };
    let (first, second) = (find(first), find(second));
    Some(Box::new(Mix { materials: [first?, second?], amount }))
}

impl Mix {
    fn shares(&self, at: &Shading) -> [f32; 2] {
        let amount = self.amount.at(at);
        [1.0 - amount, amount]
    }
}

impl Material for Mix {
    fn evaluate(&self, at: &Shading, wo: Vec3, wi: Vec3) -> SampledSpectrum {
        let [first, second] = self.shares(at);
        self.materials[0].evaluate(at, wo, wi) * first + self.materials[1].evaluate(at, wo, wi) * second
    }

    fn pdf(&self, at: &Shading, wo: Vec3, wi: Vec3) -> f32 {
        let [first, second] = self.shares(at);
        self.materials[0].pdf(at, wo, wi) * first + self.materials[1].pdf(at, wo, wi) * second
    }

    fn sample(&self, at: &Shading, wo: Vec3, choice: f32, u: Vec2) -> Option<BsdfSample> {
        let [first, second] = self.shares(at);
        let (which, choice) = if choice < first { (0, choice / first) } else { (1, (choice - first) / second) };
        let sample = self.materials[which].sample(at, wo, choice.clamp(0.0, ONE_MINUS_EPSILON), u)?;
        if sample.specular {
            // The share of the light is the share of the samples.
            return Some(sample);
        }
        let pdf = self.pdf(at, wo, sample.wi);
        let weight = self.evaluate(at, wo, sample.wi) / pdf;
        (pdf > 0.0 && weight.is_finite()).then_some(BsdfSample { weight, pdf, ..sample })
    }

    fn reflectance(&self, at: &Shading, wo: Vec3) -> SampledSpectrum {
        let [first, second] = self.shares(at);
        self.materials[0].reflectance(at, wo) * first + self.materials[1].reflectance(at, wo) * second
    }

    fn is_specular(&self) -> bool {
        self.materials.iter().all(|m| m.is_specular())
    }

    fn chooses_directions(&self) -> bool {
        self.materials.iter().any(|m| m.chooses_directions())
    }
}
