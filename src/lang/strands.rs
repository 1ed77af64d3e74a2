//! Curves in a row become one mesh: hair is many thousands of them, and a mesh of its own costs each more than its triangles.

use crate::lang::description::ShapeEntity;
use crate::lang::parts::Part;
use bhs_core::geometry::{WorldGeometry, WorldMesh};

/// Vertices of a mesh from which on nothing is added to it: they are numbered with 32 bits.
const MOST_VERTICES: usize = 1 << 30;

/// The last part of a scene, if it is a mesh of curves that more may be added to.
#[derive(Default)]
pub(super) struct Strands {
    /// What the curves have in common, and which part they are.
    open: Option<(Common, usize)>,
}

#[derive(PartialEq)]
struct Common {
    material: Option<usize>,
    side: bhs_core::spacetime::Side,
    reverse_orientation: bool,
}

impl Strands {
    /// Puts a shape's surface, of which it has one, into the mesh of the curves before it; it comes back if it is none, or differs from these. Curves
    /// that emit light or move stay what they are.
    pub fn add(
        &mut self,
        shape: &ShapeEntity,
        moves: bool,
        surfaces: Vec<WorldGeometry>,
        parts: &mut [Part],
    ) -> Vec<WorldGeometry> {
        let is_plain = shape.entity.name.value == "curve" && shape.area_light.is_none() && shape.object.is_none() && !moves;
        let mesh = match surfaces.as_slice() {
            [WorldGeometry::Mesh(mesh)] if is_plain => mesh,
            _ => {
                self.open = None;
                return surfaces;
            }
        };
        let common = Common { material: shape.material, side: shape.entity.side, reverse_orientation: shape.reverse_orientation };
        if let Some((open, at)) = &self.open
            && *open == common
            && let Some(WorldGeometry::Mesh(whole)) = parts.get_mut(*at).map(|part| &mut part.geometry)
            && append(whole, mesh)
        {
            return Vec::new();
        }
        self.open = Some((common, parts.len()));
        surfaces
    }
}

/// Adds the triangles of a curve to others; `false`, and nothing is done, where they differ in kind or are too many.
fn append(whole: &mut WorldMesh, more: &WorldMesh) -> bool {
    let has_all =
        |m: &WorldMesh| m.normals.len() == m.positions.len() && m.uvs.len() == m.positions.len() && m.colours.is_empty();
    let fits = whole.positions.len() + more.positions.len() <= MOST_VERTICES;
    if whole.flipped != more.flipped || !has_all(whole) || !has_all(more) || !fits {
        return false;
    }
    let first = whole.positions.len() as u32;
    whole.positions.extend_from_slice(&more.positions);
    whole.normals.extend_from_slice(&more.normals);
    whole.uvs.extend_from_slice(&more.uvs);
    whole.triangles.extend(more.triangles.iter().map(|t| t.map(|v| v + first)));
    true
}
