//! What a user of pbrt-v4 takes for granted, one fact a row, each found out by running a scene. (pbrt-v4's own documentation: "File Format",
//! and Pharr, Jakob and Humphreys 2023.) Where bhs differs on purpose stands in the table of differences of the language reference.

use crate::common;
use bhs::lang::BuiltScene;
use bhs::registry::Registry;
use bhs_core::camera::CameraRay;
use bhs_core::geometry::SurfaceGeometry;
use bhs_core::ray::{Arrival, Ray};
use bhs_core::spectrum::SampledWavelengths;
use glam::{DVec2, DVec3, Vec2};
use std::collections::BTreeSet;

type Fact = (&'static str, fn() -> bool);

fn v(x: f64, y: f64, z: f64) -> DVec3 {
    DVec3::new(x, y, z)
}

fn near(a: DVec3, b: DVec3) -> bool {
    (a - b).length() < 1e-5
}

fn world(text: &str) -> BuiltScene {
    common::build(&format!("WorldBegin\nLightSource \"infinite\"\n{text}"))
}

/// Where a point of a shape under the transforms `text` lies in the world.
fn place(options: &str, text: &str, p: DVec3) -> DVec3 {
    let corners = [p, p + DVec3::X, p + DVec3::Y].map(|c| format!("{} {} {}", c.x, c.y, c.z)).join("  ");
    let built = common::build(&format!(
        "{options}\nWorldBegin\nLightSource \"infinite\"\n{text}\nShape \"trianglemesh\" \"point3 P\" [{corners}] \"integer indices\" [0 1 2]"
    ));
    let corners = built.scene.world.geometries.last().and_then(|g| g.corners(0)).expect("a triangle");
    corners[0] + built.scene.world.origin
}

fn moved(text: &str, from: [f64; 3], to: [f64; 3]) -> bool {
    near(place("", text, DVec3::from_array(from)), DVec3::from_array(to))
}

/// The camera's ray through a point of the film, in the world.
fn ray(options: &str, size: [u32; 2], at: [f64; 2]) -> CameraRay {
    let film = format!("Film \"rgb\" \"integer xresolution\" {} \"integer yresolution\" {}", size[0], size[1]);
    let built = common::build(&format!("{options}\n{film}\nWorldBegin\nLightSource \"infinite\""));
    let ray = built.camera.ray(DVec2::from_array(at), Vec2::splat(0.5));
    CameraRay { origin: ray.origin + built.scene.world.origin, ..ray }
}

fn looks(options: &str, size: [u32; 2], at: [f64; 2], along: DVec3) -> bool {
    near(ray(options, size, at).direction, along.normalize())
}

/// What a ray from `from` along `along` meets, and where.
fn met(text: &str, from: DVec3, along: DVec3) -> Option<(SurfaceGeometry, DVec3)> {
    let built = world(text);
    let world = &built.scene.world;
    match built.scene.integrator.trace(world, &Ray::new(from - world.origin, along.normalize())).arrival {
        Arrival::Surface(hit) => Some((world.surface(&hit), hit.point + world.origin)),
        _ => None,
    }
}

fn normal(text: &str, from: DVec3, along: DVec3) -> DVec3 {
    met(text, from, along).expect("a surface").0.normal
}

fn uv(text: &str, from: DVec3, along: DVec3) -> Vec2 {
    met(text, from, along).expect("a surface").0.uv
}

/// Emission of a lamp that is seen from `from` along `along`, and reflectance (at normal incidence) of a material likewise.
fn seen(text: &str, from: DVec3, along: DVec3) -> (f32, f32) {
    let built = world(text);
    let (scene, lambda) = (&built.scene, SampledWavelengths::visible(0.5, 360.0, 830.0));
    let ray = Ray::new(from - scene.world.origin, along.normalize());
    let Arrival::Surface(hit) = scene.integrator.trace(&scene.world, &ray).arrival else { return (0.0, 0.0) };
    let vertex = scene.vertex(hit, &lambda).expect("flat space");
    (vertex.emitted()[0], vertex.material.reflectance(&vertex.shading, vertex.wo)[0])
}

/// The default of a parameter, as the plugin's constructor states it.
fn default(kind: &str, plugin: &str, parameter: &str, expected: &str) -> bool {
    let all = Registry::builtin().describe();
    let plugin = all.iter().find(|p| p.kind == kind && p.name == plugin);
    plugin.and_then(|p| p.params.iter().find(|q| q.name == parameter)).is_some_and(|q| q.default == expected)
}

/// Direction of the sky that the first light is aimed at.
fn sky(text: &str) -> DVec3 {
    let built = common::build(&format!("WorldBegin\n{text}"));
    built.scene.light_sampler.lights[0].sample_sky(Vec2::splat(0.5)).expect("a light of the sky").direction
}

/// Intensity of the first light in a direction.
fn intensity(text: &str, along: DVec3) -> f32 {
    common::build(&format!("WorldBegin\n{text}")).scene.light_sampler.lights[0].intensity(along.normalize(), [500.0; 4])[0]
}

const TRIANGLE: &str = "Shape \"trianglemesh\" \"point3 P\" [-9 -9 0  9 -9 0  0 9 0] \"integer indices\" [0 1 2]";
const SPHERE_LAMP: &str = "AreaLightSource \"diffuse\" \"spectrum L\" 2 Shape \"sphere\"";
const SIDES: [u32; 2] = [40, 20];
const DOWN: [u32; 2] = [20, 40];

const FACTS: &[Fact] = &[
    // ---- Transforms
    ("Translate moves", || moved("Translate 1 2 3", [1., 1., 1.], [2., 3., 4.])),
    ("Scale scales each axis", || moved("Scale 2 3 4", [1., 1., 1.], [2., 3., 4.])),
    ("Rotate 90 about z takes +x to +y", || moved("Rotate 90 0 0 1", [1., 0., 0.], [0., 1., 0.])),
    ("Rotate 90 about x takes +y to +z", || moved("Rotate 90 1 0 0", [0., 1., 0.], [0., 0., 1.])),
    ("Rotate 90 about y takes +z to +x", || moved("Rotate 90 0 1 0", [0., 0., 1.], [1., 0., 0.])),
    ("Rotate normalises its axis", || moved("Rotate 90 0 0 7", [1., 0., 0.], [0., 1., 0.])),
    ("the last transform written is applied first", || moved("Translate 1 0 0 Scale 2 2 2", [1., 1., 1.], [3., 2., 2.])),
    ("Transform is written column by column", || {
        moved("Transform [0 1 0 0  -1 0 0 0  0 0 1 0  5 6 7 1]", [1., 0., 0.], [5., 7., 7.])
    }),
    ("Transform replaces what stood before", || {
        moved("Scale 9 9 9 Transform [1 0 0 0 0 1 0 0 0 0 1 0 1 0 0 1]", [1., 1., 1.], [2., 1., 1.])
    }),
    ("ConcatTransform multiplies from the right", || {
        moved("Scale 2 2 2 ConcatTransform [1 0 0 0 0 1 0 0 0 0 1 0 1 0 0 1]", [0., 0., 0.], [2., 0., 0.])
    }),
    ("Identity forgets", || moved("Scale 2 2 2 Identity", [1., 1., 1.], [1., 1., 1.])),
    ("LookAt in the world is world to camera, too", || moved("LookAt 0 0 -5  0 0 0  0 1 0", [0., 0., 0.], [0., 0., 5.])),
    ("WorldBegin starts with the identity", || {
        near(place("Translate 9 9 9\nCamera \"perspective\"", "", DVec3::ONE), DVec3::ONE)
    }),
    ("CoordSysTransform \"camera\" is camera to world", || {
        near(
            place("LookAt 1 2 3  1 2 9  0 1 0\nCamera \"perspective\"", "CoordSysTransform \"camera\"", DVec3::ZERO),
            v(1., 2., 3.),
        )
    }),
    ("CoordSysTransform \"world\" is the world", || {
        moved("Translate 5 5 5 CoordSysTransform \"world\"", [1., 0., 0.], [1., 0., 0.])
    }),
    ("AttributeEnd brings the transform back", || {
        moved("AttributeBegin Translate 9 9 9 AttributeEnd", [1., 0., 0.], [1., 0., 0.])
    }),
    ("CoordinateSystem keeps a transform by name", || {
        moved("Translate 1 0 0 CoordinateSystem \"a\" Translate 8 0 0 CoordSysTransform \"a\"", [0., 0., 0.], [1., 0., 0.])
    }),
    // ---- Cameras
    ("a camera looks along +z", || looks("", SIDES, [20., 10.], DVec3::Z)),
    ("+x is on the right of the picture", || ray("", SIDES, [30., 10.]).direction.x > 0.1),
    ("+y is up in the picture", || ray("", SIDES, [20., 5.]).direction.y > 0.1),
    ("LookAt: the first point is where the camera stands", || {
        near(ray("LookAt 1 2 3  4 5 6  0 1 0\nCamera \"perspective\"", SIDES, [20., 10.]).origin, v(1., 2., 3.))
    }),
    ("LookAt: the second is in the middle of the picture", || {
        looks("LookAt 1 2 3  4 5 7  0 1 0\nCamera \"perspective\"", SIDES, [20., 10.], v(3., 3., 4.))
    }),
    ("LookAt: the third points up in the picture", || {
        ray("LookAt 0 0 0  0 0 1  1 0 0\nCamera \"perspective\"", SIDES, [20., 5.]).direction.x > 0.1
    }),
    ("space is left-handed: seen from -z with +y up, +x is on the right", || {
        ray("LookAt 0 0 -5  0 0 0  0 1 0\nCamera \"perspective\"", SIDES, [30., 10.]).direction.x > 0.1
    }),
    ("Scale -1 1 1 before LookAt mirrors the picture", || {
        ray("Scale -1 1 1 LookAt 0 0 -5  0 0 0  0 1 0\nCamera \"perspective\"", SIDES, [30., 10.]).direction.x < -0.1
    }),
    ("the camera's transform is world to camera", || {
        near(ray("Translate 0 0 5\nCamera \"perspective\"", SIDES, [0., 0.]).origin, v(0., 0., -5.))
    }),
    ("fov is along the shorter side: of a wide picture its height", || {
        looks("Camera \"perspective\" \"float fov\" 60", SIDES, [20., 0.], v(0., 30f64.to_radians().tan(), 1.))
    }),
    ("fov is along the shorter side: of a tall picture its width", || {
        looks("Camera \"perspective\" \"float fov\" 60", DOWN, [20., 20.], v(30f64.to_radians().tan(), 0., 1.))
    }),
    ("pixels are square, whatever the sides", || looks("", SIDES, [40., 10.], v(2., 0., 1.))),
    ("fov is 90 degrees unless told otherwise", || looks("Camera \"perspective\"", SIDES, [20., 0.], v(0., 1., 1.))),
    ("screenwindow is x from, x to, y from, y to", || {
        looks("Camera \"perspective\" \"float screenwindow\" [0 1 0 2]", SIDES, [40., 0.], v(1., 2., 1.))
    }),
    ("frameaspectratio stands for width over height", || {
        looks("Camera \"perspective\" \"float frameaspectratio\" 3", SIDES, [40., 0.], v(3., 1., 1.))
    }),
    ("an orthographic camera looks along +z everywhere", || looks("Camera \"orthographic\"", SIDES, [3., 4.], DVec3::Z)),
    ("an orthographic window reaches from -1 to 1 along the shorter side", || {
        near(ray("Camera \"orthographic\"", SIDES, [40., 0.]).origin, v(2., 1., 0.))
    }),
    ("a spherical camera maps equal areas, +y in the middle", || looks("Camera \"spherical\"", [20, 20], [10., 10.], DVec3::Y)),
    ("equirectangular: the left edge is +x, a quarter on it is +z", || {
        let camera = "Camera \"spherical\" \"string mapping\" \"equirectangular\"";
        looks(camera, SIDES, [0., 10.], DVec3::X) && looks(camera, SIDES, [10., 10.], DVec3::Z)
    }),
    ("equirectangular: the top is +y", || {
        looks("Camera \"spherical\" \"string mapping\" \"equirectangular\"", SIDES, [13., 0.], DVec3::Y)
    }),
    ("the plane that is sharp is at right angles to +z", || {
        let at = |lens: &str| ray(&format!("Camera \"perspective\" {lens} \"float focaldistance\" 3"), SIDES, [7., 3.]);
        let (sharp, r) = (at(""), at("\"float lensradius\" 0.5"));
        near(sharp.direction * (3.0 / sharp.direction.z), r.origin + r.direction * (3.0 / r.direction.z))
    }),
    ("cropwindow is x from, x to, y from, y to, rounded up", || {
        let film = "Film \"rgb\" \"integer xresolution\" 10 \"integer yresolution\" 10 \"float cropwindow\" [0.11 0.5 0.2 0.95]";
        common::build(&format!("{film}\nWorldBegin\nLightSource \"infinite\"")).film.crop() == [2, 5, 2, 10]
    }),
    // ---- Surfaces
    ("a triangle's normal is (p1 - p0) x (p2 - p0)", || near(normal(TRIANGLE, v(0., 0., -5.), DVec3::Z), DVec3::Z)),
    ("ReverseOrientation turns it", || {
        near(normal(&format!("ReverseOrientation {TRIANGLE}"), v(0., 0., -5.), DVec3::Z), -DVec3::Z)
    }),
    ("a mirroring transform does not", || near(normal(&format!("Scale -1 1 1 {TRIANGLE}"), v(0., 0., -5.), DVec3::Z), DVec3::Z)),
    ("vertex normals say which side is out", || {
        near(normal(&format!("{TRIANGLE} \"normal N\" [0 0 -1  0 0 -1  0 0 -1]"), v(0., 0., -5.), DVec3::Z), -DVec3::Z)
    }),
    ("a sphere's normal points outwards", || near(normal("Shape \"sphere\"", v(0., 0., -5.), DVec3::Z), -DVec3::Z)),
    ("a sphere's inner side can be turned out", || {
        near(normal("ReverseOrientation Shape \"sphere\"", v(0., 0., -5.), DVec3::Z), DVec3::Z)
    }),
    ("a sphere of radius 1 stands in the origin", || {
        near(met("Shape \"sphere\"", v(0., 0., -5.), DVec3::Z).expect("it").1, -DVec3::Z)
    }),
    ("zmin and zmax cut a sphere", || {
        near(met("Shape \"sphere\" \"float zmin\" -0.5", v(0., 0., -5.), DVec3::Z).expect("it").1, DVec3::Z)
    }),
    ("phimax cuts a sphere, from +x over +y", || {
        let half = "Shape \"sphere\" \"float phimax\" 180";
        near(met(half, v(0., -5., 0.), DVec3::Y).expect("it").1, DVec3::Y)
    }),
    ("u of a sphere goes from +x over +y", || (uv("Shape \"sphere\"", v(-1., 5., 0.0), v(1., -4., 0.)).x - 0.25).abs() < 0.1),
    ("v of a sphere goes from -z to +z", || uv("Shape \"sphere\"", v(0.01, 0., 5.), -DVec3::Z).y > 0.9),
    ("triangles have the uv (0,0), (1,0), (1,1) by default", || {
        (uv(TRIANGLE, v(8.9, -8.98, -5.), DVec3::Z) - Vec2::X).length() < 0.05
            && (uv(TRIANGLE, v(0., 8.9, -5.), DVec3::Z) - Vec2::ONE).length() < 0.05
    }),
    ("a disk's normal is +z", || near(normal("Shape \"disk\"", v(0.2, 0., -5.), DVec3::Z), DVec3::Z)),
    ("a disk of radius 1 lies at height 0", || {
        near(met("Shape \"disk\"", v(0.9, 0., -5.), DVec3::Z).expect("it").1, v(0.9, 0., 0.))
    }),
    ("a cylinder reaches from z -1 to 1 with radius 1, open at the ends", || {
        met("Shape \"cylinder\"", v(0., 0., -5.), DVec3::Z).is_none()
            && near(met("Shape \"cylinder\"", v(5., 0., 0.9), -DVec3::X).expect("it").1, v(1., 0., 0.9))
    }),
    // ---- Lights
    ("an area light shines from the outer side", || {
        seen(SPHERE_LAMP, v(0., 0., -5.), DVec3::Z).0 == 2.0 && seen(SPHERE_LAMP, DVec3::ZERO, DVec3::Z).0 == 0.0
    }),
    ("which ReverseOrientation turns", || seen(&format!("ReverseOrientation {SPHERE_LAMP}"), DVec3::ZERO, DVec3::Z).0 == 2.0),
    ("twosided shines from both", || {
        seen("AreaLightSource \"diffuse\" \"bool twosided\" true Shape \"sphere\"", DVec3::ZERO, DVec3::Z).0 == 1.0
    }),
    ("scale multiplies a light", || intensity("LightSource \"point\" \"spectrum I\" 3 \"float scale\" 2", DVec3::X) == 6.0),
    ("an area light ends with its attributes", || {
        seen(&format!("AttributeBegin {SPHERE_LAMP} AttributeEnd Translate 0 9 0 Shape \"sphere\""), v(0., 9., -5.), DVec3::Z).0
            == 0.0
    }),
    ("a distant light shines along +z", || near(sky("LightSource \"distant\""), -DVec3::Z)),
    ("a distant light shines from `from` to `to`, whatever their distance", || {
        near(sky("LightSource \"distant\" \"point3 from\" [2 0 0] \"point3 to\" [0 0 0]"), DVec3::X)
    }),
    ("lights are moved by the current transform", || near(sky("Rotate 90 0 1 0 LightSource \"distant\""), -DVec3::X)),
    ("a spot shines along +z", || {
        intensity("LightSource \"spot\"", DVec3::Z) == 1.0 && intensity("LightSource \"spot\"", -DVec3::Z) == 0.0
    }),
    ("a spot ends at coneangle", || {
        intensity("LightSource \"spot\"", v(0.49, 0., 0.87)) > 0.0 && intensity("LightSource \"spot\"", v(0.51, 0., 0.86)) == 0.0
    }),
    ("a spot falls off over conedeltaangle", || {
        let at = |degrees: f64| intensity("LightSource \"spot\"", v(degrees.to_radians().sin(), 0., degrees.to_radians().cos()));
        at(24.9) == 1.0 && at(25.5) < 1.0 && (at(27.6) - 0.5).abs() < 0.02
    }),
    ("power is over all directions", || {
        let i = intensity("LightSource \"point\" \"float power\" 10", DVec3::Y);
        (i - 10.0 / (4.0 * std::f32::consts::PI)).abs() < 1e-5
    }),
    // ---- Materials
    ("without a material, a shape is a diffuse one of reflectance 0.5", || {
        (seen("Shape \"sphere\"", v(0., 0., -5.), DVec3::Z).1 - 0.5).abs() < 1e-6
    }),
    ("a glass reflects as 1.5", || {
        // Reflected (eta - 1)^2/(eta + 1)^2; the rest is refracted, with the factor 1/eta^2.
        let share = seen("Material \"dielectric\" Shape \"sphere\"", v(0., 0., -5.), DVec3::Z).1;
        let r = 0.04f32;
        (share - (r + (1.0 - r) / 2.25)).abs() < 0.05
    }),
    ("a named material may be defined after it is used", || {
        let text =
            "NamedMaterial \"a\" Shape \"sphere\" MakeNamedMaterial \"a\" \"string type\" \"diffuse\" \"float reflectance\" 0.25";
        (seen(text, v(0., 0., -5.), DVec3::Z).1 - 0.25).abs() < 1e-6
    }),
    ("a metal is copper", || {
        let of = |m: &str| seen(&format!("Material \"conductor\" {m} Shape \"sphere\""), v(0., 0., -5.), DVec3::Z).1;
        (of("") - of("\"spectrum eta\" \"metal-Cu-eta\" \"spectrum k\" \"metal-Cu-k\"")).abs() < 1e-6
    }),
    ("roughness is remapped: alpha is its square root", || {
        let text = |m: &str| format!("Material \"conductor\" {m} Shape \"sphere\"");
        let of = |m: &str| seen(&text(m), v(0., 0.3, -5.), DVec3::Z).1;
        let (remapped, alpha) = (of("\"float roughness\" 0.25"), of("\"float roughness\" 0.5 \"bool remaproughness\" false"));
        (remapped - alpha).abs() < 1e-6 && (remapped - of("\"float roughness\" 0.25 \"bool remaproughness\" false")).abs() > 1e-4
    }),
    // ---- Defaults
    ("perspective: lensradius 0", || default("camera", "perspective", "lensradius", "0")),
    ("perspective: focaldistance 10^6", || default("camera", "perspective", "focaldistance", "1000000")),
    ("orthographic: lensradius 0", || default("camera", "orthographic", "lensradius", "0")),
    ("orthographic: focaldistance 10^6", || default("camera", "orthographic", "focaldistance", "1000000")),
    ("spherical: mapping equalarea", || default("camera", "spherical", "mapping", "\"equalarea\"")),
    ("rgb: 1280 by 720", || default("film", "rgb", "xresolution", "1280") && default("film", "rgb", "yresolution", "720")),
    ("rgb: cropwindow 0 1 0 1", || default("film", "rgb", "cropwindow", "[0 1 0 1]")),
    ("spectral: 16 buckets", || default("film", "spectral", "nbuckets", "16")),
    ("spectral: from 360 nm", || default("film", "spectral", "lambdamin", "360")),
    ("spectral: to 830 nm", || default("film", "spectral", "lambdamax", "830")),
    ("box: radius 0.5", || default("filter", "box", "xradius", "0.5") && default("filter", "box", "yradius", "0.5")),
    ("gaussian: radius 1.5", || {
        default("filter", "gaussian", "xradius", "1.5") && default("filter", "gaussian", "yradius", "1.5")
    }),
    ("gaussian: sigma 0.5", || default("filter", "gaussian", "sigma", "0.5")),
    ("mitchell: radius 2", || default("filter", "mitchell", "xradius", "2") && default("filter", "mitchell", "yradius", "2")),
    ("mitchell: B and C a third", || ["B", "C"].iter().all(|p| default("filter", "mitchell", p, "0.3333333333333333"))),
    ("sinc: radius 4", || default("filter", "sinc", "xradius", "4") && default("filter", "sinc", "yradius", "4")),
    ("sinc: tau 3", || default("filter", "sinc", "tau", "3")),
    ("triangle: radius 2", || default("filter", "triangle", "xradius", "2") && default("filter", "triangle", "yradius", "2")),
    ("independent: 16 samples", || default("sampler", "independent", "pixelsamples", "16")),
    ("sobol: 16 samples", || default("sampler", "sobol", "pixelsamples", "16")),
    ("stratified: 4 by 4", || {
        default("sampler", "stratified", "xsamples", "4") && default("sampler", "stratified", "ysamples", "4")
    }),
    ("stratified: jittered", || default("sampler", "stratified", "jitter", "true")),
    ("path: maxdepth 5", || default("light transport", "path", "maxdepth", "5")),
    ("diffuse: reflectance 0.5", || default("material", "diffuse", "reflectance", "0.5")),
    ("conductor: roughness 0", || default("material", "conductor", "roughness", "0")),
    ("conductor: remaproughness", || default("material", "conductor", "remaproughness", "true")),
    ("dielectric: eta 1.5", || default("material", "dielectric", "eta", "1.5")),
    ("lights: scale 1", || ["distant", "infinite", "point", "spot"].iter().all(|l| default("light", l, "scale", "1"))),
    ("spot: coneangle 30", || default("light", "spot", "coneangle", "30")),
    ("spot: conedeltaangle 5", || default("light", "spot", "conedeltaangle", "5")),
    ("area light: one side", || default("area light", "diffuse", "twosided", "false")),
    ("sphere: radius 1", || default("shape", "sphere", "radius", "1")),
    ("sphere: phimax 360", || default("shape", "sphere", "phimax", "360")),
    ("disk: radius 1", || default("shape", "disk", "radius", "1")),
    ("disk: height 0", || default("shape", "disk", "height", "0")),
    ("disk: innerradius 0", || default("shape", "disk", "innerradius", "0")),
    ("cylinder: from -1 to 1", || default("shape", "cylinder", "zmin", "-1") && default("shape", "cylinder", "zmax", "1")),
];

#[test]
fn what_pbrt_users_take_for_granted_holds() {
    let names: BTreeSet<&str> = FACTS.iter().map(|f| f.0).collect();
    assert!(FACTS.len() >= 60 && names.len() == FACTS.len());
    let wrong: Vec<&str> = FACTS.iter().filter(|(_, holds)| !holds()).map(|f| f.0).collect();
    assert!(wrong.is_empty(), "of {} facts these do not hold: {wrong:#?}", FACTS.len());
}
