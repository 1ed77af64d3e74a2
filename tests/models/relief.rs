//! Normal maps and heights of models: a map of one normal is a tilted plane, whichever way its texture coordinates run, and what stands out of a
//! displaced mesh stands out of a map too.

use super::gltf::Maker;
use super::{same, world};
use bhs::lang::BuiltScene;
use bhs_core::ray::{Arrival, Ray};
use glam::{DMat3, DVec3};

/// A picture of numbers, row after row from the bottom (PFM).
fn pfm(size: usize, texel: impl Fn(usize, usize) -> [f32; 3]) -> Vec<u8> {
    let rows = (0..size).flat_map(|y| (0..size).map(move |x| (x, y)));
    let numbers = rows.flat_map(|(x, y)| texel(x, y)).flat_map(f32::to_le_bytes);
    format!("PF\n{size} {size}\n-1\n").into_bytes().into_iter().chain(numbers).collect()
}

/// The colour of a normal.
fn colour(n: DVec3) -> [f32; 3] {
    ((n.normalize() + 1.0) * 0.5).as_vec3().to_array()
}

/// The shading normal where a line along +z meets the scene, seen from (x, y, -5); outwards.
fn normal(built: &BuiltScene, x: f64, y: f64) -> DVec3 {
    let scene = &built.scene;
    let ray = Ray::new(DVec3::new(x, y, -5.0) - scene.world.origin, DVec3::Z);
    match scene.integrator.trace(&scene.world, &ray).arrival {
        Arrival::Surface(hit) => scene.shading_normal(&hit),
        other => panic!("nothing at {x} {y}: {other:?}"),
    }
}

/// A square of the file that faces +z, with all that a mesh may have.
struct Square {
    uvs: [f32; 8],
    second_uvs: Option<[f32; 8]>,
    normals: bool,
    tangent: Option<[f32; 4]>,
    normal_texture: &'static str,
    nodes: &'static str,
}

/// Texture coordinates from the upper left corner, v downwards.
const UPRIGHT: [f32; 8] = [0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
const MIRRORED: [f32; 8] = [1.0, 1.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0];
/// u runs up, v to the right.
const ASKEW: [f32; 8] = [0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 0.0];
const PLAIN: Square = Square {
    uvs: UPRIGHT,
    second_uvs: None,
    normals: true,
    tangent: None,
    normal_texture: "",
    nodes: r#""scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}]"#,
};
const SHAPE: &str = r#"Shape "gltf" "string filename" "in/m.gltf""#;

impl Square {
    fn files(&self, map: Vec<u8>) -> Vec<(&'static str, Vec<u8>)> {
        let mut maker = Maker::default();
        let p = maker.floats("VEC3", &[-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.0]);
        let mut attributes = format!(r#""POSITION":{p},"TEXCOORD_0":{}"#, maker.floats("VEC2", &self.uvs));
        if let Some(uvs) = &self.second_uvs {
            attributes += &format!(r#","TEXCOORD_1":{}"#, maker.floats("VEC2", uvs));
        }
        if self.normals {
            attributes += &format!(r#","NORMAL":{}"#, maker.floats("VEC3", &[0.0, 0.0, 1.0].repeat(4)));
        }
        if let Some(tangent) = self.tangent {
            attributes += &format!(r#","TANGENT":{}"#, maker.floats("VEC4", &tangent.repeat(4)));
        }
        let view = maker.view(&[0, 1, 2, 0, 2, 3], "");
        let indices = maker.accessor(view, 5121, "SCALAR", 6, "");
        let rest = format!(
            r#""meshes":[{{"primitives":[{{"attributes":{{{attributes}}},"indices":{indices},"material":0}}]}}],
            "materials":[{{"doubleSided":true,"normalTexture":{{"index":0{}}}}}],"textures":[{{"source":0}}],"images":[{{"uri":"n.pfm"}}],{}"#,
            self.normal_texture, self.nodes
        );
        vec![("in/m.gltf", maker.file(&rest)), ("in/n.pfm", map)]
    }
}

#[test]
fn a_map_of_one_normal_is_a_tilted_plane_whichever_way_it_lies() {
    let n = DVec3::new(0.3, -0.2, 0.8).normalize();
    // Red, green and blue along these, in the file's coordinates.
    let frame = |x: DVec3, y: DVec3| DMat3::from_cols(x, y, DVec3::Z);
    let (x, y) = (DVec3::X, DVec3::Y);
    let upright = frame(x, y);
    let turned = DVec3::new(0.6, 0.8, 0.0);
    let cases = [
        ("upright", PLAIN, upright, n),
        ("without normals", Square { normals: false, ..PLAIN }, upright, n),
        ("mirrored", Square { uvs: MIRRORED, ..PLAIN }, frame(-x, y), n),
        ("mirrored, without normals", Square { uvs: MIRRORED, normals: false, ..PLAIN }, frame(-x, y), n),
        ("askew", Square { uvs: ASKEW, ..PLAIN }, frame(y, -x), n),
        (
            "by the second set",
            Square { second_uvs: Some(MIRRORED), normal_texture: r#","texCoord":1"#, ..PLAIN },
            frame(-x, y),
            n,
        ),
        (
            "steeper",
            Square { normal_texture: r#","scale":2"#, ..PLAIN },
            upright,
            DVec3::new(2.0 * n.x, 2.0 * n.y, n.z).normalize(),
        ),
        ("inside out", Square { normal_texture: r#","scale":-1"#, ..PLAIN }, upright, DVec3::new(-n.x, -n.y, n.z)),
        (
            "by tangents of the file",
            Square { tangent: Some([0.6, 0.8, 0.0, 1.0]), ..PLAIN },
            frame(turned, DVec3::Z.cross(turned)),
            n,
        ),
        (
            "by tangents of a mirrored frame",
            Square { tangent: Some([0.6, 0.8, 0.0, -1.0]), ..PLAIN },
            frame(turned, -DVec3::Z.cross(turned)),
            n,
        ),
        ("in a mirrored node", Square { nodes: r#""nodes":[{"mesh":0,"scale":[-1,1,1]}]"#, ..PLAIN }, frame(-x, y), n),
        (
            "in a mirrored node, by tangents",
            Square { nodes: r#""nodes":[{"mesh":0,"scale":[-1,1,1]}]"#, tangent: Some([1.0, 0.0, 0.0, 1.0]), ..PLAIN },
            frame(-x, y),
            n,
        ),
        (
            "in an instance that is mirrored",
            Square { nodes: r#""nodes":[{"mesh":0,"scale":[1,-1,1]},{"mesh":0,"translation":[9,0,0]}]"#, ..PLAIN },
            frame(x, -y),
            n,
        ),
    ];
    for (name, square, frame, n) in cases {
        let map = pfm(1, |_, _| colour(DVec3::new(0.3, -0.2, 0.8)));
        let (built, said) = world(&square.files(map), SHAPE);
        assert!(said.is_empty(), "{name}: {said:?}");
        let in_file = frame * n;
        let expected = DVec3::new(in_file.x, in_file.y, -in_file.z);
        for (at_x, at_y) in [(0.3, 0.1), (-0.4, 0.7)] {
            let found = normal(built.as_ref().expect("a scene"), at_x, at_y);
            assert!((found - expected).length() < 1e-5, "{name}: {found}, not {expected}");
        }
    }
}

/// A hill on the square, and its slopes.
fn hill(x: f64, y: f64) -> (f64, f64, f64) {
    let (dx, dy) = (x - 0.2, y + 0.1);
    let h = 0.15 * (-(dx * dx + dy * dy) / 0.1).exp();
    (h, -20.0 * dx * h, -20.0 * dy * h)
}

/// A fine mesh of the hill, which rises towards the viewer.
fn displaced() -> String {
    const N: usize = 120;
    let at = |i: usize| 2.0 * i as f64 / N as f64 - 1.0;
    let points: Vec<String> =
        (0..=N).flat_map(|j| (0..=N).map(move |i| (at(i), at(j)))).map(|(x, y)| format!("{x} {y} {}", -hill(x, y).0)).collect();
    let corner = |i: usize, j: usize| j * (N + 1) + i;
    let faces: Vec<String> = (0..N)
        .flat_map(|j| (0..N).map(move |i| [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)]))
        .map(|[a, b, c, d]| format!("{a} {c} {b} {a} {d} {c}"))
        .collect();
    format!(r#"Shape "trianglemesh" "point3 P" [{}] "integer indices" [{}]"#, points.join(" "), faces.join(" "))
}

#[test]
fn what_stands_out_of_a_displaced_mesh_stands_out_of_a_map() {
    const SIZE: usize = 256;
    let place = |i: usize| 2.0 * (i as f64 + 0.5) / SIZE as f64 - 1.0;
    let oracle = world(&[], &displaced()).0.expect("a mesh");
    let near = |found: DVec3, x: f64, y: f64, name: &str| {
        let expected = normal(&oracle, x, y);
        // Faces of the oracle are flat: their slopes vary by a fifteenth from one to the next.
        assert!((found - expected).length() < 0.05, "{name} at {x} {y}: {found}, not {expected}");
        (expected - DVec3::NEG_Z).length()
    };
    let heights = pfm(SIZE, |x, y| [hill(place(x), place(y)).0 as f32; 3]);
    let normals = |mirrored: bool| {
        pfm(SIZE, |x, y| {
            let (_, by_x, by_y) = hill(if mirrored { -place(x) } else { place(x) }, place(y));
            colour(DVec3::new(if mirrored { by_x } else { -by_x }, -by_y, 1.0))
        })
    };
    let obj =
        "mtllib a.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nusemtl m\nf 1/1 4/4 3/3 2/2\n";
    let of_mtl = |statement: &str, picture: Vec<u8>| {
        let mtl = format!("newmtl m\nKd 0.5 0.5 0.5\n{statement}\n");
        vec![("in/a.obj", obj.as_bytes().to_vec()), ("in/a.mtl", mtl.into_bytes()), ("in/n.pfm", picture)]
    };
    let obj_shape = r#"Shape "objmesh" "string filename" "in/a.obj""#;
    let cases = [
        ("glTF", PLAIN.files(normals(false)), SHAPE),
        ("glTF, mirrored", Square { uvs: MIRRORED, ..PLAIN }.files(normals(true)), SHAPE),
        ("norm", of_mtl("norm n.pfm", normals(false)), obj_shape),
        ("map_Bump of normals", of_mtl("map_Bump -bm 1 n.pfm", normals(false)), obj_shape),
        ("map_Bump of heights", of_mtl("map_Bump n.pfm", heights.clone()), obj_shape),
        (
            "bump of half heights",
            of_mtl("bump -bm 2 n.pfm", pfm(SIZE, |x, y| [0.5 * hill(place(x), place(y)).0 as f32; 3])),
            obj_shape,
        ),
    ];
    for (name, files, shape) in cases {
        let (built, said) = world(&files, shape);
        assert!(said.is_empty(), "{name}: {said:?}");
        let built = built.expect("a scene");
        let mut steepest: f64 = 0.0;
        for (x, y) in [(0.05, -0.1), (0.35, -0.1), (0.2, 0.1), (0.2, -0.3), (0.35, 0.03), (-0.8, 0.8)] {
            steepest = steepest.max(near(normal(&built, x, y), x, y, name));
        }
        assert!(steepest > 0.3, "{name}: {steepest}");
    }
}

#[test]
fn pictures_lie_by_their_own_set_of_texture_coordinates_and_wrap_by_u_and_v() {
    let tiles = std::fs::read(crate::common::root().join("grammar/examples/tiles.png")).expect("the picture is there");
    let square = |uvs: &str| {
        format!(
            r#"Scale 1 1 -1 Shape "trianglemesh" "point3 P" [-1 -1 0  1 -1 0  1 1 0  -1 1 0] "integer indices" [0 1 2  0 2 3] "point2 uv" [{uvs}]"#
        )
    };
    let wide = [-0.5, 1.5, 1.5, 1.5, 1.5, -0.5, -0.5, -0.5];
    let file = |material: &str, sampler: &str| {
        let mut maker = Maker::default();
        let p = maker.floats("VEC3", &[-1.0, -1.0, 0.0, 1.0, -1.0, 0.0, 1.0, 1.0, 0.0, -1.0, 1.0, 0.0]);
        let (first, second) = (maker.floats("VEC2", &UPRIGHT), maker.floats("VEC2", &wide));
        let view = maker.view(&[0, 1, 2, 0, 2, 3], "");
        let indices = maker.accessor(view, 5121, "SCALAR", 6, "");
        let rest = format!(
            r#""meshes":[{{"primitives":[{{"attributes":{{"POSITION":{p},"TEXCOORD_0":{first},"TEXCOORD_1":{second}}},"indices":{indices},"material":0}}]}}],
            "materials":[{{"doubleSided":true,{material}}}],"textures":[{{"source":0,"sampler":0}}],"samplers":[{{{sampler}}}],"images":[{{"uri":"t.png"}}],{}"#,
            PLAIN.nodes
        );
        vec![("in/m.gltf", maker.file(&rest)), ("in/t.png", tiles.clone())]
    };
    let picture = |name: &str, kind: &str, more: &str| {
        format!(r#"Texture "{name}" "{kind}" "imagemap" "string filename" "in/t.png" {more}"#)
    };
    // Colour by the second set, roughness by the first.
    let both = file(
        r#""pbrMetallicRoughness":{"metallicFactor":0.5,"baseColorTexture":{"index":0,"texCoord":1},"metallicRoughnessTexture":{"index":0}}"#,
        "",
    );
    let numbers = |name: &str, channel: &str, factor: f64| {
        picture(name, "float", &format!(r#""string channel" "{channel}" "string encoding" "linear" "float scale" {factor}"#))
    };
    let by_hand = format!(
        r#"{} {} {} Material "principled" "texture reflectance" "c" "texture roughness" "r" "texture metallic" "m" {}"#,
        picture("c", "spectrum", r#""float uscale" 2 "float vscale" 2 "float udelta" -0.5 "float vdelta" -0.5"#),
        numbers("r", "green", 1.0),
        numbers("m", "blue", 0.5),
        square("0 0  1 0  1 1  0 1")
    );
    same("two sets", &both, [SHAPE, &by_hand]);
    // What it emits by the second, which is then the first here.
    let lamp = file(
        r#""emissiveFactor":[1,1,1],"emissiveTexture":{"index":0,"texCoord":1},"pbrMetallicRoughness":{"metallicFactor":0,"baseColorTexture":{"index":0}}"#,
        "",
    );
    let by_hand = format!(
        r#"{} {} AreaLightSource "diffuse" "texture L" "l" "bool twosided" true Material "principled" "texture reflectance" "c" "float roughness" 1 {}"#,
        picture("l", "spectrum", ""),
        picture("c", "spectrum", r#""float uscale" 0.5 "float vscale" 0.5 "float udelta" 0.25 "float vdelta" 0.25"#),
        square("-0.5 -0.5  1.5 -0.5  1.5 1.5  -0.5 1.5")
    );
    same("a lamp", &lamp, [SHAPE, &by_hand]);
    let paint = r#""pbrMetallicRoughness":{"metallicFactor":0,"baseColorTexture":{"index":0,"texCoord":1}}"#;
    for (sampler, options) in [
        (r#""wrapS":33071,"wrapT":33648"#, r#""string wrap" "clamp" "string wrapv" "mirror""#),
        (r#""wrapS":10497,"wrapT":33071"#, r#""string wrapv" "clamp""#),
    ] {
        let by_hand = format!(
            r#"{} Material "principled" "texture reflectance" "c" "float roughness" 1 {}"#,
            picture("c", "spectrum", options),
            square("-0.5 -0.5  1.5 -0.5  1.5 1.5  -0.5 1.5")
        );
        same(sampler, &file(paint, sampler), [SHAPE, &by_hand]);
    }
}
