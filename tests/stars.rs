//! Stars, drawn as points: where they are, how bright, and in what colour, against closed forms and against discs that camera rays find.

use crate::common;
use crate::common::lights::{floor, luminance};
use bhs::image::Picture;
use bhs::point_picture::PointCounters;
use bhs::sky_points;
use bhs_core::spectrum::SampledSpectrum;
use std::f64::consts::PI;

/// Irradiance of a star of magnitude 0 times the scale of these tests.
const BRIGHT: f64 = 3.631e-11 * 1e10;
const STAR: &str = r#""float scale" 1e10"#;

/// A catalogue in the folder of the test program's own: its path.
fn catalogue(name: &str, text: &str) -> String {
    let path = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("stars_{name}.csv"));
    std::fs::write(&path, text).expect("it can be written");
    path.to_str().expect("a plain path").to_owned()
}

/// One star of magnitude 0 and of 6000 K in a direction.
fn star(name: &str, [x, y, z]: [f64; 3]) -> String {
    catalogue(name, &format!("x,y,z,mag,temperature\n{x:e},{y:e},{z:e},0,6000\n"))
}

fn picture(text: &str) -> (Picture, PointCounters) {
    let rendered = common::render(&common::build(text));
    let counters = rendered.frame.points().map_or(PointCounters::default(), |points| points.counters);
    (rendered.frame.picture(), counters)
}

/// Irradiance, as luminance, that the pixels of a perspective camera of the field of view `fov` (degrees) bring for which `holds`.
fn irradiance(picture: &Picture, fov: f64, holds: impl Fn(usize, usize) -> bool) -> f64 {
    let [w, h] = picture.size;
    let pixel = 2.0 * (0.5 * fov).to_radians().tan() / w.min(h) as f64;
    let mut sum = 0.0;
    for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).filter(|(x, y)| holds(*x, *y)) {
        let [sx, sy] = [(x, w), (y, h)].map(|(i, n)| (i as f64 + 0.5 - 0.5 * n as f64) * pixel);
        sum += luminance(picture.pixel(x, y)) * pixel * pixel / (1.0 + sx * sx + sy * sy).powf(1.5);
    }
    sum
}

/// What the eye sees of a black body, up to a factor (Planck's law).
fn black_body(temperature: f64) -> f64 {
    let planck = |nm: f64| nm.powi(-5) / (1.438_776_877e7 / (nm * temperature)).exp_m1();
    bhs_colour::standard_observer().iter().map(|[nm, _, y, _]| y * planck(*nm)).sum()
}

/// A picture of 60 by 40 pixels, 40 degrees high, seen along +z, but for what `options` say otherwise.
fn looking(options: &str, world: &str) -> String {
    let mut text = options.to_owned();
    for (word, usual) in [
        ("Film", r#"Film "rgb" "integer xresolution" 60 "integer yresolution" 40"#),
        ("Sampler", r#"Sampler "independent" "integer pixelsamples" 1"#),
        ("Camera", r#"Camera "perspective" "float fov" 40"#),
    ] {
        if !options.contains(word) {
            text = format!("{text}\n{usual}");
        }
    }
    format!("LightTransport \"path\" \"integer maxdepth\" 2\n{text}\nWorldBegin\n{world}\n")
}

#[test]
fn a_star_is_in_its_pixel_with_all_of_its_light() {
    let light = format!(r#"LightSource "stars" {STAR} "string filename" "{}""#, star("flat", [0.1, -0.07, 1.0]));
    let (sharp, counters) = picture(&looking(r#"PixelFilter "box""#, &light));
    assert_eq!((counters.points, counters.images, counters.occluded), (1, 1, 0));
    // x to the right and y up, in a space where +z is ahead.
    let pixel = 2.0 * 20f64.to_radians().tan() / 40.0;
    let (x, y) = ((30.0 + 0.1 / pixel) as usize, (20.0 + 0.07 / pixel) as usize);
    let lit: Vec<usize> = (0..2400).filter(|i| sharp.data[3 * i + 1] != 0.0).collect();
    assert_eq!(lit, [y * 60 + x]);
    let seen = irradiance(&sharp, 40.0, |_, _| true);
    // The solid angle of the pixel in its middle and at the star differ.
    assert!((seen / BRIGHT - 1.0).abs() < 2e-3, "{}", seen / BRIGHT);
    for filter in ["gaussian", "mitchell", "triangle", "sinc"] {
        let (soft, _) = picture(&looking(&format!("PixelFilter \"{filter}\""), &light));
        let seen = irradiance(&soft, 40.0, |_, _| true);
        assert!((seen / BRIGHT - 1.0).abs() < 5e-3, "{filter}: {}", seen / BRIGHT);
        assert!(soft.data.iter().filter(|v| **v != 0.0).count() > 3, "{filter}");
    }
    // The colour is that of the black body: blue over red as an infinitely large one shows it.
    let sky = mean_colour(&picture(&looking("", r#"LightSource "infinite" "blackbody L" 6000 "float scale" 1e-4"#)).0);
    let own = mean_colour(&sharp);
    assert!((own[2] / own[0] / (sky[2] / sky[0]) - 1.0).abs() < 0.03, "{own:?} {sky:?}");
}

fn mean_colour(picture: &Picture) -> [f64; 3] {
    std::array::from_fn(|c| picture.data.iter().skip(c).step_by(3).map(|v| f64::from(*v)).sum())
}

#[test]
fn spherical_cameras_show_all_stars_once() {
    // All over the sky, on the seams of the maps too.
    let mut text = "x,y,z,mag\n".to_owned();
    for (x, y, z) in (0..27).map(|i| (i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1)).filter(|p| *p != (0, 0, 0)) {
        text += &format!("{x},{y},{z},0\n");
    }
    let light = format!(r#"LightSource "stars" {STAR} "string filename" "{}""#, catalogue("all", &text));
    for filter in ["box", "triangle"] {
        let film = format!(
            r#"Camera "spherical" "string mapping" "equalarea" Film "rgb" "integer xresolution" 50 "integer yresolution" 50
               PixelFilter "{filter}""#
        );
        let (picture, counters) = picture(&looking(&film, &light));
        assert!(counters.points == 26 && counters.images == 26, "{counters:?}");
        let seen: f64 = picture.data.chunks_exact(3).map(luminance).sum::<f64>() * 4.0 * PI / 2500.0;
        assert!((seen / (26.0 * BRIGHT) - 1.0).abs() < 1e-4, "{filter}: {}", seen / (26.0 * BRIGHT));
    }
    let film =
        r#"Camera "spherical" "string mapping" "equirectangular" Film "rgb" "integer xresolution" 401 "integer yresolution" 201"#;
    let (picture, _) = picture(&looking(&format!("{film} PixelFilter \"box\""), &light));
    let solid_angle = |y: usize| (PI * (y as f64 + 0.5) / 201.0).sin() * 2.0 * PI / 401.0 * PI / 201.0;
    // Stars at the poles are in pixels that turn around them: only the others have the light of their pixels.
    let band = |y: usize| (20..181).contains(&y);
    let seen: f64 =
        (0..201 * 401).filter(|i| band(i / 401)).map(|i| luminance(picture.pixel(i % 401, i / 401)) * solid_angle(i / 401)).sum();
    assert!((seen / (24.0 * BRIGHT) - 1.0).abs() < 0.02, "{}", seen / (24.0 * BRIGHT));
}

/// The two images by a distant lens: Einstein 1936, in the limit of weak bending.
#[test]
fn far_holes_magnify_as_lenses_do() {
    // Einstein's angle of a source infinitely far behind: sqrt(4 M/D).
    let distance = 1e6;
    let ring = f64::sqrt(2.0 / distance);
    for u in [0.3, 1.0, 1.7] {
        let fov = (8.0 * ring).to_degrees();
        let file = star("lens", [u * ring, 0.0, 1.0]);
        let text = format!(
            r#"
            Film "rgb" "integer xresolution" 400 "integer yresolution" 400
            Sampler "independent" "integer pixelsamples" 1
            PixelFilter "box"
            LookAt 0 0 {}  0 0 0  0 1 0
            Camera "perspective" "float fov" {fov}
            WorldBegin
            BlackHole "schwarzschild" "float rs" 1
            LightSource "stars" {STAR} "string filename" "{file}"
            "#,
            -distance
        );
        let (picture, counters) = picture(&text);
        assert_eq!(counters.images, 2);
        let root = (u * u + 4.0).sqrt();
        for (sign, holds) in [(1.0, (|x, _| x >= 200) as fn(usize, usize) -> bool), (-1.0, |x, _| x < 200)] {
            let magnification = 0.5 * ((u * u + 2.0) / (u * root) + sign);
            let seen = irradiance(&picture, fov, holds);
            assert!((seen / (BRIGHT * magnification) - 1.0).abs() < 5e-3, "{u} {sign}: {}", seen / (BRIGHT * magnification));
            // Where it is: (u +- sqrt(u^2 + 4)) / 2, within a pixel and the next order of bending.
            let x = 200.0 + 50.0 * 0.5 * (u + sign * root);
            let lit =
                (0..400).find(|i| holds(*i, 0) && luminance(picture.pixel(*i, 200)) + luminance(picture.pixel(*i, 199)) > 0.0);
            let lit = lit.expect("there is an image") as f64 + 0.5;
            assert!((lit - x).abs() < 0.8, "{u} {sign}: {lit} {x}");
        }
    }
}

/// Points against discs that camera rays find: near a hole, moving or not, direct and round the back.
#[test]
fn points_have_the_light_of_small_discs() {
    for (camera, direction, back) in [
        ("", [0.12, 0.05, 1.0], true),
        (r#""vector3 velocity" [0.3 0.2 0.3]"#, [-0.1, 0.09, 1.0], true),
        ("", [0.35, 0.12, 1.0], false),
    ] {
        let light = |radius: f64| {
            format!(r#"LightSource "stars" {STAR} "float radius" {radius} "string filename" "{}""#, star("discs", direction))
        };
        let scene = |lens: &str, samples: u32, light: &str| {
            format!(
                r#"
                Film "rgb" "integer xresolution" 64 "integer yresolution" 64
                Sampler "sobol" "integer pixelsamples" {samples}
                PixelFilter "box"
                Integrator "adaptive"
                LookAt 0 0 -8  0 0 0  0 1 0
                Camera "perspective" "float fov" 80 {camera} {lens}
                WorldBegin
                BlackHole "schwarzschild" "float rs" 0.5
                {light}
                "#
            )
        };
        let (points, counters) = picture(&scene("", 1, &light(0.05)));
        assert_eq!(counters.images, 2);
        // A camera with a lens, however small, sees discs.
        let (discs, none) = picture(&scene(r#""float lensradius" 1e-9"#, 400, &light(0.8)));
        assert_eq!(none, PointCounters::default());
        // The images of this star on both sides of the line through the hole that is at right angles to it.
        let side = |x: usize, y: usize| (x as f64 - 31.5) * direction[0] - (y as f64 - 31.5) * direction[1] >= 0.0;
        let moves = !camera.is_empty();
        for first in [true, false].into_iter().filter(|first| *first || (back && !moves)) {
            let holds = |x: usize, y: usize| moves || side(x, y) == first;
            let [point, disc] = [&points, &discs].map(|p| irradiance(p, 80.0, holds));
            assert!(point > 0.0 && (point / disc - 1.0).abs() < 0.04, "{camera} {direction:?} {first}: {point} {disc}");
        }
    }
}

#[test]
fn moving_cameras_see_stars_aberrated_and_shifted() {
    let (v, theta) = (0.6f64, 0.5f64);
    let light = format!(r#"LightSource "stars" {STAR} "string filename" "{}""#, star("moving", [theta.sin(), 0.0, theta.cos()]));
    // Fine enough that the solid angle of a pixel is the same all over it.
    let options = r#"PixelFilter "box" Camera "perspective" "float fov" 40 "vector3 velocity" [0 0 0.6]
        Film "rgb" "integer xresolution" 600 "integer yresolution" 400"#;
    let text = looking(options, &light);
    let (picture, _) = picture(&text);
    // Einstein 1905: cos theta' = (cos theta + v) / (1 + v cos theta), E'/E = (1 + v cos theta) / sqrt(1 - v^2).
    let seen_at = ((theta.cos() + v) / (1.0 + v * theta.cos())).acos();
    let pixel = 2.0 * 20f64.to_radians().tan() / 400.0;
    let x = 300.0 + seen_at.tan() / pixel;
    let lit: Vec<usize> = (0..240_000).filter(|i| picture.data[3 * i + 1] != 0.0).collect();
    assert!(lit.len() == 1 && lit[0] % 600 == x as usize, "{lit:?} {x}");
    // A black body is seen as one of the temperature times the Doppler factor, under a solid angle over its square.
    let doppler = (1.0 + v * theta.cos()) / (1.0 - v * v).sqrt();
    let expected = BRIGHT * black_body(6000.0 * doppler) / black_body(6000.0) / doppler.powi(2);
    let seen = irradiance(&picture, 40.0, |_, _| true);
    assert!((seen / expected - 1.0).abs() < 3e-3, "{}", seen / expected);
}

#[test]
fn stars_overhead_are_blue_and_bright_deep_in_the_well() {
    let light = format!(r#"LightSource "stars" {STAR} "string filename" "{}""#, star("deep", [1e-3, 0.0, 1.0]));
    // Looking straight up, away from a hole behind the camera, at 1.2 times its radius.
    let hole = r#"BlackHole "schwarzschild" "float rs" 1 "point3 center" [0 0 -1.2]"#;
    let (seen, _) = picture(&looking(r#"PixelFilter "box""#, &format!("{hole} {light}")));
    // Near the radial ray the angle at the sky is that at the camera over N: its solid angle is N^2 times as large here.
    let lapse = f64::sqrt(1.0 - 1.0 / 1.2);
    let expected = BRIGHT * lapse.powi(2) * black_body(6000.0 / lapse) / black_body(6000.0);
    let seen = irradiance(&seen, 40.0, |x, y| (25..35).contains(&x) && (15..25).contains(&y));
    assert!((seen / expected - 1.0).abs() < 3e-3, "{}", seen / expected);
}

#[test]
fn walls_hide_stars_and_mirrors_show_them() {
    let light = |z: f64| {
        format!(
            r#"LightSource "stars" {STAR} "float radius" 1 "string filename" "{}""#,
            star(&format!("wall{z}"), [0.05, 0.02, z])
        )
    };
    let wall = |material: &str| {
        format!(r#"{material} Shape "trianglemesh" "integer indices" [0 2 1  0 3 2] "point3 P" [-9 -9 3  9 -9 3  9 9 3  -9 9 3]"#)
    };
    let black = wall(r#"Material "diffuse" "spectrum reflectance" 0"#);
    let (hidden, counters) = picture(&looking("", &format!("{} {black}", light(1.0))));
    assert!(hidden.data.iter().all(|v| *v == 0.0) && counters.occluded == 1 && counters.images == 0);
    // Camera rays do not see the disc as well, however many there are.
    let many = r#"PixelFilter "box" Sampler "independent" "integer pixelsamples" 64"#;
    let (direct, _) = picture(&looking(many, &light(1.0)));
    assert_eq!(direct.data.iter().filter(|v| **v != 0.0).count(), 3);
    let many = r#"PixelFilter "box" Sampler "sobol" "integer pixelsamples" 1024"#;
    let (mirrored, counters) = picture(&looking(many, &format!("{} {}", light(-1.0), wall(r#"Material "mirror""#))));
    assert_eq!(counters.images, 0);
    let seen = irradiance(&mirrored, 40.0, |_, _| true);
    assert!((seen / BRIGHT - 1.0).abs() < 0.02, "{}", seen / BRIGHT);
}

#[test]
fn stars_light_surfaces() {
    let file = catalogue("lit", "ra,dec,mag,temperature\n90,90,0,6000\n0,30,0,6000\n0,-30,-3,6000\n");
    let light = format!(r#"Rotate -90 1 0 0 LightSource "stars" {STAR} "float radius" 0.5 "string filename" "{file}""#);
    let sampled = r#"LightTransport "path" "integer maxdepth" 1 Sampler "sobol" "integer pixelsamples" 2048"#;
    // From the zenith and 30 degrees above the horizon; the third is below.
    let expected = 0.8 / PI * BRIGHT * 1.5;
    let seen = floor(sampled, &light);
    assert!((seen / expected - 1.0).abs() < 0.02, "{}", seen / expected);
}

/// The catalogue that comes with the scenes: Sirius is the brightest, Rigel and Betelgeuse are 18.6 degrees apart (Orion, any almanac).
#[test]
fn the_catalogue_is_our_sky() {
    let built = common::build(&looking("", r#"LightSource "stars" "string filename" "scenes/stars/hipparcos.csv""#));
    let light = &built.scene.light_sampler.lights[0];
    let near = |ra: f64, dec: f64| {
        let ((s, c), (z, across)) = (ra.to_radians().sin_cos(), dec.to_radians().sin_cos());
        let direction = glam::DVec3::new(across * c, -across * s, z);
        let number = (0..light.points().len()).min_by(|a, b| {
            let [a, b] = [a, b].map(|i| (light.points()[*i] - direction).length());
            a.total_cmp(&b)
        });
        let number = number.expect("there are stars");
        assert!((light.points()[number] - direction).length() < 1e-3);
        (light.points()[number], light.point_irradiance(number, [650.0, 550.0, 450.0, 400.0]).0)
    };
    let ((_, sirius), (rigel, blue), (betelgeuse, red)) = (near(101.287, -16.716), near(78.634, -8.202), near(88.793, 7.407));
    let all = (0..light.points().len()).map(|i| light.point_irradiance(i, [550.0; 4]).0[0]);
    assert_eq!((light.points().len(), all.fold(0.0, f32::max)), (9341, sirius[1]));
    // Seen with north up (+z), Betelgeuse is to the left of Rigel. Who looks along d in a left-handed space has z x d, by components, to the right.
    assert!(glam::DVec3::Z.cross(rigel).dot(betelgeuse - rigel) < 0.0);
    assert!((rigel.angle_between(betelgeuse).to_degrees() - 18.6).abs() < 0.05);
    assert!(blue[2] > 1.5 * blue[0] && red[0] > 1.5 * red[2], "{blue:?} {red:?}");
}

#[test]
fn pictures_of_stars_are_the_same_for_any_number_of_threads_and_crop() {
    let scene = |film: &str| {
        format!(
            r#"
            {film}
            Sampler "independent" "integer pixelsamples" 1
            LookAt 0 0 -8  0 0 0  0 1 0
            Camera "perspective" "float fov" 60
            WorldBegin
            BlackHole "schwarzschild" "float rs" 0.5
            LightSource "stars" "integer number" 3000 {STAR}
            Shape "sphere" "float radius" 1
            "#
        )
    };
    let film = r#"Film "spectral" "integer nbuckets" 3 "integer xresolution" 80 "integer yresolution" 60"#;
    let draw = |built: &bhs::lang::BuiltScene, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start");
        pool.install(|| sky_points::draw(&bhs::render::Job::of(built))).expect("there are stars")
    };
    let built = common::build(&scene(film));
    let [one, three] = [1, 3].map(|threads| draw(&built, threads));
    assert!(one.counters == three.counters && one.counters.images > 100 && one.counters.occluded > 0, "{:?}", one.counters);
    let cropped = common::build(&scene(&format!("{film} \"float cropwindow\" [0.25 0.5 0.5 1]")));
    let part = draw(&cropped, 2);
    let mut lit = 0;
    for (x, y) in (0..60).flat_map(|y| (0..80).map(move |x| (x, y))) {
        assert_eq!(one.pixel([x, y]), three.pixel([x, y]));
        let inside = (20..40).contains(&x) && (30..60).contains(&y);
        assert_eq!(part.pixel([x, y]), one.pixel([x, y]).filter(|_| inside), "{x} {y}");
        lit += usize::from(one.pixel([x, y]).is_some());
    }
    assert!(lit > 300);
    // Normals do not shine.
    let normals = bhs::lang::Overrides { transport: Some("normals".to_owned()), ..Default::default() };
    assert!(sky_points::draw(&bhs::render::Job::of(&common::build_with(&scene(film), &normals))).is_none());
    let radiance = built.scene.sky((glam::DVec3::Z, bhs_core::spacetime::Side::Near), &wavelengths(), true);
    assert_eq!(radiance, SampledSpectrum::ZERO);
}

fn wavelengths() -> bhs_core::spectrum::SampledWavelengths {
    bhs_core::spectrum::SampledWavelengths::visible(0.3, 400.0, 700.0)
}
