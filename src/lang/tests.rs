//! What scenes mean, from text to the built scene; nothing in a scene makes the program panic.

use super::*;
use crate::lang::description::{Entity, ShapeEntity};
use bhs_core::geometry::Geometry;
use bhs_core::spacetime::Class;
use glam::DVec3;
use proptest::prelude::*;

const REFERENCE: &str = include_str!("../../grammar/README.md");

fn describe(text: &str) -> (SceneDescription, Vec<Diagnostic>) {
    let mut sources = SourceMap::new();
    let file = sources.add("test", text);
    resolve::resolve(&mut sources, file)
}

fn build_with(text: &str, overrides: &Overrides) -> Result<BuiltScene, Vec<Diagnostic>> {
    let mut sources = SourceMap::new();
    let file = sources.add("test", text);
    let (description, found) = resolve::resolve(&mut sources, file);
    build(description, found, &Registry::builtin(), overrides, &mut sources)
}

fn built(text: &str) -> BuiltScene {
    build_with(text, &Overrides::default()).unwrap_or_else(|found| panic!("{found:?}\n{text}"))
}

/// The shapes of a world.
fn shapes(world: &str) -> Vec<ShapeEntity> {
    let (scene, found) = describe(world);
    assert!(!has_errors(&found), "{found:?}");
    scene.shapes
}

/// Where the origin and (1, 2, 3) of an entity's own coordinates lie in the world.
fn places(e: &Entity) -> [DVec3; 2] {
    [DVec3::ZERO, DVec3::new(1.0, 2.0, 3.0)].map(|p| e.world_from_object.transform_point3(p))
}

fn assert_near(a: DVec3, b: [f64; 3]) {
    assert!((a - DVec3::from_array(b)).length() < 1e-12, "{a} is not {b:?}");
}

#[test]
fn the_last_transform_written_is_applied_first() {
    let s = shapes("WorldBegin Translate 10 0 0 Scale 2 3 4 Rotate 90 0 0 1 Shape \"sphere\"");
    // (1, 2, 3) turns to (-2, 1, 3), is scaled to (-4, 3, 12) and moved.
    assert_near(places(&s[0].entity)[1], [6.0, 3.0, 12.0]);
    let s = shapes("WorldBegin Translate 1 1 1 Transform [1 0 0 0 0 1 0 0 0 0 1 0 5 6 7 1] Shape \"sphere\"");
    assert_near(places(&s[0].entity)[0], [5.0, 6.0, 7.0]);
    let s = shapes("WorldBegin Translate 1 1 1 ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 5 6 7 1] Shape \"sphere\"");
    assert_near(places(&s[0].entity)[0], [6.0, 7.0, 8.0]);
}

#[test]
fn the_world_begins_with_the_identity_and_knows_its_camera() {
    let text = "LookAt 0 0 -5  0 0 0  0 1 0  Camera \"perspective\"  WorldBegin Shape \"sphere\"
        CoordSysTransform \"camera\" Shape \"sphere\"  CoordSysTransform \"world\" Shape \"sphere\"";
    let (scene, found) = describe(text);
    assert!(!has_errors(&found));
    assert_near(places(&scene.cameras[0].entity)[1], [1.0, 2.0, -2.0]);
    assert_near(places(&scene.shapes[0].entity)[1], [1.0, 2.0, 3.0]);
    assert_near(places(&scene.shapes[1].entity)[0], [0.0, 0.0, -5.0]);
    assert_near(places(&scene.shapes[2].entity)[0], [0.0, 0.0, 0.0]);
}

#[test]
fn a_mirrored_camera_is_pbrts() {
    // `Scale -1 1 1` before `LookAt`: right-handed data seen the right way round.
    let (scene, _) = describe("Scale -1 1 1 LookAt 0 0 5  0 0 0  0 1 0 Camera \"perspective\" WorldBegin");
    let camera = *scene.cameras[0].entity.world_from_object;
    assert_near(camera.transform_vector3(DVec3::X), [1.0, 0.0, 0.0]);
    assert_near(camera.transform_vector3(DVec3::Z), [0.0, 0.0, -1.0]);
}

#[test]
fn attributes_are_restored_and_names_are_resolved_at_the_end() {
    let s = shapes(
        "WorldBegin
         AttributeBegin
           Translate 1 0 0 ReverseOrientation AreaLightSource \"diffuse\" NamedMaterial \"late\"
           Shape \"sphere\"
           AttributeBegin ReverseOrientation Material \"mirror\" Shape \"sphere\" AttributeEnd
           Shape \"sphere\"
         AttributeEnd
         Shape \"sphere\"
         MakeNamedMaterial \"late\" \"string type\" \"diffuse\"",
    );
    let seen: Vec<_> = s.iter().map(|s| (s.reverse_orientation, s.material, s.area_light)).collect();
    assert_eq!(seen, [(true, Some(1), Some(0)), (false, Some(0), Some(0)), (true, Some(1), Some(0)), (false, None, None)]);
    assert_near(places(&s[3].entity)[0], [0.0, 0.0, 0.0]);
}

#[test]
fn attribute_states_defaults() {
    let scene = built(
        "Attribute \"light\" \"float L\" 3
         WorldBegin
         AttributeBegin
           Attribute \"shape\" \"float radius\" 2 \"float zmax\" 1
           Attribute \"shape\" \"float radius\" 4
           Shape \"sphere\" \"float zmax\" 9
           Shape \"sphere\" \"float radius\" 3
         AttributeEnd
         LightSource \"infinite\"
         Shape \"sphere\"",
    );
    assert!(scene.warnings.is_empty(), "{:?}", scene.warnings);
    let tops: Vec<f64> = scene.scene.world.geometries.iter().map(|g| g.bounds().max.z).collect();
    // An ellipsoid may be bounded with a little room.
    for (top, right) in tops.iter().zip([4.0, 1.0, 1.0]) {
        assert!((top - right).abs() < 1e-3 * right, "{tops:?}");
    }
    let wide: Vec<f64> = scene.scene.world.geometries.iter().map(|g| g.bounds().max.x).collect();
    assert!(wide.iter().zip([4.0, 3.0, 1.0]).all(|(w, r)| (w - r).abs() < 1e-3 * r), "{wide:?}");
    let power = |text: &str| built(text).scene.light_sampler.lights[0].power(360.0, 830.0, 1.0);
    let (given, plain) = (
        power("Attribute \"light\" \"float scale\" 3 WorldBegin LightSource \"point\""),
        power("WorldBegin LightSource \"point\""),
    );
    assert!((given / plain - 3.0).abs() < 1e-5, "{given} {plain}");
}

#[test]
fn a_default_that_nobody_knows_is_a_warning_and_one_of_a_wrong_type_an_error() {
    let codes = |text: &str| {
        match build_with(text, &Overrides::default()) {
            Ok(scene) => scene.warnings,
            Err(found) => found,
        }
        .iter()
        .map(|d| d.code)
        .collect::<Vec<_>>()
    };
    let world = "WorldBegin LightSource \"infinite\" Translate 0 0 3";
    assert_eq!(codes(&format!("{world} Attribute \"shape\" \"float raduis\" 2 Shape \"sphere\"")), ["unused-attribute"]);
    assert_eq!(codes(&format!("{world} Attribute \"shape\" \"string radius\" \"2\" Shape \"sphere\"")), ["wrong-type"]);
    assert_eq!(codes(&format!("{world} Attribute \"shape\" \"float radius\" 2 Shape \"spheer\"")), ["unknown-plugin"]);
}

#[test]
fn cameras_have_their_turn() {
    let text = "Camera \"perspective\" \"string name\" \"a\" Translate 0 0 5 Camera \"perspective\" \"string name\" \"b\" \"float fov\" 5
        WorldBegin LightSource \"infinite\" Translate 0 0 3 Shape \"sphere\"";
    let mut scene = built(text);
    assert_eq!(scene.camera_names().collect::<Vec<_>>(), [Some("a"), Some("b")]);
    let near = scene.scene.footprints.camera;
    assert!(scene.next_camera());
    assert_near(scene.camera.position(), [0.0, 0.0, -5.0]);
    assert_eq!((scene.camera_name.clone().as_deref(), scene.next_camera()), (Some("b"), false));
    assert!(scene.scene.footprints.camera < near / 2.0);
    let chosen = build_with(text, &Overrides { camera: Some("b".into()), ..Default::default() }).ok().unwrap();
    assert_near(chosen.camera.position(), [0.0, 0.0, -5.0]);
    assert_eq!(chosen.scene.footprints.camera, scene.scene.footprints.camera);
}

#[test]
fn names_may_look_like_declarations() {
    let text =
        "WorldBegin MakeNamedMaterial \"normal gold\" \"string type\" \"diffuse\" NamedMaterial \"normal gold\" Shape \"sphere\"";
    assert_eq!(shapes(text)[0].material, Some(0));
}

#[test]
fn values_are_read_with_and_without_brackets_and_quotes() {
    let (directives, found) = parse::parse(
        "Shape \"s\" \"float a\" 1 \"float b\" [1 -.5e1 # comment ] [\n +2.] \"bool c\" true \"bool d\" [\"true\" \"false\"] \"string e\" \"x y\"
         \"string f\" [\"a\" # b\n \"c\\\"\"] \"point p\" [] \"string g\" \"float glass\" \"float h\" .5",
        0,
    );
    assert!(found.is_empty(), "{found:?}");
    let shown: Vec<String> = directives[0].params.iter().map(|p| format!("{} {:?}", p.name.value, p.values)).collect();
    assert_eq!(shown[0], "a Numbers { values: [1.0], whole: true }");
    assert_eq!(shown[1], "b Numbers { values: [1.0, -5.0, 2.0], whole: false }");
    assert_eq!(shown[2], "c Bools([true])");
    assert_eq!(shown[3], "d Bools([true, false])");
    assert!(shown[5].contains("\"c\\\"\""));
    assert_eq!(shown[6], "p Numbers { values: [], whole: true }");
    assert!(shown[7].contains("float glass"));
    assert_eq!(directives[0].params.len(), 9);
}

#[test]
fn where_nothing_bends_light_the_integrator_is_straight() {
    let world = "Integrator \"schwarzschild-rk4\" WorldBegin LightSource \"infinite\" Shape \"sphere\"";
    assert_eq!(built(world).integrator_name, "straight");
    let no_size = "WorldBegin LightSource \"infinite\" BlackHole \"schwarzschild\" \"float rs\" 0";
    let scene = built(no_size);
    assert_eq!((scene.integrator_name.as_str(), !scene.scene.world.bends()), ("straight", true));
    let hole =
        "WorldBegin LightSource \"infinite\" Scale 2 2 2 BlackHole \"schwarzschild\" \"float rs\" 0.1 \"point3 center\" [1 0 2]";
    let scene = built(hole);
    assert_eq!(scene.integrator_name, "adaptive");
    let Class::Spherical(hole) = scene.scene.world.spacetime().class() else { panic!("a hole") };
    assert!((hole.rs - 0.2).abs() < 1e-15);
    assert_near(hole.center + scene.scene.world.origin, [2.0, 0.0, 4.0]);
}

#[test]
fn scenes_far_from_the_origin_are_moved_to_it() {
    let scene = built(
        "LookAt 1e6 0 -4  1e6 0 0  0 1 0 Camera \"perspective\" WorldBegin LightSource \"infinite\"
         BlackHole \"schwarzschild\" \"point3 center\" [1e6 2 0] \"float rs\" 0.1
         Shape \"trianglemesh\" \"point3 P\" [999999 0 0  1000001 0 0  1000000 1 0] \"integer indices\" [0 1 2]",
    );
    let world = &scene.scene.world;
    assert_near(world.origin, [1e6, 0.5, 0.0]);
    assert_near(scene.camera.position(), [0.0, -0.5, -4.0]);
    assert_near(world.spacetime().captures()[0].center, [0.0, 1.5, 0.0]);
    let Geometry::Mesh(mesh) = &world.geometries[0] else { panic!("it is a mesh") };
    assert_eq!(mesh.positions[0], [-1.0, -0.5, 0.0]);
    // A scene near the origin stays where it is.
    let near = built("WorldBegin LightSource \"infinite\" Translate 3 0 0 Shape \"sphere\"");
    assert_eq!(near.scene.world.origin, DVec3::ZERO);
}

#[test]
fn lights_are_chosen_by_power_and_shapes_keep_their_numbers() {
    let scene = built(
        "WorldBegin Shape \"sphere\"
         AreaLightSource \"diffuse\" \"spectrum L\" 2
         Shape \"sphere\" \"float radius\" 2
         Shape \"trianglemesh\" \"point3 P\" [0 0 0  1 0 0  0 1 0  2 0 0] \"integer indices\" [0 1 2  0 1 3]",
    );
    let s = &scene.scene;
    assert_eq!(s.shapes.iter().map(|s| (s.index, s.emitter)).collect::<Vec<_>>(), [(0, None), (1, Some(0)), (2, Some(1))]);
    let choice = &s.light_sampler.choice;
    let ratio = choice.probability(0) / choice.probability(1);
    assert!((ratio / (16.0 * std::f64::consts::PI / 0.5) - 1.0).abs() < 1e-5, "{ratio}");
    assert_eq!((scene.load.triangles, scene.load.zero_area_triangles, scene.load.shapes), (1, 1, 3));
}

#[test]
fn flags_win_over_the_scene() {
    let text =
        "Film \"rgb\" \"integer xresolution\" 1000 \"integer yresolution\" 500 Sampler \"sobol\" \"integer pixelsamples\" 64
        Option \"integer seed\" 3 LightTransport \"path\" \"integer maxdepth\" 7
        WorldBegin LightSource \"infinite\" BlackHole \"schwarzschild\" \"point3 center\" [0 0 5] \"float rs\" 0.1";
    let scene = built(text);
    assert_eq!((scene.film.resolution(), scene.sampler.samples_per_pixel(), scene.seed), ([1000, 500], 64, 3));
    let quick = build_with(text, &Overrides { quick: true, ..Default::default() }).ok().unwrap();
    assert_eq!((quick.film.resolution(), quick.sampler.samples_per_pixel()), ([256, 128], 16));
    let overrides = Overrides {
        integrator: Some("straight".into()),
        transport: Some("hemisphere".into()),
        intersector: Some("reference".into()),
        spp: Some(5),
        noise: Some(0.25),
        seed: Some(u64::MAX),
        resolution: Some([30, 20]),
        crop: Some([0.5, 1.0, 0.0, 0.5]),
        layers: vec!["winding".into()],
        output: Some("x.exr".into()),
        quick: true,
        ..Default::default()
    };
    let scene = build_with(text, &overrides).ok().unwrap();
    assert_eq!((scene.film.resolution(), scene.film.crop(), scene.film.filename()), ([30, 20], [15, 30, 0, 10], "x.exr"));
    assert_eq!(scene.layers.iter().map(|layer| layer.name).collect::<Vec<_>>(), ["winding"]);
    assert_eq!((scene.sampler.samples_per_pixel(), scene.seed), (5, u64::MAX));
    assert_eq!(scene.sampler.noise_target().map(|target| target.noise), Some(0.25));
    let endless = build_with(text, &Overrides { noise: Some(0.25), ..Default::default() }).ok().unwrap();
    assert_eq!(endless.sampler.samples_per_pixel(), bhs_core::sampling::MOST_SAMPLES);
    let names = [&scene.integrator_name, &scene.transport_name, &scene.intersector_name];
    assert_eq!(names, ["straight", "hemisphere", "reference"]);
    assert_eq!(scene.hash, quick.hash);
}

#[test]
fn includes_are_not_too_deep() {
    let folder = tempfile::tempdir().unwrap();
    let write = |i: usize, text: String| std::fs::write(folder.path().join(format!("{i}.bhs")), text).unwrap();
    for i in 0..70 {
        write(i, format!("Include \"{}.bhs\"\n", i + 1));
    }
    write(70, "WorldBegin".into());
    let load = |i: usize| {
        let path = folder.path().join(format!("{i}.bhs"));
        load(&path, &Registry::builtin(), &Overrides::default(), &mut SourceMap::new())
    };
    let codes = |found: Vec<Diagnostic>| found.iter().map(|d| d.code).collect::<Vec<_>>();
    assert_eq!(load(70 - source::MAX_INCLUDE_DEPTH).map_err(codes).map(|s| s.warnings.len()), Ok(1));
    assert_eq!(load(0).map_err(codes).err(), Some(vec!["include-depth", "no-world"]));
}

#[test]
fn files_are_not_too_many() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("empty"), "").unwrap();
    let mut sources = SourceMap::new();
    let path = folder.path().join("scene.bhs");
    // The scene is a file too.
    let includes = "Include \"empty\"\n".repeat(usize::from(u16::MAX) + 2);
    std::fs::write(&path, format!("WorldBegin\n{includes}")).unwrap();
    let found = load(&path, &Registry::builtin(), &Overrides::default(), &mut sources).err().unwrap();
    assert_eq!(found.iter().map(|d| d.code).collect::<Vec<_>>(), ["too-many-files"; 2]);
    assert_eq!(sources.iter().count(), usize::from(u16::MAX) + 1);
}

#[test]
fn attributes_are_not_too_deep() {
    let depth = resolve::MAX_ATTRIBUTE_DEPTH;
    let nested = |n: usize| format!("WorldBegin {} {}", "AttributeBegin ".repeat(n), "AttributeEnd ".repeat(n));
    assert!(describe(&nested(depth)).1.is_empty());
    let found = describe(&nested(depth + 10)).1;
    assert_eq!(found.iter().map(|d| d.code).collect::<Vec<_>>(), ["attribute-depth"]);
}

/// The examples of the language reference.
fn examples() -> Vec<&'static str> {
    REFERENCE.split("```bhs\n").skip(1).map(|rest| rest.split("```").next().unwrap()).collect()
}

/// Reads and builds a text; what is found lies within it.
fn survives(text: &str) {
    let mut sources = SourceMap::new();
    let file = sources.add("soup", text);
    let (description, found) = resolve::resolve(&mut sources, file);
    let overrides = Overrides { intersector: Some("reference".into()), ..Default::default() };
    let found = match build(description, found, &Registry::builtin(), &overrides, &mut sources) {
        Ok(scene) => scene.warnings,
        Err(found) => found,
    };
    for label in found.iter().flat_map(|d| d.primary.iter().chain(&d.labels)) {
        let text = &sources.get(label.span.file).expect("the file is there").text;
        assert!(text.get(label.span.start as usize..label.span.end as usize).is_some(), "{label:?} in {text}");
    }
    crate::report::render(&found, &sources, true);
}

fn token() -> impl Strategy<Value = String> {
    let fixed = [
        "\"",
        "[",
        "]",
        "#",
        "\n",
        "\\",
        "\"float",
        "x\"",
        "\"rgb L\"",
        "\"string type\"",
        "\"diffuse\"",
        "\"sphere\"",
        "\"point3 P\"",
        "\"integer indices\"",
        "1e999",
        "nan",
        "-inf",
        "true",
        "false",
        "\u{feff}",
        "é",
        "\"é ü\"",
        "\r\n",
        "1 2 3",
        "[0 1 2]",
        "\"a\"",
        "Include",
        "Nonsense",
        "worldbegin",
        "\"trianglemesh\"",
        "\"schwarzschild\"",
        "\"float rs\"",
        "\"perspective\"",
        "1e300",
        "\0",
    ];
    prop_oneof![
        3 => proptest::sample::select(fixed.to_vec()).prop_map(str::to_owned),
        3 => proptest::sample::select(keywords().collect::<Vec<_>>()).prop_map(str::to_owned),
        1 => any::<f64>().prop_map(|x| x.to_string()),
        1 => (-3i32..20).prop_map(|x| x.to_string()),
        1 => any::<String>(),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn token_soup_does_not_panic(tokens in proptest::collection::vec((token(), any::<bool>()), 0..60)) {
        let text: String = tokens.into_iter().map(|(t, blank)| if blank { t + " " } else { t }).collect();
        survives(&text);
        survives(&format!("WorldBegin {text}"));
    }

    #[test]
    fn mutated_scenes_do_not_panic(which in any::<proptest::sample::Index>(), edits in proptest::collection::vec((any::<proptest::sample::Index>(), 0usize..8, token()), 1..6)) {
        let mut text: Vec<char> = examples()[which.index(examples().len())].chars().collect();
        for (at, removed, inserted) in edits {
            let at = at.index(text.len().max(1)).min(text.len());
            let end = (at + removed).min(text.len());
            text.splice(at..end, inserted.chars());
        }
        survives(&text.into_iter().collect::<String>());
    }
}
