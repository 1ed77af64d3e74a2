//! Things thinner than a pixel, and thinner than rays stray, near a hole: the light that arrives from them is in proportion to their size,
//! and does not depend on how fine the picture is.

use crate::common;
use std::fmt::Write as _;

const INTEGRATORS: [&str; 3] = [r#""schwarzschild-adaptive""#, r#""schwarzschild-exact""#, r#""schwarzschild-rk4""#];

/// Beside the hole, where most things are.
const CROP: &str = "0.5 0.75 0.25 0.75";

/// Where a picture is looked at: pixels across the whole picture, samples a pixel.
type Fineness = (u32, u32);

/// The light of a world after at most `depth` reflections in the part `crop` of a picture whatever its resolution: sum of the pixels over
/// their number in the whole picture.
fn light(integrator: &str, (resolution, samples): Fineness, crop: &str, depth: u32, world: &str) -> f64 {
    // Light that comes by other surfaces passes the hole several times.
    let rs = if depth == 0 { 0.5 } else { 0.1 };
    let scene = format!(
        r#"
        LookAt 0 0 -8  0 0 0  0 1 0
        Camera "perspective" "float fov" 40
        Integrator {integrator}
        Film "rgb" "integer xresolution" {resolution} "integer yresolution" {resolution} "float cropwindow" [{crop}]
        PixelFilter "box"
        Sampler "sobol" "integer pixelsamples" {samples}
        LightTransport "path" "integer maxdepth" {depth}
        WorldBegin
        BlackHole "schwarzschild" "float rs" {rs} "bool redshift" false
        {world}
        "#
    );
    let picture = common::render(&common::build(&scene)).frame.picture();
    picture.data.chunks_exact(3).map(|p| f64::from(p[1])).sum::<f64>() / f64::from(resolution * resolution)
}

const GLOWING: &str =
    r#"Material "diffuse" "float reflectance" 0 AreaLightSource "diffuse" "rgb L" [1 1 1] "bool twosided" true"#;
const WALL: &str = r#"Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point3 P" [-9 -9 2 9 -9 2 9 9 2 -9 9 2]"#;

/// A glowing thing at each of `count` places between 0.5 and 1.1.
fn each(count: u32, thing: impl Fn(u32, f64) -> String) -> String {
    (0..count).fold(String::new(), |mut text, i| {
        let x = 0.5 + 0.6 * (f64::from(i) + 0.5) / f64::from(count);
        writeln!(text, "AttributeBegin\n{GLOWING}\n{}\nAttributeEnd", thing(i, x)).unwrap();
        text
    })
}

/// Upright wires, `2 size` wide.
fn wires(size: f64, count: u32) -> String {
    each(count, |_, x| {
        format!(
            "Translate {x} 0 0.5 Rotate 90 1 0 0 Shape \"cylinder\" \"float radius\" {size} \"float zmin\" -1 \"float zmax\" 1"
        )
    })
}

/// Upright ribbons of two triangles, `2 size` wide.
fn ribbons(size: f64, count: u32) -> String {
    each(count, |_, x| {
        let (a, b) = (x - size, x + size);
        format!(
            "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [{a} -1 0.5 {b} -1 0.5 {b} 1 0.5 {a} 1 0.5]"
        )
    })
}

/// Balls in columns of 22 or, where they are many, 88; none hides another.
fn balls(size: f64, count: u32) -> String {
    let rows = if count > 1000 { 88 } else { 22 };
    each(count, |i, x| {
        let y = 1.6 * (f64::from(i % rows) + 0.5) / f64::from(rows) - 0.8;
        format!("Translate {x} {y} 0.5 Shape \"sphere\" \"float radius\" {size}")
    })
}

/// A glowing wall behind a dark one with slits `2 size` wide between its planks.
fn slits(size: f64, count: u32) -> String {
    let pitch = 0.8 / f64::from(count);
    let planks = (0..=count).fold(String::new(), |text, i| {
        let middle = 0.5 + pitch * f64::from(i);
        let (a, b) = (middle - 0.5 * pitch + size, middle + 0.5 * pitch - size);
        let (a, b) = (if i == 0 { -9.0 } else { a }, if i == count { 9.0 } else { b });
        text + &format!(
            "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [{a} -9 0.6 {b} -9 0.6 {b} 9 0.6 {a} 9 0.6]\n"
        )
    });
    format!(
        "AttributeBegin\n{GLOWING}\n{WALL}\n\
         AttributeEnd\nMaterial \"diffuse\" \"float reflectance\" 0\n{planks}"
    )
}

/// Wires before the hole that a mirror behind it shows in the part of the picture that is looked at.
fn mirrored(size: f64, count: u32) -> String {
    format!(
        "AttributeBegin Translate 1 0 -1.5\n{}AttributeEnd Material \"mirror\" \"float reflectance\" 1\n{WALL}",
        wires(size, count)
    )
}

/// Small lamps that light a wall behind the hole.
fn bounced(size: f64, count: u32) -> String {
    let lamps = each(count, |i, x| {
        let (y, z) = (0.15 * f64::from(i % 11) - 0.75, 0.1 * f64::from(i % 5));
        format!(
            "Translate {} {y} {z} AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] Shape \"disk\" \"float radius\" {size}",
            x - 2.2
        )
    });
    format!(
        "{lamps}\nMaterial \"diffuse\" \"float reflectance\" 1\n\
         {WALL}"
    )
}

/// A lamp that lights a wall behind the hole through slits.
fn shaded(size: f64, count: u32) -> String {
    let pitch = 0.8 / f64::from(count);
    let planks = (0..=count).fold(String::new(), |text, i| {
        let middle = -0.4 + pitch * f64::from(i);
        let (a, b) = (middle - 0.5 * pitch + size, middle + 0.5 * pitch - size);
        let (a, b) = (if i == 0 { -9.0 } else { a }, if i == count { 9.0 } else { b });
        text + &format!(
            "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-0.5 {a} -9 -0.5 {b} -9 -0.5 {b} 9 -0.5 {a} 9]\n"
        )
    });
    format!(
        "AttributeBegin\n{GLOWING}\nTranslate -2 0 0 Shape \"sphere\" \"float radius\" 0.5\nAttributeEnd\n\
         Material \"diffuse\" \"float reflectance\" 1\n\
         {WALL}\n\
         Material \"diffuse\" \"float reflectance\" 0\n{planks}"
    )
}

/// What is measured of a kind of thing: its light over its size.
struct Case {
    name: &'static str,
    things: fn(f64, u32) -> String,
    /// The power of the size that the light is in proportion to.
    power: i32,
    /// Reflections on the way.
    depth: u32,
    /// Sizes and how many things: from an eighth of a pixel to a thousandth, of 32 across the picture.
    sizes: &'static [(f64, u32)],
}

const LINES: &[(f64, u32)] = &[(0.01, 16), (0.001, 64), (0.0001, 400)];
const SPOTS: &[(f64, u32)] = &[(0.005, 880), (0.001, 17600)];
const LAMPS: &[(f64, u32)] = &[(0.005, 16), (0.0001, 16)];

const CASES: [Case; 7] = [
    Case { name: "wires", things: wires, power: 1, depth: 0, sizes: LINES },
    Case { name: "ribbons", things: ribbons, power: 1, depth: 0, sizes: LINES },
    Case { name: "slits", things: slits, power: 1, depth: 0, sizes: LINES },
    Case { name: "balls", things: balls, power: 2, depth: 0, sizes: SPOTS },
    Case { name: "in a mirror", things: mirrored, power: 1, depth: 1, sizes: &[(0.01, 16), (0.0015, 200)] },
    Case { name: "lamps by shadow rays", things: bounced, power: 2, depth: 1, sizes: LAMPS },
    Case { name: "shadow rays through slits", things: shaded, power: 1, depth: 1, sizes: &[(0.003, 64), (0.001, 64)] },
];

#[test]
fn light_is_in_proportion_to_size_whatever_the_resolution() {
    // By `BHS_THIN=16 cargo test --release --test all thin::` with so many times the samples, and all resolutions.
    let more: Option<u32> = std::env::var("BHS_THIN").ok().map(|n| n.parse().expect("BHS_THIN is a number"));
    let mut wrong = 0;
    for Case { name, things, power, depth, sizes } in CASES {
        let mut reference = None;
        for integrator in INTEGRATORS {
            let all = more.is_some() || integrator == INTEGRATORS[0];
            // Few paths get through the narrower slits: only many samples tell 3 % there.
            let sizes = if name == "shadow rays through slits" && more.is_none() { &sizes[..1] } else { sizes };
            for (i, (size, count)) in sizes.iter().enumerate() {
                // What a mirror shows is farther, where rays stray as much more.
                let finenesses: &[Fineness] = match name {
                    "in a mirror" => &[(256, 32)],
                    _ if all => &[(128, 64), (32, 1024)],
                    _ => &[(32, 1024)],
                };
                for (resolution, samples) in finenesses {
                    // Of spots, and through slits, a few rays see what the others do not.
                    let noisy = if name == "slits" { 4 } else { u32::from(power == 2 && depth == 0) + 1 };
                    let samples = samples * more.unwrap_or(1) * noisy;
                    let found = light(integrator, (*resolution, samples), CROP, depth, &things(*size, *count));
                    let found = found / (size.powi(power) * f64::from(*count));
                    let reference = *reference.get_or_insert(found);
                    let off = found / reference - 1.0;
                    eprintln!("{name}, {integrator}, size {size}, {resolution} across: {found:.5}, {:+.1} %", 100.0 * off);
                    wrong += u32::from(off.abs() > if i == 0 { 0.02 } else { 0.03 });
                }
            }
        }
    }
    assert_eq!(wrong, 0, "see above");
}

#[test]
fn a_lamp_that_touches_the_horizon_is_as_bright_by_default_as_by_the_finest_chords() {
    let lamp = format!("{GLOWING}\nTranslate 0.62 0 0.2 Shape \"sphere\" \"float radius\" 0.15");
    let crop = "0.25 0.75 0.25 0.75";
    let fine = light(r#""schwarzschild-exact" "float tolerance" 1e-5"#, (128, 64), crop, 0, &lamp);
    for integrator in INTEGRATORS {
        for fineness in [(32, 1024), (128, 64)] {
            let off = light(integrator, fineness, crop, 0, &lamp) / fine - 1.0;
            eprintln!("{integrator}, {fineness:?}: {:+.2} %", 100.0 * off);
            assert!(off.abs() < 0.01, "{integrator} {fineness:?}: {off}");
        }
    }
}
