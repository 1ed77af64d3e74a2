//! `mix`: two materials at once, each with its share of the surface.
//!
//! The BSDF is `(1 - amount) f_1 + amount f_2`; a direction is chosen by one of the two, with these shares as probabilities.
//!
//! A mix may have mixes as parts. A direction is chosen by one walk down to a material that is no mix; BSDF and density are the sums over
//! all of these, each with its share, so that both belong to each other for any `amount`, textured or not. Where mixes share
//! their parts, each part is evaluated once.
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
use std::collections::HashMap;
use std::ops::{Add, Mul};
use std::sync::Arc;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Material> = Plugin { name: "mix", summary: "two materials at once", build };

/// Evaluations of parts up to which it costs less to repeat them than to gather the parts first.
const REPEATED: u64 = 64;

struct Mix {
    materials: [Arc<dyn Material>; 2],
    amount: FloatParameter,
    /// What it takes to evaluate it without gathering the parts.
    evaluations: u64,
    is_oriented: bool,
    is_specular: bool,
    chooses_directions: bool,
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
    let materials = [first?, second?];
    Some(Box::new(Mix {
        evaluations: materials[0].evaluations().saturating_add(materials[1].evaluations()),
        is_oriented: materials.iter().any(|m| m.is_oriented()),
        is_specular: materials.iter().all(|m| m.is_specular()),
        chooses_directions: materials.iter().any(|m| m.chooses_directions()),
        materials,
        amount,
    }))
}

/// The materials within a mix that are no mixes, each once, with their shares at a point.
struct Shares<'m> {
    /// Mixes and other materials, every mix behind its parts.
    nodes: Vec<Node<'m>>,
    /// Index of each material by its address.
    known: HashMap<usize, usize>,
}

struct Node<'m> {
    material: &'m dyn Material,
    /// Indices and shares of the parts of a mix.
    parts: Option<[(usize, f32); 2]>,
    /// Share of the whole.
    share: f32,
}

impl<'m> Shares<'m> {
    fn new(root: &'m dyn Material, at: &Shading) -> Self {
        let mut shares = Self { nodes: Vec::new(), known: HashMap::new() };
        shares.gather(root, at);
        if let Some(root) = shares.nodes.last_mut() {
            root.share = 1.0;
        }
        // From the whole to its parts.
        for i in (0..shares.nodes.len()).rev() {
            let share = shares.nodes[i].share;
            for (part, of_this) in shares.nodes[i].parts.into_iter().flatten() {
                shares.nodes[part].share += share * of_this;
            }
        }
        shares
    }

    /// Adds a material behind its parts; its index. How deep mixes are nested has been limited when they were made.
    fn gather(&mut self, material: &'m dyn Material, at: &Shading) -> usize {
        let address = std::ptr::from_ref(material).cast::<()>() as usize;
        if let Some(index) = self.known.get(&address) {
            return *index;
        }
        let parts = material.parts(at).map(|parts| parts.map(|(part, share)| (self.gather(part, at), share)));
        self.nodes.push(Node { material, parts, share: 0.0 });
        self.known.insert(address, self.nodes.len() - 1);
        self.nodes.len() - 1
    }

    /// Those that are no mixes and have a share.
    fn leaves(&self) -> impl Iterator<Item = (&'m dyn Material, f32)> {
        self.nodes.iter().filter(|n| n.parts.is_none() && n.share > 0.0).map(|n| (n.material, n.share))
    }
}

impl Mix {
    fn shares(&self, at: &Shading) -> [f32; 2] {
        let amount = self.amount.at(at);
        [1.0 - amount, amount]
    }

    /// The sum over the parts of what `of` says of each, times its share.
    fn sum<T: Mul<f32, Output = T> + Add<Output = T>>(&self, at: &Shading, zero: T, of: impl Fn(&dyn Material) -> T) -> T {
        if self.evaluations <= REPEATED {
            let [first, second] = self.shares(at);
            return of(&*self.materials[0]) * first + of(&*self.materials[1]) * second;
        }
        Shares::new(self, at).leaves().fold(zero, |sum, (material, share)| sum + of(material) * share)
    }
}

impl Material for Mix {
    fn evaluate(&self, at: &Shading, wo: Vec3, wi: Vec3) -> SampledSpectrum {
        self.sum(at, SampledSpectrum::ZERO, |m| m.evaluate(at, wo, wi))
    }

    fn pdf(&self, at: &Shading, wo: Vec3, wi: Vec3) -> f32 {
        self.sum(at, 0.0, |m| m.pdf(at, wo, wi))
    }

    fn sample(&self, at: &Shading, wo: Vec3, choice: f32, u: Vec2) -> Option<BsdfSample> {
        let (mut chosen, mut choice): (&dyn Material, f32) = (self, choice);
        while let Some([(first, share), (second, other)]) = chosen.parts(at) {
            (chosen, choice) = if choice < share { (first, choice / share) } else { (second, (choice - share) / other) };
            choice = choice.clamp(0.0, ONE_MINUS_EPSILON);
        }
        let sample = chosen.sample(at, wo, choice, u)?;
        if sample.specular {
            // The share of the light is the share of the samples.
            return Some(sample);
        }
        let pdf = self.pdf(at, wo, sample.wi);
        let weight = self.evaluate(at, wo, sample.wi) / pdf;
        (pdf > 0.0 && weight.is_finite()).then_some(BsdfSample { weight, pdf, ..sample })
    }

    fn reflectance(&self, at: &Shading, wo: Vec3) -> SampledSpectrum {
        self.sum(at, SampledSpectrum::ZERO, |m| m.reflectance(at, wo))
    }

    fn parts(&self, at: &Shading) -> Option<[(&dyn Material, f32); 2]> {
        let [first, second] = self.shares(at);
        Some([(&*self.materials[0], first), (&*self.materials[1], second)])
    }

    fn evaluations(&self) -> u64 {
        self.evaluations
    }

    fn is_oriented(&self) -> bool {
        self.is_oriented
    }

    fn is_specular(&self) -> bool {
        self.is_specular
    }

    fn chooses_directions(&self) -> bool {
        self.chooses_directions
    }
}
