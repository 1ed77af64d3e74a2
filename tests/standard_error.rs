//! Standard error that nobody reads changes nothing: neither exit codes nor what is written. Standard output that is full is an error.
#![cfg(unix)]

use crate::common::program::{Folder, SMALL};
use std::fs::File;
use std::process::{Command, Stdio};

/// A scene with a warning.
const WARNED: &str = "\nMakeNamedMaterial \"unused\" \"string type\" \"diffuse\"\n";

/// Every command, with what is said on standard error: nothing, words, warnings, errors. Exit code; arguments.
const RUNS: [(i32, &[&str]); 30] = [
    (0, &["render", "scene.bhs"]),
    (0, &["render", "scene.bhs", "--quiet"]),
    (0, &["render", "scene.bhs", "--aov", "normal", "--false-color", "--stats", "stats.json"]),
    (0, &["render", "scene.bhs", "--checkpoint", "--write-partial"]),
    (0, &["render", "scene.bhs", "--resume"]),
    (0, &["render", "scene.bhs", "--progress", "json"]),
    (0, &["render", "scene.bhs", "--display-server=127.0.0.1:9"]),
    (1, &["render", "faulty.bhs", "scene.bhs"]),
    (1, &["render", "faulty.bhs"]),
    (1, &["render", "faulty.bhs", "--quiet"]),
    (1, &["render", "nothing.bhs"]),
    (1, &["render", "scene.bhs", "-o", "nowhere/x.exr"]),
    (2, &["render", "scene.bhs", "--false-color"]),
    (2, &["render"]),
    (2, &["render", "scene.bhs", "--spp", "many"]),
    (0, &["check", "scene.bhs"]),
    (0, &["check", "scene.bhs", "--json"]),
    (1, &["check", "faulty.bhs"]),
    (0, &["format", "scene.bhs"]),
    (1, &["format", "broken.bhs"]),
    (2, &["format", "--write", "-"]),
    (0, &["plugins"]),
    (2, &["plugins", "integrator", "cheese"]),
    (0, &["trace", "scene.bhs", "--rays", "rays.csv"]),
    (1, &["trace", "scene.bhs", "--rays", "bad.csv"]),
    (0, &["bench", "scene.bhs", "--rays", "100", "--rounds", "1", "--resolution", "4x4", "--only", "integrators"]),
    (2, &["bench", "-"]),
    (0, &["compare", "a.exr", "a.exr"]),
    (1, &["compare", "a.exr", "scene.bhs"]),
    (2, &["cheese"]),
];

fn folder() -> Folder {
    let folder = Folder::new(&format!("{SMALL}{WARNED}"));
    // As many errors as are drawn.
    folder.write("faulty.bhs", format!("{SMALL}{}", "Shape \"spheer\"\n".repeat(200)));
    folder.write("broken.bhs", "WorldBegin [");
    folder.write("rays.csv", "0,0,-5,0,0,1\n");
    folder.write("bad.csv", "0,0,-5,0,0,1\n1,2\n");
    assert_eq!(folder.run(&["render", "scene.bhs", "--quiet", "-o", "a.exr"]).code, 0);
    folder
}

/// Runs every command with a standard error that `change` gives it.
fn nothing_changes(change: impl Fn(Command) -> Command) {
    let folder = folder();
    for (code, args) in RUNS {
        let mut command = change(folder.command(args));
        let output = command.stdout(Stdio::piped()).output().expect("it starts");
        assert_eq!(output.status.code(), Some(code), "{args:?}");
        // What is printed is not lost with it; benchmarks never print the same.
        if args[0] != "bench" {
            assert_eq!(String::from_utf8_lossy(&output.stdout), folder.run(args).out, "{args:?}");
        }
        if code == 0 && args[0] == "render" {
            bhs::image::Picture::read_exr(&folder.at("small.exr")).expect("a whole picture");
            std::fs::remove_file(folder.at("small.exr")).expect("it is there");
        }
    }
    assert!(folder.files().iter().all(|name| !name.ends_with(".part")), "{:?}", folder.files());
}

#[test]
fn a_closed_pipe_behind_standard_error_ends_nothing() {
    nothing_changes(|mut command| {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        command.stderr(writer);
        command
    });
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_behind_standard_error_ends_nothing() {
    nothing_changes(|mut command| {
        command.stderr(File::options().write(true).open("/dev/full").expect("Linux has it"));
        command
    });
}

#[test]
fn a_closed_standard_error_ends_nothing() {
    nothing_changes(|command| in_shell(&command, "exec \"$@\" 2>&-"));
}

#[test]
fn a_standard_error_that_may_not_grow_ends_nothing() {
    let folder = Folder::new(&format!("{SMALL}{WARNED}"));
    // Nothing may be written to a file at all, the picture neither.
    let run = folder.shell("ulimit -f 0; \"$BHS\" check scene.bhs 2> log; echo $?; \"$BHS\" render scene.bhs 2> log; echo $?");
    assert_eq!(run.out, "0\n1\n", "{run:?}");
}

/// The same command, started by a shell script that gets it as its arguments.
fn in_shell(command: &Command, script: &str) -> Command {
    let mut shell = Command::new("sh");
    shell.args(["-c", script, "sh"]).arg(command.get_program()).args(command.get_args());
    shell.current_dir(command.get_current_dir().expect("it has one")).stdin(Stdio::null());
    shell
}

/// Commands that print on standard output.
const PRINTING: [&[&str]; 12] = [
    &["--help"],
    &["--version"],
    &["--version", "--verbose"],
    &["completions", "bash"],
    &["man"],
    &["render", "--help"],
    &["check", "--json", "scene.bhs"],
    &["format", "scene.bhs"],
    &["plugins", "--json"],
    &["trace", "scene.bhs", "--rays", "rays.csv"],
    &["bench", "scene.bhs", "--resolution", "4x4", "--rounds", "1", "--only", "transports"],
    &["compare", "a.exr", "a.exr"],
];

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_behind_standard_output_is_an_error() {
    let folder = folder();
    for args in PRINTING {
        let full = File::options().write(true).open("/dev/full").expect("Linux has it");
        let output = folder.command(args).stdout(full).output().expect("it starts");
        let err = String::from_utf8_lossy(&output.stderr).into_owned();
        assert!(output.status.code() == Some(1) && err.contains("No space left"), "{args:?}: {:?} {err}", output.status);
    }
}

#[test]
fn a_closed_pipe_behind_standard_output_is_none() {
    let folder = folder();
    for args in PRINTING {
        let (reader, writer) = std::io::pipe().expect("a pipe");
        drop(reader);
        let output = folder.command(args).stdout(writer).output().expect("it starts");
        assert_eq!(output.status.code(), Some(0), "{args:?}: {}", String::from_utf8_lossy(&output.stderr));
    }
}
