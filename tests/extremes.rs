//! Extreme values of every number that a plugin takes: each is an error at its place, or gives a picture of finite numbers. Nothing panics,
//! nothing hangs.

use crate::common;
use bhs::lang::{self, Overrides, SourceMap};
use bhs::registry::{PluginInfo, Registry};
use std::sync::mpsc;
use std::time::Duration;

/// Numbers far from what anybody means.
const NUMBERS: &[&str] = &[
    "0",
    "-0.0",
    "-1",
    "1e-300",
    "-1e-300",
    "1e-40",
    "1e-30",
    "1e-10",
    "1e-3",
    "0.999999999",
    "1",
    "1.000001",
    "2",
    "60",
    "179.99999",
    "1e3",
    "1e6",
    "1e9",
    "1e15",
    "1e20",
    "1e30",
    "-1e30",
    "1e38",
    "3.4e38",
    "1e39",
    "1e300",
    "-1e300",
    "nan",
    "inf",
    "-inf",
    "1e999",
];

const INTEGERS: &[&str] = &[
    "0",
    "-1",
    "1",
    "2",
    "1000",
    "1000000",
    "1000000000",
    "2147483648",
    "4294967296",
    "9223372036854775807",
    "9223372036854775808",
    "-9223372036854775809",
    "100000000000000000000000000000",
];

/// Samples in a picture above which it is only built.
const MOST_SAMPLES: u64 = 20_000;

/// Longer than any of it takes (s).
const HANGING: u64 = 240;

/// A room with a lamp, seen by all plugins under test: `{options}`, `{world}` and what the floor is made of.
fn scene(options: &str, world: &str, film: bool, sampler: bool) -> String {
    let film = if film { "Film \"rgb\" \"integer xresolution\" 3 \"integer yresolution\" 3" } else { "" };
    let sampler = if sampler { "Sampler \"independent\" \"integer pixelsamples\" 2" } else { "" };
    format!(
        r#"LookAt 0 1 -4  0 0.5 0  0 1 0
        {film} {sampler}
        {options}
        WorldBegin
        LightSource "infinite" "float L" 0.5
        AttributeBegin
            Translate 0 3 0 Rotate 90 1 0 0
            AreaLightSource "diffuse" "float L" 4
            Shape "disk" "float radius" 0.5
        AttributeEnd
        {world}
        Rotate -90 1 0 0
        Shape "disk" "float radius" 5
        Translate 0 0 0.6
        Shape "sphere" "float radius" 0.6"#
    )
}

/// What a film has in these tests, and what shapes cannot do without: parameters by name.
const SIZE: &[(&str, &str)] = &[("xresolution", "\"integer xresolution\" 3"), ("yresolution", "\"integer yresolution\" 3")];
const SQUARE: &[(&str, &str)] =
    &[("P", "\"point3 P\" [-1 -1 0  1 -1 0  1 1 0  -1 1 0]"), ("indices", "\"integer indices\" [0 1 2  0 2 3]")];
const PATCH: &[(&str, &str)] = &[("P", "\"point3 P\" [-1 -1 0  1 -1 0  -1 1 0  1 1 0.3]")];

/// Numbers of the lists that plugins take: what they are if nothing is wrong with them.
fn list(name: &str) -> &'static str {
    match name {
        "screenwindow" => "-1 1 -1 1",
        "cropwindow" => "0 1 0 1",
        "P" => "-1 -1 0  1 -1 0  1 1 0  -1 1 0",
        "N" => "0 0 1  0 0 1  0 0 1  0 0 1",
        "uv" => "0 0  1 0  1 1  0 1",
        "indices" => "0 1 2  0 2 3",
        _ => "",
    }
}

/// The scene in which the plugin has the parameter text `given`; `None` for plugins that no scene names.
fn scene_of(plugin: &PluginInfo, given: &str, parameter: &str) -> Option<String> {
    let name = plugin.name;
    // What else it takes to be made; a parameter under test replaces it.
    let needed = |all: &[(&str, &str)]| {
        let others = all.iter().filter(|(name, _)| *name != parameter);
        others.map(|(_, text)| *text).collect::<Vec<_>>().join(" ")
    };
    let hole = "BlackHole \"schwarzschild\" \"point3 center\" [0.5 1.2 1] \"float rs\" 0.1";
    Some(match plugin.kind {
        "integrator" => scene(&format!("Integrator \"{name}\" {given}"), hole, true, true),
        "light transport" => scene(&format!("LightTransport \"{name}\" {given}"), "", true, true),
        "motion" => scene(&format!("Camera \"perspective\" \"string motion\" \"{name}\" {given}"), "", true, true),
        "camera" => scene(&format!("Camera \"{name}\" {given}"), "", true, true),
        "film" => {
            let size = needed(SIZE);
            scene(&format!("Film \"{name}\" {size} {given}"), "", false, true)
        }
        "filter" => scene(&format!("PixelFilter \"{name}\" {given}"), "", true, true),
        "sampler" => scene(&format!("Sampler \"{name}\" {given}"), "", true, false),
        "material" if name == "mix" => {
            let world = format!(
                "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" MakeNamedMaterial \"b\" \"string type\" \"conductor\"
                 Material \"mix\" \"string materials\" [\"a\" \"b\"] {given}"
            );
            scene("", &world, true, true)
        }
        "material" => scene("", &format!("Material \"{name}\" {given}"), true, true),
        "texture" => {
            let file = if name == "imagemap" { "\"string filename\" \"grammar/examples/tiles.png\"" } else { "" };
            // A texture of numbers takes no spectra.
            let is_spectrum = ["spectrum", "rgb", "blackbody", "tolman"].iter().any(|t| given.starts_with(&format!("\"{t} ")));
            let floats = if is_spectrum { "" } else { given };
            let world = format!(
                "Texture \"s\" \"spectrum\" \"{name}\" {file} {given} Texture \"f\" \"float\" \"{name}\" {file} {floats}
                 Texture \"zero\" \"spectrum\" \"scale\" \"texture tex\" \"s\" \"float scale\" 0
                 MakeNamedMaterial \"d\" \"string type\" \"diffuse\" \"texture reflectance\" \"s\"
                 MakeNamedMaterial \"e\" \"string type\" \"diffuse\" \"texture reflectance\" \"zero\"
                 MakeNamedMaterial \"de\" \"string type\" \"mix\" \"string materials\" [\"d\" \"e\"] \"texture amount\" \"f\"
                 MakeNamedMaterial \"c\" \"string type\" \"conductor\" \"texture eta\" \"s\" \"texture roughness\" \"f\"
                 Material \"mix\" \"string materials\" [\"de\" \"c\"]"
            );
            scene("", &world, true, true)
        }
        "light" => scene("", &format!("LightSource \"{name}\" {given}"), true, true),
        "area light" => {
            let world = format!(
                "AttributeBegin Translate 1 1 0 AreaLightSource \"{name}\" {given} Shape \"sphere\" \"float radius\" 0.3 AttributeEnd"
            );
            scene("", &world, true, true)
        }
        "shape" => {
            let needs = match name {
                "trianglemesh" => needed(SQUARE),
                "bilinearmesh" => needed(PATCH),
                "plymesh" => "\"string filename\" \"grammar/examples/pyramid.ply\"".to_owned(),
                "objmesh" => "\"string filename\" \"grammar/examples/pyramid.obj\"".to_owned(),
                _ => String::new(),
            };
            let shape = format!("Shape \"{name}\" {needs} {given}");
            scene(
                "",
                &format!("{shape} AttributeBegin Translate 0 2 0 AreaLightSource \"diffuse\" {shape} AttributeEnd"),
                true,
                true,
            )
        }
        "intersector" => return None,
        other => panic!("no scene for a plugin of the kind `{other}`"),
    })
}

/// All ways to give the parameter an extreme value.
fn given(name: &str, types: &str) -> Vec<String> {
    let mut all = Vec::new();
    let numbers = list(name);
    for ty in types.split(", ") {
        match ty {
            _ if !numbers.is_empty() => {
                // One of several goes astray.
                let values = if ty == "integer" { INTEGERS } else { NUMBERS };
                let count = numbers.split_whitespace().count();
                for (value, at) in values.iter().flat_map(|v| [0, count / 2, count - 1].map(|at| (v, at))) {
                    let list: Vec<&str> =
                        numbers.split_whitespace().enumerate().map(|(i, n)| if i == at { value } else { n }).collect();
                    all.push(format!("\"{ty} {name}\" [{}]", list.join(" ")));
                }
                all.push(format!("\"{ty} {name}\" []"));
                all.extend(values.iter().map(|v| format!("\"{ty} {name}\" [{}]", vec![*v; count].join(" "))));
            }
            "float" => all.extend(NUMBERS.iter().map(|v| format!("\"float {name}\" {v}"))),
            "integer" => all.extend(INTEGERS.iter().map(|v| format!("\"integer {name}\" {v}"))),
            "spectrum" => {
                for v in NUMBERS {
                    all.push(format!("\"spectrum {name}\" {v}"));
                    all.push(format!("\"spectrum {name}\" [400 {v}  700 0.5]"));
                    all.push(format!("\"spectrum {name}\" [{v} 1  700 0.5]"));
                    all.push(format!("\"rgb {name}\" [{v} 0.2 0]"));
                    all.push(format!("\"rgb {name}\" [{v} {v} {v}]"));
                    all.push(format!("\"blackbody {name}\" {v}"));
                    all.push(format!("\"tolman {name}\" {v}"));
                }
            }
            "point2" | "vector2" | "point3" | "vector3" | "normal" => {
                let count = if ty.ends_with('2') { 2 } else { 3 };
                for v in NUMBERS {
                    all.push(format!("\"{ty} {name}\" [{}]", vec![*v; count].join(" ")));
                    all.push(format!("\"{ty} {name}\" [{v}{}]", " 0.5".repeat(count - 1)));
                    all.push(format!("\"{ty} {name}\" [{}{v}]", "0 ".repeat(count - 1)));
                }
            }
            _ => {}
        }
    }
    all
}

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
