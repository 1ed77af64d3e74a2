//! Parts of pictures: any split adds up to the very bytes of the whole, and whatever is wrong with parts is named.

mod files;
mod many;

use crate::common;
use crate::common::process::{Folder, files};
use crate::common::room::{CAMERA, room};
use bhs::image::Picture;
use bhs::lang::BuiltScene;
use bhs::parts::file::{self, PartHead};
use bhs::parts::join::{self, Sorted};
use bhs::parts::{Cover, Windowed, joined};
use bhs::progress::Progress;
use bhs::render::{Ended, Job, Limits, RenderState, Rendered};
use bhs::signals::Signals;
use std::fs::File;
use std::path::{Path, PathBuf};

const FILM: &str = r#"Film "rgb" "integer xresolution" 37 "integer yresolution" 21 "float bloom" 0.5 "string filename" "a.exr""#;
const LAYERS: &str = r#""string layers" ["normal" "variance" "sweptangle"]"#;

/// The room with stars behind it, seen by the given cameras.
fn scene(film: &str, samples: &str, cameras: &str) -> String {
    let options = format!("{film}\nSampler {samples}\nPixelFilter \"mitchell\"");
    room(&options, cameras, "LightSource \"stars\" \"integer number\" 300 \"float scale\" 1e8")
}

const SOBOL: &str = r#""sobol" "integer pixelsamples" 11"#;

struct Random(u64);

impl Random {
    fn below(&mut self, n: u32) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 33) % u64::from(n)) as u32
    }
}

/// A whole cut at random, up to so many times, by columns, rows and samples; the pieces in a random order.
fn split(whole: Cover, cuts: u32, random: &mut Random) -> Vec<Cover> {
    let mut pieces = vec![whole];
    for _ in 0..cuts {
        let i = random.below(pieces.len() as u32) as usize;
        let Cover { window: [x0, x1, y0, y1], samples } = pieces[i];
        let mut sides = [[x0, x1], [y0, y1], samples];
        let side = random.below(3) as usize;
        let [from, to] = sides[side];
        if to - from < 2 {
            continue;
        }
        let at = from + 1 + random.below(to - from - 1);
        let mut piece = |range: [u32; 2]| {
            sides[side] = range;
            Cover { window: [sides[0][0], sides[0][1], sides[1][0], sides[1][1]], samples: sides[2] }
        };
        let (one, other) = (piece([from, at]), piece([at, to]));
        pieces[i] = one;
        pieces.insert(random.below(pieces.len() as u32 + 1) as usize, other);
    }
    pieces
}

/// Renders a part.
fn render(built: &BuiltScene, cover: Cover) -> Rendered {
    let film = Windowed::new(&*built.film, cover.window);
    let job = Job { film: &film, first_sample: cover.samples[0], ..Job::of(built) };
    let state = RenderState::new(job).expect("there is memory");
    let limits = Limits { most: cover.samples[1], ..Limits::of(&*built.sampler) };
    let ended = state.run(&limits, &Progress::hidden(), &Signals::default());
    state.rendered(ended)
}

/// Renders parts into files of a folder.
fn write(built: &BuiltScene, covers: &[Cover], folder: &Path) -> Vec<PathBuf> {
    let one = |(i, cover): (usize, &Cover)| {
        let path = folder.join(format!("{i}.bhspart"));
        let to = std::io::BufWriter::new(File::create(&path).expect("the folder can be written"));
        file::write(to, &PartHead::of(built, *cover, None), &render(built, *cover)).expect("it can be written");
        path
    };
    covers.iter().enumerate().map(one).collect()
}

fn open(path: &Path) -> Result<File, String> {
    File::open(path).map_err(|e| e.to_string())
}

/// Everything that a file could show of a picture.
fn shown(rendered: &Rendered) -> Picture {
    rendered.frame.picture().with_layers(&rendered.frame.layers())
}

#[test]
fn five_hundred_random_splits_add_up_to_the_bytes_of_the_whole() {
    let spectral = FILM.replace("rgb", "spectral");
    let kinds = [
        ("layers", scene(&format!("{FILM} {LAYERS}"), SOBOL, CAMERA)),
        ("spectral", scene(&format!("{spectral} {LAYERS}"), r#""independent" "integer pixelsamples" 11"#, CAMERA)),
        ("plain", scene(FILM, r#""stratified" "integer xsamples" 4 "integer ysamples" 3"#, CAMERA)),
        ("window", scene(&format!("{FILM} \"float cropwindow\" [0.2 0.9 0.1 0.8]"), SOBOL, CAMERA)),
        ("limited", scene(&format!("{FILM} \"float maxcomponentvalue\" 0.5"), SOBOL, CAMERA)),
    ];
    let mut random = Random(18);
    let mut most = 0;
    for (name, text) in kinds {
        let built = common::build(&text);
        let expected = common::render(&built);
        assert!(expected.frame.points().is_some_and(|p| p.counters.images > 20), "{name}: there are stars");
        let whole = Cover::whole(&*built.film, built.sampler.samples_per_pixel());
        for i in 0..100 {
            let cuts = 1 + random.below(if i % 25 == 0 { 64 } else { 8 });
            let covers = split(whole, cuts, &mut random);
            most = most.max(covers.len());
            let folder = tempfile::tempdir().expect("a temporary folder");
            let paths = write(&built, &covers, folder.path());
            let Sorted { pictures, refused } = join::sort(&paths, open);
            assert!(refused.is_empty() && pictures.len() == 1, "{name}: {refused:?}");
            assert!(pictures[0].missing.is_empty(), "{name} {covers:?}");
            let (joined, _) = joined::join(&pictures[0], open).expect("they can be joined");
            assert!(shown(&joined).same_channels(&shown(&expected)), "{name} {covers:?}");
            assert_eq!(joined.counters, expected.counters, "{name}");
            assert_eq!((joined.samples, joined.ended), (expected.samples, Ended::Complete));
        }
    }
    assert!(most > 40, "{most} parts at most");
}

#[test]
fn what_is_learned_of_the_light_is_the_same_for_parts_of_a_picture() {
    let guided = scene(FILM, r#""sobol" "integer pixelsamples" 20"#, CAMERA)
        .replace("WorldBegin", "LightTransport \"path\" \"bool guiding\" true\nWorldBegin");
    let built = common::build(&guided);
    let expected = common::render(&built);
    let unguided = common::render(&common::build(&guided.replace("\"bool guiding\" true", "\"bool guiding\" false")));
    assert!(!shown(&unguided).same_channels(&shown(&expected)), "directions are guided");
    let whole = Cover::whole(&*built.film, built.sampler.samples_per_pixel());
    let mut random = Random(7);
    for _ in 0..3 {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let paths = write(&built, &split(whole, 4, &mut random), folder.path());
        let Sorted { pictures, refused } = join::sort(&paths, open);
        assert!(refused.is_empty(), "{refused:?}");
        let (joined, _) = joined::join(&pictures[0], open).expect("they can be joined");
        assert!(shown(&joined).same_channels(&shown(&expected)));
    }
}

/// A folder with the scene, its picture `whole.exr`, and parts `1.bhspart` to `5.bhspart` of the program.
fn with_parts() -> Folder {
    let folder = Folder::new(&scene(&format!("{FILM} {LAYERS}"), SOBOL, CAMERA));
    assert_eq!(folder.run(&["render", "scene.bhs", "-o", "whole.exr"]).0, 0);
    for k in 1..=5 {
        let (code, err) = folder.run(&["render", "scene.bhs", "--part", &format!("{k}/5"), "-o", &format!("{k}.bhspart")]);
        assert_eq!(code, 0, "{err}");
    }
    folder
}

const FIVE: [&str; 5] = ["1.bhspart", "2.bhspart", "3.bhspart", "4.bhspart", "5.bhspart"];

fn merge(folder: &Folder, parts: &[&str], flags: &[&str]) -> (i32, String) {
    folder.run(&[&["merge", "-o", "m.exr"], parts, flags].concat())
}

#[test]
fn the_program_joins_what_it_has_rendered() {
    let folder = with_parts();
    assert!(files(&folder.path("")).iter().all(|name| !name.contains("checkpoint") && !name.contains("bhspart.")));
    let (code, err) = merge(&folder, &FIVE, &[]);
    assert!(code == 0 && err.contains("11 spp from 5 parts"), "{err}");
    folder.assert_same("whole", "m");
    // But for what depends on the moment the header is the same.
    for name in ["bhs:scene", "bhs:stopped", "bhs:spp", "bhs:lastSample", "bhs:queriesPerGeodesic", "bhs:seed", "bhs:version"] {
        assert_eq!(folder.header("m.exr", name), folder.header("whole.exr", name), "{name}");
    }
    // By samples and windows, in another order.
    let mut parts = Vec::new();
    for (i, (samples, crop)) in
        [("0..4", "0,1,0,0.5"), ("4..11", "0,1,0,1"), ("0..4", "0,0.3,0.5,1"), ("0..4", "0.3,1,0.5,1")].iter().enumerate()
    {
        parts.push(format!("w{i}.bhspart"));
        let args = ["render", "scene.bhs", "--samples", samples, "--crop", crop, "-o", &parts[i], "--threads", "1"];
        assert_eq!(folder.run(&args).0, 0);
    }
    let parts: Vec<&str> = parts.iter().rev().map(String::as_str).collect();
    let (code, err) = folder.run(&[&["merge", "-o", "w.exr", "--quiet"], &parts[..]].concat());
    assert!(code == 0 && err.is_empty(), "{err}");
    folder.assert_same("whole", "w");
    // With more parts than samples.
    let many: Vec<String> = (1..=13).map(|k| format!("many{k}.bhspart")).collect();
    for (k, name) in (1..).zip(&many) {
        assert_eq!(folder.run(&["render", "scene.bhs", "--part", &format!("{k}/13"), "-o", name]).0, 0);
    }
    let many: Vec<&str> = many.iter().map(String::as_str).collect();
    assert_eq!(folder.run(&[&["merge", "-o", "many.exr"], &many[..]].concat()).0, 0);
    folder.assert_same("whole", "many");
}

#[test]
fn what_is_wrong_with_parts_is_named_and_nothing_is_written() {
    let folder = with_parts();
    let bytes = std::fs::read(folder.path("3.bhspart")).expect("it is there");
    folder.write("short.bhspart", &bytes[..bytes.len() * 2 / 3]);
    let mut flipped = bytes.clone();
    flipped[bytes.len() / 2] ^= 4;
    folder.write("flipped.bhspart", &flipped);
    folder.write("longer.bhspart", [&bytes[..], b"x"].concat());
    folder.write("nothing.bhspart", b"");
    folder.write("text.bhspart", b"This is a text.");
    folder.write("other.bhs", scene(&format!("{FILM} {LAYERS}"), SOBOL, CAMERA).replace("0.6", "0.7"));
    for (scene, flags, name) in [
        ("scene.bhs", &["--seed", "7"][..], "seed"),
        ("other.bhs", &[], "other"),
        ("scene.bhs", &["--spp", "12"], "spp"),
        ("scene.bhs", &["--resolution", "30x20"], "film"),
        ("scene.bhs", &["--aov", "depth"], "aov"),
    ] {
        let output = format!("{name}.bhspart");
        let (code, err) = folder.run(&[&["render", scene, "--samples", "4..6", "-o", &output], flags].concat());
        assert_eq!(code, 0, "{err}");
    }
    assert_eq!(folder.run(&["render", "scene.bhs", "--samples", "3..5", "-o", "doubled.bhspart"]).0, 0);
    let four = ["1.bhspart", "2.bhspart", "4.bhspart", "5.bhspart"];
    // Without the third, and with something in its place.
    for (file, words) in [
        (None, &["missing", "samples 4..6"][..]),
        (Some("short.bhspart"), &["short.bhspart", "cut short", "missing"]),
        (Some("flipped.bhspart"), &["flipped.bhspart", "damaged"]),
        (Some("longer.bhspart"), &["longer.bhspart", "damaged"]),
        (Some("nothing.bhspart"), &["nothing.bhspart", "cut short"]),
        (Some("text.bhspart"), &["text.bhspart", "no part of a picture"]),
        (Some("gone.bhspart"), &["gone.bhspart", "cannot read"]),
        (Some("seed.bhspart"), &["seed.bhspart", "seed: 7, not 0"]),
        (Some("other.bhspart"), &["other.bhspart", "another scene"]),
        (Some("spp.bhspart"), &["spp.bhspart", "samples a pixel: 12, not 11"]),
        (Some("film.bhspart"), &["film.bhspart", "film resolution"]),
        (Some("aov.bhspart"), &["aov.bhspart", "film layers"]),
        (Some("2.bhspart"), &["2.bhspart", "twice"]),
        (Some("doubled.bhspart"), &["doubled.bhspart", "doubled", "samples 3..4"]),
    ] {
        let parts: Vec<&str> = four.into_iter().chain(file).collect();
        let (code, err) = merge(&folder, &parts, &[]);
        assert!(code == 1 && words.iter().all(|word| err.contains(word)), "{file:?}: {err}");
        assert!(!folder.path("m.exr").exists() && !folder.path("m.png").exists(), "{file:?}: nothing is written");
        let (code, err) = merge(&folder, &parts, &["--partial"]);
        assert!(code == 0 && words.iter().all(|word| err.contains(word)), "{file:?}: {err}");
        assert_eq!(folder.header("m.exr", "bhs:stopped"), "underway");
        // The first two parts have samples 0 to 4, the last two 6 to 11; `doubled` comes last.
        assert_eq!(folder.header("m.exr", "bhs:spp"), "9", "{file:?}");
        std::fs::remove_file(folder.path("m.exr")).expect("it is there");
        std::fs::remove_file(folder.path("m.png")).expect("it is there");
    }
    // A part that is there is not in the way of one that is too much.
    let (code, err) = merge(&folder, &[&FIVE[..], &["seed.bhspart"]].concat(), &[]);
    assert!(code == 1 && err.contains("seed") && !err.contains("missing"), "{err}");
    // Not over a part, nor beside the point.
    let (code, err) = folder.run(&[&["merge", "-o", "1.bhspart"], &FIVE[..]].concat());
    assert!(code == 1 && err.contains(".exr"), "{err}");
    folder.write("linked.exr", &bytes);
    let (code, err) = folder.run(&["merge", "-o", "linked.exr", "linked.exr", "--partial"]);
    assert!(code == 1 && err.contains("a part"), "{err}");
    assert_eq!(std::fs::read(folder.path("linked.exr")).expect("it is there"), bytes);
    assert_eq!(merge(&folder, &["text.bhspart"], &["--partial"]).0, 1, "there is nothing to join");
}

#[test]
fn missing_windows_are_named() {
    let folder = Folder::new(&scene(FILM, SOBOL, CAMERA));
    for (name, samples, crop) in [("a", "0..11", "0,0.5,0,1"), ("b", "2..11", "0.5,1,0,1")] {
        let output = format!("{name}.bhspart");
        assert_eq!(folder.run(&["render", "scene.bhs", "--samples", samples, "--crop", crop, "-o", &output]).0, 0);
    }
    let (code, err) = merge(&folder, &["a.bhspart", "b.bhspart"], &[]);
    assert!(code == 1 && err.contains("missing: samples 0..2 of the window x 19..37, y 0..21"), "{err}");
}

#[test]
fn frames_and_cameras_have_parts_of_their_own() {
    let cameras = "Camera \"perspective\" \"float fov\" 45 \"string name\" \"near\"\nCamera \"perspective\" \"float fov\" 60 \"string name\" \"wide\"";
    let text = scene(FILM, SOBOL, cameras).replace("Translate 1 1 1.5", "Translate $frame 1 1.5");
    let folder = Folder::new(&text);
    assert_eq!(folder.run(&["render", "scene.bhs", "--frames", "1-2", "-o", "whole.exr"]).0, 0);
    for k in ["1/3", "2/3", "3/3"] {
        let output = format!("p{}.bhspart", &k[..1]);
        let (code, err) = folder.run(&["render", "scene.bhs", "--frames", "1-2", "--part", k, "-o", &output]);
        assert_eq!(code, 0, "{err}");
    }
    let parts: Vec<String> = files(&folder.path("")).into_iter().filter(|name| name.ends_with(".bhspart")).collect();
    assert_eq!(parts.len(), 12);
    assert!(parts.contains(&"p2.wide.0001.bhspart".to_owned()), "{parts:?}");
    let all: Vec<&str> = parts.iter().map(String::as_str).collect();
    let (code, err) = merge(&folder, &all, &[]);
    assert_eq!(code, 0, "{err}");
    for picture in ["near.0001", "near.0002", "wide.0001", "wide.0002"] {
        folder.assert_same(&format!("whole.{picture}"), &format!("m.{picture}"));
    }
    // One of them alone has the name that it is given.
    let one: Vec<&str> = all.iter().copied().filter(|name| name.contains("wide.0002")).collect();
    assert_eq!(folder.run(&[&["merge", "-o", "one.exr"], &one[..]].concat()).0, 0);
    folder.assert_same("whole.wide.0002", "one");
    // What is missing of one of several.
    let (code, err) = merge(&folder, &all[1..], &[]);
    assert!(code == 1 && err.contains("missing: of frame 1, camera `near`"), "{err}");
}

#[test]
fn what_does_not_split_says_so() {
    let folder = Folder::new(&scene(FILM, SOBOL, CAMERA));
    for (flags, word) in [
        (&["--time", "1"][..], "does not split"),
        (&["--write-partial"], "--checkpoint"),
        (&["--false-color"], "merge"),
        (&["--display-server"], "shows pictures"),
    ] {
        let (code, err) = folder.run(&[&["render", "scene.bhs", "--samples", "0..2"], flags].concat());
        assert!(code == 2 && err.contains(word), "{err}");
    }
    for (args, word) in [(["--samples", "0..12"], "beyond"), (["--part", "1/99999"], "none"), (["-o", "a.exr"], ".bhspart")] {
        let folder = Folder::new(&scene(FILM, SOBOL, CAMERA));
        let part: &[&str] = if args[0] == "-o" { &["--part", "1/2"] } else { &[] };
        let (code, err) = folder.run(&[&["render", "scene.bhs"], part, &args[..]].concat());
        assert!(code == 1 && err.contains(word), "{err}");
        assert_eq!(files(&folder.path("")), ["scene.bhs"]);
    }
}

#[test]
fn parts_have_names_of_their_own() {
    let folder = Folder::new(&scene(FILM, SOBOL, CAMERA));
    assert_eq!(folder.run(&["render", "scene.bhs", "--part", "2/11"]).0, 0);
    assert_eq!(folder.run(&["render", "scene.bhs", "--samples", "0..1"]).0, 0);
    assert_eq!(folder.run(&["render", "scene.bhs", "--samples", "0..1", "--crop", "0,0.5,0,1"]).0, 0);
    let names = ["a.part-02-of-11.bhspart", "a.samples-0-1-crop-0-0.5-0-1.bhspart", "a.samples-0-1.bhspart", "scene.bhs"];
    assert_eq!(files(&folder.path("")), names);
}

#[cfg(unix)]
#[test]
fn a_part_that_is_stopped_goes_on_where_it_was() {
    let folder = Folder::new(&scene(FILM, r#""sobol" "integer pixelsamples" 6000"#, CAMERA));
    let args = |range| ["render", "scene.bhs", "--samples", range, "-o", "b.bhspart", "--resume", "--checkpoint-every", "0.1"];
    let mut child = folder.start(&args("5..5900"));
    child.wait_for(&folder.path("b.bhspart.checkpoint"));
    child.signal("TERM");
    assert_eq!(child.wait(), Some(75), "try again");
    assert!(folder.path("b.bhspart.checkpoint").exists() && !folder.path("b.bhspart").exists());
    // Another part does not go on from it.
    let (code, err) = folder.run(&args("6..5900"));
    assert!(code == 1 && err.contains("first sample"), "{err}");
    let (code, err) = folder.run(&args("5..5900"));
    assert!(code == 0 && err.contains("going on from"), "{err}");
    assert!(files(&folder.path("")).iter().all(|name| !name.contains("checkpoint")));
    let (code, err) = folder.run(&args("5..5900"));
    assert!(code == 0 && err.contains("there already"), "{err}");
    for (range, name) in [("0..5", "a.bhspart"), ("5900..6000", "c.bhspart")] {
        assert_eq!(folder.run(&["render", "scene.bhs", "--samples", range, "-o", name]).0, 0);
    }
    assert_eq!(merge(&folder, &["a.bhspart", "b.bhspart", "c.bhspart"], &[]).0, 0);
    assert_eq!(folder.run(&["render", "scene.bhs", "-o", "whole.exr"]).0, 0);
    folder.assert_same("whole", "m");
}

#[cfg(unix)]
#[test]
fn a_user_signal_saves_the_state_of_a_part_and_writes_no_picture_in_its_place() {
    let folder = Folder::new(&scene(FILM, r#""sobol" "integer pixelsamples" 100000000"#, CAMERA));
    let part = ["render", "scene.bhs", "--part", "1/2", "-o", "b.bhspart"];
    for flags in [&["--checkpoint", "--checkpoint-every", "100000"][..], &[]] {
        let mut child = folder.start(&[&part[..], flags].concat());
        while !child.handles("TERM") {
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
        // Until there is a sample, and for the one before it once more.
        while !folder.path("b.bhspart.previous.checkpoint").exists() {
            assert!(!child.has_ended());
            child.signal("USR1");
            std::thread::sleep(std::time::Duration::from_millis(100));
        }
        child.signal("TERM");
        assert_eq!(child.wait(), Some(75));
        assert!(!folder.path("b.bhspart").exists() && folder.path("b.bhspart.checkpoint").exists());
        assert!(!folder.path("b.png").exists());
        std::fs::remove_file(folder.path("b.bhspart.checkpoint")).expect("it is there");
        std::fs::remove_file(folder.path("b.bhspart.previous.checkpoint")).expect("it is there");
    }
}
