//! What is learned of the light takes noise away where light is hard to find, and is used by itself where that pays. That it changes no mean: `unbiased`; that parts know the same: `parts`.

use crate::common;
use bhs::image::Picture;
use bhs::lang::Overrides;

/// A world, with guiding, without or, if `guiding` is empty, where that pays.
fn text(size: u32, guiding: &str, world: &str) -> String {
    format!(
        r#"
        LightTransport "path" "integer maxdepth" 8 {guiding}
        Sampler "sobol" "integer pixelsamples" 64
        Film "rgb" "integer xresolution" {size} "integer yresolution" {size}
        LookAt 1 1.2 1.5  5 1 5  0 1 0
        Camera "perspective" "float fov" 60
        WorldBegin
        Material "diffuse" "float reflectance" 0.7
        {world}"#
    )
}

const GUIDED: &str = "\"bool guiding\" true";
const UNGUIDED: &str = "\"bool guiding\" false";

/// What is seen of it.
fn scene(size: u32, guiding: &str, world: &str, overrides: &Overrides) -> Picture {
    common::render(&common::build_with(&text(size, guiding, world), overrides)).frame.picture()
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
    let [guided, without, by_itself] =
        [GUIDED, UNGUIDED, ""].map(|guiding| noise(&scene(128, guiding, DOORWAY, &Overrides::default()), 128));
    assert!(guided < 0.6 * without, "{guided} {without}");
    // A quarter of its samples come before the trial.
    assert!(by_itself < 0.75 * without, "{by_itself} {without}");
}

/// With so many samples of each pixel.
fn with(spp: u32) -> Overrides {
    Overrides { spp: Some(spp), ..Default::default() }
}

#[test]
fn what_gains_nothing_is_not_guided() {
    // A floor under a sky that is alike all over: Lambert's law is the best that can be done.
    let open = r#"LightSource "infinite" "float L" 1
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-90 0 -90 90 0 -90 90 0 90 -90 0 90]"#;
    let [by_itself, without, guided] = ["", UNGUIDED, GUIDED].map(|guiding| scene(128, guiding, open, &with(20)));
    assert!(by_itself.same_channels(&without) && !by_itself.same_channels(&guided));
}

#[test]
fn pictures_of_few_samples_or_few_pixels_are_not_guided_by_themselves() {
    for (size, spp) in [(128, 16), (96, 40)] {
        let [by_itself, without] = ["", UNGUIDED].map(|guiding| scene(size, guiding, DOORWAY, &with(spp)));
        assert!(by_itself.same_channels(&without), "{size} {spp}");
    }
    let [by_itself, without] = ["", UNGUIDED].map(|guiding| scene(128, guiding, DOORWAY, &with(17)));
    assert!(!by_itself.same_channels(&without));
}

#[test]
fn a_part_of_a_picture_is_guided_as_the_whole_is() {
    let whole = scene(128, "", DOORWAY, &with(18));
    let crop = Overrides { crop: Some([0.25, 0.5, 0.5, 0.75]), ..with(18) };
    let part = scene(128, "", DOORWAY, &crop);
    let pixels = || (0..32).flat_map(|x| (0..32).map(move |y| (x, y)));
    assert_eq!(part.size, [32, 32]);
    for (x, y) in pixels() {
        assert_eq!(part.pixel(x, y), whole.pixel(x + 32, y + 64), "{x} {y}");
    }
}
