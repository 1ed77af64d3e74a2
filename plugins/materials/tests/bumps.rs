//! Bumps: a constant tilt is a tilted plane, a ramp is its slope, nothing looks away from the viewer, and no light leaks.

mod support;

use bhs_core::diagnostics::{Diagnostic, Spanned};
use bhs_core::image::{Image, Texels};
use bhs_core::material::{Material, Shading, Tangents};
use bhs_core::params::{Context, Named, Nameless, Params};
use bhs_core::texture::{Texture, TextureKind};
use bhs_core::value::Param;
use bhs_materials::bumps::Bumps;
use glam::{Quat, Vec2, Vec3};
use std::f32::consts::PI;
use std::sync::Arc;
use support::{
    AT, build, chi_square, context, direction, float, outgoing, over_sphere, random, rough_glass, rough_gold, sidak, texts,
    texture,
};

/// A scene with the texture "hill", u + 2 v, and the picture "n.png", which has one normal.
struct Things(Vec3);

struct Hill;

impl Texture for Hill {
    fn spectrum(&self, at: &Shading) -> bhs_core::spectrum::SampledSpectrum {
        bhs_core::spectrum::SampledSpectrum::splat(self.float(at))
    }

    fn float(&self, at: &Shading) -> f32 {
        at.uv.x + 2.0 * at.uv.y
    }
}

impl Named for Things {
    fn texture(&self, name: &Spanned<String>, kind: TextureKind, context: &Context) -> Result<Arc<dyn Texture>, Box<Diagnostic>> {
        if name.value == "hill" { Ok(Arc::new(Hill)) } else { Nameless.texture(name, kind, context) }
    }

    fn material(&self, name: &Spanned<String>, context: &Context) -> Result<Arc<dyn Material>, Box<Diagnostic>> {
        Nameless.material(name, context)
    }

    fn image(&self, path: &Spanned<String>, context: &Context) -> Result<Arc<Image>, String> {
        if path.value != "n.png" {
            return Nameless.image(path, context);
        }
        let texel = ((self.0.normalize() + 1.0) * 0.5 * 65535.0).round().to_array().map(|c| c as u16);
        Ok(Arc::new(Image::new([2, 2], Texels::Words(vec![texel; 4]))))
    }
}

/// The bumps that parameters state, and what was found.
fn bumps(things: &Things, params: &[Param]) -> (Option<Bumps>, Vec<Diagnostic>) {
    let p = Params::new(Spanned::new("diffuse".to_owned(), bhs_core::diagnostics::Span::default()), params, context(things));
    let bumps = Bumps::read(&p);
    (bumps, p.finish().0)
}

/// A material with a map of the one normal `n`.
fn tilted(material: Box<dyn Material>, n: Vec3) -> Box<dyn Material> {
    let (bumps, found) = bumps(&Things(n), &[texts("normalmap", &["n.png"])]);
    assert!(found.is_empty(), "{found:?}");
    bumps.expect("there is a map").over(material)
}

const NORMALS: [Vec3; 4] = [Vec3::Z, Vec3::new(0.3, -0.2, 0.9), Vec3::new(-0.6, 0.1, 0.6), Vec3::new(0.2, 0.7, 0.3)];

#[test]
fn a_map_of_one_normal_is_a_tilted_plane() {
    for n in NORMALS {
        let turn = Quat::from_rotation_arc(n.normalize(), Vec3::Z);
        let plain: [fn() -> Box<dyn Material>; 3] = [|| build("diffuse", &[]), || rough_gold(0.3), || rough_glass(0.3)];
        for make in plain {
            let (plain, bumped) = (make(), tilted(make(), n));
            let mut compared = 0;
            for k in 0..600u64 {
                let [wo, wi] = [0, 2].map(|i| {
                    direction(
                        f64::from(random(3, 4 * k + i)) * 2.0 - 1.0,
                        f64::from(random(3, 4 * k + i + 1)) * std::f64::consts::TAU,
                    )
                });
                let (o, i) = (turn * wo, turn * wi);
                // Where both planes agree on the sides, and, of a surface that mirrors, the mirror direction is on the viewer's.
                let mirrored = 2.0 * o.z * n.normalize() - wo;
                if wo.z * o.z <= 0.02 || (!plain.is_matt() && mirrored.z * wo.z.signum() < 0.02) {
                    continue;
                }
                if wi.z * i.z <= 0.0 {
                    assert!(bumped.evaluate(&AT, wo, wi).is_zero() && bumped.pdf(&AT, wo, wi) == 0.0);
                    continue;
                }
                let (found, expected) = (bumped.evaluate(&AT, wo, wi)[1], plain.evaluate(&AT, o, i)[1]);
                assert!((found - expected).abs() <= 2e-3 * expected.max(1e-2), "{n} {wo} {wi}: {found} {expected}");
                let (found, expected) = (bumped.pdf(&AT, wo, wi), plain.pdf(&AT, o, i));
                assert!((found - expected).abs() <= 2e-3 * expected.max(1e-2), "{n} {wo} {wi}: {found} {expected}");
                compared += 1;
            }
            assert!(compared > 60, "{compared}");
        }
    }
}

#[test]
fn a_displacement_tilts_by_its_slope() {
    let (bumps, found) = bumps(&Things(Vec3::Z), &[texture("displacement", "hill")]);
    assert!(found.is_empty());
    let bumped = bumps.expect("there is a hill").over(build("diffuse", &[]));
    let normal = |tangents, uv| bumped.normal(&Shading { uv, tangents, ..AT }, Vec3::Z);
    // z = u + 2 v, with x = 4 u and y = 5 v: slopes of 1/4 and 2/5.
    let flat = Tangents { point: [Vec3::X * 4.0, Vec3::Y * 5.0], ..Tangents::OF_AXES };
    let expected = Vec3::new(-0.25, -0.4, 1.0).normalize();
    assert!((normal(flat, Vec2::new(0.3, 0.1)) - expected).length() < 1e-3, "{}", normal(flat, Vec2::ZERO));
    // On a cylinder of radius 4 around y, displaced outwards by D, x = (4 + D) u/4: a smaller slope.
    let round = Tangents { normal: [Vec3::X, Vec3::ZERO], ..flat };
    let uv = Vec2::new(0.5, 0.25);
    let expected = Vec3::new(-1.0 / (4.0 + 1.0), -0.4, 1.0).normalize();
    assert!((normal(round, uv) - expected).length() < 1e-3, "{} {expected}", normal(round, uv));
    // Where u runs the other way round, the hill still rises on the outer side.
    let mirrored = Tangents { point: [Vec3::X * 4.0, Vec3::Y * -5.0], ..flat };
    let expected = Vec3::new(-0.25, 0.4, 1.0).normalize();
    assert!((normal(mirrored, Vec2::ZERO) - expected).length() < 1e-3);
}

#[test]
fn no_normal_looks_away_and_mirrors_lose_nothing() {
    for n in NORMALS {
        let mirror = tilted(build("mirror", &[]), n);
        for k in 0..2000u64 {
            let wo = direction(f64::from(random(9, 2 * k)) * 2.0 - 1.0, f64::from(random(9, 2 * k + 1)) * std::f64::consts::TAU);
            let side = wo.z.signum();
            let normal = mirror.normal(&AT, wo);
            assert!((normal.length() - 1.0).abs() < 1e-5 && normal.dot(wo) * side > 0.0, "{n} {wo}: {normal}");
            let sample = mirror.sample(&AT, wo, 0.5, Vec2::splat(0.5)).expect("a mirror reflects");
            assert!(sample.wi.z * side > 0.0 && (sample.weight[0] - 1.0).abs() < 1e-6, "{n} {wo}: {sample:?}");
        }
        // Steadily: a small change of view changes the normal little.
        for k in 0..200 {
            let angle = |k: i32| 0.02 + k as f64 * 0.0075;
            let [a, b] = [angle(k), angle(k) + 1e-3].map(|a| mirror.normal(&AT, direction(a.cos(), 1.0)));
            assert!((a - b).length() < 0.02, "{n} {k}: {a} {b}");
        }
    }
}

#[test]
fn no_light_leaks_or_is_created_and_samples_have_their_density() {
    let brushed = || support::brushed("conductor", "", [0.1, 0.4], &[float("reflectance", 1.0)]);
    let views = [outgoing()[1], outgoing()[3]];
    let cases = [(brushed as fn() -> Box<dyn Material>, NORMALS[1]), (|| rough_glass(0.3), NORMALS[2])];
    let level = sidak(cases.len() * views.len());
    for (j, (make, n)) in cases.into_iter().enumerate() {
        let material = tilted(make(), n);
        for (i, wo) in views.into_iter().enumerate() {
            if j == 0 {
                let leaks = |wi: Vec3| if wi.z * wo.z < 0.0 { f64::from(material.evaluate(&AT, wo, wi)[0]) } else { 0.0 };
                assert_eq!(over_sphere(&leaks, 1e-3), 0.0, "{n} {wo}");
                let all = over_sphere(&|wi| f64::from(material.evaluate(&AT, wo, wi)[0]), 1e-3);
                assert!(all <= 1.0 + 2e-3 && all > 0.2, "{n} {wo}: {all}");
            }
            let number = |k: u64, m: u64| random((i + 10 * j) as u64, 3 * k + m);
            let sample = |k| material.sample(&AT, wo, number(k, 0), Vec2::new(number(k, 1), number(k, 2))).map(|s| s.wi);
            let p = chi_square(&sample, &|wi| f64::from(material.pdf(&AT, wo, wi)));
            assert!(p > level, "{n}, wo {wo}: p = {p:.2e}");
        }
    }
}

#[test]
fn faults_of_bumps_have_their_places() {
    let both = [texts("normalmap", &["n.png"]), texture("displacement", "hill")];
    let (_, found) = bumps(&Things(Vec3::Z), &both);
    assert!(found.len() == 1 && found[0].message.contains("exclude each other"), "{found:?}");
    let (none, found) = bumps(&Things(Vec3::Z), &[texts("normalmap", &["other.png"])]);
    assert!(none.is_none() && found.len() == 1 && found[0].message.contains("cannot read `other.png`"), "{found:?}");
    let (none, found) = bumps(&Things(Vec3::Z), &[]);
    assert!(none.is_none() && found.is_empty());
    // A matt surface with its own normal is itself.
    let flat = tilted(build("diffuse", &[]), Vec3::Z);
    let value = flat.evaluate(&AT, Vec3::Z, direction(0.5, 1.0))[0];
    assert!((value - 0.25 / PI).abs() < 1e-5 && flat.is_oriented() && !flat.is_matt());
}
