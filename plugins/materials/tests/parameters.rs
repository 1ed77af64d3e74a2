//! What materials say about their parameters, and about faults in them.

mod support;

use bhs_core::diagnostics::Span;
use bhs_core::value::Param;
use bhs_materials::ALL;
use glam::{Vec2, Vec3};
use support::{AT, boolean, build, float, named, try_build};

/// The messages of all findings, each of which has a place.
fn messages(plugin: &str, params: &[Param]) -> String {
    let (_, found, _) = try_build(plugin, params);
    let text = |d: &bhs_core::diagnostics::Diagnostic| {
        let label = d.primary.as_ref().expect("a place");
        assert_ne!(label.span, Span::default(), "{d:?}");
        format!("{}; {}; {}", d.message, label.text, d.help.as_deref().unwrap_or_default())
    };
    found.iter().map(text).collect::<Vec<_>>().join("\n")
}

#[track_caller]
fn expect(plugin: &str, params: &[Param], parts: &[&str]) {
    let text = messages(plugin, params);
    assert_eq!(text.lines().count(), 1, "{text}");
    for part in parts {
        assert!(text.contains(part), "`{part}` is not in: {text}");
    }
}

#[test]
fn each_material_needs_no_parameters_and_describes_them() {
    for plugin in ALL {
        let (material, found, table) = try_build(plugin.name, &[]);
        assert!(material.is_some() && found.is_empty(), "{}: {found:?}", plugin.name);
        let mut names: Vec<&str> = table.iter().map(|row| row.name).collect();
        assert!(table.iter().all(|row| !row.about.is_empty() && !row.default.is_empty()));
        names.sort_unstable();
        let count = names.len();
        names.dedup();
        assert_eq!(names.len(), count, "{} asks twice", plugin.name);
    }
}

#[test]
fn the_table_is_the_same_whatever_is_given() {
    let names = |params: &[Param]| try_build("conductor", params).2.iter().map(|r| r.name).collect::<Vec<_>>();
    assert_eq!(names(&[]), names(&[float("reflectance", 0.5)]));
}

#[test]
fn conductor_refuses_what_it_cannot_do() {
    let u = |u, v| [float("uroughness", u), float("vroughness", v)];
    expect("conductor", &u(0.1, 0.2), &["not supported yet", "0.1 along one tangent", "give one `roughness`"]);
    build("conductor", &u(0.1, 0.1));
    expect("conductor", &[float("roughness", 1.5)], &["`roughness` is out of range", "from 0 to 1, found 1.5"]);
    expect("conductor", &[float("uroughness", 1.5), float("roughness", 1.0)], &["`uroughness` is out of range"]);
    expect("conductor", &[float("reflectance", 0.5), named("k", "metal-Au-k")], &["`k` and `reflectance` exclude each other"]);
    expect("conductor", &[float("reflectance", 1.5)], &["between 0 and 1"]);
    expect("conductor", &[float("rougness", 0.1)], &["unknown parameter", "did you mean `roughness`?"]);
}

#[test]
fn dielectric_refuses_what_it_cannot_do() {
    expect("dielectric", &[named("eta", "glass-SF11")], &["dispersion is not supported yet", "\"float eta\" 1.7847"]);
    expect("dielectric", &[float("eta", 0.0)], &["`eta` is 0", "greater than 0"]);
    expect("dielectric", &[float("roughness", 0.1)], &["rough glass is not supported yet", "remove `roughness`"]);
    build("dielectric", &[float("roughness", 0.0), boolean("remaproughness", false), named("eta", "stdillum-E")]);
}

#[test]
fn roughness_is_mapped_as_in_pbrt() {
    let density = |params: &[Param]| build("conductor", params).pdf(&AT, Vec3::Z, Vec3::Z);
    let peak = |alpha: f32| 1.0 / (std::f32::consts::PI * alpha * alpha) / 4.0;
    // Mapped by default, alpha = sqrt(roughness).
    assert!((density(&[float("roughness", 0.09)]) / peak(0.3) - 1.0).abs() < 1e-5);
    assert!((density(&[float("roughness", 0.3), boolean("remaproughness", false)]) / peak(0.3) - 1.0).abs() < 1e-5);
    assert!((density(&[float("uroughness", 0.09), float("vroughness", 0.09)]) / peak(0.3) - 1.0).abs() < 1e-5);
    // Below an alpha of 0.001 a surface is smooth.
    let specular = |r| build("conductor", &[float("roughness", r), boolean("remaproughness", false)]).is_specular();
    assert!(specular(0.0) && specular(0.000_9) && !specular(0.001_1));
}

#[test]
fn defaults_are_pbrts() {
    let sample = |name: &str, params: &[Param]| build(name, params).sample(&AT, Vec3::Z, 0.999, Vec2::splat(0.5)).expect("light");
    let copper = [named("eta", "metal-Cu-eta"), named("k", "metal-Cu-k")];
    assert_eq!(sample("conductor", &[]), sample("conductor", &copper));
    assert_eq!(sample("dielectric", &[]), sample("dielectric", &[float("eta", 1.5)]));
    assert_eq!(sample("diffuse", &[]), sample("diffuse", &[float("reflectance", 0.5)]));
}
