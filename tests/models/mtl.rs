//! What the statements of MTL files become.

use super::{same, world};
use crate::common;

/// A square of the material `m` before the viewer.
const SQUARE: &str =
    "mtllib a b.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl m\nf 1/1 2/2 3/3 4/4\n";
const WHOLE: &str = r#"Shape "objmesh" "string filename" "in/a.obj" "bool materials" false"#;

fn files(statements: &str) -> Vec<(&'static str, Vec<u8>)> {
    let tiles = std::fs::read(common::root().join("grammar/examples/tiles.png")).expect("the picture is there");
    vec![
        ("in/a.obj", SQUARE.as_bytes().to_vec()),
        ("in/a b.mtl", format!("newmtl m\n{statements}\n").into_bytes()),
        ("in/my tiles.png", tiles),
    ]
}

#[test]
fn statements_mean_what_somebody_would_have_written() {
    let tiles = r#""string filename" "in/my tiles.png""#;
    let table: &[(&str, String)] = &[
        ("Kd 0.8 0.2 0.1\nKs 0 0 0\nillum 2", r#"Material "diffuse" "rgb reflectance" [0.8 0.2 0.1]"#.into()),
        ("Kd 0.8 0.2 0.1\nKs 1 1 1\nillum 1", r#"Material "diffuse" "rgb reflectance" [0.8 0.2 0.1]"#.into()),
        (
            "Kd 0.8 0.2 0.1\nKs 1 1 1\nNs 48\nNi 1.7\nillum 2",
            r#"Material "coateddiffuse" "rgb reflectance" [0.8 0.2 0.1] "float roughness" 0.2 "bool remaproughness" false "float eta" 1.7"#.into(),
        ),
        (
            "map_Kd -s 2 3 -o 0.25 0.5 my tiles.png",
            format!(
                r#"Texture "t" "spectrum" "imagemap" {tiles} "float uscale" 2 "float vscale" 3 "float udelta" 0.25 "float vdelta" 0.5
                Material "diffuse" "texture reflectance" "t""#
            ),
        ),
        (
            "Kd 0.5 1 0.5\nmap_Kd C:\\work\\my tiles.png",
            format!(
                r#"Texture "t" "spectrum" "imagemap" {tiles} Texture "p" "spectrum" "product" "texture tex1" "t" "rgb tex2" [0.5 1 0.5]
                Material "diffuse" "texture reflectance" "p""#
            ),
        ),
        ("Kd 0 0 0\nKe 2 1 0.5", r#"AreaLightSource "diffuse" "rgb L" [2 1 0.5] Material "diffuse" "rgb reflectance" [0 0 0]"#.into()),
        (
            "Kd 0 0 0\nmap_Ke my tiles.png",
            format!(
                r#"Texture "t" "spectrum" "imagemap" {tiles} AreaLightSource "diffuse" "texture L" "t"
                Material "diffuse" "rgb reflectance" [0 0 0]"#
            ),
        ),
        (
            "Kd 0.8 0.2 0.1\nd 0.25",
            r#"MakeNamedMaterial "n" "string type" "interface" MakeNamedMaterial "w" "string type" "diffuse" "rgb reflectance" [0.8 0.2 0.1]
            Material "mix" "string materials" ["n" "w"] "float amount" 0.25"#
                .into(),
        ),
        (
            "Kd 0.8 0.2 0.1\nTr 0.75\nmap_d -imfchan r my tiles.png\nillum 4",
            format!(
                r#"MakeNamedMaterial "n" "string type" "interface" MakeNamedMaterial "w" "string type" "diffuse" "rgb reflectance" [0.8 0.2 0.1]
                Texture "a" "float" "imagemap" {tiles} "string channel" "red" "string encoding" "linear" "float scale" 0.25
                Material "mix" "string materials" ["n" "w"] "texture amount" "a""#
            ),
        ),
        ("Kd 0.8 0.2 0.1\nKs 1 1 1\nNi 1.3\nillum 7\nd 0.1", r#"Material "dielectric" "float eta" 1.3"#.into()),
        (
            "Ni 1.5\nTf 0.9 0.2 0.1\nillum 4",
            r#"Material "principled" "float transmission" 1 "float roughness" 0 "rgb reflectance" [0.9 0.2 0.1]"#.into(),
        ),
        (
            "Kd 0.8 0.2 0.1\nPm 0.75\nPr 0.5\nPc 0.5\nPcr 0.25",
            r#"Material "principled" "rgb reflectance" [0.8 0.2 0.1] "float metallic" 0.75 "float roughness" 0.5 "float clearcoat" 0.5
            "float clearcoatroughness" 0.25"#
                .into(),
        ),
    ];
    for (statements, expected) in table {
        let by_hand = format!("{expected} {WHOLE}");
        same(statements, &files(statements), [r#"Shape "objmesh" "string filename" "in/a.obj""#, &by_hand]);
    }
}

#[test]
fn what_is_lost_is_told_and_the_current_material_counts() {
    let shape = r#"Material "conductor" Shape "objmesh" "string filename" "in/a.obj""#;
    let without_library = vec![files("").remove(0)];
    let lost = "the materials of `in/a.obj` are not there: `a b.mtl`: what has them has the current material";
    assert_eq!(world(&without_library, shape).1, [lost]);
    same(
        "current material",
        &files("newmtl other"),
        [
            r#"Material "conductor" Shape "objmesh" "string filename" "in/a.obj" "string group" "m""#,
            &format!("Material \"conductor\" {WHOLE}"),
        ],
    );
    let mut other = files("");
    other[1].1 = b"newmtl other\nKd 1 0 0\n".to_vec();
    let unknown = "materials of `in/a.obj` are in no file that it names: `m`: what has them has the current material";
    assert_eq!(world(&other, shape).1, [unknown]);
    let mut nameless = without_library;
    nameless[0].1 = SQUARE.replace("mtllib a b.mtl\n", "").into_bytes();
    let none = "`in/a.obj` names materials and no file of them (`mtllib`): `m`: what has them has the current material";
    assert_eq!(world(&nameless, shape).1, [none]);
    let pictures = world(&files("map_Kd no.png\nmap_Bump b.png\nrefl n.png\ndecal d.png\nKd x"), shape).1;
    let expected = [
        "`in/a b.mtl`: line 6: `Kd` needs three numbers, and is not read",
        "pictures of `in/a.obj` are not there: `b.png`, `no.png`: its materials do without them",
        "statements of the materials of `in/a.obj` are not read: `decal`, `refl`: the picture lacks what they add",
    ];
    assert_eq!(pictures, expected);
    // Who says so gets none of them, and hears nothing.
    assert_eq!(world(&files("what"), WHOLE).1, [""; 0]);
}

#[test]
fn each_material_has_its_faces_and_nothing_lasts() {
    let obj = "mtllib a.mtl b.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3\nusemtl lamp\nf 1 3 4\n";
    let files =
        [("a.obj", obj.as_bytes().to_vec()), ("a.mtl", b"newmtl x\n".to_vec()), ("b.mtl", b"newmtl lamp\nKe 3 2 1\n".to_vec())];
    let expected = r#"Material "diffuse" "rgb reflectance" [0.2 0.9 0.2] Shape "objmesh" "string filename" "a.obj" "string group" ""
        AttributeBegin Material "diffuse" "rgb reflectance" [0.5 0.5 0.5] AreaLightSource "diffuse" "rgb L" [3 2 1]
        Shape "objmesh" "string filename" "a.obj" "string group" "lamp" AttributeEnd Translate 1.2 0 0 Shape "sphere" "float radius" 0.3"#;
    let found = r#"Material "diffuse" "rgb reflectance" [0.2 0.9 0.2] Shape "objmesh" "string filename" "a.obj"
        Translate 1.2 0 0 Shape "sphere" "float radius" 0.3"#;
    same("two materials", &files, [found, expected]);
    // What the scene states for its own materials is not of the file's.
    let stated = format!("Attribute \"material\" \"rgb reflectance\" [1 0 0] Attribute \"light\" \"float scale\" 9 {found}");
    assert!(world(&files, &stated).0.is_some());
}
