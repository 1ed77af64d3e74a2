//! glTF files as files: how numbers are kept, what is left out and at fault, whole files as scenes.

use super::gltf::{Maker, square};
use super::{load, pixels, world};
use crate::common::program::Folder;
use bhs::lang::Overrides;
use bhs_models::{Model, mesh};
use glam::DVec3;
use std::sync::Arc;

const ONE_NODE: &str = r#""nodes":[{"mesh":0}]"#;

/// The triangles of the first mesh of a file.
fn triangles(file: &[u8]) -> Result<Vec<[DVec3; 3]>, String> {
    let model = Model::parse(file)?;
    let read = |name: &str| if name == "my file.bin" { Ok(Arc::new(vec![0; 9])) } else { Err("no such file".to_owned()) };
    let mesh = mesh::triangles(&model, 0, 0, mesh::Attributes::default(), &read)?;
    Ok(mesh.triangles.iter().map(|t| t.map(|v| mesh.positions[v as usize])).collect())
}

fn primitive(maker: &Maker, primitive: &str) -> Vec<u8> {
    maker.file(&format!(r#""meshes":[{{"name":"box","primitives":[{{{primitive}}}]}}],{ONE_NODE}"#))
}

fn points(all: &[[f64; 3]]) -> Vec<DVec3> {
    all.iter().map(|p| DVec3::from_array(*p)).collect()
}

#[test]
fn numbers_are_read_however_they_are_kept() {
    let (o, x, y, xy) = ([0.0f32, 0.0, 0.0], [1.0f32, 0.0, 0.0], [0.0f32, 1.0, 0.0], [1.0f32, 1.0, 0.0]);
    let bytes = |all: &[[f32; 3]], gap: usize| -> Vec<u8> {
        all.iter().flat_map(|p| p.iter().flat_map(|v| v.to_le_bytes()).chain(vec![7; gap]).collect::<Vec<u8>>()).collect()
    };
    let expected = points(&[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    let check = |name: &str, maker: &Maker, of: usize, more: &str| {
        let read = triangles(&primitive(maker, &format!(r#""attributes":{{"POSITION":{of}}}{more}"#)))
            .unwrap_or_else(|e| panic!("{name}: {e}"));
        assert_eq!(read, [[expected[0], expected[1], expected[2]]], "{name}");
    };
    let mut maker = Maker::default();
    let view = maker.view(&bytes(&[o, x, y], 4), r#","byteStride":16"#);
    let of = maker.accessor(view, 5126, "VEC3", 3, "");
    check("a stride", &maker, of, "");
    let mut maker = Maker::default();
    let view = maker.view(&[vec![9; 8], bytes(&[o, x, y], 0)].concat(), "");
    let of = maker.accessor(view, 5126, "VEC3", 3, r#","byteOffset":8"#);
    check("an offset", &maker, of, "");
    for (component, one, normalized) in [
        (5120, vec![127u8], true),
        (5121, vec![255], true),
        (5122, vec![255, 127], true),
        (5123, vec![255, 255], true),
        (5121, vec![1], false),
        (5123, vec![1, 0], false),
    ] {
        let zero = vec![0; one.len()];
        let element = |p: [f32; 3]| -> Vec<u8> {
            p.iter()
                .flat_map(|v| if *v == 1.0 { one.clone() } else { zero.clone() })
                .chain(vec![0; 4 * one.len() - 3 * one.len()])
                .collect()
        };
        let mut maker = Maker::default();
        let view = maker.view(&[element(o), element(x), element(y)].concat(), &format!(r#","byteStride":{}"#, 4 * one.len()));
        let of = maker.accessor(view, component, "VEC3", 3, if normalized { r#","normalized":true"# } else { "" });
        check(&format!("{component} {normalized}"), &maker, of, "");
    }
    for (component, width) in [(5121, 1usize), (5123, 2), (5125, 4)] {
        let mut maker = Maker::default();
        let view = maker.view(&bytes(&[y, o, x], 0), "");
        let of = maker.accessor(view, 5126, "VEC3", 3, "");
        let order: Vec<u8> = [1u8, 2, 0].iter().flat_map(|i| [vec![*i], vec![0; width - 1]].concat()).collect();
        let view = maker.view(&order, "");
        let indices = maker.accessor(view, component, "SCALAR", 3, "");
        check(&format!("indices {component}"), &maker, of, &format!(r#","indices":{indices}"#));
    }
    // Sparse values, over others and over nothing.
    for base in [true, false] {
        let mut maker = Maker::default();
        let view = maker.view(&bytes(&[o, xy, xy], 0), "");
        let (at, by) = (maker.view(&[1, 2], ""), maker.view(&bytes(&[x, y], 0), ""));
        let sparse = format!(
            r#","sparse":{{"count":2,"indices":{{"bufferView":{at},"componentType":5121}},"values":{{"bufferView":{by}}}}}"#
        );
        let of = maker.accessor(view, 5126, "VEC3", 3, &sparse);
        let file = primitive(&maker, &format!(r#""attributes":{{"POSITION":{of}}}"#));
        let text = String::from_utf8(file).expect("text");
        let text = if base {
            text
        } else {
            text.replace(&format!(r#""bufferView":{view},"componentType":5126"#), r#""componentType":5126"#)
        };
        assert_eq!(triangles(text.as_bytes()).expect("it is read"), [[expected[0], expected[1], expected[2]]], "{base}");
    }
}

#[test]
fn strips_and_fans_keep_their_sides() {
    let five = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0], [0.0, 2.0, 0.0]];
    let flat: Vec<f32> = five.iter().flatten().map(|v| *v as f32).collect();
    let mut maker = Maker::default();
    let of = maker.floats("VEC3", &flat);
    let p = points(&five);
    let read = |mode: u32| triangles(&primitive(&maker, &format!(r#""attributes":{{"POSITION":{of}}},"mode":{mode}"#)));
    assert_eq!(read(5), Ok(vec![[p[0], p[1], p[2]], [p[1], p[3], p[2]], [p[2], p[3], p[4]]]));
    assert!(read(5).expect("read").iter().all(|[a, b, c]| (*b - *a).cross(*c - *a).z > 0.0));
    assert_eq!(read(6), Ok(vec![[p[1], p[2], p[0]], [p[2], p[3], p[0]], [p[3], p[4], p[0]]]));
    assert_eq!(read(4), Ok(vec![[p[0], p[1], p[2]]]));
    assert_eq!(read(1), Err("mesh 0 `box`, primitive 0 is lines, which have no surface".to_owned()));
}

#[test]
fn faults_are_told_with_their_place() {
    let (maker, good) = square();
    let file = |primitive_text: &str| String::from_utf8(primitive(&maker, primitive_text)).expect("text");
    let whole = file(&good);
    assert!(triangles(whole.as_bytes()).is_ok());
    let check = |from: &str, to: &str, expected: &str| {
        assert!(whole.contains(from), "{from}");
        let found = triangles(whole.replacen(from, to, 1).as_bytes()).expect_err(to);
        assert!(found.contains(expected), "{to}: {found}");
    };
    check(r#""count":4"#, r#""count":400000000"#, "mesh 0 `box`, primitive 0: its accessor 0 reaches out of its buffer view");
    check(r#""bufferView":0"#, r#""bufferView":77"#, "it is damaged at accessors[0].bufferView");
    check(r#""byteLength":48"#, r#""byteLength":4800"#, "its buffer 0 ends before buffer view 0 does");
    check(r#""byteOffset":0,"byteLength":48"#, r#""byteOffset":18446744073709551615,"byteLength":48"#, "");
    check(
        r#""bufferView":0,"componentType":5126,"type":"VEC3","count":4"#,
        r#""componentType":5126,"type":"VEC3","count":4000000000"#,
        "has more elements than its file has bytes",
    );
    check(r#""bufferView":0,"#, r#""bufferView":0,"byteOffset":18446744073709551000,"#, "reaches out of its buffer view");
    check(r#""type":"VEC3""#, r#""type":"MAT4""#, "");
}

#[test]
fn damaged_files_are_told() {
    let fault = |bytes: &[u8]| Model::parse(bytes).map(|_| ()).expect_err("it is damaged");
    assert_eq!(fault(b""), "it is neither glTF (JSON) nor GLB");
    assert_eq!(fault(b"glTF\x02\0\0"), "it is cut off within its header");
    assert_eq!(fault(b"glTF\x01\0\0\0\x0c\0\0\0"), "it is GLB of version 1; there is 2");
    assert_eq!(fault(b"glTF\x02\0\0\0\xff\xff\xff\xff"), "it is cut off: it says that it has 4294967295 bytes, and has 12");
    assert_eq!(fault(b"glTF\x02\0\0\0\x0c\0\0\0"), "it has no JSON");
    assert_eq!(fault(b"glTF\x02\0\0\0\x14\0\0\0\xff\xff\xff\xffJSON"), "it is cut off within the chunk at byte 12");
    assert!(fault(b"{}").starts_with("its JSON is no glTF 2.0: missing field `asset`"));
    assert!(fault(br#"{"asset":{"version":"1.0"}}"#).contains("version"));
    let said = |file: &[u8], shape: &str| world(&[("m.gltf", file.to_vec())], shape).1;
    let shape = r#"Shape "gltf" "string filename" "m.gltf""#;
    assert_eq!(said(b"{", shape)[0].split(':').next(), Some("cannot read `m.gltf`"));
    assert_eq!(said(br#"{"asset":{"version":"2.0"}}"#, shape), ["nothing of `m.gltf` can be shown: it has no mesh in its scene"]);
    let (maker, good) = square();
    let missing = maker.json(r#","uri":"no.bin""#, &format!(r#""meshes":[{{"primitives":[{{{good}}}]}}],{ONE_NODE}"#));
    assert_eq!(
        said(missing.as_bytes(), shape),
        ["cannot read `m.gltf`: mesh 0, primitive 0: cannot read its buffer `no.bin`: there is no such file"]
    );
    let one = |more: &str| said(&primitive(&maker, &good), &format!("{shape} {more}"));
    assert_eq!(one(r#""integer mesh" 3"#), ["cannot read `m.gltf`: it has no mesh 3: it has 1, counted from 0"]);
    assert_eq!(one(r#""integer mesh" 0 "integer primitive" 1"#), ["cannot read `m.gltf`: it has no mesh 0 `box`, primitive 1"]);
}

#[test]
fn what_is_left_out_is_told() {
    let (maker, good) = square();
    let rest = format!(
        r#""meshes":[{{"primitives":[{{{good},"material":0,"targets":[{{"POSITION":0}}]}},{{{good},"mode":1}}]}}],
        "extensionsUsed":["KHR_materials_sheen"],"extensionsRequired":["X_unknown"],"skins":[{{"joints":[0]}}],
        "animations":[{{"channels":[],"samplers":[]}}],"materials":[{{"name":"cloth","normalTexture":{{"index":0}},"extensions":{{"KHR_materials_sheen":{{}}}}}}],
        "textures":[{{"source":0}}],"images":[{{"uri":"lost.png"}}],"nodes":[{{"mesh":0,"skin":0,"children":[1]}},{{"mesh":0,"scale":[0,1,1]}}],"scenes":[{{"nodes":[0,1]}}]"#
    );
    let (built, said) = world(&[("m.gltf", maker.file(&rest))], r#"Shape "gltf" "string filename" "m.gltf""#);
    assert!(built.is_some(), "{said:?}");
    let expected = [
        "`m.gltf`: not read are skins: figures stand as they were modelled, not as they are posed",
        "`m.gltf`: not read are morph targets: meshes have their first shape",
        "`m.gltf`: not read are animations: everything stands where it was exported",
        "`m.gltf`: not read are extensions that it requires: `X_unknown`",
        "`m.gltf`: not read are 1 nodes that have several parents",
        "`m.gltf`: sheen are left out of `0 cloth`",
        "pictures of `m.gltf` are not there: `lost.png`: its materials do without them",
        "1 part of `m.gltf` cannot be read: lines, which have no surface: the picture lacks them",
        "1 nodes of `m.gltf` have no size, and are not there: their transforms flatten space",
    ];
    assert_eq!(said, expected);
    let packed = maker.file(&format!(
        r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":3}},"extensions":{{"KHR_draco_mesh_compression":{{"bufferView":0,"attributes":{{}}}}}}}}]}}],"extensionsRequired":["KHR_draco_mesh_compression"],{ONE_NODE}"#
    ));
    let packed = String::from_utf8(packed).expect("text").replacen(r#""accessors":["#, r#""accessors":[{"componentType":5126,"type":"VEC3","count":3,"min":[0,0,0],"max":[1,1,1]},{"componentType":5126,"type":"VEC3","count":3,"min":[0,0,0],"max":[1,1,1]},{"componentType":5126,"type":"VEC3","count":3,"min":[0,0,0],"max":[1,1,1]},{"componentType":5126,"type":"VEC3","count":3,"min":[0,0,0],"max":[1,1,1]},"#, 1);
    let said = world(&[("m.gltf", packed.into_bytes())], r#"Shape "gltf" "string filename" "m.gltf""#).1;
    let expected = "nothing of `m.gltf` can be shown: none of its meshes can be read";
    assert!(said.iter().any(|s| s == expected) && said.iter().any(|s| s.contains("compressed by Draco")), "{said:?}");
}

/// A file with two cameras, one of them turned, and a point light.
fn with_cameras() -> (Maker, String) {
    let (maker, good) = square();
    let rest = format!(
        r#""meshes":[{{"primitives":[{{{good},"material":0}}]}}],"materials":[{{"doubleSided":true,"pbrMetallicRoughness":{{"metallicFactor":0,"baseColorFactor":[0.8,0.2,0.2,1]}}}}],
        "cameras":[{{"type":"perspective","name":"own","perspective":{{"yfov":0.8,"znear":0.1,"aspectRatio":1.5}}}},{{"type":"orthographic","orthographic":{{"xmag":1.5,"ymag":1,"znear":0.1,"zfar":10}}}}],
        "extensionsUsed":["KHR_lights_punctual"],"extensions":{{"KHR_lights_punctual":{{"lights":[{{"type":"point","intensity":5}}]}}}},
        "scenes":[{{"nodes":[0,1,2,3]}}],"nodes":[{{"mesh":0,"translation":[0.5,0,0]}},{{"name":"from the front","camera":0,"translation":[0,0,4]}},
        {{"camera":1,"translation":[-4,0,0],"rotation":[0,-0.7071067811865476,0,0.7071067811865476]}},{{"translation":[-1,1,2],"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}]"#
    );
    (maker, rest)
}

#[test]
fn a_file_is_a_scene_with_its_cameras_and_not_mirrored() {
    let (maker, rest) = with_cameras();
    let json = maker.json("", &rest);
    let mut json_chunk = json.into_bytes();
    json_chunk.resize(json_chunk.len().next_multiple_of(4), b' ');
    let mut binary = maker.buffer().to_vec();
    binary.resize(binary.len().next_multiple_of(4), 0);
    let chunk = |kind: &[u8; 4], content: &[u8]| [&(content.len() as u32).to_le_bytes()[..], kind, content].concat();
    let chunks = [chunk(b"JSON", &json_chunk), chunk(b"BIN\0", &binary)].concat();
    let glb = [&b"glTF\x02\0\0\0"[..], &(chunks.len() as u32 + 12).to_le_bytes(), &chunks].concat();
    let files = [("m.gltf", maker.file(&rest)), ("m.glb", glb)];
    let quick =
        Overrides { spp: Some(4), resolution: Some([30, 20]), camera: Some("from the front".into()), ..Overrides::default() };
    let built = ["m.gltf", "m.glb"].map(|name| load(&files, name, &quick).unwrap_or_else(|found| panic!("{found:?}")));
    let [text, binary] = built.each_ref().map(pixels);
    assert_eq!(text, binary);
    assert!(built[0].warnings.is_empty(), "{:?}", built[0].warnings);
    // The square stands to the right of the camera's axis, which looks along -z: x to the right.
    let brightness = |columns: std::ops::Range<usize>| -> f32 {
        columns.flat_map(|x| (0..20).map(move |y| (x, y))).map(|(x, y)| text[3 * (30 * y + x)]).sum()
    };
    assert!(brightness(15..30) > 1.2 * brightness(0..15), "{} {}", brightness(0..15), brightness(15..30));
    // 0.8 rad over the height at distance 4: the square's edges are where they are expected. Its left edge is at -0.5, the right one at 1.5.
    let tan = (0.4f64).tan() * 4.0;
    let column = |x: f64| (0.5 + 0.5 * x / (1.5 * tan)) * 30.0;
    let lit = |x: usize| text[3 * (30 * 10 + x)] > 0.0;
    let edges = (0..30).filter(|x| lit(*x)).fold((30, 0), |(low, high), x| (low.min(x), high.max(x)));
    assert!(
        (edges.0 as f64 - column(-0.5)).abs() <= 1.0 && (edges.1 as f64 + 1.0 - column(1.5)).abs() <= 1.0,
        "{edges:?} {} {}",
        column(-0.5),
        column(1.5)
    );
    // All cameras, by the names of their nodes or their own.
    let all = load(&files, "m.gltf", &Overrides { camera: None, ..quick }).unwrap_or_else(|found| panic!("{found:?}"));
    assert_eq!(all.camera_names().map(|n| n.unwrap_or_default().to_owned()).collect::<Vec<_>>(), ["from the front", "camera 1"]);
}

#[test]
fn files_that_are_added_stand_in_the_coordinates_of_the_model() {
    let (maker, rest) = with_cameras();
    let folder = Folder::new("");
    folder.write("m.gltf", maker.file(&rest));
    folder.write("ball.bhs", "Material \"diffuse\" \"rgb reflectance\" [0 0 1] Translate -0.8 0 1\nAreaLightSource \"diffuse\" \"rgb L\" [0 0 9] Shape \"sphere\" \"float radius\" 0.3\n");
    folder.write("hole.bhs", "BlackHole \"schwarzschild\" \"float rs\" 0.2 \"point3 center\" [-0.8 0 1]\n");
    let quick = ["--resolution", "30x20", "--spp", "4", "--camera", "from the front", "--quiet"];
    let render = |add: &str, out: &str| {
        let outcome = folder.run(&[&["render", "m.gltf", "--include", add, "-o", out], &quick[..]].concat());
        assert_eq!(outcome.code, 0, "{}", outcome.err);
        let picture = bhs::image::Picture::read_exr(&folder.at(out)).expect("a picture");
        let blue = picture.channels.iter().position(|c| c == "B").expect("a channel");
        // The ball alone is brighter than 2.
        let bright = |x: usize, y: usize| Some(picture.pixel(x, y)[blue]).filter(|v| *v > 2.0).unwrap_or(0.0);
        let [w, h] = picture.size;
        (0..w).map(|x| (0..h).map(|y| bright(x, y)).sum::<f32>()).collect::<Vec<f32>>()
    };
    // The ball is left of the axis and nearer than the square, as (-0.8, 0, 1) of the file is.
    let blue = render("ball.bhs", "ball.exr");
    let middle = blue.iter().enumerate().map(|(x, v)| x as f32 * v).sum::<f32>() / blue.iter().sum::<f32>();
    let expected = (0.5 - 0.5 * 0.8 / (1.5 * 3.0 * 0.4f32.tan())) * 30.0;
    assert!((middle + 0.5 - expected).abs() < 1.5, "{middle} {expected}");
    render("hole.bhs", "hole.exr");
    // What is converted is the same scene, and so is what is checked.
    assert_eq!(folder.run(&["convert", "m.gltf", "--include", "ball.bhs", "-o", "sub.bhs"]).code, 0);
    assert_eq!(folder.run(&["check", "m.gltf", "sub.bhs"]).code, 0);
    let outcome = folder.run(&[&["render", "sub.bhs", "-o", "again.exr"], &quick[..]].concat());
    assert_eq!(outcome.code, 0, "{}", outcome.err);
    let data = |name: &str| bhs::image::Picture::read_exr(&folder.at(name)).expect("a picture").data;
    assert_eq!(data("again.exr"), data("ball.exr"));
}

#[test]
fn every_step_of_the_page_about_blender_works() {
    let page = crate::common::read("docs/blender.md");
    let folder = Folder::new("");
    folder.write("grammar/examples/scene.gltf", crate::common::read("grammar/examples/scene.gltf"));
    for part in crate::common::examples::blocks(&page, "bhs-part") {
        let name = part.lines().next().and_then(|line| line.strip_prefix("# ")).expect("its name");
        folder.write(name, part);
    }
    let commands: Vec<&str> = page.lines().filter_map(|line| line.strip_prefix("    bhs ")).collect();
    assert!(commands.len() > 4);
    for command in commands {
        // Small pictures do, and the denoiser may not be there.
        let mut words: Vec<&str> = command.split_whitespace().filter(|word| *word != "--denoise").collect();
        if words[0] == "render" {
            words.extend(["--quiet", "--resolution", "16x12"]);
            if !words.contains(&"--spp") {
                words.extend(["--spp", "1"]);
            }
        }
        let outcome = folder.run(&words);
        assert_eq!((outcome.code, outcome.err.contains("error: ")), (0, false), "{command}\n{}", outcome.err);
    }
    assert!(folder.files().iter().any(|name| name == "final.exr"));
}

#[test]
fn a_file_without_cameras_and_lights_is_seen_whole_with_a_note() {
    let (maker, good) = square();
    let file = primitive(&maker, &good);
    let quick = Overrides { spp: Some(4), resolution: Some([24, 18]), ..Overrides::default() };
    let built = load(&[("m.gltf", file)], "m.gltf", &quick).unwrap_or_else(|found| panic!("{found:?}"));
    let said: Vec<&str> = built.warnings.iter().map(|d| d.message.as_str()).collect();
    assert_eq!(
        said,
        [
            "`m.gltf`: it has no camera: one that looks at the whole is made",
            "`m.gltf`: it has no light: an even white sky is made"
        ]
    );
    // Bright sky all around, and the square, which lacks what facets lose to one another, in the middle.
    let seen = pixels(&built);
    let [edge, middle] = [seen[0], seen[3 * (24 * 9 + 12)]];
    assert!((edge - 1.0).abs() < 0.05 && middle < 0.95, "{edge} {middle}");
}
