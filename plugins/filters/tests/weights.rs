//! The samples of a filter, with their weights, are the filter: means of test pictures against quadrature of its formula.

use bhs_core::camera::Filter;
use bhs_core::diagnostics::{Diagnostic, Span, Spanned};
use bhs_core::params::{Context, Files, Params, SpectrumSource};
use bhs_core::sampling::ONE_MINUS_EPSILON;
use bhs_core::spectrum::{Spectrum, SpectrumRole};
use bhs_core::value::{Param, ParamType, Values};
use glam::{DAffine3, DVec2, Vec2};
use std::f64::consts::PI;
use std::sync::Arc;

struct Nothing;

impl Files for Nothing {
    fn read(&self, _: &str, _: Span) -> Result<Vec<u8>, String> {
        Err("no such file".into())
    }
}

impl SpectrumSource for Nothing {
    fn build(&self, _: &Param, _: SpectrumRole, _: &Context) -> Result<Arc<dyn Spectrum>, Vec<Diagnostic>> {
        Err(Vec::new())
    }
}

fn filter(name: &str, params: &[(&str, f64)]) -> Box<dyn Filter> {
    let span = Span::default();
    let param = |(name, value): &(&str, f64)| Param {
        ty: Spanned::new(ParamType::Float, span),
        name: Spanned::new((*name).into(), span),
        values: Values::Numbers { values: vec![*value], whole: false },
        span,
    };
    let params: Vec<Param> = params.iter().map(param).collect();
    let context = Context {
        files: &Nothing,
        spectra: &Nothing,
        named: &bhs_core::params::Nameless,
        world_from_object: DAffine3::IDENTITY,
        reverse_orientation: false,
        resolution: [1, 1],
        lambda_range: [360.0, 830.0],
        seed: 0,
    };
    let plugin = bhs_filters::ALL.iter().find(|p| p.name == name).expect("a filter");
    let p = Params::new(Spanned::new(name.into(), span), &params, context);
    let built = (plugin.build)(&p);
    assert!(p.finish().0.is_empty());
    built.expect("a filter")
}

/// Weighted mean of a picture that varies as `cos(a x) cos(b y)` around the pixel, by well distributed samples (Roberts 2018, the sequence R2:
/// multiples of the inverse powers of the plastic number).
fn by_samples(filter: &dyn Filter, a: f64, b: f64) -> (f64, f64) {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    let (mut sum, mut weights, mut sizes) = (0.0, 0.0, 0.0);
    for i in 0..1_000_000 {
        let u = DVec2::new(f64::from(i) / PLASTIC, f64::from(i) / (PLASTIC * PLASTIC))
            .fract()
            .as_vec2()
            .min(Vec2::splat(ONE_MINUS_EPSILON));
        let (offset, weight) = filter.sample(u);
        let weight = f64::from(weight);
        sum += weight * (a * f64::from(offset.x)).cos() * (b * f64::from(offset.y)).cos();
        weights += weight;
        sizes += weight.abs();
    }
    // How much of the samples cancels.
    (sum / weights, weights / sizes)
}

/// The same of one curve by the midpoint rule.
fn by_quadrature(curve: &dyn Fn(f64) -> f64, radius: f64, a: f64) -> (f64, f64) {
    let n = 200_000;
    let (mut sum, mut total, mut size) = (0.0, 0.0, 0.0);
    for i in 0..n {
        let x = (2.0 * (f64::from(i) + 0.5) / f64::from(n) - 1.0) * radius;
        let f = curve(x);
        sum += f * (a * x).cos();
        total += f;
        size += f.abs();
    }
    (sum / total, total / size)
}

fn check(name: &str, params: &[(&str, f64)], radius: [f64; 2], curve: impl Fn(f64, f64) -> f64) {
    let filter = filter(name, params);
    for (a, b) in [(0.0, 0.0), (0.7, 1.3), (2.0, 0.4), (3.0, 3.0)] {
        let (seen, kept) = by_samples(filter.as_ref(), a, b);
        let [x, y] = [(radius[0], a), (radius[1], b)].map(|(r, k)| by_quadrature(&|x| curve(x, r), r, k));
        assert!((seen - x.0 * y.0).abs() < 1e-3, "{name} {a} {b}: {seen} {}", x.0 * y.0);
        assert!((kept - x.1 * y.1).abs() < 2e-3, "{name}: {kept} {}", x.1 * y.1);
    }
}

#[test]
fn weights_reproduce_the_filter() {
    check("box", &[], [0.5, 0.5], |_, _| 1.0);
    check("box", &[("xradius", 2.0)], [2.0, 0.5], |_, _| 1.0);
    check("triangle", &[], [2.0, 2.0], |x, r| r - x.abs());
    check("triangle", &[("yradius", 0.7)], [2.0, 0.7], |x, r| r - x.abs());
    let gauss = |x: f64, r: f64, s: f64| (-(x * x) / (2.0 * s * s)).exp() - (-(r * r) / (2.0 * s * s)).exp();
    check("gaussian", &[], [1.5, 1.5], |x, r| gauss(x, r, 0.5));
    check("gaussian", &[("sigma", 1.2), ("xradius", 3.0)], [3.0, 1.5], |x, r| gauss(x, r, 1.2));
    // The B-spline by convolving boxes: B = 1, C = 0 over a radius of 2 pixels.
    let spline = |x: f64| {
        let x = x.abs();
        if x < 1.0 { 2.0 / 3.0 - x * x + x * x * x / 2.0 } else { (2.0 - x).powi(3) / 6.0 }
    };
    check("mitchell", &[("B", 1.0), ("C", 0.0)], [2.0, 2.0], |x, _| spline(x));
    // Catmull and Rom's interpolation: 1 at 0, 0 at whole numbers.
    let interpolating = |x: f64| {
        let x = x.abs();
        if x < 1.0 { 1.5 * x * x * x - 2.5 * x * x + 1.0 } else { -0.5 * x * x * x + 2.5 * x * x - 4.0 * x + 2.0 }
    };
    check("mitchell", &[("B", 0.0), ("C", 0.5)], [2.0, 2.0], |x, _| interpolating(x));
    // The default is a third of the first and two thirds of the second.
    check("mitchell", &[("yradius", 4.0)], [2.0, 4.0], |x, r| {
        let x = 2.0 * x / r;
        spline(x) / 3.0 + 2.0 / 3.0 * interpolating(x)
    });
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
    check("sinc", &[], [4.0, 4.0], |x, _| sinc(x) * sinc(x / 3.0));
    check("sinc", &[("tau", 2.0), ("xradius", 2.0)], [2.0, 4.0], |x, _| sinc(x) * sinc(x / 2.0));
}

#[test]
fn samples_stay_within_the_radius_and_weights_near_their_sign() {
    for plugin in bhs_filters::ALL {
        let filter = filter(plugin.name, &[("xradius", 1.5), ("yradius", 2.5)]);
        let n = 200;
        let mut wild = 0;
        for i in 0..n * n {
            let u = Vec2::new((i % n) as f32, (i / n) as f32) / n as f32;
            let (offset, weight) = filter.sample(u);
            assert!(offset.x.abs() <= 1.5 && offset.y.abs() <= 2.5 && weight.is_finite(), "{}: {offset} {weight}", plugin.name);
            wild += usize::from((weight.abs() - 1.0).abs() > 0.1);
        }
        assert!(wild < n * n / 50, "{}: {wild}", plugin.name);
    }
}
