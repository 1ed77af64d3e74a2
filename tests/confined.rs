//! What may be read: regular files, whatever their names, and with `--root` those of a folder only.
#![cfg(unix)]

use crate::common::program::{Folder, SMALL};
use std::ffi::OsStr;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::symlink;
use std::process::Command;

/// Every way in which a scene names a file; `FILE` stands for it.
const NAMING: [&str; 10] = [
    "Include \"FILE\"",
    "LightSource \"infinite\" \"string filename\" \"FILE\"",
    "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"FILE\"\nMaterial \"diffuse\" \"texture reflectance\" \"t\"\nShape \"sphere\"",
    "Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"FILE\"\nMaterial \"conductor\" \"texture roughness\" \"t\"\nShape \"sphere\"",
    "Shape \"plymesh\" \"string filename\" \"FILE\"",
    "Shape \"objmesh\" \"string filename\" \"FILE\"",
    "Shape \"stlmesh\" \"string filename\" \"FILE\"",
    "Shape \"gltf\" \"string filename\" \"FILE\"",
    "Material \"diffuse\" \"spectrum reflectance\" \"FILE\"\nShape \"sphere\"",
    "LightSource \"point\" \"spectrum I\" \"FILE\"",
];

/// A scene that reads `file` in one of these ways, at line 10.
fn naming(way: &str, file: &str) -> String {
    format!("{SMALL}\n{}", way.replace("FILE", file))
}

#[test]
fn pipes_sockets_and_devices_are_refused_wherever_a_file_is_named() {
    let folder = Folder::new("");
    for ending in ["", ".spd", ".ply", ".obj", ".png"] {
        assert_eq!(folder.shell(&format!("mkfifo pipe{ending}")).code, 0);
        let _listener = std::os::unix::net::UnixListener::bind(folder.at(format!("socket{ending}"))).expect("a socket");
        symlink("/dev/zero", folder.at(format!("device{ending}"))).expect("links");
    }
    for way in NAMING {
        let ending = match way {
            _ if way.contains("spectrum reflectance") || way.contains("spectrum I") => ".spd",
            _ => "",
        };
        for what in ["pipe", "socket", "device"] {
            folder.write("scene.bhs", naming(way, &format!("{what}{ending}")));
            for command in ["check", "render"] {
                let run = folder.run(&[command, "scene.bhs"]);
                assert!(run.code == 1 && run.err.contains(&format!("it is a {what}")), "{way} {what}: {run:?}");
                assert!(run.err.contains("scene.bhs:10:"), "{way} {what}: {run:?}");
            }
        }
    }
    folder.write("scene.bhs", SMALL);
    let picture = folder.run(&["render", "scene.bhs", "--quiet"]);
    assert_eq!(picture.code, 0, "{picture:?}");
    for what in ["pipe", "socket", "device"] {
        let words = format!("it is a {what}");
        for args in [
            ["render", what, "", ""],
            ["check", what, "", ""],
            ["format", what, "", ""],
            ["bench", what, "", ""],
            ["trace", what, "--rays", "scene.bhs"],
            ["trace", "scene.bhs", "--rays", what],
            ["trace", "scene.bhs", "--connect", what],
            ["compare", "small.exr", what, ""],
            ["compare", what, "small.exr", ""],
        ] {
            let args: Vec<&str> = args.into_iter().filter(|a| !a.is_empty()).collect();
            let run = folder.run(&args);
            assert!(run.code == 1 && run.err.contains(&words) && run.err.contains(what), "{args:?}: {run:?}");
        }
    }
    // What a shell gives for the output of another program.
    for run in ["render pipe", "trace scene.bhs --rays pipe"] {
        let run = folder.shell(&format!("\"$BHS\" {run}"));
        assert!(run.err.contains("`-`") && run.err.contains("standard input"), "{run:?}");
    }
}

#[test]
fn names_need_not_be_text() {
    let folder = Folder::new(SMALL);
    let name = |ending: &[u8]| OsStr::from_bytes(&[b"sc\xff\xfene", ending].concat()).to_owned();
    let (scene, picture, dir) = (name(b".bhs"), name(b".exr"), OsStr::from_bytes(b"fol\xf0der"));
    let text = SMALL.replace("\"string filename\" \"small.exr\"", "") + "Include \"part.bhs\"";
    std::fs::create_dir(folder.at(dir)).expect("writable");
    std::fs::write(folder.at(dir).join(&scene), text).expect("writable");
    std::fs::write(folder.at(dir).join("part.bhs"), "Shape \"sphere\"").expect("writable");
    let path = std::path::Path::new(dir).join(&scene);
    let run = |args: &[&OsStr]| {
        let mut command: Command = folder.command(&[]);
        let output = command.args(args).output().expect("it starts");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    let word = OsStr::new;
    assert_eq!(run(&[word("render"), path.as_os_str(), word("--quiet")]), (Some(0), String::new()));
    assert!(folder.at(&picture).is_file() && folder.at(name(b".png")).is_file());
    assert_eq!(run(&[word("render"), path.as_os_str(), word("--quick"), word("--quiet")]).0, Some(0));
    assert!(folder.at(name(b".quick.exr")).is_file());
    for command in ["check", "format", "bench"] {
        let args = [word(command), path.as_os_str(), word("--rays"), word("100"), word("--rounds"), word("1")];
        let args = if command == "bench" { &args[..] } else { &args[..2] };
        assert_eq!(run(args).0, Some(0), "{command}");
    }
    assert_eq!(run(&[word("format"), word("--write"), path.as_os_str()]).0, Some(0));
    let output = name(b".two.exr");
    assert_eq!(run(&[word("render"), word("scene.bhs"), word("-o"), &output, word("--quiet")]).0, Some(0));
    assert!(folder.at(&output).is_file());
    assert_eq!(run(&[word("compare"), &output, &output]).0, Some(0));
    // An input by such a name is an input.
    let (code, err) = run(&[word("render"), word("scene.bhs"), word("--stats"), word("scene.bhs")]);
    assert!(code == Some(1) && err.contains("`scene.bhs`"), "{err}");
    let (code, err) = run(&[word("render"), path.as_os_str(), word("--stats"), path.as_os_str()]);
    assert!(code == Some(1) && err.contains("which is the scene"), "{err}");
}

#[test]
fn a_confined_scene_reads_nothing_outside() {
    let folder = Folder::new("");
    folder.write("secret", "WorldBegin # secret");
    folder.write("root/inside", "");
    symlink("../secret", folder.at("root/link")).expect("links");
    symlink("..", folder.at("root/up")).expect("links");
    let secret = folder.at("secret");
    for way in NAMING {
        for file in ["../secret", "../missing", "link", "up/secret", secret.to_str().expect("text"), "/etc/passwd", "/dev/zero"] {
            // Spectra are told from names of built-in ones by their ending.
            let spectrum = way.contains("spectrum reflectance") || way.contains("spectrum I");
            let file = if spectrum { format!("{file}.spd") } else { file.to_owned() };
            if spectrum && file.starts_with("link") {
                continue;
            }
            folder.write("root/scene.bhs", naming(way, &file));
            for args in [["--root", "root", "check", "root/scene.bhs"], ["render", "root/scene.bhs", "--root", "./root"]] {
                let run = folder.run(&args);
                assert!(run.code == 1 && run.err.contains("outside of"), "{way} {file}: {run:?}");
                assert!(run.err.contains("scene.bhs:10:") && !run.err.contains("did you mean"), "{way} {file}: {run:?}");
            }
        }
    }
    folder.write("root/scene.bhs", naming(NAMING[0], "up/root/inside"));
    assert_eq!(
        folder.run(&["--root", "root", "check", "root/scene.bhs"]).err.matches("outside").count(),
        1,
        "of the picture only"
    );
    // The scene itself, and what its folder has none of.
    for args in [
        &["render", "secret", "--root", "root"][..],
        &["check", "root/link", "--root", "root"],
        &["bench", "secret", "--root", "root"],
        &["trace", "secret", "--root", "root", "--rays", "-"],
        &["format", "root/link", "--root", "root", "--write"],
        &["trace", "root/fine.bhs", "--root", "root", "--rays", "root/link"],
        &["compare", "root/link", "root/link", "--root", "root"],
    ] {
        folder.write("root/fine.bhs", SMALL);
        let run = folder.run(args);
        assert!(run.code == 1 && run.err.contains("outside of `root`"), "{args:?}: {run:?}");
    }
    let run = folder.run(&["check", "root/scene.bhs", "--root", "nowhere"]);
    assert!(run.code == 1 && run.err.contains("nowhere"), "{run:?}");
}

#[test]
fn a_confined_scene_writes_nothing_outside() {
    let folder = Folder::new("");
    std::fs::create_dir_all(folder.at("root/out")).expect("writable");
    symlink("..", folder.at("root/up")).expect("links");
    symlink("../outside.exr", folder.at("root/link.exr")).expect("links");
    symlink("../outside.png", folder.at("root/hidden.png")).expect("links");
    let absolute = folder.at("outside.exr");
    let names = [
        "outside.exr",
        "root/../outside.exr",
        "root/up/x.exr",
        "root/link.exr",
        "root/hidden.exr",
        absolute.to_str().expect("text"),
    ];
    for name in names {
        folder.write("root/scene.bhs", SMALL.replace("small.exr", name));
        let before = folder.files();
        for command in ["check", "render"] {
            let run = folder.run(&[command, "root/scene.bhs", "--root", "root"]);
            assert!(
                run.code == 1 && run.err.contains("outside of `root`") && run.err.contains("scene.bhs:2:"),
                "{name}: {run:?}"
            );
        }
        assert_eq!(folder.files(), before);
    }
    folder.write("root/scene.bhs", SMALL.replace("small.exr", "root/out/x.exr"));
    assert_eq!(folder.run(&["render", "root/scene.bhs", "--quiet", "--root", "root"]).code, 0);
    assert!(folder.at("root/out/x.exr").exists());
    // Whoever runs the program may name files elsewhere, but is not led there by a link of the folder.
    assert_eq!(folder.run(&["render", "root/scene.bhs", "--quiet", "--root", "root", "-o", "mine.exr"]).code, 0);
    for args in [["-o", "root/link.exr"], ["-o", "root/hidden.exr"], ["--stats", "root/link.exr"]] {
        let run = folder.run(&[&["render", "root/scene.bhs", "--root", "root"], &args[..]].concat());
        assert!(run.code == 1 && run.err.contains("outside of `root`"), "{args:?}: {run:?}");
    }
    assert!(!folder.at("outside.exr").exists() && !folder.at("outside.png").exists());
}
