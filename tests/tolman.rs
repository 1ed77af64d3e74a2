//! Rooms in thermal equilibrium: no lens, no shape and no material shows in them.
//!
//! Walls of albedo rho at the local temperature `T0 / sqrt(f)` emit `(1 - rho) B` and scatter `rho B`: all in all B, which arrives anywhere
//! as B at the temperature there. Exactly so only if nothing ends in the hole, so a surface of the same kind encloses it.

use crate::common;
use crate::common::physics::{deviation, directions, lapse, planck, radiance, shadow_sine};

/// Temperature far from the hole (K).
const T0: f64 = 3200.0;
/// Where the camera stands, and how far from the hole that is, in units of rs = 1.
const CAMERA: [f64; 3] = [1.5, 0.5, -1.8];

fn distance(p: [f64; 3]) -> f64 {
    p.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// The surfaces of a closed room; the hole stands at the origin.
const BOX: &str = r#"
    Shape "trianglemesh" "point3 P" [-3 -2.5 -3.2  3 -2.5 -3.2  -3 2.5 -3.2  3 2.5 -3.2  -3 -2.5 3  3 -2.5 3  -3 2.5 3  3 2.5 3]
        "integer indices" [0 2 3  0 3 1  4 5 7  4 7 6  0 1 5  0 5 4  2 6 7  2 7 3  0 4 6  0 6 2  1 3 7  1 7 5]
"#;
const SPHERE: &str = r#"Translate 0.4 -0.3 0.2  Shape "sphere" "float radius" 3.5  Translate -0.4 0.3 -0.2"#;
/// An octahedron beside the hole, of the same kind as the walls, and a mirror and glass that do not emit.
const OBJECTS: &str = r#"
    Shape "trianglemesh" "point3 P" [-2.2 0 0  -1.4 0 0  -1.8 -0.6 0  -1.8 0.6 0  -1.8 0 -0.5  -1.8 0 0.5]
        "integer indices" [0 2 4  2 1 4  1 3 4  3 0 4  2 0 5  1 2 5  3 1 5  0 3 5]
    AttributeEnd
    AttributeBegin
      Material "mirror"
      Translate 0.4 -1.7 0.5
      Shape "sphere" "float radius" 0.5
    AttributeEnd
    AttributeBegin
      Material "dielectric" "float eta" 1.5
      Translate -0.3 0.6 -2
      Shape "sphere" "float radius" 0.4
    AttributeEnd
    AttributeBegin
"#;

/// A room of these `surfaces`, of albedo `rho`, in equilibrium around a hole.
fn room(options: &str, rho: f64, surfaces: &str) -> String {
    let [x, y, z] = CAMERA;
    format!(
        r#"
        {options}
        Film "rgb" "integer xresolution" 4 "integer yresolution" 3
        LookAt {x} {y} {z}  -0.1 0.2 0  0 1 0
        Camera "perspective" "float fov" 110
        WorldBegin
        BlackHole "schwarzschild" "float rs" 1
        AttributeBegin
          Material "diffuse" "spectrum reflectance" {rho}
          AreaLightSource "diffuse" "tolman L" {T0} "float scale" {emitted} "bool twosided" true
          {surfaces}
        AttributeEnd
        "#,
        emitted = 1.0 - rho
    )
}

/// The integrators, as precise as in a picture of some hundred pixels across (by default they would go by the pixels of this one).
const INTEGRATORS: [&str; 3] = [
    r#"Integrator "schwarzschild-exact" "float tolerance" 1e-3"#,
    r#"Integrator "schwarzschild-adaptive" "float tolerance" 1e-3"#,
    r#"Integrator "schwarzschild-rk4""#,
];

/// The methods, with samples a pixel and the noise of a pixel. Bounces enough for 0.3^(maxdepth + 1) to be nothing, mirrors and glass on the
/// way included; roulette only where next to nothing is left. The mean over all pixels is held to 0.2 %.
const METHODS: [(&str, u32, f64); 3] = [
    (r#"LightTransport "path" "integer maxdepth" 20 "integer rrdepth" 7 "bool lightsampling" false"#, 1024, 6e-3),
    (r#"LightTransport "path" "integer maxdepth" 20 "integer rrdepth" 7"#, 8192, 2e-2),
    (r#"LightTransport "hemisphere" "integer maxdepth" 12"#, 2048, 2e-2),
];

/// All of it in a room of `surfaces` with a shell of the radius `cover` around the hole.
fn is_uniform(surfaces: &str, cover: f64) {
    let surfaces = format!("Shape \"sphere\" \"float radius\" {cover}\n{surfaces}");
    for integrator in INTEGRATORS {
        for (method, samples, tolerance) in METHODS {
            let options = format!("{integrator}\n{method}\nSampler \"sobol\" \"integer pixelsamples\" {samples}");
            let (pixel, mean) = deviation(&room(&options, 0.3, &surfaces), T0 / lapse(distance(CAMERA)));
            eprintln!("cover {cover}, {integrator}, {method}: pixels {pixel:.1e}, mean {mean:.1e}");
            assert!(pixel < tolerance && mean < 2e-3, "cover {cover}, {integrator}, {method}: {pixel:.1e} {mean:.1e}");
        }
    }
}

#[test]
fn a_box_in_equilibrium_is_uniform() {
    is_uniform(BOX, 1.2);
}

#[test]
fn a_sphere_in_equilibrium_is_uniform() {
    is_uniform(SPHERE, 1.05);
}

#[test]
fn a_furnished_room_in_equilibrium_is_uniform() {
    is_uniform(&format!("{BOX}{OBJECTS}"), 1.05);
}

#[test]
fn around_a_bare_hole_what_is_seen_directly_is_uniform() {
    let lambda = [400.0f32, 500.0, 600.0, 700.0];
    let r = distance(CAMERA);
    let expected = lambda.map(|l| planck(T0 / lapse(r), f64::from(l)));
    let to_hole = glam::DVec3::from_array(CAMERA.map(|x| -x / r));
    let edge = shadow_sine(r).asin();
    let mut worst = 0.0f64;
    for integrator in INTEGRATORS {
        for surfaces in [BOX, SPHERE] {
            let options = format!("{integrator}\nLightTransport \"path\" \"integer maxdepth\" 0");
            let built = common::build(&room(&options, 0.0, surfaces));
            let mut dark = 0;
            for direction in directions(20_000) {
                let angle = direction.dot(to_hole).acos();
                // What rk4 strays near the critical ray with steps of 0.1 rad.
                if (angle - edge).abs() < 6e-3 {
                    continue;
                }
                let found = radiance(&built, direction, lambda, 0, &mut Default::default());
                if angle < edge {
                    assert_eq!(found, [0.0; 4], "{integrator}: the shadow along {direction}");
                    dark += 1;
                    continue;
                }
                for (f, e) in found.into_iter().zip(expected) {
                    worst = worst.max((f64::from(f) / e - 1.0).abs());
                }
            }
            assert!(dark > 1000, "{dark}");
        }
    }
    eprintln!("worst relative deviation {worst:.1e}");
    // Spectra take wavelength and lapse in single precision; a black body's radiance changes by some 8 times as much as those.
    assert!(worst < 4e-6, "{worst:.1e}");
}
