//! What the tests of the materials share: materials from parameters, integrals over directions, the chi-square test.
#![allow(dead_code, reason = "each test file uses its part")]

use bhs_core::diagnostics::{Diagnostic, Span, Spanned};
use bhs_core::image::Image;
use bhs_core::material::{Material, Shading};
use bhs_core::params::{Context, Files, Named, Nameless, ParamInfo, Params};
use bhs_core::sampling::{mix64, unit_f32};
use bhs_core::spectrum::SampledSpectrum;
use bhs_core::texture::{Texture, TextureKind};
use bhs_core::value::{Param, ParamType, Values};
use bhs_materials::ALL;
use bhs_spectra::Builder;
use glam::{DAffine3, Vec2, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// A point with four wavelengths over the visible range.
pub const AT: Shading = Shading::at_uv(Vec2::ZERO, [450.0, 520.0, 589.0, 650.0]);

struct NoFiles;

impl Files for NoFiles {
    fn read(&self, _: &str, _: Span) -> Result<Vec<u8>, String> {
        Err("there are no files here".to_owned())
    }
}

/// The parameter number `i` of a list, each with a place of its own.
fn param(ty: ParamType, name: &str, values: Values) -> Param {
    let start = name.bytes().map(u32::from).sum();
    let span = Span { file: 0, start, end: start + 1 };
    Param { ty: Spanned::new(ty, span), name: Spanned::new(name.to_owned(), span), values, span }
}

/// `"float name" value`.
pub fn float(name: &str, value: f64) -> Param {
    param(ParamType::Float, name, Values::Numbers { values: vec![value], whole: false })
}

/// `"bool name" value`.
pub fn boolean(name: &str, value: bool) -> Param {
    param(ParamType::Bool, name, Values::Bools(vec![value]))
}

/// `"spectrum name" "value"`.
pub fn named(name: &str, value: &str) -> Param {
    let span = Span::default();
    param(ParamType::Spectrum, name, Values::Strings(vec![Spanned::new(value.to_owned(), span)]))
}

/// `"string name" [values]`.
pub fn texts(name: &str, values: &[&str]) -> Param {
    let text = |v: &&str| Spanned::new((*v).to_owned(), Span::default());
    param(ParamType::String, name, Values::Strings(values.iter().map(text).collect()))
}

/// `"texture name" "value"`.
pub fn texture(name: &str, value: &str) -> Param {
    param(ParamType::Texture, name, Values::Strings(vec![Spanned::new(value.to_owned(), Span::default())]))
}

/// A number that is `u`, and a grey that is `u`, of the texture coordinates.
struct Ramp;

impl Texture for Ramp {
    fn spectrum(&self, at: &Shading) -> SampledSpectrum {
        SampledSpectrum::splat(at.uv.x)
    }

    fn float(&self, at: &Shading) -> f32 {
        at.uv.x
    }
}

/// A scene with the texture "ramp", and the materials "gold" (rough), "mirror", "matt" (white) and "glass" (rough).
struct Things;

impl Named for Things {
    fn texture(&self, name: &Spanned<String>, kind: TextureKind, context: &Context) -> Result<Arc<dyn Texture>, Box<Diagnostic>> {
        match name.value.as_str() {
            "ramp" => Ok(Arc::new(Ramp)),
            _ => Nameless.texture(name, kind, context),
        }
    }

    fn material(&self, name: &Spanned<String>, context: &Context) -> Result<Arc<dyn Material>, Box<Diagnostic>> {
        match name.value.as_str() {
            "gold" => Ok(Arc::from(rough_gold(0.3))),
            "mirror" => Ok(Arc::from(build("mirror", &[]))),
            "matt" => Ok(Arc::from(build("diffuse", &[float("reflectance", 1.0)]))),
            "glass" => Ok(Arc::from(rough_glass(0.3))),
            _ => Nameless.material(name, context),
        }
    }

    fn image(&self, path: &Spanned<String>, context: &Context) -> Result<Arc<Image>, String> {
        Nameless.image(path, context)
    }
}

/// What surrounds a plugin in a scene with the given things.
pub fn context(things: &dyn Named) -> Context<'_> {
    Context {
        files: &NoFiles,
        spectra: &Builder,
        named: things,
        world_from_object: DAffine3::IDENTITY,
        reverse_orientation: false,
        resolution: [1, 1],
        lambda_range: [360.0, 830.0],
        seed: 0,
    }
}

/// The material, what was found, and the table of parameters.
pub fn try_build(plugin: &str, params: &[Param]) -> (Option<Box<dyn Material>>, Vec<Diagnostic>, Vec<ParamInfo>) {
    try_build_among(&Things, plugin, params)
}

/// As [`try_build`], in a scene with the given things.
pub fn try_build_among(
    things: &dyn Named,
    plugin: &str,
    params: &[Param],
) -> (Option<Box<dyn Material>>, Vec<Diagnostic>, Vec<ParamInfo>) {
    let p = Params::new(Spanned::new(plugin.to_owned(), Span::default()), params, context(things));
    let entry = ALL.iter().find(|e| e.name == plugin).expect("a material");
    let material = (entry.build)(&p);
    let (found, table) = p.finish();
    (material, found, table)
}

/// A material without faults.
pub fn build(plugin: &str, params: &[Param]) -> Box<dyn Material> {
    let (material, found, _) = try_build(plugin, params);
    assert!(found.is_empty(), "{found:?}");
    material.expect("without faults there is a material")
}

/// A metal with alpha as its roughness, of reflectance 1.
pub fn rough_white(alpha: f64) -> Box<dyn Material> {
    build("conductor", &[float("reflectance", 1.0), float("roughness", alpha), boolean("remaproughness", false)])
}

/// Rough gold.
pub fn rough_gold(alpha: f64) -> Box<dyn Material> {
    let gold = [named("eta", "metal-Au-eta"), named("k", "metal-Au-k")];
    build("conductor", &[&gold[..], &[float("roughness", alpha), boolean("remaproughness", false)]].concat())
}

/// A material with alphas as its two roughnesses; `prefix` is that of their names.
pub fn brushed(plugin: &str, prefix: &str, alpha: [f64; 2], params: &[Param]) -> Box<dyn Material> {
    let names = ["uroughness", "vroughness"].map(|n| format!("{prefix}{n}"));
    let rough = [float(&names[0], alpha[0]), float(&names[1], alpha[1]), boolean("remaproughness", false)];
    build(plugin, &[&rough[..], params].concat())
}

/// Glass with alpha as its roughness.
pub fn rough_glass(alpha: f64) -> Box<dyn Material> {
    build("dielectric", &[float("eta", 1.5), float("roughness", alpha), boolean("remaproughness", false)])
}

/// A white ground under a coat with alpha as its roughness.
pub fn coated(reflectance: f64, alpha: f64, thickness: f64) -> Box<dyn Material> {
    let coat = [float("roughness", alpha), boolean("remaproughness", false), float("thickness", thickness)];
    build("coateddiffuse", &[&coat[..], &[float("reflectance", reflectance)]].concat())
}

/// What glTF describes, with no smooth part: each lobe alone, and all of them together.
pub fn principled_rows() -> Vec<(String, Box<dyn Material>)> {
    let row = |name: &str, values: &[(&str, f64)], thin: bool| {
        let mut params: Vec<Param> = values.iter().map(|(name, value)| float(name, *value)).collect();
        params.extend([float("reflectance", 0.8), boolean("thin", thin)]);
        (format!("principled {name}"), build("principled", &params))
    };
    let all = [("metallic", 0.3), ("roughness", 0.6), ("clearcoat", 0.7), ("clearcoatroughness", 0.5), ("transmission", 0.4)];
    vec![
        row("plastic", &[("roughness", 0.4)], false),
        row("metal", &[("metallic", 1.0), ("roughness", 0.5)], false),
        row("matt", &[("roughness", 1.0), ("specular", 0.2)], false),
        row("lacquer", &[("clearcoat", 1.0), ("clearcoatroughness", 0.3), ("roughness", 0.9)], false),
        row("glass", &[("transmission", 1.0), ("roughness", 0.6)], false),
        row("pane", &[("transmission", 1.0), ("roughness", 0.6)], true),
        row("all, solid", &all, false),
        row("all, thin", &all, true),
    ]
}

/// The unit vector with cosine `z` and azimuth `phi`.
pub fn direction(z: f64, phi: f64) -> Vec3 {
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new((r * phi.cos()) as f32, (r * phi.sin()) as f32, z as f32)
}

/// Directions at `degrees` from the normal, some of them on the far side.
pub fn outgoing() -> Vec<Vec3> {
    [(0.0f64, 0.0), (30.0, 0.3), (60.0, 4.0), (85.0, 1.0), (140.0, 2.0)]
        .map(|(degrees, phi)| direction(degrees.to_radians().cos(), phi))
        .to_vec()
}

/// Number `k` of the random sequence `seed`, in [0,1).
pub fn random(seed: u64, k: u64) -> f32 {
    unit_f32((mix64(mix64(seed) ^ k) >> 32) as u32)
}

/// Integral of `f(z, phi)` over a rectangle by Gauss's rule, halved until halving changes nothing.
pub fn integrate(f: &dyn Fn(f64, f64) -> f64, z: [f64; 2], phi: [f64; 2], tolerance: f64) -> f64 {
    refine(f, z, phi, gauss(f, z, phi), tolerance, 0)
}

fn refine(f: &dyn Fn(f64, f64) -> f64, z: [f64; 2], phi: [f64; 2], whole: f64, tolerance: f64, depth: u32) -> f64 {
    let (zm, pm) = ((z[0] + z[1]) / 2.0, (phi[0] + phi[1]) / 2.0);
    let quarters =
        [([z[0], zm], [phi[0], pm]), ([z[0], zm], [pm, phi[1]]), ([zm, z[1]], [phi[0], pm]), ([zm, z[1]], [pm, phi[1]])]
            .map(|(z, phi)| (z, phi, gauss(f, z, phi)));
    let sum: f64 = quarters.iter().map(|q| q.2).sum();
    // The first halving is never trusted: a narrow peak may hide between the nodes.
    if (depth >= 1 && (sum - whole).abs() < tolerance) || depth == 12 {
        return sum;
    }
    quarters.into_iter().map(|(z, phi, part)| refine(f, z, phi, part, tolerance / 2.0, depth + 1)).sum()
}

/// Gauss's rule with 5 by 5 nodes.
fn gauss(f: &dyn Fn(f64, f64) -> f64, z: [f64; 2], phi: [f64; 2]) -> f64 {
    const NODES: [(f64, f64); 5] = [
        (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
        (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.0, 0.568_888_888_888_888_9),
        (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
        (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    ];
    let half = |r: [f64; 2]| ((r[0] + r[1]) / 2.0, (r[1] - r[0]) / 2.0);
    let ((zc, zh), (pc, ph)) = (half(z), half(phi));
    let mut sum = 0.0;
    for (x, wx) in NODES {
        for (y, wy) in NODES {
            sum += wx * wy * f(zc + zh * x, pc + ph * y);
        }
    }
    sum * zh * ph
}

/// Integral over all directions of the sphere.
pub fn over_sphere(f: &dyn Fn(Vec3) -> f64, tolerance: f64) -> f64 {
    let g = |z: f64, phi: f64| f(direction(z, phi));
    let n = 16;
    let cells = (0..2 * n).flat_map(|i| (0..n).map(move |j| (i, j)));
    let part = |i: i32, n: i32| f64::from(i) / f64::from(n);
    cells
        .map(|(i, j)| {
            let z = [part(i, n) - 1.0, part(i + 1, n) - 1.0];
            integrate(&g, z, [2.0 * PI * part(j, n), 2.0 * PI * part(j + 1, n)], tolerance / 512.0)
        })
        .sum()
}

/// The probability that directions drawn by `sample` (`None`: absorbed) would fit the density `pdf` no better than they do.
///
/// Pearson's test on a histogram over (cosine, azimuth), cells with few expected samples pooled, and a cell for absorption.
pub fn chi_square(sample: &dyn Fn(u64) -> Option<Vec3>, pdf: &dyn Fn(Vec3) -> f64) -> f64 {
    const SAMPLES: u64 = 200_000;
    const ROWS: usize = 32;
    const COLUMNS: usize = 32;
    let mut observed = vec![0.0; ROWS * COLUMNS + 1];
    for k in 0..SAMPLES {
        let cell = sample(k).map_or(ROWS * COLUMNS, |w| {
            let row = ((f64::from(w.z) + 1.0) / 2.0 * ROWS as f64) as usize;
            let turn = (f64::from(w.y).atan2(f64::from(w.x)) / (2.0 * PI)).rem_euclid(1.0);
            row.min(ROWS - 1) * COLUMNS + ((turn * COLUMNS as f64) as usize).min(COLUMNS - 1)
        });
        observed[cell] += 1.0;
    }
    let g = |z: f64, phi: f64| pdf(direction(z, phi));
    let mut expected: Vec<f64> = (0..ROWS * COLUMNS)
        .map(|cell| {
            let (row, column) = ((cell / COLUMNS) as f64, (cell % COLUMNS) as f64);
            let z = [row, row + 1.0].map(|r| 2.0 * r / ROWS as f64 - 1.0);
            let phi = [column, column + 1.0].map(|c| 2.0 * PI * c / COLUMNS as f64);
            SAMPLES as f64 * integrate(&g, z, phi, 1e-7)
        })
        .collect();
    let rest = SAMPLES as f64 - expected.iter().sum::<f64>();
    // A density that integrates to more than one is wrong, whatever the histogram says; round-off aside.
    if rest < -1e-4 * SAMPLES as f64 {
        return 0.0;
    }
    expected.push(rest.max(0.0));
    p_value(&observed, &expected)
}

/// The tail probability of Pearson's statistic.
fn p_value(observed: &[f64], expected: &[f64]) -> f64 {
    const FEWEST: f64 = 5.0;
    let mut order: Vec<usize> = (0..expected.len()).collect();
    order.sort_by(|a, b| expected[*a].total_cmp(&expected[*b]));
    let (mut statistic, mut cells) = (0.0, 0);
    let (mut pooled_observed, mut pooled_expected) = (0.0, 0.0);
    for i in order {
        pooled_observed += observed[i];
        pooled_expected += expected[i];
        if pooled_expected >= FEWEST {
            statistic += (pooled_observed - pooled_expected) * (pooled_observed - pooled_expected) / pooled_expected;
            cells += 1;
            (pooled_observed, pooled_expected) = (0.0, 0.0);
        }
    }
    assert!(cells > 1, "too few cells for a test");
    upper_gamma(f64::from(cells - 1) / 2.0, statistic / 2.0)
}

/// The regularised upper incomplete gamma function Q(a, x) (Press et al. 2007, "Numerical Recipes", section 6.2).
pub fn upper_gamma(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        // Series of the lower function.
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-16 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - front * sum;
    }
    // Lentz's continued fraction.
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (1e300, 1.0 / b);
    let mut h = d;
    for i in 1..100_000 {
        let i = f64::from(i);
        let an = -i * (i - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    front * h
}

/// The logarithm of the gamma function, by Stirling's series after shifting its argument upwards.
fn ln_gamma(x: f64) -> f64 {
    let (mut x, mut shift) = (x, 0.0);
    while x < 40.0 {
        shift += x.ln();
        x += 1.0;
    }
    let r = 1.0 / (x * x);
    (x - 0.5) * x.ln() - x + 0.5 * (2.0 * PI).ln() + (1.0 / 12.0 - r * (1.0 / 360.0 - r / 1260.0)) / x - shift
}

/// The level below which a p-value fails, when `tests` of them are made with a chance of 1 % of any false alarm (Sidak 1967).
pub fn sidak(tests: usize) -> f64 {
    1.0 - 0.99f64.powf(1.0 / tests as f64)
}
