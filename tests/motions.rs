//! Cameras in motion: what the language says of them, and rooms in thermal equilibrium as they see them, in several spacetimes.

use crate::common;
use crate::common::physics::{lapse, planck, rgb_of};
use bhs::lang::{self, Overrides, SourceMap};
use bhs::registry::Registry;
use bhs_core::camera::CameraRay;
use glam::{DVec2, DVec3, Vec2};

const WORLD: &str = "WorldBegin LightSource \"infinite\" \"rgb L\" [0.3 0.5 0.7] Translate 0 0 4 Shape \"sphere\"";
const SMALL: &str =
    "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 6 Sampler \"sobol\" \"integer pixelsamples\" 4";

fn pixels(camera: &str) -> Vec<f32> {
    common::render(&common::build(&format!("{SMALL} {camera} {WORLD}"))).frame.picture().data
}

#[test]
fn the_motion_of_a_velocity_need_not_be_named() {
    let moving = pixels("Camera \"perspective\" \"vector3 velocity\" [0.1 0 0.4]");
    assert_eq!(moving, pixels("Camera \"perspective\" \"string motion\" \"velocity\" \"vector3 velocity\" [0.1 0 0.4]"));
    let rest = pixels("Camera \"perspective\"");
    assert_ne!(moving, rest);
    assert_eq!(rest, pixels("Camera \"perspective\" \"string motion\" \"static\""));
    assert_eq!(rest, pixels("Camera \"perspective\" \"string motion\" \"velocity\""));
}

#[test]
fn what_is_wrong_with_motions_is_told() {
    let endless = "x".repeat(5000);
    for (camera, message, help) in [
        ("\"string motion\" \"velocty\" \"vector3 velocity\" [0 0 0.1]", "unknown motion `velocty`", "did you mean `velocity`?"),
        (
            &*format!("\"string motion\" \"{endless}\""),
            "unknown motion `xxx",
            "there is infalling, keplerian, rotating, static, velocity, zamo",
        ),
        ("\"vector3 velocity\" [0 0 1]", "nothing is as fast as light", ""),
        ("\"string motion\" \"static\" \"vector3 velocity\" [0 0 0.1]", "the motion `static` takes no `velocity`", ""),
        ("\"float motion\" 1", "`motion`", ""),
        (&*format!("\"string side\" \"{endless}\""), "unknown side `xxx", ""),
    ] {
        let text = format!("Camera \"perspective\" {camera} {WORLD}");
        let loaded = lang::load_text("test.bhs", &text, &Registry::builtin(), &Overrides::default(), &mut SourceMap::new());
        let Err(found) = loaded else { panic!("{camera} is accepted") };
        let [fault] = &found[..] else { panic!("{camera}: {found:?}") };
        assert!(fault.message.contains(message) && fault.message.len() < 200, "{}", fault.message);
        assert!(fault.help.as_deref().unwrap_or("").contains(help), "{:?}", fault.help);
        assert!(fault.primary.is_some());
    }
}

/// Wavelength over that at rest, in the direction `d` that the camera measures along its own axes: `k (1 - v.d)`.
#[test]
fn a_velocity_is_along_the_axes_of_its_camera() {
    let v = DVec3::new(0.3, -0.2, 0.5);
    let k = 1.0 / (1.0 - v.length_squared()).sqrt();
    for transform in ["", "Rotate 70 0.3 1 -0.5", "Translate 3 1 2 Scale 0.01 0.01 0.01", "Scale -1 1 1 Rotate 30 0 0 1"] {
        for camera in ["perspective", "spherical", "orthographic"] {
            let text = format!("{transform} Camera \"{camera}\" \"vector3 velocity\" [0.3 -0.2 0.5] {WORLD}");
            let built = common::build(&text);
            let axes = built.camera.matrices().expect("all cameras have them").camera_from_render;
            for (x, y) in [(0.5, 0.5), (10.5, 400.5), (800.5, 33.5)] {
                let seen = built.camera.ray(DVec2::new(x, y), Vec2::splat(0.5));
                let d = axes.transform_vector3(seen.direction).normalize();
                let (ray, ratio) = built.scene.camera_ray(&seen, &built.viewpoint);
                let expected = k * (1.0 - v.dot(d));
                assert!((ratio.expect("outside") - expected).abs() < 1e-12, "{transform} {camera}: {ratio:?} for {expected}");
                // One at rest looks along the chart's own directions, and a ray starts there.
                let rest = built.scene.camera_ray(&CameraRay { ..seen }, &Default::default()).0;
                assert!((rest.direction - seen.direction).length() < 1e-12 && ray.direction.is_normalized());
            }
        }
    }
}

/// Temperature far away (K): so hot that radiance varies little across a pixel.
const T0: f64 = 12_000.0;
/// Where the camera stands in these rooms, which reach from -3 to 3.
const CAMERA: DVec3 = DVec3::new(1.5, 0.5, -1.8);
/// Pixels across and down, and half the field of view as a tangent, along the shorter side.
const SIZE: [usize; 2] = [8, 6];
const HALF: f64 = 1.0;

/// The picture of a closed room whose walls have the temperature `T0/N`, as a camera of the velocity `v` in its own axes sees it.
fn room(spacetime: &str, inner: &str, v: DVec3) -> Vec<f32> {
    let [x, y, z] = CAMERA.to_array();
    let text = format!(
        "LightTransport \"path\" \"integer maxdepth\" 0  Integrator \"adaptive\" \"float tolerance\" 1e-3
         Film \"rgb\" \"integer xresolution\" {} \"integer yresolution\" {} Sampler \"sobol\" \"integer pixelsamples\" 16384
         LookAt {x} {y} {z}  -0.1 0.2 0  0 1 0  Camera \"perspective\" \"float fov\" 90 \"vector3 velocity\" [{} {} {}]
         WorldBegin {spacetime}
         Material \"diffuse\" \"spectrum reflectance\" 0
         AreaLightSource \"diffuse\" \"tolman L\" {T0} \"bool twosided\" true
         Shape \"trianglemesh\" \"point3 P\" [-3 -2.5 -3.2  3 -2.5 -3.2  -3 2.5 -3.2  3 2.5 -3.2  -3 -2.5 3  3 -2.5 3  -3 2.5 3  3 2.5 3]
            \"integer indices\" [0 2 3  0 3 1  4 5 7  4 7 6  0 1 5  0 5 4  2 6 7  2 7 3  0 4 6  0 6 2  1 3 7  1 7 5]
         {inner}",
        SIZE[0], SIZE[1], v.x, v.y, v.z
    );
    common::render(&common::build(&text)).frame.picture().data
}

/// The same by closed form: in the direction d that the camera measures, the black body of `T0 / (N k (1 - v.d))`.
fn expected(lapse: f64, v: DVec3) -> Vec<f64> {
    const FINE: usize = 8;
    let k = 1.0 / (1.0 - v.length_squared()).sqrt();
    let [width, height] = SIZE;
    let mut picture = Vec::new();
    for (row, column) in (0..height).flat_map(|row| (0..width).map(move |column| (row, column))) {
        let mut pixel = [0.0; 3];
        for sub in 0..FINE * FINE {
            let at = |i: usize, s: usize| i as f64 + (s as f64 + 0.5) / FINE as f64;
            let x = (at(column, sub % FINE) * 2.0 - width as f64) * HALF / height as f64;
            let y = (height as f64 - at(row, sub / FINE) * 2.0) * HALF / height as f64;
            let doppler = 1.0 / (k * (1.0 - v.dot(DVec3::new(x, y, 1.0).normalize())));
            let rgb = rgb_of(|l| planck(T0 / lapse * doppler, l), [360.0, 830.0], 2);
            (0..3).for_each(|c| pixel[c] += rgb[c] / (FINE * FINE) as f64);
        }
        picture.extend(pixel);
    }
    picture
}

#[test]
fn a_moving_camera_sees_rooms_in_equilibrium_hotter_ahead_in_every_spacetime() {
    let ball = |x: f64, r: f64| format!("AttributeBegin Translate {x} 0 0 Shape \"sphere\" \"float radius\" {r} AttributeEnd ");
    let far_room = "Side \"far\" Translate 0.3 0.1 -0.2 Shape \"sphere\" \"float radius\" 3";
    let r = CAMERA.length();
    let potential = |x: f64, m: f64| m / (CAMERA - DVec3::X * x).length();
    let cases = [
        ("BlackHole \"schwarzschild\" \"float rs\" 1", ball(0.0, 1.05), lapse(r)),
        (
            "BlackHole \"majumdar-papapetrou\" \"point3 centers\" [-0.8 0 0  0.8 0 0] \"float masses\" [0.3 0.2]",
            ball(-0.8, 0.2) + &ball(0.8, 0.2),
            1.0 / (1.0 + potential(-0.8, 0.3) + potential(0.8, 0.2)),
        ),
        (
            "BlackHole \"reissner-nordstrom\" \"float rs\" 0.8 \"float charge\" 0.9",
            ball(0.0, 0.7),
            (1.0 - 0.8 / r + (0.9 * 0.4f64).powi(2) / (r * r)).sqrt(),
        ),
        ("Wormhole \"ellis\" \"float throat\" 0.8", far_room.to_owned(), 1.0),
        ("Wormhole \"dneg\" \"float throat\" 0.5 \"float length\" 0.3 \"float lensingwidth\" 0.2", far_room.to_owned(), 1.0),
    ];
    for (spacetime, inner, lapse) in cases {
        for v in [DVec3::ZERO, DVec3::new(0.2, -0.1, 0.5)] {
            let seen = room(spacetime, &inner, v);
            let off = seen.iter().zip(expected(lapse, v)).map(|(seen, e)| (f64::from(*seen) / e - 1.0).abs());
            let worst = off.fold(0.0, f64::max);
            eprintln!("{spacetime}, velocity {v}: {worst:.1e}");
            assert!(worst < 2e-3, "{spacetime}, velocity {v}: {worst:.1e}");
        }
    }
}
