//! Extreme values of every number that a plugin takes: each is an error at its place, or gives a picture of finite numbers. Nothing panics,
//! nothing hangs.

mod scenes;

use crate::common;
use bhs::lang::{self, Overrides, SourceMap};
use bhs::registry::Registry;
use scenes::{NUMBERS, given, scene, scene_of};
use std::sync::mpsc;
use std::time::Duration;

/// Samples in a picture above which it is only built.
const MOST_SAMPLES: u64 = 20_000;

/// Longer than any of it takes (s).
const HANGING: u64 = 240;

/// What becomes of a scene if nothing is wrong.
#[derive(Clone, Copy, PartialEq)]
enum Verdict {
    /// Errors at their places.
    Refused,
    /// Built, and too large to be rendered here.
    Built,
    /// A picture of finite numbers.
    Rendered,
}

/// What becomes of a scene, or what is wrong with that.
fn judge(text: &str) -> Result<Verdict, String> {
    let mut sources = SourceMap::new();
    let built = match lang::load_text("extreme.bhs", text, &Registry::builtin(), &Overrides::default(), &mut sources) {
        Ok(built) => built,
        Err(found) => {
            let errors: Vec<_> = found.iter().filter(|d| d.severity == bhs_core::diagnostics::Severity::Error).collect();
            let placed = errors.iter().all(|d| d.primary.as_ref().is_some_and(|p| p.span.end > p.span.start));
            let ours = errors.iter().any(|d| d.help.as_ref().is_some_and(|h| h.contains("fault of")));
            return if errors.is_empty() || !placed || ours { Err(format!("{found:?}")) } else { Ok(Verdict::Refused) };
        }
    };
    let [x0, x1, y0, y1] = built.film.crop().map(u64::from);
    let samples = (x1 - x0) * (y1 - y0) * u64::from(built.sampler.samples_per_pixel());
    if samples * built.film.channels().len() as u64 > MOST_SAMPLES {
        return Ok(Verdict::Built);
    }
    let rendered = common::render(&built);
    if rendered.counters.not_finite > 0 {
        return Err(format!("{} samples are not finite", rendered.counters.not_finite));
    }
    let beyond = rendered.frame.beyond_single_precision();
    let data = rendered.frame.picture().data;
    // What is too large for a file is named, and can only come from light near the largest number.
    if !beyond.is_empty() && !text.contains("e38") && !text.contains("e39") {
        return Err(format!("{beyond:?}"));
    }
    if data.iter().all(|v| v.is_finite()) { Ok(Verdict::Rendered) } else { Err("the picture is not finite".to_owned()) }
}

/// Judges all scenes; fails if anything is wrong with one, or if none of them is refused or none rendered.
fn judge_all(scenes: Vec<(String, String)>) {
    let (send, receive) = mpsc::channel();
    let names: Vec<String> = scenes.iter().map(|s| s.0.clone()).collect();
    let worker = std::thread::spawn(move || {
        for (_, text) in scenes {
            let verdict = std::panic::catch_unwind(|| judge(&text)).unwrap_or_else(|_| Err("a panic".to_owned()));
            if send.send(verdict).is_err() {
                return;
            }
        }
    });
    let (mut faults, mut verdicts) = (Vec::new(), Vec::new());
    for name in &names {
        match receive.recv_timeout(Duration::from_secs(HANGING)) {
            Ok(Ok(verdict)) => verdicts.push(verdict),
            Ok(Err(fault)) => faults.push(format!("{name}: {fault}")),
            Err(_) => panic!("{name}: hangs; before it:\n{}", faults.join("\n")),
        }
    }
    worker.join().expect("the worker catches panics");
    assert!(faults.is_empty(), "{} of {}:\n{}", faults.len(), names.len(), faults.join("\n"));
    for expected in [Verdict::Refused, Verdict::Rendered] {
        assert!(verdicts.contains(&expected), "{}", names[0]);
    }
}

fn check(kinds: &[&str]) {
    for plugin in Registry::builtin().describe().iter().filter(|p| kinds.contains(&p.kind)) {
        // As it is without any.
        let Some(text) = scene_of(plugin, "", "") else { continue };
        assert!(judge(&text) == Ok(Verdict::Rendered), "{} {}: {:?}", plugin.kind, plugin.name, judge(&text).err());
        let mut scenes = Vec::new();
        for parameter in &plugin.params {
            for given in given(parameter.name, parameter.ty) {
                let text = scene_of(plugin, &given, parameter.name);
                scenes.extend(text.map(|text| (format!("{} {} {given}", plugin.kind, plugin.name), text)));
            }
        }
        if !scenes.is_empty() {
            judge_all(scenes);
        }
    }
}

#[test]
fn methods_and_cameras() {
    check(&["integrator", "light transport", "camera", "motion", "film", "filter", "sampler"]);
}

#[test]
fn materials_and_textures() {
    check(&["material", "texture"]);
}

#[test]
fn lights() {
    check(&["light", "area light"]);
}

#[test]
fn shapes() {
    check(&["shape"]);
}

#[test]
fn the_hole_and_options() {
    let mut scenes = Vec::new();
    for given in
        ["center point3", "rs float"].iter().flat_map(|p| p.split_once(' ').map(|(name, ty)| given(name, ty)).unwrap_or_default())
    {
        let rs = if given.contains(" rs\"") { "" } else { "\"float rs\" 0.1" };
        let center = if given.contains("center") { "" } else { "\"point3 center\" [0.5 1.2 1]" };
        let world = format!("BlackHole \"schwarzschild\" {rs} {center} {given}");
        scenes.push((world.clone(), scene("", &world, true, true)));
    }
    for given in given("seed", "integer") {
        scenes.push((given.clone(), scene(&format!("Option {given}"), "", true, true)));
    }
    judge_all(scenes);
}

#[test]
fn transforms() {
    let mut scenes = Vec::new();
    for v in NUMBERS {
        for transform in [
            format!("Translate {v} 0 0"),
            format!("Scale {v} {v} {v}"),
            format!("Scale 1 {v} 1"),
            format!("Rotate {v} 0 1 0"),
            format!("Rotate 30 {v} 0 0"),
            format!("LookAt {v} 0 0  0 0 1  0 1 0"),
            format!("ConcatTransform [{v} 0 0 0  0 1 0 0  0 0 1 0  0 0 0 1]"),
            format!("ConcatTransform [1 {v} 0 0  0 1 0 0  0 0 1 0  0 0 0 1]"),
        ] {
            let world =
                format!("AttributeBegin {transform} Shape \"sphere\" \"float radius\" 0.5 Shape \"cylinder\" AttributeEnd");
            scenes.push((format!("world {transform}"), scene("", &world, true, true)));
            scenes.push((format!("camera {transform}"), scene(&format!("{transform} Camera \"perspective\""), "", true, true)));
        }
    }
    judge_all(scenes);
}

#[test]
fn extreme_indices_and_lamps_have_the_right_values() {
    let seen = |world: &str| {
        let text = format!(
            r#"Film "rgb" "integer xresolution" 4 "integer yresolution" 4
            Sampler "independent" "integer pixelsamples" 64
            Camera "perspective" "float fov" 10
            WorldBegin
            {world}"#
        );
        let picture = common::render(&common::build(&text)).frame.picture();
        picture.data.iter().map(|v| f64::from(*v)).sum::<f64>() / picture.data.len() as f64
    };
    let sky = "LightSource \"infinite\" \"float L\" 1";
    let white = seen(sky);
    // What reflects all light is not to be told from the sky around it.
    for (eta, k) in [("1e30", "1e30"), ("3.4e38", "0"), ("0", "1e38"), ("1e30", "1e-30")] {
        let ball = format!("{sky} Material \"conductor\" \"float eta\" {eta} \"float k\" {k} Translate 0 0 4 Shape \"sphere\"");
        assert!((seen(&ball) / white - 1.0).abs() < 1e-4, "{eta} {k}");
    }
    // A white ground under a smooth coat without thickness loses nothing, whatever its index.
    for eta in ["0.5", "1.5", "4", "10"] {
        let coated = format!(
            "{sky} Material \"coateddiffuse\" \"float reflectance\" 1 \"float thickness\" 0 \"float eta\" {eta}
             Translate 0 0 4 Shape \"disk\" \"float radius\" 9"
        );
        let lost = seen(&coated) / white - 1.0;
        assert!(lost.abs() < 0.05, "{eta}: {lost}");
    }
    // Radiance L of a ball of radius r at a distance d lights a white floor with L (r/d)^2: bright and small, or faint and near.
    for (radius, power) in [("1e-3", 1.0), ("1e-10", 1e14), ("1e-18", 1e30)] {
        let r: f64 = radius.parse().expect("a number");
        let scene = format!(
            "Material \"diffuse\" \"float reflectance\" 1 AttributeBegin Translate 0 0 4 Shape \"disk\" \"float radius\" 0.5 AttributeEnd
             AreaLightSource \"diffuse\" \"float L\" {power:e} Translate 0 0 2 Shape \"sphere\" \"float radius\" {radius}"
        );
        let text = scene.replace("Translate 0 0 2", "Translate 0 0.8 2");
        let (mean, cos2) = (seen(&text), 4.0 / (4.0 + 0.64));
        // The disk lies across the view; 0.8 aside, at a distance of 2 in depth; its edge is out of view.
        let expected = power * r * r / (4.0 + 0.64) * f64::sqrt(cos2) * white;
        assert!((mean / expected - 1.0).abs() < 0.3, "{radius}: {mean:e} {expected:e}");
    }
}
