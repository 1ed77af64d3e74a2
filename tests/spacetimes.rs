//! Spacetimes other than the plain hole, in whole scenes: what the language says of them, rooms in thermal equilibrium, both sides of
//! wormholes, and cameras that move.

use crate::common;
use crate::common::physics::{planck, rgb_of};
use bhs::lang::{self, Overrides, SourceMap};
use bhs::registry::Registry;

/// The codes and texts of all that is wrong with a scene.
fn findings(text: &str) -> Vec<(String, String)> {
    let mut sources = SourceMap::new();
    let found = match lang::load_text("test.bhs", text, &Registry::builtin(), &Overrides::default(), &mut sources) {
        Ok(built) => built.warnings,
        Err(found) => found,
    };
    found.iter().map(|d| (d.code.to_string(), bhs::report::render(std::slice::from_ref(d), &sources, false))).collect()
}

#[test]
fn what_is_wrong_with_spacetimes_is_told() {
    let sky = "WorldBegin LightSource \"infinite\" ";
    let cases = [
        ("BlackHole \"schwarzschild\" \"float rs\" 0.1 Spacetime \"minkowski\"", "duplicate-directive", "majumdar-papapetrou"),
        ("Wormhole \"elis\" \"float throat\" 1", "unknown-plugin", "did you mean `ellis`?"),
        ("Side \"left\"", "unknown-side", "near"),
        ("Side \"far\" Shape \"sphere\"", "no-far-side", "Wormhole"),
        ("BlackHole \"schwarzschild\" \"float rs\" 0.1 Side \"far\" Shape \"sphere\"", "no-far-side", "Wormhole"),
        ("Translate 0 0 4 Wormhole \"ellis\" \"float throat\" 1 Shape \"sphere\" \"float radius\" 0.4", "inside-throat", "0.5"),
        // None of its corners is within.
        (
            "Translate 0 0 4 Wormhole \"ellis\" \"float throat\" 1 \
             Shape \"trianglemesh\" \"point3 P\" [-9 -9 0  9 -9 0  0 9 0] \"integer indices\" [0 1 2]",
            "inside-throat",
            "throat",
        ),
        ("Wormhole \"ellis\" \"float throat\" 1", "inside-throat", "camera"),
        ("BlackHole \"reissner-nordstrom\" \"float rs\" 1 \"float charge\" 0.5", "inside-horizon", "camera"),
        ("Translate 0 0 5 Scale 1 2 1 Wormhole \"ellis\" \"float throat\" 1", "bad-transform", "scale"),
        ("Translate 0 0 5 BlackHole \"reissner-nordstrom\" \"float rs\" 1 \"float charge\" 1.5", "bad-value", "charge"),
    ];
    for (text, code, word) in cases {
        let found = findings(&format!("{sky}{text}"));
        assert!(found.iter().any(|(c, text)| c == code && text.contains(word)), "{text}: {found:?}");
    }
    for (options, code) in [
        ("Camera \"perspective\" \"vector3 velocity\" [0.8 0.6 0]", "bad-value"),
        ("Camera \"perspective\" \"string side\" \"far\"", "no-far-side"),
        ("Camera \"perspective\" \"string side\" \"upper\"", "bad-value"),
    ] {
        let found = findings(&format!("{options} {sky}"));
        assert!(found.iter().any(|(c, _)| c == code), "{options}: {found:?}");
    }
    let exact = "Integrator \"schwarzschild-exact\" WorldBegin LightSource \"infinite\" Translate 0 0 5 Wormhole \"ellis\" \"float throat\" 1";
    let found = findings(exact);
    assert!(found.iter().any(|(code, _)| code == "unfit-integrator"), "{found:?}");
}

fn pixels(text: &str) -> Vec<f32> {
    common::render(&common::build(text)).frame.picture().data
}

const SMALL: &str =
    "Film \"rgb\" \"integer xresolution\" 12 \"integer yresolution\" 9 Sampler \"sobol\" \"integer pixelsamples\" 8
    LookAt 0 0.5 -6  0 0 0  0 1 0  Camera \"perspective\" \"float fov\" 60 ";
const WORLD: &str = "LightSource \"infinite\" \"rgb L\" [0.3 0.4 0.8]
    AttributeBegin AreaLightSource \"diffuse\" \"rgb L\" [9 8 7] Translate 1 2 0 Shape \"sphere\" \"float radius\" 0.3 AttributeEnd
    Shape \"trianglemesh\" \"point3 P\" [-5 -1.5 -5  5 -1.5 -5  5 -1.5 5  -5 -1.5 5] \"integer indices\" [0 1 2  0 2 3] ";

#[test]
fn the_three_directives_mean_the_same_and_nothing_is_flat_space() {
    let scene = |spacetime: &str| pixels(&format!("{SMALL}WorldBegin {spacetime} {WORLD}"));
    let hole = scene("BlackHole \"schwarzschild\" \"float rs\" 0.3");
    assert_eq!(hole, scene("Spacetime \"schwarzschild\" \"float rs\" 0.3"));
    assert_eq!(hole, scene("Wormhole \"reissner-nordstrom\" \"float rs\" 0.3"));
    let flat = scene("");
    assert_ne!(hole, flat);
    for nothing in [
        "Spacetime \"minkowski\"",
        "BlackHole \"schwarzschild\" \"float rs\" 0",
        "BlackHole \"reissner-nordstrom\" \"float rs\" 0 \"float charge\" 1",
        "BlackHole \"majumdar-papapetrou\" \"point3 centers\" [0 0 0  1 0 0] \"float masses\" [0 0]",
        "Wormhole \"ellis\" \"float throat\" 0",
        "Wormhole \"dneg\" \"float throat\" 0 \"float length\" 0 \"float lensingwidth\" 0.1",
        "BlackHole \"kerr\" \"float rs\" 0 \"float spin\" 0.9",
    ] {
        assert_eq!(flat, scene(nothing), "{nothing}");
    }
}

/// A closed room whose walls have the temperature `T0/N`, and which the camera sees from `[0.5 0.3 -2]`.
fn tolman_room(spacetime: &str, inner: &str) -> Vec<f32> {
    let walls = "Shape \"trianglemesh\" \"point3 P\" [-3 -2.5 -3.2  3 -2.5 -3.2  -3 2.5 -3.2  3 2.5 -3.2  -3 -2.5 3  3 -2.5 3  -3 2.5 3  3 2.5 3]
        \"integer indices\" [0 2 3  0 3 1  4 5 7  4 7 6  0 1 5  0 5 4  2 6 7  2 7 3  0 4 6  0 6 2  1 3 7  1 7 5]";
    pixels(&format!(
        "LightTransport \"path\" \"integer maxdepth\" 0
         Film \"rgb\" \"integer xresolution\" 12 \"integer yresolution\" 9 Sampler \"sobol\" \"integer pixelsamples\" 4
         LookAt 0.5 0.3 -2  -0.1 0.2 0  0 1 0  Camera \"perspective\" \"float fov\" 100
         WorldBegin {spacetime}
         Material \"diffuse\" \"spectrum reflectance\" 0
         AreaLightSource \"diffuse\" \"tolman L\" 3200 \"bool twosided\" true
         {walls} {inner}"
    ))
}

/// The largest relative difference of two pictures from each other.
fn difference(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f32::max)
}

#[test]
fn rooms_in_equilibrium_are_uniform_whatever_bends() {
    let ball = |x: f64, r: f64| format!("AttributeBegin Translate {x} 0 0 Shape \"sphere\" \"float radius\" {r} AttributeEnd ");
    let holes = "BlackHole \"majumdar-papapetrou\" \"point3 centers\" [-0.8 0 0  0.8 0 0] \"float masses\" [0.3 0.2]";
    let charged = "BlackHole \"reissner-nordstrom\" \"float rs\" 0.8 \"float charge\" 0.9";
    // What the static observer at the camera sees of `T0/N`: the black body of T0 over N there.
    let at = |x: f64, m: f64| m / ((0.5f64 - x).powi(2) + 0.3 * 0.3 + 4.0).sqrt();
    let u = 1.0 + at(-0.8, 0.3) + at(0.8, 0.2);
    let r2 = 0.25 + 0.09 + 4.0f64;
    let lapse = (1.0 - 0.8 / r2.sqrt() + (0.9 * 0.4f64).powi(2) / r2).sqrt();
    // N^2 = 1 - 2 M r/S, r from the oblate chart, the axis along +y.
    let spinning = "Spacetime \"kerr\" \"float rs\" 0.8 \"float spin\" 0.9";
    let (a2, y2) = ((0.9 * 0.4f64).powi(2), 0.09);
    let c = r2 - a2;
    let of_r2 = 0.5 * (c + (c * c + 4.0 * a2 * y2).sqrt());
    let dragged = (1.0 - 0.8 * of_r2.sqrt() / (of_r2 + a2 * y2 / of_r2)).sqrt();
    for (spacetime, inner, hotter) in [
        (holes, ball(-0.8, 0.2) + &ball(0.8, 0.2), u),
        (charged, ball(0.0, 0.7), 1.0 / lapse),
        (spinning, ball(0.0, 0.95), 1.0 / dragged),
    ] {
        let seen = tolman_room(spacetime, &inner);
        let text = format!("\"blackbody L\" {:.12}", 3200.0 * hotter);
        let flat = pixels(&format!(
            "LightTransport \"path\" \"integer maxdepth\" 0
             Film \"rgb\" \"integer xresolution\" 12 \"integer yresolution\" 9 Sampler \"sobol\" \"integer pixelsamples\" 4
             LookAt 0.5 0.3 -2  -0.1 0.2 0  0 1 0  Camera \"perspective\" \"float fov\" 100
             WorldBegin AreaLightSource \"diffuse\" {text} \"bool twosided\" true Shape \"sphere\" \"float radius\" 9"
        ));
        let off = difference(&seen, &flat);
        assert!(off < 1e-4, "{spacetime}: {off}");
    }
}

#[test]
fn a_wormhole_between_rooms_of_one_temperature_is_invisible() {
    let flat = tolman_room("", "");
    for wormhole in
        ["\"ellis\" \"float throat\" 0.8", "\"dneg\" \"float throat\" 0.5 \"float length\" 0.3 \"float lensingwidth\" 0.2"]
    {
        let spacetime = format!("Wormhole {wormhole}");
        let far = "Side \"far\" Translate 0.3 0.1 -0.2 Shape \"sphere\" \"float radius\" 3";
        let off = difference(&tolman_room(&spacetime, far), &flat);
        assert!(off < 1e-5, "{wormhole}: {off}");
        // Without the other room its sky shows, which is black.
        let black = tolman_room(&spacetime, "").iter().filter(|x| **x == 0.0).count();
        assert!(black > 2, "{wormhole}: {black} numbers");
    }
}

/// A room of one temperature T0, seen from one who passes at the velocity v: in each direction d' the black body of `T0 / (k (1 - v d'))`.
#[test]
fn a_moving_camera_sees_a_uniform_room_hotter_ahead() {
    let (t0, v) = (3000.0, [0.2, -0.1, 0.5]);
    let k = 1.0 / (1.0 - v.iter().map(|x| x * x).sum::<f64>()).sqrt();
    let n = 4;
    let seen = pixels(&format!(
        "LightTransport \"path\" \"integer maxdepth\" 0
         Film \"rgb\" \"integer xresolution\" {n} \"integer yresolution\" {n} Sampler \"sobol\" \"integer pixelsamples\" 65536
         Camera \"perspective\" \"float fov\" 90 \"vector3 velocity\" [{} {} {}]
         WorldBegin AreaLightSource \"diffuse\" \"blackbody L\" {t0} \"bool twosided\" true Shape \"sphere\" \"float radius\" 9",
        v[0], v[1], v[2]
    ));
    let fine = 16;
    for (i, pixel) in seen.chunks_exact(3).enumerate() {
        let mut expected = [0.0; 3];
        for sub in 0..fine * fine {
            let at = |i: usize, s: usize| (i as f64 + (s as f64 + 0.5) / fine as f64) / n as f64 * 2.0 - 1.0;
            let (x, y) = (at(i % n, sub % fine), -at(i / n, sub / fine));
            let along = (v[0] * x + v[1] * y + v[2]) / (x * x + y * y + 1.0).sqrt();
            let rgb = rgb_of(|l| planck(t0 / (k * (1.0 - along)), l), [360.0, 830.0], 5);
            (0..3).for_each(|c| expected[c] += rgb[c] / (fine * fine) as f64);
        }
        for c in 0..3 {
            let off = f64::from(pixel[c]) / expected[c] - 1.0;
            assert!(off.abs() < 2e-3, "pixel {i}, channel {c}: {} for {}", pixel[c], expected[c]);
        }
    }
}

#[test]
fn trace_says_on_which_side_rays_begin_and_end() {
    let built = common::build(&format!(
        "{SMALL}WorldBegin Wormhole \"ellis\" \"float throat\" 1 LightSource \"infinite\"
         Side \"far\" Translate 0 0 -3 Shape \"sphere\" \"float radius\" 0.5"
    ));
    let mut out = Vec::new();
    // Straight through the throat: it comes out on the near side of the other chart. The second one starts on the far side.
    let rays = "ox,oy,oz,dx,dy,dz,side\n0,0,-6,0,0,1,near\n0,0,3,0,0,1,far\n0,0,3,0,0,-1,far\n0,0,-5,0,0,-1,\n";
    bhs::trace::trace(&bhs::trace::Answers::new(&built.scene), rays.as_bytes(), &mut out).expect("all rays are answered");
    let lines: Vec<serde_json::Value> =
        String::from_utf8(out).expect("text").lines().map(|l| serde_json::from_str(l).expect("JSON")).collect();
    let said: Vec<_> = lines.iter().map(|l| (l["outcome"].as_str().unwrap(), l["side"].as_str().unwrap())).collect();
    assert_eq!(said, [("hit", "far"), ("escaped", "far"), ("escaped", "near"), ("escaped", "near")]);
    let z = lines[0]["point"][2].as_f64().unwrap();
    assert!((z + 2.5).abs() < 1e-6, "{z}");
}

#[test]
fn what_is_on_the_other_side_counts_for_footprints_and_has_no_depth() {
    let scene = |near: &str, far: &str| {
        common::build(&format!(
            "Film \"rgb\" \"integer xresolution\" 12 \"integer yresolution\" 9 \"string layers\" [\"depth\" \"side\"]
             LookAt 0 0 -6  0 0 0  0 1 0  Camera \"perspective\" \"float fov\" 60
             WorldBegin Wormhole \"ellis\" \"float throat\" 4 LightSource \"infinite\" {near} Side \"far\" {far}"
        ))
    };
    let room = "Shape \"sphere\" \"float radius\" 20";
    let (near, far) = (scene(room, ""), scene("", room));
    assert!(near.scene.footprints.camera > 0.0);
    assert_eq!(near.scene.footprints, far.scene.footprints);

    let rendered = common::render(&far);
    let layers = rendered.frame.layers();
    let [depth, side] = &layers[..] else { panic!("{} layers", layers.len()) };
    let through = side.values.iter().filter(|v| v.is_some_and(|v| v[0] > 0.0)).count();
    assert!(through > 10, "{through} pixels");
    assert!(depth.values.iter().all(Option::is_none), "{:?}", depth.values);
}
