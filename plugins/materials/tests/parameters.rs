//! What materials say about their parameters, and about faults in them.

mod support;

use bhs_core::diagnostics::Span;
use bhs_core::value::Param;
use bhs_materials::ALL;
use glam::{Vec2, Vec3};
use support::{AT, boolean, build, float, named, texts, texture, try_build};

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
        // All but one: a mix is of something.
        let needs = found.len() == 1 && found[0].code == "missing-parameter" && plugin.name == "mix";
        assert!(needs || (material.is_some() && found.is_empty()), "{}: {found:?}", plugin.name);
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
    assert!(build("conductor", &u(0.1, 0.2)).is_oriented() && !build("conductor", &u(0.1, 0.2)).is_uniform());
    assert!(!build("conductor", &u(0.1, 0.1)).is_oriented() && build("conductor", &u(0.1, 0.1)).is_uniform());
    expect("conductor", &[float("roughness", 1.5)], &["`roughness` is out of range", "from 0 to 1, found 1.5"]);
    expect("conductor", &[float("uroughness", 1.5), float("roughness", 1.0)], &["`uroughness` is out of range"]);
    expect("conductor", &[float("reflectance", 0.5), named("k", "metal-Au-k")], &["`k` and `reflectance` exclude each other"]);
    expect("conductor", &[float("reflectance", 1.5)], &["between 0 and 1"]);
    expect("conductor", &[float("rougness", 0.1)], &["unknown parameter", "did you mean `roughness`?"]);
}

#[test]
fn dielectric_refuses_what_it_cannot_do() {
    for eta in [0.0, 1e-30, 9e-4, 1001.0, 1e30] {
        expect("dielectric", &[float("eta", eta)], &["`eta` is", "lies between 0.001 and 1000"]);
    }
    expect("dielectric", &[float("roughness", 2.0)], &["`roughness` is out of range"]);
    assert!(build("dielectric", &[float("uroughness", 0.1)]).is_oriented());
    build("dielectric", &[float("roughness", 0.1), boolean("remaproughness", false), named("eta", "glass-SF11")]);
}

#[test]
fn coats_and_mixes_refuse_what_they_cannot_do() {
    expect("coateddiffuse", &[float("albedo", 0.5)], &["a coat that scatters light is not supported yet"]);
    expect("coateddiffuse", &[named("eta", "glass-BK7")], &["dispersion in a coat is not supported yet"]);
    for eta in [0.0, 1e-30, 0.09, 10.1, 1e30] {
        expect("coateddiffuse", &[float("eta", eta)], &["`eta` is", "lies between 0.1 and 10"]);
    }
    expect("mix", &[texts("materials", &["gold"])], &["`materials` has 1 names", "a mix is of two materials"]);
    expect("mix", &[texts("materials", &["gold", "matt"]), float("amount", 1.5)], &["`amount` is out of range"]);
}

#[test]
fn textures_stand_for_spectra_and_numbers() {
    let at = |u| bhs_core::material::Shading { uv: Vec2::new(u, 0.0), ..AT };
    let weight =
        |params: &[Param], u| build("diffuse", params).sample(&at(u), Vec3::Z, 0.5, Vec2::splat(0.3)).expect("light").weight;
    assert_eq!(weight(&[texture("reflectance", "ramp")], 0.25), weight(&[float("reflectance", 0.25)], 0.0));
    // A reflectance is at most 1.
    assert_eq!(weight(&[texture("reflectance", "ramp")], 3.0), weight(&[float("reflectance", 1.0)], 0.0));
    for name in ["conductor", "dielectric"] {
        let [textured, plain] = [texture("roughness", "ramp"), float("roughness", 0.3)].map(|p| build(name, &[p]));
        assert_eq!(textured.pdf(&at(0.3), Vec3::Z, Vec3::Z), plain.pdf(&AT, Vec3::Z, Vec3::Z));
        assert!(!textured.is_specular());
        let brushed = build(name, &[texture("uroughness", "ramp"), float("vroughness", 0.2)]);
        let plain = build(name, &[float("uroughness", 0.3), float("vroughness", 0.2)]);
        assert_eq!(brushed.pdf(&at(0.3), Vec3::Z, Vec3::Z), plain.pdf(&AT, Vec3::Z, Vec3::Z));
        // One texture for both tangents is one roughness.
        assert!(brushed.is_oriented() && !textured.is_oriented());
    }
    let mix = build("mix", &[texts("materials", &["matt", "mirror"]), texture("amount", "ramp")]);
    assert!((mix.evaluate(&at(0.75), Vec3::Z, Vec3::Z)[0] - 0.25 / std::f32::consts::PI).abs() < 1e-6);
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
    let sheet = [float("reflectance", 0.25), float("transmittance", 0.25), float("scale", 1.0)];
    assert_eq!(sample("diffusetransmission", &[]), sample("diffusetransmission", &sheet));
    let coat = [float("reflectance", 0.5), float("roughness", 0.0), float("thickness", 0.01), float("eta", 1.5)];
    assert_eq!(sample("coateddiffuse", &[]), sample("coateddiffuse", &coat));
    let both = texts("materials", &["gold", "matt"]);
    assert_eq!(sample("mix", std::slice::from_ref(&both)), sample("mix", &[both.clone(), float("amount", 0.5)]));
}
