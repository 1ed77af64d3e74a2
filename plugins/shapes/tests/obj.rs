//! OBJ files: what is read of them, and what is said of faulty ones.

mod common;

use bhs_shapes::obj;
use common::{Memory, Place, text};
use glam::DVec3;
use proptest::prelude::*;

const CUBE_CORNER: &str = "# three sides
mtllib none.mtl
o corner
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1e0
v 1 1 0
vt 0 0
vt 1 0
vt 0 1
vn 0 0 2
g front
usemtl red
s off
f 1/1/1 2/2/1 5/3/1 3/3/1
g side
l 1 2 3
p 1
f -5/1/1 \\
  -2/2/1 -3/3/1
";

#[test]
fn faces_of_all_groups_make_one_mesh() {
    let read = obj::read(CUBE_CORNER.as_bytes()).expect("it is read");
    assert!(read.partial.is_empty());
    let corners: Vec<[DVec3; 3]> = read.mesh.triangles.iter().map(|t| t.map(|v| read.mesh.positions[v as usize])).collect();
    let (o, x, y, z, xy) = (DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 1.0, 0.0));
    // A line is no face.
    assert_eq!(corners, [[o, x, xy], [o, xy, y], [o, z, y]]);
    assert!(read.mesh.normals.iter().all(|n| *n == [0.0, 0.0, 1.0]) && read.mesh.normals.len() == read.mesh.positions.len());
    let last = read.mesh.triangles[2].map(|v| read.mesh.uvs[v as usize]);
    assert_eq!(last, [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]]);
}

#[test]
fn it_makes_the_same_mesh_as_the_vertices_in_the_scene() {
    let files = Memory(vec![("a.obj", b"v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n".to_vec())]);
    let place = Place { files, ..Place::default() };
    let mesh = place.mesh("objmesh", &[text("filename", "a.obj")]);
    assert_eq!((mesh.positions, mesh.triangles), (vec![DVec3::ZERO, DVec3::X, DVec3::Y], vec![[0, 1, 2]]));
}

#[test]
fn what_some_corners_lack_is_left_out_and_told() {
    let file = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2/1/1 3/1/1\nf 1//1 3//1 2//1\n";
    let read = obj::read(file.as_bytes()).expect("it is read");
    assert_eq!(read.partial, ["texture coordinates"]);
    assert!(read.mesh.uvs.is_empty() && read.mesh.normals.len() == read.mesh.positions.len());
    let place = Place { files: Memory(vec![("a.obj", file.into())]), ..Place::default() };
    let said = place.faults("objmesh", &[text("filename", "a.obj")]);
    assert_eq!(said, ["the texture coordinates of `a.obj` are left out: some corners of faces have none"]);
}

#[test]
fn faults_are_told_with_their_line() {
    let check = |file: &str, expected: &str| assert_eq!(obj::read(file.as_bytes()).unwrap_err(), expected, "{file}");
    let three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    check("", "it holds no triangle");
    check(three, "it holds no triangle");
    check("# only a comment", "it holds no triangle; it is text, and no mesh that is known");
    check("<!DOCTYPE html>\n", "it holds no triangle; it is a web page: download the file itself, not the page that shows it");
    check("v 0 0\n", "line 1: `v` needs three numbers, and takes one or three more");
    check("# ...\n\nv 0 0 x\n", "line 3: `v` needs three numbers, and takes one or three more");
    check("v 0 0 0 0\n", "line 1: the fourth number of `v` is 0");
    check("v 0 0 0 1 2\n", "line 1: `v` takes one more number, or three");
    check("vn 0 0\n", "line 1: `vn` needs three numbers");
    check("vt\n", "line 1: `vt` needs one to three numbers");
    check("vt 0 0 0 0\n", "line 1: `vt` needs one to three numbers");
    check(&format!("{three}f 1 2 a\n"), "line 4: a corner of a face is a number of a vertex, as in 3, 3/1, 3//2 or 3/1/2");
    check(&format!("{three}f 1 2 3/1/1/1\n"), "line 4: a corner of a face is a number of a vertex, as in 3, 3/1, 3//2 or 3/1/2");
    check(&format!("{three}f 1 2 4\n"), "line 4: a face uses a vertex that does not exist (4)");
    check(&format!("{three}f 1 2 0\n"), "line 4: a face uses a vertex that does not exist (0)");
    check(&format!("{three}f 1 2 -4\n"), "line 4: a face uses a vertex that does not exist (-4)");
    check(&format!("{three}vt 0 0\nf 1/1 2/1 3/2\n"), "line 5: a face uses texture coordinates that do not exist (2)");
    check(&format!("{three}vn 0 0 1\nf 1//1 2//1 3//2\n"), "line 5: a face uses a normal that does not exist (2)");
    check(&format!("{three}f 1 2 9223372036854775808\n"), "line 4: a number of a vertex is too large");
    check(&format!("{three}f\n"), "line 4: a face has no corners");
    let fault = "line 4: a face uses vertex 1, which has a coordinate that is not a finite number";
    check("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3", fault);
    check("v 0 0 1.#QNAN\rv 1 0 0\rv 0 1 0\rf 1 2 3", fault);
    check("\u{feff}v 0 0\n", "line 1: `v` needs three numbers, and takes one or three more");
    check(
        &format!("{three}vt 1e300 0\nf 1/1 2/1 3/1\n"),
        "line 5: a texture coordinate is not a finite number of single precision",
    );
    let binary = [b"v 0 0 0\nv \xff".as_slice(), b" 0 0\n"].concat();
    assert_eq!(obj::read(&binary).unwrap_err(), "line 2: `v` needs three numbers, and takes one or three more");
    assert_eq!(obj::read(b"\xff\xfev\0 \x000\0").unwrap_err(), "it is text in UTF-16: save it as UTF-8 or ASCII");
}

/// Area of the triangles of a file.
fn area(file: &[u8]) -> f64 {
    let read = obj::read(file).unwrap_or_else(|e| panic!("{}: {e}", String::from_utf8_lossy(file)));
    let corner = |v: u32| read.mesh.positions[v as usize];
    read.mesh.triangles.iter().map(|t| 0.5 * (corner(t[1]) - corner(t[0])).cross(corner(t[2]) - corner(t[0])).length()).sum()
}

#[test]
fn every_program_s_way_of_writing_a_square_is_read() {
    let corners = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n";
    let table: &[(&str, String)] = &[
        ("byte order mark, first line a vertex", format!("\u{feff}{corners}v 0 0 0\nf 1 2 3 4\n")),
        ("CRLF", format!("{corners}f 1 2 3 4\n").replace('\n', "\r\n")),
        ("CR", format!("{corners}f 1 2 3 4\n").replace('\n', "\r")),
        ("no end of the last line", format!("{corners}f 1 2 3 4")),
        ("comments in lines", format!("{corners}f 1 2 3 4 # the face\n").replace("-1 0\n", "-1 0 # low\n")),
        ("a comment that ends as a folder", format!("# C:\\models\\\n{corners}f 1 2 3 4\n")),
        ("names that end as a folder", format!("mtllib C:\\m\\\n{corners}g a\\\nf 1 2 3 4\n")),
        ("lines that go on", format!("{corners}f 1 2 \\\r\n 3 \\ # why not\n4\n").replace("v 1 1 0", "v 1 \\\n1 0")),
        ("one texture coordinate", format!("{corners}vt 0\nvt 1\nf 1/1 2/2 3/2 4/1\n")),
        ("three texture coordinates", format!("{corners}vt 0 0 0\nf 1/1 2/1 3/1 4/1\n")),
        ("slashes without numbers", format!("{corners}f 1/ 2// 3/ 4//\n")),
        ("vertex colours", format!("{corners}f 1 2 3 4\n").replace("0\nv", "0 0.5 0.25 1\nv")),
        ("vertex colours with opacity", format!("{corners}f 1 2 3 4\n").replace("0\nv", "0 0.5 0.25 1 1\nv")),
        ("weights", format!("{corners}f 1 2 3 4\n").replace("v 1 1 0", "v 2 2 0 2")),
        ("negative numbers", format!("{corners}f -4 -3 -2 -1\n")),
        ("faces first", format!("f 1 2 3 4\n{corners}")),
        ("a vertex without a place, unused", format!("{corners}v nan nan 1.#IND\nf 1 2 3 4\n")),
        ("numbers with signs and exponents", format!("{corners}f +1 2 3 4\n").replace("v 1 1 0", "v +1.0e0 1.d0 -0.0")),
        ("lines and points", format!("{corners}p 1\nl 1 2\nf 1\nf 1 2\nf 1 2 3 4\n")),
        ("free forms", format!("{corners}cstype bezier\ndeg 3\nvp 0 0\ncurv 0 1 1 2\nend\nf 1 2 3 4\n")),
    ];
    for (name, file) in table {
        assert_eq!(area(file.as_bytes()), 4.0, "{name}:\n{file}");
    }
    assert_eq!(area(&[b"# caf\xe9\no \xff\n".as_slice(), corners.as_bytes(), b"f 1 2 3 4 # \xe9\n"].concat()), 4.0);
}

#[test]
fn a_corner_without_a_normal_takes_that_of_its_face() {
    let corners = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\n";
    // The face as such looks along +z, its normals the other way.
    for none in ["-nan(ind) -nan(ind) -nan(ind)", "nan 0 0", "0 0 0", "1.#QNAN 1.#QNAN 1.#QNAN", "inf 0 0"] {
        let file = format!("{corners}vn {none}\nvn 0 0 -2\nf 1//1 2//2 3//2 4//2\n");
        let read = obj::read(file.as_bytes()).expect("it is read");
        assert_eq!(read.mesh.normals, [[0.0, 0.0, -1.0]; 4], "{none}");
        let file = format!("{corners}vn {none}\nf 1//1 2//1 3//1 4//1\n");
        let read = obj::read(file.as_bytes()).expect("it is read");
        assert_eq!(read.mesh.normals, [[0.0, 0.0, 1.0]; 4], "{none}");
    }
    let file = format!("{corners}vn 0 0 1\nf 1//1 2 3//1\nf 1 3 4\n");
    assert!(obj::read(file.as_bytes()).expect("it is read").mesh.normals.iter().all(|n| *n == [0.0, 0.0, 1.0]));
}

#[test]
fn polygons_need_not_be_convex() {
    let l = "v -1 -1 0\nv 1 -1 0\nv 1 0 0\nv 0 0 0\nv 0 1 0\nv -1 1 0\n";
    let arrow = "v 0 -1 0\nv 1 1 0\nv 0 0 0\nv -1 1 0\n";
    for (corners, n, wanted) in [(l, 6, 3.0), (arrow, 4, 1.0)] {
        for first in 0..n {
            let face: String = (0..n).map(|i| format!(" {}", (first + i) % n + 1)).collect();
            let file = format!("{corners}f{face}\n");
            assert_eq!(area(file.as_bytes()), wanted, "{face}");
            let mesh = obj::read(file.as_bytes()).expect("it is read").mesh;
            let corner = |v: u32| mesh.positions[v as usize];
            let fronts = mesh.triangles.iter().map(|t| (corner(t[1]) - corner(t[0])).cross(corner(t[2]) - corner(t[0])).z);
            assert!(fronts.into_iter().all(|z| z > 0.0), "{face}");
        }
    }
}

#[test]
fn faces_of_one_material_are_a_mesh_of_their_own() {
    let file = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 4\nusemtl red wood\nf 1 2 3\nusemtl blue\nf 1 4 2 3\nusemtl none\nusemtl red wood\nf 4 2 3\n";
    let read = obj::parse(file.as_bytes()).expect("it is read");
    assert_eq!(read.groups(), ["", "red wood", "blue"]);
    let place = Place { files: Memory(vec![("a.obj", file.into())]), ..Place::default() };
    let build = |group: &str| place.build("objmesh", &[text("filename", "a.obj"), text("group", group)]);
    let triangles = |group: &str| match build(group) {
        (Some(bhs_core::geometry::WorldGeometry::Mesh(mesh)), said) if said.is_empty() => {
            (mesh.triangles.len(), mesh.positions.len())
        }
        (_, said) => panic!("{said:?}"),
    };
    // A vertex that two faces share is one, and those of other groups are not there.
    assert_eq!([triangles(""), triangles("red wood")], [(1, 3), (2, 4)]);
    assert_eq!(build("blue").1, ["faces of `a.obj` cross themselves, and are taken for fans of triangles: 1"]);
    let fault = "cannot read `a.obj`: no face has the material `none` (`usemtl`); there is ``, `red wood`, `blue`";
    assert_eq!(build("none").1, [fault]);
    let (whole, said) = place.build("objmesh", &[text("filename", "a.obj")]);
    assert!(matches!(whole, Some(bhs_core::geometry::WorldGeometry::Mesh(mesh)) if mesh.triangles.len() == 5) && said.len() == 1);
}

#[test]
fn the_files_of_materials_are_named() {
    let named = |file: &str| {
        obj::parse(format!("{file}\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").as_bytes()).expect("it is read").libraries
    };
    assert_eq!(named("mtllib my scene.mtl"), ["my scene.mtl"]);
    assert_eq!(named("mtllib a.mtl b.mtl\r\nmtllib  c.mtl "), ["a.mtl b.mtl", "c.mtl"]);
    assert!(named("# mtllib a.mtl").is_empty());
}

#[test]
fn faults_of_an_objmesh_are_told() {
    let place = Place { files: Memory(vec![("a.obj", b"f 1 2 3".to_vec())]), ..Place::default() };
    let said = |name: &str| place.faults("objmesh", &[text("filename", name)]);
    assert_eq!(said("a.obj"), ["cannot read `a.obj`: line 1: a face uses a vertex that does not exist (1)"]);
    assert_eq!(said("b.obj"), ["cannot read `b.obj`: no such file"]);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_bytes_make_the_reader_panic(edits in prop::collection::vec((any::<prop::sample::Index>(), 0usize..4, any::<u8>()), 0..12)) {
        let mut file = CUBE_CORNER.as_bytes().to_vec();
        for (at, what, byte) in edits {
            let at = at.index(file.len());
            match what {
                0 => file[at] = byte,
                1 => file[at] = b"-/0 9\n\\e."[usize::from(byte) % 9],
                2 => file.insert(at, b"-/0 9\n\\e."[usize::from(byte) % 9]),
                _ => { file.remove(at); }
            }
        }
        if let Ok(read) = obj::read(&file) {
            let n = read.mesh.positions.len();
            prop_assert!(read.mesh.triangles.iter().flatten().all(|v| (*v as usize) < n));
            prop_assert!([0, n].contains(&read.mesh.normals.len()) && [0, n].contains(&read.mesh.uvs.len()));
        }
    }
}
