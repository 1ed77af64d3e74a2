//! STL files, binary and ASCII: what is read of them, and what is said of faulty ones.

mod common;

use bhs_shapes::stl;
use common::{Memory, Place, text};
use glam::{DAffine3, DVec3};

/// The corners of a tetrahedron's triangles, seen from outside counter-clockwise.
const TETRAHEDRON: [[[f32; 3]; 3]; 4] = [
    [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]],
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
];

fn binary(header: &str, stated: u32, triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut file = header.as_bytes().to_vec();
    file.resize(80, b' ');
    file.extend(stated.to_le_bytes());
    for triangle in triangles {
        // A normal that is not used, and two bytes of colour.
        file.extend([f32::NAN; 3].iter().chain(triangle.as_flattened()).flat_map(|x| x.to_le_bytes()));
        file.extend([0xff, 0x7f]);
    }
    file
}

fn ascii(triangles: &[[[f32; 3]; 3]]) -> String {
    let vertex = |v: &[f32; 3]| format!("      vertex {:e} {} {}\n", v[0], v[1], v[2]);
    let facet = |t: &[[f32; 3]; 3]| {
        format!("  facet normal 0 0 0\n    outer loop\n{}    endloop\n  endfacet\n", t.iter().map(vertex).collect::<String>())
    };
    format!("solid a name of facets\n{}endsolid a name of facets\n", triangles.iter().map(facet).collect::<String>())
}

fn fault(file: &[u8]) -> String {
    stl::read(file).expect_err("it is at fault")
}

#[test]
fn all_forms_of_a_file_make_the_same_watertight_mesh() {
    let text_form = ascii(&TETRAHEDRON);
    let forms: [(&str, Vec<u8>); 9] = [
        ("binary", binary("made by a program", 4, &TETRAHEDRON)),
        ("binary that begins with solid", binary("solid made by another program", 4, &TETRAHEDRON)),
        ("ASCII", text_form.clone().into_bytes()),
        ("CRLF", text_form.replace('\n', "\r\n").into_bytes()),
        ("CR", text_form.replace('\n', "\r").into_bytes()),
        ("upper case, byte order mark", format!("\u{feff}{}", text_form.to_uppercase()).into_bytes()),
        ("one line after the name", text_form.replacen('\n', "\u{1}", 1).replace('\n', " ").replace('\u{1}', "\n").into_bytes()),
        ("several solids", (ascii(&TETRAHEDRON[..2]) + &ascii(&TETRAHEDRON[2..])).into_bytes()),
        (
            "normals that are no numbers, no end",
            text_form.replace("normal 0 0 0", "normal nan nan nan").split("endsolid").next().unwrap().into(),
        ),
    ];
    for (name, file) in forms {
        let read = stl::read(&file).unwrap_or_else(|why| panic!("{name}: {why}"));
        assert_eq!(read.note, None, "{name}");
        // Twelve corners, four places.
        assert_eq!((read.mesh.positions.len(), read.mesh.triangles.len()), (4, 4), "{name}");
        assert!(read.mesh.normals.is_empty() && read.mesh.uvs.is_empty());
        for (t, corners) in read.mesh.triangles.iter().zip(TETRAHEDRON) {
            assert_eq!(t.map(|v| read.mesh.positions[v as usize].as_vec3().to_array()), corners, "{name}");
        }
        // Every edge is there once in each direction.
        let edges: Vec<(u32, u32)> =
            read.mesh.triangles.iter().flat_map(|t| [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])]).collect();
        assert!(edges.iter().all(|(a, b)| edges.iter().filter(|e| **e == (*b, *a)).count() == 1), "{name}");
    }
    let zeros = [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], [[-0.0, 0.0, -0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]];
    assert_eq!(stl::read(&binary("", 2, &zeros)).expect("it is read").mesh.positions.len(), 4);
}

#[test]
fn the_outer_side_is_that_of_the_corners_also_where_space_is_mirrored() {
    let files = || Memory(vec![("a.stl", binary("", 4, &TETRAHEDRON))]);
    for scale in [DVec3::ONE, DVec3::new(1.0, 1.0, -2.0)] {
        let place = Place { files: files(), ..Place::at(DAffine3::from_scale(scale)) };
        let mesh = place.mesh("stlmesh", &[text("filename", "a.stl")]);
        let middle = DVec3::splat(0.25) * scale;
        for t in &mesh.triangles {
            let [a, b, c] = t.map(|v| mesh.positions[v as usize]);
            assert!((b - a).cross(c - a).dot(a - middle) > 0.0);
        }
    }
}

#[test]
fn wrong_counts_are_told_and_what_is_there_is_read() {
    for (stated, held) in [(0, 4), (7, 4), (u32::MAX, 4), (3, 4)] {
        let read = stl::read(&binary("\0", stated, &TETRAHEDRON)).expect("it is read");
        assert_eq!(read.mesh.triangles.len(), 4);
        let note = format!("its header states {stated} triangles, and it holds {held}: 4 are read");
        assert_eq!(read.note, Some(note));
    }
    // Something else behind the triangles.
    let mut longer = binary("\0", 3, &TETRAHEDRON[..3]);
    longer.extend([7; 20]);
    assert_eq!(stl::read(&longer).expect("it is read").mesh.triangles.len(), 3);
    let files = Memory(vec![("a.stl", binary("\0", 0, &TETRAHEDRON))]);
    let said = Place { files, ..Place::default() }.build("stlmesh", &[text("filename", "a.stl")]).1;
    assert_eq!(said, ["`a.stl`: its header states 0 triangles, and it holds 4: 4 are read"]);
}

#[test]
fn faults_are_told_with_their_place() {
    let whole = binary("\0", 4, &TETRAHEDRON);
    assert_eq!(fault(&whole[..200]), "it ends within triangle 3 of the 4 that its header states, after 200 bytes: it is cut off");
    let mut broken = TETRAHEDRON;
    broken[2][1][1] = f32::INFINITY;
    assert_eq!(fault(&binary("", 4, &broken)), "triangle 3 (byte 184) has a coordinate that is not a finite number");
    assert_eq!(fault(&binary("", 0, &[])), "it holds no triangle");
    assert_eq!(fault(b""), "it is no STL file");
    assert_eq!(fault(b"\x89PNG\r\n"), "it is no STL file; it is a picture");
    assert!(fault(&[b"<!DOCTYPE html>".as_slice(), &[b' '; 100]].concat()).contains("it is a web page"));
    let text_form = ascii(&TETRAHEDRON);
    let check =
        |from: &str, to: &str, expected: &str| assert_eq!(fault(text_form.replacen(from, to, 1).as_bytes()), expected, "{to}");
    check("vertex 0e0 0 0", "vertex 0 0", "line 4: `vertex` needs three numbers");
    check("vertex 0e0 0 0", "vertex 0 nan 0", "line 4: a coordinate is not a finite number of single precision");
    check("vertex 0e0 0 0", "vertex 0 1e39 0", "line 4: a coordinate is not a finite number of single precision");
    check("      vertex 0e0 0 0\n", "", "line 7: a facet ends that does not have three vertices");
    check("    endloop", "vertex 0 0 0", "line 7: a facet has more than three vertices");
    check("  endfacet\n", "", "line 8: `facet` stands within a facet: the one before it has no `endfacet`");
    check("  facet normal 0 0 0\n", "", "line 3: `vertex` stands outside of a facet");
    check("outer loop", "outer lop", "line 3: `lop` is no word of STL");
    assert_eq!(fault(&text_form.as_bytes()[..text_form.len() - 60]), "it ends within a facet: it is cut off");
    assert_eq!(fault(b"solid nothing\nendsolid"), "it holds no triangle");
    assert_eq!(fault(b"\xff\xfes\0o\0"), "it is text in UTF-16: save it as UTF-8 or ASCII");
}
