//! Layers against numbers that are computed here in other ways, from the orbit's first integral alone.

use crate::common;
use bhs::lang::Overrides;
use bhs::layers::LayerPicture;
use bhs::registry::Registry;
use bhs_core::ray::{Arrival, Ray};
use bhs_engine::layer::VisibleSurface;
use bhs_layers::orbit::Constants;
use glam::DVec3;
use std::f64::consts::{PI, TAU};

const RELATIVITY: &str = r#""impactparameter" "sweptangle" "closestapproach" "winding" "redshift" "queries" "outcome""#;

/// One pixel, all of it one ray but for a millionth of a degree: seen from (0, 0, -r0), at the local angle `theta` (rad) from the
/// direction away from the hole (rs = 1, in the origin).
fn ray(r0: f64, theta: f64, layers: &str, hole: &str, world: &str) -> String {
    let target = [theta.sin(), 0.0, -r0 - theta.cos()];
    format!(
        r#"
        LookAt 0 0 {}  {} {} {}  0 1 0
        Camera "perspective" "float fov" 1e-6
        Film "rgb" "integer xresolution" 1 "integer yresolution" 1 "string layers" [{layers}]
        Sampler "sobol" "integer pixelsamples" 2
        LightTransport "path" "integer maxdepth" 1
        Integrator "schwarzschild-exact"
        WorldBegin
        {hole}
        LightSource "infinite"
        {world}
        "#,
        -r0, target[0], target[1], target[2]
    )
}

const HOLE: &str = r#"BlackHole "schwarzschild" "float rs" 1"#;
/// A shell all around, of radius 5.
const SHELL: &str = r#"Shape "sphere" "float radius" 5"#;

/// The values of the layers of the first pixel.
fn first(text: &str) -> Vec<Option<[f64; 3]>> {
    common::render(&common::build(text)).frame.layers().iter().map(|l| l.values[0]).collect()
}

fn scalars(text: &str) -> Vec<Option<f64>> {
    first(text).into_iter().map(|v| v.map(|v| v[0])).collect()
}

/// `integral of weight(u) du / sqrt(1/b^2 - u^2 + u^3)` from `u0` to `u1` by the midpoint rule; `turn` is a zero of the root at one of the ends,
/// where the substitution `u = turn - s^2` takes its singularity away.
fn along_orbit(b: f64, u0: f64, u1: f64, turn: Option<f64>, weight: impl Fn(f64) -> f64) -> f64 {
    let n = 200_000;
    let p = |u: f64| (1.0 / (b * b) - u * u + u * u * u).sqrt() / weight(u);
    let rule = |from: f64, to: f64, f: &dyn Fn(f64) -> f64| {
        let h = (to - from) / f64::from(n);
        (0..n).map(|i| f(from + (f64::from(i) + 0.5) * h)).sum::<f64>() * h
    };
    match turn {
        None => rule(u0, u1, &|u| 1.0 / p(u)),
        Some(t) => rule((t - u1).max(0.0).sqrt(), (t - u0).sqrt(), &|s| 2.0 * s / p(t - s * s)),
    }
}

/// The angle swept there.
fn swept(b: f64, u0: f64, u1: f64, turn: Option<f64>) -> f64 {
    along_orbit(b, u0, u1, turn, |_| 1.0)
}

/// The periapsis of a ray of impact parameter `b` > b_crit, as u = 1/r, by bisection of the first integral.
fn turning_point(b: f64) -> f64 {
    let (mut lo, mut hi) = (0.0, 2.0 / 3.0);
    for _ in 0..200 {
        let u = 0.5 * (lo + hi);
        if 1.0 / (b * b) - u * u + u * u * u > 0.0 { lo = u } else { hi = u }
    }
    lo
}

#[test]
fn orbits_have_the_angle_the_parameter_and_the_periapsis_of_their_first_integral() {
    let f = |r: f64| 1.0 - 1.0 / r;
    for (r0, theta) in [(4.0f64, 0.4f64), (4.0, 1.5), (4.0, 2.0), (4.0, 2.45), (2.0, 0.9), (2.0, 1.9), (1.3, 0.3)] {
        // Energy and angular momentum of the light that the static observer at r0 sees at theta.
        let b = r0 * theta.sin() / f(r0).sqrt();
        let (u0, u1) = (1.0 / r0, 0.2);
        let inward = theta > 0.5 * PI;
        let (phi, nearest) = if inward {
            let turn = turning_point(b);
            (swept(b, u0, turn, Some(turn)) + swept(b, u1, turn, Some(turn)), 1.0 / turn)
        } else {
            (swept(b, u1, u0, None), r0)
        };
        let found = scalars(&ray(r0, theta, RELATIVITY, HOLE, SHELL));
        let g = (f(5.0) / f(r0)).sqrt();
        for (name, found, expected) in [
            ("b", found[0], b),
            ("phi", found[1], phi),
            ("closest", found[2], nearest),
            ("winding", found[3], phi / TAU),
            ("g", found[4], g),
        ] {
            let found = found.expect("a value");
            assert!((found / expected - 1.0).abs() < 2e-6, "r0 {r0}, theta {theta}: {name} {found}, expected {expected}");
        }
        assert!(found[5].is_some_and(|q| q >= 1.0));
        assert_eq!(found[6], Some(1.0), "hits the shell");
    }
}

#[test]
fn light_is_late_by_its_first_integral() {
    // dt/dphi = r^2 / (b f), along the orbit as above; r0 = 4, out to the shell at 5.
    let (r0, f) = (4.0f64, |u: f64| 1.0 - u);
    for theta in [0.4f64, 1.5, 2.0, 2.45] {
        let b = r0 * theta.sin() / f(1.0 / r0).sqrt();
        let time = |from: f64, to: f64, turn: Option<f64>| along_orbit(b, from, to, turn, |u| 1.0 / (b * u * u * f(u)));
        let expected = if theta > 0.5 * PI {
            let turn = turning_point(b);
            time(0.25, turn, Some(turn)) + time(0.2, turn, Some(turn))
        } else {
            time(0.2, 0.25, None)
        };
        let found = scalars(&ray(r0, theta, "\"traveltime\"", HOLE, SHELL))[0].expect("it comes from the shell");
        assert!((found / expected - 1.0).abs() < 2e-6, "theta {theta}: {found}, expected {expected}");
    }
    assert_eq!(scalars(&ray(4.0, 2.0, "\"traveltime\"", HOLE, "")), [None], "light from the sky takes for ever");
    assert_eq!(scalars(&ray(4.0, 2.9, "\"traveltime\"", HOLE, SHELL)), [None], "and from the horizon");
    let flat = scalars(&ray(4.0, PI, "\"traveltime\"", "", SHELL))[0].expect("it comes from the shell");
    assert!((flat - 9.0).abs() < 1e-9, "{flat}");
}

#[test]
fn light_that_arrives_has_the_constants_of_its_orbit() {
    let of = |hole: &str, from: [f64; 3], local: [f64; 3]| {
        let [x, y, z] = from;
        let to: Vec<String> = (0..3).map(|i| (from[i] + local[i]).to_string()).collect();
        let text = format!(
            "LookAt {x} {y} {z}  {}  0.1 0.2 1  Camera \"perspective\" \"float fov\" 1e-6
             Film \"rgb\" \"integer xresolution\" 1 \"integer yresolution\" 1 \"string layers\" [\"angularmomentum\" \"carter\" \"impactparameter\"]
             Sampler \"sobol\" \"integer pixelsamples\" 1 LightTransport \"normals\" WorldBegin {hole} LightSource \"infinite\"",
            to.join(" ")
        );
        let found = scalars(&text);
        [0, 1, 2].map(|i| found[i].expect("all rays have these"))
    };
    let close = |found: f64, right: f64, what: &str| {
        assert!((found - right).abs() < 1e-7 * right.abs().max(1.0), "{what}: {found} is {right}")
    };
    // A static eye on the equator of a spin of 0.9, at x = 12: L/E of the light that arrives, from Kerr-Schild coordinates. Q = p_theta^2 there, which
    // the eye measures: r l_z / N.
    let kerr = "BlackHole \"kerr\" \"float rs\" 2 \"float spin\" 0.9 \"vector3 axis\" [0 0 1]";
    for (local, l) in [
        ([-1.0, -0.45, 0.2], 5.130726638629703f64),
        ([-1.0, -0.1, 0.6], 0.943423103976243),
        ([-1.0, 0.62, 0.1], -7.088375348045848),
    ] {
        let r = (144.0 - 0.81f64).sqrt();
        let q = (r * local[2]).powi(2) / local.iter().map(|c| c * c).sum::<f64>() / (1.0 - 2.0 / r);
        let found = of(kerr, [12.0, 0.0, 0.0], local);
        for (found, right) in found.into_iter().zip([l, q, (l * l + q).sqrt()]) {
            close(found, right, &format!("{local:?}"));
        }
    }
    // Without spin, L is about +y: b^2 = L^2 + Q, and the light moves against the look.
    let f = 1.0 - 1.0 / 4.0;
    let [l, q, b] = of(HOLE, [0.0, 0.0, 4.0], [0.6, 0.0, -0.8]);
    close(b, 2.4 / f64::sqrt(f), "b");
    close(l, -b, "y of (x cross p) for p along (-0.6, 0, 0.8)");
    close(q, 0.0, "in the plane across y");
    let [l, q, b] = of(HOLE, [0.0, 0.0, 4.0], [0.0, 0.6, -0.8]);
    close(l, 0.0, "through the axis");
    close(q, b * b, "all of it across");
}

#[test]
fn constants_of_the_orbit_are_constant() {
    let text = "Integrator \"adaptive\" \"float tolerance\" 1e-8
         WorldBegin BlackHole \"kerr\" \"float rs\" 1 \"float spin\" -0.8 \"float charge\" 0.3 \"vector3 axis\" [0.2 0.9 -0.4]
                LightSource \"infinite\" Shape \"sphere\" \"float radius\" 9";
    let overrides = Overrides { without_camera: true, ..Overrides::default() };
    let scene = common::build_with(text, &overrides).scene;
    let mut compared = 0;
    for k in 0..40 {
        let at = |k: f64| DVec3::new((1.3 * k).sin(), (2.1 * k + 0.4).cos(), (0.7 * k + 1.0).sin());
        let start = Ray::new(at(f64::from(k)) * 3.0, at(f64::from(k) + 0.5).normalize());
        let end = scene.integrator.trace(&scene.world, &start);
        let Arrival::Surface(hit) = end.arrival else { continue };
        let there = Ray::new(hit.point, hit.direction);
        let [a, b] = [start, there].map(|ray| Constants::of(&VisibleSurface::of_ray(&scene, ray, end, 1.0)));
        let (Some(a), Some(b)) = (a, b) else { continue };
        let scale = a.carter.abs() + a.angular_momentum.powi(2);
        assert!((a.angular_momentum - b.angular_momentum).abs() < 1e-5 * scale.sqrt(), "{a:?} {b:?}");
        assert!((a.carter - b.carter).abs() < 1e-5 * scale, "{a:?} {b:?}");
        compared += 1;
    }
    assert!(compared > 15, "{compared}");
}

#[test]
fn rays_that_fall_in_or_escape_say_so() {
    let captured = first(&ray(4.0, 2.9, RELATIVITY, HOLE, SHELL));
    assert_eq!(captured[2], Some([1.0, 0.0, 0.0]), "the horizon is the closest approach");
    assert_eq!(captured[4], None, "no light, no redshift");
    assert_eq!(captured[6], Some([0.0, 0.0, 1.0]));
    let escaped = first(&ray(4.0, 2.0, RELATIVITY, HOLE, ""));
    let b = 4.0 * 2f64.sin() / 0.75f64.sqrt();
    let turn = turning_point(b);
    let phi = swept(b, 0.25, turn, Some(turn)) + swept(b, 0.0, turn, Some(turn));
    assert!(escaped[1].is_some_and(|v| (v[0] / phi - 1.0).abs() < 2e-6), "{escaped:?}, expected {phi}");
    // Light that falls from far away is blue to who stands near the hole.
    assert!(escaped[4].is_some_and(|v| (v[0] - 0.75f64.powf(-0.5)).abs() < 1e-12), "{escaped:?}");
    assert_eq!(escaped[6], Some([0.0, 1.0, 0.0]));
    let unshifted = r#"BlackHole "schwarzschild" "float rs" 1 "bool redshift" false"#;
    assert_eq!(scalars(&ray(4.0, 2.0, RELATIVITY, unshifted, ""))[4], Some(1.0));
}

#[test]
fn flat_space_bends_and_shifts_nothing() {
    let expected = [0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0].map(Some);
    let of_no_size = HOLE.replace("\"float rs\" 1", "\"float rs\" 0");
    for hole in ["", of_no_size.as_str()] {
        assert_eq!(scalars(&ray(4.0, 2.0, RELATIVITY, hole, SHELL)), expected, "{hole}");
    }
    // Nor does an integrator that ignores the hole.
    let text = ray(4.0, 2.0, RELATIVITY, HOLE, SHELL).replace("schwarzschild-exact", "straight");
    assert_eq!(scalars(&text), expected);
    // A hole too small to matter: angle and distance of a straight line that passes it at 4 sin(theta).
    let tiny = HOLE.replace("\"float rs\" 1", "\"float rs\" 1e-6");
    let found = scalars(&ray(4.0, 2.0, RELATIVITY, &tiny, SHELL));
    let b = 4.0 * 2f64.sin();
    let phi = (b / 4.0).acos() + (b / 5.0).acos();
    for (found, expected) in found.iter().zip([b, phi, b, phi / TAU, 1.0]) {
        assert!(found.is_some_and(|v| (v / expected - 1.0).abs() < 1e-5), "{found:?}, expected {expected}");
    }
}

#[test]
fn surfaces_have_place_normals_and_albedo() {
    let layers = r#""position" "normal" "shadingnormal" "albedo""#;
    let world = |material: &str| format!("{material}\nTranslate 0 0 3\nShape \"sphere\"");
    // From (0, 0, -4) straight ahead, without a hole: the sphere's nearest point.
    let found = |material: &str| first(&ray(4.0, PI, layers, "", &world(material)));
    let values = found(r#"Material "diffuse" "float reflectance" 0.3"#);
    for (found, expected) in values.iter().zip([[0.0, 0.0, 2.0], [0.0, 0.0, -1.0], [0.0, 0.0, -1.0], [0.3; 3]]) {
        let found = found.expect("a value");
        assert!((0..3).all(|c| (found[c] - expected[c]).abs() < 1e-6), "{found:?}, expected {expected:?}");
    }
    // An sRGB colour comes back as what it is.
    let color = [0.6, 0.25, 0.1];
    let albedo = found(r#"Material "diffuse" "rgb reflectance" [0.6 0.25 0.1]"#)[3].expect("a value");
    assert!((0..3).all(|c| (albedo[c] - color[c]).abs() < 0.01), "{albedo:?}");
    let mirror = found(r#"Material "mirror" "float reflectance" 0.8"#)[3].expect("a value");
    assert!(mirror.iter().all(|v| (v - 0.8).abs() < 1e-6), "{mirror:?}");
    // No surface, no value.
    assert!(first(&ray(4.0, 0.0, layers, "", &world(""))).iter().all(Option::is_none));
    // Far from the origin positions are still those of the world.
    let far = ray(4.0, PI, layers, "", &world("")).replace("LookAt 0 0 -4  ", "LookAt 0 0 999996  ");
    let far = far.replace("Translate 0 0 3", "Translate 0 0 1000003").replace("-3  0 1 0", "999997  0 1 0");
    let built = common::build(&far);
    assert!(built.scene.world.origin.z > 1e5, "render space is elsewhere: {far}");
    let position = common::render(&built).frame.layers()[0].values[0].expect("a value");
    assert!((position[2] - 1_000_002.0).abs() < 1e-3, "{position:?}");
}

/// A small picture of a ball beside a hole.
fn ball(layers: &str) -> String {
    format!(
        r#"
        LookAt 0 0 -4  0 0 0  0 1 0
        Camera "perspective" "float fov" 60
        Film "rgb" "integer xresolution" 20 "integer yresolution" 18 {layers}
        Sampler "sobol" "integer pixelsamples" 8
        WorldBegin
        BlackHole "schwarzschild" "float rs" 0.3
        LightSource "infinite"
        Translate 1 0 1
        Shape "sphere"
        "#
    )
}

#[test]
fn nothing_is_allocated_or_changed_without_request() {
    let plain = common::render(&common::build(&ball("")));
    assert!(plain.frame.layers().is_empty());
    assert!(plain.frame.tiles.iter().all(|t| t.lock().expect("free").layers.capacity() == 0));
    assert_eq!(plain.frame.picture().with_layers(&plain.frame.layers()).channels, ["R", "G", "B"]);

    let with = common::render(&common::build(&ball(r#""string layers" ["sweptangle" "albedo"]"#)));
    for (a, b) in with.frame.tiles.iter().zip(&plain.frame.tiles) {
        let (a, b) = (a.lock().expect("free"), b.lock().expect("free"));
        // Two layers: one and three channels, and a weight each.
        assert_eq!((a.layers.len(), a.sums.len()), (6 * a.weights.len(), b.sums.len()));
    }
    let picture = with.frame.picture();
    assert_eq!(picture.data, plain.frame.picture().data, "the colours are the same");
    assert_eq!(with.counters, plain.counters, "and the counts");
    let all = picture.with_layers(&with.frame.layers());
    assert_eq!(all.channels, ["R", "G", "B", "sweptangle", "Albedo.R", "Albedo.G", "Albedo.B"]);
    assert_eq!(all.data.len(), 20 * 18 * 7);
}

#[test]
fn a_layer_is_the_mean_over_the_rays_that_have_a_value() {
    // At the ball's rim some rays of a pixel hit it: their mean point lies on the ball, not between it and the origin.
    let built = common::build(&ball(r#""string layers" ["position" "outcome" "normal"]"#));
    let layers: Vec<LayerPicture> = common::render(&built).frame.layers();
    assert_eq!(layers.iter().map(|l| l.name).collect::<Vec<_>>(), ["position", "outcome", "normal"]);
    let mut rim = 0;
    for i in 0..20 * 18 {
        let outcome = layers[1].values[i].expect("all rays end somewhere");
        assert!((outcome.iter().sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!(outcome[0] > 0.0, layers[0].values[i].is_some());
        if let (true, Some(p), Some(n)) = (outcome[0] < 1.0, layers[0].values[i], layers[2].values[i]) {
            rim += 1;
            let distance = ((p[0] - 1.0).powi(2) + p[1].powi(2) + (p[2] - 1.0).powi(2)).sqrt();
            // A mean of points within a pixel lies somewhat below the surface.
            assert!((0.5..=1.0 + 1e-6).contains(&distance), "{p:?}");
            assert!((n.iter().map(|x| x * x).sum::<f64>() - 1.0).abs() < 1e-9);
        }
    }
    assert!(rim > 3, "{rim}");
}

#[test]
fn the_command_line_adds_layers_to_those_of_the_scene() {
    let overrides = Overrides { layers: vec!["winding".into(), "albedo".into()], ..Default::default() };
    let layers = |text: &str| common::build_with(text, &overrides).layers.iter().map(|layer| layer.name).collect::<Vec<_>>();
    assert_eq!(layers(&ball("")), ["winding", "albedo"]);
    assert_eq!(layers(&ball(r#""string layers" ["albedo" "queries"]"#)), ["albedo", "queries", "winding"]);
}

#[test]
fn the_language_reference_lists_every_layer_with_its_channels() {
    let reference = common::read("grammar/README.md");
    let all = Registry::builtin().describe();
    let mut layers = 0;
    for (name, format) in all.iter().filter_map(|plugin| Some((plugin.name, plugin.format?))) {
        let row = reference.lines().find(|l| l.starts_with(&format!("| `{name}` | `")));
        let row = row.unwrap_or_else(|| panic!("{name} is missing"));
        assert!(format.channels.iter().all(|c| row.contains(&format!("`{c}`"))), "{row}");
        assert!(row.ends_with(&format!("| {} |", format.unit)) || format.unit.is_empty() && row.ends_with("| |"), "{row}");
        layers += 1;
    }
    assert_eq!(layers, 18);
}
