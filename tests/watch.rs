//! `bhs watch`, as somebody works with it: files are saved, broken, mended; the picture follows.
#![cfg(unix)]

use crate::common::program::{Folder, SMALL};
use crate::common::viewer::{self, Viewer};
use std::io::Read;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

/// The program under way; killed when it is let go.
struct Watching {
    child: Child,
    said: Arc<Mutex<String>>,
}

/// Waits until `is` says so.
fn wait_until(what: &str, mut is: impl FnMut() -> bool) {
    let start = Instant::now();
    while !is() {
        assert!(start.elapsed() < Duration::from_secs(300), "it does not come: {what}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

impl Watching {
    fn start(folder: &Folder, args: &[&str]) -> Self {
        let mut command = folder.command(&[&["watch"], args].concat());
        let mut child = command.stdout(Stdio::null()).spawn().expect("it starts");
        let said = Arc::new(Mutex::new(String::new()));
        let (mut from, to) = (child.stderr.take().expect("a pipe"), Arc::clone(&said));
        std::thread::spawn(move || {
            let mut bytes = [0; 4096];
            while let Ok(n @ 1..) = from.read(&mut bytes) {
                to.lock().expect("nobody panics").push_str(&String::from_utf8_lossy(&bytes[..n]));
            }
        });
        Self { child, said }
    }

    /// What it has said since this was last asked.
    fn take_said(&self) -> String {
        std::mem::take(&mut self.said.lock().expect("nobody panics"))
    }

    /// Waits until it says something.
    fn wait_for(&mut self, word: &str) -> String {
        wait_until(word, || {
            assert!(self.child.try_wait().expect("it can be asked").is_none(), "it has ended: {}", self.take_said());
            self.said.lock().expect("nobody panics").contains(word)
        });
        self.take_said()
    }

    fn signal(&self, name: &str) {
        assert!(
            Command::new("kill").args([&format!("-{name}"), &self.child.id().to_string()]).status().expect("kill runs").success()
        );
    }
}

impl Drop for Watching {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A scene that includes `sky.bhs` and shows a mesh before it.
fn folder() -> Folder {
    let folder = Folder::new(&SMALL.replace("LightSource \"infinite\"", "Include \"sky.bhs\"").replace(
        "Shape \"sphere\"",
        "Material \"diffuse\" \"float reflectance\" 0\nShape \"plymesh\" \"string filename\" \"mesh.ply\"",
    ));
    folder.write("sky.bhs", sky([1, 1, 1]));
    folder.write("mesh.ply", mesh(1e-3));
    folder
}

fn sky([r, g, b]: [u8; 3]) -> String {
    format!("LightSource \"infinite\" \"rgb L\" [{r} {g} {b}]\n")
}

/// A triangle that spans so many units.
fn mesh(size: f64) -> String {
    format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
         property list uchar int vertex_indices\nend_header\n{0} {0} 0\n-{0} {0} 0\n0 -{0} 0\n3 0 1 2\n",
        size
    )
}

/// The mean of red, green and blue of a picture, if it is there and whole.
fn mean(folder: &Folder, name: &str) -> Option<[f64; 3]> {
    let picture = image::open(folder.at(name)).ok()?.to_rgb8();
    let count = f64::from(picture.width() * picture.height());
    Some(std::array::from_fn(|c| picture.pixels().map(|p| f64::from(p.0[c])).sum::<f64>() / count))
}

#[test]
fn the_picture_follows_whatever_is_saved() {
    let folder = folder();
    let mut watching = Watching::start(&folder, &["scene.bhs"]);
    watching.wait_for("small.watch.png: 2 spp in");
    let is =
        |what: &str, like: &dyn Fn([f64; 3]) -> bool| wait_until(what, || mean(&folder, "small.watch.png").is_some_and(like));
    is("white", &|[r, g, b]| r > 200.0 && g > 200.0 && b > 200.0);

    // What the scene includes is saved.
    folder.write("sky.bhs", sky([1, 0, 0]));
    is("red", &|[r, g, b]| r > 200.0 && g < 100.0 && b < 100.0);
    // As many editors save: a new file takes the place of the old one.
    folder.write("new", sky([0, 1, 0]));
    std::fs::rename(folder.at("new"), folder.at("sky.bhs")).expect("it can be moved");
    is("green", &|[r, g, _]| g > 200.0 && r < 150.0);
    // Or the old one is moved away, and a new one written.
    std::fs::rename(folder.at("sky.bhs"), folder.at("sky.bhs~")).expect("it can be moved");
    folder.write("sky.bhs", sky([0, 0, 1]));
    is("blue", &|[r, _, b]| b > 200.0 && r < 150.0);
    // A mesh that hides the sky.
    folder.write("mesh.ply", mesh(100.0));
    is("black", &|rgb| rgb.iter().all(|c| *c < 10.0));
    folder.write("mesh.ply", mesh(1e-3));
    is("blue", &|[_, _, b]| b > 200.0);

    // An error is shown, and the picture stays. What was rendered until then may have been coarse or fine; from here on nothing is.
    watching.take_said();
    folder.write("sky.bhs", "LightSource \"infinit\"\n");
    let said = watching.wait_for("waits until");
    assert!(said.contains("sky.bhs:1:13") && said.contains("did you mean `infinite`"), "{said}");
    let before = folder.read("small.watch.png");
    is("blue", &|[_, _, b]| b > 200.0);
    // So it does if a file is gone, which may come back.
    std::fs::remove_file(folder.at("mesh.ply")).expect("it was there");
    let said = watching.wait_for("waits until");
    assert!(said.contains("mesh.ply"), "{said}");
    assert_eq!(folder.read("small.watch.png"), before);
    folder.write("sky.bhs", sky([1, 0, 0]));
    watching.wait_for("waits until");
    folder.write("mesh.ply", mesh(1e-3));
    is("red", &|[r, _, b]| r > 200.0 && b < 100.0);

    // The finer picture that follows the first red one may be half written.
    let files = ["mesh.ply", "scene.bhs", "sky.bhs", "sky.bhs~", "small.watch.png"];
    wait_until("the files of a render that is done", || folder.files() == files);
    watching.signal("INT");
    assert_eq!(watching.child.wait().expect("it ends").code(), Some(130));
    assert_eq!(folder.files(), files);
}

#[test]
fn a_change_ends_the_render_under_way() {
    let folder = folder();
    let mut watching = Watching::start(&folder, &["scene.bhs", "--spp", "1000000000", "-o", "look.png"]);
    wait_until("a first impression", || mean(&folder, "look.png").is_some_and(|[r, _, b]| r > 200.0 && b > 200.0));
    folder.write("sky.bhs", sky([1, 0, 0]));
    watching.wait_for("`sky.bhs` has changed");
    wait_until("red", || mean(&folder, "look.png").is_some_and(|[r, _, b]| r > 200.0 && b < 100.0));
    watching.signal("TERM");
    assert_eq!(watching.child.wait().expect("it ends").code(), Some(143));
    assert_eq!(folder.files(), ["look.png", "mesh.ply", "scene.bhs", "sky.bhs"]);
}

#[test]
fn keys_and_variables_are_watched_too() {
    let folder = Folder::new(&SMALL.replace("LightSource \"infinite\"", "LightSource \"infinite\" \"rgb L\" [$red 1 1]"));
    folder.write("keys.csv", "frame,red\n1,1\n3,0\n");
    let watching = Watching::start(&folder, &["scene.bhs", "--frame", "3", "--keys", "keys.csv"]);
    wait_until("cyan", || mean(&folder, "small.watch.png").is_some_and(|[r, _, b]| r < 150.0 && b > 200.0));
    folder.write("keys.csv", "frame,red\n1,0\n3,1\n");
    wait_until("white", || mean(&folder, "small.watch.png").is_some_and(|[r, _, b]| r > 200.0 && b > 200.0));
    folder.write("keys.csv", "frame\n");
    wait_until("an error", || watching.take_said().contains("keys.csv"));
}

#[test]
fn a_viewer_sees_what_is_watched() {
    let folder = folder();
    let viewer = Viewer::new();
    let watching = Watching::start(&folder, &["scene.bhs", "--quiet", &viewer.flag(), "--aov", "depth"]);
    let mut stream = viewer.accept();
    let (mut changed, mut blue) = (false, false);
    let seen = viewer::read(&mut stream, |seen| {
        let Some(image) = seen.images.get("small.watch.png") else { return false };
        let mean = |name: &str| image.channels[name].iter().sum::<f32>() / image.channels[name].len() as f32;
        if mean("R") > 0.5 && image.channels.contains_key("depth") && !std::mem::replace(&mut changed, true) {
            folder.write("sky.bhs", sky([0, 0, 1]));
        }
        blue = changed && mean("R") < 0.3 && mean("B") > 0.5;
        blue
    });
    assert!(blue, "{:?}", seen.images.keys());
    // The same image, changed.
    assert_eq!((seen.images.len(), seen.images["small.watch.png"].created), (1, 1));
    assert_eq!(watching.take_said(), "");
}

#[test]
fn what_cannot_be_watched_is_refused() {
    let folder = folder();
    for (args, code, word) in [
        (&["watch", "nothing.bhs"][..], 1, "nothing.bhs"),
        (&["watch", "-"], 2, "standard input"),
        (&["watch", "scene.bhs", "-o", "x.exr"], 2, ".png"),
        (&["watch", "scene.bhs", "--keys", "keys.csv"], 2, "--frame"),
    ] {
        let run = folder.run(args);
        assert!(run.code == code && run.err.contains(word), "{args:?}: {} {}", run.code, run.err);
    }
    // What `render` writes, and what the scene reads.
    let textured = "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"map.png\"\n\
                    Material \"diffuse\" \"texture reflectance\" \"t\"\nShape \"sphere\"\n";
    folder.write("sky.bhs", format!("{}\n{textured}", sky([1, 1, 1])));
    image::RgbImage::from_pixel(2, 2, image::Rgb([9; 3])).save(folder.at("map.png")).expect("a PNG");
    let before = folder.read("map.png");
    // A link to what is there, and one to what is not there yet.
    std::os::unix::fs::symlink("map.png", folder.at("input.png")).expect("links can be made");
    std::os::unix::fs::symlink("small.png", folder.at("own.png")).expect("links can be made");
    for name in ["small.png", "./small.png", "own.png", "map.png", "./map.png", "input.png"] {
        let mut watching = Watching::start(&folder, &["scene.bhs", "-o", name]);
        let said = watching.wait_for("waits until");
        assert!(said.contains("error") && said.contains(name), "{said}");
    }
    assert_eq!(folder.read("map.png"), before);
    assert_eq!(folder.files(), ["input.png", "map.png", "mesh.ply", "own.png", "scene.bhs", "sky.bhs"]);
    // Nor over the picture of one of several cameras.
    let cameras = "Camera \"perspective\"\nCamera \"perspective\" \"string name\" \"left\"";
    folder.write("two.bhs", SMALL.replace("Camera \"perspective\"", cameras));
    let said = Watching::start(&folder, &["two.bhs", "-o", "./small.left.png"]).wait_for("waits until");
    assert!(said.contains("`bhs render` writes"), "{said}");
}
