//! The program as a person runs it: exit codes, files, messages.

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
fn check_speaks_json() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    write(dir.path(), "inner.bhs", "Material \"diffuse\"\nShape \"spheer\"\n");
    write(dir.path(), "scene.bhs", "WorldBegin\nInclude \"inner.bhs\"\nTexture\nMaterial \"diffuse\" \"rgb reflectance\" [1 2\n");
    let (code, out, err) = run(dir.path(), &["check", "--json", "scene.bhs"]);
    assert_eq!((code, err.as_str()), (1, ""));
    let found: Vec<serde_json::Value> = out.lines().map(|l| serde_json::from_str(l).expect("an object a line")).collect();
    let shape = found.iter().find(|d| d["code"] == "unknown-plugin").expect("the shape is unknown");
    assert_eq!(shape["severity"], "error");
    assert_eq!(shape["file"], "inner.bhs");
    assert_eq!((&shape["line"], &shape["column"]), (&2.into(), &7.into()));
    assert_eq!(shape["end"], serde_json::json!({ "line": 2, "column": 15 }));
    assert_eq!(shape["help"], "did you mean `sphere`?");
    assert_eq!((&shape["included_from"][0]["line"], &shape["included_from"][0]["column"]), (&2.into(), &9.into()));
    assert!(found.iter().any(|d| d["code"] == "unclosed-list" && d["label"] == "opened here"));

    write(dir.path(), "scene.bhs", "WorldBegin\n");
    let (code, out, _) = run(dir.path(), &["check", "--json", "scene.bhs"]);
    assert_eq!(code, 0);
    let warning: serde_json::Value = serde_json::from_str(out.trim_end()).expect("one object");
    assert_eq!((&warning["severity"], &warning["code"]), (&"warning".into(), &"no-light".into()));
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
fn format_prints_or_writes_or_leaves_alone() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    write(dir.path(), "scene.bhs", "WorldBegin   # so\nShape    \"sphere\"");
    let neat = "WorldBegin  # so\nShape \"sphere\"\n";
    let read = || std::fs::read_to_string(dir.path().join("scene.bhs")).expect("readable");
    assert_eq!(run(dir.path(), &["format", "scene.bhs"]), (0, neat.to_owned(), String::new()));
    assert_ne!(read(), neat);
    assert_eq!(run(dir.path(), &["format", "--write", "scene.bhs"]), (0, String::new(), String::new()));
    assert_eq!(read(), neat);
    write(dir.path(), "scene.bhs", "WorldBegin [");
    let (code, out, err) = run(dir.path(), &["format", "--write", "scene.bhs"]);
    assert!(code == 1 && out.is_empty() && err.contains("never closed"), "{err}");
    assert_eq!((read().as_str(), files(dir.path()).len()), ("WorldBegin [", 0));
    assert_eq!(run(dir.path(), &["format", "--write", "-"]).0, 2);
    let piped = bhs().args(["format", "-"]).write_stdin("WorldBegin").output().expect("bhs starts");
    assert_eq!(piped.stdout, b"WorldBegin\n");
}

#[test]
fn plugins_speak_json() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let (code, out, _) = run(dir.path(), &["plugins", "--json"]);
    let all: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    assert!(code == 0 && all.as_array().is_some_and(|a| a.len() > 20));
    let (_, out, _) = run(dir.path(), &["plugins", "shape", "sphere", "--json"]);
    let sphere: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    let radius = &sphere[0]["parameters"][0];
    assert_eq!((&sphere[0]["kind"], &sphere[0]["name"]), (&"shape".into(), &"sphere".into()));
    assert_eq!((&radius["name"], &radius["type"], &radius["default"]), (&"radius".into(), &"float".into(), &"1".into()));
    assert_eq!(run(dir.path(), &["plugins", "shape", "spheer", "--json"]).0, 2);
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
fn trace_answers_in_order_with_17_digits() {
    let dir = folder("BlackHole \"schwarzschild\" \"float rs\" 0.1\nTranslate 0 0 3\nShape \"sphere\"");
    write(
        dir.path(),
        "scene.bhs",
        format!(
            "LookAt 0 0 -5 0 0 0 0 1 0 {SMALL}BlackHole \"schwarzschild\" \"float rs\" 0.1\nTranslate 0 0 3\nShape \"sphere\""
        ),
    );
    let rays = "# a comment\n0,1,-5, 0,0,2\n0,0,-5,0,0,1\n\n0,0,-5,0,0,-1\n";
    write(dir.path(), "rays.csv", rays);
    let (code, out, err) = run(dir.path(), &["trace", "scene.bhs", "--rays", "rays.csv", "--path"]);
    assert_eq!(code, 0, "{err}");
    let answers: Vec<serde_json::Value> = out.lines().map(|l| serde_json::from_str(l).expect("JSON")).collect();
    let outcomes: Vec<_> = answers.iter().map(|a| a["outcome"].as_str().expect("a word")).collect();
    assert_eq!(outcomes, ["hit", "captured", "escaped"]);
    let hit = &answers[0];
    let coordinate = |name: &str, i: usize| hit[name][i].as_f64().expect("a number");
    // On the sphere, bent towards the hole.
    let r2: f64 = (0..3).map(|i| (coordinate("point", i) - if i == 2 { 3.0 } else { 0.0 }).powi(2)).sum();
    assert!((r2 - 1.0).abs() < 1e-9 && coordinate("direction", 1) < -0.1, "{hit}");
    assert_eq!(hit["shape"], 0);
    assert!(hit["path"].as_array().is_some_and(|p| p.len() > 3));
    assert!(hit["phi"].as_f64().is_some_and(|p| p > 1.0));
    assert!(out.lines().next().is_some_and(|l| l.contains("\"phi\":2.") && l.contains("e0")), "{out}");
    // From standard input, and with a straight integrator.
    let run =
        |args: &[&str], input: &str| bhs().current_dir(dir.path()).args(args).write_stdin(input).output().expect("bhs starts");
    let straight = run(&["trace", "scene.bhs", "--rays", "-", "--integrator", "straight"], "0,0,-5,0,0,1\n");
    assert!(String::from_utf8_lossy(&straight.stdout).contains("\"hit\""));
    for (bad, word) in [("0,0,0,0,0,0", "direction"), ("1,2,3", "6 numbers"), ("a,0,0,0,0,1", "`a`"), ("inf,0,0,0,0,1", "finite")]
    {
        let out = run(&["trace", "scene.bhs", "--rays", "-"], &format!("0,0,-5,0,0,1\n{bad}\n"));
        let err = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!(out.status.code(), Some(1), "{bad}");
        assert!(err.contains("line 2") && err.contains(word), "{bad}: {err}");
    }
}

#[test]
fn compare_measures_pictures() {
    let dir = folder(LIT);
    assert_eq!(run(dir.path(), &["render", "scene.bhs", "--quiet", "-o", "a.exr"]).0, 0);
    assert_eq!(run(dir.path(), &["render", "scene.bhs", "--quiet", "--seed", "9", "-o", "b.exr"]).0, 0);
    let json = |a: &str, b: &str| -> serde_json::Value {
        let (code, out, err) = run(dir.path(), &["compare", a, b, "--json"]);
        assert_eq!(code, 0, "{err}");
        serde_json::from_str(&out).expect("JSON")
    };
    assert_eq!(json("a.exr", "a.exr")["mse"], 0.0);
    assert!(json("a.exr", "b.exr")["mse"].as_f64().is_some_and(|m| m > 0.0));
    assert!(run(dir.path(), &["compare", "a.exr", "b.exr"]).1.contains("PSNR"));
    assert_eq!(run(dir.path(), &["compare", "a.exr", "none.exr"]).0, 1);
    assert_eq!(run(dir.path(), &["compare", "a.exr", "scene.bhs"]).0, 1);
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
fn plugins_are_listed_with_their_parameters() {
    let dir = folder(LIT);
    let (code, out, _) = run(dir.path(), &["plugins"]);
    assert_eq!(code, 0);
    for name in ["straight", "schwarzschild-rk4", "hemisphere", "path", "conductor", "plymesh", "embree", "reference", "sobol"] {
        assert!(out.contains(name), "{name} is missing:\n{out}");
    }
    let (code, out, _) = run(dir.path(), &["plugins", "integrator", "schwarzschild-rk4"]);
    assert_eq!(code, 0);
    for word in ["step", "float", "0.1", "rad"] {
        assert!(out.contains(word), "{word} is missing:\n{out}");
    }
    assert_eq!(run(dir.path(), &["plugins", "integrator", "cheese"]).0, 2);
}

#[test]
fn check_builds_without_rendering() {
    let dir = folder(LIT);
    assert_eq!(run(dir.path(), &["check", "scene.bhs"]).0, 0);
    assert!(!dir.path().join("small.exr").exists());
    write(dir.path(), "scene.bhs", format!("{SMALL}Shape \"sphere\" \"float radios\" 1\nShpe \"sphere\""));
    let (code, _, err) = run(dir.path(), &["check", "scene.bhs"]);
    assert_eq!(code, 1);
    // Both faults at once, each with a suggestion.
    assert!(err.contains("`radius`") && err.contains("`Shape`"), "{err}");
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
    ];
    for name in names {
        assert!(readme.contains(name) && common::root().join(format!("docs/{name}.png")).exists(), "{name}");
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

#[test]
fn connected_points_are_where_their_rays_lead() {
    // A wall at z = 3 behind a hole, and a screen that hides one half of it from below.
    let dir = folder("");
    write(
        dir.path(),
        "scene.bhs",
        format!(
            "LookAt 0 0 -5 0 0 0 0 1 0 {SMALL}BlackHole \"schwarzschild\" \"float rs\" 0.1\n\
            Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-9 -9 3  9 -9 3  9 9 3  -9 9 3]\n\
            Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-9 -9 2  9 -9 2  9 0.3 2  -9 0.3 2]"
        ),
    );
    let run =
        |args: &[&str], input: &str| bhs().current_dir(dir.path()).args(args).write_stdin(input).output().expect("bhs starts");
    let lines = |output: std::process::Output| -> Vec<serde_json::Value> {
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).lines().map(|l| serde_json::from_str(l).expect("JSON")).collect()
    };
    let vector = |v: &serde_json::Value| -> Vec<f64> {
        v.as_array().expect("a vector").iter().map(|x| x.as_f64().expect("a number")).collect()
    };

    let pairs = "# from the camera to the wall\n0.1,0.2,-5,0.3,0.4,3\n0,0,-5,0,-2,3\n";
    let answers = lines(run(&["trace", "scene.bhs", "--connect", "-"], pairs));
    assert_eq!(answers.len(), 2);
    let images = answers[0]["connections"].as_array().expect("a list");
    assert_eq!(images.len(), 2);
    for (image, c) in images.iter().enumerate() {
        assert_eq!((c["image"].as_u64(), c["blocked"].as_bool()), (Some(image as u64), Some(image == 1)), "{c}");
        let d = vector(&c["launch"]);
        // The light that goes round below does not: followed back from the wall, it ends at the screen.
        let back = vector(&c["arrival"]);
        let ray = if image == 0 {
            format!("0.1,0.2,-5,{},{},{}\n", d[0], d[1], d[2])
        } else {
            format!("0.3,0.4,2.9999,{},{},{}\n", -back[0], -back[1], -back[2])
        };
        let hit = &lines(run(&["trace", "scene.bhs", "--rays", "-", "--integrator", "schwarzschild-exact"], &ray))[0];
        let point = vector(&hit["point"]);
        if image == 0 {
            assert!((point[0] - 0.3).hypot(point[1] - 0.4) < 1e-9 && (point[2] - 3.0).abs() < 1e-9, "{hit}");
        } else {
            assert!((point[2] - 2.0).abs() < 1e-9 && point[1] < 0.3, "stopped by the screen: {hit}");
        }
    }
    // Behind the screen.
    assert_eq!(answers[1]["connections"][0]["blocked"], true);

    for (bad, word) in [("1,2,3,1,2,3", "the same"), ("1,2", "6 numbers")] {
        let out = run(&["trace", "scene.bhs", "--connect", "-"], bad);
        assert_eq!(out.status.code(), Some(1));
        assert!(String::from_utf8_lossy(&out.stderr).contains(word), "{}", String::from_utf8_lossy(&out.stderr));
    }
    assert_eq!(run(&["trace", "scene.bhs"], "").status.code(), Some(2));
    assert_eq!(run(&["trace", "scene.bhs", "--rays", "-", "--connect", "-"], "").status.code(), Some(2));
}

#[test]
fn bench_measures_integrators_and_transports() {
    let dir = folder("");
    let hole = "BlackHole \"schwarzschild\" \"float rs\" 0.1";
    let lamp = "AreaLightSource \"diffuse\" \"bool twosided\" true\nTranslate 0 1 3\nShape \"sphere\"";
    write(
        dir.path(),
        "scene.bhs",
        format!("LookAt 0 0 -5 0 0 0 0 1 0 {SMALL}{hole}\nShape \"sphere\" \"float radius\" 0.5\n{lamp}"),
    );
    let small = ["--rays", "200", "--rounds", "1", "--resolution", "6x4"];
    let (code, out, err) = run(dir.path(), &[&["bench", "scene.bhs", "--json", "-o", "out"], &small[..]].concat());
    assert_eq!(code, 0, "{err}");
    let measured: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    let rows = |name: &str| measured["tables"][name].as_array().map(Vec::len);
    assert_eq!((rows("camera_rays"), rows("transports")), (Some(30), Some(12)), "{out}");
    let camera = measured["tables"]["camera_rays"].as_array().expect("rows");
    let error = |integrator: &str, setting: &str| {
        let row = camera.iter().find(|r| r["integrator"] == integrator && r["setting"] == setting);
        row.and_then(|r| r["p99"].as_f64()).unwrap_or_else(|| panic!("{integrator} {setting}: {camera:?}"))
    };
    assert!(error("rk4", "0.2 rad") > 10.0 * error("rk4", "0.05 rad"));
    assert!(error("exact", "1e-4 diagonal") < 1e-12);
    // The method of the paper is of second order, ours of fourth.
    assert!(error("micro-steps (paper)", "0.05 rad") > 10.0 * error("rk4", "0.05 rad"));
    let equal = measured["tables"]["camera_rays_at_equal_error"].as_array().expect("rows");
    assert!(equal.len() == 3 && equal.iter().all(|row| row["micro-steps (paper) / adaptive"].as_f64() > Some(0.0)), "{out}");
    for file in [
        "camera_rays.csv",
        "camera_rays_at_equal_error.csv",
        "camera_rays.svg",
        "bounce_rays.csv",
        "transports.csv",
        "transports.svg",
    ] {
        assert!(dir.path().join("out").join(file).exists(), "{file}");
    }
    let (code, _, err) = run(dir.path(), &["bench", "-"]);
    assert_eq!((code, err.contains("needs a file")), (2, true), "{err}");
}
