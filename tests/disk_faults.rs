//! Disks that are full, limits on the size of files, and folders that go away: the picture is kept if any place takes it.
#![cfg(unix)]

use crate::common;
use crate::common::program::{Folder, SMALL};
use std::time::Duration;

/// The commands that a message names, as a script.
fn commands(err: &str) -> String {
    err.lines()
        .filter(|l| l.trim_start().starts_with("mv ") || l.trim_start().starts_with("mkdir "))
        .collect::<Vec<_>>()
        .join("\n")
}

/// A file of the folder's other than the scene, by a part of its name.
fn one(folder: &Folder, part: &str) -> Option<String> {
    folder.files().into_iter().find(|name| name.contains(part))
}

#[test]
fn a_limit_on_the_size_of_files_does_not_kill_and_harms_nothing() {
    let folder = Folder::new(SMALL);
    assert_eq!(folder.run(&["render", "scene.bhs", "--quiet"]).code, 0);
    let before = folder.contents();
    // No file may have a byte: no place can help.
    let run = folder.shell("ulimit -f 0; export TMPDIR=\"$PWD\"; exec \"$BHS\" render scene.bhs --quiet --seed 7 2> /dev/full");
    assert_eq!(run.code, 1, "{run:?}");
    assert!(folder.contents() == before, "{:?}", folder.files());
    let run = folder.shell("ulimit -f 0; export TMPDIR=\"$PWD\"; \"$BHS\" render scene.bhs --quiet --seed 7 2>&1 | cat");
    assert!(
        run.out.contains("too large") && run.out.contains("`small.exr` is lost") && run.out.contains("`small.png` is lost"),
        "{run:?}"
    );
    assert!(folder.contents() == before, "{:?}", folder.files());
}

#[test]
fn what_fits_is_kept_elsewhere() {
    // The PNG of a grey picture is small, the EXR with its layers is not.
    let folder = Folder::new(&SMALL.replace("resolution\" 8", "resolution\" 32"));
    let run =
        folder.shell("ulimit -f 8; export TMPDIR=\"$PWD\"; exec \"$BHS\" render scene.bhs --quiet --aov normal --aov position");
    assert_eq!(run.code, 1, "{run:?}");
    assert!(run.err.contains("cannot write `small.exr`") && run.err.contains("`small.exr` is lost"), "{run:?}");
    let kept = one(&folder, "small.rescued-").expect("the PNG is kept");
    assert!(kept.ends_with(".png") && run.err.contains(&kept) && !folder.at("small.png").exists(), "{kept}: {run:?}");
    assert_eq!(folder.shell(&commands(&run.err)).code, 0);
    assert_eq!(folder.files(), ["scene.bhs", "small.png"]);
    image::open(folder.at("small.png")).expect("a whole PNG");
}

#[test]
fn a_folder_that_goes_away_costs_no_picture() {
    let folder = Folder::new(SMALL);
    folder.write("a b's/scene.bhs", SMALL);
    std::fs::create_dir(folder.at("out")).expect("writable");
    let scene = folder.at("a b's/scene.bhs");
    let args = ["render", scene.to_str().expect("text"), "--spp", "1000000000", "-o", "out/x.exr", "--stats", "out/x.json"];
    let child = folder.command(&args).spawn().expect("it starts");
    std::thread::sleep(Duration::from_secs(2));
    std::fs::remove_dir(folder.at("out")).expect("there is nothing in it");
    let id = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &id]).status().expect("kill runs").success());
    let output = child.wait_with_output().expect("it ends");
    let err = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{err}");
    for ending in [".exr", ".png", ".json"] {
        let kept = folder.files().into_iter().find(|f| f.starts_with("a b's/x.rescued-") && f.ends_with(ending));
        assert!(kept.is_some(), "{err} {:?}", folder.files());
    }
    let finished = folder.shell(&commands(&err));
    assert_eq!(finished.code, 0, "{err}{finished:?}");
    assert_eq!(folder.files(), ["a b's/scene.bhs", "out/x.exr", "out/x.json", "out/x.png", "scene.bhs"]);
    bhs::image::Picture::read_exr(&folder.at("out/x.exr")).expect("a whole picture");
}

#[test]
fn without_room_beside_the_scene_the_temporary_folder_takes_it() {
    let folder = Folder::new(SMALL);
    std::fs::create_dir_all(folder.at("out")).expect("writable");
    std::fs::create_dir_all(folder.at("tmp")).expect("writable");
    let mut command = folder.command(&["render", "-", "--spp", "1000000000", "-o", "x.exr"]);
    // The folder of the picture is that of the scene, and goes away.
    let scene = std::fs::File::open(folder.at("scene.bhs")).expect("it is there");
    let child = command.current_dir(folder.at("out")).env("TMPDIR", folder.at("tmp")).stdin(scene).spawn().expect("it starts");
    std::thread::sleep(Duration::from_secs(2));
    std::fs::remove_dir(folder.at("out")).expect("there is nothing in it");
    let id = child.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &id]).status().expect("kill runs").success());
    let output = child.wait_with_output().expect("it ends");
    let err = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(1), "{err}");
    let kept = one(&folder, "tmp/x.rescued-").expect("it is kept");
    assert!(err.contains(&kept), "{err}");
    assert_eq!(folder.shell(&commands(&err)).code, 0, "{err}");
    assert_eq!(folder.files(), ["out/x.exr", "out/x.png", "scene.bhs"]);
}

/// A file system of 64 KiB, where the system lets one be mounted.
#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_costs_no_picture() {
    let folder = Folder::new(&SMALL.replace("resolution\" 8", "resolution\" 100"));
    std::fs::create_dir(folder.at("disk")).expect("writable");
    let mount = "unshare -Urm sh -c 'mount -t tmpfs -o size=64k none disk && ";
    if folder.shell(&format!("{mount} true'")).code != 0 {
        common::skipped("a small file system cannot be mounted here");
        return;
    }
    let script = "cp scene.bhs disk/old.exr; \
        \"$BHS\" render scene.bhs --quiet --aov normal --aov position -o disk/x.exr; \
        code=$?; ls -A disk; exit $code'";
    let run = folder.shell(&format!("{mount} {script}"));
    assert!(run.code == 1 && run.err.contains("No space left"), "{run:?}");
    assert_eq!(run.out, "old.exr\n", "nothing by half, and no litter");
    assert_eq!(folder.files().len(), 3, "{:?}", folder.files());
    let run = folder.shell(&commands(&run.err));
    assert_eq!(run.code, 0, "{run:?}");
    assert_eq!(folder.files(), ["disk/x.exr", "disk/x.png", "scene.bhs"]);
    bhs::image::Picture::read_exr(&folder.at("disk/x.exr")).expect("a whole picture");
}

#[test]
fn a_folder_that_cannot_be_written_is_found_before_rendering() {
    let folder = Folder::new(SMALL);
    // Also for who may write everything else.
    let run = folder.run(&["render", "scene.bhs", "--spp", "1000000000", "-o", "/proc/x.exr"]);
    assert!(run.code == 1 && run.err.contains("/proc/x.exr"), "{run:?}");
    assert_eq!(folder.files(), ["scene.bhs"]);
}
