//! What is learned of the light: used where it pays, if nothing is said, and nowhere else. That it changes no mean: `unbiased`; that parts know the same: `parts`.

use crate::common;
use bhs::image::Picture;

/// Options, and what is seen from a room. `guiding` is a parameter of the transport, or nothing.
fn scene(size: u32, guiding: &str, world: &str) -> Picture {
    let text = format!(
        r#"
        LightTransport "path" "integer maxdepth" 8 {guiding}
        Sampler "sobol" "integer pixelsamples" 24
        Film "rgb" "integer xresolution" {size} "integer yresolution" {size}
        LookAt 1 1.2 1.5  5 1 5  0 1 0
        Camera "perspective" "float fov" 60
        WorldBegin
        Material "diffuse" "float reflectance" 0.7
        {world}"#
    );
    common::render(&common::build(&text)).frame.picture()
}

/// A room that gets its light through a doorway, from a lamp that is not seen.
const DOORWAY: &str = r#"
    Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [0 0 0 6 0 0 6 0 12 0 0 12]
    Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [0 2.5 0 6 2.5 0 6 2.5 12 0 2.5 12]
    Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [0 0 0 0 2.5 0 0 2.5 12 0 0 12]
    Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [6 0 0 6 2.5 0 6 2.5 12 6 0 12]
    Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [0 0 0 6 0 0 6 2.5 0 0 2.5 0]
    Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [0 0 12 6 0 12 6 2.5 12 0 2.5 12]
    Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [0 0 6 5.2 0 6 5.2 2.5 6 0 2.5 6]
    AreaLightSource "diffuse" "float L" 30
    Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [1 2.49 8 2 2.49 8 2 2.49 9 1 2.49 9]"#;

/// A floor under an even sky: nothing to be learned.
const FLOOR: &str = r#"
    LightSource "infinite" "float L" 1
    Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [0 0 0 6 0 0 6 0 12 0 0 12]"#;

/// Mean square of the differences between neighbours, over the squared mean: mostly noise where all is smooth.
fn noise(picture: &Picture, size: usize) -> f64 {
    let green = |x: usize, y: usize| f64::from(picture.pixel(x, y)[1]);
    let (mut squares, mut sum) = (0.0, 0.0);
    for (x, y) in (0..size - 1).flat_map(|x| (0..size).map(move |y| (x, y))) {
        squares += (green(x + 1, y) - green(x, y)).powi(2);
        sum += green(x, y);
    }
    let count = (size * (size - 1)) as f64;
    squares / count / (sum / count).powi(2)
}

#[test]
fn a_room_lit_through_a_doorway_is_guided_by_itself() {
    let [by_itself, without] = ["", "\"bool guiding\" false"].map(|guiding| noise(&scene(128, guiding, DOORWAY), 128));
    assert!(by_itself < 0.6 * without, "{by_itself} {without}");
}

#[test]
fn where_nothing_is_to_be_gained_nothing_changes() {
    // An even sky, and a picture that is done before anything is learned.
    for (size, world) in [(128, FLOOR), (64, DOORWAY)] {
        let [by_itself, without] = ["", "\"bool guiding\" false"].map(|guiding| scene(size, guiding, world));
        assert!(by_itself.same_channels(&without), "{size}");
    }
}
