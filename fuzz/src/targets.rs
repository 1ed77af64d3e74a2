//! From the bytes of an input to what bhs makes of them: one function for each kind of thing that bhs reads.
//!
//! The fuzz targets and the test that replays the corpus (`tests/corpus.rs`) share this file, so that they cannot drift apart.
//! No target reads a file of the system but `compare`, whose input is one. A target fails by a panic, an abort, a hang, or by asking for
//! more memory than its input justifies.

use bhs::checkpoint::format::{Reader, SectionKind, Writer};
use bhs::checkpoint::{self, Identity};
use bhs::image::Picture;
use bhs::lang::parse::Directives;
use bhs::lang::{self, BuiltScene, Overrides, SourceMap};
use bhs::progress::Progress;
use bhs::registry::Registry;
use bhs::render::{Job, Limits, RenderState};
use bhs::signals::Signals;
use bhs::trace::Answers;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::PathBuf;
use std::sync::{Arc, OnceLock};

/// The names of all targets: those of the programs in `fuzz_targets` and of the folders in `corpus`.
#[allow(dead_code)] // the targets name themselves, the replay goes through all
pub const NAMES: [&str; 16] = [
    "scene",
    "ply",
    "ply_gzip",
    "obj",
    "mtl",
    "stl",
    "gltf",
    "spd",
    "png",
    "jpeg",
    "hdr",
    "exr",
    "compare",
    "rays",
    "pairs",
    "checkpoint",
];

/// Bytes that any input may make the program hold at once.
const BYTES_BESIDES: u64 = 8 << 20;
/// Bytes besides for each byte of a text, a mesh or a spectrum.
const BYTES_A_BYTE: u64 = 200;
/// Bytes besides for each byte of a compressed file: deflate makes at most 1032 bytes of one, a byte of a picture of one bit a
/// texel is eight texels, and a texel is three bytes.
const BYTES_A_COMPRESSED_BYTE: u64 = 1032 * 8 * 3 * 2;

/// Runs the target `name` on `data`.
///
/// # Panics
/// If bhs fails on it, or there is no such target.
pub fn run(name: &str, data: &[u8]) {
    // What is loaded once and kept does not count.
    registry();
    let (work, bytes_a_byte): (fn(&[u8]), u64) = match name {
        "scene" => (scene, BYTES_A_BYTE),
        "ply" => (|data| with_file(MESH, "mesh.ply", data), BYTES_A_BYTE),
        "ply_gzip" => (ply_gzip, BYTES_A_COMPRESSED_BYTE),
        "obj" => (|data| with_file(OBJ, "mesh.obj", data), BYTES_A_BYTE),
        "mtl" => (mtl, BYTES_A_BYTE),
        "stl" => (|data| with_file(STL, "mesh.stl", data), BYTES_A_BYTE),
        "gltf" => (gltf, BYTES_A_BYTE),
        "spd" => (|data| with_file(SPECTRUM, "paint.spd", data), BYTES_A_BYTE),
        "png" => (|data| picture(data, b"\x89PNG\r\n\x1a\n"), BYTES_A_COMPRESSED_BYTE),
        "jpeg" => (|data| picture(data, b"\xff\xd8\xff"), BYTES_A_COMPRESSED_BYTE),
        "hdr" => (|data| picture(data, b"#?RADIANCE\n"), BYTES_A_COMPRESSED_BYTE),
        "exr" => (|data| picture(data, &EXR_SIGNATURE), BYTES_A_COMPRESSED_BYTE),
        "compare" => (compare, BYTES_A_COMPRESSED_BYTE),
        "rays" => (rays, BYTES_A_BYTE),
        "pairs" => (pairs, BYTES_A_BYTE),
        "checkpoint" => (checkpoint, BYTES_A_BYTE),
        _ => panic!("there is no target `{name}`"),
    };
    let most = allocation_counter::measure(|| work(data)).bytes_max;
    let allowed = BYTES_BESIDES + bytes_a_byte * data.len() as u64;
    assert!(most <= allowed, "{most} bytes of memory for an input of {} bytes", data.len());
}

const EXR_SIGNATURE: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];

/// The plugins, and what they load once.
fn registry() -> &'static Registry {
    static REGISTRY: OnceLock<Registry> = OnceLock::new();
    REGISTRY.get_or_init(|| {
        let registry = Registry::builtin();
        // Tables of spectra are decoded at their first use.
        let colours = r#"WorldBegin LightSource "infinite" "rgb L" [1 0.5 0.2] Material "diffuse" "rgb reflectance" [0.1 0.2 0.3]
            Shape "sphere""#;
        drop(lang::load_text("warm.bhs", colours, &registry, &overrides(), &mut SourceMap::new()));
        registry
    })
}

/// The brute-force intersector has no memory of its own that is not counted here.
fn overrides() -> Overrides {
    Overrides { intersector: Some("reference".into()), ..Overrides::default() }
}

/// Builds the scene `text` with the given files and no others, and draws what is found. `None` if it has errors.
fn build(text: &str, files: &[(&str, &[u8])]) -> Option<BuiltScene> {
    let files: BTreeMap<PathBuf, Arc<[u8]>> = files.iter().map(|(name, data)| (PathBuf::from(name), Arc::from(*data))).collect();
    let mut sources = SourceMap::in_memory(files);
    let made = lang::load_text("fuzz.bhs", text, registry(), &overrides(), &mut sources);
    let found = match &made {
        Ok(built) => &built.warnings,
        Err(found) => found,
    };
    for label in found.iter().flat_map(|d| d.primary.iter().chain(&d.labels)) {
        let text = &sources.get(label.span.file).expect("the file is there").text;
        assert!(text.get(label.span.start as usize..label.span.end as usize).is_some(), "{label:?} lies outside of the text");
    }
    bhs::report::render(found, &sources, true);
    made.ok()
}

/// A text: read by the quick parser and by the grammar, which must agree; formatted, twice; built.
fn scene(data: &[u8]) {
    let text = &*String::from_utf8_lossy(data);
    let mut directives = Directives::new(text, 0);
    let read: Vec<_> = directives.by_ref().collect();
    let found = directives.into_faults();
    let mut by_grammar = Directives::by_grammar(text, 0);
    assert_eq!(read, by_grammar.by_ref().collect::<Vec<_>>(), "the two parsers differ");
    assert_eq!(found, by_grammar.into_faults(), "the two parsers differ");
    if let Ok(neat) = lang::format(text, 0) {
        assert_eq!(lang::format(&neat, 0).as_ref(), Ok(&neat), "formatting twice is formatting once");
    }
    let mesh: &[u8] = b"ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    let sky: &[u8] = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x80\x80\x81\x40\x80\x20\x81";
    let files: [(&str, &[u8]); 6] = [
        ("fuzz.bhs", data),
        ("a.bhs", b"Translate 1 0 0\nShape \"sphere\"\n"),
        ("a.ply", mesh),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("a.hdr", sky),
        ("a.spd", b"400 0.5\n700 0.25\n"),
    ];
    build(text, &files);
}

const MESH: &str = r#"WorldBegin Shape "plymesh" "string filename" "mesh.ply""#;
const OBJ: &str = r#"WorldBegin Shape "objmesh" "string filename" "mesh.obj""#;
const STL: &str = r#"WorldBegin Shape "stlmesh" "string filename" "mesh.stl""#;
const SPECTRUM: &str = r#"WorldBegin Material "diffuse" "spectrum reflectance" "paint.spd" Shape "sphere""#;
/// The same file is a sky, a colour and a number.
const PICTURE: &str = r#"WorldBegin LightSource "infinite" "string filename" "picture"
    Texture "c" "spectrum" "imagemap" "string filename" "picture" Texture "n" "float" "imagemap" "string filename" "picture"
    Material "conductor" "texture reflectance" "c" "texture roughness" "n" Shape "sphere""#;

/// Builds a scene that reads `data` as the file `name`.
fn with_file(text: &str, name: &str, data: &[u8]) {
    build(text, &[(name, data)]);
}

/// A file of materials, beside a mesh that has two of them.
fn mtl(data: &[u8]) {
    let mesh: &[u8] = b"mtllib mesh.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nusemtl a\nf 1/1 2/1 3/1\nusemtl b c\nf 1/1 3/1 2/1\n";
    let picture: &[u8] = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n\x80\x80\x80\x81\x40\x80\x20\x81";
    build(OBJ, &[("mesh.obj", mesh), ("mesh.mtl", data), ("a.hdr", picture)]);
}

/// A model in a scene, and a scene by itself.
fn gltf(data: &[u8]) {
    let names = ["mesh.gltf", "mesh.glb"];
    let files: BTreeMap<PathBuf, Arc<[u8]>> = names.iter().map(|name| (PathBuf::from(name), Arc::from(data))).collect();
    let mut sources = SourceMap::in_memory(files);
    let found = match lang::load(names[0], registry(), &overrides(), &mut sources) {
        Ok(built) => built.warnings,
        Err(found) => found,
    };
    bhs::report::render(&found, &sources, true);
    build(r#"WorldBegin Scale 2 2 2 Shape "gltf" "string filename" "mesh.gltf""#, &[("mesh.gltf", data)]);
}

/// A mesh that is compressed: `data` as it stands behind the mark of gzip, or as the compressed content, by its first byte.
fn ply_gzip(data: &[u8]) {
    let Some((how, data)) = data.split_first() else { return };
    let file = if how % 2 == 0 {
        [&[0x1f, 0x8b], data].concat()
    } else {
        let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
        encoder.write_all(data).and_then(|()| encoder.finish()).expect("memory does not fail")
    };
    with_file(MESH, "mesh.ply", &file);
}

/// A picture of the kind that starts with `signature`, which the input need not have.
fn picture(data: &[u8], signature: &[u8]) {
    let data = if data.starts_with(&signature[..2]) { data } else { &[signature, data].concat() };
    with_file(PICTURE, "picture", data);
}

/// A file that is compared with itself.
fn compare(data: &[u8]) {
    let data = if data.starts_with(&EXR_SIGNATURE) { data } else { &[&EXR_SIGNATURE, data].concat() };
    let path = std::env::temp_dir().join(format!("bhs-fuzz-{}.exr", std::process::id()));
    std::fs::write(&path, data).expect("the temporary folder can be written");
    let read = Picture::read_exr(&path);
    let _ = std::fs::remove_file(&path);
    if let Ok(picture) = read {
        drop(bhs::compare::compare(&picture, &picture));
    }
}

/// A sphere before a hole.
fn traced() -> &'static BuiltScene {
    static SCENE: OnceLock<BuiltScene> = OnceLock::new();
    SCENE.get_or_init(|| {
        let text = r#"WorldBegin BlackHole "schwarzschild" "float rs" 0.2 Translate 0 0 3 Shape "sphere""#;
        let overrides = Overrides { without_camera: true, ..overrides() };
        lang::load_text("traced.bhs", text, registry(), &overrides, &mut SourceMap::new())
            .unwrap_or_else(|found| panic!("{found:?}"))
    })
}

/// Lines of `bhs trace --rays`.
fn rays(data: &[u8]) {
    let answers = Answers { with_path: true, ..Answers::new(&traced().scene) };
    drop(bhs::trace::trace(&answers, data, &mut std::io::sink()));
}

/// Lines of `bhs trace --connect`.
fn pairs(data: &[u8]) {
    drop(bhs::trace::connect(&traced().scene, data, &mut std::io::sink()));
}

/// The sections of a checkpoint.
type Sections = Vec<(SectionKind, Vec<u8>)>;

/// A small picture that is guided, and the parts of its checkpoint after eight of its samples.
fn saved() -> &'static (BuiltScene, Sections) {
    static SAVED: OnceLock<(BuiltScene, Sections)> = OnceLock::new();
    SAVED.get_or_init(|| {
        let text = r#"Film "rgb" "integer xresolution" 20 "integer yresolution" 3 "string layers" ["normal" "variance"]
            LightTransport "path" "bool guiding" true Sampler "sobol" "integer pixelsamples" 10
            WorldBegin LightSource "infinite" Translate 0 0 3 Shape "sphere""#;
        let made = lang::load_text("saved.bhs", text, registry(), &overrides(), &mut SourceMap::new());
        let built = made.unwrap_or_else(|found| panic!("{found:?}"));
        let state = RenderState::new(Job::of(&built)).expect("there is memory");
        state.run(&Limits { most: 8, least: 8, ..Limits::of(&*built.sampler) }, &Progress::hidden(), &Signals::default());
        let mut file = Vec::new();
        checkpoint::write(&mut file, &Identity::of(&built), &state).expect("memory does not fail");
        let mut parts = Vec::new();
        let mut reader = Reader::new(&file[..]).expect("it was written so");
        while let Ok(part) = reader.section() {
            parts.push(part);
        }
        (built, parts)
    })
}

/// The file with the given sections.
fn joined(parts: &[(SectionKind, Vec<u8>)]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut writer = Writer::new(&mut file).expect("memory does not fail");
    for (kind, content) in parts {
        writer.section(*kind, &[content]).expect("memory does not fail");
    }
    file
}

/// Sections with some bytes changed and some cut off: number, place and change of each are four bytes.
fn changed(mut parts: Sections, data: &[u8]) -> Sections {
    for change in data.chunks_exact(4) {
        let count = parts.len();
        let content = &mut parts[usize::from(change[0]) % count].1;
        let at = usize::from(u16::from_le_bytes([change[1], change[2]])) % content.len().max(1);
        match content.get_mut(at) {
            Some(byte) if change[3] > 0 => *byte ^= change[3],
            _ => content.truncate(at),
        }
    }
    parts
}

/// The first of the given sections, and those that `data` describes, one kind of which there is not: for each the number of its kind, its length in two bytes, its content.
fn sections(parts: &[(SectionKind, Vec<u8>)], mut data: &[u8]) -> Sections {
    let kinds = [*b"HEAD", *b"STAT", *b"NONE", *b"TILE", *b"END "];
    let mut all: Vec<_> = parts.iter().take(1).cloned().collect();
    while let Some(([kind, low, high], rest)) = data.split_first_chunk::<3>() {
        let length = usize::from(u16::from_le_bytes([*low, *high])).min(rest.len());
        all.push((kinds[usize::from(*kind) % kinds.len()], rest[..length].to_vec()));
        data = &rest[length..];
    }
    all
}

/// A checkpoint, which is resumed. By the first byte, what follows is the file as it stands, or changes of a good one, or sections behind a right
/// head; the checksums of the last two are right.
fn checkpoint(data: &[u8]) {
    let Some((how, data)) = data.split_first() else { return };
    let (built, parts) = saved();
    let file = match how % 3 {
        0 => data.to_vec(),
        1 => joined(&changed(parts.clone(), data)),
        _ => joined(&sections(parts, data)),
    };
    let mut state = RenderState::new(Job::of(built)).expect("there is memory");
    if checkpoint::read(&file[..], &Identity::of(built), false, &mut state).is_ok() {
        state.run(&Limits::of(&*built.sampler), &Progress::hidden(), &Signals::default());
    }
}
