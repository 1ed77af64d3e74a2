//! Tangents for normal maps, where a file brings none.
//!
//! They are those of MikkTSpace, by which programs bake normal maps (glTF 2.0, section 3.7.2.1; Mikkelsen 2008, "Simulation of Wrinkled
//! Surfaces Revisited"), made by the crate `bevy_mikktspace`.

use bevy_mikktspace::{Geometry, TangentSpace, generate_tangents};
use bhs_core::geometry::WorldMesh;
use std::collections::HashMap;

/// A mesh and the tangents of the corners of its triangles, as far as they are known.
struct Corners<'m> {
    mesh: &'m WorldMesh,
    uvs: &'m [[f32; 2]],
    tangents: Vec<[[f32; 4]; 3]>,
}

impl Corners<'_> {
    fn vertex(&self, face: usize, corner: usize) -> usize {
        self.mesh.triangles[face][corner] as usize
    }
}

impl Geometry for Corners<'_> {
    fn num_faces(&self) -> usize {
        self.mesh.triangles.len()
    }

    fn num_vertices_of_face(&self, _: usize) -> usize {
        3
    }

    fn position(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.positions[self.vertex(face, corner)].as_vec3().to_array()
    }

    fn normal(&self, face: usize, corner: usize) -> [f32; 3] {
        self.mesh.normals[self.vertex(face, corner)]
    }

    fn tex_coord(&self, face: usize, corner: usize) -> [f32; 2] {
        self.uvs[self.vertex(face, corner)]
    }

    fn set_tangent(&mut self, found: Option<TangentSpace>, face: usize, corner: usize) {
        self.tangents[face][corner] = found.unwrap_or_default().tangent_encoded();
    }
}

/// Gives the vertices of a mesh tangents by its first or second set of texture coordinates; a vertex in which several meet becomes several. Nothing
/// happens to a mesh that has tangents, and to one without normals or texture coordinates: its triangles have those of their own.
pub fn fill(mesh: &mut WorldMesh, by_second: bool) {
    let uvs = if by_second && !mesh.second_uvs.is_empty() { &mesh.second_uvs } else { &mesh.uvs };
    if !mesh.tangents.is_empty() || mesh.normals.is_empty() || uvs.is_empty() {
        return;
    }
    let mut corners = Corners { mesh, uvs, tangents: vec![[[1.0, 0.0, 0.0, 1.0]; 3]; mesh.triangles.len()] };
    // It has no error to tell.
    if generate_tangents(&mut corners).is_err() {
        return;
    }
    let of_corners = corners.tangents;
    let mut tangents: Vec<Option<[f32; 4]>> = vec![None; mesh.positions.len()];
    let mut copies: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
    for (triangle, found) in mesh.triangles.iter_mut().zip(of_corners) {
        for (corner, tangent) in triangle.iter_mut().zip(found) {
            let v = *corner as usize;
            if *tangents[v].get_or_insert(tangent) == tangent {
                continue;
            }
            let Ok(next) = u32::try_from(mesh.positions.len()) else { continue };
            let copy = *copies.entry((*corner, tangent.map(f32::to_bits))).or_insert(next);
            if copy == next {
                mesh.positions.push(mesh.positions[v]);
                mesh.normals.push(mesh.normals[v]);
                for of_vertices in [&mut mesh.uvs, &mut mesh.second_uvs].into_iter().filter(|all| !all.is_empty()) {
                    of_vertices.push(of_vertices[v]);
                }
                if !mesh.colours.is_empty() {
                    mesh.colours.push(mesh.colours[v]);
                }
                tangents.push(Some(tangent));
            }
            *corner = copy;
        }
    }
    mesh.tangents = tangents.into_iter().map(|t| t.unwrap_or([1.0, 0.0, 0.0, 1.0])).collect();
}
