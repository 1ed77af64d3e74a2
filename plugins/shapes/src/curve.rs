//! `curve`: a thin thread or ribbon along a spline: hair, fur, grass, cloth.
//!
//! The control points `P` are those of Bezier curves of the degree 2 or 3, each of which begins with the last point of the one before, or of a
//! uniform B-spline. The width goes linearly from `width0` to `width1`.
//!
//! Every curve becomes triangles. A `cylinder` is a tube of six sides with round shading whose mean width, seen from all around, is the one asked
//! for. So is `flat`, which in pbrt-v4 is a strip that turns towards each ray: where light comes to a curve from many sides, as it does here, there
//! is no such strip. A `ribbon` is a strip across the normals `N`. Curves are cut where they have turned by some 12 degrees, whatever `splitdepth`
//! says. Texture: u goes from 0 to 1 along each Bezier curve, v across a ribbon, or around a tube.
//!
//! Names and defaults of pbrt-v4.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `P` | point3 | required | | control points |
//! | `type` | string | "flat" | | `flat` or `cylinder`: a tube; `ribbon`: a strip |
//! | `basis` | string | "bezier" | | or `bspline` |
//! | `degree` | integer | 3 | | 2 or 3 |
//! | `width` | float | 1 | scene | width of a curve |
//! | `width0`, `width1` | float | `width` | scene | width at the start and at the end |
//! | `N` | normal | none | | of a ribbon: normals at the ends of its Bezier curves |
//! | `splitdepth` | integer | 3 | | no effect: curves are cut as finely as they bend |
//!
//! ```bhs
//! WorldBegin
//! LightSource "infinite"
//! Translate 0 0 4
//! Shape "curve" "point3 P" [-1 -1 0  -1 1 0  1 -1 0  1 1 0] "string type" "cylinder" "float width0" 0.2 "float width1" 0.05
//! ```

use crate::mesh::{to_world, unit};
use bhs_core::diagnostics::Diagnostic;
use bhs_core::geometry::{Shape, WorldMesh};
use bhs_core::params::{Normal3, Params, Point3};
use bhs_core::plugin::Plugin;
use bhs_elementary::{Elementary, unit_vector};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// The entry in the list of shapes.
pub const PLUGIN: Plugin<dyn Shape> = Plugin { name: "curve", summary: "a thin thread or ribbon along a spline", build };

/// Sides of a tube.
const SIDES: usize = 6;

/// The angle by which a curve may turn within a piece (radians).
const TURN: f64 = 0.2;

/// The most pieces that one Bezier curve is cut into.
const MOST_PIECES: usize = 64;

/// What a curve is made into.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    Tube,
    Ribbon,
}

fn build(p: &Params) -> Option<Box<dyn Shape>> {
    let points = p.require::<Vec<Point3>>("P", "", "control points");
    let kind = match word(p, "type", &["flat", "cylinder", "ribbon"], "`flat` or `cylinder`: a tube; `ribbon`: a strip") {
        "ribbon" => Kind::Ribbon,
        _ => Kind::Tube,
    };
    let is_spline = word(p, "basis", &["bezier", "bspline"], "what `P` are control points of") == "bspline";
    let degree = p.get_in("degree", 3, 2..=3, "", "2 or 3") as usize;
    let width = p.get_in("width", 1.0, 0.0..=f64::MAX, "scene", "width of a curve");
    let ends = [("width0", "width at the start, instead of `width`"), ("width1", "width at the end, likewise")];
    let widths = ends.map(|(name, about)| width_at(p, name, width, about));
    let normals = p.optional::<Vec<Normal3>>("N", "", "of a ribbon: normals at the ends of its Bezier curves");
    p.get_in("splitdepth", 3, 0..=64, "", "no effect: curves are cut as finely as they bend");

    let points: Vec<DVec3> = points?.into_iter().map(|p| p.0).collect();
    let curves = if is_spline { of_spline(&points, degree) } else { of_bezier(&points, degree) };
    let Some(curves) = curves else {
        let cause = match is_spline {
            true => format!("a B-spline of degree {degree} has at least {}", degree + 1),
            false => format!("Bezier curves of degree {degree} have {} and {degree} more each", degree + 1),
        };
        p.reject("P", format!("{} points make no curves", points.len()), cause);
        return None;
    };
    let normals = ribbon_normals(p, normals, kind, curves.len())?;
    let mut mesh = WorldMesh::default();
    let count = curves.len() as f64;
    for (i, control) in curves.iter().enumerate() {
        let [from, to] = [i, i + 1].map(|i| widths[0] + (widths[1] - widths[0]) * (i as f64 / count));
        let ends = normals.get(i..i + 2).map(|n| [n[0], n[1]]);
        Curve { control: *control, widths: [from, to] }.add(&mut mesh, ends);
    }
    Some(Box::new(to_world(p, mesh)?))
}

/// One of several words, the first by default.
fn word(p: &Params, name: &'static str, words: &'static [&'static str], about: &'static str) -> &'static str {
    let given = p.get(name, words[0].to_owned(), "", about);
    words.iter().copied().find(|word| *word == given).unwrap_or_else(|| {
        let help = format!("there is {}", words.join(", "));
        p.report(Diagnostic::error("bad-value", format!("unknown `{name}`: `{given}`")).at(p.span_of(name), "").help(help));
        words[0]
    })
}

/// The width at one end.
fn width_at(p: &Params, name: &'static str, width: f64, about: &'static str) -> f64 {
    let given = p.optional::<f64>(name, "scene", about).unwrap_or(width);
    if given >= 0.0 && given.is_finite() {
        return given;
    }
    p.reject(name, format!("`{name}` is {given}"), "a width is not below 0");
    width
}

/// The unit normals of a ribbon, one more than it has Bezier curves, or none of a tube; `None` after a report.
fn ribbon_normals(p: &Params, normals: Option<Vec<Normal3>>, kind: Kind, curves: usize) -> Option<Vec<DVec3>> {
    match (kind, normals) {
        (Kind::Tube, None) => Some(Vec::new()),
        (Kind::Tube, Some(_)) => {
            let warning = Diagnostic::warning("unused-normals", "`N` means something for a ribbon alone");
            p.report(warning.at(p.span_of("N"), "this curve is a tube"));
            Some(Vec::new())
        }
        (Kind::Ribbon, Some(normals)) if normals.len() == curves + 1 => {
            Some(normals.into_iter().map(|n| DVec3::from_array(unit(n.0).map(f64::from))).collect())
        }
        (Kind::Ribbon, normals) => {
            let found = normals.map_or(0, |n| n.len());
            let message = format!("a ribbon of {curves} Bezier curves needs {} normals", curves + 1);
            let place = if p.is_given("N") { p.span_of("N") } else { p.span_of("type") };
            p.report(Diagnostic::error("wrong-count", message).at(place, format!("`N` has {found}")));
            None
        }
    }
}

/// The same curve with one more control point.
fn elevated([a, b, c]: [DVec3; 3]) -> [DVec3; 4] {
    [a, (a + b * 2.0) / 3.0, (b * 2.0 + c) / 3.0, c]
}

/// The control points of the cubic curves that points are those of.
fn of_bezier(points: &[DVec3], degree: usize) -> Option<Vec<[DVec3; 4]>> {
    if points.len() <= degree || !(points.len() - 1).is_multiple_of(degree) {
        return None;
    }
    let curve = |i: usize| {
        let own = &points[i * degree..];
        if degree == 2 { elevated([own[0], own[1], own[2]]) } else { [own[0], own[1], own[2], own[3]] }
    };
    Some((0..(points.len() - 1) / degree).map(curve).collect())
}

/// The same of a uniform B-spline.
fn of_spline(points: &[DVec3], degree: usize) -> Option<Vec<[DVec3; 4]>> {
    if points.len() <= degree {
        return None;
    }
    let curve = |w: &[DVec3]| match degree {
        2 => elevated([(w[0] + w[1]) / 2.0, w[1], (w[1] + w[2]) / 2.0]),
        _ => [
            (w[0] + w[1] * 4.0 + w[2]) / 6.0,
            (w[1] * 2.0 + w[2]) / 3.0,
            (w[1] + w[2] * 2.0) / 3.0,
            (w[1] + w[2] * 4.0 + w[3]) / 6.0,
        ],
    };
    Some(points.windows(degree + 1).map(curve).collect())
}

/// A cubic Bezier curve.
struct Curve {
    control: [DVec3; 4],
    /// At its start and its end.
    widths: [f64; 2],
}

/// The angle between two directions; 0 where one of them is none.
fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().arctangent2(a.dot(b))
}

impl Curve {
    fn point(&self, u: f64) -> DVec3 {
        let [a, b, c, d] = self.control;
        let v = 1.0 - u;
        a * (v * v * v) + b * (3.0 * u * v * v) + c * (3.0 * u * u * v) + d * (u * u * u)
    }

    /// The unit tangent; `None` of a curve that is a point.
    fn tangent(&self, u: f64) -> Option<DVec3> {
        let [a, b, c, d] = self.control;
        let v = 1.0 - u;
        let here = (b - a) * (v * v) + (c - b) * (2.0 * u * v) + (d - c) * (u * u);
        here.try_normalize().or_else(|| (d - a).try_normalize())
    }

    /// Into how many pieces it is cut; `twist`: the angle by which a ribbon turns about it.
    fn pieces(&self, twist: f64) -> usize {
        let [a, b, c, d] = self.control;
        let legs: Vec<DVec3> = [b - a, c - b, d - c].into_iter().filter(|leg| *leg != DVec3::ZERO).collect();
        let turn: f64 = legs.windows(2).map(|w| angle(w[0], w[1])).sum();
        (((turn + twist) / TURN).ceil() as usize).clamp(1, MOST_PIECES)
    }

    /// Adds its triangles; `normals`: those at the ends of a ribbon.
    fn add(&self, mesh: &mut WorldMesh, normals: Option<[DVec3; 2]>) {
        let Some(mut along) = self.tangent(0.0) else { return };
        let mut side = along.any_orthonormal_vector();
        let pieces = self.pieces(normals.map_or(0.0, |[a, b]| angle(a, b)));
        let columns: u32 = if normals.is_some() { 2 } else { SIDES as u32 + 1 };
        let first = mesh.positions.len() as u32;
        for i in 0..=pieces {
            let u = i as f64 / pieces as f64;
            let here = self.tangent(u).unwrap_or(along);
            side = carried(side, along, here);
            along = here;
            let width = self.widths[0] + (self.widths[1] - self.widths[0]) * u;
            match normals {
                Some([a, b]) => {
                    let normal = between(a, b, u);
                    let across = normal.cross(along).try_normalize().unwrap_or(side);
                    let (off, out) = (across * (0.5 * width), along.cross(across));
                    self.row(mesh, u, &[(-off, out, 0.0), (off, out, 1.0)]);
                }
                None => {
                    let other = side.cross(along);
                    // A polygon's mean width is its circumference over pi.
                    let radius = width * PI / (2.0 * SIDES as f64 * (PI / SIDES as f64).sine());
                    let corner = |k: usize| {
                        let v = k as f64 / SIDES as f64;
                        let out = unit_vector(TAU * (k % SIDES) as f64 / SIDES as f64);
                        let out = side * out.x + other * out.y;
                        (out * radius, out, v)
                    };
                    self.row(mesh, u, &std::array::from_fn::<_, { SIDES + 1 }, _>(corner));
                }
            }
        }
        for i in 0..pieces as u32 {
            for k in 0..columns - 1 {
                let a = first + i * columns + k;
                let (b, c, d) = (a + columns, a + columns + 1, a + 1);
                // Counter-clockwise about the tangent times the way across.
                mesh.triangles.extend([[a, b, c], [a, c, d]]);
            }
        }
    }

    /// Adds the vertices at `u`: how far off the curve they lie, their normals, and v.
    fn row(&self, mesh: &mut WorldMesh, u: f64, vertices: &[(DVec3, DVec3, f64)]) {
        let point = self.point(u);
        for (off, normal, v) in vertices {
            mesh.positions.push(point + *off);
            mesh.normals.push(unit(*normal));
            mesh.uvs.push([u as f32, *v as f32]);
        }
    }
}

/// A unit vector across `from`, turned with it to be one across `to` without a twist.
fn carried(side: DVec3, from: DVec3, to: DVec3) -> DVec3 {
    let turned = glam::DQuat::from_rotation_arc(from, to) * side;
    (turned - to * to.dot(turned)).try_normalize().unwrap_or_else(|| to.any_orthonormal_vector())
}

/// The unit normal between two, turning evenly.
fn between(a: DVec3, b: DVec3, u: f64) -> DVec3 {
    let whole = angle(a, b);
    let sin = whole.sine();
    if sin < 1e-9 {
        return a;
    }
    (a * ((1.0 - u) * whole).sine() + b * (u * whole).sine()) / sin
}
