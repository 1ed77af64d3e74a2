//! Renders that are broken off and resumed end with the same bytes; checkpoints that do not belong to them are refused.

use crate::common;
use crate::common::process::{Folder, files};
use crate::common::room::{CAMERA, room};
use bhs::checkpoint::{self, Identity, Refusal};
use bhs::image::Picture;
use bhs::lang::{BuiltScene, Overrides};
use bhs::progress::Progress;
use bhs::render::{Ended, Job, Limits, RenderState, Rendered};
use bhs::signals::Signals;
use bhs_engine::scene::Scene;
use bhs_engine::stats::PathLog;
use bhs_engine::transport::{LightTransport, PathSample, RenderSetting};
use std::ops::Range;
use std::time::{Duration, Instant};

/// A film, a sampler and a way of gathering light, in the room.
fn scene(film: &str, samples: &str, transport: &str) -> String {
    room(&format!("{film}\nSampler {samples}\nLightTransport \"path\" {transport}"), CAMERA, "")
}

const SMALL: &str = r#""integer xresolution" 40 "integer yresolution" 24"#;
const SOBOL: &str = r#""sobol" "integer pixelsamples" 70"#;
const LAYERS: &str = r#""string layers" ["normal" "variance" "sweptangle"]"#;

/// Everything that a file could show of a picture.
fn shown(rendered: &Rendered) -> Picture {
    rendered.frame.picture().with_layers(&rendered.frame.layers())
}

fn whole(built: &BuiltScene) -> Rendered {
    bhs::render::render_quietly(built)
}

/// One run, on `threads` threads, that ends after `time`: from `from` on, if there is something. What it saves at its end.
fn run(built: &BuiltScene, from: Option<&[u8]>, threads: usize, time: Option<Duration>) -> (Vec<u8>, Rendered) {
    let mut state = RenderState::new(Job::of(built)).expect("there is memory");
    if let Some(saved) = from {
        checkpoint::read(saved, &Identity::of(built), false, &mut state).expect("it can be resumed");
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
    let limits = Limits { time, ..Limits::of(&*built.sampler) };
    let ended = pool.install(|| state.run(&limits, &Progress::hidden(), &Signals::default()));
    let mut saved = Vec::new();
    checkpoint::write(&mut saved, &Identity::of(built), &state).expect("memory can be written");
    (saved, state.rendered(ended))
}

/// Renders that differ in whatever a checkpoint has to hold.
fn kinds() -> Vec<(&'static str, BuiltScene)> {
    let rgb = format!("Film \"rgb\" {SMALL}");
    let spectral = format!("Film \"spectral\" {SMALL} {LAYERS}");
    let stratified = r#""stratified" "integer xsamples" 8 "integer ysamples" 8"#;
    let stars = "WorldBegin\nLightSource \"stars\" \"integer number\" 500 \"float scale\" 1e8";
    [
        ("plain", scene(&rgb, SOBOL, "")),
        ("stars", scene(&format!("{rgb} {LAYERS}"), SOBOL, "").replace("WorldBegin", stars)),
        ("layers", scene(&format!("{rgb} {LAYERS}"), SOBOL, "")),
        ("spectral film", scene(&spectral, r#""independent" "integer pixelsamples" 40"#, "")),
        ("adaptive", scene(&format!("{rgb} {LAYERS}"), r#""sobol" "float noise" 0.1 "integer pixelsamples" 200"#, "")),
        ("guiding", scene(&rgb, SOBOL, "\"bool guiding\" true")),
        ("stratified", scene(&rgb, stratified, "")),
    ]
    .map(|(name, text)| (name, common::build(&text)))
    .into()
}

#[test]
fn a_render_broken_off_many_times_ends_with_the_same_picture() {
    for (name, built) in kinds() {
        let expected = whole(&built);
        let (mut saved, mut rendered) = run(&built, None, 1, Some(Duration::from_millis(1)));
        let mut runs = 1;
        while rendered.ended != Ended::Complete {
            assert!(runs < 100_000, "{name}: it goes on");
            runs += 1;
            (saved, rendered) = run(&built, Some(&saved), 1 + runs % 3, Some(Duration::from_millis(10 * (runs as u64 % 3))));
        }
        assert!(runs > 2, "{name}: it was not broken off");
        assert!(shown(&rendered).same_channels(&shown(&expected)), "{name}, after {runs} runs");
        assert_eq!(rendered.counters, expected.counters, "{name}");
    }
}

#[test]
fn what_is_saved_while_threads_go_on_is_one_moment() {
    for (name, built) in kinds() {
        let expected = shown(&whole(&built));
        let state = RenderState::new(Job::of(&built)).expect("there is memory");
        let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().expect("threads start");
        let mut all = Vec::new();
        let done = std::sync::atomic::AtomicBool::new(false);
        std::thread::scope(|scope| {
            scope.spawn(|| {
                pool.install(|| state.run(&Limits::of(&*built.sampler), &Progress::hidden(), &Signals::default()));
                done.store(true, std::sync::atomic::Ordering::SeqCst);
            });
            while !done.load(std::sync::atomic::Ordering::SeqCst) {
                let mut saved = Vec::new();
                checkpoint::write(&mut saved, &Identity::of(&built), &state).expect("memory can be written");
                all.push(saved);
                std::thread::sleep(Duration::from_millis(5));
            }
        });
        assert!(shown(&state.rendered(Ended::Complete)).same_channels(&expected), "{name}: saving changes nothing");
        let step = all.len().div_ceil(6);
        for (i, saved) in all.iter().enumerate().step_by(step) {
            let (_, rendered) = run(&built, Some(saved), 2, None);
            assert!(shown(&rendered).same_channels(&expected), "{name}, {i} of {}", all.len());
        }
    }
}

/// A method that sees nothing, and has so much to learn before each wave but the first that it ends only if it is told to, or is given up.
struct Learner;

impl LightTransport for Learner {
    fn follow(&self, _: &Scene, path: &mut PathSample, _: &mut PathLog) {
        path.radiance = Default::default();
    }

    fn for_render(&self, _: &RenderSetting) -> Option<Box<dyn LightTransport>> {
        Some(Box::new(Self))
    }

    fn begin_wave(&mut self, setting: &RenderSetting, samples: Range<u32>) {
        let began = Instant::now();
        while samples.start > 0 && !(setting.is_stopped)() {
            assert!(began.elapsed() < Duration::from_secs(60), "it is told that time is over");
            std::thread::yield_now();
        }
    }
}

#[test]
fn what_is_learned_before_a_later_wave_is_left_off_when_time_is_over() {
    let built = common::build(&scene(&format!("Film \"rgb\" {SMALL}"), SOBOL, ""));
    let state = RenderState::new(Job { transport: &Learner, ..Job::of(&built) }).expect("there is memory");
    // Time enough for the first sample of a few pixels.
    let limits = Limits { time: Some(Duration::from_secs(5)), ..Limits::of(&*built.sampler) };
    let ended = state.run(&limits, &Progress::hidden(), &Signals::default());
    assert_eq!((ended, state.rendered(ended).samples), (Ended::TimeOver, 1));
}

#[test]
fn more_samples_give_the_picture_of_as_many() {
    // 37 ends within a wave, which is not learned from before it is whole.
    for transport in ["", "\"bool guiding\" true"] {
        let text = scene(&format!("Film \"rgb\" {SMALL} {LAYERS}"), SOBOL, transport);
        let with = |spp| common::build_with(&text, &Overrides { spp: Some(spp), ..Default::default() });
        let mut saved = None;
        for spp in [1, 3, 37, 64, 70] {
            let built = with(spp);
            let (bytes, rendered) = run(&built, saved.as_deref(), 2, None);
            assert!(shown(&rendered).same_channels(&shown(&whole(&built))), "{spp} samples {transport}");
            saved = Some(bytes);
        }
    }
}

fn refusal(built: &BuiltScene, saved: &[u8]) -> String {
    let mut state = RenderState::new(Job::of(built)).expect("there is memory");
    let fixed = built.sampler.depends_on_count();
    match checkpoint::read(saved, &Identity::of(built), fixed, &mut state) {
        Err(Refusal::Other(why)) => why,
        other => panic!("{other:?}"),
    }
}

#[test]
fn what_belongs_to_another_render_says_which_part_does() {
    let text = scene(&format!("Film \"rgb\" {SMALL}"), SOBOL, "");
    let built = common::build(&text);
    let (saved, _) = run(&built, None, 1, None);
    let with = |overrides| refusal(&common::build_with(&text, &overrides), &saved);
    assert!(with(Overrides { seed: Some(7), ..Default::default() }).contains("another seed: 0, not 7"));
    assert!(with(Overrides { resolution: Some([8, 8]), ..Default::default() }).contains("film resolution"));
    assert!(with(Overrides { crop: Some([0.0, 0.5, 0.0, 1.0]), ..Default::default() }).contains("film crop window"));
    assert!(with(Overrides { layers: vec!["depth".into()], ..Default::default() }).contains("film layers"));
    assert!(with(Overrides { transport: Some("normals".into()), ..Default::default() }).contains("light transport"));
    assert!(with(Overrides { integrator: Some("straight".into()), ..Default::default() }).contains("integrator"));
    assert!(refusal(&common::build(&text.replace("0.6", "0.7")), &saved).contains("another scene"));
    assert!(refusal(&common::build(&text.replace("\"rgb\" \"int", "\"spectral\" \"int")), &saved).contains("another scene"));
    // The version, as another program would have written it.
    let mut other = Vec::new();
    let identity = Identity::of(&built).to_json().replace(&format!("\"{}\"", env!("CARGO_PKG_VERSION")), "\"9.9.9\"");
    let identity = Identity::from_json(identity.as_bytes()).expect("JSON");
    checkpoint::write(&mut other, &identity, &RenderState::new(Job::of(&built)).expect("there is memory"))
        .expect("memory can be written");
    assert!(refusal(&built, &other).contains("version of bhs: 9.9.9"), "{}", refusal(&built, &other));
}

#[test]
fn the_scene_is_all_that_it_reads() {
    let folder = Folder::new("");
    let scene = |curve: &str| {
        folder.write("curve.spd", curve);
        let path = folder.path("curve.spd");
        common::build(&format!("WorldBegin\nLightSource \"infinite\" \"spectrum L\" \"{}\"", path.display())).hash
    };
    let hash = scene("400 1\n700 2\n");
    assert_eq!(hash.len(), 64);
    assert_eq!(hash, scene("400 1\n700 2\n"));
    assert_ne!(hash, scene("400 1\n700 3\n"));
}

#[test]
fn a_sampler_that_depends_on_their_number_says_that_it_cannot_go_on_to_more() {
    let film = format!("Film \"rgb\" {SMALL}");
    let text = scene(&film, "\"stratified\"", "");
    let with_spp = |spp| common::build_with(&text, &Overrides { spp: Some(spp), ..Default::default() });
    let (saved, _) = run(&with_spp(4), None, 1, None);
    let why = refusal(&with_spp(9), &saved);
    assert!(why.contains("sampler") && why.contains("from 4 to 9"), "{why}");
}

#[test]
fn nothing_that_is_damaged_is_taken_over() {
    let built = common::build(&scene(&format!("Film \"rgb\" {SMALL}"), SOBOL, "\"bool guiding\" true"));
    let (saved, _) = run(&built, None, 1, Some(Duration::from_millis(50)));
    let read = |bytes: &[u8]| {
        let mut state = RenderState::new(Job::of(&built)).expect("there is memory");
        checkpoint::read(bytes, &Identity::of(&built), false, &mut state)
    };
    assert_eq!(read(&saved), Ok(()));
    for i in 0..200 {
        let at = i * saved.len() / 200;
        assert!(matches!(read(&saved[..at]), Err(Refusal::Damaged(_))), "cut at {at}");
        let mut flipped = saved.clone();
        flipped[at] ^= 0x10;
        // The version of the format is named as such.
        assert!(matches!(read(&flipped), Err(Refusal::Damaged(_) | Refusal::Other(_))), "flipped at {at}");
    }
}

/// The options and the world of [`Folder`]s for the program itself.
fn program_scene() -> String {
    scene(&format!("Film \"rgb\" {SMALL} \"string filename\" \"a.exr\" {LAYERS}"), SOBOL, "\"bool guiding\" true")
}

#[test]
fn the_program_resumes_what_was_killed() {
    let folder = Folder::new(&program_scene());
    assert_eq!(folder.run(&["render", "scene.bhs", "-o", "whole.exr", "--spp", "600"]).0, 0);
    let mut child = folder.start(&["render", "scene.bhs", "--spp", "600", "--checkpoint", "--checkpoint-every", "0.1"]);
    child.wait_for(&folder.path("a.checkpoint"));
    child.kill();
    let (code, err) = folder.run(&["render", "scene.bhs", "--spp", "600", "--resume", "--threads", "3"]);
    assert_eq!(code, 0, "{err}");
    folder.assert_same("whole", "a");
    // Once more: it is finished, and nothing is written.
    let modified = |name: &str| std::fs::metadata(folder.path(name)).and_then(|m| m.modified()).expect("it is there");
    let before = ["a.exr", "a.png", "a.checkpoint"].map(modified);
    let (code, err) = folder.run(&["render", "scene.bhs", "--spp", "600", "--resume"]);
    assert!(code == 0 && err.contains("finished"), "{err}");
    assert_eq!(["a.exr", "a.png", "a.checkpoint"].map(modified), before);
    // Unless a picture is gone.
    std::fs::remove_file(folder.path("a.png")).expect("it was there");
    assert_eq!(folder.run(&["render", "scene.bhs", "--spp", "600", "--resume"]).0, 0);
    folder.assert_same("whole", "a");
}

#[test]
fn the_program_refuses_what_is_of_another_render_and_harms_nothing() {
    let folder = Folder::new(&program_scene());
    assert_eq!(folder.run(&["render", "scene.bhs", "--spp", "8", "--checkpoint=state"]).0, 0);
    let before = ["a.exr", "a.png", "state"].map(|name| std::fs::read(folder.path(name)).expect("it is there"));
    for (args, word) in
        [(&["--seed", "5"][..], "seed"), (&["--resolution", "8x8"], "film"), (&["--transport", "normals"], "transport")]
    {
        let (code, err) = folder.run(&[&["render", "scene.bhs", "--spp", "8", "--checkpoint=state", "--resume"], args].concat());
        assert!(code == 1 && err.contains(word) && err.contains("state"), "{err}");
    }
    let after = ["a.exr", "a.png", "state"].map(|name| std::fs::read(folder.path(name)).expect("it is there"));
    assert!(before == after);
}

#[test]
fn a_damaged_checkpoint_gives_way_to_the_one_before() {
    let folder = Folder::new(&program_scene());
    assert_eq!(folder.run(&["render", "scene.bhs", "-o", "whole.exr"]).0, 0);
    for spp in ["20", "40"] {
        assert_eq!(folder.run(&["render", "scene.bhs", "--resume", "--spp", spp]).0, 0);
    }
    let mut bytes = std::fs::read(folder.path("a.checkpoint")).expect("it is there");
    bytes.truncate(bytes.len() / 2);
    folder.write("a.checkpoint", &bytes);
    let (code, err) = folder.run(&["render", "scene.bhs", "--resume"]);
    assert!(code == 0 && err.contains("damaged"), "{err}");
    folder.assert_same("whole", "a");
    // Without one before it, that is an error, and says what to do.
    folder.write("a.checkpoint", b"nothing");
    folder.write("a.previous.checkpoint", b"nothing");
    let (code, err) = folder.run(&["render", "scene.bhs", "--resume"]);
    assert!(code == 1 && err.contains("a.checkpoint") && err.contains("delete"), "{err}");
}

#[test]
fn every_camera_has_a_checkpoint_of_its_own() {
    let text = program_scene().replace(
        "Camera \"perspective\" \"float fov\" 45",
        "Camera \"perspective\" \"float fov\" 45 \"string name\" \"near\"\nCamera \"perspective\" \"float fov\" 60 \"string name\" \"wide\"",
    );
    let folder = Folder::new(&text);
    assert_eq!(folder.run(&["render", "scene.bhs", "-o", "whole.exr", "--spp", "300"]).0, 0);
    let mut child = folder.start(&["render", "scene.bhs", "--spp", "300", "--checkpoint", "--checkpoint-every", "0.1"]);
    child.wait_for(&folder.path("a.wide.checkpoint"));
    child.kill();
    let (code, err) = folder.run(&["render", "scene.bhs", "--spp", "300", "--resume"]);
    assert!(code == 0 && err.contains("`a.near.checkpoint` is finished"), "{err}");
    folder.assert_same("whole.near", "a.near");
    folder.assert_same("whole.wide", "a.wide");
}

#[test]
fn time_ends_a_render_with_the_samples_that_it_has() {
    let folder = Folder::new(&program_scene());
    let args = ["render", "scene.bhs", "--spp", "1000000000", "--time", "0.3", "--checkpoint"];
    let (code, err) = folder.run(&args);
    assert!(code == 0 && err.contains("time is over"), "{err}");
    assert_eq!(folder.header("a.exr", "bhs:stopped"), "time");
    // At least so many, however short the time; at most those of --spp.
    assert_eq!(folder.run(&["render", "scene.bhs", "-o", "b.exr", "--time", "0", "--min-spp", "5"]).0, 0);
    assert_eq!(folder.header("b.exr", "bhs:spp"), "5");
    assert_eq!(folder.run(&["render", "scene.bhs", "-o", "five.exr", "--spp", "5"]).0, 0);
    assert_eq!(folder.header("five.exr", "bhs:stopped"), "complete");
    assert_eq!(
        (folder.header("five.exr", "bhs:firstSample"), folder.header("five.exr", "bhs:lastSample")),
        ("0".into(), "4".into())
    );
    folder.assert_same("five", "b");
    // What time has ended can be resumed.
    assert_eq!(folder.run(&["render", "scene.bhs", "-o", "c.exr", "--time", "0", "--min-spp", "5", "--checkpoint"]).0, 0);
    assert_eq!(folder.run(&["render", "scene.bhs", "-o", "c.exr", "--resume"]).0, 0);
    assert_eq!(folder.run(&["render", "scene.bhs", "-o", "whole.exr"]).0, 0);
    folder.assert_same("whole", "c");
}

#[test]
fn partial_pictures_come_with_checkpoints() {
    let folder = Folder::new(&program_scene());
    let args = ["render", "scene.bhs", "--spp", "1000000000", "--checkpoint-every", "0.1", "--write-partial"];
    let mut child = folder.start(&args);
    child.wait_for(&folder.path("a.exr"));
    child.kill();
    assert_eq!(folder.header("a.exr", "bhs:stopped"), "underway");
    Picture::read_exr(&folder.path("a.exr")).expect("a whole picture");
    // No checkpoint was asked for.
    assert!(files(&folder.path("")).iter().all(|f| !f.ends_with(".checkpoint")));
}
