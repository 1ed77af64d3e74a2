//! Scenes that are deep, long or wrong in very many places: done or refused, in time and memory that grow as the scene does.

use assert_cmd::Command;
use bhs::lang::{self, Overrides, SourceMap};
use bhs::registry::Registry;
use bhs_core::diagnostics::{Diagnostic, Severity};
use std::fmt::Write as _;
use std::time::Duration;

/// Far more than anything here takes, and far less than what grows with the square of a scene would.
const LONG: Duration = Duration::from_secs(120);

/// A small picture of a sphere of the material that is current.
const HEAD: &str = r#"Film "rgb" "integer xresolution" 8 "integer yresolution" 8 "string filename" "out.exr"
    Sampler "independent" "integer pixelsamples" 4 Option "string intersector" "reference"
    LookAt 0 0 -3 0 0 0 0 1 0 Camera "perspective"
    WorldBegin
    LightSource "infinite"
    "#;

/// What is said of a scene that is built from text.
fn load(text: &str) -> Vec<Diagnostic> {
    match lang::load_text("test.bhs", text, &Registry::builtin(), &Overrides::default(), &mut SourceMap::new()) {
        Ok(built) => built.warnings.clone(),
        Err(found) => found,
    }
}

fn errors(found: &[Diagnostic]) -> usize {
    found.iter().filter(|d| d.severity == Severity::Error).count()
}

/// Runs the program in a folder with the scene `text`; exit code and standard error.
fn run(text: &str, command: &[&str]) -> (i32, String) {
    let dir = tempfile::tempdir().expect("a temporary folder");
    std::fs::write(dir.path().join("scene.bhs"), text).expect("the folder can be written");
    let mut bhs = Command::new(assert_cmd::cargo::cargo_bin!("bhs"));
    let out = bhs.current_dir(dir.path()).args(command).arg("scene.bhs").timeout(LONG).output().expect("bhs starts");
    (out.status.code().unwrap_or(-1), String::from_utf8_lossy(&out.stderr).into_owned())
}

/// `count` of what `make` writes.
fn many(count: usize, make: impl Fn(usize) -> String) -> String {
    (0..count).fold(String::new(), |mut text, i| {
        let _ = writeln!(text, "{}", make(i));
        text
    })
}

/// Textures or materials that are made of each other: `depth` layers of a pair, each made of both of the layer below.
fn tower(depth: usize, layer: impl Fn(&str, [String; 2]) -> String) -> String {
    many(depth, |i| {
        let below = |a: &str, b: &str| [format!("{a}{i}"), format!("{b}{i}")];
        let above = |a: &str| format!("{a}{}", i + 1);
        layer(&above("a"), below("a", "b")) + "\n" + &layer(&above("b"), below("b", "a"))
    })
}

fn mixed_material(name: &str, [a, b]: [String; 2]) -> String {
    format!(r#"MakeNamedMaterial "{name}" "string type" "mix" "string materials" ["{a}" "{b}"]"#)
}

const TWO_MATERIALS: &str = r#"MakeNamedMaterial "a0" "string type" "diffuse" "float reflectance" 0.25
    MakeNamedMaterial "b0" "string type" "diffuse" "float reflectance" 0.75
    "#;
const TWO_TEXTURES: &str = r#"Texture "a0" "spectrum" "constant" "float value" 0.25
    Texture "b0" "spectrum" "constant" "float value" 0.75
    Texture "f" "float" "constant" "float value" 1
    "#;

/// The ways in which textures are made of others, with the values of the first texture of a tower of them.
type Composite = (&'static str, fn(&str, [String; 2]) -> String);

const COMPOSITES: [Composite; 4] = [
    ("0.5", |name, [a, b]| {
        format!(
            r#"Texture "{name}" "spectrum" "constant" "texture value" "{name}m"
            Texture "{name}m" "spectrum" "mix" "texture tex1" "{a}" "texture tex2" "{b}""#
        )
    }),
    ("0.5", |name, [a, b]| format!(r#"Texture "{name}" "spectrum" "mix" "texture tex1" "{a}" "texture tex2" "{b}""#)),
    ("0.25", |name, [a, _]| format!(r#"Texture "{name}" "spectrum" "scale" "texture tex" "{a}" "texture scale" "f""#)),
    ("0.25", |name, [a, b]| {
        // All of the sphere lies within the first square.
        format!(
            r#"Texture "{name}" "spectrum" "checkerboard" "float uscale" 0.1 "float vscale" 0.1
            "texture tex1" "{a}" "texture tex2" "{b}""#
        )
    }),
];

/// The picture of a scene.
fn picture(text: &str) -> Vec<f32> {
    let found = lang::load_text("test.bhs", text, &Registry::builtin(), &Overrides::default(), &mut SourceMap::new());
    let built = found.unwrap_or_else(|found| panic!("{found:?}"));
    bhs::render::render_quietly(&built).frame.picture().data
}

fn assert_equal_pictures(a: &str, b: &str) {
    let (a, b) = (picture(a), picture(b));
    assert!(a.iter().any(|v| *v > 0.1) && a.len() == b.len());
    for (a, b) in a.iter().zip(&b) {
        assert!((a - b).abs() < 1e-4 * b.abs().max(0.1), "{a} {b}");
    }
}

#[test]
fn parts_that_are_shared_in_very_many_ways_are_evaluated_once() {
    // 2^40 ways from the last material or texture to the first ones.
    let shown = "NamedMaterial \"a40\" Shape \"sphere\"";
    let tower_of_materials = format!("{HEAD}{TWO_MATERIALS}{}{shown}", tower(40, mixed_material));
    let grey = |value: &str| format!("{HEAD}Material \"diffuse\" \"float reflectance\" {value} Shape \"sphere\"");
    assert_equal_pictures(&tower_of_materials, &grey("0.5"));
    for (value, layer) in COMPOSITES {
        let shown = "Material \"diffuse\" \"texture reflectance\" \"a40\" Shape \"sphere\"";
        assert_equal_pictures(&format!("{HEAD}{TWO_TEXTURES}{}{shown}", tower(40, layer)), &grey(value));
    }
}

#[test]
fn very_many_textures_over_a_picture_are_refused_without_following_them_all() {
    let mut text = format!("{HEAD}Texture \"t0\" \"spectrum\" \"imagemap\" \"string filename\" \"none.png\"\n");
    for i in 1..=50_000 {
        text += &format!("Texture \"t{i}\" \"spectrum\" \"scale\" \"texture tex\" \"t{}\"\n", i - 1);
    }
    let shown = "Material \"diffuse\" \"texture reflectance\" \"t50000\" Shape \"sphere\"";
    let (code, err) = run(&format!("{text}{shown}"), &["check"]);
    assert!(code == 1 && err.contains("nested more than 100 deep"), "{code} {err}");
}

#[test]
fn what_is_nested_too_deeply_is_refused() {
    let backwards = |text: &str| text.lines().rev().fold(String::new(), |all, line| all + line + "\n");
    let textures = COMPOSITES.iter().map(|(_, layer)| {
        let shown = "Material \"diffuse\" \"texture reflectance\" \"a6000\" Shape \"sphere\"";
        (TWO_TEXTURES, tower(6000, |name, parts| layer(name, parts).replace('\n', " ")), shown)
    });
    let shown = "NamedMaterial \"a6000\" Shape \"sphere\"";
    for (parts, tower, shown) in textures.chain([(TWO_MATERIALS, tower(6000, mixed_material), shown)]) {
        for tower in [&tower, &backwards(&tower)] {
            let text = format!("{HEAD}{parts}{tower}{shown}");
            for command in ["check", "render"] {
                let (code, err) = run(&text, &[command]);
                assert!(code == 1 && err.contains("nested more than 100 deep") && err.contains("\n1 error\n"), "{code} {err}");
            }
        }
    }
    // As deep as is allowed works, on the small stack of a test too.
    let text = format!("{HEAD}{TWO_MATERIALS}{}NamedMaterial \"a99\" Shape \"sphere\"", backwards(&tower(99, mixed_material)));
    assert_eq!(errors(&load(&text)), 0);
}

#[test]
fn very_many_errors_are_counted_and_not_all_kept() {
    for (word, directive) in
        [("[", false), ("\"", false), ("]", false), ("x ", false), ("A [ ", false), ("[", true), ("\"", true)]
    {
        let text = if directive { format!("A {}", word.repeat(500_000)) } else { word.repeat(1_000_000 / word.len()) };
        load("WorldBegin");
        let (mut found, mut formatted) = (Vec::new(), Ok(String::new()));
        let most = allocation_counter::measure(|| {
            found = load(&text);
            formatted = lang::format(&text, 0);
        });
        assert!(most.bytes_max < 64 << 20, "{word}: {} bytes for {}", most.bytes_max, text.len());
        assert!((1..=1002).contains(&errors(&found)) && formatted.err().is_none_or(|e| errors(&e) <= 1002), "{word}");
    }
    let negative = HEAD.to_owned() + &many(100_000, |_| "Shape \"sphere\" \"float radius\" -1".into());
    let unknown = HEAD.to_owned() + &many(100_000, |i| format!("Sphere{i}"));
    for text in [negative, unknown] {
        let found = load(&text);
        assert!(errors(&found) <= 1002 && found.iter().any(|d| d.code == "too-many-errors"), "{}", found.len());
    }
    // What a directive does not know is named in part and counted.
    let found = load(&format!("{HEAD}Shape \"sphere\" {}", many(100_000, |i| format!("\"float p{i}\" 1"))));
    assert_eq!(errors(&found), 21);
    assert_eq!(found[20].message, "99980 more unknown parameters");
    let found = load(&format!("{HEAD}Shape \"sphere\" {}", "\"float radius\" 1 ".repeat(100_000)));
    assert_eq!(errors(&found), 21);
}

#[test]
fn parameters_that_are_stated_between_directives_share_their_room() {
    let text = HEAD.to_owned() + &many(5_000, |i| format!("Attribute \"shape\" \"float a{i}\" {i} Shape \"sphere\""));
    load("WorldBegin");
    let most = allocation_counter::measure(|| assert_eq!(errors(&load(&text)), 0));
    assert!(most.bytes_max < 64 << 20, "{} bytes for {}", most.bytes_max, text.len());
}

#[test]
fn a_very_large_number_of_a_thing_takes_no_more_than_its_share_of_time() {
    const N: usize = 50_000;
    let sphere = "Shape \"sphere\"";
    let texture = |i| format!("Texture \"t{i}\" \"spectrum\" \"constant\"");
    let object = |i| format!("ObjectBegin \"o{i}\" ObjectEnd");
    let lists = [
        // Names that are there, and names that are not.
        many(N, |i| format!("{} Material \"diffuse\" \"texture reflectance\" \"t{i}\" {sphere}", texture(i))),
        many(N, texture) + &many(N, |i| format!("Material \"diffuse\" \"texture reflectance\" \"u{i}\" {sphere}")),
        many(N, |i| format!("MakeNamedMaterial \"m{i}\" \"string type\" \"diffuse\" NamedMaterial \"mm{i}\" {sphere}")),
        many(N, object) + &many(N, |i| format!("ObjectInstance \"oo{i}\"")),
        many(N, |i| format!("CoordinateSystem \"c{i}\"")) + &many(N, |i| format!("CoordSysTransform \"cc{i}\"")),
        many(N, |i| format!("Attribute \"shape\" \"float a{i}\" 1 {sphere}")),
        // Parameters of one directive, all of one line.
        format!("{sphere} {}", many(2 * N, |i| format!("\"float p{i}\" 1")).replace('\n', " ")),
        format!("{sphere} {}", "\"float radius\" 1 ".repeat(2 * N)),
    ];
    for list in lists {
        let text = HEAD.to_owned() + &list;
        for command in [&["check", "--json"][..], &["format"]] {
            let (code, err) = run(&text, command);
            assert!(code == 0 || code == 1, "{code} {err}");
        }
    }
    let options = format!("Option {}\n{HEAD}", many(2 * N, |i| format!("\"integer o{i}\" 1")));
    let cameras = many(N, |i| format!("Camera \"perspective\" \"string name\" \"c{i}\"")) + HEAD;
    assert_eq!(run(&options, &["check"]).0, 1);
    assert_eq!(run(&cameras, &["check"]).0, 0);
}
