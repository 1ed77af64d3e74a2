//! What an output replaces: its mode and the links that lead to it stay, half a file is never seen, and nothing is left lying about.
#![cfg(unix)]

use crate::common;
use crate::common::program::{Folder, SMALL};
use std::fs;
use std::os::unix::fs::{MetadataExt, PermissionsExt, symlink};
use std::time::{Duration, Instant};

#[test]
fn modes_and_links_of_what_is_replaced_are_kept() {
    let folder = Folder::new(SMALL);
    for (name, mode) in [("store/real.exr", 0o640), ("store/small.png", 0o604), ("s.json", 0o600)] {
        folder.write(name, "old");
        fs::set_permissions(folder.at(name), fs::Permissions::from_mode(mode)).expect("its mode can be set");
    }
    symlink("store/link.exr", folder.at("small.exr")).expect("links");
    symlink("real.exr", folder.at("store/link.exr")).expect("links");
    symlink(folder.at("store/small.png"), folder.at("small.png")).expect("links");
    let run = folder.run(&["render", "scene.bhs", "--quiet", "--stats", "s.json"]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    for link in ["small.exr", "store/link.exr", "small.png"] {
        assert!(fs::symlink_metadata(folder.at(link)).expect("it is there").is_symlink(), "{link}");
    }
    for (name, mode) in [("store/real.exr", 0o640), ("store/small.png", 0o604), ("s.json", 0o600)] {
        assert_eq!(fs::metadata(folder.at(name)).expect("it is there").mode() & 0o7777, mode, "{name}");
        assert_ne!(folder.read(name), b"old");
    }
    assert_eq!(
        folder.files(),
        ["s.json", "scene.bhs", "small.exr", "small.png", "store/link.exr", "store/real.exr", "store/small.png"]
    );
    // New files have the mode that new files have.
    let run = folder.shell("umask 027; \"$BHS\" render scene.bhs --quiet -o new.exr");
    assert_eq!((run.code, fs::metadata(folder.at("new.exr")).expect("it is there").mode() & 0o777), (0, 0o640));
}

#[test]
fn a_link_to_what_is_not_there_yet_is_followed() {
    let folder = Folder::new(SMALL);
    fs::create_dir(folder.at("store")).expect("writable");
    symlink("store/picture.exr", folder.at("small.exr")).expect("links");
    assert_eq!(folder.run(&["render", "scene.bhs", "--quiet"]).code, 0);
    assert!(fs::symlink_metadata(folder.at("small.exr")).expect("it is there").is_symlink());
    assert!(fs::symlink_metadata(folder.at("store/picture.exr")).expect("it is there").is_file());
}

#[test]
fn format_keeps_mode_and_links() {
    let folder = Folder::new("");
    folder.write("real/scene.bhs", "WorldBegin   # so\n");
    fs::set_permissions(folder.at("real/scene.bhs"), fs::Permissions::from_mode(0o660)).expect("its mode can be set");
    fs::remove_file(folder.at("scene.bhs")).expect("it is there");
    symlink("real/scene.bhs", folder.at("scene.bhs")).expect("links");
    assert_eq!(folder.run(&["format", "--write", "scene.bhs"]).code, 0);
    assert!(fs::symlink_metadata(folder.at("scene.bhs")).expect("it is there").is_symlink());
    assert_eq!(fs::metadata(folder.at("scene.bhs")).expect("it is there").mode() & 0o7777, 0o660);
    assert_eq!(folder.read("real/scene.bhs"), b"WorldBegin  # so\n");
    assert_eq!(folder.files(), ["real/scene.bhs", "scene.bhs"]);
}

#[test]
fn long_names_are_written() {
    let folder = Folder::new(SMALL);
    let name = format!("{}.exr", "ä".repeat(123));
    assert_eq!(name.len(), 250);
    let run = folder.run(&["render", "scene.bhs", "--quiet", "-o", &name]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    assert_eq!(folder.files(), ["scene.bhs".to_owned(), name.clone(), name.replace(".exr", ".png")]);
    let run = folder.run(&["render", "scene.bhs", "-o", &format!("{}.exr", "x".repeat(252))]);
    assert!(run.code == 1 && run.err.contains("too long"), "{}", run.err);
}

#[test]
fn what_dead_processes_left_is_cleared_and_what_living_ones_write_is_not() {
    let folder = Folder::new(SMALL);
    let (dead, alive) = (".small.exr.abcDEF012345.part", ".small.png.abcDEF012345.part");
    // Names that are not those of files under way of this picture.
    let others = [".other.exr.abcDEF012345.part", ".small.exr.abc.part", "small.exr.part", ".small.exr.part"];
    for name in [dead, alive].into_iter().chain(others) {
        folder.write(name, "half");
    }
    let held = fs::OpenOptions::new().write(true).open(folder.at(alive)).expect("it is there");
    held.try_lock().expect("nobody else holds it");
    let run = folder.run(&["render", "scene.bhs", "--quiet"]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    assert!(!folder.at(dead).exists() && folder.at(alive).exists());
    assert!(others.iter().all(|name| folder.at(name).exists()));
    drop(held);
    assert_eq!(folder.run(&["render", "scene.bhs", "--quiet"]).code, 0);
    assert!(!folder.at(alive).exists());
}

/// A file of somebody else's, in a folder that keeps it from being replaced, as `/tmp` does.
#[test]
#[cfg(target_os = "linux")]
fn what_belongs_to_somebody_else_is_found_before_rendering() {
    let folder = Folder::new(SMALL);
    fs::create_dir(folder.at("shared")).expect("writable");
    folder.write("shared/x.exr", "theirs");
    for (name, mode) in [("", 0o755), ("shared", 0o1777), ("shared/x.exr", 0o666)] {
        fs::set_permissions(folder.at(name), fs::Permissions::from_mode(mode)).expect("its mode can be set");
    }
    // Another user: only root may become one, and be kept out by the folder of the program.
    let other = "setpriv --reuid 65534 --regid 65534 --clear-groups";
    if folder.shell(&format!("{other} \"$BHS\" --version")).code != 0 {
        common::skipped("this user cannot become another, or that one cannot start the program");
        return;
    }
    let run = folder.shell(&format!("{other} \"$BHS\" render scene.bhs -o shared/x.exr"));
    assert!(run.code == 1 && run.err.contains("belongs to somebody else"), "{run:?}");
    assert_eq!(
        (folder.files(), folder.read("shared/x.exr")),
        (vec!["scene.bhs".into(), "shared/x.exr".into()], b"theirs".to_vec())
    );
}

#[test]
fn a_killed_render_leaves_nothing_and_changes_nothing() {
    let folder = Folder::new(SMALL);
    folder.write("small.exr", "old");
    let mut child = folder.command(&["render", "scene.bhs", "--spp", "1000000000"]).spawn().expect("it starts");
    std::thread::sleep(Duration::from_secs(1));
    child.kill().expect("it runs");
    child.wait().expect("it ends");
    assert_eq!(
        (folder.files(), folder.read("small.exr")),
        (vec!["scene.bhs".to_owned(), "small.exr".to_owned()], b"old".to_vec())
    );
}

#[test]
fn a_picture_is_never_seen_by_half() {
    // Larger, so that writing takes a while.
    let folder = Folder::new(&SMALL.replace("resolution\" 8", "resolution\" 600"));
    let render = || folder.command(&["render", "scene.bhs", "--quiet", "--spp", "1"]).spawn().expect("it starts");
    assert!(render().wait().expect("it ends").success());
    let (exr, png) = (folder.at("small.exr"), folder.at("small.png"));
    let mut child = render();
    let (mut seen, start) = (0, Instant::now());
    while child.try_wait().expect("it can be asked").is_none() && start.elapsed() < Duration::from_secs(60) {
        let picture = bhs::image::Picture::read_exr(&exr).expect("a whole picture");
        assert_eq!(picture.size, [600, 600]);
        image::open(&png).expect("a whole PNG");
        seen += 1;
    }
    assert!(seen > 0 && child.wait().expect("it ends").success());
}
