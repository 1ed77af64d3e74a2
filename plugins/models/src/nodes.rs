//! Where everything of a file stands.

use crate::model::Model;
use glam::{DAffine3, DMat3, DMat4, DQuat, DVec3, Quat, Vec3};
use gltf::scene::Transform;

/// A node and where it stands.
#[derive(Clone, Debug)]
pub struct Placed<'m> {
    /// The node.
    pub node: gltf::Node<'m>,
    /// Takes its own coordinates to those of the file.
    pub world_from_node: DAffine3,
}

/// All nodes of the scene that the file shows, parents before their children.
pub struct Nodes<'m> {
    /// The nodes.
    pub placed: Vec<Placed<'m>>,
    /// Nodes that have several parents, or are their own: they stand where they are found first.
    pub repeated: usize,
    /// Nodes whose transform is no transform of space.
    pub bent: usize,
}

/// The nodes of `model`: of the scene that it names, else of its first, else all that no other node has.
pub fn nodes(model: &Model) -> Nodes<'_> {
    let document = &model.document;
    let mut stack: Vec<(gltf::Node, DAffine3)> = match document.default_scene().or_else(|| document.scenes().next()) {
        Some(scene) => scene.nodes().map(|node| (node, DAffine3::IDENTITY)).collect(),
        None => {
            let children: std::collections::HashSet<usize> =
                document.nodes().flat_map(|node| node.children().map(|c| c.index()).collect::<Vec<_>>()).collect();
            document.nodes().filter(|node| !children.contains(&node.index())).map(|node| (node, DAffine3::IDENTITY)).collect()
        }
    };
    stack.reverse();
    let mut found = Nodes { placed: Vec::new(), repeated: 0, bent: 0 };
    let mut seen = vec![false; document.nodes().len()];
    while let Some((node, parent)) = stack.pop() {
        if std::mem::replace(&mut seen[node.index()], true) {
            found.repeated += 1;
            continue;
        }
        let own = transform(&node).unwrap_or_else(|| {
            found.bent += 1;
            DAffine3::IDENTITY
        });
        let world_from_node = parent * own;
        let children: Vec<gltf::Node> = node.children().collect();
        stack.extend(children.into_iter().rev().map(|child| (child, world_from_node)));
        found.placed.push(Placed { node, world_from_node });
    }
    found
}

/// The transform of a node; `None` if it is none of space.
fn transform(node: &gltf::Node) -> Option<DAffine3> {
    let affine = match node.transform() {
        Transform::Matrix { matrix } => {
            let m = DMat4::from_cols_array_2d(&matrix.map(|column| column.map(f64::from)));
            let w = m.w_axis.w;
            let is_affine = [m.x_axis.w, m.y_axis.w, m.z_axis.w].iter().all(|x| *x == 0.0) && w != 0.0;
            let column = |c: glam::DVec4| c.truncate() / w;
            is_affine.then(|| {
                let axes = DMat3::from_cols(column(m.x_axis), column(m.y_axis), column(m.z_axis));
                DAffine3::from_mat3_translation(axes, column(m.w_axis))
            })?
        }
        Transform::Decomposed { translation, rotation, scale } => {
            let q = Quat::from_array(rotation).as_dquat();
            let turned = if q.length_squared() > 0.0 { q.normalize() } else { DQuat::IDENTITY };
            let vec = |v: [f32; 3]| -> DVec3 { Vec3::from_array(v).as_dvec3() };
            DAffine3::from_scale_rotation_translation(vec(scale), turned, vec(translation))
        }
    };
    affine.is_finite().then_some(affine)
}
