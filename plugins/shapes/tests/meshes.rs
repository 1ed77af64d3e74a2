//! Triangle meshes: parameters, transforms, and which side is out.

mod common;

use bhs_core::geometry::WorldMesh;
use bhs_core::value::{Param, ParamType};
use common::{Memory, Place, near, numbers, text};
use glam::{DAffine3, DMat3, DVec2, DVec3};

const CORNERS: [f64; 9] = [1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0, 3.0];

fn triangle() -> Vec<Param> {
    vec![numbers(ParamType::Point3, "P", &CORNERS)]
}

fn normal(mesh: &WorldMesh) -> DVec3 {
    let (mesh, dropped) = mesh.clone().rebase(DVec3::ZERO);
    assert_eq!(dropped, 0);
    mesh.surface(0, DVec2::new(0.3, 0.3)).normal
}

/// The normal of the triangle in its own coordinates.
fn own_normal() -> DVec3 {
    DVec3::new(6.0, 3.0, 2.0).normalize()
}

fn transforms() -> Vec<DAffine3> {
    let turned = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.8);
    let slanted = DMat3::from_cols(DVec3::new(1.0, 0.3, 0.0), DVec3::new(0.0, 2.0, -0.4), DVec3::new(0.6, 0.0, 0.5));
    vec![
        DAffine3::IDENTITY,
        DAffine3::from_translation(DVec3::new(5.0, -3.0, 1e3)),
        DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0)),
        DAffine3::from_scale(DVec3::new(-1.0, -3.0, 1.0)),
        DAffine3::from_scale(DVec3::new(-2.0, -0.1, -7.0)),
        turned,
        DAffine3::from_mat3(slanted) * turned,
        DAffine3::from_scale(DVec3::new(1.0, 1.0, -1.0)) * DAffine3::from_mat3(slanted),
    ]
}

#[test]
fn the_normal_of_a_face_is_the_transform_of_its_own() {
    for t in transforms() {
        let expected = (t.matrix3.inverse().transpose() * own_normal()).normalize();
        assert!(near(normal(&Place::at(t).mesh("trianglemesh", &triangle())), expected, 1e-6), "{t:?}");
        assert!(near(normal(&Place::at(t).reversed().mesh("trianglemesh", &triangle())), -expected, 1e-6), "{t:?}");
    }
}

#[test]
fn vertex_normals_go_along_and_agree() {
    let n = own_normal() * 7.0;
    let mut params = triangle();
    params.push(numbers(ParamType::Normal, "N", &[n.x, n.y, n.z].repeat(3)));
    for t in transforms() {
        for (place, sign) in [(Place::at(t), 1.0), (Place::at(t).reversed(), -1.0)] {
            let mesh = place.mesh("trianglemesh", &params);
            let expected = (t.matrix3.inverse().transpose() * own_normal()).normalize() * sign;
            for n in &mesh.normals {
                assert!(near(DVec3::from_array(n.map(f64::from)), expected, 1e-6), "{t:?}");
            }
            // The order of the corners says the same as the vertex normals.
            let bare = WorldMesh { normals: Vec::new(), ..mesh };
            assert!(near(normal(&bare), expected, 1e-6));
        }
    }
}

#[test]
fn positions_are_transformed() {
    for t in transforms() {
        let mesh = Place::at(t).mesh("trianglemesh", &triangle());
        for (p, own) in mesh.positions.iter().zip(CORNERS.chunks(3)) {
            assert!(near(*p, t.transform_point3(DVec3::from_slice(own)), 0.0));
        }
    }
}

#[test]
fn a_mesh_may_be_flattened() {
    let mut params = triangle();
    params.push(numbers(ParamType::Normal, "N", &[0.0, 1.0, 0.0].repeat(3)));
    let mesh = Place::at(DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0))).mesh("trianglemesh", &params);
    assert_eq!(mesh.normals, [[0.0, 1.0, 0.0]; 3]);
    assert_eq!(mesh.bounds().max, DVec3::new(1.0, 0.0, 3.0));
}

#[test]
fn indices_and_texture_coordinates() {
    let square = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0];
    let params = [
        numbers(ParamType::Point3, "P", &square),
        numbers(ParamType::Integer, "indices", &[0.0, 1.0, 2.0, 0.0, 2.0, 3.0]),
        numbers(ParamType::Point2, "uv", &[0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 0.5]),
    ];
    let mesh = Place::default().mesh("trianglemesh", &params);
    assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.uvs, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 0.5]]);
}

#[test]
fn texture_coordinates_that_are_not_given_follow_the_order_of_the_corners() {
    // As in pbrt: (0,0) (1,0) (1,1) at the corners as the scene lists them, whatever becomes of the orientation.
    for (place, t) in transforms().into_iter().flat_map(|t| [(Place::at(t), t), (Place::at(t).reversed(), t)]) {
        let (mesh, _) = place.mesh("trianglemesh", &triangle()).rebase(DVec3::ZERO);
        for (corner, uv) in CORNERS.chunks(3).zip([DVec2::ZERO, DVec2::X, DVec2::ONE]) {
            let at = t.transform_point3(DVec3::from_slice(corner)).as_vec3().to_array();
            let weights = [DVec2::ZERO, DVec2::X, DVec2::Y];
            let which = (0..3).find(|i| mesh.positions[mesh.triangles[0][*i] as usize] == at).expect("a corner");
            assert_eq!(mesh.surface(0, weights[which]).uv.as_dvec2(), uv);
        }
    }
}

#[test]
fn faults_of_a_trianglemesh_are_told() {
    let check = |extra: &[Param], expected: &[&str]| {
        let params = [&triangle(), extra].concat();
        assert_eq!(Place::default().faults("trianglemesh", &params), expected);
    };
    let indices = |v: &[f64]| numbers(ParamType::Integer, "indices", v);
    let counted = "there are 3 vertices, counted from 0";
    check(&[indices(&[0.0, 1.0])], &["the number of `indices` is not a multiple of 3: found 2: each triangle takes 3"]);
    check(&[indices(&[])], &["the number of `indices` is not a multiple of 3: found 0: each triangle takes 3"]);
    check(&[indices(&[0.0, 1.0, 2.0, 2.0, 3.0, 1.0])], &[&format!("vertex index 3 of triangle 1 is out of range: {counted}")]);
    check(&[indices(&[0.0, -1.0, 2.0])], &[&format!("vertex index -1 of triangle 0 is out of range: {counted}")]);
    check(
        &[indices(&[0.0, 1e18, 2.0])],
        &[&format!("vertex index 1000000000000000000 of triangle 0 is out of range: {counted}")],
    );
    // All faults at once.
    check(
        &[numbers(ParamType::Normal, "N", &[0.0, 0.0, 1.0]), numbers(ParamType::Point2, "uv", &[0.0, 0.0]), indices(&[0.0])],
        &[
            "the number of `indices` is not a multiple of 3: found 1: each triangle takes 3",
            "`N` does not match `P`: 1 for 3 vertices: one each is needed",
            "`uv` does not match `P`: 1 for 3 vertices: one each is needed",
        ],
    );
    check(
        &[numbers(ParamType::Point2, "uv", &[0.0, 0.0, 1e300, 0.0, 0.0, 1.0])],
        &["`uv` is too large: more than single precision can hold"],
    );

    let two = [numbers(ParamType::Point3, "P", &[0.0; 6])];
    assert_eq!(
        Place::default().faults("trianglemesh", &two),
        ["`indices` can be left out with exactly 3 vertices only, not with 2: which of these make a triangle?"]
    );
    assert_eq!(Place::default().faults("trianglemesh", &[]), ["`trianglemesh` needs the parameter `P`"]);
    let far = Place::at(DAffine3::from_scale(DVec3::splat(1e308)));
    assert_eq!(far.faults("trianglemesh", &triangle()), ["the current transform takes vertex 1 to infinity"]);
}

fn place_with(file: &'static str, content: &str) -> Place {
    Place { files: Memory(vec![(file, content.as_bytes().to_vec())]), ..Place::default() }
}

const HEADER: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n1 0 0\n0 2 0\n0 0 3\n";

#[test]
fn a_ply_file_makes_the_same_mesh() {
    for t in transforms() {
        let mut place = place_with("a.ply", &format!("{HEADER}3 0 1 2\n"));
        place.transform = t;
        let from_file = place.mesh("plymesh", &[text("filename", "a.ply")]);
        assert_eq!(from_file, Place::at(t).mesh("trianglemesh", &triangle()));
    }
}

#[test]
fn faults_of_a_plymesh_are_told() {
    let check = |content: &str, expected: &[&str]| {
        let said = place_with("a.ply", content).build("plymesh", &[text("filename", "a.ply")]).1;
        assert_eq!(said, expected);
    };
    check("", &["cannot read `a.ply`: the file is empty"]);
    check(&format!("{HEADER}2 0 1\n"), &["cannot read `a.ply`: it holds no triangle"]);
    check(
        &format!("{HEADER}4 0 1 2\n"),
        &["cannot read `a.ply`: line 13, face 0 of 1: the line has fewer values than the header announces"],
    );
    check(&format!("{HEADER}3 0 1 2\n3 2 1 0\n"), &["`a.ply` goes on after the last element that its header announces"]);
    let two_faces = HEADER.replace("face 1", "face 2");
    check(&format!("{two_faces}3 0 1 2\n1 0\n"), &["faces of fewer than 3 corners are left out of `a.ply`: 1"]);
    assert_eq!(Place::default().faults("plymesh", &[text("filename", "b.ply")]), ["cannot read `b.ply`: no such file"]);
    assert_eq!(Place::default().faults("plymesh", &[]), ["`plymesh` needs the parameter `filename`"]);
}
