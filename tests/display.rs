//! Pictures under way, as a viewer sees them; and whatever the viewer does, the picture is the same.

use crate::common::program::{Folder, SMALL};
use crate::common::viewer::{self, Seen, Viewer};
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::Duration;

/// A picture with stars and layers, of several tiles.
const STARS: &str = r#"
    Film "rgb" "integer xresolution" 70 "integer yresolution" 50 "string filename" "stars.exr"
        "string layers" ["normal" "depth" "variance" "shadingnormal"]
    Sampler "sobol" "integer pixelsamples" 4
    Camera "perspective"
    WorldBegin
    LightSource "infinite" "float L" 0.1
    LightSource "stars" "integer number" 2000
    Translate 0 0 3
    Shape "sphere"
"#;

/// Renders with these arguments, and a viewer that reads everything: exit code, standard error, what it has seen.
fn watched(folder: &Folder, args: &[&str]) -> (i32, String, Seen) {
    let viewer = Viewer::new();
    let flag = viewer.flag();
    let reading = thread::spawn(move || viewer::read(&mut viewer.accept(), |_| false));
    let run = folder.run(&[args, &[&flag]].concat());
    (run.code, run.err, reading.join().expect("the viewer understands all packets"))
}

/// A render that never ends by itself; killed when the test is over.
struct Endless(Child);

impl Endless {
    fn start(folder: &Folder, flag: &str) -> Self {
        let mut command = folder.command(&["render", "scene.bhs", "--spp", "1000000000", "--checkpoint", "--quiet", flag]);
        Self(command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().expect("it starts"))
    }

    fn interrupt(&self) {
        assert!(Command::new("kill").args(["-INT", &self.0.id().to_string()]).status().expect("kill runs").success());
    }
}

impl Drop for Endless {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn the_last_update_is_the_picture_to_the_bit() {
    for scene in [STARS, SMALL] {
        let folder = Folder::new(scene);
        let name = if scene == STARS { "stars" } else { "small" };
        let exr = format!("{name}.exr");
        assert_eq!(folder.run(&["render", "scene.bhs", "--quiet"]).code, 0);
        let plain = folder.read(&format!("{name}.png"));
        let (code, err, seen) = watched(&folder, &["render", "scene.bhs"]);
        assert_eq!((code, err.lines().filter(|line| line.contains("viewer")).count()), (0, 0), "{err}");
        seen.assert_is(&exr, &folder.at(&exr));
        let image = &seen.images[&exr];
        assert_eq!((image.created, &seen.shown), (1, &exr));
        // In one piece.
        assert_eq!(image.updates.last(), Some(&[0, 0, image.size[0], image.size[1]]));
        assert_eq!(folder.read(&format!("{name}.png")), plain);
    }
}

#[test]
fn a_crop_is_an_image_of_its_own_size() {
    let folder = Folder::new(STARS);
    let (code, err, seen) = watched(&folder, &["render", "scene.bhs", "--crop", "0.3,0.8,0.1,0.9", "-o", "part.exr"]);
    assert_eq!(code, 0, "{err}");
    seen.assert_is("part.exr", &folder.at("part.exr"));
    assert_eq!(seen.images["part.exr"].size, [35, 40]);
}

#[test]
fn every_camera_and_frame_is_an_image() {
    let cameras =
        SMALL.replace("Camera \"perspective\"", "Camera \"perspective\"\nCamera \"perspective\" \"string name\" \"left\"");
    let folder = Folder::new(&cameras.replace("Translate 0 0 3", "Translate 0 0 $frame"));
    let (code, err, seen) = watched(&folder, &["render", "scene.bhs", "--frames", "2-3"]);
    assert_eq!(code, 0, "{err}");
    let names = ["small.0002.exr", "small.0003.exr", "small.left.0002.exr", "small.left.0003.exr"];
    assert!(seen.images.keys().eq(&names.map(str::to_owned)), "{:?}", seen.images.keys());
    names.iter().for_each(|name| seen.assert_is(name, &folder.at(name)));
    assert_eq!(seen.shown, "small.left.0003.exr");
}

#[test]
fn a_picture_that_is_finished_already_is_shown() {
    let folder = Folder::new(STARS);
    assert_eq!(folder.run(&["render", "scene.bhs", "--quiet", "--checkpoint"]).code, 0);
    let (code, err, seen) = watched(&folder, &["render", "scene.bhs", "--resume"]);
    assert_eq!(code, 0, "{err}");
    seen.assert_is("stars.exr", &folder.at("stars.exr"));
}

#[test]
fn nobody_who_listens_changes_nothing() {
    let folder = Folder::new(STARS);
    assert_eq!(folder.run(&["render", "scene.bhs", "--quiet", "-o", "plain.exr"]).code, 0);
    let flag = Viewer::new().flag();
    let run = folder.run(&["render", "scene.bhs", &flag]);
    assert!(run.code == 0 && run.err.contains("note: the viewer at 127.0.0.1:") && run.err.contains("4 spp in"), "{}", run.err);
    assert_eq!(folder.read("stars.png"), folder.read("plain.png"));
    let run = folder.run(&["render", "scene.bhs", "--quiet", &flag]);
    assert_eq!((run.code, run.out.as_str(), run.err.as_str()), (0, "", ""));
    for wrong in ["--display-server=a:b", "--display-server=", "--display-server=host:0"] {
        let run = folder.run(&["render", "scene.bhs", wrong]);
        assert!(run.code == 2 && (run.err.contains("HOST:PORT")), "{wrong}: {}", run.err);
    }
}

#[test]
fn a_viewer_that_does_not_read_changes_nothing() {
    // More than the system keeps for it.
    let folder = Folder::new(&STARS.replace(
        "\"integer xresolution\" 70 \"integer yresolution\" 50",
        "\"integer xresolution\" 900 \"integer yresolution\" 700",
    ));
    assert_eq!(folder.run(&["render", "scene.bhs", "--quiet", "--spp", "1", "-o", "plain.exr"]).code, 0);
    let viewer = Viewer::new();
    let flag = viewer.flag();
    let (over, is_over) = std::sync::mpsc::channel::<()>();
    let stalling = thread::spawn(move || {
        let stream = viewer.accept();
        let _ = is_over.recv();
        drop(stream);
    });
    let run = folder.run(&["render", "scene.bhs", "--spp", "1", &flag]);
    assert!(run.code == 0 && run.err.contains("1 spp in"), "{}", run.err);
    assert!(folder.read("stars.png") == folder.read("plain.png"));
    drop(over);
    stalling.join().expect("it has accepted");
}

#[test]
#[cfg(unix)]
fn a_viewer_that_goes_away_and_comes_back_has_everything() {
    let folder = Folder::new(STARS);
    let viewer = Viewer::new();
    let endless = Endless::start(&folder, &viewer.flag());
    // It is closed in the middle, and killed with packets unread.
    let has_update = |seen: &Seen| seen.images.values().any(|image| !image.updates.is_empty());
    for _ in 0..3 {
        let seen = viewer::read(&mut viewer.accept(), has_update);
        assert_eq!(seen.images["stars.exr"].created, 1);
    }
    let mut stream = viewer.accept();
    let mut interrupted = false;
    let seen = viewer::read(&mut stream, |seen| {
        if has_update(seen) && !std::mem::replace(&mut interrupted, true) {
            endless.interrupt();
        }
        false
    });
    seen.assert_is("stars.exr", &folder.at("stars.exr"));
}

#[test]
#[cfg(unix)]
fn a_viewer_that_comes_late_has_everything() {
    let folder = Folder::new(STARS);
    let address = Viewer::new().address();
    let endless = Endless::start(&folder, &format!("--display-server={address}"));
    while !folder.at("stars.checkpoint").exists() {
        thread::sleep(Duration::from_millis(5));
    }
    let viewer = Viewer::at(address);
    let mut interrupted = false;
    let seen = viewer::read(&mut viewer.accept(), |seen| {
        let image = seen.images.get("stars.exr");
        if image.is_some_and(|image| image.updates.len() > 3) && !std::mem::replace(&mut interrupted, true) {
            endless.interrupt();
        }
        false
    });
    seen.assert_is("stars.exr", &folder.at("stars.exr"));
}
