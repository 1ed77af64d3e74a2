//! A plain bounding volume hierarchy in double precision, without any cleverness: the oracle that the tests hold the fast
//! intersector against, and what is left where Embree cannot be had.
//!
//! Instances are taken apart: each of their triangles stands in the hierarchy, in render space. Triangles are tested as in Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection", JCGT 2(1): no segment
//! slips between two triangles that share an edge.
//!
//! ```bhs
//! Option "string intersector" "reference"
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::geometry::{Aabb, Geometry, Segment};
use bhs_core::intersector::{Intersector, IntersectorBuilder, PrimitiveHit};
use glam::{DVec3, USizeVec3};

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn IntersectorBuilder> = Plugin {
    name: "reference",
    summary: "A plain bounding volume hierarchy in double precision; slow, the oracle of the tests",
    build: |_| Some(Box::new(Reference)),
};

/// Builder of the hierarchy.
pub struct Reference;

/// A leaf is split while it has more primitives.
const LEAF: usize = 4;

/// Relative growth of boxes and slack of their parameters: some rounding errors, so that no box is missed whose content is hit.
const SLACK: f64 = 16.0 * f64::EPSILON;

/// Levels that the hierarchy can have: median splits halve `u32::MAX` primitives at most 32 times.
const DEPTH: usize = 48;

/// A triangle of a mesh, or an analytic surface.
struct Primitive {
    geometry: u32,
    primitive: u32,
    bounds: Aabb,
}

/// The first child of an inner node comes next in the list.
struct Node {
    bounds: Aabb,
    /// Of a leaf, its first primitive; of an inner node, its second child.
    link: u32,
    /// How many primitives; 0 in an inner node.
    count: u32,
    /// Along which an inner node is split.
    axis: usize,
}

struct Hierarchy {
    geometries: Vec<Geometry>,
    nodes: Vec<Node>,
    /// Geometry and primitive, in the order of the leaves.
    primitives: Vec<(u32, u32)>,
}

impl IntersectorBuilder for Reference {
    fn build(&self, geometries: &[Geometry]) -> Result<Box<dyn Intersector>, String> {
        crate::check(geometries)?;
        let mut primitives = Vec::new();
        for (geometry, shape) in (0u32..).zip(geometries) {
            match shape {
                Geometry::Analytic(surface) => primitives.push(Primitive { geometry, primitive: 0, bounds: surface.bounds() }),
                mesh => primitives.extend((0..mesh.triangle_count() as u32).map(|primitive| {
                    let corners = mesh.corners(primitive).into_iter().flatten();
                    Primitive { geometry, primitive, bounds: corners.fold(Aabb::EMPTY, Aabb::with_point) }
                })),
            }
        }
        // An analytic surface may be empty, and so is the box of a triangle whose vertices are not numbers.
        primitives.retain(|p| !p.bounds.is_empty());
        if u32::try_from(primitives.len()).is_err() {
            return Err(format!("{} triangles are more than can be numbered", primitives.len()));
        }
        let mut nodes = Vec::new();
        if !primitives.is_empty() {
            split(&mut nodes, &mut primitives, 0);
        }
        let primitives = primitives.iter().map(|p| (p.geometry, p.primitive)).collect();
        Ok(Box::new(Hierarchy { geometries: geometries.to_vec(), nodes, primitives }))
    }
}

/// Appends the hierarchy over `primitives`, the first of which has the number `first`.
fn split(nodes: &mut Vec<Node>, primitives: &mut [Primitive], first: usize) {
    let bounds = primitives.iter().fold(Aabb::EMPTY, |b, p| b.union(p.bounds));
    let bounds = bounds.grown(SLACK * bounds.min.abs().max(bounds.max.abs()).max_element());
    let here = nodes.len();
    if primitives.len() <= LEAF {
        nodes.push(Node { bounds, link: first as u32, count: primitives.len() as u32, axis: 0 });
        return;
    }
    let centers = primitives.iter().fold(Aabb::EMPTY, |b, p| b.with_point(p.bounds.center()));
    let axis = (centers.max - centers.min).max_position();
    let half = primitives.len() / 2;
    primitives.select_nth_unstable_by(half, |a, b| a.bounds.center()[axis].total_cmp(&b.bounds.center()[axis]));
    nodes.push(Node { bounds, link: 0, count: 0, axis });
    let (left, right) = primitives.split_at_mut(half);
    split(nodes, left, first);
    nodes[here].link = nodes.len() as u32;
    split(nodes, right, first + half);
}

impl Intersector for Hierarchy {
    fn closest(&self, segment: &Segment) -> Option<PrimitiveHit> {
        self.traverse(segment, false)
    }

    fn blocked(&self, segment: &Segment) -> bool {
        self.traverse(segment, true).is_some()
    }
}

impl Hierarchy {
    /// The first hit found if `any`, else the hit with the least parameter.
    fn traverse(&self, segment: &Segment, any: bool) -> Option<PrimitiveHit> {
        if self.nodes.is_empty() {
            return None;
        }
        let shear = Shear::new(segment)?;
        let inverse = segment.direction.recip();
        let mut segment = *segment;
        let mut best = None;
        let mut stack = [0u32; DEPTH];
        let mut height = 1;
        while height > 0 {
            height -= 1;
            let index = stack[height];
            let node = &self.nodes[index as usize];
            if !meets(&node.bounds, &segment, inverse) {
                continue;
            }
            if node.count == 0 {
                let (near, far) =
                    if segment.direction[node.axis] < 0.0 { (node.link, index + 1) } else { (index + 1, node.link) };
                stack[height] = far;
                stack[height + 1] = near;
                height += 2;
                continue;
            }
            for &(geometry, primitive) in &self.primitives[node.link as usize..(node.link + node.count) as usize] {
                let t = match &self.geometries[geometry as usize] {
                    Geometry::Analytic(surface) => surface.intersect(&segment),
                    mesh => mesh.corners(primitive).and_then(|corners| shear.triangle(corners)),
                };
                let Some(t) = t.filter(|t| segment.t_min < *t && *t < segment.t_max) else { continue };
                best = Some(PrimitiveHit { t, geometry, primitive });
                if any {
                    return best;
                }
                segment.t_max = t;
            }
        }
        best
    }
}

/// Whether the segment may pass the box. A product that is not a number (a segment within a box's face) rules nothing out.
fn meets(bounds: &Aabb, segment: &Segment, inverse: DVec3) -> bool {
    let (mut enter, mut leave) = (segment.t_min, segment.t_max);
    for axis in 0..3 {
        let a = (bounds.min[axis] - segment.origin[axis]) * inverse[axis];
        let b = (bounds.max[axis] - segment.origin[axis]) * inverse[axis];
        // f64::min and f64::max ignore what is not a number.
        if !a.is_nan() && !b.is_nan() {
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
    }
    enter - SLACK * enter.abs() <= leave + SLACK * leave.abs()
}

/// The shear that takes the segment's line to an axis, with its start at the origin.
struct Shear {
    origin: DVec3,
    axes: USizeVec3,
    shear: DVec3,
}

impl Shear {
    /// None unless the segment is a piece of a line.
    fn new(segment: &Segment) -> Option<Self> {
        let Segment { origin, direction, t_min, t_max } = *segment;
        let is_piece = origin.is_finite() && direction.is_finite() && direction != DVec3::ZERO && t_min < t_max;
        if !is_piece {
            return None;
        }
        let z = direction.abs().max_position();
        let axes = USizeVec3::new((z + 1) % 3, (z + 2) % 3, z);
        let along = direction[z];
        let shear = DVec3::new(direction[axes.x] / along, direction[axes.y] / along, 1.0 / along);
        Some(Self { origin, axes, shear })
    }

    /// The parameter at which the line meets the triangle, edges included.
    fn triangle(&self, corners: [DVec3; 3]) -> Option<f64> {
        let [a, b, c] = corners.map(|corner| {
            let p = corner - self.origin;
            let (x, y, z) = (p[self.axes.x], p[self.axes.y], p[self.axes.z]);
            DVec3::new(x - self.shear.x * z, y - self.shear.y * z, self.shear.z * z)
        });
        // An edge of two triangles gives these two the same number with opposite signs, exactly.
        let weights = DVec3::new(c.x * b.y - c.y * b.x, a.x * c.y - a.y * c.x, b.x * a.y - b.y * a.x);
        if weights.min_element() < 0.0 && weights.max_element() > 0.0 {
            return None;
        }
        let sum = weights.element_sum();
        let t = weights.dot(DVec3::new(a.z, b.z, c.z)) / sum;
        t.is_finite().then_some(t)
    }
}
