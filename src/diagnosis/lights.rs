//! Causes in what lights emit.

use super::Explanation;
use crate::lang::{BuiltScene, Statement, TextPlace};
use bhs_core::diagnostics::Diagnostic;
use bhs_core::geometry::Geometry;
use bhs_core::light::{AreaLight, EmissionPoint, Light};
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, VisibleWavelengths};
use bhs_elementary::unit_vector;
use bhs_engine::light_sampling::Emitter;
use glam::{DVec3, Vec2};
use std::f64::consts::TAU;

/// Code of lights that emit nothing.
pub const ZERO: &str = "dark-lights";
/// Code of lights of which the film records nothing.
pub const WAVELENGTHS: &str = "no-shared-wavelengths";

/// The wavelengths at which a light may shine that shows nothing in the film (nm), and the borders between which they are looked for.
const BORDERS: [f32; 22] = [
    10.0, 50.0, 100.0, 150.0, 200.0, 250.0, 300.0, 350.0, 400.0, 450.0, 500.0, 550.0, 600.0, 650.0, 700.0, 800.0, 1e3, 1.5e3,
    3e3, 1e4, 3e4, 1e5,
];

/// What a light does for a film.
#[derive(Clone, Copy, PartialEq)]
enum Shines {
    Elsewhere,
    Nowhere,
}

/// A light of the scene, as far as it matters here.
struct Judged<'b> {
    shines: Shines,
    statement: Option<&'b Statement>,
}

/// Says so if no light of the scene shows anything in the film.
pub fn dark(built: &BuiltScene) -> Option<Diagnostic> {
    if is_blind(built) {
        let [lo, hi] = built.film.lambda_range();
        let film = &built.statements.film;
        let at = film.param("lambdamin").or(film.param("lambdamax")).unwrap_or(film.at);
        let message = format!("the film records {lo} to {hi} nm, where no eye sees: the picture will be black");
        return Some(
            Diagnostic::warning(WAVELENGTHS, message)
                .at(at.span, "")
                .help("wavelengths are in nm: visible light has 380 to 780; Film \"spectral\" records others too"),
        );
    }
    let all = judge(built, built.film.lambda_range())?;
    let elsewhere = all.iter().find(|l| l.shines == Shines::Elsewhere);
    if elsewhere.is_some() && may_shift(built) {
        return None;
    }
    if let Some(first) = elsewhere {
        let found = Diagnostic::warning(WAVELENGTHS, wavelengths_message(built));
        let found = match first.statement {
            Some(statement) => found.at(strength(statement).0.span, "there is nothing of it at these wavelengths"),
            None => found,
        };
        let film = &built.statements.film;
        let recorded = film.param("lambdamin").or(film.param("lambdamax"));
        let found = recorded.map_or(found.clone(), |at| found.and(at.span, "what the film records"));
        return Some(found.help(WAVELENGTHS_HELP));
    }
    let first = all.first()?;
    let (at, name) = first.statement.map(strength).map_or((None, None), |(at, name)| (Some(at), name));
    let what = if all.len() == 1 { "the light of the scene" } else { "every light of the scene" };
    let why = name.map_or_else(|| "it emits nothing".to_owned(), |name| format!("its `{name}` is zero"));
    let message = format!("{what} is dark: {why}, and the picture will be black");
    let found = Diagnostic::warning(ZERO, message);
    let found = at.map_or(found.clone(), |at| found.at(at.span, ""));
    let found = all[1..].iter().filter_map(|l| l.statement).take(3).fold(found, |found, statement| {
        let (at, _) = strength(statement);
        found.and(at.span, "and so is this one")
    });
    Some(found.help(format!("give it a value above 0, such as {}", example(name.unwrap_or("L")))))
}

/// Whether light may arrive at other wavelengths than those at which it was sent: for the mass that it passes, or because something moves.
pub fn may_shift(built: &BuiltScene) -> bool {
    let (world, shapes) = (&built.scene.world, &built.scene.shapes);
    let moves = built.viewpoint.motion.is_some() || shapes.iter().any(|shape| shape.motion.is_some());
    moves || world.bends() && world.conventions.redshift
}

/// Whether the light of a shape is one that emits at all.
pub fn emits(built: &BuiltScene, index: u32) -> bool {
    let scene = &built.scene;
    let is_lit = |emitter: &Emitter| {
        let geometry = &scene.world.geometries[emitter.geometry as usize];
        let points = points(emitter, geometry);
        let at = |[lo, hi]: [f32; 2]| surface_shines(&*emitter.light, &points, lo, hi);
        emitter.light.depends_on_time() || shines(built.film.lambda_range(), at) != Some(Shines::Nowhere)
    };
    scene.light_sampler.emitters.iter().any(|e| scene.shapes[e.geometry as usize].index == index && is_lit(e))
}

/// Whether no channel of the film takes light of any of its wavelengths.
fn is_blind(built: &BuiltScene) -> bool {
    let [lo, hi] = built.film.lambda_range();
    let wavelengths = VisibleWavelengths::new(lo, hi);
    let mut sums = vec![0.0; built.film.channels().len()];
    (0..64).for_each(|i| built.film.add(SampledSpectrum::ONE, &wavelengths.sample((i as f32 + 0.5) / 64.0), &mut sums));
    sums.iter().all(|sum| *sum == 0.0)
}

const WAVELENGTHS_HELP: &str =
    "change `lambdamin` and `lambdamax` of the film, or the spectrum of the light; wavelengths are in nm";

fn wavelengths_message(built: &BuiltScene) -> String {
    let [lo, hi] = built.film.lambda_range();
    format!("the film and the lights share no wavelengths: it records {lo} to {hi} nm, where nothing shines")
}

/// The same of a picture that is black, where light has been shifted by as much as it is.
pub fn dark_everywhere(built: &BuiltScene) -> Option<Explanation> {
    let all = judge(built, built.film.lambda_range())?;
    let elsewhere = all.iter().find(|l| l.shines == Shines::Elsewhere)?;
    let place = elsewhere.statement.and_then(|s| built.statements.place(strength(s).0));
    let place = place.map(|place| format!(" (the light at {place})")).unwrap_or_default();
    Some(Explanation::warning(WAVELENGTHS, format!("{}{place}; {WAVELENGTHS_HELP}", wavelengths_message(built))))
}

/// An example of a value above zero.
fn example(parameter: &str) -> String {
    match parameter {
        "scale" => "\"float scale\" 1".to_owned(),
        other => format!("\"spectrum {other}\" 1"),
    }
}

/// What says how strong a light is, and its name if it is a parameter.
fn strength(statement: &Statement) -> (TextPlace, Option<&'static str>) {
    if let (Some(0.0), Some(at)) = (statement.number("scale"), statement.param("scale")) {
        return (at, Some("scale"));
    }
    let given = ["L", "I", "filename"].into_iter().find_map(|name| Some((statement.param(name)?, name)));
    match given {
        Some((at, "filename")) => (at, None),
        Some((at, name)) => (at, Some(name)),
        None => (statement.at, None),
    }
}

/// All lights of a scene, if none of them shines at wavelengths of `range` (nm).
fn judge(built: &BuiltScene, range: [f32; 2]) -> Option<Vec<Judged<'_>>> {
    let scene = &built.scene;
    let mut all = Vec::new();
    for emitter in &scene.light_sampler.emitters {
        let geometry = &scene.world.geometries[emitter.geometry as usize];
        // What has no area shows nothing for another reason.
        if emitter.light.depends_on_time() || emitter.area(geometry) <= 0.0 {
            return None;
        }
        let points = points(emitter, geometry);
        let shines = shines(range, |[lo, hi]| surface_shines(&*emitter.light, &points, lo, hi))?;
        all.push(Judged { shines, statement: built.statements.area_light(scene.shapes[emitter.geometry as usize].index) });
    }
    for (number, light) in scene.light_sampler.lights.iter().enumerate() {
        let shines = shines(range, |range| light_shines(&**light, range))?;
        all.push(Judged { shines, statement: built.statements.lights.get(number) });
    }
    Some(all).filter(|all| !all.is_empty())
}

/// Where a light shines; `None` if that is within `range`.
fn shines(range: [f32; 2], at: impl Fn([f32; 2]) -> bool) -> Option<Shines> {
    if at(range) {
        return None;
    }
    let outside = |pair: &[f32]| [[pair[0], pair[1].min(range[0])], [pair[0].max(range[1]), pair[1]]];
    let any = BORDERS.windows(2).flat_map(outside).any(|[lo, hi]| lo < hi && at([lo, hi]));
    Some(if any { Shines::Elsewhere } else { Shines::Nowhere })
}

/// Points of a surface that emits, all over it.
fn points(emitter: &Emitter, geometry: &Geometry) -> Vec<EmissionPoint> {
    let nowhere = EmissionPoint { uv: Vec2::ZERO, point: DVec3::ZERO };
    if emitter.light.is_uniform() {
        return vec![nowhere];
    }
    let cell = |i: u32| (i as f32 + 0.5) / 16.0;
    let numbers = (0..256).map(|i| (Vec2::new(cell(i % 16), cell(i / 16)), (i as f32 * 0.618_034).fract()));
    numbers.filter_map(|(u, choice)| emitter.point(geometry, u, choice)).collect()
}

fn surface_shines(light: &dyn AreaLight, points: &[EmissionPoint], lo: f32, hi: f32) -> bool {
    points.iter().any(|point| light.exitance(point, lo, hi) > 0.0)
}

/// Whether a light that is no surface shines at all between two wavelengths.
fn light_shines(light: &dyn Light, [lo, hi]: [f32; 2]) -> bool {
    if light.power(lo, hi, 1.0) > 0.0 {
        return true;
    }
    let lit = |at: &dyn Fn([f32; N_LAMBDA]) -> bool, count: usize| {
        (0..count).any(|k| {
            let wavelength = |i: usize| lo + (hi - lo) * ((k * N_LAMBDA + i) as f32 + 0.5) / (count * N_LAMBDA) as f32;
            at(std::array::from_fn(wavelength))
        })
    };
    // Lines may be narrow: a nanometre apart in one direction, coarser in the others.
    let sky = |direction| move |lambda| !light.sky_radiance(direction, lambda).is_zero();
    let fine = ((hi - lo) / N_LAMBDA as f32).ceil().clamp(8.0, 512.0) as usize;
    lit(&sky(DVec3::Y), fine)
        || directions(64).any(|d| lit(&sky(d), 8))
        || lit(&|lambda| !light.irradiance(lambda).is_zero(), fine)
        || directions(64).any(|d| lit(&|lambda| !light.intensity(d, lambda).is_zero(), 8))
        || (0..light.points().len().min(64)).any(|i| lit(&|lambda| !light.point_irradiance(i, lambda).is_zero(), 8))
}

/// Unit directions, evenly spread (a spiral of Fibonacci).
pub(super) fn directions(count: u32) -> impl Iterator<Item = DVec3> {
    (0..count).map(move |i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(count);
        let xy = unit_vector(TAU * 0.618_033_988_75 * f64::from(i)) * (1.0 - z * z).sqrt();
        xy.extend(z)
    })
}
