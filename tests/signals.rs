//! What a render leaves behind when it is told to stop, or killed, at whatever moment.
//!
//! `BHS_KILLS=200 cargo test --release --test all signals::` kills it 200 times with each signal; a few times by default.
#![cfg(unix)]

use crate::common::process::{Folder, files};
use bhs::image::Picture;
use std::time::{Duration, Instant};

/// A small room that renders for about as many samples as are asked for.
const SCENE: &str = r#"
    Film "rgb" "integer xresolution" 48 "integer yresolution" 40 "string filename" "a.exr" "string layers" ["normal" "variance"]
    Sampler "sobol" "integer pixelsamples" 16
    LightTransport "path" "bool guiding" true
    LookAt 0 1 -4  0 1 0  0 1 0
    Camera "perspective" "float fov" 45
    WorldBegin
    LightSource "infinite" "rgb L" [0.7 0.8 1]
    Shape "sphere" "float radius" 0.6
    Rotate -90 1 0 0
    Shape "disk" "float radius" 3
"#;

/// More samples than any test waits for.
const ENDLESS: [&str; 4] = ["render", "scene.bhs", "--spp", "1000000000"];

const SIGNALS: [(&str, i32); 3] = [("INT", 130), ("TERM", 143), ("HUP", 129)];

/// Those of [`SIGNALS`] that reach a program that is started here: whoever runs the tests may ignore hangups (`nohup`), and what they start
/// inherits that.
fn signals() -> impl Iterator<Item = (&'static str, i32)> {
    let ignored = std::fs::read_to_string("/proc/self/status").ok().and_then(|status| {
        let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"))?.trim().to_owned();
        u64::from_str_radix(&mask, 16).ok()
    });
    let hangup_comes = ignored.is_none_or(|mask| mask & 1 == 0);
    if !hangup_comes {
        eprintln!("skipped: SIGHUP, which is ignored here");
    }
    SIGNALS.into_iter().filter(move |(name, _)| hangup_comes || *name != "HUP")
}

#[test]
fn a_signal_stops_a_render_which_writes_what_it_has() {
    for (signal, code) in signals() {
        let folder = Folder::new(SCENE);
        let mut child = folder.start(&[&ENDLESS[..], &["--checkpoint"]].concat());
        child.wait_for(&folder.path("a.checkpoint"));
        child.signal(signal);
        assert_eq!(child.wait(), Some(code));
        assert_eq!(folder.header("a.exr", "bhs:stopped"), format!("SIG{signal}"));
        // Some pixels may have more samples than others.
        let last: u32 = folder.header("a.exr", "bhs:lastSample").parse().expect("a number");
        assert_eq!(files(&folder.path("")), ["a.checkpoint", "a.exr", "a.png", "a.previous.checkpoint", "scene.bhs"]);
        // It goes on from there.
        let more = (last + 10).to_string();
        assert_eq!(folder.run(&["render", "scene.bhs", "--resume", "--spp", &more]).0, 0);
        assert_eq!(folder.run(&["render", "scene.bhs", "-o", "whole.exr", "--spp", &more]).0, 0);
        folder.assert_same("whole", "a");
    }
}

#[test]
fn a_signal_while_the_scene_loads_ends_at_once_and_writes_nothing() {
    for (signal, code) in signals() {
        let folder = Folder::new(SCENE);
        for old in ["a.exr", "a.png"] {
            folder.write(old, "old");
        }
        let mut child = folder.start_loading(&["render", "-", "-o", "a.exr", "--checkpoint"]);
        // The handlers are there before the scene is read: until then the signal itself ends the program.
        let start = Instant::now();
        while !child.handles(signal) {
            assert!(start.elapsed() < Duration::from_secs(300), "it does not listen");
            std::thread::sleep(Duration::from_millis(5));
        }
        child.signal(signal);
        assert_eq!(child.wait(), Some(code), "{signal}");
        assert_eq!(files(&folder.path("")), ["a.exr", "a.png", "scene.bhs"]);
        assert!(["a.exr", "a.png"].iter().all(|old| std::fs::read(folder.path(old)).is_ok_and(|b| b == b"old")));
    }
}

#[test]
fn a_hangup_that_is_ignored_at_the_start_stays_ignored() {
    let folder = Folder::new(SCENE);
    let mut child = folder.start_without_hangup(&[&ENDLESS[..], &["--checkpoint", "--checkpoint-every", "0.1"]].concat());
    child.wait_for(&folder.path("a.checkpoint"));
    child.signal("HUP");
    // It goes on, and saves what it does.
    child.wait_for(&folder.path("a.previous.checkpoint"));
    std::fs::remove_file(folder.path("a.previous.checkpoint")).expect("it was there");
    child.wait_for(&folder.path("a.previous.checkpoint"));
    assert!(!child.has_ended());
    child.signal("TERM");
    assert_eq!(child.wait(), Some(143));
}

#[test]
fn a_user_signal_writes_what_there_is_and_the_render_goes_on() {
    let folder = Folder::new(SCENE);
    let mut child = folder.start(&[&ENDLESS[..], &["--checkpoint", "--checkpoint-every", "100000"]].concat());
    child.wait_for(&folder.path("a.checkpoint"));
    assert!(!folder.path("a.exr").exists());
    child.signal("USR1");
    child.wait_for(&folder.path("a.exr"));
    child.wait_for(&folder.path("a.previous.checkpoint"));
    assert_eq!(folder.header("a.exr", "bhs:stopped"), "underway");
    assert!(!child.has_ended());
    child.signal("TERM");
    assert_eq!(child.wait(), Some(143));
    assert_eq!(folder.header("a.exr", "bhs:stopped"), "SIGTERM");
}

#[test]
fn a_second_signal_leaves_whole_files_and_no_litter() {
    for (i, (signal, code)) in signals().enumerate() {
        let folder = Folder::new(SCENE);
        let mut child = folder.start(&[&ENDLESS[..], &["--checkpoint", "--resolution", "300x300"]].concat());
        child.wait_for(&folder.path("a.checkpoint"));
        child.signal("TERM");
        std::thread::sleep(Duration::from_millis(7 * i as u64));
        child.signal(signal);
        let ended = child.wait();
        assert!(ended == Some(code) || ended == Some(143), "{signal}: {ended:?}");
        assert_whole(&folder);
        assert_no_litter(&folder);
    }
}

/// That whatever stands under a final name can be read.
fn assert_whole(folder: &Folder) {
    for name in files(&folder.path("")) {
        if name.ends_with(".exr") {
            Picture::read_exr(&folder.path(&name)).unwrap_or_else(|e| panic!("{name}: {e:#}"));
        } else if name.ends_with(".png") {
            let bytes = std::fs::read(folder.path(&name)).expect("it is there");
            image::load_from_memory(&bytes).unwrap_or_else(|e| panic!("{name}: {e}"));
        }
    }
}

fn assert_no_litter(folder: &Folder) {
    let known = ["a.checkpoint", "a.exr", "a.png", "a.previous.checkpoint", "scene.bhs", "whole.exr", "whole.png"];
    let litter: Vec<_> = files(&folder.path("")).into_iter().filter(|f| !known.contains(&f.as_str())).collect();
    assert!(litter.is_empty(), "{litter:?}");
}

#[test]
fn killed_at_any_moment_a_render_resumes_to_the_same_bytes() {
    let kills: u32 = std::env::var("BHS_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(3);
    let folder = Folder::new(SCENE);
    let args = ["render", "scene.bhs", "--spp", "200", "--quiet"];
    let start = Instant::now();
    assert_eq!(folder.run(&[&args[..], &["-o", "whole.exr"]].concat()).0, 0);
    let took = start.elapsed();
    // The old pictures, of another render.
    assert_eq!(folder.run(&["render", "scene.bhs", "--spp", "1", "--seed", "9"]).0, 0);
    let old = ["a.exr", "a.png"].map(|name| (name, std::fs::read(folder.path(name)).expect("it is there")));
    let args = [&args[..], &["--checkpoint", "--checkpoint-every", "0.05"]].concat();
    for (signal, code) in [("KILL", None), ("TERM", Some(143)), ("INT", Some(130))] {
        let (mut stopped, mut resumed) = (0, 0);
        for i in 0..kills {
            for (name, content) in &old {
                folder.write(name, content);
            }
            for checkpoint in ["a.checkpoint", "a.previous.checkpoint"] {
                let _ = std::fs::remove_file(folder.path(checkpoint));
            }
            let mut child = folder.start(&args);
            // Well spread over the whole time and a little more: multiples of the golden section.
            std::thread::sleep(took.mul_f64(1.1 * (f64::from(i) * 0.618_034 + 0.37).fract()));
            child.signal(signal);
            let ended = child.wait();
            // One that comes before the program listens ends it without a code.
            assert!(ended == code || ended == Some(0) || ended.is_none(), "{signal}: {ended:?}");
            stopped += u32::from(ended != Some(0));
            assert_whole(&folder);
            if code.is_some() && ended.is_some() {
                assert_no_litter(&folder);
            }
            let kept = old.iter().all(|(name, content)| std::fs::read(folder.path(name)).is_ok_and(|b| b == *content));
            if !kept && signal != "KILL" {
                let why = folder.header("a.exr", "bhs:stopped");
                assert!(why == "complete" || why == format!("SIG{signal}"), "{why}");
            }
            resumed += u32::from(folder.path("a.checkpoint").exists());
            let (code, err) = folder.run(&[&args[..], &["--resume"]].concat());
            assert_eq!(code, 0, "{err}");
            folder.assert_same("whole", "a");
            assert_no_litter(&folder);
        }
        println!("{signal}: {kills} times, {stopped} before the end, {resumed} resumed from a checkpoint");
    }
}
