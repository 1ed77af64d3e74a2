//! What the tests share: spacetimes built as scenes build them, points, and a quadrature.
#![allow(dead_code)] // no test needs all of it

use bhs_core::diagnostics::{Diagnostic, Span, Spanned};
use bhs_core::params::{Context, Files, Params, SpectrumSource};
use bhs_core::spacetime::{Class, GradedIndex, Spacetime};
use bhs_core::spectrum::{Spectrum, SpectrumRole};
use bhs_core::value::{Param, ParamType, Values};
use glam::{DAffine3, DVec3};
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

/// Parameters such as `("float rs", &[0.5])`.
pub type Given<'a> = &'a [(&'a str, &'a [f64])];

/// The spacetime `name` under a transform, and what is wrong with them.
pub fn build_under(transform: DAffine3, name: &str, params: Given) -> (Option<Box<dyn Spacetime>>, Vec<Diagnostic>) {
    let span = Span::default();
    let param = |(typed, values): &(&str, &[f64])| {
        let (word, name) = typed.split_once(' ').expect("a type and a name");
        Param {
            ty: Spanned::new(ParamType::from_word(word).expect("a type"), span),
            name: Spanned::new(name.into(), span),
            values: Values::Numbers { values: values.to_vec(), whole: false },
            span,
        }
    };
    let params: Vec<Param> = params.iter().map(param).collect();
    let context = Context {
        files: &Nothing,
        spectra: &Nothing,
        named: &bhs_core::params::Nameless,
        world_from_object: transform,
        reverse_orientation: false,
        resolution: [1, 1],
        lambda_range: [360.0, 830.0],
        seed: 0,
    };
    let plugin = bhs_spacetimes::ALL.iter().find(|p| p.name == name).expect("a spacetime");
    let p = Params::new(Spanned::new(name.into(), span), &params, context);
    let built = (plugin.build)(&p);
    (built, p.finish().0)
}

/// The spacetime `name` with parameters that are right.
pub fn build(name: &str, params: Given) -> Box<dyn Spacetime> {
    let (built, found) = build_under(DAffine3::IDENTITY, name, params);
    assert!(found.is_empty(), "{name}: {found:?}");
    built.expect("a spacetime")
}

/// One of each kind, with its centre away from the origin.
pub fn one_of_each() -> Vec<(&'static str, Box<dyn Spacetime>)> {
    let center: (&str, &[f64]) = ("point3 center", &[0.3, -0.2, 0.1]);
    let kinds: &[(&str, Given)] = &[
        ("minkowski", &[]),
        ("schwarzschild", &[center, ("float rs", &[0.8])]),
        ("reissner-nordstrom", &[center, ("float rs", &[0.8]), ("float charge", &[0.9])]),
        (
            "majumdar-papapetrou",
            &[("point3 centers", &[0.0, 0.1, 0.4, 0.2, 0.0, -0.5, -0.9, 0.0, 0.0]), ("float masses", &[0.5, 0.2, 0.3])],
        ),
        ("ellis", &[center, ("float throat", &[0.9])]),
        (
            "kerr",
            &[
                center,
                ("float rs", &[0.8]),
                ("float spin", &[0.7]),
                ("float charge", &[0.3]),
                ("vector3 axis", &[1.0, 2.0, -0.5]),
            ],
        ),
        ("dneg", &[center, ("float throat", &[0.9]), ("float length", &[0.6]), ("float lensingwidth", &[0.2])]),
    ];
    kinds.iter().map(|(name, params)| (*name, build(name, params))).collect()
}

/// Points around the holes of [`one_of_each`], some near and some far.
pub fn points() -> impl Iterator<Item = DVec3> {
    let mut random = Random(7);
    std::iter::from_fn(move || Some(random.direction() * (0.1 * 30.0_f64.powf(1.2 * random.next())))).take(200)
}

/// Numbers that look random (Steele and Vigna 2014: SplitMix).
pub struct Random(pub u64);

impl Random {
    /// The next number from 0 to 1.
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// A unit vector.
    pub fn direction(&mut self) -> DVec3 {
        let (z, angle) = (2.0 * self.next() - 1.0, std::f64::consts::TAU * self.next());
        let s = (1.0 - z * z).sqrt();
        DVec3::new(s * angle.cos(), s * angle.sin(), z)
    }
}

/// The graded index of a spacetime.
pub fn index_of(spacetime: &dyn Spacetime) -> Option<&dyn GradedIndex> {
    match spacetime.class() {
        Class::Index(index) => Some(index),
        _ => None,
    }
}

/// The integral of `f` over an interval at whose ends it may have singularities that can be integrated, or over all numbers above `a`:
/// tanh-sinh quadrature (Takahasi and Mori 1974), with ever smaller steps until two agree. `f` sees its place and the distances from
/// both ends.
pub fn integral(a: f64, b: f64, f: impl Fn(f64, f64, f64) -> f64) -> f64 {
    let half = 0.5 * (b - a);
    let term = |t: f64| {
        let s = std::f64::consts::FRAC_PI_2 * t.sinh();
        // Distances from the two ends.
        let (left, right) = (2.0 * half / (1.0 + (-2.0 * s).exp()), 2.0 * half / (1.0 + (2.0 * s).exp()));
        let weight = half * std::f64::consts::FRAC_PI_2 * t.cosh() / (s.cosh() * s.cosh());
        if weight == 0.0 || left == 0.0 || right == 0.0 {
            return 0.0;
        }
        weight * f(if left < right { a + left } else { b - right }, left, right)
    };
    let mut step = 0.5;
    let mut sum: f64 = (-12..=12).map(|k| term(0.5 * f64::from(k))).sum();
    let mut last = sum * step;
    for _ in 0..10 {
        step *= 0.5;
        let count = (6.0 / step) as i32;
        sum += (-count..=count).filter(|k| k % 2 != 0).map(|k| term(step * f64::from(k))).sum::<f64>();
        let now = sum * step;
        if (now - last).abs() <= 1e-14 * now.abs() {
            return now;
        }
        last = now;
    }
    last
}

/// The integral of `f` over all numbers above `a`.
pub fn integral_from(a: f64, f: impl Fn(f64) -> f64) -> f64 {
    // x = a + t / (1 - t)
    integral(0.0, 1.0, |_, left, right| if right < 1e-100 { 0.0 } else { f(a + left / right) / (right * right) })
}
