//! Animations: frames are what single renders make of the same numbers, and none of them destroys or repeats anything.

use crate::common;
use crate::common::examples::{blocks, build_all};
use crate::common::process;
use crate::common::program::Folder;
use bhs::animation::keys::Keys;
use bhs::cli::Cli;
use bhs::lang::source::FileCache;
use bhs::lang::{self, Overrides, SourceMap};
use bhs::registry::Registry;
use clap::Parser;
use image::AnimationDecoder;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::PathBuf;
use std::sync::Arc;

/// A sphere that moves with `$x`, grows with `$frame` and turns grey with `$time`.
const MOVING: &str = r#"
Define "x" 9
Film "rgb" "integer xresolution" 12 "integer yresolution" 8 "string filename" "film.exr"
Sampler "sobol" "integer pixelsamples" 4
Camera "perspective"
WorldBegin
LightSource "infinite"
Translate $x 0 5
Material "diffuse" "rgb reflectance" [0.5 $time 0.5]
Shape "sphere" "float radius" 0.5 "float phimax" 360
Translate 0 0 $frame
Shape "sphere"
"#;

const KEYS: &str = "frame,x\n2,-1\n4,1\n";

fn moving() -> Folder {
    let folder = Folder::new(MOVING);
    folder.write("keys.csv", KEYS);
    folder
}

#[test]
fn the_page_on_animations_shows_what_works() {
    let page = common::read("docs/animations.md");
    build_all("docs/animations.md", &page);
    let table = blocks(&page, "csv");
    assert!(table.len() == 1 && Keys::parse(table[0], 0).is_ok(), "{table:?}");
    let lines: Vec<&str> = page.lines().filter_map(|line| line.strip_prefix("$ ")).collect();
    assert!(lines.len() >= 4);
    for line in &lines {
        Cli::try_parse_from(line.split_whitespace()).unwrap_or_else(|e| panic!("{line}\n{e}"));
    }
    // The first animation, small.
    let folder = Folder::new("");
    folder.write("orbit.bhs", blocks(&page, "bhs")[0]);
    folder.write("orbit.csv", table[0]);
    let line = lines.iter().find(|line| line.contains("--frames")).expect("there is one");
    let args: Vec<&str> = line.split_whitespace().skip(1).chain(["--resolution", "16x9", "--spp", "1"]).collect();
    let said = done(&folder, &args);
    assert!(folder.files().contains(&"orbit.0060.png".to_owned()) && folder.files().contains(&"orbit.gif".to_owned()), "{said}");
    let last = said.lines().last().expect("it says something");
    assert!(last.contains("ffmpeg") && last.contains("'orbit.%04d.png'") && last.contains("'orbit.mp4'"), "{last}");
}

/// Runs a command that has to succeed.
fn done(folder: &Folder, args: &[&str]) -> String {
    let run = folder.run(args);
    assert_eq!(run.code, 0, "{args:?}: {}", run.err);
    run.err
}

/// That two pictures are the same, to the last bit.
fn assert_same(folder: &Folder, a: &str, b: &str) {
    let name = |stem: &str| format!("{stem}.exr");
    let compared = folder.run(&["compare", &name(a), &name(b), "--json"]);
    assert!(compared.out.contains("\"mse\": 0.0"), "{a}, {b}: {}{}", compared.out, compared.err);
    assert_eq!(folder.read(&format!("{a}.png")), folder.read(&format!("{b}.png")), "{a}, {b}");
}

#[test]
fn a_frame_is_the_single_picture_of_its_numbers() {
    let folder = moving();
    let said = done(&folder, &["render", "scene.bhs", "--frames", "2-6:2", "--keys", "keys.csv", "--fps", "10", "--seed", "7"]);
    assert!(said.contains("ffmpeg -framerate 5 "), "{said}");
    let numbers = [(2, "-1", "0.2"), (4, "1", "0.4"), (6, "1", "0.6")];
    for (frame, x, time) in numbers {
        let text = MOVING.replace("$x", x).replace("$time", time).replace("$frame", &frame.to_string());
        folder.write("single.bhs", text);
        done(&folder, &["render", "single.bhs", "--seed", "7", "-o", "single.exr", "--quiet"]);
        assert_same(&folder, &format!("film.{frame:04}"), "single");
        // Or given on the command line, where the command line wins over keys, and keys over the scene.
        let given = [format!("x={x}"), format!("frame={frame}"), format!("time={time}")];
        let mut args = vec!["render", "scene.bhs", "--seed", "7", "-o", "given.exr", "--quiet"];
        given.iter().for_each(|g| args.extend(["-D", g]));
        done(&folder, &args);
        assert_same(&folder, "given", "single");
    }
    let args = ["render", "scene.bhs", "--frames", "2", "--keys", "keys.csv", "-D", "x=0.5", "--seed", "7", "-o", "won.exr"];
    done(&folder, &args);
    folder
        .write("single.bhs", MOVING.replace("$x", "0.5").replace("$time", &(2.0_f64 / 24.0).to_string()).replace("$frame", "2"));
    done(&folder, &["render", "single.bhs", "--seed", "7", "-o", "single.exr"]);
    assert_same(&folder, "won.0002", "single");
}

#[test]
fn frames_have_seeds_of_their_own_unless_one_is_given() {
    let still = Folder::new(&MOVING.replace("$x", "0").replace("$time", "0.5").replace("$frame", "1"));
    done(&still, &["render", "scene.bhs", "--frames", "1-3", "--threads", "1"]);
    assert_ne!(still.read("film.0001.png"), still.read("film.0002.png"));
    // The same frame is the same picture, whatever is rendered before it and by how many threads.
    done(&still, &["render", "scene.bhs", "--frames", "2", "-o", "alone.exr", "--threads", "2"]);
    assert_same(&still, "film.0002", "alone.0002");
    done(&still, &["render", "scene.bhs", "--frames", "1-2", "--seed", "5", "-o", "seed.exr"]);
    assert_same(&still, "seed.0001", "seed.0002");
    done(&still, &["render", "scene.bhs", "--seed", "5", "-o", "single.exr"]);
    assert_same(&still, "seed.0001", "single");
}

#[test]
fn files_are_numbered_for_every_camera_and_layer_and_those_that_are_there_stay() {
    let cameras = MOVING.replace(
        "Camera \"perspective\"",
        "Camera \"perspective\" \"string name\" \"left\"\nLookAt 1 0 0 0 0 5 0 1 0 Camera \"perspective\" \"string name\" \"right\"",
    );
    let folder = Folder::new(&cameras);
    let args =
        ["render", "scene.bhs", "--frames", "8-12:4", "-o", "a.exr", "--stats", "s.json", "--aov", "depth", "--false-color"];
    done(&folder, &args);
    let mut expected = vec!["scene.bhs".to_owned()];
    for camera in ["left", "right"] {
        for frame in ["0008", "0012"] {
            expected.extend(["exr", "png", "depth.png"].map(|ending| format!("a.{camera}.{frame}.{ending}")));
            expected.push(format!("s.{camera}.{frame}.json"));
        }
    }
    expected.sort();
    assert_eq!(folder.files(), expected);
    let stats: serde_json::Value = serde_json::from_slice(&folder.read("s.left.0012.json")).expect("JSON");
    assert_eq!((&stats["variables"]["frame"], &stats["variables"]["time"]), (&12.0.into(), &0.5.into()));
    // One is gone: that frame is rendered again, the other is not touched.
    let before = folder.read("a.left.0008.exr");
    std::fs::remove_file(folder.at("a.right.0012.png")).expect("it is there");
    let said = done(&folder, &[&args[..], &["--skip-existing"]].concat());
    assert!(said.contains("left as they are: frames 8\n"), "{said}");
    assert_eq!((folder.files(), folder.read("a.left.0008.exr")), (expected, before));
    let refused = folder.run(&[&args[..], &["--no-overwrite"]].concat());
    assert!(refused.code == 1 && refused.err.contains("a.left.0008.exr"), "{}", refused.err);
}

#[test]
fn no_frame_takes_the_place_of_what_is_read() {
    let folder = moving();
    let picture = image::RgbImage::from_pixel(4, 2, image::Rgb([200, 100, 50]));
    picture.save(folder.at("film.0003.png")).expect("writable");
    let textured = MOVING.replace(
        "Material \"diffuse\" \"rgb reflectance\" [0.5 $time 0.5]",
        "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"film.0003.png\" Material \"diffuse\" \"texture reflectance\" \"t\"",
    );
    folder.write("textured.bhs", textured);
    std::fs::copy(folder.at("keys.csv"), folder.at("film.0002.png")).expect("writable");
    let preview = ["--preview", "film.0002.png"];
    for (args, said) in [
        (vec!["render", "textured.bhs", "--frames", "1-5"], "film.0003.png"),
        (vec!["render", "scene.bhs", "--frames", "1-5", "--keys", "film.0002.png"], "the file of keys, `film.0002.png`"),
        (
            [&["render", "scene.bhs", "--frames", "2", "--keys", "film.0002.png", "-o", "x.exr"], &preview[..]].concat(),
            "the file of keys",
        ),
        ([&["render", "scene.bhs", "--frames", "1-5"], &preview[..]].concat(), "they are one file"),
    ] {
        let before = folder.contents();
        let refused = folder.run(&args);
        assert!(refused.code == 1 && refused.err.contains(said), "{args:?}: {}", refused.err);
        assert!(folder.contents() == before, "{args:?} changed files");
    }
}

#[test]
fn a_frame_that_is_at_fault_is_named_before_anything_is_rendered() {
    let hole = "LookAt 0 0 -$x 0 0 0 0 1 0 Camera \"perspective\" WorldBegin BlackHole \"schwarzschild\" \"float rs\" 1
        LightSource \"infinite\" Translate 3 0 0 Shape \"sphere\" \"float radius\" $r";
    let folder = Folder::new(hole);
    folder.write("keys.csv", "frame,x,r\n1,4,1\n7,0.4,1\n8,5,-0.5\n9,5,1\n");
    let run = folder.run(&["render", "scene.bhs", "--frames", "1-9", "--keys", "keys.csv", "--quick"]);
    assert_eq!(run.code, 1, "{}", run.err);
    assert!(run.err.contains("wrong with frame 6; of 9 frames these have errors: 6-8"), "{}", run.err);
    assert!(run.err.contains("scene.bhs:1:"), "{}", run.err);
    assert_eq!(folder.files(), ["keys.csv", "scene.bhs"]);
    folder.write("keys.csv", "frame,x,r\n1,4,1\n2,4,x\n");
    let run = folder.run(&["render", "scene.bhs", "--frames", "1-9", "--keys", "keys.csv", "--quick"]);
    assert!(run.code == 1 && run.err.contains("keys.csv:3:5"), "{}", run.err);
    for (args, code, said) in [
        (["--frames", "-5-5"], 2, "numbered from 0"),
        (["--frames", "9-1"], 2, "comes after"),
        (["--frames=1-2", "--fps=0"], 2, "24 or 29.97"),
        (["--frames=1-2", "--preview=x.mp4"], 2, ".gif"),
        (["--frames=1-2", "--keys=none.csv"], 1, "none.csv"),
        (["--skip-existing", "--quiet"], 2, "--frames"),
    ] {
        let run = folder.run(&[&["render", "scene.bhs"], &args[..]].concat());
        assert!(run.code == code && run.err.contains(said), "{args:?}: {}", run.err);
    }
    let run = folder.run(&["render", "-", "--frames", "1-2"]);
    assert!(run.code == 2 && run.err.contains("standard input"), "{}", run.err);
    assert_eq!(folder.files(), ["keys.csv", "scene.bhs"]);
}

#[test]
fn columns_that_move_nothing_are_told_once() {
    let folder = moving();
    folder.write("keys.csv", "frame,x,xx\n1,0,0\n4,1,1\n");
    let said = done(&folder, &["render", "scene.bhs", "--frames", "1-4", "--keys", "keys.csv"]);
    assert_eq!(said.matches("the column `xx` of the keys moves nothing").count(), 1, "{said}");
    assert!(said.contains("did you mean `x`?"), "{said}");
}

#[test]
fn previews_are_the_frames() {
    let folder = moving();
    let args = ["render", "scene.bhs", "--frames", "1-4", "--keys", "keys.csv", "--preview", "film.gif", "--fps", "30"];
    done(&folder, &args);
    done(&folder, &[&args[..6], &["--preview", "film.png", "--skip-existing", "--fps", "30"]].concat());
    let pixels = |name: &str| image::open(folder.at(name)).expect("a picture").into_rgba8();
    let frames: Vec<_> = (1..=4).map(|n| pixels(&format!("film.{n:04}.png"))).collect();
    let decoder = image::codecs::png::PngDecoder::new(Cursor::new(folder.read("film.png"))).expect("a PNG");
    let shown = decoder.apng().expect("an animation").into_frames().collect_frames().expect("frames");
    assert_eq!(shown.len(), frames.len());
    for (shown, frame) in shown.iter().zip(&frames) {
        assert!(shown.buffer() == frame);
        let (numer, denom) = shown.delay().numer_denom_ms();
        assert!((f64::from(numer) / f64::from(denom) - 1000.0 / 30.0).abs() < 1.0, "{numer}/{denom} ms");
    }
    let decoder = image::codecs::gif::GifDecoder::new(Cursor::new(folder.read("film.gif"))).expect("a GIF");
    let shown = decoder.into_frames().collect_frames().expect("frames");
    assert_eq!(shown.len(), frames.len());
    let mut length = 0.0;
    for (shown, frame) in shown.iter().zip(&frames) {
        // 96 pixels have at most 96 colours, which 256 hold all but exactly.
        let far = shown.buffer().pixels().zip(frame.pixels()).flat_map(|(a, b)| (0..3).map(|c| a[c].abs_diff(b[c])));
        assert!(far.max() <= Some(8), "a frame of the GIF differs");
        let (numer, denom) = shown.delay().numer_denom_ms();
        length += f64::from(numer) / f64::from(denom);
    }
    // Hundredths of a second are too coarse for one frame, but not for all of them.
    assert!((length - 4000.0 / 30.0).abs() <= 5.0 + 1e-9, "{length} ms");
}

#[test]
#[cfg(unix)]
fn an_animation_that_is_stopped_goes_on_behind_what_it_has() {
    let slow = MOVING.replace("12", "160").replace("\"integer yresolution\" 8", "\"integer yresolution\" 120");
    let slow = slow.replace("\"integer pixelsamples\" 4", "\"integer pixelsamples\" 16");
    let folder = process::Folder::new(&slow);
    folder.write("keys.csv", KEYS);
    let args = ["render", "scene.bhs", "--frames", "1-6", "--keys", "keys.csv"];
    let mut running = folder.start(&args);
    running.wait_for(&folder.path("film.0002.exr"));
    running.signal("INT");
    let code = running.wait();
    assert!([Some(130), Some(0)].contains(&code), "{code:?}");
    let first = std::fs::read(folder.path("film.0001.exr")).expect("it stays");
    let (code, said) = folder.run(&[&args[..], &["--skip-existing"]].concat());
    assert_eq!(code, 0, "{said}");
    assert_eq!(std::fs::read(folder.path("film.0001.exr")).expect("it stays"), first);
    let (code, said) = folder.run(&[&args[..], &["-o", "whole.exr"]].concat());
    assert_eq!(code, 0, "{said}");
    for n in 1..=6 {
        assert_eq!(folder.header(&format!("film.{n:04}.exr"), "bhs:stopped"), "complete");
        folder.assert_same(&format!("film.{n:04}"), &format!("whole.{n:04}"));
    }
    // A picture that is there but not complete is rendered again.
    let (_, said) = folder.run(&[&args[..], &["--spp", "1000000", "--time", "0.2", "-o", "cut.exr"]].concat());
    assert_eq!(folder.header("cut.0003.exr", "bhs:stopped"), "time", "{said}");
}

#[test]
fn frames_resume_from_checkpoints_of_their_own() {
    let folder = moving();
    let args = ["render", "scene.bhs", "--frames", "1-2", "--keys", "keys.csv", "--checkpoint"];
    done(&folder, &args);
    assert!(folder.files().iter().filter(|name| name.ends_with(".checkpoint")).count() >= 2, "{:?}", folder.files());
    let said = done(&folder, &["render", "scene.bhs", "--frames", "1-2", "--keys", "keys.csv", "--resume", "--spp", "8"]);
    assert_eq!(said.matches("going on from").count(), 2, "{said}");
    done(&folder, &["render", "scene.bhs", "--frames", "1-2", "--keys", "keys.csv", "--spp", "8", "-o", "whole.exr"]);
    assert_same(&folder, "film.0002", "whole.0002");
    // With other keys it is another frame.
    folder.write("keys.csv", "frame,x\n1,0.5\n");
    let run = folder.run(&["render", "scene.bhs", "--frames", "1-2", "--keys", "keys.csv", "--resume"]);
    assert!(run.code == 1 && run.err.contains("frame 1") && run.err.contains("of another scene"), "{}", run.err);
    done(&folder, &["render", "scene.bhs", "--frames", "1-2", "--checkpoint=c.state", "-o", "named.exr"]);
    assert!(folder.files().contains(&"c.0002.state".to_owned()), "{:?}", folder.files());
}

#[test]
fn what_is_made_of_a_file_is_shared_as_long_as_the_file_is_the_same() {
    let mesh = |x: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n{x} 0 0\n0 1 0\n3 0 1 2\n"
        )
    };
    let cache = Arc::new(FileCache::default());
    let load = |x: &str, z: &str| {
        let files = BTreeMap::from([(PathBuf::from("mesh.ply"), Arc::from(mesh(x).into_bytes()))]);
        let text =
            format!("WorldBegin LightSource \"infinite\" Translate 0 0 {z} Shape \"plymesh\" \"string filename\" \"mesh.ply\"");
        let overrides = Overrides { intersector: Some("reference".into()), ..Overrides::default() };
        let mut sources = SourceMap::in_memory(files).keeping(&cache);
        let built = lang::load_text("frame.bhs", &text, &Registry::builtin(), &overrides, &mut sources);
        let built = built.unwrap_or_else(|found| panic!("{found:?}"));
        assert_eq!(built.load.triangles, 1);
        cache.misses()
    };
    // Where it stands does not matter, and what it is does.
    assert_eq!([load("1", "3"), load("1", "4"), load("2", "4"), load("1", "5")], [1, 1, 2, 2]);
}
