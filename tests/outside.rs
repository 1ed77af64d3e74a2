//! Plugins of another crate: a layer and a spectrum join by [`Registry::with`], are named by a scene, listed and drawn.

use crate::common;
use bhs::lang::{self, BuiltScene, Overrides, SourceMap};
use bhs::plugins_table;
use bhs::registry::Registry;
use bhs_core::Plugin;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::params::{Context, Params, SpectrumMaker};
use bhs_core::spectrum::{Spectrum, SpectrumRole};
use bhs_core::value::{Param, Values};
use bhs_engine::layer::{Layer, LayerFormat, Value, VisibleSurface, scalar};
use std::sync::Arc;

/// How high above a plane a surface is.
struct Height {
    above: f64,
}

const HEIGHT: Plugin<dyn Layer> = Plugin {
    name: "height",
    summary: "height of the surface above a plane",
    build: |p: &Params| Some(Box::new(Height { above: p.get("plane", 0.0, "scene", "height of the plane") })),
};

impl Layer for Height {
    fn format(&self) -> LayerFormat {
        LayerFormat::new(&["height"], "scene")
    }

    fn value(&self, seen: &VisibleSurface) -> Option<Value> {
        let hit = seen.hit()?;
        Some(scalar(hit.point.y + seen.scene.world.origin.y - self.above))
    }
}

/// Spectra that grow with the wavelength, from 0 to a value at 1000 nm.
struct Ramps;

const RAMPS: Plugin<dyn SpectrumMaker> =
    Plugin { name: "ramps", summary: "grow with the wavelength", build: |_| Some(Box::new(Ramps)) };

#[derive(Debug)]
struct Ramp(f32);

impl SpectrumMaker for Ramps {
    fn names(&self) -> Vec<&'static str> {
        vec!["ramp", "steep-ramp"]
    }

    fn make(&self, param: &Param, role: SpectrumRole, _: &Context) -> Result<Arc<dyn Spectrum>, Vec<Diagnostic>> {
        let Values::Strings(texts) = &param.values else { return Err(Vec::new()) };
        let slope = if texts[0].value == "ramp" { 1.0 } else { 4.0 };
        match role.fault(slope) {
            Some(cause) => Err(vec![Diagnostic::error("bad-value", "this ramp is too steep").at(texts[0].span, cause)]),
            None => Ok(Arc::new(Ramp(slope as f32))),
        }
    }
}

impl Spectrum for Ramp {
    fn at(&self, lambda_nm: f32) -> f32 {
        self.0 * lambda_nm / 1000.0
    }

    fn max(&self, _: f32, hi: f32) -> f32 {
        self.at(hi)
    }
}

fn registry() -> Registry {
    Registry::builtin().with(HEIGHT).with(RAMPS)
}

fn load(registry: &Registry, text: &str) -> Result<BuiltScene, Vec<Diagnostic>> {
    lang::load_text("test.bhs", text, registry, &Overrides::default(), &mut SourceMap::new())
}

/// A shining ball beside a hole.
fn scene(layers: &str, light: &str, reflectance: &str) -> String {
    format!(
        r#"
        LookAt 0 0 -4  0 0 0  0 1 0
        Camera "perspective" "float fov" 60
        Film "rgb" "integer xresolution" 16 "integer yresolution" 12 "string layers" [{layers}]
        Sampler "sobol" "integer pixelsamples" 4
        WorldBegin
        BlackHole "schwarzschild" "float rs" 0.2 "bool redshift" false
        LightSource "infinite" "spectrum L" {light}
        Translate 1 0.5 1
        Material "diffuse" "spectrum reflectance" {reflectance}
        Shape "sphere"
        "#
    )
}

#[test]
fn a_layer_and_a_spectrum_from_outside_are_drawn() {
    let layers = r#""position" "height"] "float plane" [-0.25"#;
    let built = load(&registry(), &scene(layers, r#""steep-ramp""#, r#""ramp""#));
    let built = built.unwrap_or_else(|found| panic!("{found:?}"));
    assert!(built.warnings.is_empty(), "{:?}", built.warnings);
    let rendered = common::render(&built);
    let [position, height] = &rendered.frame.layers()[..] else { panic!("two layers") };
    assert_eq!(height.name, "height");
    let mut hits = 0;
    for (position, height) in position.values.iter().zip(&height.values) {
        assert_eq!(position.is_some(), height.is_some());
        if let (Some(position), Some(height)) = (position, height) {
            assert!((height[0] - (position[1] + 0.25)).abs() < 1e-12, "{height:?} {position:?}");
            hits += 1;
        }
    }
    assert!(hits > 20 && hits < 16 * 12, "{hits}");
    let picture = rendered.frame.picture().with_layers(&rendered.frame.layers());
    assert_eq!(picture.channels, ["R", "G", "B", "P.X", "P.Y", "P.Z", "height"]);

    // The same light as tables.
    let tables = scene(r#""position""#, "[1 0.004  1000 4]", "[1 0.001  1000 1]");
    let expected = common::render(&common::build(&tables)).frame.picture();
    for (pixel, expected) in picture.data.chunks(7).zip(expected.data.chunks(3)) {
        for c in 0..3 {
            assert!((pixel[c] - expected[c]).abs() <= 1e-4 * expected[1].abs(), "{pixel:?} {expected:?}");
        }
    }
}

#[test]
fn faults_are_said_as_those_of_the_tree() {
    let fault = |text: &str| load(&registry(), text).err().expect("a fault").remove(0);
    let near = fault(&scene(r#""hight""#, "1", "1"));
    assert_eq!(near.code, "unknown-layer");
    assert!(near.help.as_deref().is_some_and(|help| help.contains("did you mean `height`?")), "{near:?}");
    let near = fault(&scene(r#""depth""#, r#""ramb""#, "1"));
    assert_eq!((near.code, near.help.as_deref()), ("unknown-spectrum", Some("did you mean `ramp`?")));
    assert_eq!(fault(&scene(r#""depth""#, "1", r#""steep-ramp""#)).message, "this ramp is too steep");
    // A parameter of a layer that is not recorded is nobody's.
    assert_eq!(fault(&scene(r#""depth"] "float plane" [1"#, "1", "1")).code, "unknown-parameter");
    // What the program does not have it does not know.
    assert!(load(&Registry::builtin(), &scene(r#""height""#, "1", "1")).is_err());
}

#[test]
fn channels_that_cannot_be_recorded_are_the_layers_fault() {
    struct Odd(&'static [&'static str]);
    impl Layer for Odd {
        fn format(&self) -> LayerFormat {
            LayerFormat::new(self.0, "")
        }
        fn value(&self, _: &VisibleSurface) -> Option<Value> {
            None
        }
    }
    let odd: [Plugin<dyn Layer>; 3] = [
        Plugin { name: "odd", summary: "none", build: |_| Some(Box::new(Odd(&[]))) },
        Plugin { name: "odd", summary: "four", build: |_| Some(Box::new(Odd(&["a", "b", "c", "d"]))) },
        Plugin { name: "odd", summary: "another's", build: |_| Some(Box::new(Odd(&["depth"]))) },
    ];
    for plugin in odd {
        let found = load(&Registry::builtin().with(plugin), &scene(r#""depth" "odd""#, "1", "1")).err().expect("a fault");
        assert_eq!(found[0].code, "plugin-failed", "{}", plugin.summary);
    }
}

#[test]
fn layers_are_listed_with_channels_and_unit_and_spectra_with_their_names() {
    let registry = registry();
    let text = plugins_table::render(&registry, Some("layer"), None).expect("a kind");
    for part in ["position", "P.X, P.Y, P.Z  [scene]", "height  [scene]", "plane", "Variance.R"] {
        assert!(text.contains(part), "{part}:\n{text}");
    }
    let text = plugins_table::render(&registry, Some("spectrum"), Some("ramps")).expect("a plugin");
    assert!(text.contains("ramp, steep-ramp"), "{text}");
    let json = plugins_table::to_json(&registry, Some("layer"), Some("height")).expect("a plugin");
    assert_eq!((&json[0]["channels"][0], &json[0]["unit"]), (&"height".into(), &"scene".into()));
    let json = plugins_table::to_json(&registry, Some("spectrum"), Some("builtin")).expect("a plugin");
    assert!(json[0]["names"].as_array().is_some_and(|names| names.iter().any(|name| name == "stdillum-D65")));
}
