//! A picture's layers, the counts of its render and `bhs trace` say the same of a camera ray, to the bit, whatever follows it.

use crate::common;
use bhs::lang::{BuiltScene, Overrides};
use bhs::not_finite::SampleId;
use bhs::registry::Registry;
use bhs::render::{Job, Rendered};
use bhs::sample::CameraSample;
use bhs::trace::Answers;
use bhs_core::ray::{Arrival, Ray, RayEnd};
use bhs_core::sampling::SampleStream;
use bhs_core::spacetime::{Class, Side};
use bhs_core::spectrum::VisibleWavelengths;
use bhs_engine::connections::Connections;
use bhs_engine::integrator::{Integrator, IntegratorBuilder};
use bhs_engine::transport::LightTransport;
use bhs_engine::way::Watch;
use bhs_engine::world::World;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::sync::atomic::Ordering::Relaxed;

/// A picture of all layers; every sample weighs 1 and follows one ray.
fn options(samples: u32) -> String {
    let layers: Vec<String> = bhs_layers::ALL.iter().map(|layer| format!("\"{}\"", layer.name)).collect();
    format!(
        "Film \"rgb\" \"integer xresolution\" 16 \"integer yresolution\" 12 \"string layers\" [{}]
         Sampler \"sobol\" \"integer pixelsamples\" {samples}  PixelFilter \"box\"  LightTransport \"normals\"",
        layers.join(" ")
    )
}

/// Small things at many places, so that there is free space to pass over.
fn things() -> String {
    let ball = |x: i32, y: i32, z: i32| {
        format!("AttributeBegin Translate {x} {y} {z} Shape \"sphere\" \"float radius\" 0.3 AttributeEnd\n")
    };
    let mut text = String::new();
    for (x, y) in [(-3, -2), (-3, 1), (0, -2), (0, 2), (2, -1), (3, 2)] {
        text += &ball(x, y, (x + y).rem_euclid(3) - 1);
    }
    text + "Shape \"trianglemesh\" \"point3 P\" [-4 -4 5  4 -4 5  4 4 5  -4 4 5] \"integer indices\" [0 1 2 0 2 3]\n"
}

const CAMERA: &str = "LookAt 0 0 -6  0 0 0  0 1 0  Camera \"perspective\" \"float fov\" 60";

/// A scene of all that, in such a spacetime.
fn around(samples: u32, spacetime: &str) -> String {
    format!("{} {CAMERA} WorldBegin LightSource \"infinite\" {spacetime}\n{}", options(samples), things())
}

/// A plain hole, two holes, one that turns, and a wormhole, each with the integrators that work there.
fn scenes(samples: u32) -> Vec<(String, BuiltScene)> {
    let wormhole = around(samples, "Wormhole \"ellis\" \"float throat\" 1") + &format!("Side \"far\"\n{}", things());
    let all: Vec<String> = Registry::builtin().names::<dyn IntegratorBuilder>().into_iter().map(str::to_owned).collect();
    assert!(all.len() >= 6, "{all:?}");
    let some = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect::<Vec<_>>();
    let cases = [
        ("hole", around(samples, "BlackHole \"schwarzschild\" \"float rs\" 0.5"), all),
        (
            "charged hole",
            around(samples, "BlackHole \"reissner-nordstrom\" \"float rs\" 0.5 \"float charge\" 0.5"),
            some(&["adaptive", "general"]),
        ),
        (
            "two holes",
            around(samples, "BlackHole \"majumdar-papapetrou\" \"point3 centers\" [-1 0 0  1 0 0] \"float masses\" [0.2 0.1]"),
            some(&["adaptive", "general"]),
        ),
        ("wormhole", wormhole, some(&["straight", "adaptive", "general"])),
    ];
    let mut scenes = Vec::new();
    for (name, text, integrators) in cases {
        for integrator in integrators {
            let overrides = Overrides { integrator: Some(integrator.clone()), ..Overrides::default() };
            scenes.push((format!("{name}, {integrator}"), common::build_with(&text, &overrides)));
        }
    }
    scenes
}

fn layer(rendered: &Rendered, wanted: &str) -> Vec<Option<[f64; 3]>> {
    rendered.frame.layers().into_iter().find(|picture| picture.name == wanted).expect("all layers are recorded").values
}

#[test]
fn the_mean_of_the_queries_layer_is_what_the_render_counts() {
    for (name, built) in scenes(3) {
        let rendered = common::render(&built);
        let queries = layer(&rendered, "queries");
        let mean = queries.iter().map(|q| q.expect("every ray has queries")[0]).sum::<f64>() / queries.len() as f64;
        let counters = &rendered.counters;
        assert_eq!((counters.paths, counters.geodesics, counters.shadow_rays), (16 * 12 * 3, 16 * 12 * 3, 0), "{name}");
        let counted = counters.queries as f64 / counters.geodesics as f64;
        assert!(counted > 0.0 && (mean / counted - 1.0).abs() < 1e-12, "{name}: {mean} {counted}");
    }
}

/// An integrator that counts the rays that it is asked to follow.
struct Counted {
    integrator: Box<dyn Integrator>,
    rays: Arc<AtomicU64>,
}

impl Integrator for Counted {
    fn trace_all(&self, world: &World, rays: &[Ray], ends: &mut [RayEnd]) {
        self.rays.fetch_add(rays.len() as u64, Relaxed);
        self.integrator.trace_all(world, rays, ends);
    }

    fn watched(&self, world: &World, ray: &Ray, watch: &mut dyn Watch) -> RayEnd {
        self.rays.fetch_add(1, Relaxed);
        self.integrator.watched(world, ray, watch)
    }

    fn connections(&self) -> Option<&dyn Connections> {
        self.integrator.connections()
    }
}

#[test]
fn layers_follow_no_ray_of_their_own() {
    for transport in Registry::builtin().names::<dyn LightTransport>() {
        let overrides = Overrides { transport: Some(transport.to_owned()), ..Overrides::default() };
        // But for the travel time, which is a sum along the ray.
        let text = around(3, "BlackHole \"schwarzschild\" \"float rs\" 0.5");
        let text = text.replace("\"traveltime\"", "");
        let mut built = common::build_with(&text, &overrides);
        assert_eq!(built.layers.len(), bhs_layers::ALL.len() - 1);
        let rays = Arc::new(AtomicU64::new(0));
        let integrator = std::mem::replace(&mut built.scene.integrator, Box::new(bhs_integrators::Straight));
        built.scene.integrator = Box::new(Counted { integrator, rays: rays.clone() });
        let rendered = common::render(&built);
        assert!(rendered.counters.geodesics >= 16 * 12 * 3);
        assert_eq!(rays.load(Relaxed), rendered.counters.geodesics, "{transport}");
    }
}

/// The camera rays of a picture of one sample a pixel, row by row.
fn camera_rays(built: &BuiltScene) -> Vec<Ray> {
    let (job, [lo, hi]) = (Job::of(built), built.film.lambda_range());
    let wavelengths = VisibleWavelengths::new(lo, hi);
    let [width, height] = built.film.resolution();
    let pixels = (0..height).flat_map(|y| (0..width).map(move |x| [x, y]));
    let ray = |pixel| {
        let stream = SampleStream::new(&*built.sampler, pixel, 0);
        CameraSample::new(&job, &wavelengths, SampleId { pixel, sample: 0 }, stream).1.ray
    };
    pixels.map(ray).collect()
}

/// What `layer` records of a ray; `None` for layers that say it otherwise.
fn recorded(built: &BuiltScene, ray: &Ray, end: &RayEnd, layer: &str) -> Option<Option<[f64; 3]>> {
    let world = &built.scene.world;
    let scalar = |x: f64| Some([x, 0.0, 0.0]);
    let hit = match end.arrival {
        Arrival::Surface(hit) => Some(hit),
        _ => None,
    };
    let side = match end.arrival {
        Arrival::Surface(hit) => Some(world.side_of(hit.geometry)),
        Arrival::Sky(_, side) => Some(side),
        _ => None,
    };
    Some(match layer {
        "queries" => scalar(f64::from(end.cost.queries)),
        "outcome" => match end.arrival {
            Arrival::Surface(_) => Some([1.0, 0.0, 0.0]),
            Arrival::Sky(..) => Some([0.0, 1.0, 0.0]),
            Arrival::Captured => Some([0.0, 0.0, 1.0]),
            Arrival::OutOfSteps => None,
        },
        "position" => hit.map(|hit| (hit.point + world.origin).to_array()),
        "depth" => {
            hit.filter(|hit| world.side_of(hit.geometry) == ray.side).and_then(|hit| scalar((hit.point - ray.origin).length()))
        }
        "side" => side.and_then(|side| scalar(f64::from(side as u8))),
        "sweptangle" if matches!(world.spacetime().class(), Class::Spherical(_)) => scalar(end.swept),
        _ => return None,
    })
}

#[test]
fn a_ray_that_is_traced_alone_ends_as_its_picture_says() {
    for (name, built) in scenes(1) {
        let rendered = common::render(&built);
        let (rays, scene) = (camera_rays(&built), &built.scene);
        let ends: Vec<RayEnd> = rays.iter().map(|ray| scene.integrator.trace(&scene.world, ray)).collect();
        let kinds = ["hit", "escaped"].map(|kind| {
            ends.iter()
                .filter(|end| matches!((kind, end.arrival), ("hit", Arrival::Surface(_)) | ("escaped", Arrival::Sky(..))))
                .count()
        });
        assert!(kinds.iter().all(|n| *n > 10), "{name}: {kinds:?}");
        let mut compared = 0;
        for wanted in bhs_layers::ALL.iter().map(|layer| layer.name) {
            for ((ray, end), found) in rays.iter().zip(&ends).zip(layer(&rendered, wanted)) {
                let Some(expected) = recorded(&built, ray, end, wanted) else { continue };
                assert_eq!(found, expected, "{name}: {} of {ray:?}", wanted);
                compared += 1;
            }
        }
        assert!(compared >= 5 * rays.len(), "{name}: {compared}");
        // Whoever watches the way sees the same.
        for (ray, end) in rays.iter().zip(&ends) {
            assert_eq!(scene.integrator.polyline(&scene.world, ray).0, *end, "{name}: {ray:?}");
        }
    }
}

/// The numbers that follow `key` in a line of JSON, to the bit (which `serde_json` does not read them).
fn numbers(json: &str, key: &str) -> Vec<f64> {
    let (_, rest) = json.split_once(key).expect("it is there");
    rest.split([',', ']', '}']).map_while(|number| number.parse().ok()).collect()
}

#[test]
fn bhs_trace_of_camera_rays_says_what_their_picture_saw() {
    for (name, built) in scenes(1) {
        let rendered = common::render(&built);
        let (rays, origin) = (camera_rays(&built), built.scene.world.origin);
        let mut lines = String::from("ox,oy,oz,dx,dy,dz,side,footprint\n");
        for ray in &rays {
            let start = ray.origin + origin;
            assert_eq!(start - origin, ray.origin, "no rounding on the way to world space and back");
            let numbers = [start, ray.direction].map(|v| format!("{:?},{:?},{:?}", v.x, v.y, v.z)).join(",");
            let side = if ray.side == Side::Far { "far" } else { "near" };
            lines += &format!("{numbers},{side},{:?}\n", ray.footprint);
        }
        for with_path in [false, true] {
            let mut out = Vec::new();
            bhs::trace::trace(&Answers { with_path, ..Answers::new(&built.scene) }, lines.as_bytes(), &mut out)
                .expect("all rays are answered");
            let text = String::from_utf8(out).expect("text");
            let answers: Vec<&str> = text.lines().collect();
            assert_eq!(answers.len(), rays.len());
            let [positions, queries] = ["position", "queries"].map(|wanted| layer(&rendered, wanted));
            for ((answer, position), queries) in answers.iter().zip(positions).zip(queries) {
                let point =
                    answer.contains("\"hit\"").then(|| numbers(answer, "\"point\":[")[..3].try_into().expect("three numbers"));
                assert_eq!(point, position, "{name}: {answer}");
                assert_eq!(queries.map(|q| q[0]), numbers(answer, "\"queries\":").first().copied(), "{name}: {answer}");
            }
        }
    }
}

#[test]
fn what_is_wrong_with_the_columns_of_rays_is_told() {
    let built = common::build("WorldBegin LightSource \"infinite\"");
    let traced = |text: &str| {
        let mut out = Vec::new();
        bhs::trace::trace(&Answers::new(&built.scene), text.as_bytes(), &mut out)
            .map(|()| out.iter().filter(|b| **b == b'\n').count())
    };
    let header = "ox,oy,oz,dx,dy,dz";
    for (columns, line, answers) in [
        ("", "0,0,0,0,0,1", 1),
        (",footprint", "0,0,0,0,0,1,0.5\n0,0,0,0,0,1,\n# 1,2,3\n\n", 2),
        (", footprint, side", "0,0,0,0,0,2, 1e-3, near", 1),
    ] {
        assert_eq!(traced(&format!("{header}{columns}\n{line}\n")).expect("they are rays"), answers, "{columns}");
    }
    for (columns, line, word) in [
        (",colour", "", "colour"),
        (",side,side", "", "side"),
        (",footprint", "0,0,0,0,0,1,-1", "-1"),
        (",footprint", "0,0,0,0,0,1,inf", "inf"),
        (",footprint", "0,0,0,0,0,1", "found 6"),
        (",footprint,side", "0,0,0,0,0,1,1,left", "left"),
    ] {
        let error = traced(&format!("{header}{columns}\n{line}\n")).expect_err("they are none");
        assert!(format!("{error:#}").contains(word), "{columns} {line}: {error:#}");
    }
}
