//! Files of artists: what OBJ files with materials and glTF files become is the scene that somebody would have written by hand.

mod gltf;
mod gltf_files;
mod mtl;
mod relief;

use crate::common;
use bhs::lang::{self, BuiltScene, Overrides, SourceMap};
use bhs::registry::Registry;
use bhs_core::diagnostics::Diagnostic;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

/// Files that there are, in place of those of the system.
pub type Files<'f> = &'f [(&'f str, Vec<u8>)];

/// Builds the file `name`.
pub fn load(files: Files, name: &str, overrides: &Overrides) -> Result<BuiltScene, Vec<Diagnostic>> {
    let files: BTreeMap<PathBuf, Arc<[u8]>> = files.iter().map(|(name, data)| (name.into(), data.as_slice().into())).collect();
    lang::load(name, &Registry::builtin(), overrides, &mut SourceMap::in_memory(files))
}

/// A small picture of a world that is some three units wide.
const VIEW: &str = r#"Film "rgb" "integer xresolution" 12 "integer yresolution" 9
    LightTransport "path" "integer maxdepth" 3 "bool caustics" false
    Sampler "sobol" "integer pixelsamples" 8 LookAt 0.4 0.7 -3.5  0 0.1 0  0 1 0 Camera "perspective" "float fov" 45"#;
const SKY: &str = r#"WorldBegin LightSource "infinite" "rgb L" [0.9 1 0.8]"#;

/// Builds a world that is lit from all sides; what is said of it, errors or warnings.
pub fn world(files: Files, world: &str) -> (Option<BuiltScene>, Vec<String>) {
    let scene = format!("{VIEW}\n{SKY}\n{world}\n");
    let files: Vec<(&str, Vec<u8>)> = files.iter().cloned().chain([("scene.bhs", scene.into_bytes())]).collect();
    let say = |d: Diagnostic| match d.primary {
        Some(label) if !label.text.is_empty() => format!("{}: {}", d.message, label.text),
        _ => d.message,
    };
    match load(&files, "scene.bhs", &Overrides::default()) {
        Ok(mut built) => {
            let said = std::mem::take(&mut built.warnings).into_iter().map(say).collect();
            (Some(built), said)
        }
        Err(found) => (None, found.into_iter().map(say).collect()),
    }
}

/// The pixels of a scene.
pub fn pixels(built: &BuiltScene) -> Vec<f32> {
    common::render(built).frame.picture().data
}

/// The picture of a world without faults.
pub fn picture(files: Files, text: &str) -> Vec<f32> {
    let (built, said) = world(files, text);
    assert!(said.is_empty(), "{said:?}\n{text}");
    pixels(&built.expect("without faults there is a scene"))
}

/// Whether two worlds look the same, but for rounding, and not like nothing.
pub fn same(name: &str, files: Files, [found, expected]: [&str; 2]) {
    let [found, expected] = [found, expected].map(|text| picture(files, text));
    let nothing = picture(files, "Translate 0 0 -50 Shape \"sphere\"");
    let off = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(off(&found, &expected) < 2e-3, "{name}: {}\n{found:?}\n{expected:?}", off(&found, &expected));
    assert!(off(&found, &nothing) > 1e-2, "{name}: nothing is seen");
}
