//! The layers `albedo` and `normal` are of what is seen in mirrors and through smooth glass.

use crate::common;

/// Means over the picture of a scene's layers: what lies in front of a camera at the origin that looks along +z, with a red wall behind it.
fn means(options: &str, transport: &str, world: &str) -> Vec<[f64; 3]> {
    let built = common::build(&format!(
        r#"
        LookAt 0 0 0  0 0 1  0 1 0
        Camera "perspective" "float fov" 10
        Film "rgb" "integer xresolution" 8 "integer yresolution" 8 "string layers" ["albedo" "normal" "depth"] {options}
        Sampler "sobol" "integer pixelsamples" 64
        LightTransport "{transport}"
        WorldBegin
        LightSource "infinite"
        AttributeBegin
            Material "diffuse" "rgb reflectance" [0.7 0.2 0.1]
            Shape "bilinearmesh" "point3 P" [-9 -9 -3  9 -9 -3  -9 9 -3  9 9 -3]
        AttributeEnd
        {world}
        "#
    ));
    let layers = common::render(&built).frame.layers();
    let mean = |values: &[Option<[f64; 3]>]| {
        let count = values.len() as f64;
        std::array::from_fn(|c| values.iter().map(|v| v.expect("a surface everywhere")[c]).sum::<f64>() / count)
    };
    layers.iter().map(|layer| mean(&layer.values)).collect()
}

fn close(found: [f64; 3], expected: [f64; 3], tolerance: f64, what: &str) {
    assert!((0..3).all(|c| (found[c] - expected[c]).abs() < tolerance), "{what}: {found:?}, expected {expected:?}");
}

const MIRROR: &str =
    r#"Material "mirror" "float reflectance" 0.8 Shape "bilinearmesh" "point3 P" [-5 -5 2  5 -5 2  -5 5 2  5 5 2]"#;

#[test]
fn a_mirror_shows_the_wall_behind_the_camera() {
    for transport in ["path", "hemisphere"] {
        let found = means("", transport, MIRROR);
        close(found[0], [0.56, 0.16, 0.08], 0.02, "albedo");
        assert!(found[1][2].abs() > 0.999, "normal {:?}", found[1]);
        // The wall's normal is the mirror's own; a wall that leans tells them apart.
        let leaning =
            MIRROR.to_owned() + r#" Material "diffuse" Shape "bilinearmesh" "point3 P" [-5 -5 -1  5 -5 -1  -5 5 -2  5 5 -2]"#;
        let found = means("", transport, &leaning);
        assert!((found[1][1].abs() - 0.0995).abs() < 1e-3, "normal {:?}", found[1]);
        close([found[2][0]; 3], [2.0; 3], 0.02, "depth is that of the mirror");
        let first = means("\"bool firstsurface\" true", transport, &leaning);
        close(first[0], [0.8; 3], 1e-6, "albedo of the first surface");
        assert!(first[1][2].abs() > 0.999, "normal of the first surface {:?}", first[1]);
    }
    // A transport that follows no path sees the mirror.
    close(means("", "normals", MIRROR)[0], [0.8; 3], 1e-6, "albedo by `normals`");
}

#[test]
fn nearly_a_mirror_is_a_mirror_and_a_rough_one_is_not() {
    let metal = |roughness: f64| {
        let world = MIRROR.replace(
            "\"mirror\" \"float reflectance\" 0.8",
            "\"conductor\" \"float reflectance\" 0.8 \"bool remaproughness\" false",
        );
        means("", "path", &world.replace("false", &format!("false \"float roughness\" {roughness}")))[0]
    };
    close(metal(0.005), [0.56, 0.16, 0.08], 0.03, "polished");
    close(metal(0.3), [0.8; 3], 0.1, "brushed");
}

#[test]
fn glass_shows_what_is_behind_it_and_what_it_reflects() {
    // A pane; a blue wall behind it, the red one in its reflection: 4.3 % a surface for an index of 1.5, twice that for a pane.
    let pane = r#"
        AttributeBegin Material "dielectric" "float eta" 1.5
            AttributeBegin ReverseOrientation Shape "bilinearmesh" "point3 P" [-5 -5 2  5 -5 2  -5 5 2  5 5 2] AttributeEnd
            Shape "bilinearmesh" "point3 P" [-5 -5 2.1  5 -5 2.1  -5 5 2.1  5 5 2.1]
        AttributeEnd
        Material "diffuse" "rgb reflectance" [0.1 0.2 0.8]
        Shape "bilinearmesh" "point3 P" [-9 -9 5  9 -9 5  -9 9 5  9 9 5]"#;
    let found = means("", "path", pane)[0];
    let share = 0.0769;
    let expected = [[0.1, 0.7], [0.2, 0.2], [0.8, 0.1]].map(|[through, back]| (1.0 - share) * through + share * back);
    close(found, expected, 0.03, "albedo");
}

#[test]
fn what_shows_nothing_but_the_sky_has_values_of_its_own() {
    let ball = r#"Material "mirror" "float reflectance" 0.8 Translate 0 0 3 Shape "sphere" "float radius" 0.9"#;
    let built = common::build(&format!(
        "LookAt 0 0 0  0 0 1  0 1 0 Camera \"perspective\" \"float fov\" 10
         Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 4 \"string layers\" [\"albedo\" \"normal\"]
         Sampler \"sobol\" \"integer pixelsamples\" 4 WorldBegin LightSource \"infinite\" {ball}"
    ));
    let layers = common::render(&built).frame.layers();
    for value in &layers[0].values {
        close(value.expect("a surface"), [0.8; 3], 1e-6, "albedo");
    }
    assert!(layers[1].values.iter().all(|n| n.expect("a surface")[2] < -0.8));
}
