//! The program as a person runs it: exit codes, files, messages.

mod tools;

use crate::common;
use assert_cmd::Command;
use std::path::Path;
use std::time::{Duration, Instant};
use tempfile::TempDir;

fn bhs() -> Command {
    Command::new(assert_cmd::cargo::cargo_bin!("bhs"))
}

/// Options of a small quick picture.
const SMALL: &str = r#"
    Film "rgb" "integer xresolution" 8 "integer yresolution" 8 "string filename" "small.exr"
    Sampler "sobol" "integer pixelsamples" 2
    Camera "perspective"
    WorldBegin
"#;

/// A folder with a scene `scene.bhs` of the options above and `world`.
fn folder(world: &str) -> TempDir {
    let dir = tempfile::tempdir().expect("a temporary folder");
    write(dir.path(), "scene.bhs", format!("{SMALL}{world}"));
    dir
}

fn write(dir: &Path, name: &str, content: impl AsRef<[u8]>) {
    std::fs::write(dir.join(name), content).expect("the temporary folder can be written");
}

/// Runs `bhs` in `dir` and returns exit code, standard output and standard error.
fn run(dir: &Path, args: &[&str]) -> (i32, String, String) {
    let out = bhs().current_dir(dir).args(args).output().expect("bhs starts");
    let text = |b: &[u8]| String::from_utf8_lossy(b).into_owned();
    (out.status.code().unwrap_or(-1), text(&out.stdout), text(&out.stderr))
}

const LIT: &str = "LightSource \"infinite\" \"float L\" 1\nTranslate 0 0 3\nShape \"sphere\"";

#[test]
fn render_writes_an_exr_and_a_png_and_says_so() {
    let dir = folder(LIT);
    let (code, out, err) = run(dir.path(), &["render", "scene.bhs", "--stats", "stats.json"]);
    assert_eq!((code, out.as_str()), (0, ""), "{err}");
    assert!(err.contains("small.exr"), "{err}");
    let mut files: Vec<_> = std::fs::read_dir(dir.path())
        .expect("readable")
        .map(|e| e.expect("readable").file_name().into_string().expect("plain names"))
        .collect();
    files.sort();
    assert_eq!(files, ["scene.bhs", "small.exr", "small.png", "stats.json"]);
    let stats: serde_json::Value =
        serde_json::from_slice(&std::fs::read(dir.path().join("stats.json")).expect("readable")).expect("JSON");
    assert_eq!(stats["counts"]["paths"], 128);
    for clock in ["seconds", "processor_seconds"] {
        assert!(stats[clock]["render"].as_f64().is_some_and(|s| s > 0.0), "{stats}");
    }
    assert_eq!(stats["integrator"], "straight");
}

#[test]
fn quiet_is_quiet_and_o_names_the_file() {
    let dir = folder(LIT);
    assert_eq!(run(dir.path(), &["render", "scene.bhs", "--quiet", "-o", "other.exr"]), (0, String::new(), String::new()));
    assert!(dir.path().join("other.exr").exists() && dir.path().join("other.png").exists());
    assert!(!dir.path().join("small.exr").exists());
}

#[test]
fn standard_input_is_a_scene() {
    let dir = folder("");
    let text = format!("{SMALL}{LIT}");
    let out = bhs().current_dir(dir.path()).args(["render", "-", "--quiet"]).write_stdin(text).output().expect("bhs starts");
    assert_eq!(out.status.code(), Some(0), "{}", String::from_utf8_lossy(&out.stderr));
    assert!(dir.path().join("small.exr").exists());
}

const CAMERAS: &str = r#"
    Film "rgb" "integer xresolution" 8 "integer yresolution" 8 "string filename" "room.exr"
    Sampler "sobol" "integer pixelsamples" 1
    Camera "perspective"
    Camera "perspective" "string name" "left" "float fov" 20
    Translate 0 0 7
    Camera "perspective" "string name" "far away"
    WorldBegin
    LightSource "infinite"
    Translate 0 0 3
    Material "diffuse" "float reflectance" 0
    Shape "sphere"
"#;

fn files(dir: &Path) -> Vec<String> {
    let name = |e: std::io::Result<std::fs::DirEntry>| e.expect("readable").file_name().into_string().expect("plain names");
    let mut files: Vec<_> = std::fs::read_dir(dir).expect("readable").map(name).filter(|f| f != "scene.bhs").collect();
    files.sort();
    files
}

#[test]
fn every_camera_makes_a_picture() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    write(dir.path(), "scene.bhs", CAMERAS);
    let (code, _, err) = run(dir.path(), &["render", "scene.bhs", "--stats", "stats.json"]);
    assert_eq!(code, 0, "{err}");
    let names = ["room", "room.far away", "room.left"];
    let mut expected: Vec<String> = names.iter().flat_map(|n| [format!("{n}.exr"), format!("{n}.png")]).collect();
    expected.extend(["stats", "stats.far away", "stats.left"].map(|n| format!("{n}.json")));
    expected.sort();
    assert_eq!(files(dir.path()), expected);
    // The black sphere fills the narrow view, a part of the wide one, and little of the one from afar.
    let brightness = |name: &str| {
        let picture = bhs::image::Picture::read_exr(&dir.path().join(format!("{name}.exr"))).expect("a picture");
        picture.data.iter().sum::<f32>() / picture.data.len() as f32
    };
    let [near, far, left] = names.map(brightness);
    assert!(left < 0.05 && near > 0.5 && far > near && far < 1.01, "{left} {near} {far}");
    let stats = std::fs::read_to_string(dir.path().join("stats.left.json")).expect("readable");
    assert!(stats.contains("\"camera\": \"left\""), "{stats}");
}

#[test]
fn one_camera_can_be_chosen() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    write(dir.path(), "scene.bhs", CAMERAS);
    assert_eq!(run(dir.path(), &["render", "scene.bhs", "--quiet", "--camera", "left"]).0, 0);
    assert_eq!(files(dir.path()), ["room.left.exr", "room.left.png"]);
    assert_eq!(run(dir.path(), &["render", "scene.bhs", "--quiet", "--camera", "left", "-o", "x.exr"]).0, 0);
    let pictures =
        ["room.left.exr", "x.exr"].map(|f| bhs::image::Picture::read_exr(&dir.path().join(f)).expect("a picture").data);
    assert_eq!(pictures[0], pictures[1]);
    let (code, _, err) = run(dir.path(), &["render", "scene.bhs", "--camera", "lefd"]);
    assert_eq!(code, 1);
    assert!(err.contains("no camera `lefd`") && err.contains("did you mean `left`?"), "{err}");
}

#[test]
fn colours_are_as_asked_for() {
    let dir = folder("Shape \"spheer\"");
    let (_, _, auto) = run(dir.path(), &["check", "scene.bhs"]);
    let (_, _, never) = run(dir.path(), &["check", "scene.bhs", "--color", "never"]);
    let (_, _, always) = run(dir.path(), &["--color", "always", "check", "scene.bhs"]);
    assert!(auto == never && !never.contains('\x1b') && always.contains("\x1b["), "{always}");
    assert_eq!(run(dir.path(), &["check", "scene.bhs", "--color", "maybe"]).0, 2);
}

#[test]
fn the_command_line_itself_can_be_wrong() {
    let dir = folder(LIT);
    for args in [
        &["render"][..],
        &["frobnicate"],
        &["render", "scene.bhs", "--spp", "0"],
        &["render", "scene.bhs", "--crop", "0,1"],
        &["render", "scene.bhs", "--resolution", "0x5"],
        &["plugins", "cheese"],
        &["render", "scene.bhs", "--aov", "redshft"],
        &["render", "scene.bhs", "--false-color"],
        &["trace", "-", "--rays", "-"],
    ] {
        let (code, _, err) = run(dir.path(), args);
        assert_eq!(code, 2, "{args:?}: {err}");
        assert!(!err.is_empty(), "{args:?}");
    }
    assert_eq!(run(dir.path(), &["--help"]).0, 0);
    assert_eq!(run(dir.path(), &["--version"]).0, 0);
}

#[test]
fn faulty_files_are_errors_with_exit_code_1_and_harm_nothing() {
    let header = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                  element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    let dir = folder("Shape \"plymesh\" \"string filename\" \"mesh.ply\"");
    std::fs::create_dir(dir.path().join("folder.ply")).expect("writable");
    write(dir.path(), "small.exr", "precious");
    write(dir.path(), "small.png", "precious");
    let cases: [(&str, Option<String>, &str); 7] = [
        ("missing", None, "mesh.ply"),
        ("truncated", Some(format!("{header}0 0 0\n1 0 0\n")), "vert"),
        ("not a number", Some(format!("{header}0 0 0\n1 0 0\n0 nan 0\n3 0 1 2\n")), "vert"),
        ("index out of range", Some(format!("{header}0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n")), "3"),
        ("empty", Some(String::new()), "empty"),
        ("no PLY", Some("solid teapot\n".into()), "ply"),
        ("binary, truncated", Some(header.replace("ascii", "binary_little_endian") + "0123"), "vert"),
    ];
    for (name, content, word) in cases {
        let _ = std::fs::remove_file(dir.path().join("mesh.ply"));
        if let Some(content) = content {
            write(dir.path(), "mesh.ply", content);
        }
        let (code, _, err) = run(dir.path(), &["render", "scene.bhs"]);
        assert_eq!(code, 1, "{name}: {err}");
        assert!(err.contains("scene.bhs:") && err.contains("mesh.ply") && err.contains(word), "{name}: {err}");
    }
    write(dir.path(), "scene.bhs", format!("{SMALL}Shape \"plymesh\" \"string filename\" \"folder.ply\""));
    let (code, _, err) = run(dir.path(), &["render", "scene.bhs"]);
    assert!(code == 1 && err.contains("directory"), "{err}");
    for file in ["small.exr", "small.png"] {
        assert_eq!(std::fs::read_to_string(dir.path().join(file)).expect("still there"), "precious");
    }
    assert_eq!(run(dir.path(), &["render", "nothing.bhs"]).0, 1);
    assert_eq!(run(dir.path(), &["check", "nothing.bhs"]).0, 1);
}

#[test]
fn an_output_that_cannot_be_written_is_found_before_rendering() {
    let dir = folder(LIT);
    std::fs::create_dir(dir.path().join("taken.exr")).expect("writable");
    for (output, word) in [("nowhere/x.exr", "nowhere"), ("taken.exr", "directory"), ("picture.jpg", ".exr"), ("..", ".exr")] {
        let start = Instant::now();
        // Long enough that rendering first would be noticed.
        let (code, _, err) = run(dir.path(), &["render", "scene.bhs", "--spp", "100000000", "-o", output]);
        assert_eq!(code, 1, "{output}: {err}");
        assert!(err.contains(word), "{output}: {err}");
        assert!(start.elapsed() < Duration::from_secs(60), "{output}");
    }
}

#[test]
#[cfg(unix)]
fn an_interrupt_writes_what_is_there_and_exits_with_130() {
    let dir = folder(LIT);
    let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin!("bhs"))
        .current_dir(dir.path())
        .args(["render", "scene.bhs", "--spp", "1000000000", "--stats", "stats.json"])
        .stderr(std::process::Stdio::null())
        .spawn()
        .expect("bhs starts");
    std::thread::sleep(Duration::from_secs(2));
    let id = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &id]).status().expect("kill runs").success());
    assert_eq!(child.wait().expect("it ends").code(), Some(130));
    let picture = bhs::image::Picture::read_exr(&dir.path().join("small.exr")).expect("a whole picture");
    assert!(picture.data.iter().all(|v| *v > 0.0), "every pixel has light");
    let stats = std::fs::read_to_string(dir.path().join("stats.json")).expect("readable");
    assert!(stats.contains("\"interrupted\": true"), "{stats}");
}

#[test]
fn layers_become_channels_and_false_colour_pictures() {
    let dir = folder(
        "BlackHole \"schwarzschild\" \"point3 center\" [0 0 2] \"float rs\" 0.3\nLightSource \"infinite\"\nTranslate 2 0 3\nShape \"sphere\"",
    );
    let args = ["render", "scene.bhs", "--aov", "closestapproach", "--aov", "normal", "--false-color"];
    let (code, _, err) = run(dir.path(), &args);
    assert_eq!(code, 0, "{err}");
    assert!(err.contains("small.closestapproach.png shows closestapproach: ") && err.contains("scene units"), "{err}");
    let read = |name: &str| image::open(dir.path().join(name)).expect("a PNG").to_rgb8();
    let (distance, normal) = (read("small.closestapproach.png"), read("small.normal.png"));
    assert_eq!((distance.dimensions(), normal.dimensions()), ((8, 8), (8, 8)));
    // Yellow at the picture's rim, dark blue where rays fall in; the sky has no normal.
    let [r, g, b] = distance.get_pixel(0, 0).0;
    assert!(r > b && g > b, "{r} {g} {b}");
    let [r, g, b] = distance.get_pixel(4, 4).0;
    assert!(b > g && b > r, "{r} {g} {b}");
    assert_eq!(normal.get_pixel(0, 0).0, [0; 3]);
    assert!(normal.pixels().any(|p| p.0 != [0; 3]));

    let picture = bhs::image::Picture::read_exr(&dir.path().join("small.exr")).expect("readable");
    let mut channels = picture.channels.clone();
    channels.sort();
    assert_eq!(channels, ["B", "G", "N.X", "N.Y", "N.Z", "R", "closestapproach"]);
    // Other programs compare colours with colours, and so does `compare`.
    assert_eq!(run(dir.path(), &["render", "scene.bhs", "--quiet", "--aov", "normal", "-o", "plain.exr"]).0, 0);
    let (code, out, _) = run(dir.path(), &["compare", "small.exr", "plain.exr", "--json"]);
    let comparison: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    assert_eq!(
        (code, &comparison["channels"], &comparison["mse"]),
        (0, &serde_json::json!(["B", "G", "R"]), &serde_json::json!(0.0))
    );

    let (code, _, err) = run(dir.path(), &["render", "scene.bhs", "--aov", "redshft"]);
    assert!(code == 2 && err.contains("did you mean `redshift`") && err.contains("shadingnormal"), "{err}");
}

#[test]
fn the_scene_in_readme_has_no_errors() {
    let readme = common::read("README.md");
    let scenes: Vec<&str> = readme.split("```bhs\n").skip(1).filter_map(|part| part.split("```").next()).collect();
    assert!(!scenes.is_empty());
    for scene in scenes {
        assert!(common::build(scene).warnings.is_empty());
    }
}

#[test]
fn every_scene_that_readme_shows_has_no_errors() {
    let readme = common::read("README.md");
    let names = [
        "cornell_box",
        "spheres",
        "spheres_hole",
        "cornell_hole",
        "bunny_hole",
        "gold_dragon",
        "blueshift",
        "redshift_spheres",
        "redshift_wall",
        "frames_static",
        "frames_chart",
        "prism",
        "wormhole",
        "two_holes",
        "moving_camera",
        "shadow_stars",
        "kerr_disc",
        "kerr_room",
        "dragon_army",
        "terrace",
    ];
    for name in names {
        let pictures = ["png", "jpg"].map(|ending| format!("docs/{name}.{ending}"));
        assert!(pictures.iter().any(|p| readme.contains(&format!("({p})")) && common::root().join(p).exists()), "{name}");
        // `./test` fetches the meshes; plain `cargo test` may find none.
        let scene = format!("scenes/{name}.bhs");
        if common::read(&scene).contains("\"meshes/") && !common::root().join("scenes/meshes").exists() {
            eprintln!("skipped: {name} needs scenes/meshes");
            continue;
        }
        let (code, _, err) = run(common::root(), &["check", &scene]);
        assert!(code == 0 && err.lines().count() == 1, "{name}: {err}");
    }
}
