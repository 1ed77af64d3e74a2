//! Following light takes no memory: once a scene is built, no path allocates, whatever follows it and whatever it meets. (What Embree does
//! within is its own; it answers queries from the stack.)

use crate::common::{build_with, read};
use bhs::lang::{self, BuiltScene, Overrides, SourceMap};
use bhs::not_finite::SampleId;
use bhs::registry::Registry;
use bhs::render::Job;
use bhs::sample::CameraSample;
use bhs_core::sampling::SampleStream;
use bhs_core::spectrum::VisibleWavelengths;
use bhs_engine::integrator::IntegratorBuilder;
use bhs_engine::stats::PathLog;
use bhs_engine::transport::LightTransport;

/// Follows `count` camera paths all over the picture, and returns how many rays that took.
fn follow(built: &BuiltScene, count: u32, sums: &mut [f64]) -> u64 {
    let [width, height] = built.film.resolution();
    let [lo, hi] = built.film.lambda_range();
    let (job, wavelengths) = (Job::of(built), VisibleWavelengths::new(lo, hi));
    let mut log = PathLog::default();
    for i in 0..count {
        let pixel = [i % width, i / width % height];
        let sample = i / (width * height);
        let stream = SampleStream::new(&*built.sampler, pixel, sample);
        let (sample, mut path) = CameraSample::new(&job, &wavelengths, SampleId { pixel, sample }, stream);
        built.transport.follow(&built.scene, &mut path, &mut log);
        sample.add(&job, &path, sums, &mut log);
    }
    log.counters.geodesics
}

fn check(name: &str, text: &str, count: u32, overrides: &Overrides) {
    let overrides = Overrides { resolution: Some([64, 48]), ..overrides.clone() };
    let built = build_with(text, &overrides);
    check_built(&format!("{name}, {overrides:?}"), &built, count);
}

fn check_built(name: &str, built: &BuiltScene, count: u32) {
    let mut sums = vec![0.0; built.film.channels().len()];
    // What is made when it is first asked for is made here.
    follow(built, 100, &mut sums);
    let mut rays = 0;
    let found = allocation_counter::measure(|| rays = follow(built, count, &mut sums));
    assert!(rays >= u64::from(count), "{name}: {rays} rays");
    assert_eq!(found.count_total, 0, "{name}: {} bytes in {rays} rays", found.bytes_total);
}

/// Scene files by name, with includes seen from the project's root.
fn scene(name: &str) -> String {
    read(&format!("scenes/{name}.bhs")).replace("Include \"", "Include \"scenes/").replace("\"meshes/", "\"scenes/meshes/")
}

fn with<F: Fn(&mut Overrides)>(change: F) -> Overrides {
    let mut overrides = Overrides::default();
    change(&mut overrides);
    overrides
}

#[test]
fn what_allocates_is_counted() {
    assert_eq!(allocation_counter::measure(|| drop(std::hint::black_box(vec![0_u8; 8]))).count_total, 1);
}

#[test]
fn no_light_transport_allocates_with_or_without_a_hole() {
    let registry = Registry::builtin();
    let transports = registry.names::<dyn LightTransport>();
    assert!(transports.len() >= 2);
    for transport in transports {
        let overrides = with(|o| o.transport = Some(transport.to_owned()));
        for name in ["cornell_box", "cornell_hole"] {
            check(name, &scene(name), 20_000, &overrides);
        }
    }
}

#[test]
fn no_integrator_allocates() {
    // `general` reads a metric anew for each batch, and is the measure of the others, not the fast one.
    for integrator in Registry::builtin().names::<dyn IntegratorBuilder>().into_iter().filter(|name| *name != "general") {
        check("cornell_hole", &scene("cornell_hole"), 2_000, &with(|o| o.integrator = Some(integrator.to_owned())));
    }
    let micro_steps = format!("Integrator \"schwarzschild-rk4\" \"string hits\" \"chord\"\n{}", scene("cornell_hole"));
    check("cornell_hole", &micro_steps, 2_000, &Overrides::default());
}

#[test]
fn no_material_and_no_light_of_the_scenes_allocates() {
    for name in ["spheres", "spheres_hole", "redshift_spheres", "redshift_wall", "blueshift", "frames_chart"] {
        check(name, &scene(name), 2_000, &Overrides::default());
    }
}

#[test]
fn no_plugin_of_the_reference_allocates() {
    // Every plugin has an example there.
    let reference = read("grammar/README.md");
    let examples = reference.split("```bhs\n").skip(1).map(|rest| rest.split("```").next().unwrap_or(rest));
    let mut count = 0;
    for (number, example) in examples.enumerate() {
        let name = format!("example {number}: {example}");
        let mut sources = SourceMap::new();
        let file = format!("grammar/example_{number}.bhs");
        let overrides = Overrides { resolution: Some([64, 48]), ..Default::default() };
        // What such spacetimes are made of is told anew for each batch of rays.
        let sets_up = ["general", "reissner", "kerr", "majumdar", "ellis", "dneg"].iter().any(|name| example.contains(name));
        if sets_up {
            continue;
        }
        match lang::load_text(&file, example, &Registry::builtin(), &overrides, &mut sources) {
            Ok(built) => check_built(&name, &built, 500),
            Err(found) => panic!("{name}: {}", bhs::report::render(&found, &sources, false)),
        }
        count += 1;
    }
    assert!(count >= 50, "{count}");
}
