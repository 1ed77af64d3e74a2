//! What is learned of the light takes noise away where light is hard to find. That it changes no mean: `unbiased`; that parts know the same: `parts`.

use crate::common;
use bhs::image::Picture;

/// What is seen of a world, with and without guiding.
fn scene(size: u32, guiding: bool, world: &str) -> Picture {
    let text = format!(
        r#"
        LightTransport "path" "integer maxdepth" 8 "bool guiding" {guiding}
        Sampler "sobol" "integer pixelsamples" 64
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
fn a_room_lit_through_a_doorway_has_less_noise() {
    let [guided, without] = [true, false].map(|guiding| noise(&scene(128, guiding, DOORWAY), 128));
    assert!(guided < 0.6 * without, "{guided} {without}");
}
