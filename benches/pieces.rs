//! Time of the pieces that a render is made of: a step of an orbit, a ray with its chords, a connection, a spectrum, a material, and what
//! is read before: PLY files and scenes.
//!
//! `cargo bench --bench pieces`, all of it in a minute or two; `cargo bench --bench pieces -- steps` one group. More of the same beside the
//! crates: `cargo bench -p bhs-intersectors`, `cargo bench -p bhs-integrators`.

use bhs::bench::rays::{bounce_rays, camera_rays};
use bhs::lang::{self, BuiltScene, Overrides, SourceMap};
use bhs::registry::{Registry, bare_context};
use bhs_core::diagnostics::{Span, Spanned};
use bhs_core::material::Material;
use bhs_core::ray::{Arrival, Ray};
use bhs_core::sampling::{SampleStream, cosine_hemisphere};
use bhs_core::spacetime::Class;
use bhs_core::spectrum::{SampledWavelengths, SpectrumRole};
use bhs_core::value::{Param, ParamType, Values};
use bhs_engine::connections::Connections;
use bhs_engine::integrator::Integrator;
use bhs_integrators::Tolerance;
use bhs_integrators::closed_form::ClosedForm;
use bhs_integrators::orbit::{OrbitPlane, Rk4Orbit, Stepper};
use bhs_integrators::taylor::TaylorOrbit;
use bhs_integrators::{Adaptive, Exact, MicroSteps, Rk4, Straight};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::hint::black_box;
use std::path::Path;
use std::time::Duration;

/// Things of one measurement: too many for the processor to learn their branches.
const MANY: usize = 2048;

/// The text of a scene of the project, which reads its files from anywhere.
fn text(name: &str) -> String {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes");
    let text = std::fs::read_to_string(folder.join(format!("{name}.bhs"))).expect("the project's scenes are there");
    text.replace("Include \"", &format!("Include \"{}/", folder.display()))
}

fn build(text: &str) -> BuiltScene {
    let mut sources = SourceMap::new();
    let built = lang::load_text("scene.bhs", text, &Registry::builtin(), &Overrides::default(), &mut sources);
    built.unwrap_or_else(|found| panic!("{}", bhs::report::render(&found, &sources, false)))
}

fn steps(criterion: &mut Criterion) {
    let built = build(&text("cornell_hole"));
    let Class::Spherical(hole) = built.scene.world.spacetime().class() else { panic!("the scene has a hole") };
    let starts: Vec<_> = bounce_rays(&built, &camera_rays(&built, 2 * MANY))
        .iter()
        .take(MANY)
        .map(|ray| OrbitPlane::of_ray(hole.center, ray.origin, ray.direction).1)
        .collect();
    let mut group = criterion.benchmark_group("steps");
    group.throughput(Throughput::Elements(starts.len() as u64));
    group.bench_function("Runge-Kutta", |b| {
        b.iter(|| starts.iter().map(|s| Rk4Orbit { hole: hole.rs.into(), step: 0.1, state: *s }.advance().0.end.u).sum::<f64>())
    });
    group.bench_function("Taylor series, error 1e-6", |b| {
        b.iter(|| {
            for s in &starts {
                black_box(TaylorOrbit::new(hole.rs, *s, 1e-6).advance());
            }
        });
    });
    group.bench_function("closed form and one point of it", |b| {
        b.iter(|| starts.iter().map(|s| ClosedForm::new(hole.rs, s.u, s.du).at(0.5).0).sum::<f64>());
    });
    group.finish();
}

fn chords(criterion: &mut Criterion) {
    let built = build(&text("cornell_hole"));
    let world = &built.scene.world;
    let rays: Vec<Ray> = bounce_rays(&built, &camera_rays(&built, 2 * MANY)).into_iter().take(MANY).collect();
    let integrators: [(&str, Box<dyn Integrator>); 5] = [
        ("straight", Box::new(Straight)),
        ("adaptive", Box::new(Adaptive::new(Tolerance::DEFAULT, 100_000))),
        ("exact", Box::new(Exact::new(Tolerance::DEFAULT, 100_000))),
        ("rk4, 0.1 rad", Box::new(Rk4::new(0.1, 100_000))),
        ("micro-steps, 0.1 rad", Box::new(MicroSteps::new(0.1, 100_000))),
    ];
    let mut group = criterion.benchmark_group("rays of a room with a hole");
    group.throughput(Throughput::Elements(rays.len() as u64));
    for (name, integrator) in &integrators {
        group.bench_function(*name, |b| {
            b.iter(|| rays.iter().filter(|ray| integrator.trace(world, ray).arrival == Arrival::Captured).count())
        });
    }
    group.finish();
}

fn connections(criterion: &mut Criterion) {
    let built = build(&text("cornell_hole"));
    let world = &built.scene.world;
    let integrator = Adaptive::new(Tolerance::DEFAULT, 100_000);
    let connections = integrator.connections().expect("it joins points");
    let points: Vec<_> =
        bounce_rays(&built, &camera_rays(&built, 3 * MANY)).iter().take(2 * MANY).map(|ray| ray.origin).collect();
    let mut group = criterion.benchmark_group("connections");
    group.throughput(Throughput::Elements((points.len() / 2) as u64));
    for (name, connections) in [("straight", &Straight as &dyn Connections), ("a pair around the hole", connections)] {
        group.bench_function(name, |b| {
            b.iter(|| {
                points
                    .chunks_exact(2)
                    .map(|p| {
                        connections
                            .connect(world, bhs_core::spacetime::Place::near(p[0]), bhs_core::spacetime::Place::near(p[1]), 0)
                            .iter()
                            .flatten()
                            .count()
                    })
                    .sum::<usize>()
            })
        });
    }
    group.finish();
}

fn wavelengths() -> Vec<SampledWavelengths> {
    (0..MANY).map(|i| SampledWavelengths::visible((i as f32 + 0.5) / MANY as f32, 360.0, 830.0)).collect()
}

fn spectra(criterion: &mut Criterion) {
    let numbers = |values: &[f64]| Values::Numbers { values: values.to_vec(), whole: false };
    let name = |name: &str| Values::Strings(vec![Spanned::new(name.to_owned(), Span::default())]);
    let cases = [
        ("constant", ParamType::Spectrum, numbers(&[0.5])),
        ("measured paint", ParamType::Spectrum, name("cornell-white")),
        ("measured metal", ParamType::Spectrum, name("metal-Au-eta")),
        ("daylight", ParamType::Spectrum, name("stdillum-D65")),
        ("glass", ParamType::Spectrum, name("glass-BK7")),
        ("rgb", ParamType::Rgb, numbers(&[0.8, 0.3, 0.1])),
        ("blackbody", ParamType::Blackbody, numbers(&[5500.0])),
    ];
    let (registry, sources, lambda) = (Registry::builtin(), SourceMap::new(), wavelengths());
    let mut group = criterion.benchmark_group("spectra, four wavelengths");
    group.throughput(Throughput::Elements(lambda.len() as u64));
    for (case, ty, values) in cases {
        let span = Span::default();
        let param = Param { ty: Spanned::new(ty, span), name: Spanned::new("s".to_owned(), span), values, span };
        let context = bare_context(&sources, registry.spectra());
        let role = if case == "blackbody" { SpectrumRole::Emission } else { SpectrumRole::Unbounded };
        let spectrum = registry.spectra().build(&param, role, &context).expect("a spectrum");
        group.bench_function(case, |b| b.iter(|| lambda.iter().map(|l| spectrum.sample(l.lambda_nm)[0]).sum::<f32>()));
    }
    group.bench_function("choice of wavelengths", |b| {
        b.iter(|| {
            (0..MANY).map(|i| SampledWavelengths::visible(black_box(i as f32) / MANY as f32, 360.0, 830.0).pdf[0]).sum::<f32>()
        })
    });
    group.finish();
}

fn materials(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("materials");
    group.throughput(Throughput::Elements(MANY as u64));
    let cases = [
        ("diffuse", "\"spectrum reflectance\" \"cornell-white\""),
        ("conductor", "\"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\" \"float roughness\" 0.15"),
        ("mirror", ""),
        ("dielectric", ""),
    ];
    for (name, parameters) in cases {
        let scene = format!(
            "WorldBegin\nLightSource \"infinite\"\nTranslate 0 0 3\nMaterial \"{name}\" {parameters}\nShape \"sphere\"\n"
        );
        let built = build(&scene);
        let hits =
            camera_rays(&built, 16 * MANY).into_iter().filter_map(|ray| match Straight.trace(&built.scene.world, &ray).arrival {
                Arrival::Surface(hit) => Some(hit),
                _ => None,
            });
        let lambda = wavelengths();
        let vertices: Vec<_> = hits.zip(&lambda).filter_map(|(hit, lambda)| built.scene.vertex(hit, lambda)).take(MANY).collect();
        let numbers: Vec<_> = (0..vertices.len() as u32)
            .map(|i| {
                let mut stream = SampleStream::new(&*built.sampler, [0, 0], i);
                (stream.next_1d(), stream.next_2d())
            })
            .collect();
        let material: &dyn Material = vertices[0].material;
        group.bench_function(format!("{name}: sample"), |b| {
            b.iter(|| {
                for (v, (choice, u)) in vertices.iter().zip(&numbers) {
                    black_box(material.sample(&v.shading, v.wo, *choice, *u));
                }
            });
        });
        if !material.is_specular() {
            group.bench_function(format!("{name}: evaluate and density"), |b| {
                b.iter(|| {
                    for (v, (_, u)) in vertices.iter().zip(&numbers) {
                        let wi = cosine_hemisphere(*u);
                        black_box((material.evaluate(&v.shading, v.wo, wi), material.pdf(&v.shading, v.wo, wi)));
                    }
                });
            });
        }
    }
    group.finish();
}

/// A square of 2 n^2 triangles as a PLY file, as text or as little-endian numbers.
fn ply(n: u32, as_text: bool) -> Vec<u8> {
    let (vertices, faces) = ((n + 1) * (n + 1), 2 * n * n);
    let format = if as_text { "ascii" } else { "binary_little_endian" };
    let mut file = format!(
        "ply\nformat {format} 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\nproperty float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )
    .into_bytes();
    for i in 0..vertices {
        let [x, y] = [i % (n + 1), i / (n + 1)].map(|k| k as f32 / n as f32);
        let z = (7.0 * x).sin() * (5.0 * y).cos();
        if as_text {
            file.extend(format!("{x} {y} {z} \n").bytes());
        } else {
            file.extend([x, y, z].into_iter().flat_map(f32::to_le_bytes));
        }
    }
    for i in 0..n * n {
        let a = i / n * (n + 1) + i % n;
        for [p, q, r] in [[a, a + 1, a + n + 2], [a, a + n + 2, a + n + 1]] {
            if as_text {
                file.extend(format!("3 {p} {q} {r} \n").bytes());
            } else {
                file.push(3);
                file.extend([p, q, r].into_iter().flat_map(u32::to_le_bytes));
            }
        }
    }
    file
}

fn reading(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("reading");
    for (name, as_text) in [("PLY, text", true), ("PLY, binary", false)] {
        let file = ply(200, as_text);
        group.throughput(Throughput::Bytes(file.len() as u64));
        group.bench_function(format!("{name}, 80,000 triangles"), |b| {
            b.iter(|| bhs_shapes::ply::read(&file).map(|ply| ply.mesh.triangles.len()))
        });
    }
    for name in ["cornell_box", "spheres_hole"] {
        let text = text(name);
        group.throughput(Throughput::Bytes(text.len() as u64));
        group.bench_function(format!("parse {name}"), |b| b.iter(|| lang::parse::parse(&text, 0).0.len()));
        group.bench_function(format!("load {name}"), |b| b.iter(|| build(&text).load.triangles));
    }
    group.finish();
}

fn short() -> Criterion {
    Criterion::default().sample_size(20).warm_up_time(Duration::from_millis(300)).measurement_time(Duration::from_secs(1))
}

criterion_group! { name = pieces; config = short(); targets = steps, chords, connections, spectra, materials, reading }
criterion_main!(pieces);
