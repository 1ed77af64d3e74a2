//! Whatever is written destroys nothing: neither what the scene reads, nor what else is written, nor what it replaces by half.

use crate::common::program::{Folder, SMALL};

/// A scene that reads a file of every kind: an include, a texture, two skies, a mesh and a spectrum.
const READER: &str = r#"
Film "rgb" "integer xresolution" 8 "integer yresolution" 8 "string filename" "out.exr"
Sampler "sobol" "integer pixelsamples" 1
Camera "perspective"
WorldBegin
Include "in/part.bhs"
LightSource "infinite" "string filename" "in/sky.exr"
Texture "wood" "spectrum" "imagemap" "string filename" "in/../in/wood.png"
Material "diffuse" "texture reflectance" "wood"
Translate 0 0 3
Shape "plymesh" "string filename" "in/mesh.ply"
AreaLightSource "diffuse" "spectrum L" "in/lamp.spd"
Shape "sphere"
"#;

const MESH: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    property float u\nproperty float v\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n";

/// What [`READER`] reads, with the names by which it does.
const INPUTS: [(&str, &str); 6] = [
    ("scene.bhs", "scene.bhs"),
    ("in/part.bhs", "in/part.bhs"),
    ("in/sky.exr", "in/sky.exr"),
    ("in/wood.png", "in/../in/wood.png"),
    ("in/mesh.ply", "in/mesh.ply"),
    ("in/lamp.spd", "in/lamp.spd"),
];

fn reader() -> Folder {
    let folder = Folder::new(READER);
    folder.write("in/part.bhs", "Rotate 1 0 0 1\n");
    folder.write("in/mesh.ply", MESH);
    folder.write("in/lamp.spd", "400 1\n700 1\n");
    let picture = image::RgbImage::from_pixel(4, 2, image::Rgb([200, 100, 50]));
    picture.save(folder.at("in/wood.png")).expect("writable");
    folder.write("sky.bhs", SMALL.replace("\"integer xresolution\" 8", "\"integer xresolution\" 16"));
    let made = folder.run(&["render", "sky.bhs", "--quiet", "-o", "in/sky.exr"]);
    assert_eq!(made.code, 0, "{}", made.err);
    for made in ["sky.bhs", "in/sky.png"] {
        std::fs::remove_file(folder.at(made)).expect("it is there");
    }
    folder
}

/// Makes sure that a command is refused, says these words, and changes nothing.
fn refused(folder: &Folder, args: &[&str], words: &[&str]) {
    let before = folder.contents();
    let run = folder.run(args);
    assert_eq!(run.code, 1, "{args:?}: {}", run.err);
    for word in words {
        assert!(run.err.contains(word) || run.out.contains(word), "{args:?} does not say {word}: {}{}", run.err, run.out);
    }
    assert!(folder.contents() == before, "{args:?} changed files: {:?}", folder.files());
}

#[test]
fn nothing_that_a_scene_reads_is_overwritten() {
    let folder = reader();
    let read = folder.run(&["render", "scene.bhs", "--quiet", "-o", "fine.exr"]);
    assert_eq!((read.code, read.err.as_str()), (0, ""));
    for (file, named) in INPUTS {
        std::fs::hard_link(folder.at(file), folder.at("hard")).expect("hard links");
        #[cfg(unix)]
        std::os::unix::fs::symlink(file, folder.at("soft")).expect("links");
        for other in [file, &format!("in/.././{file}"), "hard", "soft"] {
            refused(&folder, &["render", "scene.bhs", "--stats", other], &[&format!("`{other}`"), &format!("`{named}`")]);
        }
        std::fs::remove_file(folder.at("hard")).expect("it is there");
        std::fs::remove_file(folder.at("soft")).expect("it is there");
    }
    // As the picture itself, as the PNG beside it, and as that of a layer.
    refused(&folder, &["render", "scene.bhs", "-o", "./in/sky.exr"], &["`./in/sky.exr`", "`in/sky.exr`"]);
    refused(&folder, &["render", "scene.bhs", "-o", "in/wood.exr"], &["`in/wood.png`", "`in/../in/wood.png`"]);
    std::fs::hard_link(folder.at("in/wood.png"), folder.at("x.normal.png")).expect("hard links");
    refused(&folder, &["render", "scene.bhs", "-o", "x.exr", "--aov", "normal", "--false-color"], &["`x.normal.png`"]);
}

#[test]
fn a_scene_that_names_its_own_texture_is_refused_by_check_too() {
    let folder = reader();
    folder.write("scene.bhs", READER.replace("\"out.exr\"", "\"in/wood.exr\""));
    refused(&folder, &["render", "scene.bhs"], &["`in/wood.png`", "`in/../in/wood.png`"]);
    refused(&folder, &["check", "scene.bhs"], &["`in/wood.png`", "`in/../in/wood.png`"]);
    let json = folder.run(&["check", "scene.bhs", "--json"]);
    let found: serde_json::Value = serde_json::from_str(json.out.trim_end()).expect("one object");
    assert_eq!((json.code, &found["code"], &found["line"]), (1, &"output-is-input".into(), &2.into()), "{}", json.out);
    assert_eq!((&found["labels"][0]["line"], &found["labels"][0]["message"]), (&8.into(), &"read here".into()));
    assert_eq!(folder.run(&["render", "scene.bhs", "--quiet", "-o", "out.exr"]).code, 0);
}

#[test]
fn bench_overwrites_nothing_either() {
    let folder = Folder::new(&SMALL.replace("WorldBegin", "WorldBegin\nInclude \"out/camera_rays.csv\""));
    folder.write("out/camera_rays.csv", "# a part of the scene\n");
    refused(&folder, &["bench", "scene.bhs", "-o", "out"], &["`out/camera_rays.csv`", "scene reads"]);
}

/// Cameras whose pictures are `room.exr` and `room.left.exr`.
const CAMERAS: &str = r#"
Film "rgb" "integer xresolution" 8 "integer yresolution" 8 "string filename" "room.exr"
Sampler "sobol" "integer pixelsamples" 1
Camera "perspective"
Camera "perspective" "string name" "left"
WorldBegin
LightSource "infinite"
"#;

#[test]
fn outputs_that_are_one_file_are_refused() {
    let folder = Folder::new(CAMERAS);
    refused(&folder, &["render", "scene.bhs", "--camera", "left", "--stats", "room.left.png"], &["room.left.png", "one file"]);
    refused(&folder, &["render", "scene.bhs", "-o", "x.exr", "--stats", "././x.png"], &["`x.png`", "`././x.png`"]);
    refused(&folder, &["render", "scene.bhs", "-o", "x.exr", "--stats", "x.exr"], &["`x.exr`", "one file"]);
    // A camera's own file, and the stats of one camera as the picture of another.
    refused(&folder, &["render", "scene.bhs", "--stats", "room.exr"], &["`room.exr`", "one file"]);
}

#[test]
fn a_checkpoint_takes_the_place_of_nothing_else() {
    let folder = Folder::new(&SMALL.replace("WorldBegin", "WorldBegin\nInclude \"small.checkpoint\""));
    folder.write("small.checkpoint", "# a part of the scene\n");
    let words = ["`small.checkpoint`", "scene reads"];
    for flag in ["--checkpoint", "--resume"] {
        refused(&folder, &["render", "scene.bhs", flag], &words);
    }
    // The one before it is kept too.
    folder.write("small.previous.checkpoint", "# a part of the scene\n");
    folder.write("scene.bhs", SMALL.replace("WorldBegin", "WorldBegin\nInclude \"small.previous.checkpoint\""));
    refused(&folder, &["render", "scene.bhs", "--checkpoint"], &["`small.previous.checkpoint`", "scene reads"]);
    folder.write("scene.bhs", SMALL);
    for other in ["scene.bhs", "./small.exr", "./small.png", "s.json"] {
        let checkpoint = format!("--checkpoint={other}");
        refused(&folder, &["render", "scene.bhs", "--stats", "s.json", &checkpoint], &[&format!("`{other}`")]);
    }
    // It is there for being replaced, with the flag that replaces nothing too.
    for name in ["one.exr", "two.exr"] {
        let args = ["render", "scene.bhs", "--quiet", "--no-overwrite", "--checkpoint=c", "-o", name];
        assert_eq!(folder.run(&args).code, 0, "{name}");
    }
}

#[test]
fn pictures_written_on_the_way_are_no_others() {
    let folder = Folder::new(SMALL);
    let partial = ["--spp", "200000", "--checkpoint-every", "0.1", "--write-partial", "--no-overwrite"];
    let run = folder.run(&[&["render", "scene.bhs", "--quiet"], &partial[..]].concat());
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    assert_eq!(folder.files(), ["scene.bhs", "small.exr", "small.png"]);
}

#[test]
#[cfg(unix)]
fn outputs_that_are_one_file_by_links_are_refused() {
    let folder = Folder::new(SMALL);
    std::fs::create_dir(folder.at("real")).expect("writable");
    std::os::unix::fs::symlink("real", folder.at("link")).expect("links");
    std::os::unix::fs::symlink("small.png", folder.at("dangling.json")).expect("links");
    for (output, stats) in [("real/x.exr", "link/x.png"), ("link/x.exr", "real/x.exr"), ("small.exr", "dangling.json")] {
        refused(&folder, &["render", "scene.bhs", "-o", output, "--stats", stats], &[stats, "one file"]);
    }
}

#[test]
fn pictures_have_the_names_that_they_should() {
    let names = |scene: &str, args: &[&str]| {
        let folder = Folder::new("");
        std::fs::rename(folder.at("scene.bhs"), folder.at("my.scene.bhs")).expect("it is there");
        folder.write("my.scene.bhs", scene);
        let run = folder.run(&[&["render", "my.scene.bhs", "--quiet"], args].concat());
        assert_eq!(run.code, 0, "{}", run.err);
        let mut files = folder.files();
        files.retain(|f| f != "my.scene.bhs");
        files.join(" ")
    };
    let unnamed = SMALL.replace("\"string filename\" \"small.exr\"", "");
    assert_eq!(names(SMALL, &[]), "small.exr small.png");
    assert_eq!(names(SMALL, &["--quick"]), "small.quick.exr small.quick.png");
    assert_eq!(names(SMALL, &["--quick", "-o", "x.exr", "--stats", "x.json"]), "x.exr x.json x.png");
    assert_eq!(names(&unnamed, &[]), "my.scene.exr my.scene.png");
    assert_eq!(names(&unnamed, &["--quick"]), "my.scene.quick.exr my.scene.quick.png");
    assert_eq!(
        names(SMALL, &["--quick", "--aov", "normal", "--false-color"]),
        "small.quick.exr small.quick.normal.png small.quick.png"
    );
    assert_eq!(names(CAMERAS, &["--quick"]), "room.left.quick.exr room.left.quick.png room.quick.exr room.quick.png");

    // In the current folder, whatever folder the scene is in; standard input has no name.
    let folder = Folder::new(&unnamed);
    std::fs::create_dir(folder.at("sub")).expect("writable");
    std::fs::rename(folder.at("scene.bhs"), folder.at("sub/scene.bhs")).expect("writable");
    assert_eq!(folder.run(&["render", "sub/scene.bhs", "--quiet"]).code, 0);
    assert_eq!(folder.shell("\"$BHS\" render - --quiet < sub/scene.bhs && \"$BHS\" render - --quick < sub/scene.bhs").code, 0);
    let all = ["bhs.exr", "bhs.png", "bhs.quick.exr", "bhs.quick.png", "scene.exr", "scene.png", "sub/scene.bhs"];
    assert_eq!(folder.files(), all);
}

#[test]
fn no_overwrite_overwrites_nothing() {
    let folder = Folder::new(SMALL);
    let all = ["render", "scene.bhs", "--no-overwrite", "--stats", "s.json", "--aov", "normal", "--false-color"];
    for there in ["small.exr", "small.png", "s.json", "small.normal.png"] {
        folder.write(there, "old");
        refused(&folder, &all, &[&format!("`{there}`"), "--no-overwrite"]);
        std::fs::remove_file(folder.at(there)).expect("it is there");
    }
    let first = folder.run(&all);
    assert_eq!(first.code, 0, "{}", first.err);
    refused(&folder, &all, &["small.exr", "small.png", "s.json", "small.normal.png"]);
    assert_eq!(folder.run(&["render", "scene.bhs"]).code, 0);
}

#[test]
fn check_finds_what_render_would_refuse() {
    let folder = Folder::new("");
    folder.write("taken.exr/x", "");
    folder.write("readonly.png", "old");
    let mut permissions = std::fs::metadata(folder.at("readonly.png")).expect("it is there").permissions();
    permissions.set_readonly(true);
    std::fs::set_permissions(folder.at("readonly.png"), permissions).expect("its mode can be set");
    for (name, word) in [
        ("picture.jpg", ".exr"),
        ("picture", ".exr"),
        ("nowhere/x.exr", "no folder `nowhere`"),
        ("scene.bhs/x.exr", "no folder"),
        ("taken.exr", "directory"),
        ("readonly.exr", "read-only"),
        ("..", ".exr"),
    ] {
        folder.write("scene.bhs", SMALL.replace("small.exr", name));
        for command in ["check", "render"] {
            refused(&folder, &[command, "scene.bhs"], &[word, "scene.bhs:2:"]);
        }
        let json = folder.run(&["check", "--json", "scene.bhs"]);
        assert!(json.code == 1 && json.out.contains("\"line\":2"), "{}", json.out);
    }
    folder.write("scene.bhs", SMALL);
    let fine = folder.run(&["check", "scene.bhs"]);
    assert_eq!((fine.code, fine.err.as_str()), (0, "scene.bhs: no errors\n"));
    assert!(!folder.at("small.exr").exists());
}

#[test]
#[cfg(unix)]
fn devices_and_pipes_are_no_outputs() {
    let folder = Folder::new(SMALL);
    assert_eq!(folder.shell("mkfifo pipe.json").code, 0);
    for (stats, what) in [("/dev/null", "device"), ("pipe.json", "pipe"), ("/dev/full", "device")] {
        let run = folder.run(&["render", "scene.bhs", "--stats", stats]);
        assert!(run.code == 1 && run.err.contains(what) && run.err.contains(stats), "{}", run.err);
    }
    assert_eq!(folder.files(), ["pipe.json", "scene.bhs"]);
}
