//! Redshift: what wavelength and what radiance arrive, between all pairs of radii, and what the film makes of it.

use crate::common;
use crate::common::physics::{directions, lapse, planck, radiance, rgb_of, shadow_sine};
use glam::DVec3;

const INTEGRATORS: [&str; 3] = ["schwarzschild-exact", "schwarzschild-adaptive", "schwarzschild-rk4"];

/// A camera at `(0, 0, camera)` beside a hole with rs = 1 at the origin (`hole` are its further parameters), and a sphere of radius
/// `emitter` around the hole that emits `light` to both sides and reflects nothing.
fn sphere(integrator: &str, hole: &str, camera: f64, emitter: f64, light: &str) -> String {
    format!(
        r#"
        Integrator "{integrator}"
        LightTransport "path" "integer maxdepth" 0
        LookAt 0 0 {camera}  0 0 0  0 1 0  Camera "perspective"
        WorldBegin
        BlackHole "schwarzschild" "float rs" 1 {hole}
        Material "diffuse" "spectrum reflectance" 0
        AreaLightSource "diffuse" {light} "bool twosided" true
        Shape "sphere" "float radius" {emitter}
        "#
    )
}

/// Largest relative deviation of `found` from `expected`.
fn deviation(found: [f32; 4], expected: [f64; 4]) -> f64 {
    found.into_iter().zip(expected).map(|(f, e)| (f64::from(f) / e - 1.0).abs()).fold(0.0, f64::max)
}

/// The shift is computed in double precision and handed to spectra in single; five roundings, and the fifth power of one.
const ROUNDING: f64 = 2e-6;

const RADII: [f64; 7] = [1.02, 1.2, 1.5, 2.0, 4.0, 20.0, 300.0];

#[test]
fn wavelength_and_radiance_shift_by_the_ratio_of_the_clocks() {
    // Radiance is proportional to wavelength at the emitter: what arrives tells both the wavelength there and the factor on the way.
    let light = r#""spectrum L" [1 1e-3  1e5 100]"#;
    let lambda = [400.0f32, 500.0, 600.0, 700.0];
    let mut worst = 0.0f64;
    for (i, (camera, emitter)) in RADII.iter().flat_map(|c| RADII.map(|e| (*c, e))).filter(|(c, e)| c != e).enumerate() {
        let shift = lapse(emitter) / lapse(camera); // wavelength at the emitter over wavelength at the camera
        let at_emitter = lambda.map(|l| f64::from(l) * shift * 1e-3);
        let cases = [
            ("", at_emitter.map(|l| l * shift.powi(5))),
            (r#""string radiance" "shift-only""#, at_emitter),
            (r#""bool redshift" false"#, lambda.map(|l| f64::from(l) * 1e-3)),
        ];
        for (hole, expected) in cases {
            let built = common::build(&sphere(INTEGRATORS[i % 3], hole, camera, emitter, light));
            // Outwards every ray arrives if the emitter is around the camera, inwards if it is not.
            let away = DVec3::Z * if emitter > camera { 1.0 } else { -1.0 };
            let radial = radiance(&built, away, lambda, 0, &mut Default::default());
            let seen = directions(40).map(|d| radiance(&built, d, lambda, 0, &mut Default::default())).filter(|l| l[0] != 0.0);
            for found in std::iter::once(radial).chain(seen) {
                let off = deviation(found, expected);
                assert!(off < ROUNDING, "camera {camera} emitter {emitter} {hole}: {found:?}, expected {expected:?}");
                worst = worst.max(off);
            }
        }
    }
    eprintln!("worst relative deviation {worst:.1e}");
}

#[test]
fn the_frame_convention_does_not_change_the_shift() {
    let light = r#""spectrum L" [1 1e-3  1e5 100]"#;
    let built = common::build(&sphere(INTEGRATORS[0], r#""string frame" "chart""#, 1.5, 8.0, light));
    let shift = lapse(8.0) / lapse(1.5);
    let found = radiance(&built, DVec3::Z, [500.0; 4], 0, &mut Default::default());
    assert!(deviation(found, [0.5 * shift.powi(6); 4]) < ROUNDING, "{found:?}");
}

#[test]
fn a_black_body_around_the_hole_is_one_of_another_temperature() {
    let (temperature, around) = (3500.0, 30.0);
    let lambda = [380.0f32, 500.0, 650.0, 820.0];
    let mut worst = 0.0f64;
    for camera in [1.05, 1.3, 1.5, 1.8, 5.0, 25.0] {
        let seen = temperature * lapse(around) / lapse(camera);
        let expected = lambda.map(|l| planck(seen, f64::from(l)));
        for integrator in INTEGRATORS {
            let light = format!(r#""blackbody L" {temperature}"#);
            let built = common::build(&sphere(integrator, "", camera, around, &light));
            let (mut lit, mut dark, mut near_edge) = (0, 0, 0);
            for direction in directions(4000) {
                // Angle from the hole, which lies along -z; the shadow is beyond a right angle for a camera within 1.5 rs.
                let edge = shadow_sine(camera).asin();
                let edge = if camera < 1.5 { std::f64::consts::PI - edge } else { edge };
                let angle = (-direction.z).acos();
                // rk4 with steps of 0.1 rad strays near the critical ray (`docs/accuracy.md`, orbits near critical).
                if (angle - edge).abs() < 6e-3 {
                    near_edge += 1;
                    continue;
                }
                let found = radiance(&built, direction, lambda, 0, &mut Default::default());
                if angle < edge {
                    assert_eq!(found, [0.0; 4], "{integrator} at {camera}: the shadow along {direction}");
                    dark += 1;
                } else {
                    let off = deviation(found, expected);
                    assert!(off < 2.0 * ROUNDING, "{integrator} at {camera}: {found:?}, expected {expected:?} along {direction}");
                    worst = worst.max(off);
                    lit += 1;
                }
            }
            assert!(lit > 10 && dark > 2 && near_edge < 40, "{integrator} at {camera}: {lit} {dark} {near_edge}");
        }
    }
    eprintln!("worst relative deviation from Planck {worst:.1e}");
}

/// A picture of the light of a line between `from` and `to` (nm), of the value 1, emitted at `emitter` and seen at `camera`; its mean.
fn picture_of_a_line([from, to]: [f64; 2], camera: f64, emitter: f64, film: &str) -> [f64; 3] {
    let [outside, inside] = [from - 1e-3, to + 1e-3];
    let light = format!(r#""spectrum L" [{outside} 0  {from} 1  {to} 1  {inside} 0]"#);
    let up = if emitter > camera { 2.0 * camera } else { 0.0 };
    let text = sphere("schwarzschild-adaptive", "", camera, emitter, &light).replace(
        &format!(r#"LookAt 0 0 {camera}  0 0 0  0 1 0  Camera "perspective""#),
        &format!(
            r#"
            Sampler "sobol" "integer pixelsamples" 8192
            Film "rgb" "integer xresolution" 4 "integer yresolution" 4 {film}
            LookAt 0 0 {camera}  0 0 {up}  0 1 0
            Camera "perspective" "float fov" 1"#
        ),
    );
    let picture = common::render(&common::build(&text)).frame.picture();
    let n = picture.data.len() / 3;
    std::array::from_fn(|k| picture.data.iter().skip(k).step_by(3).map(|v| f64::from(*v)).sum::<f64>() / n as f64)
}

#[test]
fn lines_from_outside_the_visible_are_recorded_where_they_arrive() {
    // Line at the emitter (nm), camera, emitter. Deep in the field far light is blue: 900 nm arrives at 548. Far away deep light is
    // red: 220 nm from 1.2 rs arrives at 525. From 1.02 rs, 80 nm arrives at 566, weaker by a factor 18,000.
    for ([from, to], camera, emitter) in
        [([880.0, 920.0], 1.5, 10.0), ([1800.0, 1850.0], 1.1, 500.0), ([210.0, 230.0], 20.0, 1.2), ([79.0, 81.0], 50.0, 1.02)]
    {
        let shift = lapse(emitter) / lapse(camera);
        let seen = |l: f64| if (from..to).contains(&(l * shift)) { shift.powi(5) } else { 0.0 };
        let found = picture_of_a_line([from, to], camera, emitter, "");
        let expected = rgb_of(seen, [360.0, 830.0], 100);
        let scale = expected.iter().fold(0.0f64, |m, c| m.max(c.abs()));
        for (f, e) in found.into_iter().zip(expected) {
            // 131,072 samples of 4 wavelengths, some 1 in 20 within the line, stratified by Sobol's sequence.
            assert!((f - e).abs() < 3e-3 * scale, "line {from} to {to}: {found:?}, expected {expected:?}");
        }
        eprintln!("line {from} to {to} nm: {:.5} of the green expected", found[1] / expected[1]);
        // A film of the lower half of its wavelengths records that half.
        let middle = 0.5 * (from + to) / shift;
        let half = picture_of_a_line([from, to], camera, emitter, &format!(r#""float lambdamax" {middle}"#));
        let expected = rgb_of(seen, [360.0, middle], 100);
        for (f, e) in half.into_iter().zip(expected) {
            assert!((f - e).abs() < 3e-3 * scale, "half the line {from} to {to}: {half:?}, expected {expected:?}");
        }
    }
    // And what leaves the visible on the way is not seen.
    assert_eq!(picture_of_a_line([540.0, 560.0], 1.5, 10.0, ""), [0.0; 3]);
    assert_eq!(picture_of_a_line([540.0, 560.0], 20.0, 1.2, ""), [0.0; 3]);
}
