//! Engines that people have: the scripts of `farm/` on a real Slurm and on Open Job Description, where these are installed.

use crate::common;
use crate::common::program::{Folder, SMALL};
use std::process::Command;

/// Whether a program is there.
fn has(program: &str) -> bool {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::env::split_paths(&path).chain(["/usr/sbin".into(), "/sbin".into()]);
    folders.map(|folder| folder.join(program)).any(|file| file.is_file())
}

fn run(script: &str, args: &[&str]) {
    let mut command = Command::new("sh");
    command.arg(common::root().join(script)).args(args).env("BHS", assert_cmd::cargo::cargo_bin!("bhs"));
    // Not what a farm that runs this test says of itself.
    std::env::vars_os().filter(|(name, _)| name.to_string_lossy().starts_with("SLURM")).for_each(|(name, _)| {
        command.env_remove(name);
    });
    let out = command.output().expect("sh starts");
    let text = format!("{}{}", String::from_utf8_lossy(&out.stdout), String::from_utf8_lossy(&out.stderr));
    assert!(out.status.success(), "{script}: {}\n{text}", out.status);
}

#[cfg(target_os = "linux")]
#[test]
fn a_slurm_of_four_nodes_makes_the_bytes_of_one_machine() {
    if !["slurmctld", "slurmd", "sbatch"].iter().all(|program| has(program)) {
        return common::skipped("Slurm is not installed (slurmctld, slurmd, slurm-client); farm/slurm/try.sh installs it");
    }
    run("farm/slurm/try.sh", &["--no-install"]);
}

/// A folder with a scene, whose shell has a Slurm that says what it is told to: `sbatch` notes its words in the file `submitted`, and `squeue` prints
/// the file `queue`.
#[cfg(unix)]
fn without_slurm() -> (Folder, impl Fn(&Folder, &str) -> String) {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new(SMALL);
    for (name, script) in
        [("sbatch", "for word; do echo \"$word\"; done >> submitted; echo 7"), ("squeue", "cat queue"), ("scontrol", "exit 1")]
    {
        let name = format!("bin/{name}");
        folder.write(&name, format!("#!/bin/sh\n{script}\n"));
        std::fs::set_permissions(folder.at(&name), std::fs::Permissions::from_mode(0o755)).expect("its mode can be set");
    }
    let shell = |folder: &Folder, script: &str| {
        let farm = common::root().join("farm/slurm");
        let run = folder.shell(&format!("set -e; PATH=$(pwd)/bin:$PATH; export BHS; farm='{}'; {script}", farm.display()));
        assert_eq!(run.code, 0, "{script}: {}{}", run.out, run.err);
        run.out
    };
    (folder, shell)
}

#[cfg(unix)]
#[test]
fn numbers_with_zeros_before_them_are_decimal_and_what_runs_is_not_submitted_again() {
    let (folder, shell) = without_slurm();
    folder.write("queue", "");
    let array = |folder: &Folder| {
        let words = String::from_utf8(folder.read("submitted")).expect("text");
        std::fs::remove_file(folder.at("submitted")).expect("it is there");
        words.lines().filter_map(|word| word.strip_prefix("--array=").map(str::to_owned)).collect::<Vec<_>>()
    };
    shell(&folder, "$farm/submit scene.bhs -o film.exr --frames 008-010:01 --cpus 08 --warn 010");
    assert_eq!(array(&folder), ["0-2"]);
    let job = String::from_utf8(folder.read("film.farm/job")).expect("text");
    assert!(job.contains("first=8 last=10 step=1 cpus=8 warn=10\n"), "{job}");
    // Two of them are under way.
    folder.write("queue", "7 0\n7 2\n");
    let said = shell(&folder, "$farm/resubmit film.farm");
    assert!(said.contains("under way: 2"), "{said}");
    assert_eq!(array(&folder), ["1"]);
    folder.write("queue", "7 0\n7 2\n7 1\n");
    shell(&folder, "$farm/resubmit film.farm");
    assert!(!folder.at("submitted").exists());
    // Parts, and the job that joins them.
    folder.write("queue", "");
    shell(&folder, "$farm/submit scene.bhs -o room.exr --parts 010");
    assert_eq!(array(&folder), ["0-9"]);
    folder.write("queue", (0..10).map(|k| format!("7 {k}\n")).collect::<String>() + "8 N/A\n");
    shell(&folder, "$farm/resubmit room.farm");
    assert!(!folder.at("submitted").exists());
    // Without it, it is to come after them.
    folder.write("queue", "7 3\n");
    folder.write("room.farm/done.1", "");
    folder.write("room.farm/1.bhspart", "");
    shell(&folder, "$farm/resubmit room.farm");
    let words = String::from_utf8(folder.read("submitted")).expect("text");
    assert!(words.contains("--array=1-2,4-9\n") && words.contains("--dependency=afterany:7:7\n"), "{words}");
}

#[cfg(unix)]
#[test]
fn a_task_leaves_the_state_of_other_films_alone() {
    let (folder, shell) = without_slurm();
    folder.write("queue", "");
    folder.write("film.other.0009.checkpoint", "of a film that is called `film.other`");
    shell(&folder, "$farm/submit scene.bhs -o film.exr --frames 09-10");
    shell(&folder, "SLURM_ARRAY_TASK_ID=0 sh $farm/task $(pwd)/film.farm");
    let files = folder.files();
    let there = |name: &str| files.iter().any(|file| file == name);
    assert!(there("film.0009.exr") && there("film.farm/done.9") && there("film.other.0009.checkpoint"), "{files:?}");
    assert_eq!(files.iter().filter(|name| name.contains("checkpoint")).count(), 1, "{files:?}");
}

#[test]
fn open_job_description_makes_the_bytes_of_one_machine() {
    if !has("openjd") {
        return common::skipped("openjd-cli is not installed (pip install openjd-cli)");
    }
    run("farm/openjd/try.sh", &[]);
}

#[test]
fn scripts_are_scripts() {
    for folder in ["farm/slurm", "farm/openjd"] {
        for entry in std::fs::read_dir(common::root().join(folder)).expect("it is there") {
            let path = entry.expect("it can be read").path();
            let text = std::fs::read_to_string(&path).expect("a text");
            if text.starts_with("#!/bin/sh") || path.extension().is_some_and(|ending| ending == "sh") {
                let checked = Command::new("sh").arg("-n").arg(&path).status().expect("sh starts");
                assert!(checked.success(), "{}", path.display());
            }
        }
    }
}
