//! Surfaces that turn: rooms in thermal equilibrium with their walls, which no lens, no dragging and no reflection shows, and a matt disc in daylight.

use crate::common;
use crate::common::physics::{deviation, planck, radiance};
use bhs_core::observer::Observer;
use bhs_core::spacetime::Place;
use bhs_engine::stats::PathLog;
use glam::DVec3;

/// Temperature of walls whose clocks run as one far away (K).
const T0: f64 = 3200.0;
/// How fast all turns about +y (rad/length).
const OMEGA: f64 = 0.08;
/// Mass and spin of the hole at the origin.
const MASS: f64 = 0.4;
const SPIN: f64 = 0.9;
/// Where the camera is.
const CAMERA: DVec3 = DVec3::new(0.5, 0.3, -2.0);

const HOLE: &str = "Spacetime \"kerr\" \"float rs\" 0.8 \"float spin\" 0.9";
const TURNING: &str = "\"string motion\" \"rotating\" \"float omega\" 0.08";

/// Walls around the origin in equilibrium that turn, with a cover around a hole, of albedo `rho`; the camera moves by `motion`.
fn room(options: &str, (spacetime, motion): (&str, &str), rho: f64) -> String {
    let DVec3 { x, y, z } = CAMERA;
    let emitted = 1.0 - rho;
    let cover = if spacetime.is_empty() { String::new() } else { format!("Shape \"sphere\" \"float radius\" 0.95 {TURNING}") };
    format!(
        "{options} Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 3
         Translate {} {} {} Camera \"perspective\" \"float fov\" 110 {motion}
         WorldBegin {spacetime}
         Material \"diffuse\" \"spectrum reflectance\" {rho}
         AreaLightSource \"diffuse\" \"tolman L\" {T0} \"float scale\" {emitted} \"bool twosided\" true
         {cover}
         Shape \"sphere\" \"float radius\" 3.5 {TURNING}",
        -x, -y, -z
    )
}

/// `1/U^t` of what turns so at the camera: `sqrt(-g_tt - 2 Omega g_tphi - Omega^2 g_phiphi)` in Boyer and Lindquist's coordinates, by the book.
fn slowness(mass: f64) -> f64 {
    let a = SPIN * mass;
    let c = CAMERA.length_squared() - a * a;
    let r2 = 0.5 * (c + (c * c + 4.0 * a * a * CAMERA.y * CAMERA.y).sqrt());
    let (r, cos2) = (r2.sqrt(), CAMERA.y * CAMERA.y / r2);
    let (sigma, sin2) = (r2 + a * a * cos2, 1.0 - cos2);
    let (tt, tphi) = (-(1.0 - 2.0 * mass * r / sigma), -2.0 * mass * a * r * sin2 / sigma);
    let phiphi = (r2 + a * a + 2.0 * mass * a * a * r * sin2 / sigma) * sin2;
    (-tt - 2.0 * OMEGA * tphi - OMEGA * OMEGA * phiphi).sqrt()
}

/// How a camera turns with the room: the axis passes through the origin, which lies here in its coordinates.
fn with_the_room() -> String {
    let DVec3 { x, y, z } = -CAMERA;
    format!("{TURNING} \"point3 center\" [{x} {y} {z}]")
}

#[test]
fn who_turns_with_a_room_sees_one_temperature() {
    for (spacetime, mass) in [("", 0.0), (HOLE, MASS)] {
        let seen = T0 / slowness(mass);
        for (method, samples, rho, pixel, mean) in [
            ("LightTransport \"path\" \"integer maxdepth\" 0", 4096, 0.0, 2e-3, 1e-3),
            (
                "LightTransport \"path\" \"integer maxdepth\" 12 \"integer rrdepth\" 7 \"bool lightsampling\" false",
                1024,
                0.3,
                1e-2,
                2e-3,
            ),
            ("LightTransport \"path\" \"integer maxdepth\" 12 \"integer rrdepth\" 7", 2048, 0.3, 4e-2, 2e-3),
            ("LightTransport \"hemisphere\" \"integer maxdepth\" 10", 1024, 0.3, 3e-2, 2e-3),
        ] {
            let options = format!(
                "{method} Sampler \"sobol\" \"integer pixelsamples\" {samples} Integrator \"adaptive\" \"float tolerance\" 1e-3"
            );
            let found = deviation(&room(&options, (spacetime, &with_the_room()), rho), seen);
            assert!(found.0 < pixel && found.1 < mean, "{spacetime} {method}: {found:?}");
        }
    }
}

/// One at rest sees `T0/(N (1 - Omega L))`, with the angular momentum of each light: `E - Omega L` is conserved.
#[test]
fn who_stands_in_a_room_that_turns_sees_one_side_hotter() {
    let lambda = [400.0f32, 500.0, 600.0, 700.0];
    for spacetime in ["", HOLE] {
        let options = "LightTransport \"path\" \"integer maxdepth\" 0 Integrator \"adaptive\" \"float tolerance\" 1e-4";
        let built = common::build(&room(options, (spacetime, ""), 0.0));
        let metric = built.scene.world.spacetime().at(Place::near(built.camera.position())).expect("a place");
        let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
        for (i, local) in common::physics::directions(500).enumerate() {
            let seen = radiance(&built, local, lambda, i as u32, &mut PathLog::default());
            let d = Observer::at_rest(&metric).chart_direction(local);
            let l = CAMERA.cross(metric.momentum(-d)).y;
            let hotter = 1.0 / (metric.lapse * (1.0 - OMEGA * l));
            (least, most) = (least.min(hotter), most.max(hotter));
            for (value, l) in seen.iter().zip(lambda) {
                let off = f64::from(*value) / planck(T0 * hotter, f64::from(l)) - 1.0;
                assert!(off.abs() < 2e-4, "{spacetime} {local} {l}: {off:e}");
            }
        }
        assert!(most / least > 1.2, "{least} {most}");
    }
}

/// A matt disc that turns, in light from far away of an even spectrum: `L = rho E cos Dop_in^2 / (pi Dop_out^5)` (special relativity; with the solid
/// angle of the light, its cosine and `L lambda^5` as the matter has them).
#[test]
fn a_disc_that_turns_reflects_as_moving_matter_does() {
    let (omega, rho, e) = (0.5, 0.6, 3.0);
    let sun = DVec3::new(0.5, 0.3, -0.6);
    let text = format!(
        "LightTransport \"path\" \"integer maxdepth\" 1
         Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 3
         Translate 0 0 3 Camera \"perspective\"
         WorldBegin LightSource \"distant\" \"spectrum L\" {e} \"point3 from\" [{} {} {}] \"point3 to\" [0 0 0]
         Material \"diffuse\" \"spectrum reflectance\" {rho}
         Shape \"disk\" \"float radius\" 1.9 \"string motion\" \"rotating\" \"float omega\" {omega} \"vector3 axis\" [0 0 1]",
        sun.x, sun.y, sun.z
    );
    let built = common::build(&text);
    let lambda = [450.0f32, 500.0, 600.0, 650.0];
    let still = common::build(&text.replace("\"float omega\" 0.5", "\"float omega\" 0"));
    for x in [DVec3::new(1.5, 0.0, 0.0), DVec3::new(0.3, -1.7, 0.0), DVec3::new(-1.0, -1.2, 0.0), DVec3::ZERO] {
        let look = (x - DVec3::new(0.0, 0.0, -3.0)).normalize();
        let v = DVec3::Z.cross(x) * omega;
        let k = 1.0 / (1.0 - v.length_squared()).sqrt();
        // The matter looks towards the sun, and against the light that it sends to the eye.
        let (in_, out) = (k * (1.0 + v.dot(sun.normalize())), k * (1.0 + v.dot(look)));
        let right = in_ * in_ / out.powi(5);
        let of = |built| radiance(built, look, lambda, 0, &mut PathLog::default());
        for (moving, rest) in of(&built).into_iter().zip(of(&still)) {
            let cos = sun.normalize().z.abs();
            assert!((f64::from(rest) / (rho * e * cos / std::f64::consts::PI) - 1.0).abs() < 1e-5, "{rest}");
            assert!((f64::from(moving / rest) / right - 1.0).abs() < 2e-5, "{x}: {moving} {rest} {right}");
        }
    }
}
