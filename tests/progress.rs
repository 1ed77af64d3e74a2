//! How far a render has come, as people and programs are told.

use crate::common::program::{Folder, SMALL};
use serde_json::Value;

/// The lines of standard error, each of which is an event.
fn events(err: &str) -> Vec<Value> {
    err.lines().map(|line| serde_json::from_str(line).unwrap_or_else(|e| panic!("{e}: {line}"))).collect()
}

/// The names of the events.
fn names(events: &[Value]) -> Vec<&str> {
    events.iter().map(|event| event["event"].as_str().expect("every event has a name")).collect()
}

/// That there is one first event and one last; the last.
fn framed(events: &[Value]) -> &Value {
    let names = names(events);
    assert_eq!((names.first(), names.last()), (Some(&"start"), Some(&"end")), "{names:?}");
    assert_eq!(names.iter().filter(|name| ["start", "end"].contains(name)).count(), 2, "{names:?}");
    events.last().expect("there is one")
}

#[test]
fn programs_hear_of_a_render_line_by_line() {
    let folder = Folder::new(&format!("{SMALL}\nMakeNamedMaterial \"unused\" \"string type\" \"diffuse\"\n"));
    assert_eq!(folder.run(&["render", "scene.bhs", "--quiet", "-o", "plain.exr"]).code, 0);
    for quiet in [&[][..], &["--quiet"]] {
        let run = folder.run(&[&["render", "scene.bhs", "--progress", "json"][..], quiet].concat());
        assert_eq!((run.code, run.out.as_str()), (0, ""), "{}", run.err);
        let all = events(&run.err);
        let end = framed(&all);
        assert_eq!((&end["status"], &end["exit_code"], &end["error"]), (&"done".into(), &0.into(), &Value::Null));
        let find = |name: &'static str| all.iter().filter(move |e| e["event"] == name);
        let done = find("progress").next_back().expect("one at least");
        assert_eq!((done["percent"].as_f64(), &done["spp"]), (Some(100.0), &2.into()));
        let picture = find("picture").next().expect("one");
        assert_eq!((&picture["output"], &picture["stopped"]), (&"small.exr".into(), &"complete".into()));
        let warning = find("diagnostic").next().expect("a material is not used");
        assert_eq!((&warning["severity"], &warning["file"]), (&"warning".into(), &"scene.bhs".into()));
        let said: Vec<&str> = find("message").filter_map(|e| e["text"].as_str()).collect();
        assert_eq!(said.iter().any(|text| text.contains("2 spp in")), quiet.is_empty(), "{said:?}");
        assert_eq!(folder.read("small.exr").len(), folder.read("plain.exr").len());
        assert_eq!(folder.read("small.png"), folder.read("plain.png"));
    }
}

#[test]
fn what_is_finished_says_how_many_samples_it_was_to_have() {
    let folder = Folder::new(SMALL);
    for _ in 0..2 {
        let run = folder.run(&["render", "scene.bhs", "--resume", "--progress", "json"]);
        let all = events(&run.err);
        let last = all.iter().rfind(|e| e["event"] == "progress").expect("one at least");
        assert_eq!((&last["spp"], &last["total_spp"]), (&2.into(), &2.into()), "{}", run.err);
    }
}

#[test]
fn the_last_event_carries_the_failure() {
    let folder = Folder::new(SMALL);
    folder.write("faulty.bhs", format!("{SMALL}Shape \"spheer\"\nShape \"cubee\"\n"));
    let cases: [(&[&str], i32, &str); 5] = [
        (&["render", "faulty.bhs"], 1, "spheer"),
        (&["render", "nothing.bhs"], 1, "nothing.bhs"),
        (&["render", "scene.bhs", "-o", "nowhere/x.exr"], 1, "nowhere"),
        (&["render", "scene.bhs", "--false-color"], 2, "--aov"),
        (&["render", "scene.bhs", "--root", "no/such/folder"], 1, "no/such/folder"),
    ];
    for (args, code, word) in cases {
        let run = folder.run(&[args, &["--progress", "json"]].concat());
        assert_eq!(run.code, code, "{}", run.err);
        let all = events(&run.err);
        let end = framed(&all);
        assert_eq!((&end["status"], &end["exit_code"]), (&"failed".into(), &code.into()));
        assert!(end["error"].as_str().is_some_and(|error| error.contains(word)), "{end}");
        let run = folder.run(&[args, &["--progress", "openjd"]].concat());
        let failures: Vec<&str> = run.err.lines().filter(|line| line.starts_with("openjd_fail: ")).collect();
        assert_eq!((run.code, failures.len(), run.err.lines().last()), (code, 1, failures.last().copied()), "{}", run.err);
        assert!(failures[0].contains(word), "{failures:?}");
    }
}

#[test]
fn frames_and_cameras_count_together() {
    let cameras =
        SMALL.replace("Camera \"perspective\"", "Camera \"perspective\"\nCamera \"perspective\" \"string name\" \"left\"");
    let folder = Folder::new(&cameras);
    let run = folder.run(&["render", "scene.bhs", "--frames", "1-3", "--progress", "json"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let all = events(&run.err);
    framed(&all);
    assert_eq!(names(&all).iter().filter(|name| **name == "picture").count(), 6);
    let percent: Vec<f64> = all.iter().filter_map(|e| e["percent"].as_f64()).collect();
    assert!(percent.is_sorted() && percent.len() >= 6 && percent.last() == Some(&100.0), "{percent:?}");
    let run = folder.run(&["render", "scene.bhs", "--progress", "openjd"]);
    let progress: Vec<&str> = run.err.lines().filter(|line| line.starts_with("openjd_progress: ")).collect();
    assert_eq!(
        (run.code, progress.first(), progress.last()),
        (0, Some(&"openjd_progress: 50.0"), Some(&"openjd_progress: 100.0"))
    );
    assert!(!run.err.contains("openjd_fail"), "{}", run.err);
}

#[test]
fn off_a_terminal_a_line_comes_now_and_then() {
    let folder = Folder::new(SMALL);
    let run = folder.run(&["render", "scene.bhs", "--time", "7", "--spp", "1000000000"]);
    let lines: Vec<&str> = run.err.lines().filter(|line| line.starts_with("progress: ")).collect();
    assert!(run.code == 0 && !lines.is_empty() && run.err.contains("spp in"), "{}", run.err);
    for line in lines {
        // Of the time, not of a billion of samples.
        let percent: f64 = line["progress: ".len()..].split('%').next().and_then(|p| p.trim().parse().ok()).expect("a number");
        assert!((20.0..=100.0).contains(&percent) && ["spp", "gone", "left"].iter().all(|w| line.contains(w)), "{line}");
    }
    // A render that is over before has none.
    let run = folder.run(&["render", "scene.bhs"]);
    assert_eq!((run.code, run.err.lines().count()), (0, 1), "{}", run.err);
    for form in ["none", "lines", "tty"] {
        let run = folder.run(&["render", "scene.bhs", "--progress", form]);
        assert_eq!((run.code, run.err.lines().count()), (0, 1), "{}", run.err);
    }
}

#[test]
#[cfg(unix)]
fn programs_hear_of_a_signal() {
    use std::io::{BufRead, BufReader};
    use std::process::Command;
    let folder = Folder::new(SMALL);
    let args = ["render", "scene.bhs", "--spp", "1000000000", "--progress", "json"];
    let mut child = folder.command(&args).spawn().expect("it starts");
    let mut lines = BufReader::new(child.stderr.take().expect("a pipe")).lines().map(|line| line.expect("text"));
    // Under way.
    let before: Vec<String> = lines.by_ref().take_while(|line| !line.contains("\"progress\"")).collect();
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().expect("kill runs").success());
    let all: Vec<String> = before.into_iter().chain(lines).collect();
    let all = events(&all.join("\n"));
    let end = framed(&all);
    assert_eq!((&end["status"], &end["exit_code"]), (&"stopped".into(), &130.into()));
    assert_eq!(child.wait().expect("it ends").code(), Some(130));
    assert_eq!(folder.files(), ["scene.bhs", "small.exr", "small.png"]);
}
