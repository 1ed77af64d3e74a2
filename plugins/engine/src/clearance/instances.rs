//! What instances take up of the grid of free space: the triangles of an object are looked at once, in a grid of its own, and the cells
//! that it fills there are carried to wherever it stands.

use crate::clearance::Clearance;
use bhs_core::geometry::instance::Instance;
use bhs_core::geometry::{Aabb, Geometry, TriangleMesh};
use glam::DVec3;
use std::collections::HashMap;

/// Cells of an object's own grid in one of the scene's, and the most of them along its longest side.
const FINER: f64 = 2.0;
const MOST_CELLS: f64 = 128.0;

/// The part of space that a mesh of an object takes up, in the object's coordinates.
struct Filled {
    /// Middles of boxes that hold all of it.
    middles: Vec<DVec3>,
    /// Half the sides of each.
    half: DVec3,
}

/// Meshes of objects by their place in memory: how large (scene units) the largest instance of each is, and what it takes up once
/// that has been found out.
pub(crate) struct Objects {
    meshes: HashMap<*const TriangleMesh, (f64, Option<Filled>)>,
}

impl Objects {
    /// Those of `geometries`.
    pub(crate) fn new(geometries: &[Geometry]) -> Self {
        let mut meshes = HashMap::new();
        for geometry in geometries {
            if let Geometry::Instance(instance) = geometry {
                let b = instance.bounds();
                let (size, _) = meshes.entry(key(instance)).or_insert((0.0, None));
                *size = f64::max(*size, (b.max - b.min).max_element());
            }
        }
        Self { meshes }
    }

    /// Boxes that together hold the instance (render space), in a grid the cells of which have the side `cell`; `None` where it takes
    /// too long to tell.
    pub(crate) fn boxes(&mut self, instance: &Instance, cell: f64) -> Option<impl Iterator<Item = Aabb> + '_> {
        let (size, filled) = self.meshes.get_mut(&key(instance))?;
        if filled.is_none() {
            let cells = (FINER * *size / cell).ceil().clamp(1.0, MOST_CELLS);
            *filled = Some(Filled::new(instance, cells)?);
        }
        let filled = filled.as_ref()?;
        let t = *instance.render_from_own();
        let m = t.matrix3;
        let half = m.x_axis.abs() * filled.half.x + m.y_axis.abs() * filled.half.y + m.z_axis.abs() * filled.half.z;
        Some(filled.middles.iter().map(move |middle| {
            let middle = t.transform_point3(*middle);
            Aabb { min: middle - half, max: middle + half }
        }))
    }
}

fn key(instance: &Instance) -> *const TriangleMesh {
    std::sync::Arc::as_ptr(instance.mesh())
}

impl Filled {
    fn new(instance: &Instance, cells: f64) -> Option<Self> {
        let mesh = Geometry::Mesh(instance.mesh().clone());
        let bounds = mesh.bounds();
        match Clearance::marked(&[mesh], &bounds, cells)? {
            Some(grid) => Some(Self { half: DVec3::splat(0.5 * grid.cell()), middles: grid.marked_cells().collect() }),
            // Of no size that could be divided.
            None if bounds.is_empty() => Some(Self { half: DVec3::ZERO, middles: Vec::new() }),
            None => Some(Self { half: 0.5 * (bounds.max - bounds.min), middles: vec![bounds.center()] }),
        }
    }
}
