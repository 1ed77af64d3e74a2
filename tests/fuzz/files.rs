//! Mutated meshes, spectra and pictures, and large ones.

use super::{BYTES_BESIDES, Random, mutate, times, within_memory};
use crate::common;
use bhs::develop::Texts;
use bhs::image::{Frame, Picture};
use bhs::lang::description::Entity;
use bhs::lang::parse::Directives;
use bhs::lang::{self, Overrides, SourceMap};
use bhs::look::Look;
use bhs::registry::{Kind, Registry, bare_context};
use bhs_core::diagnostics::{Span, Spanned};
use bhs_core::geometry::Shape;
use bhs_core::material::Material;
use bhs_core::params::Files;
use bhs_core::value::{Param, ParamType, Values};
use std::io::Cursor;

/// Files of each kind that are mutated and read.
const FILES: u64 = 10_000;
/// Models and materials that are mutated and built as scenes.
const MODELS: u64 = 3_000;
/// Pictures that are mutated and rendered.
const PICTURES: u64 = 1_000;

/// The one file that there is.
struct OneFile(Vec<u8>);

impl Files for OneFile {
    fn read(&self, _: &str, _: Span) -> Result<Vec<u8>, String> {
        Ok(self.0.clone())
    }
}

/// Makes a plugin whose parameter `name` is the file; whether that worked.
fn make<T: Kind + ?Sized>(registry: &Registry, file: &OneFile, plugin: &str, ty: ParamType, name: &str) -> bool {
    let mut found = Vec::new();
    let span = Span::default();
    let spanned = |text: &str| Spanned::new(text.to_owned(), span);
    let values = Values::Strings(vec![spanned("the.file")]);
    let entity = Entity {
        name: spanned(plugin),
        params: vec![Param { ty: Spanned::new(ty, span), name: spanned(name), values, span }],
        defaults: Default::default(),
        span,
        keyword: span,
        faulty: false,
        world_from_object: Default::default(),
        side: Default::default(),
    };
    registry.create::<T>(&entity, bare_context(file, registry.spectra()), &mut found).is_some() && found.is_empty()
}

const FILE_WORDS: &[&str] = &[
    "ply\n",
    "element face 4000000000\n",
    "element vertex 18446744073709551615\n",
    "property list uchar int vertex_indices\n",
    "-1",
    "4294967295",
    "nan",
    "1e39",
    " ",
    "\n",
    "\0",
    "\u{1f}",
    "format ascii 1.0\n",
    "end_header\n",
    "400 0.5\n",
    ",",
];

/// Mutates the files `examples` and makes something of each.
fn mutated_files(examples: &[Vec<u8>], make: impl Fn(&OneFile) -> bool) {
    // What is loaded once and kept is loaded here, and does not count.
    assert!(examples.iter().all(|e| make(&OneFile(e.clone()))));
    let mut faulty = 0;
    for seed in 0..times(FILES) {
        let mut random = Random(seed);
        let mut bytes = examples[random.below(examples.len())].clone();
        mutate(&mut random, &mut bytes, FILE_WORDS);
        let file = OneFile(bytes);
        within_memory(file.0.len(), &String::from_utf8_lossy(&file.0), || faulty += u64::from(!make(&file)));
    }
    // Some mutations do no harm, most do.
    assert!(faulty > times(FILES) / 10 && faulty < times(FILES), "{faulty}");
}

#[test]
fn mutated_meshes() {
    let registry = Registry::builtin();
    mutated_files(&ply_examples(), |file| make::<dyn Shape>(&registry, file, "plymesh", ParamType::String, "filename"));
}

#[test]
fn mutated_obj_files() {
    let registry = Registry::builtin();
    let others = "\u{feff}v -1 -1 0 # low\r\nv 1 -1 0 1 0 0\rv 1 0 0\nv 0 0 0\nv 0 1 0\nv -1 1 1.#QNAN\nv -1 1 0\nvt 0\nvn -nan(ind) 0 1\n\
        f 2/1 3/1 4/1/1 \\\n5/1/1 7/1 1/1\n";
    let examples = [common::read("grammar/examples/pyramid.obj").into_bytes(), others.as_bytes().to_vec()];
    mutated_files(&examples, |file| make::<dyn Shape>(&registry, file, "objmesh", ParamType::String, "filename"));
}

/// Binary and text.
fn stl_examples() -> Vec<Vec<u8>> {
    ["text", "binary"].map(|name| std::fs::read(common::root().join("fuzz/corpus/stl").join(name)).expect("it is there")).to_vec()
}

#[test]
fn mutated_stl_files() {
    let registry = Registry::builtin();
    mutated_files(&stl_examples(), |file| make::<dyn Shape>(&registry, file, "stlmesh", ParamType::String, "filename"));
}

/// Mutates the examples of a fuzz target, and hands each to it: what it does and how much memory it holds is checked there.
fn mutated_by_target(target: &str, words: &[&str], count: u64) {
    let folder = common::root().join("fuzz/corpus").join(target);
    let mut paths: Vec<_> =
        std::fs::read_dir(folder).expect("the folder is there").map(|e| e.expect("readable").path()).collect();
    paths.sort();
    let examples: Vec<Vec<u8>> = paths.iter().map(|path| std::fs::read(path).expect("it can be read")).collect();
    for seed in 0..times(count) {
        let mut random = Random(seed);
        let mut bytes = examples[random.below(examples.len())].clone();
        mutate(&mut random, &mut bytes, words);
        crate::corpus::targets::run(target, &bytes);
    }
}

#[test]
fn mutated_materials() {
    let words =
        ["newmtl b c\n", "Kd ", "-s 1 ", "map_Kd ", "illum 4\n", "1e999 ", "nan ", "\\\n", "d -halo ", "a.hdr", "\r", " "];
    mutated_by_target("mtl", &words, MODELS);
}

#[test]
fn mutated_models() {
    let words = [
        "0",
        "1",
        "-1",
        "4294967295",
        "1e999",
        "[",
        "]",
        "{",
        "}",
        ",",
        "null",
        "\"nodes\":[0]",
        "\"mesh\":0,",
        "\"count\":400000000,",
        "\"byteOffset\":9,",
        "\"mode\":6,",
        "\"indices\":0,",
        "\"byteStride\":4,",
        "\"normalized\":true,",
        "5126",
        "VEC4",
    ];
    mutated_by_target("gltf", &words, MODELS);
}

#[test]
fn mutated_spectra() {
    let registry = Registry::builtin();
    let examples = [b"# paint\n400 0.5\n\n500.5\t1e-1\n".to_vec(), b"400,0.5\n500,0.25\n".to_vec()];
    mutated_files(&examples, |file| make::<dyn Material>(&registry, file, "diffuse", ParamType::Spectrum, "reflectance"));
}

/// A picture of 4 by 2 texels as PNG, EXR and HDR.
fn picture_examples() -> Vec<Vec<u8>> {
    let size = [4, 2];
    let data: Vec<f32> = (0..24).map(|i| i as f32 / 16.0).collect();
    let channels = ["R", "G", "B"].map(str::to_owned).to_vec();
    let picture = Picture { size, frame: Frame { offset: [0, 0], size }, channels, data };
    let mut exr = Cursor::new(Vec::new());
    picture.write_exr(&mut exr, &[]).expect("the encoder works");
    let mut png = Vec::new();
    bhs::develop::write_png(&mut png, &picture, &Look::default(), &Texts::default()).expect("the encoder works");
    let mut hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 4\n".to_vec();
    hdr.extend((0..32).map(|i| if i % 4 == 3 { 129 } else { 8 * i as u8 }));
    vec![png, exr.into_inner(), hdr]
}

/// A picture of 3 by 2 texels as TGA (plain and packed), PFM and WebP.
fn other_picture_examples() -> Vec<Vec<u8>> {
    let texels: Vec<u8> = (0..18).map(|i| 14 * i).collect();
    let header = |kind: u8| [&[0, 0, kind, 0, 0, 0, 0, 0, 0, 0, 0, 0, 3, 0, 2, 0, 24, 32][..]].concat();
    let plain = [header(2), texels.clone()].concat();
    let packed = [header(10), vec![2], texels[..9].to_vec(), vec![0x82, 1, 2, 3]].concat();
    let numbers: Vec<u8> = texels.iter().flat_map(|t| (f32::from(*t) / 255.0).to_le_bytes()).collect();
    let pfm = [b"PF\n3 2\n-1.0\n".to_vec(), numbers].concat();
    let without_loss = b"RIFF.\x00\x00\x00WEBPVP8L\x22\x00\x00\x00/\x02@\x00\x00/\x20\x16L\xf6\xe6\x8f\x9c\xc48\x8c\xc7\xfc'\xb6\xa1\xa6m\x036\xd4\xf9\x97S#\xfa\x1f\xd3\x0b";
    let with_loss = b"RIFF8\x00\x00\x00WEBPVP8\x20,\x00\x00\x00\xd0\x01\x00\x9d\x01*\x03\x00\x02\x00\x02\xc0L%\xa0\x02\xec\x01\x0e\xfe\x03\xc8\x00\x00\xfe\xf5\xf0\xf1ZJ\x84_\xcbo\xcb\x9a\xdd\xc6\x96\x02\xec\x00\x00\x00";
    vec![plain, packed, pfm, without_loss.to_vec(), with_loss.to_vec()]
}

#[test]
fn mutated_pictures_of_other_kinds() {
    let examples = other_picture_examples();
    for example in &examples {
        assert!(bhs_textures::decode::decode(example).is_ok(), "{example:?}");
    }
    let words = ["PF\n", "Pf\n", "-1.0\n", "65535 65535\n", "RIFF", "VP8X", "VP8 ", "ALPH", "\u{1}", "\u{7f}", "\0\0"];
    let (mut faulty, count) = (0, times(FILES));
    for seed in 0..count {
        let mut random = Random(seed);
        let mut bytes = examples[random.below(examples.len())].clone();
        mutate(&mut random, &mut bytes, &words);
        // What a byte may stand for: 65,536 even texels of a WebP, a run of 64 of a TGA; each for a moment twice, as four bytes and as three.
        let a_byte = if bytes.starts_with(b"RIFF") { 65_536 } else { 64 } * 12;
        let most = allocation_counter::measure(|| faulty += u64::from(bhs_textures::decode::decode(&bytes).is_err())).bytes_max;
        assert!(most <= (BYTES_BESIDES + a_byte * bytes.len()) as u64, "{most} bytes of memory: {bytes:?}");
    }
    assert!(faulty > count / 10 && faulty < count, "{faulty}");
}

#[test]
fn mutated_pictures_in_scenes() {
    // The same file is a sky, a colour and a number.
    let text = r#"LightTransport "path" "integer maxdepth" 2 Film "rgb" "integer xresolution" 2 "integer yresolution" 2
        Sampler "independent" "integer pixelsamples" 1 Option "string intersector" "reference" LookAt 0 0 -3 0 0 0 0 1 0
        WorldBegin LightSource "infinite" "string filename" "picture"
        Texture "c" "spectrum" "imagemap" "string filename" "picture" Texture "n" "float" "imagemap" "string filename" "picture"
        Material "conductor" "texture reflectance" "c" "texture roughness" "n" Shape "sphere""#;
    let (folder, registry) = (tempfile::tempdir().expect("a folder"), Registry::builtin());
    let (scene, picture) = (folder.path().join("scene.bhs"), folder.path().join("picture"));
    std::fs::write(&scene, text).expect("a file");
    let make = |bytes: &[u8]| {
        std::fs::write(&picture, bytes).expect("a file");
        let mut sources = SourceMap::new();
        let made = lang::load(&scene, &registry, &Overrides::default(), &mut sources);
        match &made {
            Ok(built) => drop(bhs::render::render_quietly(built)),
            Err(found) => assert!(found.iter().all(|d| ["bad-file", "unreadable"].contains(&d.code)), "{found:?}"),
        }
        made.is_ok()
    };
    let examples = picture_examples();
    assert!(examples.iter().all(|e| make(e)));
    let mut faulty = 0;
    for seed in 0..times(PICTURES) {
        let mut random = Random(seed);
        let mut bytes = examples[random.below(examples.len())].clone();
        mutate(&mut random, &mut bytes, FILE_WORDS);
        within_memory(bytes.len(), &bytes, || faulty += u64::from(!make(&bytes)));
    }
    assert!(faulty > times(PICTURES) / 10 && faulty < times(PICTURES), "{faulty}");
}

#[test]
fn mutated_pictures_to_compare() {
    let folder = "plugins/textures/tests/data";
    let mut paths: Vec<_> =
        std::fs::read_dir(folder).expect("the folder is there").map(|e| e.expect("readable").path()).collect();
    paths.sort();
    paths.retain(|p| p.extension().is_some_and(|e| e == "exr"));
    let examples: Vec<Vec<u8>> = paths.iter().map(|p| std::fs::read(p).expect("it is read")).collect();
    assert!(examples.len() > 20);
    let mut faulty = 0;
    for seed in 0..times(FILES) {
        let mut random = Random(seed);
        let bytes = &mut examples[random.below(examples.len())].clone();
        mutate(&mut random, bytes, FILE_WORDS);
        // As textures and skies read it, too.
        within_memory(bytes.len(), &bytes, || {
            faulty += u64::from(bhs_textures::decode::exr::read_all(bytes).is_err());
            let _ = bhs_textures::decode::decode(bytes);
        });
    }
    assert!(faulty > times(FILES) / 10 && faulty < times(FILES), "{faulty}");
}

#[test]
fn a_sky_takes_no_more_memory_than_its_picture() {
    // As a PNG of one colour, which is three hundred times smaller than its texels; and as light.
    let size = [2048, 1024];
    let texels = size[0] * size[1];
    let mut png = Vec::new();
    bhs::image::write_rows(&mut png, size, false, &[], |_, row| row.extend([77; 3].repeat(size[0]))).expect("the encoder works");
    let mut hdr = b"#?RGBE\n\n-Y 1024 +X 2048\n".to_vec();
    hdr.extend([128; 4].repeat(texels));
    let (folder, registry) = (tempfile::tempdir().expect("a folder"), Registry::builtin());
    let scene = folder.path().join("scene.bhs");
    let text = r#"WorldBegin LightSource "infinite" "string filename" "picture" Shape "sphere""#;
    std::fs::write(&scene, text).expect("a file");
    for (bytes, a_texel) in [(png, 3), (hdr, 12)] {
        std::fs::write(folder.path().join("picture"), &bytes).expect("a file");
        // The table to draw from has a number for 16 texels.
        let most = bytes.len() + a_texel * texels + texels / 4 + BYTES_BESIDES;
        let load = || {
            let made = lang::load(&scene, &registry, &Overrides::default(), &mut SourceMap::new());
            assert!(made.is_ok_and(|built| built.warnings.is_empty()));
        };
        let found = allocation_counter::measure(load).bytes_max;
        assert!(found <= most as u64, "{found} bytes, at most {most}");
    }
}

/// One mesh in every way that a PLY file can be written.
fn ply_examples() -> Vec<Vec<u8>> {
    let text = common::read("grammar/examples/pyramid.ply");
    let (header, _) = text.split_once("end_header\n").expect("it has a header");
    let binary = |format: &str, float: fn(f32) -> [u8; 4], int: fn(i32) -> [u8; 4]| {
        let mut bytes = header.replace("ascii", format).into_bytes();
        bytes.extend(b"end_header\n");
        for p in [[-1.0, 0.0, -1.0], [1.0, 0.0, -1.0], [1.0, 0.0, 1.0], [-1.0, 0.0, 1.0], [0.0, 1.0, 0.0]] {
            bytes.extend(p.into_iter().flat_map(float));
        }
        for face in [&[0, 1, 2, 3][..], &[0, 4, 1], &[1, 4, 2], &[2, 4, 3], &[3, 4, 0]] {
            bytes.push(face.len() as u8);
            bytes.extend(face.iter().flat_map(|i| int(*i)));
        }
        bytes
    };
    let little = binary("binary_little_endian", f32::to_le_bytes, i32::to_le_bytes);
    let big = binary("binary_big_endian", f32::to_be_bytes, i32::to_be_bytes);
    vec![text.into_bytes(), little, big]
}

#[test]
fn a_file_of_one_character_is_read_quickly() {
    // What is opened again and again and never closed must not be looked at again and again.
    for word in [
        "[",
        "\"",
        "]",
        "#",
        "A [ ",
        "A [ 1 ",
        "A \"",
        "A [ \"a\" ",
        "\"float a\" ",
        "A \"float a\" [ 1 ",
        "AttributeBegin ",
        "Shape \"sphere\" ",
        "\\",
        "x ",
    ] {
        let text = word.repeat(200_000 / word.len());
        let mut directives = Directives::new(&text, 0);
        let count = directives.by_ref().count();
        assert!(count <= text.len() && directives.into_faults().len() <= text.len());
    }
}
