//! Thin discs: what is seen of them, against closed forms that are stated here again.

use crate::common;
use crate::common::physics::{planck, radiance};
use bhs::lang::BuiltScene;
use bhs_core::camera::CameraRay;
use bhs_core::ray::{Arrival, Ray, SurfaceHit};
use bhs_core::spectrum::SampledWavelengths;
use glam::{DVec2, DVec3, Vec2};
use std::f64::consts::TAU;

/// Size of the pictures (pixels), and the opening of their shorter side (degrees).
const SIZE: [usize; 2] = [48, 27];
const FOV: f64 = 50.0;
/// Temperature of the hottest ring (K).
const HOTTEST: f64 = 8000.0;

/// A disc in the plane y = 0 around a hole of M = 1 that spins about +y, seen by a static eye at Boyer and Lindquist's radius 30.
#[derive(Clone, Copy, Debug)]
struct View {
    spin: f64,
    /// Of the eye against the axis (degrees).
    inclination: f64,
    retrograde: bool,
}

const VIEWS: [View; 4] = [
    View { spin: 0.0, inclination: 80.0, retrograde: false },
    View { spin: 0.9, inclination: 80.0, retrograde: false },
    View { spin: 0.7, inclination: 35.0, retrograde: true },
    View { spin: -0.5, inclination: 60.0, retrograde: false },
];

impl View {
    fn eye(&self) -> DVec3 {
        let (sin, cos) = self.inclination.to_radians().sin_cos();
        DVec3::new(0.0, 30.0 * cos, -30f64.hypot(self.spin) * sin)
    }

    fn built(&self, film: &str, light: &str) -> BuiltScene {
        common::build(&self.text(film, light))
    }

    fn text(&self, film: &str, light: &str) -> String {
        let (DVec3 { x, y, z }, Self { spin, retrograde, .. }) = (self.eye(), self);
        format!(
            r#"
            {film}
            PixelFilter "box" "float xradius" 0.001 "float yradius" 0.001
            Sampler "independent" "integer pixelsamples" 1
            LightTransport "path" "integer maxdepth" 0
            LookAt {x} {y} {z}  0 0 0  0 1 0
            Camera "perspective" "float fov" {FOV}
            WorldBegin
            BlackHole "kerr" "float rs" 2 "float spin" {spin}
            Texture "board" "float" "checkerboard" "float uscale" 8 "float vscale" 3 "float tex1" 1 "float tex2" 0.25
            AreaLightSource "thindisc" "float temperature" {HOTTEST} "bool retrograde" {retrograde} {light}
            Rotate -90 1 0 0
            Shape "disk" "float radius" 16 "string motion" "keplerian" "bool retrograde" {retrograde}
            "#
        )
    }

    /// `L/E` of the light that the eye sees there (the static observer's `n_phi`, solved for L).
    fn momentum(&self, looked: DVec3) -> f64 {
        let (a, r) = (self.spin, 30.0f64);
        let (sin, cos) = self.inclination.to_radians().sin_cos();
        let (s, d) = (r * r + a * a * cos * cos, r * r - 2.0 * r + a * a);
        let lapse = (1.0 - 2.0 * r / s).sqrt();
        // Light moves the other way; phi turns along y x x.
        let n_phi = -looked.dot(DVec3::Y.cross(self.eye()).normalize());
        (n_phi * sin * (d * s).sqrt() / (s - 2.0 * r).sqrt() - 2.0 * a * r * sin * sin / s / lapse) / lapse
    }

    /// `nu_observed/nu_emitted` of matter at `r`, whose light has the momentum `l`.
    fn redshift(&self, r: f64, l: f64) -> f64 {
        let (a, l) = if self.retrograde { (-self.spin, -l) } else { (self.spin, l) };
        let cos = self.inclination.to_radians().cos();
        let lapse = (1.0 - 60.0 / (900.0 + (self.spin * cos).powi(2))).sqrt();
        (r.powi(3) - 3.0 * r * r + 2.0 * a * r.powf(1.5)).sqrt() / (r.powf(1.5) + a - l) / lapse
    }

    /// Boyer and Lindquist's radius of the innermost stable orbit.
    fn isco(&self) -> f64 {
        let a = if self.retrograde { -self.spin } else { self.spin };
        let z1 = 1.0 + (1.0 - a * a).cbrt() * ((1.0 + a).cbrt() + (1.0 - a).cbrt());
        let z2 = (3.0 * a * a + z1 * z1).sqrt();
        3.0 + z2 - a.signum() * ((3.0 - z1) * (3.0 + z1 + 2.0 * z2)).sqrt()
    }

    /// The same in the chart.
    fn edge(&self) -> f64 {
        self.isco().hypot(self.spin)
    }

    /// Temperature of the disc at `r` (K), by Page and Thorne's eq. 15n.
    fn temperature(&self, r: f64) -> f64 {
        let a = if self.retrograde { -self.spin } else { self.spin };
        let isco = self.isco();
        let third = a.acos() / 3.0;
        let roots = [2.0 * (third - TAU / 6.0).cos(), 2.0 * (third + TAU / 6.0).cos(), -2.0 * third.cos()];
        let flux = |r: f64| {
            let (x, x0) = (r.sqrt(), isco.sqrt());
            let terms = (0..3).map(|i| {
                let [p, q, s] = [0, 1, 2].map(|k| roots[(i + k) % 3]);
                if p.abs() < 1e-12 { 0.0 } else { 3.0 * (p - a).powi(2) / (p * (p - q) * (p - s)) * ((x - p) / (x0 - p)).ln() }
            });
            let bracket = x - x0 - 1.5 * a * (x / x0).ln() - terms.sum::<f64>();
            1.5 / (x.powi(4) * (x.powi(3) - 3.0 * x + 2.0 * a)) * bracket
        };
        let greatest = (1..20_000).map(|i| flux(isco * (1.0 + 1e-4 * f64::from(i)))).fold(0.0, f64::max);
        HOTTEST * (flux(r) / greatest).max(0.0).powf(0.25)
    }

    /// Boyer and Lindquist's radius of a point of the plane.
    fn radius(&self, point: DVec3) -> f64 {
        (point.length_squared() - self.spin * self.spin).sqrt()
    }
}

/// The local direction in which the eye looks through the middle of a pixel.
fn looked(built: &BuiltScene, pixel: usize) -> DVec3 {
    let raster = DVec2::new((pixel % SIZE[0]) as f64 + 0.5, (pixel / SIZE[0]) as f64 + 0.5);
    built.camera.ray(raster, Vec2::splat(0.5)).direction
}

/// Where the disc is seen in a local direction.
fn seen(built: &BuiltScene, looked: DVec3) -> Option<(Ray, SurfaceHit, f64)> {
    let scene = &built.scene;
    let eye = CameraRay { origin: built.camera.position(), direction: looked };
    let (ray, ratio) = scene.camera_ray(&eye, &built.viewpoint);
    match scene.integrator.trace(&scene.world, &ray).arrival {
        Arrival::Surface(hit) => Some((ray, hit, ratio.expect("the eye stands outside"))),
        _ => None,
    }
}

fn film(layers: &str) -> String {
    format!(r#"Film "rgb" "integer xresolution" {} "integer yresolution" {} {layers}"#, SIZE[0], SIZE[1])
}

/// At every pixel the frequency ratio is that of circular orbits, by the momentum of the pixel's light and the radius where it ends; and its light is that of
/// a black body of the ring's temperature times that ratio.
#[test]
fn every_pixel_is_a_black_body_of_the_shifted_temperature() {
    let lambda = [400.0f32, 500.0, 600.0, 700.0];
    for view in VIEWS {
        let built = view.built(&film("\"string layers\" [\"redshift\"]\nIntegrator \"adaptive\" \"float tolerance\" 1e-10"), "");
        let layer = &common::render(&built).frame.layers()[0].values;
        let (mut worst, mut off, mut count, mut differ) = (0.0f64, 0.0f64, 0, 0);
        for pixel in 0..SIZE[0] * SIZE[1] {
            let looked = looked(&built, pixel);
            let Some((_, hit, at_eye)) = seen(&built, looked) else { continue };
            let r = view.radius(hit.point);
            let wanted = view.redshift(r, view.momentum(looked));
            let wavelengths = SampledWavelengths { lambda_nm: lambda, pdf: [1.0; 4] };
            let vertex = built.scene.vertex(hit, &wavelengths).expect("an orbit");
            worst = worst.max((vertex.ratio / at_eye / wanted - 1.0).abs());
            count += 1u32;
            // The picture's ray passes within a thousandth of a pixel of the middle, which matters in narrow images only.
            differ += u32::from(layer[pixel].is_none_or(|[shift, ..]| (shift / wanted - 1.0).abs() > 2e-3));
            let found = radiance(&built, looked, lambda, 0, &mut Default::default());
            let body = wanted * view.temperature(r);
            // Fainter light is that of the edge, where the flux goes to 0 with the square of the distance.
            for (l, value) in lambda.into_iter().zip(found).filter(|_| body > 1000.0) {
                off = off.max((f64::from(value) / planck(body, f64::from(l)) - 1.0).abs());
            }
        }
        eprintln!("{view:?}: {count} pixels; redshift off by {worst:.1e}, layer otherwise at {differ}, radiance by {off:.1e}");
        assert!(count > 200, "{view:?}: {count}");
        // Radiance: single precision of wavelengths, in the exponent of Wien's law.
        assert!(worst < 1e-6 && 50 * differ < count && off < 3e-5, "{view:?}: {worst:e} {differ} {off:e}");
    }
}

/// The channels of a spectral film are the means of Planck's law over their buckets.
#[test]
fn the_spectrum_of_a_pixel_is_plancks() {
    let view = VIEWS[1];
    let film = r#"Film "spectral" "integer nbuckets" 8 "integer xresolution" 1 "integer yresolution" 1 "float lambdamin" 400 "float lambdamax" 720"#;
    let eye = view.eye();
    let (right, ahead) = (DVec3::X, -eye.normalize());
    for (x, y) in [(-0.24, 0.02), (0.22, 0.03), (0.0, 0.2)] {
        let target = eye + ahead + right * x + ahead.cross(right) * y;
        let text = view.text(film, "").replace("0 0 0  0 1 0", &format!("{} {} {}  0 1 0", target.x, target.y, target.z));
        let text = text
            .replace(&format!("\"float fov\" {FOV}"), "\"float fov\" 1e-6")
            .replace("\"integer pixelsamples\" 1", "\"integer pixelsamples\" 16384");
        let text = text.replace("Sampler \"independent\"", "Sampler \"sobol\"");
        let built = common::build(&text);
        let looked = built.camera.ray(DVec2::splat(0.5), Vec2::splat(0.5)).direction;
        let (_, hit, _) = seen(&built, looked).expect("the disc");
        let r = view.radius(hit.point);
        let body = view.redshift(r, view.momentum(looked)) * view.temperature(r);
        let picture = common::render(&built).frame.picture();
        let channels = &picture.pixel(0, 0)[3..];
        assert_eq!(channels.len(), 8);
        for (k, found) in channels.iter().enumerate() {
            let mean =
                (0..400).map(|i| planck(body, 400.0 + 40.0 * (k as f64 + (f64::from(i) + 0.5) / 400.0))).sum::<f64>() / 400.0;
            // Some 8000 evenly spread wavelengths fall into a bucket.
            assert!((f64::from(*found) / mean - 1.0).abs() < 0.02, "({x}, {y}), bucket {k}: {found} {mean}");
        }
    }
}

/// What lies on the disc at time 0 has turned with its orbit when its light leaves, by the time that the light has still to go.
#[test]
fn patterns_turn_with_the_orbits_and_are_seen_late() {
    for view in VIEWS {
        for time in [0.0, 250.0] {
            let [plain, patterned] = ["".to_owned(), format!(r#""texture modulation" "board" "float time" {time}"#)]
                .map(|light| view.built(&film(""), &light));
            let (mut bright, mut dark) = (0, 0);
            for pixel in 0..SIZE[0] * SIZE[1] {
                let looked = looked(&plain, pixel);
                let Some((ray, hit, _)) = seen(&plain, looked) else { continue };
                let r = view.radius(hit.point);
                let sense = if view.retrograde { -1.0 } else { 1.0 };
                let omega = sense / (r.powf(1.5) + sense * view.spin);
                let late = plain.scene.integrator.travel_time(&plain.scene.world, &ray).expect("it ends on the disc");
                // Azimuth along y x x, which is z towards x; the disk's own runs from x towards -z.
                let phi = (-hit.point.z).atan2(hit.point.x) - omega * (time - late);
                let v = 1.0 - (hit.point.length() - view.edge()) / (16.0 - view.edge());
                let square = [8.0 * (phi / TAU).rem_euclid(1.0), 3.0 * v];
                if square.iter().any(|s| (s - s.round()).abs() < 1e-3) {
                    continue;
                }
                let odd = (square[0].floor() + square[1].floor()).rem_euclid(2.0) >= 1.0;
                let [whole, found] = [&plain, &patterned].map(|b| radiance(b, looked, [600.0; 4], 0, &mut Default::default())[0]);
                if whole > 0.0 {
                    let wanted = if odd { 0.25 } else { 1.0 };
                    assert!((found / whole - wanted).abs() < 1e-4, "{view:?} {time} {pixel}: {found} {whole}, expected {wanted}");
                    if odd { dark += 1 } else { bright += 1 }
                }
            }
            assert!(bright > 80 && dark > 80, "{view:?}: {bright} {dark}");
        }
    }
}

/// A disk that does not say where it begins does so at the innermost stable orbit, and one that does where it says.
#[test]
fn the_disk_begins_at_the_innermost_stable_orbit() {
    for view in VIEWS {
        let built = view.built(&film(""), "");
        let bhs_core::geometry::Geometry::Analytic(disk) = &built.scene.world.geometries[0] else { panic!("no disk") };
        let area = TAU / 2.0 * (256.0 - view.edge().powi(2));
        assert!((disk.area() / area - 1.0).abs() < 1e-9, "{view:?}: {} {area}", disk.area());
        let stated = common::build(
            &view.text(&film(""), "").replace("\"float radius\" 16", "\"float radius\" 16 \"float innerradius\" 3"),
        );
        let bhs_core::geometry::Geometry::Analytic(disk) = &stated.scene.world.geometries[0] else { panic!("no disk") };
        assert!((disk.area() / (TAU / 2.0 * 247.0) - 1.0).abs() < 1e-12);
    }
}
