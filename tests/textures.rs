//! Textures as they are seen: rendered squares against the numbers that the textures are made of.

use crate::common;
use bhs_core::spectrum::N_LAMBDA;
use std::path::Path;

const TEXELS: [usize; 2] = [6, 4];
const PIXELS: usize = 12;

/// The picture's values, rows from the top.
fn texel(x: usize, y: usize) -> [u8; 3] {
    [(40 * x + 20) as u8, (60 * y + 15) as u8, if (x + y).is_multiple_of(2) { 30 } else { 200 }]
}

fn write_picture(folder: &Path) -> String {
    let [w, h] = TEXELS;
    let bytes: Vec<u8> = (0..h).flat_map(|y| (0..w).flat_map(move |x| texel(x, y))).collect();
    let path = folder.join("picture.png");
    image::save_buffer(&path, &bytes, w as u32, h as u32, image::ColorType::Rgb8).expect("the picture can be written");
    path.to_str().expect("a path of letters").to_owned()
}

/// A square that fills the frame exactly, with (u, v) from (0, 0) at its lower left to (1, 1), under even light of the colour white.
fn square(world: &str) -> String {
    format!(
        r#"
        Camera "perspective" "float fov" 90
        Film "rgb" "integer xresolution" {PIXELS} "integer yresolution" {PIXELS}
        Sampler "sobol" "integer pixelsamples" 2048
        LightTransport "path" "integer maxdepth" 1
        WorldBegin
        LightSource "infinite" "rgb L" [1 1 1]
        {world}
        Shape "trianglemesh" "point3 P" [-1 -1 1  1 -1 1  1 1 1  -1 1 1] "point2 uv" [0 0  1 0  1 1  0 1]
            "integer indices" [0 1 2  0 2 3]
        "#
    )
}

/// The pixels of a scene, rows from the top.
fn rendered(text: &str) -> Vec<[f64; 3]> {
    let frame = common::render(&common::build(text)).frame;
    let picture = frame.picture();
    (0..PIXELS * PIXELS)
        .map(|i| {
            let pixel = picture.pixel(i % PIXELS, i / PIXELS);
            std::array::from_fn(|c| f64::from(pixel[c]))
        })
        .collect()
}

/// Compares a scene with `expected(u, v)`, the mean of which over each pixel is taken here.
fn check(name: &str, text: &str, expected: &dyn Fn(f64, f64) -> [f64; 3]) {
    const FINE: usize = 24;
    for (i, found) in rendered(text).into_iter().enumerate() {
        let (x, y) = (i % PIXELS, i / PIXELS);
        let mut mean = [0.0; 3];
        for (a, b) in (0..FINE).flat_map(|a| (0..FINE).map(move |b| (a, b))) {
            let part = |pixel: usize, sub: usize| (pixel as f64 + (sub as f64 + 0.5) / FINE as f64) / PIXELS as f64;
            let value = expected(part(x, a), 1.0 - part(y, b));
            mean.iter_mut().zip(value).for_each(|(m, v)| *m += v / (FINE * FINE) as f64);
        }
        for c in 0..3 {
            assert!((found[c] - mean[c]).abs() < 0.02, "{name}, pixel {x} {y}: {found:?}, not {mean:?}");
        }
    }
}

/// IEC 61966-2-1.
fn linear(byte: u8) -> f64 {
    let v = f64::from(byte) / 255.0;
    if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) }
}

/// Column and row of a place on the repeated picture, both as fractions.
fn at(s: f64, t: f64) -> (f64, f64) {
    (s * TEXELS[0] as f64, (1.0 - t) * TEXELS[1] as f64)
}

fn repeated(x: f64, y: f64) -> [f64; 3] {
    let column = x.rem_euclid(TEXELS[0] as f64) as usize;
    let row = y.rem_euclid(TEXELS[1] as f64) as usize;
    texel(column, row).map(linear)
}

#[test]
fn a_picture_lies_on_a_square_as_in_pbrt() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = write_picture(folder.path());
    let image = |more: &str| {
        square(&format!(
            r#"Texture "picture" "spectrum" "imagemap" "string filename" "{path}" {more}
            Material "diffuse" "texture reflectance" "picture""#
        ))
    };
    // Two pixels a texel: upright, the first row at the top.
    check("point", &image(r#""string filter" "point""#), &|u, v| {
        let (x, y) = at(u, v);
        repeated(x, y)
    });
    // The mean of four texels' middles.
    check("bilinear", &image(""), &|u, v| {
        let (x, y) = at(u, v);
        let (x, y) = (x - 0.5, y - 0.5);
        let (fx, fy) = (x - x.floor(), y - y.floor());
        std::array::from_fn(|c| {
            let corner = |i: f64, j: f64| repeated(x.floor() + i, y.floor() + j)[c];
            (corner(0.0, 0.0) * (1.0 - fx) + corner(1.0, 0.0) * fx) * (1.0 - fy)
                + (corner(0.0, 1.0) * (1.0 - fx) + corner(1.0, 1.0) * fx) * fy
        })
    });
    let moved = r#""string filter" "point" "float uscale" 2 "float vscale" -1.5 "float udelta" 0.25 "float vdelta" 1"#;
    check("moved", &image(moved), &|u, v| {
        let (x, y) = at(2.0 * u + 0.25, -1.5 * v + 1.0);
        repeated(x, y)
    });
    let inside = |s: f64, t: f64| (0.0..1.0).contains(&s) && (0.0..1.0).contains(&t);
    let outside = r#""string filter" "point" "float uscale" 2 "float vscale" 2 "float udelta" -0.5 "float vdelta" -0.5"#;
    check("black", &image(&format!(r#"{outside} "string wrap" "black""#)), &|u, v| {
        let (s, t) = (2.0 * u - 0.5, 2.0 * v - 0.5);
        let (x, y) = at(s, t);
        if inside(s, t) { repeated(x, y) } else { [0.0; 3] }
    });
    check("clamp", &image(&format!(r#"{outside} "string wrap" "clamp""#)), &|u, v| {
        let (x, y) = at((2.0 * u - 0.5).clamp(0.0, 1.0 - 1e-9), (2.0 * v - 0.5).clamp(1e-9, 1.0));
        repeated(x, y)
    });
    check("scaled and inverted", &image(r#""string filter" "point" "float scale" 0.5 "bool invert" true"#), &|u, v| {
        let (x, y) = at(u, v);
        repeated(x, y).map(|c| 1.0 - 0.5 * c)
    });
    let encoded = |f: &dyn Fn(f64) -> f64, u: f64, v: f64| {
        let (x, y) = at(u, v);
        texel(x as usize, y as usize).map(|b| f(f64::from(b) / 255.0))
    };
    check("linear", &image(r#""string filter" "point" "string encoding" "linear""#), &|u, v| encoded(&|c| c, u, v));
    check("gamma", &image(r#""string filter" "point" "string encoding" "gamma 1.8""#), &|u, v| encoded(&|c| c.powf(1.8), u, v));
}

#[test]
fn boards_mixes_and_scales_are_what_they_are_made_of() {
    let odd = |u: f64, v: f64| (u.floor() + v.floor()).rem_euclid(2.0) == 1.0;
    let board = r#"Texture "board" "spectrum" "checkerboard" "float uscale" 4 "float vscale" 3
            "rgb tex1" [0.8 0.3 0.1] "spectrum tex2" 0.05
        Material "diffuse" "texture reflectance" "board""#;
    let colour = |u: f64, v: f64| if odd(4.0 * u, 3.0 * v) { [0.05; 3] } else { [0.8, 0.3, 0.1] };
    check("board", &square(board), &colour);
    let mix = r#"Material "diffuse" "texture reflectance" "mix"
        Texture "mix" "spectrum" "mix" "texture tex1" "half" "rgb tex2" [0.1 0.2 0.9] "texture amount" "stripes"
        Texture "half" "spectrum" "scale" "texture tex" "base" "float scale" 0.5
        Texture "base" "spectrum" "constant" "rgb value" [0.8 0.4 0.2]
        Texture "stripes" "float" "checkerboard" "float vscale" 4 "float tex1" 0.25 "float tex2" 1"#;
    check("mix", &square(mix), &|u, v| {
        let amount = if odd(u, 4.0 * v) { 1.0 } else { 0.25 };
        let blue = [0.1, 0.2, 0.9];
        std::array::from_fn(|c| (1.0 - amount) * [0.4, 0.2, 0.1][c] + amount * blue[c])
    });
}

#[test]
fn a_texture_of_one_colour_is_that_colour_also_where_light_shifts() {
    let hole = |material: &str| {
        common::build(&format!(
            r#"
            LookAt 0 0 -8  0 0 0  0 1 0
            Camera "perspective" "float fov" 40
            Film "rgb" "integer xresolution" 8 "integer yresolution" 8
            Sampler "sobol" "integer pixelsamples" 4
            WorldBegin
            BlackHole "schwarzschild" "float rs" 1
            LightSource "infinite" "blackbody L" 4000
            {material}
            Translate 1.5 0 0
            Shape "sphere" "float radius" 1
            "#
        ))
    };
    let plain = hole(r#"Material "diffuse" "rgb reflectance" [0.8 0.3 0.1]"#);
    let textured = hole(
        r#"Texture "c" "spectrum" "constant" "rgb value" [0.8 0.3 0.1]
        Material "diffuse" "texture reflectance" "c""#,
    );
    let [a, b] = [plain, textured].map(|scene| common::render(&scene).frame);
    assert_eq!(a.picture(), b.picture());
}

#[test]
fn what_nothing_uses_is_not_read() {
    let scene = common::build(
        r#"
        WorldBegin
        LightSource "infinite"
        Texture "missing" "spectrum" "imagemap" "string filename" "there is no such file.png"
        MakeNamedMaterial "unused" "string type" "diffuse" "texture reflectance" "missing"
        Shape "sphere"
        "#,
    );
    let warnings: Vec<&str> = scene.warnings.iter().map(|w| w.code).collect();
    assert_eq!(warnings, ["unused-texture", "unused-material"]);
}

#[test]
fn glass_that_disperses_stands_unseen_in_even_light() {
    // Whatever light goes through it, nothing is lost: a furnace of radiance 1 at all wavelengths.
    for (glass, slack) in [(r#""spectrum eta" "glass-SF11""#, 0.01), (r#""float eta" 1.5"#, 1e-4)] {
        let scene = common::build(&format!(
            r#"
            Sampler "independent" "integer pixelsamples" 1
            LightTransport "path" "integer maxdepth" 100 "integer rrdepth" 1000
            WorldBegin
            LightSource "infinite" "spectrum L" 1
            Material "dielectric" {glass}
            Translate 0 0 4
            Shape "sphere" "float radius" 2
            "#
        ));
        for x in [0.0, 0.2, 0.42] {
            let direction = glam::DVec3::new(x, 0.0, 1.0).normalize();
            let n = 4000;
            let mut sum = 0.0;
            for i in 0..n {
                let light =
                    common::physics::radiance(&scene, direction, [430.0, 520.0, 589.0, 680.0], i, &mut Default::default());
                sum += f64::from(light.iter().sum::<f32>()) / (N_LAMBDA as f64 * f64::from(n));
            }
            assert!((sum - 1.0).abs() < slack, "{glass} at {x}: {sum}");
        }
    }
}
