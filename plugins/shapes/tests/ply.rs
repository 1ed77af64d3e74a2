//! The PLY reader: every way of writing a mesh gives the same mesh, every fault its own words, and no bytes a panic.

mod common;

use bhs_shapes::ply::{Ply, read};
use common::box_near;
use flate2::{Compression, write::GzEncoder};
use glam::DVec3;
use proptest::prelude::*;
use std::io::Write;

const HEADER: &str = "ply\nformat FORMAT 1.0\ncomment by hand\nobj_info none\nelement camera 1\nproperty list uchar float m\n\
    property double t\nelement vertex 4\nproperty float x\nproperty double y\nproperty short junk\nproperty float z\n\
    property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty double t\nelement nothing 7\n\
    element face 3\nproperty uchar flag\nproperty list ushort INDEX vertex_index\nproperty list int double extra\nend_header\n";

const VERTICES: [[f64; 9]; 4] = [
    [0.1, 0.0, 7.0, -1.5, 0.0, 0.0, 1.0, 0.25, 0.0],
    [1e-3, 2.0, -7.0, 3.0, 0.0, 1.0, 0.0, 0.5, 1.0],
    [1.25e10, -0.0, 0.0, 123456.789, 1.0, 0.0, 0.0, 0.0, 0.5],
    [-7.0, 0.333_333_333_333_333_3, 1.0, 1e-30, 0.0, 0.0, -1.0, 1.0, 1.0],
];
const FACES: [&[i64]; 3] = [&[0, 1, 2], &[3, 2, 1, 0], &[1, 2]];

/// The same mesh in one of the formats.
fn write(format: &str, index: &str) -> Vec<u8> {
    let mut out = HEADER.replace("FORMAT", format).replace("INDEX", index).into_bytes();
    if format == "ascii" {
        let mut text = String::from("2 0.5 nan 1\n");
        for v in VERTICES {
            text += &format!("{} {} {} {:e}  {}\t{} {} {} {:e}\r\n", v[0], v[1], v[2], v[3], v[4], v[5], v[6], v[7], v[8]);
        }
        text += "\n  \n";
        for f in FACES {
            let indices = f.iter().map(|i| format!("{i} ")).collect::<String>();
            text += &format!("1 {} {indices}2 0.5 1e3\n", f.len());
        }
        out.extend(text.bytes());
        return out;
    }
    let mut put = |bytes: &[u8]| match format {
        "binary_big_endian" => out.extend(bytes.iter().rev()),
        _ => out.extend(bytes),
    };
    put(&[1]);
    put(&0.5f32.to_le_bytes());
    put(&1.0f64.to_le_bytes());
    for v in VERTICES {
        for (i, x) in v.into_iter().enumerate() {
            match i {
                1 | 8 => put(&x.to_le_bytes()),
                2 => put(&(x as i16).to_le_bytes()),
                _ => put(&(x as f32).to_le_bytes()),
            }
        }
    }
    for f in FACES {
        put(&[1]);
        put(&(f.len() as u16).to_le_bytes());
        for i in f {
            match index {
                "uchar" => put(&(*i as u8).to_le_bytes()),
                "int16" => put(&(*i as i16).to_le_bytes()),
                _ => put(&(*i as u32).to_le_bytes()),
            }
        }
        put(&2u32.to_le_bytes());
        put(&0.5f64.to_le_bytes());
        put(&1e3f64.to_le_bytes());
    }
    out
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).expect("memory takes everything");
    encoder.finish().expect("memory takes everything")
}

/// What [`write`] writes.
fn expected() -> Ply {
    // The quadrilateral is no plane one, and crosses itself.
    let mut ply = Ply { dropped_faces: 1, crossing_faces: 1, ..Ply::default() };
    for [x, y, _, z, nx, ny, nz, u, v] in VERTICES {
        ply.mesh.positions.push(DVec3::new(f64::from(x as f32), y, f64::from(z as f32)));
        ply.mesh.normals.push([nx as f32, ny as f32, nz as f32]);
        ply.mesh.uvs.push([u as f32, v as f32]);
    }
    // A quadrilateral is the fan around its first corner.
    ply.mesh.triangles = vec![[0, 1, 2], [3, 2, 1], [3, 1, 0]];
    ply
}

#[test]
fn all_formats_hold_the_same_mesh() {
    for index in ["uchar", "int16", "uint", "uint32"] {
        for format in ["ascii", "binary_little_endian", "binary_big_endian"] {
            let file = write(format, index);
            assert_eq!(read(&file).as_ref(), Ok(&expected()), "{format} {index}");
            assert_eq!(read(&gzip(&file)).as_ref(), Ok(&expected()), "{format} {index} gzip");
            // Two gzip files one after the other are one file (RFC 1952).
            let parts = [gzip(&file[..file.len() / 2]), gzip(&file[file.len() / 2..])].concat();
            assert_eq!(read(&parts).as_ref(), Ok(&expected()), "{format} {index} gzip in two parts");
        }
    }
}

#[test]
fn line_ends_do_not_matter() {
    let text = String::from_utf8(write("ascii", "int")).expect("text").replace('\r', "");
    for file in [text.replace('\n', "\r\n"), text.replace('\n', "\r"), text.trim_end().to_owned()] {
        assert_eq!(read(file.as_bytes()), Ok(expected()));
    }
    let binary = write("binary_little_endian", "int");
    let body = binary.windows(11).position(|w| w == b"end_header\n").expect("a header") + 11;
    for eol in ["\r\n", "\r"] {
        let header = String::from_utf8_lossy(&binary[..body]).replace('\n', eol);
        assert_eq!(read(&[header.as_bytes(), &binary[body..]].concat()), Ok(expected()), "{eol:?}");
    }
}

#[test]
fn numbers_are_rounded_as_the_language_rounds_them() {
    let words = [
        "0.0503644",
        "16777217",
        "0.1",
        "-0.3333333333333333",
        "1.17549435e-38",
        "1e-45",
        "7.006492321624085e-46",
        "3.4028235e38",
        "1.00000017881393432617187499",
        "1.00000017881393421514957253748434595763683319091796875001",
        "+5",
        ".5",
        "5.",
        "-.25",
        "9007199254740993",
        "123456789012345678901234567890",
        "0.000000000000000000000000000001",
        "1e5",
        "2E+3",
        "-0",
    ];
    for word in words {
        for (ty, value) in [("float", word.parse::<f32>().map(f64::from)), ("double", word.parse::<f64>())] {
            let file = format!(
                "ply\nformat ascii 1.0\nelement vertex 1\nproperty {ty} x\nproperty {ty} y\nproperty {ty} z\n\
                 element face 0\nproperty list uchar int vertex_index\nend_header\n{word} 0 0\n"
            );
            let found = read(file.as_bytes()).expect("a mesh").mesh.positions[0].x;
            assert_eq!(found.to_bits(), value.expect("a number").to_bits(), "{ty} {word}");
        }
    }
}

/// A file of three vertices and one triangle, as text, changed by `change`.
fn faulty(change: &[(&str, &str)]) -> String {
    let mut text = String::from(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
    );
    for (from, to) in change {
        assert!(text.contains(from), "{from}");
        text = text.replacen(from, to, 1);
    }
    text
}

#[test]
fn every_fault_is_told_with_its_place() {
    let check = |change: &[(&str, &str)], fault: &str| {
        let file = faulty(change);
        assert_eq!(read(file.as_bytes()).map(|_| ()), Err(fault.to_owned()), "{change:?}");
        assert_eq!(read(&gzip(file.as_bytes())).map(|_| ()), Err(fault.to_owned()), "{change:?} gzip");
    };
    // The header.
    check(&[("ply\n", "plx\n")], "not a PLY file: its first line is not `ply`; it is text, and no mesh that is known");
    check(&[("ply\n", "ply x\n")], "header line 1: unknown keyword `ply`");
    check(&[("end_header", "")], "header line 10: unknown keyword `0`");
    check(&[("format ascii 1.0\n", "")], "the header has no line `format`");
    check(&[("1.0", "1.1")], "header line 2: version `1.1` of the format is unknown, only 1.0 is");
    check(&[("ascii", "utf8")], "header line 2: format `utf8` is none of `ascii`, `binary_little_endian`, `binary_big_endian`");
    check(&[("ascii 1.0", "ascii")], "header line 2: expected `format NAME 1.0`, found `format ascii`");
    check(&[("element vertex 3\n", "format ascii 1.0\n")], "header line 3: a second line `format`");
    check(&[("vertex 3", "vertex -3")], "header line 3: expected the number of elements `vertex`, found `-3`");
    check(&[("vertex 3", "vertex many")], "header line 3: expected the number of elements `vertex`, found `many`");
    check(&[("element vertex 3\n", "")], "header line 3: property `x` stands before any element");
    check(&[("float x", "real x")], "header line 4: unknown type `real`");
    check(
        &[("float x", "x")],
        "header line 4: expected `property TYPE NAME` or `property list TYPE TYPE NAME`, found `property x`",
    );
    check(&[("float y", "float x")], "header line 5: element `vertex` declares property `x` twice");
    check(&[("face 1", "vertex 1")], "header line 7: element `vertex` is declared twice");
    check(&[("list uchar", "list float")], "header line 8: the length of list `vertex_indices` must have an integer type");
    check(&[("float y", "float w")], "the vertices have no property `y`");
    check(&[("float y", "list uchar float y")], "the vertices have no property `y`");
    check(&[("float z", "float z\nproperty float nx")], "the vertices have some but not all of `nx`, `ny`, `nz`");
    check(&[("vertex 3", "point 3")], "the file has no element `vertex`");
    check(&[("face 1", "strip 1")], "the file has no element `face`: no surface, points only");
    check(&[("vertex_indices", "corners")], "the faces have no property `vertex_indices` (or `vertex_index`)");
    check(&[("int vertex_indices", "float vertex_indices")], "`vertex_indices` of the faces must be a list of integers");
    check(&[("vertex 3", "vertex 5000000000")], "5000000000 vertices are more than the 4294967295 that a mesh can have");
    // What follows it.
    check(&[("1 0 0", "1 zero 0")], "line 11, vertex 1 of 3: expected a number, found `zero`");
    check(&[("1 0 0", "1 0")], "line 11, vertex 1 of 3: the line has fewer values than the header announces");
    check(&[("1 0 0", "1 0 0 0")], "line 11, vertex 1 of 3: the line has more values than the header announces");
    check(&[("1 0 0", "1 nan 0")], "line 11, vertex 1 of 3: `y` is not a finite number (NaN), and a face uses it");
    check(&[("1 0 0", "1 -inf 0")], "line 11, vertex 1 of 3: `y` is not a finite number (-inf), and a face uses it");
    check(&[("1 0 0", "1 1e39 0")], "line 11, vertex 1 of 3: `y` is not a finite number (inf), and a face uses it");
    check(
        &[("0 1 2\n", "0 1 3\n")],
        "line 13, face 0 of 1: vertex index 3 is out of range: there are 3 vertices, counted from 0",
    );
    check(&[("0 1 2\n", "0 -1 2\n")], "line 13, face 0 of 1: vertex index -1 is negative");
    check(&[("0 1 2\n", "0 1.5 2\n")], "line 13, face 0 of 1: expected an integer, found `1.5`");
    check(&[("3 0 1 2\n", "-3 0 1 2\n")], "line 13, face 0 of 1: a list of -3 values");
    check(&[("3 0 1 2\n", "9999999999999 0 1 2\n")], "line 13, face 0 of 1: the line has fewer values than the header announces");
    let ends = "the file ends here, before what its header announces";
    check(&[("3 0 1 2\n", "")], &format!("line 12, face 0 of 1: {ends}"));
    check(&[("vertex 3", "vertex 4"), ("3 0 1 2\n", "")], &format!("line 12, vertex 3 of 4: {ends}"));
    check(&[("vertex 3", "vertex 4000000000"), ("3 0 1 2\n", "")], &format!("line 12, vertex 3 of 4000000000: {ends}"));
    check(&[("vertex 3", "vertex 2")], "line 12, face 0 of 1: the line has more values than the header announces");
}

#[test]
fn faults_of_binary_and_compressed_files_are_told() {
    let fault = |file: &[u8]| read(file).expect_err("a fault");
    assert_eq!(fault(b""), "the file is empty");
    assert_eq!(fault(b"ply"), "not a PLY file: its first line is not `ply`");
    assert!(fault(b"v 0 0 0\nv 1 0 0\n").ends_with("; it looks like OBJ: Shape \"objmesh\" reads it"));
    assert!(fault(b"version https://git-lfs.github.com/spec/v1\n").contains("git lfs pull"));
    assert_eq!(fault(b"ply\n"), "the header has no end: there is no line `end_header`");
    assert_eq!(fault(&gzip(b"")), "the file is empty");
    let whole = write("binary_little_endian", "int");
    let ends = "the file ends here, before what its header announces";
    assert_eq!(fault(&whole[..whole.len() - 1]), format!("face 2 of 3: {ends}"));
    assert_eq!(fault(&whole[..whole.len() - 110]), format!("vertex 3 of 4: {ends}"));
    // A list that is longer than the file.
    let mut long = whole.clone();
    let last_face = whole.len() - 31;
    long[last_face + 1..last_face + 3].copy_from_slice(&[0xff, 0xff]);
    long[last_face + 3..].fill(0);
    assert_eq!(fault(&long), format!("face 2 of 3: {ends}"));
    // The same for one that is stepped over.
    let mut long = whole.clone();
    long[last_face + 11..last_face + 15].copy_from_slice(&i32::MAX.to_le_bytes());
    assert_eq!(fault(&long), format!("face 2 of 3: {ends}"));
    long[last_face + 11..last_face + 15].copy_from_slice(&(-1i32).to_le_bytes());
    assert_eq!(fault(&long), "face 2 of 3: a list of -1 values");
    let squeezed = gzip(&whole);
    assert!(fault(&squeezed[..squeezed.len() / 2]).contains("the gzip stream is damaged"));
    let mut flipped = squeezed.clone();
    let crc = squeezed.len() - 6;
    flipped[crc] ^= 1;
    assert!(fault(&flipped).contains("the gzip stream is damaged"), "{}", fault(&flipped));
    assert!(fault(&squeezed[..9]).contains("the gzip stream is damaged"));
}

#[test]
fn memory_is_reserved_as_the_file_justifies() {
    let lie = faulty(&[("vertex 3", "vertex 4294967295"), ("face 1", "face 18446744073709551615")]);
    for file in [lie.clone().into_bytes(), gzip(lie.as_bytes()), lie.replace("ascii", "binary_big_endian").into_bytes()] {
        assert!(read(&file).is_err());
    }
    // A header without properties announces elements that take no room: they are not counted through.
    let empty = faulty(&[("element face", "element nothing 18446744073709551615\nelement face")]);
    assert!(read(empty.as_bytes()).is_ok());
    // A line without end in a compressed file.
    let mut endless = faulty(&[("3 0 1 2\n", "3 0 1 ")]).into_bytes();
    endless.resize(endless.len() + (1 << 25), b'1');
    assert_eq!(read(&gzip(&endless)), Err("line 12, face 0 of 1: a line has more than 16777216 bytes".into()));
}

#[test]
fn what_follows_is_noticed() {
    assert_eq!(read(faulty(&[("3 0 1 2\n", "3 0 1 2\n \r\n\n")]).as_bytes()).map(|p| p.goes_on), Ok(false));
    assert_eq!(read(faulty(&[("3 0 1 2\n", "3 0 1 2\n3 0 1 2")]).as_bytes()).map(|p| p.goes_on), Ok(true));
}

/// A change of some bytes: (kind, place, byte).
fn mutated(mut file: Vec<u8>, changes: &[(u8, usize, u8)]) -> Vec<u8> {
    for (kind, at, byte) in changes {
        let at = at % (file.len() + 1);
        match kind {
            0 if at < file.len() => file[at] = *byte,
            1 => file.insert(at, *byte),
            2 if at < file.len() => drop(file.remove(at)),
            3 if at < file.len() => file[at] ^= 1 << (byte % 8),
            // Digits and blanks are what text is made of.
            4 if at < file.len() => file[at] = b"0123456789 -.en\n"[usize::from(byte % 16)],
            5 if *byte < 32 => file.truncate(at),
            _ => {}
        }
    }
    file
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn no_bytes_make_the_reader_panic(
        format in 0usize..3,
        index in 0usize..3,
        squeezed in 0u8..4,
        changes in prop::collection::vec((0u8..6, any::<usize>(), any::<u8>()), 1..12),
    ) {
        let file = write(["ascii", "binary_little_endian", "binary_big_endian"][format], ["uchar", "int16", "uint"][index]);
        // Changed before or after it is compressed, or not compressed at all.
        let file = match squeezed {
            0 => mutated(gzip(&file), &changes),
            1 => gzip(&mutated(file, &changes)),
            _ => mutated(file, &changes),
        };
        if let Ok(ply) = read(&file) {
            let n = ply.mesh.positions.len() as u32;
            prop_assert!(ply.mesh.positions.iter().all(|p| p.is_finite()));
            prop_assert!(ply.mesh.triangles.iter().flatten().all(|v| *v < n));
            prop_assert!(ply.mesh.positions.capacity() <= 1032 * file.len());
        }
    }
}

#[test]
fn meshes_of_the_trade_are_as_they_should_be() {
    // name, vertices, triangles, box (rounded to six digits), as counted by another program (PROVENANCE.md beside the files).
    type Row = (&'static str, usize, usize, [f64; 3], [f64; 3]);
    let rows: [Row; 5] = [
        ("stanford_dragon_871k", 437_645, 871_414, [-0.108324, 0.052729, -0.050414], [0.096566, 0.197173, 0.041207]),
        ("stanford_dragon_res4_11k", 5_205, 11_102, [-0.107585, 0.052844, -0.049836], [0.095236, 0.196343, 0.040826]),
        ("cs184_dragon_100k", 50_000, 100_000, [-0.43292, 0.0, -0.319536], [0.426383, 0.7, 0.355722]),
        ("stanford_bunny_69k", 35_947, 69_451, [-0.09469, 0.032987, -0.061874], [0.061009, 0.187321, 0.0588]),
        ("npm_bunny_4k", 1_839, 3_674, [-4.95847, -0.003149, -3.72983], [4.94885, 9.65475, 3.81064]),
    ];
    for (name, vertices, triangles, min, max) in rows {
        let path = format!("{}/../../../shared/data/meshes/{name}.ply", env!("CARGO_MANIFEST_DIR"));
        let Ok(file) = std::fs::read(&path) else {
            eprintln!("skipped: no {path}");
            continue;
        };
        let ply = read(&file).expect(name);
        assert_eq!((ply.mesh.positions.len(), ply.mesh.triangles.len(), ply.goes_on), (vertices, triangles, false), "{name}");
        let six_digits = 5e-6 * max[1].max(1.0);
        assert!(box_near(ply.mesh.bounds(), min, max, six_digits), "{name}: {:?}", ply.mesh.bounds());
        assert_eq!(ply.dropped_faces, 0);
    }
}
