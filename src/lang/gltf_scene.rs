//! A whole glTF file as a scene: its cameras, then all that it has.
//!
//! The text that is made here is read as any other scene is. A camera of the file looks along its -z, with y upwards; one of a scene along z. The
//! world is the file's with z turned around, so that pictures show what viewers of glTF show, not mirrored.

use bhs_elementary::Elementary;
use bhs_models::Model;
use bhs_models::gltf::camera::Projection;
use bhs_models::gltf::{Node, Semantic};
use bhs_models::nodes::{Placed, nodes};
use glam::{DAffine3, DMat3, DVec3};
use std::collections::BTreeSet;
use std::fmt::Write;
use std::path::Path;

/// Rows of a picture, where the file's camera states its shape.
const HEIGHT: f64 = 480.0;
/// Field of view of a camera that is made for a file without one (degrees).
const FIELD: f64 = 40.0;
/// Where that stands, seen from the middle: before the model, which looks along +z, a little above and beside it.
const BESIDE: DVec3 = DVec3::new(0.5, 0.35, 1.0);

/// The text of a scene.
pub struct GltfScene {
    /// What is to be read.
    pub text: String,
    /// What is to be said of it, in words.
    pub notes: Vec<String>,
}

/// Whether the name of a file says that it is glTF.
pub fn is_gltf_file(path: &Path) -> bool {
    path.extension().is_some_and(|e| e.eq_ignore_ascii_case("gltf") || e.eq_ignore_ascii_case("glb"))
}

/// The scene of the file called `name`, which holds `bytes`.
///
/// # Errors
/// What is wrong with it, in words.
pub fn scene(name: &str, bytes: &[u8]) -> Result<GltfScene, String> {
    let model = Model::parse(bytes)?;
    let nodes = nodes(&model).placed;
    let mut notes = Vec::new();
    let mut text = format!("# {}, as a scene\n", name.replace(['\n', '\r'], " "));
    let cameras: Vec<(&Placed, bhs_models::gltf::Camera)> = nodes.iter().filter_map(|p| Some((p, p.node.camera()?))).collect();
    let aspects = cameras.iter().filter_map(|(_, camera)| match camera.projection() {
        Projection::Perspective(p) => p.aspect_ratio().map(f64::from),
        Projection::Orthographic(o) => Some(f64::from(o.xmag()) / f64::from(o.ymag())),
    });
    let aspect = aspects.filter(|a| (0.05..=20.0).contains(a)).collect::<Vec<_>>().first().copied();
    if let Some(aspect) = aspect {
        let width = (HEIGHT * aspect).round().max(1.0);
        let _ = writeln!(text, "Film \"rgb\" \"integer xresolution\" {width} \"integer yresolution\" {HEIGHT}");
    }
    let (mut names, mut has_camera) = (BTreeSet::new(), false);
    for (placed, camera) in &cameras {
        let name = unique(&placed.node, camera.name(), camera.index(), &mut names);
        // The longer side may be upright.
        let shape = aspect.unwrap_or(4.0 / 3.0);
        let parameters = match camera.projection() {
            Projection::Perspective(p) => {
                let half = (f64::from(p.yfov()) / 2.0).tangent() * shape.min(1.0);
                let field = (2.0 * half.arctangent()).to_degrees();
                let field = if field.is_finite() { field.clamp(0.01, 179.0) } else { FIELD };
                format!("\"perspective\" \"string name\" \"{name}\" \"float fov\" {field}")
            }
            Projection::Orthographic(o) => {
                let size = |x: f32| if x.is_finite() { f64::from(x).abs().clamp(1e-6, 1e9) } else { 1.0 };
                let (x, y) = (size(o.xmag()), size(o.ymag()));
                format!("\"orthographic\" \"string name\" \"{name}\" \"float screenwindow\" [-{x} {x} -{y} {y}]")
            }
        };
        let Some(view) = camera_from_world(&placed.world_from_node) else {
            notes.push(format!("its camera `{name}` looks nowhere, and is left out"));
            continue;
        };
        has_camera = true;
        let _ = writeln!(text, "Transform [{}]\nCamera {parameters}", numbers(&view));
    }
    if !has_camera {
        notes.push("it has no camera: one that looks at the whole is made".to_owned());
        text += &looking_at_all(&nodes);
    }
    text += "WorldBegin\n";
    if !has_light(&nodes) {
        notes.push("it has no light: an even white sky is made".to_owned());
        text += "LightSource \"infinite\" \"rgb L\" [1 1 1]\n";
    }
    let file = Path::new(name).file_name().map_or(name.into(), |file| file.to_string_lossy());
    let _ = writeln!(text, "Shape \"gltf\" \"string filename\" \"{}\"", quoted(&file));
    Ok(GltfScene { text, notes })
}

fn quoted(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "\\\"").chars().filter(|c| !c.is_control()).collect()
}

/// A name for a camera: that of its node, else its own, else its number; once.
fn unique(node: &Node, own: Option<&str>, index: usize, names: &mut BTreeSet<String>) -> String {
    let name = node.name().or(own).filter(|n| !n.trim().is_empty()).map_or_else(|| format!("camera {index}"), quoted);
    let taken = |names: &BTreeSet<String>, name: &str| names.contains(name);
    let free = if taken(names, &name) {
        (2u32..).map(|i| format!("{name} {i}")).find(|n| !taken(names, n)).unwrap_or_default()
    } else {
        name
    };
    names.insert(free.clone());
    free
}

/// Takes the scene's coordinates to those of a camera that stands so in the file; scales do not count.
fn camera_from_world(world_from_node: &DAffine3) -> Option<DAffine3> {
    let turn = DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0));
    let m = world_from_node.matrix3;
    let axes = [m.x_axis, m.y_axis, m.z_axis].map(|axis| axis.try_normalize());
    let [Some(x), Some(y), Some(z)] = axes else { return None };
    let world_from_camera =
        DAffine3::from_mat3_translation(turn * DMat3::from_cols(x, y, z) * turn, turn * world_from_node.translation);
    let inverse = world_from_camera.inverse();
    inverse.is_finite().then_some(inverse)
}

fn numbers(t: &DAffine3) -> String {
    let columns = [(t.matrix3.x_axis, 0), (t.matrix3.y_axis, 0), (t.matrix3.z_axis, 0), (t.translation, 1)];
    let column = |(c, w): (DVec3, i32)| format!("{} {} {} {w}", c.x, c.y, c.z);
    columns.map(column).join("  ")
}

/// Whether something of the file is meant to light it: viewers of glTF light no surface by another one, so that small lamps on models are mostly
/// as bright as a white sheet at most, and what is to light a room is brighter.
fn has_light(nodes: &[Placed]) -> bool {
    let lights = |material: bhs_models::gltf::Material| material.emissive_strength().is_some_and(|s| s > 1.0);
    let shines = |p: &Placed| p.node.mesh().is_some_and(|mesh| mesh.primitives().any(|part| lights(part.material())));
    nodes.iter().any(|p| p.node.light().is_some() || shines(p))
}

/// A camera that sees all that the accessors of the meshes say that they reach to.
fn looking_at_all(nodes: &[Placed]) -> String {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for placed in nodes {
        let Some(mesh) = placed.node.mesh() else { continue };
        for primitive in mesh.primitives() {
            let Some(accessor) = primitive.get(&Semantic::Positions) else { continue };
            let corner = |value: Option<bhs_models::gltf::json::Value>| {
                let value = value?;
                let of = |i: usize| value.get(i).and_then(|x| x.as_f64());
                Some(DVec3::new(of(0)?, of(1)?, of(2)?)).filter(|p| p.is_finite())
            };
            let (Some(min), Some(max)) = (corner(accessor.min()), corner(accessor.max())) else { continue };
            // Whole numbers that stand for those between -1 and 1.
            let scale = if accessor.normalized() { 1.0 / f64::from(normalizer(accessor.data_type())) } else { 1.0 };
            for i in 0..8 {
                let pick = |bit: usize, a: f64, b: f64| if i & bit == 0 { a } else { b };
                let corner = DVec3::new(pick(1, min.x, max.x), pick(2, min.y, max.y), pick(4, min.z, max.z)) * scale;
                let p = placed.world_from_node.transform_point3(corner);
                if p.is_finite() {
                    (low, high) = (low.min(p), high.max(p));
                }
            }
        }
    }
    let (middle, radius) =
        if low.cmple(high).all() { (0.5 * (low + high), (0.5 * (high - low).length()).max(1e-6)) } else { (DVec3::ZERO, 1.0) };
    let distance = 1.05 * radius / (FIELD.to_radians() / 2.0).sine();
    let eye = middle + BESIDE.normalize() * distance;
    let point = |p: DVec3| format!("{} {} {}", p.x, p.y, -p.z);
    format!("LookAt {}  {}  0 1 0\nCamera \"perspective\" \"float fov\" {FIELD}\n", point(eye), point(middle))
}

fn normalizer(ty: bhs_models::gltf::accessor::DataType) -> f32 {
    use bhs_models::gltf::accessor::DataType;
    match ty {
        DataType::I8 => 127.0,
        DataType::U8 => 255.0,
        DataType::I16 => 32767.0,
        DataType::U16 => 65535.0,
        DataType::U32 | DataType::F32 => 1.0,
    }
}
