//! Pictures on surfaces that are blurred over what a pixel sees: along bent light, the same for every sample of the pixel, and nearer to the mean of many
//! samples than a few samples without it.

use crate::common;
use bhs::lang::BuiltScene;
use bhs::not_finite::SampleId;
use bhs::patches::Patches;
use bhs::render::Job;
use bhs::replay::Replay;
use glam::DVec3;
use std::path::Path;

/// A floor with a picture of random texels that are smaller than pixels further away.
fn floor(folder: &Path, options: &str, hole: &str, filter: &str) -> BuiltScene {
    let map = folder.join("map.png");
    let texel = |x: u32, y: u32| u8::from((x * 7919 + y * 104_729).wrapping_mul(2_654_435_761) >> 31 == 1) * 230;
    image::RgbImage::from_fn(256, 256, |x, y| image::Rgb([texel(x, y); 3])).save(&map).expect("it can be written");
    common::build(&format!(
        r#"
        {options}
        LightTransport "path" "integer maxdepth" 1
        LookAt 0 -8 1.5  0 0 0.5  0 0 1
        Camera "perspective" "float fov" 50
        WorldBegin
        {hole}
        LightSource "infinite"
        Texture "t" "spectrum" "imagemap" "string filename" "{}" "string encoding" "linear" "string filter" "{filter}"
        Material "diffuse" "texture reflectance" "t"
        Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-8 -8 -1  8 -8 -1  8 40 -1  -8 40 -1]
            "point2 uv" [0 0  1 0  1 1  0 1]
        "#,
        map.display()
    ))
}

fn options(samples: u32, more: &str) -> String {
    format!(
        r#"Integrator "exact"
        Sampler "sobol" "integer pixelsamples" {samples}
        Film "rgb" "integer xresolution" 64 "integer yresolution" 48 "string layers" "albedo" {more}"#
    )
}

const HOLE: &str = r#"BlackHole "schwarzschild" "float rs" 0.3 "point3 center" [0 0 0.6]"#;

/// The reflectance that each pixel records, if it sees the floor.
fn albedo(built: &BuiltScene) -> Vec<Option<f64>> {
    let layers = common::render(built).frame.layers();
    layers[0].values.iter().map(|value| value.map(|v| v[0])).collect()
}

/// Far from a hole the place where light comes from on a plane behind it is theta - theta_E^2/theta, seen from the camera (the lens equation): a pixel's
/// patch is longer along the radius than without the hole, and shorter across.
#[test]
fn a_patch_behind_a_hole_is_that_of_the_lens_equation() {
    let scene = |hole: &str| {
        common::build(&format!(
            r#"
            Integrator "exact"
            Film "rgb" "integer xresolution" 20 "integer yresolution" 20
            LookAt 0 0 -10000  0 0 0  0 1 0
            Camera "perspective" "float fov" 2
            WorldBegin
            {hole}
            LightSource "infinite"
            Texture "t" "spectrum" "imagemap" "string filename" "plugins/textures/tests/data/plain.png" "string filter" "ewa"
            Material "diffuse" "texture reflectance" "t"
            Shape "trianglemesh" "integer indices" [0 1 2 0 2 3]
                "point3 P" [-1500 -1500 10000  1500 -1500 10000  1500 1500 10000  -1500 1500 10000]
            "#
        ))
    };
    let tan = |pixels: f64| 1_f64.to_radians().tan() * pixels / 10.0;
    for (hole, rs) in [("", 0.0), (r#"BlackHole "schwarzschild" "float rs" 1"#, 1.0)] {
        let built = scene(hole);
        let patch = Patches::of(&Job::of(&built), std::iter::once([18, 9])).get(0).expect("it sees the plane");
        // The middle of the pixel, the right edge's and the lower edge's, from the middle of the picture.
        let source = |x: f64, y: f64| {
            let theta = glam::dvec2(tan(x), tan(y));
            let einstein = 2.0 * rs * 1e4 / (1e4 * 2e4);
            theta * (1.0 - einstein / theta.length_squared()) * 2e4
        };
        let middle = source(8.5, 0.5);
        for (found, expected) in patch.beside.iter().zip([source(9.0, 0.5) - middle, source(8.5, 0.0) - middle]) {
            let found = glam::dvec2(found.dot(DVec3::X).abs(), found.dot(DVec3::Y).abs());
            let tolerance = if rs == 0.0 { 1e-6 } else { 0.02 };
            let off = (found - expected.abs()).length() / expected.length();
            assert!(off < tolerance, "{hole}: {found}, expected {expected}");
        }
    }
}

#[test]
fn a_few_samples_are_nearer_to_the_mean_of_many() {
    let folder = tempfile::tempdir().expect("a folder");
    for hole in ["", HOLE] {
        let reference = albedo(&floor(folder.path(), &options(400, ""), hole, "bilinear"));
        let [bilinear, round, ellipse] = ["bilinear", "trilinear", "ewa"].map(|filter| {
            let found = albedo(&floor(folder.path(), &options(4, ""), hole, filter));
            let pairs: Vec<[f64; 2]> = found.iter().zip(&reference).filter_map(|(a, b)| Some([(*a)?, (*b)?])).collect();
            let mean = |f: &dyn Fn(&[f64; 2]) -> f64| pairs.iter().map(f).sum::<f64>() / pairs.len() as f64;
            // As bright, in the mean.
            let ratio = mean(&|p| p[0]) / mean(&|p| p[1]);
            assert!((ratio - 1.0).abs() < 0.02, "{hole} {filter}: {ratio}");
            mean(&|p| (p[0] - p[1]).powi(2)).sqrt()
        });
        assert!(ellipse < 0.7 * bilinear && round < bilinear, "{hole}: {bilinear} {round} {ellipse}");
    }
}

/// The patch is that of the pixel: whatever is rendered beside it, and however it is rendered.
#[test]
fn parts_of_a_picture_and_replayed_samples_have_the_same_patches() {
    let folder = tempfile::tempdir().expect("a folder");
    let whole = floor(folder.path(), &options(1, ""), HOLE, "ewa");
    let picture = common::render(&whole).frame.picture();
    let crop = floor(folder.path(), &options(1, "\"float cropwindow\" [0.25 0.75 0.5 1]"), HOLE, "ewa");
    let part = common::render(&crop).frame.picture();
    assert_eq!(part.size, [32, 24]);
    let mut replay = Replay::new(Job::of(&whole));
    for (x, y) in (0..32).flat_map(|x| (0..24).map(move |y| (x, y))) {
        let seen = picture.pixel(16 + x, 24 + y);
        assert_eq!(part.pixel(x, y), seen, "{x} {y}");
        let replayed = replay.follow(SampleId { pixel: [16 + x as u32, 24 + y as u32], sample: 0 });
        assert_eq!(replayed.channels.iter().map(|c| *c as f32).collect::<Vec<_>>(), seen, "{x} {y}");
    }
}

#[test]
fn no_ray_is_followed_where_no_texture_asks() {
    let folder = tempfile::tempdir().expect("a folder");
    let found = |filter| {
        let built = floor(folder.path(), &options(1, ""), "", filter);
        (built.scene.wants_patches, Patches::of(&Job::of(&built), std::iter::once([32, 40])).get(0).is_some())
    };
    assert_eq!(
        ["bilinear", "point", "trilinear", "ewa"].map(found),
        [(false, false), (false, false), (true, true), (true, true)]
    );
    // A texture that nothing has asks for nothing.
    let text = r#"
        Texture "t" "spectrum" "imagemap" "string filename" "plugins/textures/tests/data/plain.png" "string filter" "ewa"
        LightSource "infinite"
        Shape "sphere"
    "#;
    assert!(!common::build(&format!("Film \"rgb\"\nWorldBegin\n{text}")).scene.wants_patches);
}
