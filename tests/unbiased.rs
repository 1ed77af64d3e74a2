//! Light sampling along geodesics changes no mean: `path` with it, `path` without it and `hemisphere` give the same picture, block by
//! block, within noise.
//!
//! Every method renders each scene a number of times with different seeds; the spread of the results is the error of their mean. Two
//! methods agree if the differences of their block means, in units of their errors, are distributed as they should be by chance.
//!
//! The default is a quick check of some per cent. Half a per cent takes minutes for each scene:
//! `BHS_UNBIASED=64 cargo test --release --test all unbiased:: -- --nocapture --test-threads 1` (the number multiplies the samples).

use crate::common;
use bhs::lang::Overrides;

/// Size of the pictures (pixels) and of a block.
const SIZE: [u32; 2] = [32, 24];
const BLOCK: u32 = 8;
/// Renders of each method: enough for the spread of their mean to be known to some 13 %.
const RENDERS: u64 = 32;

/// Means of the blocks over all renders, and their standard errors: luminance-like sums of the channels.
struct Blocks {
    mean: Vec<f64>,
    error: Vec<f64>,
}

impl Blocks {
    fn relative_error(&self) -> f64 {
        let of_all: f64 = self.mean.iter().sum::<f64>() / self.mean.len() as f64;
        self.error.iter().fold(0.0, |m: f64, e| m.max(e / of_all))
    }
}

fn measure(text: &str, transport: &str, samples: u32) -> Blocks {
    let text = with_transport(text, transport);
    let columns = SIZE[0] / BLOCK;
    let count = (columns * SIZE[1] / BLOCK) as usize;
    let (mut sums, mut squares) = (vec![0.0; count], vec![0.0; count]);
    for seed in 0..RENDERS {
        // Other seeds for each method: common random numbers would hide in the errors.
        let seed = seed + 1000 * (transport.len() as u64);
        let overrides = Overrides { spp: Some(samples), resolution: Some(SIZE), seed: Some(seed), ..Default::default() };
        let built = common::build_with(&text, &overrides);
        let rendered = common::render(&built);
        assert_eq!(rendered.counters.not_finite, 0, "{transport}");
        let picture = rendered.frame.picture();
        let mut blocks = vec![0.0; count];
        for y in 0..SIZE[1] {
            for x in 0..SIZE[0] {
                let value: f64 = picture.pixel(x as usize, y as usize)[..3].iter().map(|v| f64::from(*v)).sum();
                blocks[(y / BLOCK * columns + x / BLOCK) as usize] += value / f64::from(3 * BLOCK * BLOCK);
            }
        }
        for (i, b) in blocks.into_iter().enumerate() {
            sums[i] += b;
            squares[i] += b * b;
        }
    }
    let n = RENDERS as f64;
    let mean: Vec<f64> = sums.iter().map(|s| s / n).collect();
    let error = mean.iter().zip(&squares).map(|(m, s)| ((s / n - m * m).max(0.0) / (n - 1.0)).sqrt()).collect();
    Blocks { mean, error }
}

/// The scene with its line `LightTransport` replaced.
fn with_transport(text: &str, transport: &str) -> String {
    let lines = text.lines().map(|l| if l.starts_with("LightTransport") { transport } else { l });
    lines.collect::<Vec<_>>().join("\n")
}

/// Both methods' blocks, compared: every difference below 4.5 standard errors (one block in some 10,000 by chance, with so few renders),
/// and their mean square not above what chance makes of it in one case of a thousand.
fn agree(scene: &str, names: [&str; 2], a: &Blocks, b: &Blocks) {
    let z: Vec<f64> = (0..a.mean.len())
        .map(|i| {
            let error = a.error[i].hypot(b.error[i]);
            if error == 0.0 { 0.0 } else { (a.mean[i] - b.mean[i]) / error }
        })
        .collect();
    let n = z.len() as f64;
    let worst = z.iter().fold(0.0f64, |m, z| m.max(z.abs()));
    let square = z.iter().map(|z| z * z).sum::<f64>() / n;
    let ratio = a.mean.iter().sum::<f64>() / b.mean.iter().sum::<f64>();
    let error = |v: &Blocks| v.error.iter().map(|e| e * e).sum::<f64>().sqrt() / v.mean.iter().sum::<f64>();
    eprintln!(
        "{scene}: {} / {} = {ratio:.5} +- {:.5}; largest |z| {worst:.2}, mean z^2 {square:.2}; largest error of a block {:.2} % and {:.2} %",
        names[0],
        names[1],
        error(a).hypot(error(b)),
        100.0 * a.relative_error(),
        100.0 * b.relative_error()
    );
    assert!(worst < 4.5, "{scene}: {names:?} differ: {z:.2?}");
    // Of n squares of standard normal numbers: mean 1, standard deviation sqrt(2/n).
    assert!(square < 1.0 + 3.5 * (2.0 / n).sqrt() + 4.0 / n, "{scene}: {names:?} differ: {z:.2?}");
}

/// A scene of the project whose hole has other parameters: from its name to the end of its line.
fn scene(file: &str, hole: &str) -> String {
    let text = common::read(&format!("scenes/{file}.bhs"));
    let text = text.replace("Include \"include/", "Include \"scenes/include/").replace("\"meshes/", "\"scenes/meshes/");
    assert!(text.contains("\"bool redshift\" false"), "{file}");
    text.replace("\"bool redshift\" false", hole)
}

fn check(name: &str, text: &str, depth: u32, samples: [u32; 3]) {
    let more: u32 = std::env::var("BHS_UNBIASED").map_or(1, |n| n.parse().expect("BHS_UNBIASED is a number"));
    let [sampled, by_chance, uniform] = [
        (format!("LightTransport \"path\" \"integer maxdepth\" {depth}"), samples[0]),
        (format!("LightTransport \"path\" \"integer maxdepth\" {depth} \"bool lightsampling\" false"), samples[1]),
        (format!("LightTransport \"hemisphere\" \"integer maxdepth\" {depth}"), samples[2]),
    ]
    .map(|(transport, samples)| measure(text, &transport, samples * more));
    agree(name, ["path", "path by chance"], &sampled, &by_chance);
    agree(name, ["path", "hemisphere"], &sampled, &uniform);
}

/// Directions that follow what was learned against those that materials choose: in flat space, and around a hole.
#[test]
fn guiding_changes_no_mean() {
    let flat = common::read("scenes/cornell_box.bhs");
    let bent = scene("cornell_hole", REDSHIFT);
    for (name, text) in [("cornell_box", &flat), ("cornell_hole", &bent)] {
        let [guided, unguided] = [true, false].map(|guiding| {
            let transport = format!("LightTransport \"path\" \"integer maxdepth\" 6 \"bool guiding\" {guiding}");
            measure(text, &transport, 32)
        });
        agree(name, ["guided", "unguided"], &guided, &unguided);
    }
}

const FLAT_TIME: &str = "\"bool redshift\" false";
const CHART: &str = "\"bool redshift\" false \"string frame\" \"chart\"";
const REDSHIFT: &str = "\"bool redshift\" true";

#[test]
fn in_the_cornell_room() {
    check("cornell_hole", &scene("cornell_hole", FLAT_TIME), 6, [4, 4, 6]);
    check("cornell_hole, chart frame", &scene("cornell_hole", CHART), 6, [4, 4, 6]);
    check("cornell_hole, redshift", &scene("cornell_hole", REDSHIFT), 6, [4, 4, 6]);
}

#[test]
fn with_a_mirror_and_glass() {
    check("spheres_hole", &scene("spheres_hole", FLAT_TIME), 6, [4, 4, 6]);
}

#[test]
fn with_a_golden_dragon() {
    if !common::root().join("scenes/meshes/dragon_vrip.ply.gz").exists() {
        eprintln!("skipped: the dragon's mesh is not here; ./test fetches it");
        return;
    }
    check("gold_dragon", &scene("gold_dragon", FLAT_TIME), 6, [4, 4, 6]);
}

/// A lamp exactly behind a large hole, which throws its ring on the wall in front; the hole close to the wall that the camera sees.
#[test]
fn with_the_lamp_exactly_behind_the_hole() {
    for (name, hole) in [("static", REDSHIFT), ("chart", CHART)] {
        let text = format!(
            r#"
            LightTransport "path"
            Film "rgb" "integer xresolution" 32 "integer yresolution" 24
            Include "scenes/include/camera.bhs"
            WorldBegin
            Material "diffuse" "spectrum reflectance" 0.5
            Shape "trianglemesh" "integer indices" [0 1 2  0 2 3  4 6 5  4 7 6]
                "point3 P" [-1 0 -1   1 0 -1   1 1.5 -1   -1 1.5 -1   -1 0 1  1 0 1  1 0 -1  -1 0 -1]
            AttributeBegin
                AreaLightSource "diffuse" "spectrum L" 10 "bool twosided" true
                Translate 0 0.75 0.8
                Shape "sphere" "float radius" 0.08
            AttributeEnd
            BlackHole "schwarzschild" "point3 center" [0 0.75 -0.2] "float rs" 0.2 {hole}
            "#
        );
        check(&format!("ring, {name}"), &text, 3, [4, 16, 24]);
    }
}

/// A closed room with a lamp, around what bends light in its middle; `far` is what stands on the far side, if there is one.
fn bent_room(integrator: &str, spacetime: &str, far: &str) -> String {
    format!(
        r#"
        LightTransport "path"
        {integrator}
        Film "rgb" "integer xresolution" 32 "integer yresolution" 24
        Include "scenes/include/camera.bhs"
        WorldBegin
        {spacetime}
        Material "diffuse" "spectrum reflectance" 0.5
        Shape "trianglemesh" "integer indices" [0 1 2  0 2 3  4 6 5  4 7 6  0 4 5  0 5 1  3 2 6  3 6 7  0 3 7  0 7 4  1 5 6  1 6 2]
            "point3 P" [-1 0 -1   1 0 -1   1 1.5 -1   -1 1.5 -1   -1 0 4  1 0 4  1 1.5 4  -1 1.5 4]
        AttributeBegin
            AreaLightSource "diffuse" "spectrum L" 10
            Translate 0.5 1.2 0.5
            Shape "sphere" "float radius" 0.15
        AttributeEnd
        {far}
        "#
    )
}

#[test]
fn around_a_charged_hole() {
    let hole =
        r#"BlackHole "reissner-nordstrom" "point3 center" [0 0.75 -0.2] "float rs" 0.25 "float charge" 0.9 "bool redshift" true"#;
    check("charged", &bent_room("", hole, ""), 3, [4, 8, 12]);
}

#[test]
fn on_both_sides_of_a_wormhole() {
    let far = r#"
        AttributeBegin
            Side "far"
            LightSource "infinite" "rgb L" [0.1 0.2 0.4]
            Shape "trianglemesh" "integer indices" [0 1 2  0 2 3] "point3 P" [-2 0 -2  2 0 -2  2 0 2  -2 0 2]
            AttributeBegin
                AreaLightSource "diffuse" "spectrum L" 30
                Translate -0.8 1.4 -0.6
                Shape "sphere" "float radius" 0.25
            AttributeEnd
        AttributeEnd
    "#;
    let ellis = r#"Wormhole "ellis" "point3 center" [0 0.75 -0.2] "float throat" 0.7"#;
    check("ellis", &bent_room("", ellis, far), 3, [4, 8, 12]);
    let dneg = r#"Wormhole "dneg" "point3 center" [0 0.75 -0.2] "float throat" 0.4 "float length" 0.2 "float lensingwidth" 0.1"#;
    check("dneg", &bent_room("", dneg, far), 3, [2, 4, 4]);
}

#[test]
fn among_extremal_holes() {
    let connected = r#"Integrator "adaptive" "bool connections" true"#;
    let one = r#"BlackHole "majumdar-papapetrou" "point3 centers" [0 0.75 -0.2] "float masses" [0.1] "bool redshift" true"#;
    check("one extremal hole", &bent_room("", one, ""), 3, [4, 8, 12]);
    let two = r#"BlackHole "majumdar-papapetrou" "point3 centers" [-0.3 0.75 -0.2  0.3 0.7 -0.2] "float masses" [0.07 0.05]"#;
    check("two extremal holes", &bent_room(connected, two, ""), 3, [1, 4, 4]);
}

/// Spheres that shine, where light is straight: all but touching the floor, stretched, seen from inside through a veil, far from what they light, and over a
/// floor that moves.
#[test]
fn under_spheres_that_shine() {
    let lights = r#"
        AttributeBegin
            AreaLightSource "diffuse" "rgb L" [4 2 1]
            Translate -0.6 0.2005 0.3
            Shape "sphere" "float radius" 0.2
        AttributeEnd
        AttributeBegin
            AreaLightSource "diffuse" "rgb L" [1 2 4] "bool twosided" true
            Translate -0.4 1.1 0.2  Rotate 30 1 0.5 0  Scale 0.3 0.05 0.15
            Shape "sphere"
        AttributeEnd
        AttributeBegin
            Material "interface" "float transmits" 0.6
            AreaLightSource "diffuse" "rgb L" [0.5 1 0.5] "bool twosided" true
            Translate 0.35 0.4 -0.2
            Shape "sphere" "float radius" 0.35
        AttributeEnd
        AttributeBegin
            Translate 0.35 0.25 -0.2
            Shape "sphere" "float radius" 0.15
        AttributeEnd
        AttributeBegin
            Translate 0 0.01 0.5  Rotate -90 1 0 0
            Shape "disk" "float radius" 0.9 "string motion" "rotating" "float omega" 0.6
        AttributeEnd
    "#;
    check("spheres", &bent_room("", "", lights), 4, [8, 24, 32]);
}

/// Lights whose radiance varies over their surface, flat and of triangles, one of them a veil in front of the other; in flat space and around a hole.
#[test]
fn with_textured_lights_behind_a_veil() {
    for (name, hole) in [("flat", ""), ("hole", r#"BlackHole "schwarzschild" "point3 center" [0 0.75 -0.2] "float rs" 0.15"#)] {
        let lights = r#"
            Texture "board" "spectrum" "checkerboard" "float uscale" 4 "float vscale" 2 "rgb tex1" [9 8 6] "rgb tex2" [0.3 0.2 0.1]
            Texture "clouds" "spectrum" "fbm" "float uscale" 6 "float vscale" 3 "float offset" 0.8
            AttributeBegin
                Material "interface" "float transmits" 0.4
                AreaLightSource "diffuse" "texture L" "clouds" "bool twosided" true
                Translate -0.4 1.1 0.2  Rotate 60 1 0 0
                Shape "disk" "float radius" 0.4 "float innerradius" 0.1
            AttributeEnd
            AttributeBegin
                AreaLightSource "diffuse" "texture L" "board" "bool twosided" true
                Shape "trianglemesh" "integer indices" [0 1 2  0 2 3]
                    "point2 uv" [0 0 1 0 1 1 0 1] "point3 P" [-0.6 1.3 0   0.2 1.35 0   0.2 1.4 0.5   -0.6 1.35 0.5]
            AttributeEnd
        "#;
        let text = bent_room("", hole, lights);
        let (before, after) = text.split_once("AttributeBegin\n            AreaLightSource").expect("the room has a lamp");
        let (_, after) = after.split_once("AttributeEnd").expect("it ends");
        check(&format!("textured, {name}"), &format!("{before}{after}"), 4, [8, 8, 12]);
    }
}

/// A room that only a thin disc lights, whose matter moves: what light sampling draws from it and what BSDF sampling finds of it are the same.
#[test]
fn in_a_room_lit_by_a_thin_disc() {
    let disc = r#"
        AttributeBegin
            Translate 0 0.75 0.2  Rotate 20 0 0 1
            Material "diffuse" "spectrum reflectance" 0
            AreaLightSource "thindisc" "float temperature" 6000 "float scale" 1e-3 "vector3 axis" [0 1 0]
            Rotate -90 1 0 0
            Shape "disk" "float radius" 0.6 "string motion" "keplerian" "vector3 axis" [0 0 1]
        AttributeEnd
    "#;
    let hole = r#"BlackHole "schwarzschild" "point3 center" [0 0.75 0.2] "float rs" 0.1"#;
    let text = bent_room("", hole, disc);
    let (before, after) = text.split_once("AttributeBegin\n            AreaLightSource").expect("the room has a lamp");
    let (_, after) = after.split_once("AttributeEnd").expect("it ends");
    check("thin disc", &format!("{before}{after}"), 3, [8, 12, 16]);
}
