//! Polygons to triangles, convex or not, whichever corner comes first.
//!
//! All triangles of a polygon lie on the outer side of its Newell normal (Sutherland et al. 1974): the mean normal of a closed line,
//! plane or not. Quadrilaterals are cut along the shorter of the diagonals that lie within. Other polygons that are not convex become a
//! constrained Delaunay triangulation (the crate `spade`) in the plane of the two axes along which they extend most; it uses all corners,
//! those in the middle of a straight side too, so that neighbours fit. Holes that are joined to the outline by a seam stay open. A line
//! that crosses itself has no inside: it becomes the fan around one of its corners, and is counted.

use glam::{DVec2, DVec3};
use spade::handles::{FixedFaceHandle, InnerTag};
use spade::{ConstrainedDelaunayTriangulation, HierarchyHintGenerator, Point2, Triangulation};
use std::collections::HashMap;

/// Part of a polygon's area that is none, beside roundings.
const NO_AREA: f64 = 1e-12;

/// The triangles of one polygon, as numbers of its corners.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Filled {
    pub(crate) triangles: Vec<[u32; 3]>,
    /// Whether the line crosses itself.
    pub(crate) crosses: bool,
}

/// Fills the polygon with these corners, of which there are at least three.
pub(crate) fn fill(corners: &[DVec3]) -> Filled {
    match corners {
        [_, _, _] => Filled { triangles: vec![[0, 1, 2]], crosses: false },
        [a, b, c, d] => quadrilateral([*a, *b, *c, *d]),
        _ => many(corners),
    }
}

/// Sum of the cross products of a closed line: along the mean normal, twice as long as its area.
fn newell(corners: &[DVec3]) -> DVec3 {
    // From the first corner, so that polygons far from the origin keep their digits.
    let first = corners[0];
    corners[1..].windows(2).map(|w| (w[0] - first).cross(w[1] - first)).sum()
}

fn quadrilateral(q: [DVec3; 4]) -> Filled {
    let normal = (q[2] - q[0]).cross(q[3] - q[1]);
    let whole = normal.length_squared();
    // Twice the area of a triangle, as the normal sees it.
    let area = |[i, j, k]: [usize; 3]| (q[j] - q[i]).cross(q[k] - q[i]).dot(normal) / whole;
    let cuts = [[[0, 1, 2], [0, 2, 3]], [[1, 2, 3], [1, 3, 0]]];
    let least = cuts.map(|c| area(c[0]).min(area(c[1])));
    let lengths = [q[0].distance_squared(q[2]), q[1].distance_squared(q[3])];
    let first = match least.map(|a| a > NO_AREA) {
        [true, true] if lengths[0] == lengths[1] => precedes(&[q[0].min_of(q[2]), q[1].min_of(q[3])]) == 0,
        [true, true] => lengths[0] < lengths[1],
        [false, false] => precedes(&q).is_multiple_of(2),
        [first, _] => first,
    };
    // Three corners in a line leave a triangle without area: no crossing.
    let crosses = least.iter().all(|a| a.is_nan() || *a < -NO_AREA);
    let cut = cuts[if first { 0 } else { 1 }];
    Filled { triangles: cut.map(|t| t.map(|i| i as u32)).to_vec(), crosses }
}

trait Order {
    fn min_of(self, other: Self) -> Self;
}

impl Order for DVec3 {
    /// The first of two points in the order of their coordinates.
    fn min_of(self, other: Self) -> Self {
        if precedes(&[self, other]) == 0 { self } else { other }
    }
}

/// The corner that comes first in the order of coordinates: the same one, wherever the list begins.
fn precedes(corners: &[DVec3]) -> usize {
    let key = |i: &usize| corners[*i].to_array();
    (0..corners.len()).min_by(|a, b| key(a).partial_cmp(&key(b)).unwrap_or(std::cmp::Ordering::Equal)).unwrap_or(0)
}

fn many(corners: &[DVec3]) -> Filled {
    let normal = newell(corners);
    // Without the axis that the normal is nearest to, the outer side in front.
    let size = normal.abs();
    let flat: fn(DVec3) -> DVec2 = match (size.x > size.y && size.x > size.z, size.y > size.z) {
        (true, _) => |p| DVec2::new(p.y, p.z),
        (_, true) => |p| DVec2::new(p.z, p.x),
        _ => |p| DVec2::new(p.x, p.y),
    };
    let sign = normal.to_array().into_iter().fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a }).signum();
    let points: Vec<DVec2> = corners.iter().map(|p| flat(*p) * DVec2::new(sign, 1.0)).collect();
    let start = precedes(corners);
    if is_convex(&points) {
        return Filled { triangles: fan(corners.len(), start), crosses: false };
    }
    match delaunay(&points) {
        Some(triangles) => Filled { triangles, crosses: false },
        None => Filled { triangles: fan(corners.len(), start), crosses: true },
    }
}

/// The triangles around one corner.
fn fan(n: usize, start: usize) -> Vec<[u32; 3]> {
    let corner = |i: usize| ((start + i) % n) as u32;
    (1..n - 1).map(|i| [corner(0), corner(i), corner(i + 1)]).collect()
}

/// Whether a closed line turns left at every corner, and once in all.
fn is_convex(points: &[DVec2]) -> bool {
    let n = points.len();
    let sides: Vec<DVec2> = (0..n).map(|i| points[(i + 1) % n] - points[i]).collect();
    // A straight corner makes a triangle without area somewhere: those go the other way.
    let turns_left = (0..n).all(|i| sides[i].perp_dot(sides[(i + 1) % n]) > 0.0);
    // Turning once, it goes up once and down once.
    let changes = (0..n).filter(|i| (sides[*i].y > 0.0) != (sides[(i + 1) % n].y > 0.0)).count();
    turns_left && changes == 2
}

/// Triangles within a closed line that goes to the left; `None` if it crosses itself.
fn delaunay(points: &[DVec2]) -> Option<Vec<[u32; 3]>> {
    // A place counts once: a seam comes back to corners that were there.
    let mut places: HashMap<[u64; 2], usize> = HashMap::with_capacity(points.len());
    let mut corner_of = Vec::with_capacity(points.len());
    let mut vertices = Vec::with_capacity(points.len());
    let mut line = Vec::with_capacity(points.len());
    for (i, p) in points.iter().enumerate() {
        // One zero; and none of the numbers near it which `spade` refuses.
        let p = p.to_array().map(|x| if x.abs() < spade::MIN_ALLOWED_VALUE { 0.0 } else { x });
        let place = *places.entry(p.map(f64::to_bits)).or_insert(vertices.len());
        if place == vertices.len() {
            vertices.push(Point2::new(p[0], p[1]));
            corner_of.push(i as u32);
        }
        line.push(place);
    }
    let sides: Vec<[usize; 2]> = (0..line.len()).map(|i| [line[i], line[(i + 1) % line.len()]]).filter(|[a, b]| a != b).collect();
    // One after the other: corners of a polygon that are loaded at once, in no order, take up to quadratic time.
    let mut mesh: ConstrainedDelaunayTriangulation<Point2<f64>, (), (), (), HierarchyHintGenerator<f64>> = Default::default();
    for vertex in vertices {
        mesh.insert(vertex).ok()?;
    }
    let sides = sides.into_iter().map(|ends| ends.map(spade::handles::FixedVertexHandle::from_index));
    // One by one, to end with the first that crosses another.
    for [a, b] in sides.clone() {
        if mesh.try_add_constraint(a, b).is_empty() {
            return None;
        }
    }
    // How often the line goes along each edge; all are there already, so that nothing is changed.
    let mut passes: HashMap<usize, u32> = HashMap::new();
    for [a, b] in sides {
        for edge in mesh.try_add_constraint(a, b) {
            *passes.entry(edge.as_undirected().index()).or_default() += 1;
        }
    }
    // From outside inwards: an edge that the line passes an odd number of times parts inside and outside.
    let parts = |edge: usize| passes.get(&edge).is_some_and(|n| n % 2 == 1);
    let mut inside: Vec<Option<bool>> = vec![None; mesh.num_all_faces()];
    inside[mesh.outer_face().fix().index()] = Some(false);
    let mut front: Vec<FixedFaceHandle<InnerTag>> = Vec::new();
    let reachable = mesh.convex_hull().map(|e| (e.rev(), parts(e.as_undirected().fix().index())));
    for (edge, side) in reachable {
        if let Some(face) = edge.face().as_inner() {
            inside[face.fix().index()] = Some(side);
            front.push(face.fix());
        }
    }
    while let Some(face) = front.pop() {
        let is_inside = inside[face.index()] == Some(true);
        for edge in mesh.face(face).adjacent_edges() {
            let next = edge.rev().face();
            let side = is_inside != parts(edge.as_undirected().fix().index());
            match (inside[next.fix().index()], next.as_inner()) {
                (None, Some(inner)) => {
                    inside[next.fix().index()] = Some(side);
                    front.push(inner.fix());
                }
                // Both ways to a triangle agree unless the line crosses itself.
                (Some(known), _) if known != side => return None,
                _ => {}
            }
        }
    }
    let faces = mesh.inner_faces().filter(|f| inside[f.fix().index()] == Some(true));
    // Counter-clockwise, as the line.
    Some(faces.map(|f| f.vertices().map(|v| corner_of[v.fix().index()])).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use bhs_core::sampling::mix64;

    fn number(i: u64) -> f64 {
        (mix64(i) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Area of the triangles, each of which must lie on the outer side; with every corner first.
    fn area_for_all_corners(corners: &[DVec3]) -> f64 {
        let normal = newell(corners).normalize();
        let mut areas = Vec::new();
        for first in 0..corners.len() {
            let turned: Vec<DVec3> = (0..corners.len()).map(|i| corners[(i + first) % corners.len()]).collect();
            let filled = fill(&turned);
            assert!(!filled.crosses, "{turned:?}");
            let mut sum = 0.0;
            for t in &filled.triangles {
                let [a, b, c] = t.map(|i| turned[i as usize]);
                let twice = (b - a).cross(c - a);
                assert!(twice.dot(normal) > 0.0, "{t:?} of {turned:?} lies on the other side");
                assert!((twice.normalize() - normal).length() < 1e-6, "{turned:?}");
                sum += 0.5 * twice.length();
            }
            areas.push(sum);
        }
        assert!(areas.iter().all(|a| (a / areas[0] - 1.0).abs() < 1e-9), "{areas:?}");
        areas[0]
    }

    fn placed(flat: &[[f64; 2]], frame: [DVec3; 2], origin: DVec3) -> Vec<DVec3> {
        flat.iter().map(|[x, y]| origin + frame[0] * *x + frame[1] * *y).collect()
    }

    #[test]
    fn polygons_are_filled_whichever_corner_comes_first() {
        let l = [[-1.0, -1.0], [1.0, -1.0], [1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [-1.0, 1.0]];
        let comb: Vec<[f64; 2]> = (0..20)
            .flat_map(|i| {
                [[f64::from(i), 0.0], [f64::from(i) + 0.5, 0.0]].map(|[x, y]| if i % 2 == 0 { [x, y] } else { [x, 5.0] })
            })
            .chain([[20.0, 6.0], [0.0, 6.0]])
            .collect();
        let table: Vec<(&str, Vec<[f64; 2]>, f64)> = vec![
            ("square", vec![[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]], 4.0),
            ("arrow", vec![[0.0, -1.0], [1.0, 1.0], [0.0, 0.0], [-1.0, 1.0]], 1.0),
            ("L", l.to_vec(), 3.0),
            ("clockwise L", l.iter().rev().copied().collect(), 3.0),
            (
                "hexagon",
                (0..6).map(|i| f64::from(i) * std::f64::consts::FRAC_PI_3).map(|a| [a.cos(), a.sin()]).collect(),
                1.5 * 3f64.sqrt(),
            ),
            ("corner in a straight side", vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]], 4.0),
            ("triangle of four corners", vec![[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [0.0, 2.0]], 2.0),
            ("corners twice", vec![[0.0, 0.0], [2.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0], [0.0, 2.0]], 4.0),
            // A square hole, joined by a seam.
            (
                "hole",
                vec![
                    [0.0, 0.0],
                    [4.0, 0.0],
                    [4.0, 4.0],
                    [0.0, 4.0],
                    [0.0, 0.0],
                    [1.0, 1.0],
                    [1.0, 3.0],
                    [3.0, 3.0],
                    [3.0, 1.0],
                    [1.0, 1.0],
                ],
                12.0,
            ),
            ("spike", vec![[0.0, 0.0], [2.0, 0.0], [3.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]], 4.0),
            ("comb", comb.clone(), {
                let twice: f64 =
                    (0..comb.len()).map(|i| DVec2::from(comb[i]).perp_dot(DVec2::from(comb[(i + 1) % comb.len()]))).sum();
                twice.abs() / 2.0
            }),
        ];
        let frames = [
            ([DVec3::X, DVec3::Y], DVec3::ZERO),
            ([DVec3::Y, DVec3::Z], DVec3::new(3.0, 2.0, 1.0)),
            ([DVec3::Z, DVec3::X], DVec3::ZERO),
            ([DVec3::new(0.6, 0.0, 0.8), DVec3::new(0.0, 1.0, 0.0)], DVec3::new(0.0, 0.0, 1000.0)),
        ];
        for (name, flat, wanted) in table {
            for (frame, origin) in frames {
                // What roundings out of the plane do to corners in a straight line is not what is asked here.
                if frame[0].x == 0.6 && ["triangle of four corners", "spike"].contains(&name) {
                    continue;
                }
                let area = area_for_all_corners(&placed(&flat, frame, origin));
                assert!((area - wanted).abs() < 1e-6, "{name}: {area}, not {wanted}");
            }
        }
    }

    #[test]
    fn stars_of_many_corners_have_their_area() {
        for seed in 0..30 {
            let n = 5 + (mix64(seed) % 40) as usize;
            let ray = |i: usize| {
                let (sin, cos) = (i as f64 / n as f64 * std::f64::consts::TAU).sin_cos();
                let r = 0.05 + number(seed * 1000 + i as u64);
                [r * cos, r * sin]
            };
            let flat: Vec<[f64; 2]> = (0..n).map(ray).collect();
            let twice: f64 = (0..n).map(|i| DVec2::from(flat[i]).perp_dot(DVec2::from(flat[(i + 1) % n]))).sum();
            let area = area_for_all_corners(&placed(&flat, [DVec3::X, DVec3::Y], DVec3::ZERO));
            assert!((area - 0.5 * twice).abs() < 1e-9, "{area} {twice}");
        }
    }

    #[test]
    fn lines_that_cross_themselves_are_fans() {
        let bow_tie = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0));
        let filled = fill(&bow_tie);
        assert!(filled.crosses && filled.triangles.len() == 2, "{filled:?}");
        let pentagram: Vec<DVec3> =
            (0..5).map(|i| f64::from(2 * i) * std::f64::consts::TAU / 5.0).map(|a| DVec3::new(a.cos(), a.sin(), 0.0)).collect();
        let filled = fill(&pentagram);
        assert!(filled.crosses && filled.triangles.len() == 3, "{filled:?}");
        // No area at all.
        for n in 3..8 {
            assert!(fill(&vec![DVec3::ONE; n]).triangles.len() <= n - 2);
            assert!(fill(&(0..n).map(|i| DVec3::X * i as f64).collect::<Vec<_>>()).triangles.len() <= n - 2);
        }
    }

    #[test]
    fn the_largest_polygons_take_no_longer_than_they_should() {
        // A saw of 200,000 corners, and as many at random: what is quadratic would not end.
        let saw = |i: u32| DVec3::new(f64::from(i), f64::from(i % 2) + if i == 0 { 5.0 } else { 0.0 }, 0.0);
        let filled = fill(&(0..200_001).map(saw).collect::<Vec<_>>());
        assert!(!filled.triangles.is_empty());
        let random: Vec<DVec3> = (0..200_000).map(|i| DVec3::new(number(2 * i), number(2 * i + 1), 0.0)).collect();
        assert!(fill(&random).crosses);
    }
}
