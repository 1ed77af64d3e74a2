//! Where surfaces touch, or come nearer to each other than single precision can tell, and where they meet at an edge that is not smooth.
//!
//! Each pair of primitives that are so near gives a zone: the part of space within reach of both. Rays that begin, end or pass there are
//! put to [`crate::exact`]; everywhere else the nearest other surface is farther away than what single precision can be wrong by.

use crate::cells::Cells;
use crate::tree::Tree;
use crate::zone::Zone;
use bhs_core::geometry::{Aabb, Geometry, Segment, TriangleMesh};
use bhs_core::intersector::Primitive;
use glam::DVec3;
use std::collections::HashMap;

/// How near surfaces have to come, relative to the numbers with which single precision finds them: 16 times as far as a ray is moved off
/// its surface elsewhere, and more than a shadow ray is shortened by.
const NEAR: f64 = 256.0 * f32::EPSILON as f64;

/// Cosine of the angle by which triangles with a common vertex may turn from one to the next and count as one smooth surface.
const SMOOTH: f64 = 0.7;

/// Triangles of all meshes that are compared with others of their own mesh: larger meshes are taken not to touch themselves.
const MOST_WITHIN: usize = 50_000;

/// Triangles that are looked at for pairs of meshes, and zones that are kept: beyond, single precision has to do.
const MOST_LOOKS: usize = 20_000_000;
const MOST_ZONES: usize = 400_000;

/// Pairs of boxes that are compared.
const MOST_PAIRS: usize = 20_000_000;

/// How often the zone of an analytic surface is halved.
const HALVINGS: u32 = 7;

/// Meshes of up to so many triangles are known to [`crate::exact`] as a whole.
const SMALL: usize = 4096;

/// All zones of a scene.
pub(crate) struct Contacts {
    /// Of each geometry, a bit for each primitive that has a zone; empty where none has.
    involved: Vec<Vec<u64>>,
    zones: Vec<Zone>,
    cells: Cells,
    /// The zones where triangles meet at an edge of both without sharing it. Single precision may let a ray through between them.
    cracks: Option<(Vec<Zone>, Tree)>,
}

impl Contacts {
    /// Those among `geometries`; `None` where nothing comes near anything else.
    pub(crate) fn find(geometries: &[Geometry]) -> Option<Self> {
        let mut search = Search {
            geometries,
            involved: geometries.iter().map(|_| Vec::new()).collect(),
            zones: Vec::new(),
            cracks: Vec::new(),
            pairs: 0,
        };
        search.within_geometries();
        search.between_geometries();
        let Search { involved, zones, cracks, .. } = search;
        if zones.is_empty() {
            return None;
        }
        let boxes = |zones: &[Zone]| zones.iter().map(|z| z.bounds).collect::<Vec<_>>();
        let cells = Cells::new(&boxes(&zones), |zone, middle, half| zones[zone].may_hold(middle, half));
        let cracks = (!cracks.is_empty()).then(|| {
            let tree = Tree::new(&boxes(&cracks));
            (cracks, tree)
        });
        Some(Self { involved, cells, zones, cracks })
    }

    /// Whether single precision may have let a segment through between two surfaces.
    #[inline]
    pub(crate) fn may_slip_through(&self, segment: &Segment) -> bool {
        let Some((zones, tree)) = &self.cracks else { return false };
        let mut slips = false;
        tree.along(segment, |zone, _| {
            slips = zones[zone as usize].is_passed(segment);
            slips
        });
        slips
    }

    /// Whether a primitive has a zone.
    #[inline]
    pub(crate) fn involves(&self, p: Primitive) -> bool {
        let bits = self.involved.get(p.geometry as usize).and_then(|bits| bits.get(p.primitive as usize / 64));
        bits.is_some_and(|bits| bits >> (p.primitive % 64) & 1 == 1)
    }

    /// Whether a point lies in a zone.
    #[inline(always)]
    pub(crate) fn is_crowded(&self, point: DVec3) -> bool {
        let near = self.cells.at(point);
        !near.is_empty() && self.is_among(near, point)
    }

    #[inline(never)]
    fn is_among(&self, zones: &[u32], point: DVec3) -> bool {
        zones.iter().any(|zone| self.zones[*zone as usize].holds(point))
    }

    /// The primitives that have zones, and their neighbours.
    pub(crate) fn with_neighbours(&self, geometries: &[Geometry]) -> Vec<Primitive> {
        let mut found = Vec::new();
        for (number, geometry) in (0u32..).zip(geometries).filter(|(i, _)| !self.involved[*i as usize].is_empty()) {
            let all = (0..geometry.triangle_count().max(1) as u32).map(|primitive| Primitive { geometry: number, primitive });
            match mesh_of(geometry).filter(|mesh| mesh.triangles.len() > SMALL) {
                None => found.extend(all),
                Some(mesh) => {
                    let mut touched = vec![false; mesh.positions.len()];
                    for p in all.clone().filter(|p| self.involves(*p)) {
                        mesh.triangles[p.primitive as usize].iter().for_each(|v| touched[*v as usize] = true);
                    }
                    found.extend(all.filter(|p| mesh.triangles[p.primitive as usize].iter().any(|v| touched[*v as usize])));
                }
            }
        }
        found
    }
}

/// The triangles of a geometry, in whatever coordinates.
fn mesh_of(geometry: &Geometry) -> Option<&TriangleMesh> {
    match geometry {
        Geometry::Mesh(mesh) => Some(mesh),
        Geometry::Instance(instance) => Some(instance.mesh()),
        Geometry::Analytic(_) => None,
    }
}

/// A triangle or an analytic surface.
struct Piece {
    primitive: Primitive,
    bounds: Aabb,
    /// How far from it others are near.
    reach: f64,
}

struct Search<'a> {
    geometries: &'a [Geometry],
    involved: Vec<Vec<u64>>,
    zones: Vec<Zone>,
    cracks: Vec<Zone>,
    pairs: usize,
}

impl Search<'_> {
    /// Surfaces that come near themselves.
    fn within_geometries(&mut self) {
        let geometries = self.geometries;
        let mut left = MOST_WITHIN;
        for (number, geometry) in (0u32..).zip(geometries) {
            match geometry {
                Geometry::Analytic(surface) => {
                    let bounds = surface.bounds();
                    let reach = NEAR * geometry.magnitude(0);
                    if !bounds.is_empty() && surface.thickness() <= reach {
                        let primitive = Primitive { geometry: number, primitive: 0 };
                        self.add(Zone { bounds: bounds.grown(reach), planes: [None; 2], reach }, [primitive; 2]);
                    }
                }
                mesh => {
                    let count = mesh.triangle_count();
                    if count <= left {
                        left -= count;
                        let pieces = self.pieces(number, None);
                        self.sweep(&pieces, &[]);
                    }
                }
            }
        }
    }

    /// Surfaces that come near others, those first that take the least time to tell.
    fn between_geometries(&mut self) {
        let boxes = self.grown_boxes();
        let mut order: Vec<usize> = (0..boxes.len()).filter(|i| !boxes[*i].is_empty()).collect();
        order.sort_by(|a, b| boxes[*a].min.x.total_cmp(&boxes[*b].min.x));
        let mut pairs = Vec::new();
        let mut compared = 0;
        for (k, a) in order.iter().enumerate() {
            for b in order[k + 1..].iter().take_while(|b| boxes[**b].min.x <= boxes[*a].max.x) {
                compared += 1;
                let common = common(&boxes[*a], &boxes[*b]);
                if (common.min.cmple(common.max)).all() {
                    let count = self.geometries[*a].triangle_count() + self.geometries[*b].triangle_count();
                    pairs.push((count, *a as u32, *b as u32, common));
                }
                if compared > MOST_PAIRS {
                    break;
                }
            }
        }
        pairs.sort_by_key(|(count, a, b, _)| (*count, *a, *b));
        let mut looks = 0;
        for (count, a, b, common) in pairs {
            looks += count;
            if looks > MOST_LOOKS {
                return;
            }
            let (a, b) = (self.pieces(a, Some(&common)), self.pieces(b, Some(&common)));
            if !a.is_empty() && !b.is_empty() {
                self.sweep(&a, &b);
            }
        }
    }

    /// The boxes of the geometries, grown by how far from them others are near.
    fn grown_boxes(&self) -> Vec<Aabb> {
        // Of the meshes of objects, the greatest coordinates.
        let mut own = HashMap::new();
        let grown = |geometry: &Geometry| {
            let bounds = geometry.bounds();
            if bounds.is_empty() {
                return bounds;
            }
            let magnitude = match geometry {
                Geometry::Instance(instance) => {
                    let mesh: &TriangleMesh = instance.mesh();
                    let own = *own.entry(std::ptr::from_ref(mesh)).or_insert_with(|| {
                        let b = mesh.bounds();
                        b.min.abs().max(b.max.abs())
                    });
                    instance.magnitude_within(own)
                }
                _ => bounds.min.abs().max(bounds.max.abs()).max_element(),
            };
            bounds.grown(NEAR * magnitude)
        };
        self.geometries.iter().map(grown).collect()
    }

    /// The primitives of a geometry, or those near the box `near`.
    fn pieces(&self, number: u32, near: Option<&Aabb>) -> Vec<Piece> {
        let geometry = &self.geometries[number as usize];
        let piece = |primitive: u32, bounds: Aabb| {
            let reach = NEAR * geometry.magnitude(primitive);
            let grown = bounds.grown(reach);
            let is_near = near.is_none_or(|near| grown.min.cmple(near.max).all() && near.min.cmple(grown.max).all());
            is_near.then_some(Piece { primitive: Primitive { geometry: number, primitive }, bounds, reach })
        };
        if let Geometry::Analytic(surface) = geometry {
            return piece(0, surface.bounds()).into_iter().collect();
        }
        let of = |triangle: u32| {
            let bounds = geometry.corners(triangle)?.into_iter().fold(Aabb::EMPTY, Aabb::with_point);
            piece(triangle, bounds)
        };
        (0..geometry.triangle_count() as u32).filter_map(of).collect()
    }

    /// Compares all of `a` with all of `b`; with each other, if `b` is empty.
    fn sweep(&mut self, a: &[Piece], b: &[Piece]) {
        // Along the axis along which they are spread most.
        let all = a.iter().chain(b).fold(Aabb::EMPTY, |all, p| all.union(p.bounds));
        if all.is_empty() {
            return;
        }
        let axis = (all.max - all.min).max_position();
        let start = |p: &Piece| p.bounds.min[axis] - p.reach;
        let end = |p: &Piece| p.bounds.max[axis] + p.reach;
        let mut order: Vec<(&Piece, bool)> = a.iter().map(|p| (p, false)).chain(b.iter().map(|p| (p, true))).collect();
        order.sort_by(|(p, _), (q, _)| start(p).total_cmp(&start(q)));
        for (k, (p, of_b)) in order.iter().enumerate() {
            for (q, _) in order[k + 1..].iter().take_while(|(q, _)| start(q) <= end(p)).filter(|(_, o)| b.is_empty() || o != of_b)
            {
                self.pairs += 1;
                if self.pairs > MOST_PAIRS || self.zones.len() > MOST_ZONES {
                    return;
                }
                self.compare(p, q);
            }
        }
    }

    /// Notes the zone of two primitives, if they have one.
    fn compare(&mut self, p: &Piece, q: &Piece) {
        let reach = p.reach + q.reach;
        let bounds = common(&p.bounds.grown(reach), &q.bounds.grown(reach));
        if !bounds.min.cmple(bounds.max).all() {
            return;
        }
        let of = |piece: &Piece| &self.geometries[piece.primitive.geometry as usize];
        let corners = [p, q].map(|piece| of(piece).corners(piece.primitive.primitive));
        if let [Some(a), Some(b)] = &corners
            && p.primitive.geometry == q.primitive.geometry
            && continues(a, b)
        {
            return;
        }
        let planes = corners.map(|corners| {
            let [a, b, c] = corners?;
            let n = (b - a).cross(c - a).try_normalize()?;
            Some((n, n.dot(a)))
        });
        // All corners of the one on one side of the other: never near.
        for (plane, corners) in [(planes[0], corners[1]), (planes[1], corners[0])] {
            if let (Some((n, distance)), Some(corners)) = (plane, corners) {
                let off = corners.map(|c| n.dot(c) - distance);
                if off.iter().all(|o| *o > reach) || off.iter().all(|o| *o < -reach) {
                    return;
                }
            }
        }
        let both = [p.primitive, q.primitive];
        if let [Some(a), Some(b)] = corners {
            let zone = Zone { bounds, planes, reach };
            if meet_at_edges(a, b, reach) {
                self.cracks.push(zone);
            }
            return self.add(zone, both);
        }
        let mut boxes = vec![bounds];
        for _ in 0..HALVINGS {
            boxes = boxes.into_iter().flat_map(halves).filter(|b| both.iter().all(|s| self.may_pass(*s, b, reach))).collect();
        }
        for bounds in boxes {
            self.add(Zone { bounds, planes, reach }, both);
        }
    }

    /// Whether an analytic surface may come within `reach` of a box.
    fn may_pass(&self, p: Primitive, bounds: &Aabb, reach: f64) -> bool {
        match &self.geometries[p.geometry as usize] {
            Geometry::Analytic(surface) => surface.may_pass(bounds.center(), 0.5 * (bounds.max - bounds.min) + reach),
            _ => true,
        }
    }

    fn add(&mut self, zone: Zone, of: [Primitive; 2]) {
        self.zones.push(zone);
        for p in of {
            let bits = &mut self.involved[p.geometry as usize];
            bits.resize(self.geometries[p.geometry as usize].triangle_count().max(1).div_ceil(64), 0);
            bits[p.primitive as usize / 64] |= 1 << (p.primitive % 64);
        }
    }
}

/// What two boxes have in common; its least corner may lie beyond its greatest.
fn common(a: &Aabb, b: &Aabb) -> Aabb {
    Aabb { min: a.min.max(b.min), max: a.max.min(b.max) }
}

/// The two halves of a box, across its longest side.
fn halves(b: Aabb) -> [Aabb; 2] {
    let axis = (b.max - b.min).max_position();
    let middle = b.center()[axis];
    let (mut low, mut high) = (b, b);
    (low.max[axis], high.min[axis]) = (middle, middle);
    [low, high]
}

/// Whether the second of two triangles of a mesh has a vertex of the first and goes on about as that does.
fn continues(a: &[DVec3; 3], b: &[DVec3; 3]) -> bool {
    let normal = |[a, b, c]: &[DVec3; 3]| (*b - *a).cross(*c - *a).normalize_or_zero();
    a.iter().any(|p| b.contains(p)) && normal(a).dot(normal(b)) >= SMOOTH
}

/// Whether two triangles meet along an edge of each, within `reach`, which is not the same for both.
fn meet_at_edges(a: [DVec3; 3], b: [DVec3; 3], reach: f64) -> bool {
    let edges = |[p, q, r]: [DVec3; 3]| [[p, q], [q, r], [r, p]];
    edges(a).into_iter().flat_map(|e| edges(b).map(|f| (e, f))).any(|([p, q], [r, s])| {
        let same = (p == r && q == s) || (p == s && q == r);
        let way = q - p;
        let length = way.length();
        let along = [r, s].map(|x| (x - p).dot(way) / length);
        let beside = [r, s].map(|x| (x - p).cross(way).length() / length);
        let overlap = length.min(along[0].max(along[1])) - f64::max(0.0, along[0].min(along[1]));
        !same && beside.iter().all(|b| *b <= reach) && overlap > reach
    })
}
