//! Engines that people have: the scripts of `farm/` on a real Slurm and on Open Job Description, where these are installed.

use crate::common;
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
