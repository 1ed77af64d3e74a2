//! Loading: what is made side by side is what is made one by one, and curves in a row look as curves apart.

use crate::common;
use bhs::lang::{self, BuiltScene, Overrides, SourceMap};
use bhs::registry::Registry;
use bhs_core::diagnostics::Diagnostic;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

type Loaded = Result<BuiltScene, Vec<Diagnostic>>;

/// Loads the scene of some files on so many threads.
fn load(files: &BTreeMap<PathBuf, Arc<[u8]>>, threads: usize) -> Loaded {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
    let mut sources = SourceMap::in_memory(files.clone());
    pool.install(|| lang::load("scene.bhs", &Registry::builtin(), &Overrides::default(), &mut sources))
}

fn ply(i: usize) -> Vec<u8> {
    let x = i as f64 * 0.1;
    format!("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 2\nproperty list uchar int vertex_indices\nend_header\n{x} 0 2\n{x} 1 2\n{} 0 2\n3 0 1 2\n2 0 1\n", x + 0.1)
        .into_bytes()
}

/// A scene of 150 files, each of which has a face that is left out, which a warning says; and among them a model that is shared.
fn files() -> BTreeMap<PathBuf, Arc<[u8]>> {
    let mut text = "WorldBegin\nLightSource \"infinite\"\n".to_owned();
    let mut files = BTreeMap::new();
    for i in 0..150 {
        text += &format!("Shape \"plymesh\" \"string filename\" \"{i}.ply\"\n");
        files.insert(PathBuf::from(format!("{i}.ply")), Arc::from(ply(i)));
        if i % 40 == 7 {
            text += "Shape \"objmesh\" \"string filename\" \"a.obj\"\n";
        }
    }
    files.insert("a.obj".into(), Arc::from(b"v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\n".as_slice()));
    files.insert("scene.bhs".into(), Arc::from(text.into_bytes()));
    files
}

fn words(found: &[Diagnostic]) -> Vec<String> {
    found.iter().map(|d| format!("{:?} {}", d.primary, d.message)).collect()
}

#[test]
fn shapes_made_side_by_side_are_those_made_one_by_one() {
    let files = files();
    let [one, many] = [1, 5].map(|threads| load(&files, threads).unwrap_or_else(|found| panic!("{found:?}")));
    // A hash of all contents in the order of the scene.
    assert_eq!(one.hash, many.hash);
    assert_eq!(words(&one.warnings), words(&many.warnings));
    assert_eq!(many.warnings.len(), 150);
    let [one, many] = [&one, &many].map(|built| {
        let bounds = built.scene.world.geometries.iter().map(|g| format!("{:?}", g.bounds()));
        let numbers = built.scene.shapes.iter().map(|s| s.index.to_string());
        bounds.chain(numbers).collect::<Vec<_>>()
    });
    assert_eq!(one, many);
    assert_eq!(one.len(), 2 * 154);
}

#[test]
fn the_hash_is_of_all_files_in_the_order_of_the_scene() {
    let mut other = files();
    let hash = |files: &_| load(files, 4).unwrap_or_else(|found| panic!("{found:?}")).hash;
    let before = hash(&other);
    let (a, b) = (other[&PathBuf::from("70.ply")].clone(), other[&PathBuf::from("71.ply")].clone());
    other.insert("70.ply".into(), b);
    other.insert("71.ply".into(), a);
    assert_ne!(hash(&other), before);
}

#[test]
fn faults_of_several_files_come_in_the_order_of_the_scene() {
    let mut files = files();
    for i in [140, 3, 70] {
        files.insert(format!("{i}.ply").into(), Arc::from(b"nothing".as_slice()));
    }
    files.remove(&PathBuf::from("20.ply"));
    let [one, many] = [1, 5].map(|threads| load(&files, threads).err().expect("it is faulty"));
    assert_eq!(words(&one), words(&many));
    let errors: Vec<&str> = many.iter().filter(|d| d.code == "bad-file").map(|d| d.message.as_str()).collect();
    let names: Vec<bool> =
        ["3.ply", "20.ply", "70.ply", "140.ply"].iter().zip(&errors).map(|(name, e)| e.contains(name)).collect();
    assert_eq!(names, [true; 4], "{errors:?}");
}

#[test]
fn curves_in_a_row_are_one_mesh_and_look_as_curves_apart() {
    let curve = |i: usize| {
        let x = i as f64 * 0.2 - 0.5;
        format!("Shape \"curve\" \"point3 P\" [{x} -0.5 3  {x} 0 2.8  {x} 0.2 3  {} 0.5 3] \"float width\" 0.05\n", x + 0.1)
    };
    let scene = |between: &str| {
        let curves: String = (0..6).map(|i| format!("{between}{}", curve(i))).collect();
        common::build(&format!(
            "Film \"rgb\" \"integer xresolution\" 24 \"integer yresolution\" 18\nSampler \"sobol\" \"integer pixelsamples\" 2\nWorldBegin\nLightSource \"infinite\"\nMaterial \"diffuse\" \"rgb reflectance\" [0.8 0.3 0.1]\n{curves}"
        ))
    };
    let (row, apart) = (scene(""), scene("Material \"diffuse\" \"rgb reflectance\" [0.8 0.3 0.1]\n"));
    assert_eq!([row.scene.world.geometries.len(), apart.scene.world.geometries.len()], [1, 6]);
    assert_eq!(row.load.triangles, apart.load.triangles);
    let [row, apart] = [&row, &apart].map(|built| common::render(built).frame.picture().data);
    assert!(row == apart && row.iter().any(|v| *v > 0.0));
    // What emits, or is something else, stays what it is.
    let lamps = scene("AreaLightSource \"diffuse\"\n");
    assert_eq!(lamps.scene.world.geometries.len(), 6);
    let others = common::build(&format!("WorldBegin\nLightSource \"infinite\"\n{}Shape \"sphere\"\n{}", curve(0), curve(1)));
    assert_eq!(others.scene.world.geometries.len(), 3);
}
