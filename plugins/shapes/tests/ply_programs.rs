//! PLY files as programs write them: all that is a square to its author is one here.

use bhs_shapes::ply::read;
use flate2::{Compression, write::GzEncoder};
use std::io::Write;

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).expect("memory takes everything");
    encoder.finish().expect("memory takes everything")
}

/// Area of the triangles of a file.
fn area(file: &[u8]) -> f64 {
    let mesh = read(file).unwrap_or_else(|e| panic!("{}: {e}", String::from_utf8_lossy(file))).mesh;
    let corner = |v: u32| mesh.positions[v as usize];
    mesh.triangles.iter().map(|t| 0.5 * (corner(t[1]) - corner(t[0])).cross(corner(t[2]) - corner(t[0])).length()).sum()
}

/// A square in the way that most programs write it.
const SQUARE: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n-1 -1 0\n1 -1 0\n1 1 0\n-1 1 0\n4 0 1 2 3\n";

#[test]
fn every_program_s_way_of_writing_a_square_is_read() {
    let with_normals = "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n";
    let table: &[(&str, &[(&str, &str)])] = &[
        ("plain", &[]),
        ("byte order mark", &[("ply\n", "\u{feff}ply\n")]),
        (
            "comments anywhere in the header",
            &[("format", "comment caf\u{e9}\nobj_info  x\nformat"), ("element face", "comment\nelement face")],
        ),
        ("vertex_index", &[("vertex_indices", "vertex_index")]),
        ("unsigned lists", &[("uchar int", "uint uint")]),
        ("signed short lists", &[("uchar int", "int8 int16")]),
        ("double", &[("float x", "double x"), ("float y", "float64 y")]),
        (
            "colours and more",
            &[
                ("property float z\n", "property float z\nproperty uchar red\n"),
                ("-1 -1 0\n1 -1 0\n1 1 0\n-1 1 0\n", "-1 -1 0 9\n1 -1 0 9\n1 1 0 9\n-1 1 0 9\n"),
            ],
        ),
        (
            "elements after the faces",
            &[
                ("end_header", "element edge 1\nproperty int vertex1\nproperty int vertex2\nend_header"),
                ("4 0 1 2 3\n", "4 0 1 2 3\n0 1\n"),
            ],
        ),
        (
            "elements before the vertices",
            &[("element vertex 4", "element camera 1\nproperty float view_px\nelement vertex 4"), ("-1 -1 0\n", "7\n-1 -1 0\n")],
        ),
        ("a vertex without a place, unused", &[("vertex 4", "vertex 5"), ("4 0 1", "nan -nan(ind) 1.#QNAN\n4 0 1")]),
        (
            "normals that are none",
            &[
                ("property float z\n", with_normals),
                ("-1 -1 0\n1 -1 0\n1 1 0\n-1 1 0\n", "-1 -1 0 nan nan nan\n1 -1 0 0 0 -7\n1 1 0 0 0 -1\n-1 1 0 inf 0 0\n"),
            ],
        ),
        (
            "texture coordinates of corners",
            &[
                ("vertex_indices\n", "vertex_indices\nproperty list uchar float texcoord\n"),
                ("4 0 1 2 3", "4 0 1 2 3 8 0 0 1 0 1 1 0 1"),
            ],
        ),
        (
            "strips besides",
            &[
                ("end_header", "element tristrips 1\nproperty list int int vertex_indices\nend_header"),
                ("4 0 1 2 3\n", "4 0 1 2 3\n4 0 1 2 -1\n"),
            ],
        ),
    ];
    for (name, changes) in table {
        let mut text = SQUARE.to_owned();
        for (from, to) in *changes {
            assert!(text.contains(from), "{name}: {from}");
            text = text.replacen(from, to, 1);
        }
        for (end, text) in [("LF", text.clone()), ("CRLF", text.replace('\n', "\r\n")), ("CR", text.replace('\n', "\r"))] {
            assert_eq!(area(text.as_bytes()), 4.0, "{name}, {end}:\n{text}");
            assert_eq!(area(&gzip(text.as_bytes())), 4.0, "{name}, {end}, gzip");
        }
    }
    // A comment in another encoding.
    assert_eq!(area(&[b"ply\ncomment caf\xe9 \xff\n", &SQUARE.as_bytes()[4..]].concat()), 4.0);
}

#[test]
fn a_normal_that_is_none_is_that_of_the_face() {
    let text =
        SQUARE.replace("property float z\n", "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n");
    let corners = "-1 -1 0\n1 -1 0\n1 1 0\n-1 1 0\n";
    let with = |rows: &str| read(text.replace(corners, rows).as_bytes()).expect("it is read").mesh.normals;
    // On the side of the normals that there are.
    assert_eq!(with("-1 -1 0 nan nan nan\n1 -1 0 0 0 -1\n1 1 0 0 0 -1\n-1 1 0 0 0 0\n"), [[0.0, 0.0, -1.0]; 4]);
    assert_eq!(with("-1 -1 0 nan nan nan\n1 -1 0 0 0 0\n1 1 0 0 inf 0\n-1 1 0 -nan 0 0\n"), [[0.0, 0.0, 1.0]; 4]);
}

#[test]
fn polygons_need_not_be_convex_and_may_come_before_their_vertices() {
    let corners = ["-1 -1 0", "1 -1 0", "1 0 0", "0 0 0", "0 1 0", "-1 1 0"];
    for first in 0..6 {
        let face: String = (0..6).map(|i| format!(" {}", (first + i) % 6)).collect();
        let vertex = "element vertex 6\nproperty float x\nproperty float y\nproperty float z\n";
        let faces = "element face 1\nproperty list uchar int vertex_indices\n";
        let rows = corners.join("\n");
        for body in
            [format!("{vertex}{faces}end_header\n{rows}\n6{face}\n"), format!("{faces}{vertex}end_header\n6{face}\n{rows}\n")]
        {
            let file = format!("ply\nformat ascii 1.0\n{body}");
            assert_eq!(area(file.as_bytes()), 3.0, "{file}");
        }
    }
}

#[test]
fn what_is_not_read_is_told() {
    let strips = SQUARE.replace("element face 1", "element tristrips 1");
    let fault = "its surface is triangle strips (element `tristrips`), which are not read: save it with faces";
    assert_eq!(read(strips.as_bytes()), Err(fault.to_owned()));
    assert_eq!(read(b"\xff\xfep\0l\0y\0\n\0"), Err("it is text in UTF-16: save it as UTF-8 or ASCII".to_owned()));
    let texcoord = SQUARE
        .replace("vertex_indices\n", "vertex_indices\nproperty list uchar float texcoord\n")
        .replace("4 0 1 2 3", "4 0 1 2 3 0");
    assert_eq!(
        read(texcoord.as_bytes()).expect("it is read").unread,
        ["texture coordinates of the corners of faces (`texcoord`)"]
    );
}
