//! `loopsubdiv`: the smooth surface that triangles of a coarse mesh control.
//!
//! Each level makes four triangles of one; then vertices are put where infinitely many levels would take them, with the normals of that limit.
//! Edges with one triangle are a border, which is smooth by itself. The normals are pbrt-v4's: they point away from the side on which the
//! corners of a triangle are seen in counter-clockwise order (in the right-handed sense).
//!
//! Source: Loop 1987, "Smooth Subdivision Surfaces Based on Triangles"; borders and limits: Hoppe et al. 1994, "Piecewise Smooth Surface
//! Reconstruction". Names and defaults of pbrt-v4.
//!
//! | parameter | type | default | meaning |
//! |---|---|---|---|
//! | `P` | point3 | required | vertex positions |
//! | `indices` | integer | 0 1 2 | three vertex numbers a triangle, from 0 |
//! | `levels` | integer | 3 | how often triangles are divided, 0 to 10 |
//!
//! ```bhs
//! WorldBegin
//! Shape "loopsubdiv" "integer levels" 4 "point3 P" [1 1 1  -1 -1 1  -1 1 -1  1 -1 -1]
//!     "integer indices" [0 1 2  0 3 1  0 2 3  1 3 2]
//! ```

use crate::mesh::{checked_indices, to_world, unit};
use bhs_core::diagnostics::Diagnostic;
use bhs_core::geometry::{Shape, WorldMesh};
use bhs_core::params::{Params, Point3};
use bhs_core::plugin::Plugin;
use bhs_elementary::Elementary;
use glam::DVec3;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// The entry in the list of shapes.
pub const PLUGIN: Plugin<dyn Shape> =
    Plugin { name: "loopsubdiv", summary: "the smooth surface that triangles of a coarse mesh control", build };

/// More triangles than this are not made.
const MOST_TRIANGLES: usize = 1 << 24;

fn build(p: &Params) -> Option<Box<dyn Shape>> {
    let positions = p.require::<Vec<Point3>>("P", "", "vertex positions");
    let indices = p.optional::<Vec<i64>>("indices", "", "three vertex numbers a triangle, from 0");
    let levels = p.get_in("levels", 3, 0..=10, "", "how often triangles are divided, 0 to 10");
    let positions = positions?;
    let triangles = checked_indices::<3>(p, indices, positions.len(), "triangle")?;
    if triangles.len().saturating_mul(1 << (2 * levels)) > MOST_TRIANGLES {
        p.reject("levels", "`levels` is too large", format!("more than {MOST_TRIANGLES} triangles"));
        return None;
    }
    let mut control = Control { positions: positions.into_iter().map(|p| p.0).collect(), triangles };
    for _ in 0..levels {
        control = control.rings().map_err(|why| refuse(p, why)).ok().map(|rings| control.divided(&rings))?;
    }
    let rings = control.rings().map_err(|why| refuse(p, why)).ok()?;
    let (positions, normals) = control.limit(&rings);
    let mesh = WorldMesh { positions, triangles: control.triangles, normals, ..WorldMesh::default() };
    Some(Box::new(to_world(p, mesh)?))
}

fn refuse(p: &Params, why: String) {
    p.report(
        Diagnostic::error("bad-mesh", "this mesh controls no surface")
            .at(p.span_of("indices"), why)
            .help("every edge has one or two triangles, which run along it in opposite directions"),
    );
}

/// A mesh that controls a surface.
struct Control {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

/// The neighbours of a vertex in counter-clockwise order.
struct Ring {
    vertices: Vec<u32>,
    is_border: bool,
}

impl Ring {
    /// The weight of each neighbour when a vertex inside moves (Loop).
    fn beta(&self) -> f64 {
        if self.vertices.len() == 3 { 3.0 / 16.0 } else { 3.0 / (8.0 * self.vertices.len() as f64) }
    }
}

impl Control {
    /// The rings of all vertices; empty for those without triangles.
    fn rings(&self) -> Result<Vec<Ring>, String> {
        let mut next: Vec<Vec<(u32, u32)>> = vec![Vec::new(); self.positions.len()];
        for t in &self.triangles {
            if t[0] == t[1] || t[1] == t[2] || t[2] == t[0] {
                return Err(format!("a triangle has vertex {} twice", if t[0] == t[1] { t[0] } else { t[2] }));
            }
            for k in 0..3 {
                next[t[k] as usize].push((t[(k + 1) % 3], t[(k + 2) % 3]));
            }
        }
        let ring = |(v, pairs): (usize, &Vec<(u32, u32)>)| {
            let follows: HashMap<u32, u32> = pairs.iter().copied().collect();
            let leads: HashMap<u32, u32> = pairs.iter().map(|(a, b)| (*b, *a)).collect();
            if follows.len() < pairs.len() || leads.len() < pairs.len() {
                return Err(format!("more than two triangles, or two that do not match, share an edge of vertex {v}"));
            }
            let first = pairs.iter().map(|(a, _)| *a).find(|a| !leads.contains_key(a));
            let is_border = first.is_some();
            let mut vertices = Vec::with_capacity(pairs.len() + 1);
            if let Some(start) = first.or(pairs.first().map(|(a, _)| *a)) {
                vertices.push(start);
                while let Some(b) = follows.get(&vertices[vertices.len() - 1])
                    && *b != start
                {
                    vertices.push(*b);
                }
            }
            if vertices.len() != pairs.len() + usize::from(is_border) {
                return Err(format!("two parts of the surface touch in vertex {v} alone"));
            }
            Ok(Ring { vertices, is_border })
        };
        next.iter().enumerate().map(ring).collect()
    }

    /// Where a vertex goes with the weight `inside` of each neighbour, or `border` of the two on the border.
    fn moved(&self, v: usize, ring: &Ring, inside: f64, border: f64) -> DVec3 {
        let at = |i: &u32| self.positions[*i as usize];
        if ring.vertices.is_empty() {
            // No triangle has it.
            return self.positions[v];
        }
        match (ring.is_border, ring.vertices.first(), ring.vertices.last()) {
            (true, Some(first), Some(last)) => (1.0 - 2.0 * border) * self.positions[v] + border * (at(first) + at(last)),
            _ => {
                let sum: DVec3 = ring.vertices.iter().map(at).sum();
                (1.0 - inside * ring.vertices.len() as f64) * self.positions[v] + inside * sum
            }
        }
    }

    /// The mesh of the next level.
    fn divided(&self, rings: &[Ring]) -> Self {
        let mut positions: Vec<DVec3> = (0..rings.len()).map(|v| self.moved(v, &rings[v], rings[v].beta(), 1.0 / 8.0)).collect();
        // The vertices across each edge.
        let key = |a: u32, b: u32| (a.min(b), a.max(b));
        let mut edges: HashMap<(u32, u32), (DVec3, u32)> = HashMap::with_capacity(2 * self.triangles.len());
        for t in &self.triangles {
            for k in 0..3 {
                let entry = edges.entry(key(t[k], t[(k + 1) % 3])).or_insert((DVec3::ZERO, 0));
                *entry = (entry.0 + self.positions[t[(k + 2) % 3] as usize], entry.1 + 1);
            }
        }
        let mut numbers: HashMap<(u32, u32), u32> = HashMap::with_capacity(edges.len());
        let mut triangles = Vec::with_capacity(4 * self.triangles.len());
        for t in &self.triangles {
            let middle = [0, 1, 2].map(|k: usize| {
                let edge = key(t[k], t[(k + 1) % 3]);
                *numbers.entry(edge).or_insert_with(|| {
                    let ends = self.positions[edge.0 as usize] + self.positions[edge.1 as usize];
                    let across = edges.get(&edge).copied().unwrap_or_default();
                    positions.push(if across.1 == 2 { 0.375 * ends + 0.125 * across.0 } else { 0.5 * ends });
                    (positions.len() - 1) as u32
                })
            });
            triangles.extend([
                [t[0], middle[0], middle[2]],
                [middle[0], t[1], middle[1]],
                [middle[2], middle[1], t[2]],
                [middle[0], middle[1], middle[2]],
            ]);
        }
        Self { positions, triangles }
    }

    /// Places and normals on the limit surface.
    fn limit(&self, rings: &[Ring]) -> (Vec<DVec3>, Vec<[f32; 3]>) {
        let gamma = |ring: &Ring| 1.0 / (ring.vertices.len() as f64 + 3.0 / (8.0 * ring.beta()));
        let positions: Vec<DVec3> = (0..rings.len()).map(|v| self.moved(v, &rings[v], gamma(&rings[v]), 1.0 / 5.0)).collect();
        let normals = rings.iter().zip(&positions).map(|(ring, at)| {
            let points: Vec<DVec3> = ring.vertices.iter().map(|i| positions[*i as usize]).collect();
            unit(if ring.is_border { border_normal(&points, *at) } else { inner_normal(&points) })
        });
        (positions.clone(), normals.collect())
    }
}

/// The normal where the ring is whole.
fn inner_normal(ring: &[DVec3]) -> DVec3 {
    let n = ring.len() as f64;
    // Clockwise, as pbrt-v4 goes around.
    let tangent = |f: fn(f64) -> f64| ring.iter().rev().enumerate().map(|(j, p)| f(TAU * j as f64 / n) * *p).sum::<DVec3>();
    tangent(<f64 as Elementary>::cosine).cross(tangent(<f64 as Elementary>::sine))
}

/// The normal on the border.
fn border_normal(ring: &[DVec3], at: DVec3) -> DVec3 {
    let last = ring.len() - 1;
    let along = ring[last] - ring[0];
    let across = match ring.len() {
        2 => ring[0] + ring[1] - 2.0 * at,
        3 => ring[1] - at,
        4 => -ring[0] + 2.0 * ring[1] + 2.0 * ring[2] - ring[3] - 2.0 * at,
        n => {
            let theta = PI / (n - 1) as f64;
            let inner = (1..last).map(|k| (2.0 * theta.cosine() - 2.0) * (k as f64 * theta).sine() * ring[k]);
            -(theta.sine() * (ring[0] + ring[last]) + inner.sum::<DVec3>())
        }
    };
    along.cross(across)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn octahedron() -> Control {
        let positions = vec![DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
        let triangles = vec![[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
        Control { positions, triangles }
    }

    fn levels(mut control: Control, n: usize) -> Control {
        for _ in 0..n {
            control = control.divided(&control.rings().expect("a surface"));
        }
        control
    }

    #[test]
    fn the_limit_does_not_depend_on_the_level() {
        let limit = |n: usize| {
            let control = levels(octahedron(), n);
            control.limit(&control.rings().expect("a surface"))
        };
        let (coarse, fine) = (limit(0), limit(3));
        for v in 0..6 {
            assert!((coarse.0[v] - fine.0[v]).length() < 1e-12, "{v}");
            // Outwards is where the corners are counter-clockwise: the normals point inwards.
            let inwards = -fine.0[v].normalize();
            assert!((DVec3::from_array(fine.1[v].map(f64::from)) - inwards).length() < 1e-6, "{v}: {:?}", fine.1[v]);
        }
        assert_eq!(levels(octahedron(), 3).triangles.len(), 8 * 64);
    }

    #[test]
    fn a_flat_sheet_stays_flat_and_its_border_is_a_curve() {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
        let control = levels(Control { positions, triangles: vec![[0, 1, 2], [0, 2, 3]] }, 2);
        let (places, normals) = control.limit(&control.rings().expect("a surface"));
        assert!(places.iter().all(|p| p.z == 0.0 && p.min_element() >= 0.0 && p.max_element() <= 1.0));
        assert!(normals.iter().all(|n| (n[2] + 1.0).abs() < 1e-6), "{normals:?}");
    }

    #[test]
    fn a_vertex_without_triangles_stays_where_it_is() {
        let mut control = octahedron();
        control.positions.push(DVec3::splat(9.0));
        let control = levels(control, 1);
        let (places, normals) = control.limit(&control.rings().expect("a surface"));
        assert_eq!(places[6], DVec3::splat(9.0));
        assert!(
            places.iter().all(|p| p.is_finite()) && normals.as_flattened().iter().all(|n| n.is_finite()),
            "{places:?} {normals:?}"
        );
    }

    #[test]
    fn what_is_no_surface_is_refused() {
        let positions = vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X];
        for triangles in [vec![[0, 1, 2], [0, 1, 3]], vec![[0, 0, 1]], vec![[0, 1, 2], [0, 3, 4]]] {
            let control = Control { positions: positions.clone(), triangles };
            assert!(control.rings().is_err(), "{:?}", control.triangles);
        }
    }
}
