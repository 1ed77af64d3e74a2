//! What tests of physics hold pictures against: Planck's law, the eye, orbits by quadrature. Nothing here comes from the program.

use bhs::lang::BuiltScene;
use bhs_core::ray::Ray;
use bhs_core::sampling::SampleStream;
use bhs_core::spectrum::{N_LAMBDA, SampledWavelengths};
use bhs_engine::stats::PathLog;
use bhs_engine::transport::PathSample;
use glam::DVec3;

/// `sqrt(1 - rs/r)` with r in units of rs: the clock of a static observer at r over one far away.
pub fn lapse(r: f64) -> f64 {
    (1.0 - 1.0 / r).sqrt()
}

/// Spectral radiance of a black body [W m^-2 sr^-1 nm^-1] by Planck's law, in SI units throughout.
pub fn planck(temperature: f64, lambda_nm: f64) -> f64 {
    let (h, c, k) = (6.626_070_15e-34, 299_792_458.0, 1.380_649e-23);
    let l = lambda_nm * 1e-9;
    2.0 * h * c * c / l.powi(5) / (h * c / (l * k * temperature)).exp_m1() * 1e-9
}

/// Linear sRGB that a film of the range `lo..hi` (nm) records of `radiance`: trapezia of 1/`fine` nm over the CIE 1931 table,
/// `XYZ = integral(L xyz-bar) / integral(y-bar)`, and the matrix that Lindbloom publishes for sRGB
/// and the D65 of ASTM E308.
pub fn rgb_of(radiance: impl Fn(f64) -> f64, [lo, hi]: [f64; 2], fine: u32) -> [f64; 3] {
    let table = super::read("plugins/colour/data/cie1931_2deg_1nm.csv");
    let rows: Vec<[f64; 4]> = table
        .lines()
        .filter_map(|l| l.split(',').map(|w| w.parse().ok()).collect::<Option<Vec<f64>>>()?.try_into().ok())
        .collect();
    assert_eq!(rows.len(), 471);
    let (mut xyz, mut y) = ([0.0; 3], 0.0);
    for pair in rows.windows(2) {
        for i in 0..fine {
            let t = (f64::from(i) + 0.5) / f64::from(fine);
            let [l, bar @ ..]: [f64; 4] = std::array::from_fn(|k| pair[0][k] + t * (pair[1][k] - pair[0][k]));
            y += bar[1] / f64::from(fine);
            if (lo..hi).contains(&l) {
                let value = radiance(l);
                xyz.iter_mut().zip(bar).for_each(|(sum, bar)| *sum += value * bar / f64::from(fine));
            }
        }
    }
    let [x, g, z] = xyz.map(|v| v / y);
    [
        3.240_454_2 * x - 1.537_138_5 * g - 0.498_531_4 * z,
        -0.969_266_0 * x + 1.876_010_8 * g + 0.041_556_0 * z,
        0.055_643_4 * x - 0.204_025_9 * g + 1.057_225_2 * z,
    ]
}

/// Largest relative deviation of a pixel of the scene, and of the mean of all, from a black body; fails if a ray gets out of it.
pub fn deviation(text: &str, temperature: f64) -> (f64, f64) {
    let built = super::build(text);
    let expected = rgb_of(|l| planck(temperature, l), [360.0, 830.0], 10);
    let rendered = super::render(&built);
    let lost = rendered.counters.captured + rendered.counters.escaped + rendered.counters.out_of_steps;
    assert_eq!(lost, 0, "the room leaks: {:?}", rendered.counters);
    let picture = rendered.frame.picture();
    let pixels: Vec<_> = picture.data.chunks_exact(3).collect();
    let off = |k: usize, value: f64| (value / expected[k] - 1.0).abs();
    let of_pixel = |k: usize| pixels.iter().map(|p| off(k, f64::from(p[k]))).fold(0.0, f64::max);
    let of_mean = |k: usize| off(k, pixels.iter().map(|p| f64::from(p[k])).sum::<f64>() / pixels.len() as f64);
    ((0..3).map(of_pixel).fold(0.0, f64::max), (0..3).map(of_mean).fold(0.0, f64::max))
}

/// The spectral radiance that the scene's method finds at the wavelengths `lambda_nm` along the local direction `local` of the
/// observer at the camera; sample number `index`.
pub fn radiance(built: &BuiltScene, local: DVec3, lambda_nm: [f32; N_LAMBDA], index: u32, log: &mut PathLog) -> [f32; N_LAMBDA] {
    let scene = &built.scene;
    let observer = scene
        .observer(bhs_core::spacetime::Place::near(built.camera.position()))
        .expect("a camera stands outside of the horizon");
    let direction = observer.chart_direction(local);
    let ray = Ray { footprint: scene.footprints.camera, ..Ray::new(built.camera.position(), direction) };
    let to_infinity = observer.ratio(direction).recip();
    let lambda = SampledWavelengths { lambda_nm, pdf: [1.0; N_LAMBDA] };
    let lambda = SampledWavelengths { lambda_nm: lambda.at(to_infinity as f32), ..lambda };
    let mut path = PathSample::new(ray, lambda, SampleStream::new(&*built.sampler, [0, 0], index));
    built.transport.follow(scene, &mut path, log);
    (path.radiance * scene.radiance_factor(to_infinity)).0
}

/// `n` directions spread evenly over the sphere (a Fibonacci lattice), with the z axis as its own.
pub fn directions(n: u32) -> impl Iterator<Item = DVec3> {
    let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
    (0..n).map(move |i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(n);
        let (sin, cos) = (golden * f64::from(i)).sin_cos();
        let s = (1.0 - z * z).sqrt();
        DVec3::new(s * cos, s * sin, z)
    })
}

/// Sine of the angle from the hole at which a static observer at `r` (in rs) sees the shadow's edge (Synge 1966).
pub fn shadow_sine(r: f64) -> f64 {
    // 1 at 1.5 rs, but for rounding.
    (1.5 * 3f64.sqrt() * lapse(r) / r).min(1.0)
}

/// Angle swept (rad) by the orbit with pericentre `1/um` from radius `1/u` to it, rs = 1: the quadrature of `du / sqrt(P(u))`, the
/// singular factor `um - u = w^2` taken out (Simpson's rule in w).
pub fn swept_to_pericentre(um: f64, u: f64) -> f64 {
    let integrand = |w: f64| {
        let u = um - w * w;
        2.0 / ((um + u) - (um * um + um * u + u * u)).sqrt()
    };
    let n = 2000;
    let h = (um - u).sqrt() / f64::from(n);
    let sum: f64 = (0..=n)
        .map(|i| integrand(f64::from(i) * h) * [1.0, 4.0, 2.0][if i == 0 || i == n { 0 } else { 2 - i % 2 } as usize])
        .sum();
    sum * h / 3.0
}
