//! Emitters that lie in the very plane of another surface: which of the two light meets is a matter of rounding, and transports disagree.
//!
//! Only surfaces that emit are held against the others, by boxes first; very large emitters and meshes are looked at in part.

use bhs_core::diagnostics::{Diagnostic, Span};
use bhs_core::geometry::{Aabb, Analytic, AreaSample, Geometry, Segment, triangle_area};
use bhs_engine::scene::ShapeBinding;
use glam::{DVec2, DVec3, Vec2};
use std::cell::OnceCell;
use std::collections::BTreeSet;

/// Triangles of one emitter that are looked at, the largest ones.
const TRIANGLES_OF_AN_EMITTER: usize = 64;
/// Pieces of emitters that are looked at, in the order of the scene.
const PIECES: usize = 1 << 16;
/// Triangles of other surfaces whose boxes are compared, small meshes first.
const TRIANGLES: usize = 1 << 22;
/// Pairs that are compared in full.
const PAIRS: usize = 1 << 18;
/// Warnings that are given.
const WARNINGS: usize = 10;
/// Rows and columns of points that stand for a surface given by a formula.
const POINTS: u32 = 12;
/// Two surfaces overlap if they share this part of the smaller one: those that share an edge do not.
const SHARED: f64 = 1e-4;
/// How far apart single precision cannot tell two surfaces, relative to their coordinates: a few roundings.
const ROUNDING: f64 = 4.0 * f32::EPSILON as f64;

/// Warns of each emitter that overlaps another surface in its plane; `spans` are the places of the shapes' names, by geometry.
pub(super) fn warn(geometries: &[Geometry], bindings: &[ShapeBinding], spans: &[Span], found: &mut Vec<Diagnostic>) {
    let emitters = bindings.iter().enumerate().filter(|(_, b)| b.emitter.is_some()).map(|(i, _)| i);
    let pieces: Vec<Piece> = emitters.flat_map(|i| pieces(i, &geometries[i])).take(PIECES).collect();
    if pieces.is_empty() {
        return;
    }
    let tree = Tree::new(pieces);
    let mut search = Search { bindings, pairs: BTreeSet::new(), compared: 0 };
    let mut order: Vec<usize> = (0..geometries.len()).collect();
    order.sort_by_key(|i| geometries[*i].triangle_count());
    let mut triangles = 0;
    for i in order {
        if !tree.may_meet(&geometries[i].bounds()) {
            continue;
        }
        if let Geometry::Analytic(surface) = &geometries[i] {
            search.compare(&tree, &Piece::of_surface(i, surface.as_ref()));
            continue;
        }
        triangles += geometries[i].triangle_count();
        if triangles > TRIANGLES {
            break;
        }
        for corners in (0..geometries[i].triangle_count() as u32).filter_map(|t| geometries[i].corners(t)) {
            search.compare(&tree, &Piece::of_triangle(i, corners));
        }
    }
    for (emitter, other) in search.pairs.into_iter().take(WARNINGS) {
        found.push(
            Diagnostic::warning("coplanar-light", "this light lies in the plane of another surface, and the two overlap")
                .at(spans[emitter], "which of the two is met is a matter of rounding")
                .and(spans[other], "the other surface")
                .help("move the light a little off the surface, or leave a hole in the surface where the light is"),
        );
    }
}

/// A triangle, or a surface given by a formula.
struct Piece<'a> {
    geometry: usize,
    /// Grown by what rounding may do.
    bounds: Aabb,
    tolerance: f64,
    form: Form<'a>,
}

enum Form<'a> {
    Triangle([DVec3; 3]),
    Surface {
        surface: &'a dyn Analytic,
        /// Points all over it, found when they are first asked for.
        points: OnceCell<Vec<AreaSample>>,
    },
}

/// The pieces of an emitter.
fn pieces(index: usize, geometry: &Geometry) -> Vec<Piece<'_>> {
    if let Geometry::Analytic(surface) = geometry {
        return vec![Piece::of_surface(index, surface.as_ref())];
    }
    let mut triangles: Vec<[DVec3; 3]> = (0..geometry.triangle_count() as u32).filter_map(|t| geometry.corners(t)).collect();
    if triangles.len() > TRIANGLES_OF_AN_EMITTER {
        triangles.sort_by(|a, b| triangle_area(*b).total_cmp(&triangle_area(*a)));
        triangles.truncate(TRIANGLES_OF_AN_EMITTER);
    }
    triangles.into_iter().map(|corners| Piece::of_triangle(index, corners)).collect()
}

impl<'a> Piece<'a> {
    fn new(geometry: usize, bounds: Aabb, form: Form<'a>) -> Self {
        let tolerance = ROUNDING * bounds.min.abs().max(bounds.max.abs()).max_element();
        Self { geometry, bounds: bounds.grown(tolerance), tolerance, form }
    }

    fn of_triangle(geometry: usize, corners: [DVec3; 3]) -> Self {
        Self::new(geometry, corners.into_iter().fold(Aabb::EMPTY, Aabb::with_point), Form::Triangle(corners))
    }

    fn of_surface(geometry: usize, surface: &'a dyn Analytic) -> Self {
        Self::new(geometry, surface.bounds(), Form::Surface { surface, points: OnceCell::new() })
    }

    /// Whether the two share a part of one surface.
    fn overlaps(&self, other: &Self) -> bool {
        let tolerance = self.tolerance.max(other.tolerance);
        match (&self.form, &other.form) {
            (Form::Triangle(a), Form::Triangle(b)) => triangles_overlap(*a, *b, tolerance),
            (Form::Triangle(corners), Form::Surface { surface, points })
            | (Form::Surface { surface, points }, Form::Triangle(corners)) => {
                let normal = normal_of(*corners);
                let bounds = corners.iter().fold(Aabb::EMPTY, |b, p| b.with_point(*p)).grown(tolerance);
                may_pass(*surface, &bounds)
                    && (points_on(*surface, points).iter().any(|p| lies_in(*corners, normal, p, tolerance))
                        || points_of(*corners).any(|p| lies_on(*surface, p, normal, tolerance)))
            }
            (Form::Surface { surface: a, points: p }, Form::Surface { surface: b, points: q }) => {
                let on = |surface, at: &AreaSample| lies_on(surface, at.point, at.normal, tolerance);
                may_pass(*a, &other.bounds)
                    && may_pass(*b, &self.bounds)
                    && (points_on(*a, p).iter().any(|p| on(*b, p)) || points_on(*b, q).iter().any(|q| on(*a, q)))
            }
        }
    }
}

/// Cosine of the angle above which normals count as parallel: far from exact, as places are compared too.
const PARALLEL: f64 = 0.9999;

fn may_pass(surface: &dyn Analytic, bounds: &Aabb) -> bool {
    surface.may_pass(bounds.center(), 0.5 * (bounds.max - bounds.min))
}

/// Points all over a surface given by a formula, but not on its edges.
fn points_on<'p>(surface: &dyn Analytic, points: &'p OnceCell<Vec<AreaSample>>) -> &'p [AreaSample] {
    let at = |i: u32| (i as f32 + 0.5) / POINTS as f32;
    points.get_or_init(|| (0..POINTS * POINTS).map(|i| surface.sample(Vec2::new(at(i % POINTS), at(i / POINTS)))).collect())
}

fn normal_of([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// Points all over the inside of a triangle.
fn points_of([a, b, c]: [DVec3; 3]) -> impl Iterator<Item = DVec3> {
    const N: u32 = 6;
    let weights = (0..N).flat_map(|i| (0..N - i).map(move |j| [i, j].map(|k| (f64::from(k) + 1.0 / 3.0) / f64::from(N))));
    weights.map(move |[u, v]| a + (b - a) * u + (c - a) * v)
}

/// Whether a point of a surface lies in a triangle, whose plane touches the surface there.
fn lies_in([a, b, c]: [DVec3; 3], normal: DVec3, at: &AreaSample, tolerance: f64) -> bool {
    let p = at.point - a;
    if p.dot(normal).abs() > tolerance || at.normal.dot(normal).abs() < PARALLEL {
        return false;
    }
    let (ab, ac) = (b - a, c - a);
    let n = ab.cross(ac);
    let (u, v) = (n.dot(p.cross(ac)), n.dot(ab.cross(p)));
    u >= 0.0 && v >= 0.0 && u + v <= n.length_squared()
}

/// Whether a point of a surface with the unit normal `normal` lies on another surface, which has the same tangents there.
fn lies_on(surface: &dyn Analytic, point: DVec3, normal: DVec3, tolerance: f64) -> bool {
    let across = normal * tolerance;
    let segment = Segment { origin: point - across, direction: 2.0 * across, t_min: 0.0, t_max: 1.0 };
    surface.intersect(&segment).is_some_and(|t| surface.surface(segment.at(t)).normal.dot(normal).abs() >= PARALLEL)
}

/// Whether two triangles lie in one plane and share more than an edge.
fn triangles_overlap(a: [DVec3; 3], b: [DVec3; 3], tolerance: f64) -> bool {
    let (small, large) = if triangle_area(a) < triangle_area(b) { (a, b) } else { (b, a) };
    let normal = normal_of(large);
    if small.iter().any(|p| (*p - large[0]).dot(normal).abs() > tolerance) {
        return false;
    }
    // In the plane, along two axes at right angles.
    let (x, y) = normal.any_orthonormal_pair();
    let flat = |p: DVec3| DVec2::new((p - large[0]).dot(x), (p - large[0]).dot(y));
    let (small, large) = (small.map(flat), large.map(flat));
    let turn = area(&large).signum();
    // Of the smaller one, what lies within all edges of the larger one (Sutherland and Hodgman 1974).
    let mut rest = small.to_vec();
    for i in 0..3 {
        let (from, along) = (large[i], large[(i + 1) % 3] - large[i]);
        let inside = |p: DVec2| along.perp_dot(p - from) * turn;
        let mut next = Vec::with_capacity(rest.len() + 1);
        for (k, p) in rest.iter().enumerate() {
            let q = rest[(k + 1) % rest.len()];
            let (here, there) = (inside(*p), inside(q));
            if here >= 0.0 {
                next.push(*p);
            }
            if (here > 0.0 && there < 0.0) || (here < 0.0 && there > 0.0) {
                next.push(p.lerp(q, here / (here - there)));
            }
        }
        rest = next;
    }
    area(&rest).abs() > SHARED * area(&small).abs()
}

/// The area of a polygon, positive if it turns from x to y.
fn area(polygon: &[DVec2]) -> f64 {
    let edges = polygon.iter().zip(polygon.iter().cycle().skip(1));
    0.5 * edges.map(|(p, q)| p.perp_dot(*q)).sum::<f64>()
}

/// What has been found so far.
struct Search<'a> {
    bindings: &'a [ShapeBinding],
    /// Geometries of emitters and of what they overlap.
    pairs: BTreeSet<(usize, usize)>,
    compared: usize,
}

impl Search<'_> {
    /// Holds a piece of a surface against all emitters that are near it.
    fn compare(&mut self, tree: &Tree, piece: &Piece) {
        tree.near(&piece.bounds, &mut |emitter| {
            let (mut pair, index) = ((emitter.geometry, piece.geometry), |g: usize| self.bindings[g].index);
            // Of two emitters, each is the other's: the later one is named first.
            if self.bindings[pair.1].emitter.is_some() && pair.0 < pair.1 {
                pair = (pair.1, pair.0);
            }
            let known = self.pairs.contains(&pair) || self.pairs.len() > WARNINGS;
            if index(pair.0) == index(pair.1) || known || self.compared >= PAIRS {
                return;
            }
            self.compared += 1;
            if emitter.overlaps(piece) {
                self.pairs.insert(pair);
            }
        });
    }
}

/// Pieces of emitters by their boxes: each inner node has the boxes of two halves.
struct Tree<'a> {
    pieces: Vec<Piece<'a>>,
    /// Boxes of ranges of pieces: of all, then of the halves, and so on; `nodes[i]` has the children `2 i + 1` and `2 i + 2`.
    nodes: Vec<Aabb>,
}

/// Pieces that a leaf has at most.
const LEAF: usize = 4;

impl<'a> Tree<'a> {
    fn new(mut pieces: Vec<Piece<'a>>) -> Self {
        let mut nodes = Vec::new();
        Self::divide(&mut pieces, 0, &mut nodes);
        Self { pieces, nodes }
    }

    fn divide(pieces: &mut [Piece], node: usize, nodes: &mut Vec<Aabb>) {
        let bounds = pieces.iter().fold(Aabb::EMPTY, |b, p| b.union(p.bounds));
        if nodes.len() <= node {
            nodes.resize(node + 1, Aabb::EMPTY);
        }
        nodes[node] = bounds;
        if pieces.len() <= LEAF {
            return;
        }
        let size = bounds.max - bounds.min;
        let axis = (0..3).max_by(|a, b| size[*a].total_cmp(&size[*b])).unwrap_or(0);
        let half = pieces.len() / 2;
        pieces.select_nth_unstable_by(half, |a, b| a.bounds.center()[axis].total_cmp(&b.bounds.center()[axis]));
        let (left, right) = pieces.split_at_mut(half);
        Self::divide(left, 2 * node + 1, nodes);
        Self::divide(right, 2 * node + 2, nodes);
    }

    /// Whether any emitter may lie within a box.
    fn may_meet(&self, bounds: &Aabb) -> bool {
        self.nodes.first().is_some_and(|all| meet(all, bounds))
    }

    /// Calls `f` with all pieces whose boxes meet a box.
    fn near(&self, bounds: &Aabb, f: &mut impl FnMut(&Piece)) {
        let mut rest = vec![(0, 0..self.pieces.len())];
        while let Some((node, range)) = rest.pop() {
            if !meet(&self.nodes[node], bounds) {
                continue;
            }
            if range.len() <= LEAF {
                self.pieces[range].iter().filter(|p| meet(&p.bounds, bounds)).for_each(&mut *f);
                continue;
            }
            let half = range.start + range.len() / 2;
            rest.push((2 * node + 1, range.start..half));
            rest.push((2 * node + 2, half..range.end));
        }
    }
}

fn meet(a: &Aabb, b: &Aabb) -> bool {
    (a.min.cmple(b.max) & b.min.cmple(a.max)).all()
}
