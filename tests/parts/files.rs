//! The files of parts, and what stands beside them: what is not their own stays, and what is not whole is not taken for it.

use super::{CAMERA, FILM, LAYERS, SOBOL, render, scene};
use crate::common;
use crate::common::process::Folder;
use crate::common::program;
use bhs::checkpoint::{self, Identity};
use bhs::parts::file::{self, PartHead};
use bhs::parts::{Cover, Windowed};
use bhs::progress::Progress;
use bhs::render::{Job, Limits, RenderState};
use bhs::signals::Signals;
use serde_json::Value;
use std::fs::File;

#[test]
fn checkpoints_of_others_stay() {
    let folder = Folder::new(&scene(FILM, SOBOL, CAMERA));
    assert_eq!(folder.run(&["render", "scene.bhs", "-o", "room.exr", "--checkpoint", "--spp", "3"]).0, 0);
    assert_eq!(folder.run(&["render", "scene.bhs", "-o", "room.exr", "--resume"]).0, 0);
    folder.write("thesis.txt", "years of work");
    folder.write("thesis.previous.txt", "and more");
    let names = ["room.checkpoint", "room.previous.checkpoint", "thesis.txt", "thesis.previous.txt"];
    let all = || names.map(|name| std::fs::read(folder.path(name)).unwrap_or_else(|e| panic!("{name}: {e}")));
    let before = all();
    // One pixel of a first sample: it is done before a checkpoint is due.
    let part = ["render", "scene.bhs", "--samples", "0..1", "--crop", "0,0.02,0,0.02", "-o", "room.bhspart"];
    for flags in [&[][..], &["--checkpoint"], &["--checkpoint=thesis.txt"], &["--checkpoint=room.checkpoint"]] {
        let (code, err) = folder.run(&[&part[..], flags].concat());
        assert_eq!(code, 0, "{flags:?}: {err}");
        assert!(before == all(), "{flags:?}");
    }
    // All of the picture as a part, too.
    assert_eq!(folder.run(&["render", "scene.bhs", "--part", "1/1", "-o", "room.bhspart", "--checkpoint"]).0, 0);
    assert!(before == all());
}

#[test]
fn a_part_does_not_go_on_from_one_with_more_samples() {
    let folder = Folder::new(&scene(FILM, SOBOL, CAMERA));
    let built = common::build(&scene(FILM, SOBOL, CAMERA));
    let job = Job { first_sample: 5, ..Job::of(&built) };
    let state = RenderState::new(job).expect("there is memory");
    let limits = Limits { most: 9, ..Limits::of(&*built.sampler) };
    state.run(&limits, &Progress::hidden(), &Signals::default());
    let identity = Identity::of_part(&built, job.film.crop(), 5);
    let to = File::create(folder.path("b.bhspart.checkpoint")).expect("the folder can be written");
    checkpoint::write(to, &identity, &state).expect("it can be written");
    let run = |samples| folder.run(&["render", "scene.bhs", "--samples", samples, "-o", "b.bhspart", "--resume"]);
    let (code, err) = run("5..8");
    assert!(code == 1 && err.contains("longer part") && err.contains("samples up to 9"), "{err}");
    assert!(!folder.path("b.bhspart").exists() && folder.path("b.bhspart.checkpoint").exists());
    // One that ends there, or later, does.
    let (code, err) = run("5..9");
    assert!(code == 0 && err.contains("finished") && !folder.path("b.bhspart.checkpoint").exists(), "{err}");
    let (code, err) = folder.run(&["merge", "b.bhspart", "-o", "m.exr", "--partial"]);
    assert!(code == 0 && !err.contains("damaged"), "{err}");
}

#[test]
fn what_has_other_samples_than_it_says_is_no_whole_part() {
    let built = common::build(&scene(&format!("{FILM} {LAYERS}"), SOBOL, CAMERA));
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.bhspart");
    let cover = |samples| Cover { samples, ..Cover::whole(&*built.film, 11) };
    let head = PartHead::of(&built, cover([2, 6]), None);
    let holds = |samples| {
        let to = File::create(&path).expect("the folder can be written");
        file::write(to, &head, &render(&built, cover(samples))).expect("it can be written");
        file::holds(&path, &head, (&*built.film, &built.layers))
    };
    assert_eq!([[2, 6], [2, 5], [2, 7]].map(holds), [true, false, false]);
}

#[test]
fn the_film_of_a_part_reads_no_file() {
    let built = common::build(&scene(FILM, SOBOL, CAMERA));
    let head = PartHead::of(&built, Cover::whole(&*built.film, 11), None);
    assert!(file::film_of(&head).is_some());
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("film.bhs");
    std::fs::write(&path, &head.film).expect("the folder can be written");
    let include = PartHead { film: format!("Include \"{}\"", path.display()), ..head };
    assert!(file::film_of(&include).is_none());
}

#[test]
fn stars_are_drawn_by_the_parts_that_show_them() {
    let built = common::build(&scene(FILM, SOBOL, CAMERA));
    for (first_sample, shows) in [(0, true), (3, false)] {
        let film = Windowed::new(&*built.film, built.film.crop());
        let state = RenderState::new(Job { film: &film, first_sample, ..Job::of(&built) }).expect("there is memory");
        assert_eq!(state.frame().points().is_some(), shows, "from sample {first_sample} on");
    }
}

#[test]
fn programs_hear_of_parts() {
    let folder = program::Folder::new(&scene(FILM, SOBOL, CAMERA));
    let part = ["render", "scene.bhs", "--part", "2/2", "-o", "b.bhspart"];
    let run = folder.run(&[&part[..], &["--stats", "-", "--quiet"]].concat());
    let stats: Value = serde_json::from_str(&run.out).unwrap_or_else(|e| panic!("{e}: {}", run.out));
    assert!(run.code == 0 && run.err.is_empty() && stats["counts"]["paths"] == 37 * 21 * 6, "{stats} {}", run.err);
    let run = folder.run(&[&part[..], &["--progress", "json"]].concat());
    let events: Vec<Value> = run.err.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    let pictures: Vec<&Value> = events.iter().filter(|e| e["event"] == "picture").collect();
    assert!(pictures.len() == 1 && pictures[0]["output"] == "b.bhspart" && pictures[0]["in_place"] == true, "{}", run.err);
}
