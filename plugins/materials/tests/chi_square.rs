//! Directions are drawn with the density that `pdf` states: chi-square tests, which also fail when they should.

mod support;

use bhs_core::material::Material;
use glam::{Vec2, Vec3};
use support::{
    AT, boolean, brushed, build, chi_square, coated, float, named, outgoing, random, rough_glass, rough_gold, rough_white, sidak,
    texts, upper_gamma,
};

const ALPHAS: [f64; 5] = [0.02, 0.1, 0.3, 0.7, 1.0];

/// The p-value of `sampled`'s directions against the density of `judged`.
fn p_value(sampled: &dyn Material, judged: &dyn Material, wo: Vec3, seed: u64) -> f64 {
    let number = |k: u64, i: u64| random(seed, 3 * k + i);
    let sample = |k| sampled.sample(&AT, wo, number(k, 0), Vec2::new(number(k, 1), number(k, 2))).map(|s| s.wi);
    chi_square(&sample, &|wi| f64::from(judged.pdf(&AT, wo, wi)))
}

#[test]
fn samples_have_their_density() {
    let mut materials = vec![("diffuse".to_owned(), build("diffuse", &[]))];
    materials.extend(ALPHAS.map(|a| (format!("conductor with alpha {a}"), rough_gold(a))));
    materials.extend([0.1, 0.3, 0.7].map(|a| (format!("glass with alpha {a}"), rough_glass(a))));
    let rough = [float("roughness", 0.2), boolean("remaproughness", false)];
    materials.extend([
        ("dispersive glass".to_owned(), build("dielectric", &[&[named("eta", "glass-SF11")], &rough[..]].concat())),
        ("coated".to_owned(), coated(0.7, 0.2, 0.01)),
        (
            "coated metal".to_owned(),
            build(
                "coatedconductor",
                &[float("interface.roughness", 0.3), float("conductor.roughness", 0.2), boolean("remaproughness", false)],
            ),
        ),
        ("paper".to_owned(), build("diffusetransmission", &[float("reflectance", 0.6), float("transmittance", 0.2)])),
        ("brushed metal".to_owned(), brushed("conductor", "", [0.05, 0.4], &[])),
        ("glass with grooves".to_owned(), brushed("dielectric", "", [0.5, 0.15], &[])),
        (
            "brushed under varnish".to_owned(),
            brushed("coatedconductor", "conductor.", [0.4, 0.1], &[float("interface.roughness", 0.3)]),
        ),
        ("a coat with grooves".to_owned(), brushed("coateddiffuse", "", [0.1, 0.5], &[])),
        ("mix".to_owned(), build("mix", &[texts("materials", &["gold", "glass"]), float("amount", 0.4)])),
    ]);
    materials.extend(support::principled_rows());
    let cases: Vec<_> = materials.iter().flat_map(|m| outgoing().into_iter().map(move |wo| (m, wo))).collect();
    let level = sidak(cases.len());
    let mut p_values = Vec::new();
    for (i, ((name, material), wo)) in cases.iter().enumerate() {
        let p = p_value(&**material, &**material, *wo, i as u64);
        assert!(p > level, "{name}, wo {wo}: p = {p:.2e} < {level:.2e}");
        p_values.push(p);
    }
    // p-values of a right density are uniform: neither all near 0 nor all near 1 (four standard deviations).
    let mean = p_values.iter().sum::<f64>() / p_values.len() as f64;
    assert!((mean - 0.5).abs() < 4.0 / (12.0 * p_values.len() as f64).sqrt(), "mean p-value {mean}");
}

#[test]
fn a_wrong_density_is_noticed() {
    let wo = outgoing()[1];
    let level = sidak(30);
    let (narrow, wide, diffuse) = (rough_white(0.3), rough_white(0.32), build("diffuse", &[]));
    assert!(p_value(&*narrow, &*wide, wo, 1) < level);
    assert!(p_value(&*diffuse, &*wide, wo, 2) < level);
    // 3 % too much, 3 % too little, and the right density of a slightly different viewer.
    let sample = |k| diffuse.sample(&AT, wo, 0.5, Vec2::new(random(3, 2 * k), random(3, 2 * k + 1))).map(|s| s.wi);
    let scaled = |s: f64| chi_square(&sample, &|wi| s * f64::from(diffuse.pdf(&AT, wo, wi)));
    assert!(scaled(1.03) < level && scaled(0.97) < level && scaled(1.0) > level);
    let moved = Vec3::new(wo.x + 0.05, wo.y, wo.z).normalize();
    let sample = |k| narrow.sample(&AT, wo, 0.5, Vec2::new(random(4, 2 * k), random(4, 2 * k + 1))).map(|s| s.wi);
    assert!(chi_square(&sample, &|wi| f64::from(narrow.pdf(&AT, moved, wi))) < level);
}

#[test]
fn tail_probabilities_are_right() {
    // Q(1/2, x) = erfc(sqrt x), Q(1, x) = exp(-x), Q(2, x) = (1 + x) exp(-x); the last is a table's 5 % point.
    assert!((upper_gamma(0.5, 1.0) - 0.157_299_207_050_285_13).abs() < 1e-12);
    for x in [0.1, 1.0, 3.0, 20.0f64] {
        assert!((upper_gamma(1.0, x) - (-x).exp()).abs() < 1e-12);
        assert!((upper_gamma(2.0, x) - (1.0 + x) * (-x).exp()).abs() < 1e-12);
    }
    assert!((upper_gamma(50.0, 124.342 / 2.0) - 0.05).abs() < 1e-5);
}
