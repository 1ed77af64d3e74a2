//! What glTF files bring: each feature against the scene that somebody would have written by hand.

use super::{same, world};

/// A glTF file under way: its buffer, and what describes it.
#[derive(Default)]
pub struct Maker {
    buffer: Vec<u8>,
    views: Vec<String>,
    accessors: Vec<String>,
}

impl Maker {
    /// Adds a view of bytes; its number.
    pub fn view(&mut self, bytes: &[u8], more: &str) -> usize {
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        let start = self.buffer.len();
        self.buffer.extend(bytes);
        self.views.push(format!(r#"{{"buffer":0,"byteOffset":{start},"byteLength":{}{more}}}"#, bytes.len()));
        self.views.len() - 1
    }

    /// Adds an accessor of what is in a view.
    pub fn accessor(&mut self, view: usize, component: u32, ty: &str, count: usize, more: &str) -> usize {
        // Places state what they reach to.
        let reach = if ty == "VEC3" && !more.contains("min") { r#","min":[-1,-1,0],"max":[1,1,0]"# } else { "" };
        self.accessors
            .push(format!(r#"{{"bufferView":{view},"componentType":{component},"type":"{ty}","count":{count}{more}{reach}}}"#));
        self.accessors.len() - 1
    }

    /// Adds an accessor of numbers of single precision.
    pub fn floats(&mut self, ty: &str, values: &[f32]) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes, "");
        let size = ["SCALAR", "VEC2", "VEC3", "VEC4"].iter().position(|t| *t == ty).expect("a type") + 1;
        self.accessor(view, 5126, ty, values.len() / size, r#","min":[-1,-1,0],"max":[1,1,0]"#)
    }

    pub fn buffer(&self) -> &[u8] {
        &self.buffer
    }

    /// The JSON, with `rest` beside what has been added; `uri` is where the buffer is.
    pub fn json(&self, uri: &str, rest: &str) -> String {
        let (views, accessors) = (self.views.join(","), self.accessors.join(","));
        format!(
            r#"{{"asset":{{"version":"2.0"}},"buffers":[{{"byteLength":{}{uri}}}],"bufferViews":[{views}],"accessors":[{accessors}],{rest}}}"#,
            self.buffer.len()
        )
    }

    /// The file with its buffer in it.
    pub fn file(&self, rest: &str) -> Vec<u8> {
        let bytes: String = self.buffer.iter().map(|b| format!("%{b:02x}")).collect();
        self.json(&format!(r#","uri":"data:application/octet-stream,{bytes}""#), rest).into_bytes()
    }
}

const CORNERS: [f32; 12] = [-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.0];

/// A square that faces +z of the file, which is where the viewer is, with texture coordinates from its upper left corner.
pub fn square() -> (Maker, String) {
    let mut maker = Maker::default();
    let p = maker.floats("VEC3", &CORNERS);
    let uv = maker.floats("VEC2", &[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    let view = maker.view(&[0, 1, 2, 0, 2, 3], "");
    let indices = maker.accessor(view, 5121, "SCALAR", 6, "");
    let primitive = format!(r#""attributes":{{"POSITION":{p},"TEXCOORD_0":{uv}}},"indices":{indices}"#);
    (maker, primitive)
}

const ONE_NODE: &str = r#""scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}]"#;
const SHAPE: &str = r#"Shape "gltf" "string filename" "in/m.gltf""#;
/// The same square by hand.
const SQUARE: &str = r#"Shape "trianglemesh" "point3 P" [-1 -1 0  1 -1 0  1 1 0  -1 1 0] "integer indices" [0 1 2  0 2 3] "point2 uv" [0 0  1 0  1 1  0 1]"#;
const TURNED: &str = "Scale 1 1 -1";

fn files(file: Vec<u8>) -> Vec<(&'static str, Vec<u8>)> {
    vec![("in/m.gltf", file)]
}

/// A square with a material (JSON), and more of the file.
fn with_material(material: &str, more: &str) -> Vec<(&'static str, Vec<u8>)> {
    let (maker, primitive) = square();
    let mesh = format!(r#""meshes":[{{"primitives":[{{{primitive},"material":0}}]}}],"materials":[{{{material}}}]"#);
    files(maker.file(&format!("{mesh},{ONE_NODE}{more}")))
}

#[test]
fn the_square_is_where_and_what_it_is() {
    let white = r#"Material "principled" "rgb reflectance" [1 1 1] "float metallic" 1 "float roughness" 1 "bool twosided" false"#;
    let (maker, primitive) = square();
    let file = maker.file(&format!(r#""meshes":[{{"primitives":[{{{primitive}}}]}}],{ONE_NODE}"#));
    same("default material", &files(file), [SHAPE, &format!("{white} {TURNED} {SQUARE}")]);
    let own = r#"Material "diffuse" "rgb reflectance" [0.9 0.1 0.1]"#;
    let (found, expected) = (format!(r#"{own} {SHAPE} "bool materials" false"#), format!("{own} {TURNED} {SQUARE}"));
    same("no materials", &with_material(r#""name":"x""#, ""), [&found, &expected]);
}

#[test]
fn transforms_and_instances_stand_where_the_file_says() {
    let (maker, primitive) = square();
    let mesh = format!(
        r#""meshes":[{{"primitives":[{{{primitive},"material":0}}]}}],"materials":[{{"pbrMetallicRoughness":{{"metallicFactor":0,"baseColorFactor":[0.8,0.3,0.2,1]}},"doubleSided":true}}]"#
    );
    let paint = r#"Material "principled" "rgb reflectance" [0.8 0.3 0.2] "float roughness" 1"#;
    let turn = (30f64.to_radians() / 2.0).sin_cos();
    let nodes = format!(
        r#""scenes":[{{"nodes":[0,3]}}],"nodes":[{{"translation":[0.5,0,0],"children":[1,2]}},{{"mesh":0,"scale":[0.3,0.5,1],"rotation":[0,{},0,{}]}},
        {{"mesh":0,"matrix":[0.2,0,0,0,0,-0.2,0,0,0,0,0.2,0,-1,0.5,0.25,1]}},{{"mesh":0,"scale":[0.1,0.1,0.1],"translation":[0,-0.5,1]}},{{"mesh":0}}]"#,
        turn.0, turn.1
    );
    let expected = format!(
        "{paint} {TURNED} AttributeBegin Translate 0.5 0 0 Rotate 30 0 1 0 Scale 0.3 0.5 1 {SQUARE} AttributeEnd
        AttributeBegin Translate 0.5 0 0 Translate -1 0.5 0.25 Scale 0.2 -0.2 0.2 {SQUARE} AttributeEnd Translate 0 -0.5 1 Scale 0.1 0.1 0.1 {SQUARE}"
    );
    let all = files(maker.file(&format!("{mesh},{nodes}")));
    same("nodes", &all, [SHAPE, &expected]);
    // One mesh that three nodes have is kept once.
    let built = world(&all, SHAPE).0.expect("no faults");
    assert_eq!((built.load.instances, built.load.triangles), (3, 2));
    let moved = format!("Translate 0 0.3 0 Rotate 20 0 0 1 {SHAPE}");
    let expected = format!("Translate 0 0.3 0 Rotate 20 0 0 1 {expected}");
    same("under a transform", &all, [&moved, &expected]);
    // Within an object everything is written out.
    let object = format!("ObjectBegin \"o\" {SHAPE} ObjectEnd Translate 0 0.1 0 ObjectInstance \"o\"");
    same(
        "in an object",
        &all,
        [&object, &format!("Translate 0 0.1 0 {}", expected.replacen("Translate 0 0.3 0 Rotate 20 0 0 1", "", 1))],
    );
}

#[test]
fn materials_are_principled() {
    let table = [
        (
            r#""pbrMetallicRoughness":{"baseColorFactor":[0.8,0.2,0.1,0.5],"metallicFactor":0.25,"roughnessFactor":0.5}"#,
            r#""rgb reflectance" [0.8 0.2 0.1] "float metallic" 0.25 "float roughness" 0.5 "bool twosided" false"#,
        ),
        (
            r#""doubleSided":true,"extensions":{"KHR_materials_ior":{"ior":1.8}},"pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0.3}"#,
            r#""rgb reflectance" [1 1 1] "float eta" 1.8 "float roughness" 0.3"#,
        ),
        (
            r#""extensions":{"KHR_materials_transmission":{"transmissionFactor":0.75}},"pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0.3,"baseColorFactor":[0.2,0.9,0.3,1]}"#,
            r#""rgb reflectance" [0.2 0.9 0.3] "float transmission" 0.75 "bool thin" true "float roughness" 0.3"#,
        ),
        (
            r#""extensions":{"KHR_materials_transmission":{"transmissionFactor":1},"KHR_materials_volume":{"thicknessFactor":1}},"pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0.5}"#,
            r#""rgb reflectance" [1 1 1] "float transmission" 1 "float roughness" 0.5"#,
        ),
        (
            r#""doubleSided":true,"extensions":{"KHR_materials_clearcoat":{"clearcoatFactor":0.5,"clearcoatRoughnessFactor":0.4},"KHR_materials_specular":{"specularFactor":0.5}},"pbrMetallicRoughness":{"metallicFactor":0,"baseColorFactor":[0.1,0.1,0.4,1]}"#,
            r#""rgb reflectance" [0.1 0.1 0.4] "float roughness" 1 "float clearcoat" 0.5 "float clearcoatroughness" 0.4 "float specular" 0.5"#,
        ),
    ];
    for (material, expected) in table {
        let expected = format!("Material \"principled\" {expected} {TURNED} {SQUARE}");
        same(material, &with_material(material, ""), [SHAPE, &expected]);
        // From behind: where light goes straight on, nothing is seen.
        if !expected.contains("twosided") {
            let behind = |text: &str| format!("Rotate 180 0 1 0 {text}");
            same(material, &with_material(material, ""), [&behind(SHAPE), &behind(&expected)]);
        }
    }
}

/// A picture of 2 by 2 texels with opacity, as PNG.
fn png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let texels = [[255u8, 0, 0, 255], [0, 255, 0, 64], [0, 0, 255, 255], [255, 255, 255, 200]];
    let encoder = image::codecs::png::PngEncoder::new(&mut bytes);
    image::ImageEncoder::write_image(encoder, texels.as_flattened(), 2, 2, image::ExtendedColorType::Rgba8)
        .expect("the encoder works");
    bytes
}

#[test]
fn pictures_lie_as_the_file_says_wherever_they_are() {
    let png = png();
    let uri: String = png.iter().map(|b| format!("%{b:02x}")).collect();
    let mut within = square().0;
    let view = within.view(&png, "");
    let places = [
        format!(r#""uri":"data:image/png,{uri}""#),
        r#""uri":"my%20picture.png""#.to_owned(),
        format!(r#""bufferView":{view},"mimeType":"image/png""#),
    ];
    let material = r#""pbrMetallicRoughness":{"metallicFactor":0,"baseColorTexture":{"index":0}},"doubleSided":true"#;
    let read = r#""string filename" "in/my picture.png""#;
    let paint = |options: &str| {
        format!(
            r#"Texture "t" "spectrum" "imagemap" {read} {options} Material "principled" "texture reflectance" "t" "float roughness" 1"#
        )
    };
    let make = |image: &str, sampler: &str, material: &str| {
        let primitive = square().1;
        let rest = format!(
            r#""meshes":[{{"primitives":[{{{primitive},"material":0}}]}}],"materials":[{{{material}}}],"textures":[{{"source":0,"sampler":0}}],"samplers":[{{{sampler}}}],"images":[{{{image}}}],{ONE_NODE}"#
        );
        let mut all = files(within.file(&rest));
        all.push(("in/my picture.png", png.clone()));
        all
    };
    for place in &places {
        same(place, &make(place, "", material), [SHAPE, &format!("{} {TURNED} {SQUARE}", paint(""))]);
    }
    let samplers = [
        (r#""wrapS":33071,"wrapT":33071,"magFilter":9728"#, r#""string wrap" "clamp" "string filter" "point""#),
        (r#""wrapS":33648,"wrapT":33648"#, r#""string wrap" "mirror""#),
    ];
    let wide = material.replace(r#"{"index":0}"#, r#"{"index":0,"extensions":{"KHR_texture_transform":{"scale":[3,2]}}}"#);
    for (sampler, options) in samplers {
        let scaled = format!(r#"{options} "float uscale" 3 "float vscale" 2 "float vdelta" -1"#);
        same(sampler, &make(&places[0], sampler, &wide), [SHAPE, &format!("{} {TURNED} {SQUARE}", paint(&scaled))]);
    }
    // Turned by a quarter around the upper left corner, as the specification's matrices do it: (u, v) becomes (v, -u) downwards.
    let turned = material.replace(
        r#"{"index":0}"#,
        r#"{"index":0,"extensions":{"KHR_texture_transform":{"rotation":1.5707963267948966,"offset":[0,1]}}}"#,
    );
    let by_hand = SQUARE.replace("[0 0  1 0  1 1  0 1]", "[1 0  1 1  0 1  0 0]");
    same("turned", &make(&places[0], "", &turned), [SHAPE, &format!("{} {TURNED} {by_hand}", paint(""))]);
    // How opaque it is.
    let hole =
        r#"MakeNamedMaterial "n" "string type" "interface" MakeNamedMaterial "w" "string type" "principled" "float roughness" 1"#;
    let opacity = format!(r#"Texture "a" "float" "imagemap" {read} "string channel" "opacity" "string encoding" "linear""#);
    let base = format!(r#"Texture "t" "spectrum" "imagemap" {read}"#);
    let mixed = |share: &str| format!(r#"{base} {opacity} {hole} "texture reflectance" "t" {share} {TURNED} {SQUARE}"#);
    let blend = format!(r#"{material},"alphaMode":"BLEND""#);
    same(
        "blend",
        &make(&places[0], "", &blend),
        [SHAPE, &mixed(r#"Material "mix" "string materials" ["n" "w"] "texture amount" "a""#)],
    );
    let mask = format!(r#"{material},"alphaMode":"MASK","alphaCutoff":0.6"#);
    let cut = r#"Texture "m" "float" "threshold" "texture tex" "a" "float cutoff" 0.6 Material "mix" "string materials" ["n" "w"] "texture amount" "m""#;
    same("mask", &make(&places[0], "", &mask), [SHAPE, &mixed(cut)]);
    // Roughness is green, metal is blue.
    let rough = r#""pbrMetallicRoughness":{"metallicFactor":0.5,"metallicRoughnessTexture":{"index":0}},"doubleSided":true"#;
    let channel = |name: &str, channel: &str, scale: f64| {
        format!(
            r#"Texture "{name}" "float" "imagemap" {read} "string encoding" "linear" "string channel" "{channel}" "float scale" {scale}"#
        )
    };
    let by_hand = format!(
        r#"{} {} Material "principled" "rgb reflectance" [1 1 1] "texture roughness" "r" "texture metallic" "m" {TURNED} {SQUARE}"#,
        channel("r", "green", 1.0),
        channel("m", "blue", 0.5)
    );
    same("roughness", &make(&places[0], "", rough), [SHAPE, &by_hand]);
}

#[test]
fn vertices_have_colours() {
    for (name, ty, component, bytes, more) in [
        (
            "floats",
            "VEC3",
            5126,
            [1.0f32, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0]
                .iter()
                .flat_map(|v| v.to_le_bytes())
                .collect::<Vec<u8>>(),
            "",
        ),
        (
            "bytes",
            "VEC4",
            5121,
            vec![255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255],
            r#","normalized":true"#,
        ),
        (
            "shorts",
            "VEC4",
            5123,
            [65535u16, 0, 0, 65535, 0, 65535, 0, 65535, 0, 0, 65535, 65535, 65535, 65535, 65535, 65535]
                .iter()
                .flat_map(|v| v.to_le_bytes())
                .collect(),
            r#","normalized":true"#,
        ),
    ] {
        let (mut maker, primitive) = square();
        let view = maker.view(&bytes, "");
        let colours = maker.accessor(view, component, ty, 4, more);
        let primitive = primitive.replace("\"TEXCOORD_0\"", &format!("\"COLOR_0\":{colours},\"TEXCOORD_0\""));
        let rest = format!(
            r#""meshes":[{{"primitives":[{{{primitive},"material":0}}]}}],"materials":[{{"pbrMetallicRoughness":{{"metallicFactor":0}},"doubleSided":true}}],{ONE_NODE}"#
        );
        // The same in halves: a picture of the four colours, bilinear between the middles of its texels, is not the same within triangles; on the whole it
        // is near, so the corners are compared.
        let (built, said) = world(&files(maker.file(&rest)), SHAPE);
        assert!(said.is_empty(), "{name}: {said:?}");
        let scene = built.expect("no faults").scene;
        let mesh = &scene.world.geometries[0];
        let at = |barycentric| mesh.surface(Default::default(), 0, barycentric).colour;
        assert_eq!(at(glam::DVec2::ZERO), glam::Vec4::new(1.0, 0.0, 0.0, 1.0), "{name}");
        // z is turned around, and with it the order of the corners.
        assert_eq!(at(glam::DVec2::new(1.0, 0.0)), glam::Vec4::new(0.0, 0.0, 1.0, 1.0), "{name}");
        assert_eq!(at(glam::DVec2::new(0.25, 0.5)), glam::Vec4::new(0.25, 0.5, 0.25, 1.0), "{name}");
    }
}

#[test]
fn what_shines_is_an_area_light() {
    let table = [
        (
            r#""emissiveFactor":[1,0.5,0.25],"pbrMetallicRoughness":{"baseColorFactor":[0,0,0,1],"metallicFactor":0},"extensions":{"KHR_materials_emissive_strength":{"emissiveStrength":4}}"#,
            r#"AreaLightSource "diffuse" "rgb L" [4 2 1] Material "principled" "rgb reflectance" [0 0 0] "float roughness" 1 "bool twosided" false"#,
        ),
        (
            r#""emissiveFactor":[1,0.5,0.25],"doubleSided":true,"alphaMode":"BLEND","pbrMetallicRoughness":{"baseColorFactor":[0,0,0,0.5],"metallicFactor":0}"#,
            r#"AreaLightSource "diffuse" "rgb L" [0.5 0.25 0.125] "bool twosided" true MakeNamedMaterial "n" "string type" "interface" MakeNamedMaterial "w" "string type" "principled" "rgb reflectance" [0 0 0] "float roughness" 1 Material "mix" "string materials" ["n" "w"] "float amount" 0.5"#,
        ),
        (
            r#""pbrMetallicRoughness":{"baseColorFactor":[0.2,0.8,0.4,1]},"extensions":{"KHR_materials_unlit":{}}"#,
            r#"AreaLightSource "diffuse" "rgb L" [0.2 0.8 0.4] Material "diffuse" "float reflectance" 0"#,
        ),
    ];
    for (material, by_hand) in table {
        same(material, &with_material(material, ""), [SHAPE, &format!("{by_hand} {TURNED} {SQUARE}")]);
    }
}

#[test]
fn lights_shine_in_candela_and_lux() {
    let table = [
        (r#""type":"point","intensity":3,"color":[1,0.5,0.25]"#, r#"LightSource "point" "rgb I" [3 1.5 0.75]"#),
        (r#""type":"directional","intensity":2"#, r#"LightSource "distant" "rgb L" [2 2 2] "point3 to" [0 0 -1]"#),
        (
            r#""type":"spot","intensity":9,"spot":{"innerConeAngle":0.3,"outerConeAngle":0.5}"#,
            r#"LightSource "spot" "rgb I" [9 9 9] "point3 to" [0 0 -1] "float coneangle" 28.64788975654116 "float conedeltaangle" 11.459155902616466"#,
        ),
    ];
    for (light, by_hand) in table {
        let (maker, primitive) = square();
        let rest = format!(
            r#""meshes":[{{"primitives":[{{{primitive},"material":0}}]}}],"materials":[{{"doubleSided":true,"pbrMetallicRoughness":{{"metallicFactor":0}}}}],
            "extensionsUsed":["KHR_lights_punctual"],"extensions":{{"KHR_lights_punctual":{{"lights":[{{{light}}}]}}}},
            "scenes":[{{"nodes":[0,1]}}],"nodes":[{{"mesh":0}},{{"translation":[0.2,0.1,1],"extensions":{{"KHR_lights_punctual":{{"light":0}}}}}}]"#
        );
        let all = files(maker.file(&rest));
        let paint = r#"Material "principled" "rgb reflectance" [1 1 1] "float roughness" 1"#;
        let lit = format!("{paint} {TURNED} {SQUARE} Translate 0.2 0.1 1 {by_hand}");
        same(light, &all, [SHAPE, &lit]);
        let dark = format!("{paint} {TURNED} {SQUARE}");
        same("no lights", &all, [&format!(r#"{SHAPE} "bool lights" false"#), &dark]);
    }
}
