//! The triangles of a primitive.

use crate::accessor::{floats, indices};
use crate::model::{Model, ReadFile};
use bhs_core::geometry::WorldMesh;
use glam::{DVec3, Vec3};
use gltf::mesh::{Mode, Primitive, Semantic};

/// Whether a primitive has triangles that can be read; else what the picture lacks.
///
/// # Errors
/// What it has in place of them.
pub fn readable(primitive: &Primitive) -> Result<(), &'static str> {
    if primitive.extension_value("KHR_draco_mesh_compression").is_some()
        && primitive.get(&Semantic::Positions).is_none_or(|a| a.view().is_none())
    {
        return Err("compressed by Draco");
    }
    let compressed = |view: gltf::buffer::View| view.extension_value("EXT_meshopt_compression").is_some();
    if primitive.get(&Semantic::Positions).and_then(|a| a.view()).is_some_and(compressed) {
        return Err("compressed by meshopt");
    }
    match primitive.mode() {
        Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan => Ok(()),
        Mode::Points => Err("points, which have no surface"),
        _ => Err("lines, which have no surface"),
    }
}

/// What of a primitive is read besides its shape.
#[derive(Clone, Copy, Debug, Default)]
pub struct Attributes {
    /// The set of texture coordinates that is the mesh's first.
    pub uv_set: u32,
    /// The one that is its second.
    pub second_uv_set: Option<u32>,
    /// Whether the tangents of a file count.
    pub tangents: bool,
}

/// The triangles of primitive number `primitive` of mesh number `mesh`, in the file's coordinates; texture coordinates have v upwards. A normal that is no direction is zero.
///
/// # Errors
/// What is wrong with it, in words that can follow "cannot read `file`: ".
pub fn triangles(model: &Model, mesh: usize, primitive: usize, with: Attributes, read: ReadFile) -> Result<WorldMesh, String> {
    let meshes = model.document.meshes().len();
    let of_mesh =
        model.document.meshes().nth(mesh).ok_or_else(|| format!("it has no mesh {mesh}: it has {meshes}, counted from 0"))?;
    let name = of_mesh.name().map_or(String::new(), |name| format!(" `{}`", crate::model::shown(name)));
    let place = format!("mesh {mesh}{name}, primitive {primitive}");
    let Some(primitive) = of_mesh.primitives().nth(primitive) else { return Err(format!("it has no {place}")) };
    readable(&primitive).map_err(|what| format!("{place} is {what}"))?;
    read_primitive(model, &primitive, with, read).map_err(|fault| format!("{place}: {fault}"))
}

fn read_primitive(model: &Model, primitive: &Primitive, with: Attributes, read: ReadFile) -> Result<WorldMesh, String> {
    let Some(accessor) = primitive.get(&Semantic::Positions) else { return Err("it has no positions".to_owned()) };
    let positions = floats::<3>(model, &accessor, 0.0, read)?;
    let count = positions.len();
    let corners = match primitive.indices() {
        Some(accessor) => indices(model, &accessor, read)?,
        None => (0..u32::try_from(count).map_err(|_| "it has too many vertices")?).collect(),
    };
    if let Some(index) = corners.iter().find(|index| **index as usize >= count) {
        return Err(format!("a triangle has vertex {index}, and there are {count}, counted from 0"));
    }
    let is_finite = |index: &u32| positions[*index as usize].iter().all(|x| x.is_finite());
    if let Some(index) = corners.iter().find(|index| !is_finite(index)) {
        return Err(format!("vertex {index} has a coordinate that is not a finite number"));
    }
    let attribute = |semantic: &Semantic, what: &str| match primitive.get(semantic) {
        Some(accessor) if accessor.count() != count => Err(format!("its {what} are not as many as its positions")),
        other => Ok(other),
    };
    let normals = match attribute(&Semantic::Normals, "normals")? {
        Some(accessor) => floats::<3>(model, &accessor, 0.0, read)?,
        None => Vec::new(),
    };
    let set = |set: u32| match attribute(&Semantic::TexCoords(set), "texture coordinates")? {
        Some(accessor) => floats::<2>(model, &accessor, 0.0, read),
        None => Ok(Vec::new()),
    };
    let uvs = set(with.uv_set)?;
    let second_uvs = with.second_uv_set.map_or(Ok(Vec::new()), set)?;
    // Without normals they mean nothing (glTF 2.0, section 3.7.2.1).
    let tangents = match attribute(&Semantic::Tangents, "tangents")?.filter(|_| with.tangents && !normals.is_empty()) {
        Some(accessor) => floats::<4>(model, &accessor, 1.0, read)?,
        None => Vec::new(),
    };
    let numbers = [uvs.as_flattened(), second_uvs.as_flattened(), tangents.as_flattened()];
    let colours = match attribute(&Semantic::Colors(0), "colours")? {
        Some(accessor) => floats::<4>(model, &accessor, 1.0, read)?,
        None => Vec::new(),
    };
    if !numbers.into_iter().flatten().chain(colours.as_flattened()).all(|x| x.is_finite()) {
        return Err("a texture coordinate, a tangent or a colour is not a finite number".to_owned());
    }
    Ok(WorldMesh {
        positions: positions.into_iter().map(|p| DVec3::from_array(p.map(f64::from))).collect(),
        triangles: joined(&corners, primitive.mode()),
        normals: normals.into_iter().map(|n| Vec3::from_array(n).try_normalize().unwrap_or_default().to_array()).collect(),
        uvs: upwards(uvs),
        second_uvs: upwards(second_uvs),
        tangents,
        colours,
        flipped: false,
    })
}

/// Texture coordinates with v upwards.
fn upwards(mut uvs: Vec<[f32; 2]>) -> Vec<[f32; 2]> {
    uvs.iter_mut().for_each(|[_, v]| *v = 1.0 - *v);
    uvs
}

/// The triangles that a sequence of vertices stands for (glTF 2.0, section 3.7.2.1).
fn joined(v: &[u32], mode: Mode) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            v.windows(3).enumerate().map(|(i, t)| if i % 2 == 0 { [t[0], t[1], t[2]] } else { [t[0], t[2], t[1]] }).collect()
        }
        Mode::TriangleFan => v.get(1..).unwrap_or_default().windows(2).map(|t| [t[0], t[1], v[0]]).collect(),
        _ => v.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}
