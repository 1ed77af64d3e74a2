//! Mixes of mixes: one that shares its parts in very many ways is the plain mix that it adds up to.

mod support;

use bhs_core::diagnostics::{Diagnostic, Spanned};
use bhs_core::image::Image;
use bhs_core::material::Material;
use bhs_core::params::{Context, Named, Nameless};
use bhs_core::texture::{Texture, TextureKind};
use glam::Vec2;
use std::collections::BTreeMap;
use std::sync::Arc;
use support::{
    AT, build, chi_square, direction, float, outgoing, random, rough_glass, rough_gold, sidak, texts, try_build_among,
};

/// Materials by name.
struct Layers(BTreeMap<String, Arc<dyn Material>>);

impl Named for Layers {
    fn texture(&self, name: &Spanned<String>, kind: TextureKind, context: &Context) -> Result<Arc<dyn Texture>, Box<Diagnostic>> {
        Nameless.texture(name, kind, context)
    }

    fn material(&self, name: &Spanned<String>, context: &Context) -> Result<Arc<dyn Material>, Box<Diagnostic>> {
        self.0.get(&name.value).cloned().map_or_else(|| Nameless.material(name, context), Ok)
    }

    fn image(&self, path: &Spanned<String>, context: &Context) -> Result<Arc<Image>, String> {
        Nameless.image(path, context)
    }
}

/// `layers` pairs of mixes of gold and glass, each of both mixes of the layer below: 2^layers ways from the last one down. Also the
/// share of glass in it.
fn tower(layers: usize) -> (Arc<dyn Material>, f64) {
    let [to_b, to_a] = [0.04, 0.07];
    let mut made = Layers(BTreeMap::new());
    made.0.insert("a0".into(), Arc::from(rough_gold(0.3)));
    made.0.insert("b0".into(), Arc::from(rough_glass(0.3)));
    let mut glass = [0.0, 1.0];
    for i in 1..=layers {
        let below = [format!("a{}", i - 1), format!("b{}", i - 1)];
        for (name, order, amount) in [("a", [0, 1], to_b), ("b", [1, 0], to_a)] {
            let names = order.map(|k| below[k].as_str());
            let (mix, found, _) = try_build_among(&made, "mix", &[texts("materials", &names), float("amount", amount)]);
            assert!(found.is_empty(), "{found:?}");
            made.0.insert(format!("{name}{i}"), Arc::from(mix.expect("without faults there is a material")));
        }
        glass = [glass[0] * (1.0 - to_b) + glass[1] * to_b, glass[1] * (1.0 - to_a) + glass[0] * to_a];
    }
    (Arc::clone(&made.0[&format!("a{layers}")]), glass[0])
}

#[test]
fn nested_mixes_are_what_they_add_up_to() {
    // Few layers are evaluated part by part, many are gathered first.
    for layers in [1, 3, 5, 6, 10, 50, 90] {
        let (tower, share) = tower(layers);
        let plain = build("mix", &[texts("materials", &["gold", "glass"]), float("amount", share)]);
        assert!(!tower.is_specular() && tower.chooses_directions());
        for wo in outgoing() {
            for wi in [direction(0.9, 1.0), direction(0.3, 3.0), direction(-0.5, 5.0)] {
                let [t, p] = [tower.pdf(&AT, wo, wi), plain.pdf(&AT, wo, wi)];
                assert!((t - p).abs() <= 2e-5 * p.max(1e-3), "{layers}: {t} {p}");
                let [t, p] = [tower.evaluate(&AT, wo, wi)[1], plain.evaluate(&AT, wo, wi)[1]];
                assert!((t - p).abs() <= 2e-5 * p.max(1e-3), "{layers}: {t} {p}");
            }
            let [t, p] = [tower.reflectance(&AT, wo)[2], plain.reflectance(&AT, wo)[2]];
            assert!((t - p).abs() <= 2e-5 * p, "{layers}: {t} {p}");
        }
    }
}

#[test]
fn nested_mixes_choose_with_the_density_of_what_they_add_up_to() {
    let cases = [(5, outgoing()[1]), (10, outgoing()[4]), (90, outgoing()[1])];
    let level = sidak(cases.len());
    for (i, (layers, wo)) in cases.into_iter().enumerate() {
        let (tower, share) = tower(layers);
        let plain = build("mix", &[texts("materials", &["gold", "glass"]), float("amount", share)]);
        let number = |k: u64, n: u64| random(i as u64, 3 * k + n);
        let sample = |k| {
            let sample = tower.sample(&AT, wo, number(k, 0), Vec2::new(number(k, 1), number(k, 2)))?;
            // What light sampling is weighted against is the density that the direction was drawn with.
            let [pdf, expected] = [f64::from(sample.pdf), f64::from(plain.pdf(&AT, wo, sample.wi))];
            assert!((pdf - expected).abs() <= 2e-5 * expected.max(1e-3), "{layers}: {pdf} {expected}");
            Some(sample.wi)
        };
        let p = chi_square(&sample, &|wi| f64::from(plain.pdf(&AT, wo, wi)));
        assert!(p > level, "{layers} layers, wo {wo}: p = {p:.2e} < {level:.2e}");
    }
}
