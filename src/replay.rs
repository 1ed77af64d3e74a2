//! One sample of a picture, followed once more with the same random numbers, step by step.

use crate::lang::{BuiltScene, Label, Labels, SourceMap};
use crate::not_finite::SampleId;
use crate::patches::Patches;
use crate::render::{Job, Wave};
use crate::sample::CameraSample;
use crate::wavelengths;
use bhs_core::ray::{Arrival, Ray, RayEnd, SurfaceHit};
use bhs_core::sampling::SampleStream;
use bhs_core::spectrum::{SampledSpectrum, SampledWavelengths, VisibleWavelengths};
use bhs_engine::path_log::{LightPlace, PathEvent};
use bhs_engine::stats::PathLog;
use bhs_engine::transport::{LightTransport, RenderSetting};
use glam::DVec3;
use serde_json::{Map, Value, json};

/// What became of a sample.
pub struct Replayed {
    /// Which one it is.
    pub id: SampleId,
    /// Wavelengths where the ray starts, and their densities.
    pub lambda: SampledWavelengths,
    /// The filter's weight.
    pub weight: f32,
    /// What happened to its path.
    pub events: Vec<PathEvent>,
    /// Spectral radiance that the film receives, before the filter's weight.
    pub radiance: SampledSpectrum,
    /// Whether the film takes it: it is finite, and stays so with the filter's weight.
    pub is_finite: bool,
    /// The channels of a picture that has this sample alone.
    pub channels: Vec<f64>,
}

/// Follows samples of a picture once more.
pub struct Replay<'a> {
    job: Job<'a>,
    setting: RenderSetting<'a>,
    wavelengths: VisibleWavelengths,
    /// The transport's memory, if it has one, and the wave that it has been told of.
    memory: Option<(Box<dyn LightTransport>, Option<Wave>)>,
}

impl<'a> Replay<'a> {
    /// Of the picture of `job`.
    pub fn new(job: Job<'a>) -> Self {
        let setting = job.setting();
        let memory = job.transport.for_render(&setting).map(|own| (own, None));
        Self { job, setting, wavelengths: wavelengths::drawn(&job), memory }
    }

    /// Follows sample `id` as a render does; samples of one wave after the other are followed fastest.
    pub fn follow(&mut self, id: SampleId) -> Replayed {
        let wave = Wave::of(id.sample);
        if let Some((memory, begun)) = &mut self.memory
            && begun.replace(wave) != Some(wave)
        {
            memory.begin_wave(&self.setting, wave.samples());
        }
        let transport = self.memory.as_ref().map_or(self.job.transport, |(own, _)| &**own);
        follow(&Job { transport, ..self.job }, &self.wavelengths, id)
    }
}

/// Follows sample `id` of `job`, whose transport is ready for its wave.
fn follow(job: &Job, wavelengths: &VisibleWavelengths, id: SampleId) -> Replayed {
    let stream = SampleStream::new(job.sampler, id.pixel, id.sample);
    let (sample, mut path) = CameraSample::new(job, wavelengths, id, stream);
    path.patch = Patches::of(job, std::iter::once(id.pixel)).get(0);
    let mut log = PathLog { path: Some(Vec::new()), ..PathLog::default() };
    job.transport.follow_all(job.scene, std::slice::from_mut(&mut path), &mut log);
    let events = log.path.take().unwrap_or_default();
    let radiance = sample.received(job, path.radiance, &mut log);
    let mut channels = vec![0.0; job.film.channels().len()];
    let weight = sample.add(job, &path, &mut channels, &mut log);
    if let Some(weight) = weight.filter(|w| *w != 0.0) {
        channels.iter_mut().for_each(|c| *c /= weight);
    }
    Replayed { id, lambda: sample.lambda, weight: sample.weight, events, radiance, is_finite: weight.is_some(), channels }
}

/// A number; one that is not finite as a text, which JSON has no number for.
fn number(x: f64) -> Value {
    if x.is_finite() { json!(x) } else { json!(x.to_string()) }
}

fn spectrum(s: SampledSpectrum) -> Value {
    numbers(s.0)
}

fn numbers(all: [f32; 4]) -> Value {
    // The shortest digits that are this number in single precision.
    all.iter().map(|x| number(x.to_string().parse().unwrap_or(f64::from(*x)))).collect()
}

fn vector(v: DVec3) -> Value {
    v.to_array().into_iter().map(number).collect()
}

/// A thing by name and place.
fn named(label: Option<Label>) -> Value {
    let Some(Label { plugin, place, material }) = label else { return Value::Null };
    let mut object = json!({ "plugin": plugin, "place": place });
    if let Some(material) = material {
        object["material"] = json!(material);
    }
    object
}

impl Replayed {
    /// All of it as JSON. Places are in world space, directions those of the chart; radiances of vertices are at E = 1, those of the whole where
    /// the ray starts.
    pub fn to_json(&self, built: &BuiltScene, labels: &Labels, sources: &SourceMap) -> Value {
        let writer = Writer { built, labels, sources };
        let channels = built.film.channels().into_iter().zip(self.channels.iter().map(|c| number(*c)));
        json!({
            "pixel": self.id.pixel,
            "sample": self.id.sample,
            "seed": built.seed,
            "camera": built.camera_name,
            "integrator": built.integrator_name,
            "transport": built.transport_name,
            "wavelengths_nm": numbers(self.lambda.lambda_nm),
            "wavelength_densities_per_nm": numbers(self.lambda.pdf),
            "filter_weight": number(self.weight.into()),
            "vertices": writer.vertices(&self.events),
            "radiance": spectrum(self.radiance),
            "finite": self.is_finite,
            "channels": channels.collect::<Map<_, _>>(),
        })
    }
}

impl Replayed {
    /// The JSON of [`Replayed::to_json`] with a line for each vertex of the path.
    pub fn to_text(&self, built: &BuiltScene, labels: &Labels, sources: &SourceMap) -> String {
        let mut lines = Vec::new();
        if let Value::Object(all) = self.to_json(built, labels, sources) {
            for (name, value) in &all {
                let value = match value.as_array() {
                    Some(vertices) if name == "vertices" && !vertices.is_empty() => {
                        let vertices: Vec<String> = vertices.iter().map(|v| format!("    {v}")).collect();
                        format!("[\n{}\n  ]", vertices.join(",\n"))
                    }
                    _ => value.to_string(),
                };
                lines.push(format!("  \"{name}\": {value}"));
            }
        }
        format!("{{\n{}\n}}\n", lines.join(",\n"))
    }
}

/// Writes what happened in a scene.
struct Writer<'a> {
    built: &'a BuiltScene,
    labels: &'a Labels,
    sources: &'a SourceMap,
}

impl Writer<'_> {
    fn to_world(&self, p: DVec3) -> Value {
        vector(p + self.built.scene.world.origin)
    }

    /// Every end of a ray, with what happened there.
    fn vertices(&self, events: &[PathEvent]) -> Vec<Value> {
        let mut vertices: Vec<Value> = Vec::new();
        for event in events {
            if let PathEvent::Traced { ray, end, throughput, lambda_nm } = event {
                let mut vertex = self.end(ray, end);
                vertex["wavelengths_far_away_nm"] = numbers(*lambda_nm);
                vertex["throughput"] = spectrum(*throughput);
                vertices.push(vertex);
                continue;
            }
            let Some(vertex) = vertices.last_mut() else { continue };
            match event {
                PathEvent::Traced { .. } => {}
                PathEvent::Found(light) => vertex["found"] = spectrum(*light),
                PathEvent::Sampled { light, place, radiance, visible } => {
                    let sampled = self.light(*light, *place, *radiance, *visible);
                    match vertex.get_mut("lights").and_then(Value::as_array_mut) {
                        Some(lights) => lights.push(sampled),
                        None => vertex["lights"] = json!([sampled]),
                    }
                }
                PathEvent::Scattered { direction, weight, pdf, specular } => {
                    vertex["scattered"] = json!({
                        "direction": vector(*direction),
                        "weight": spectrum(*weight),
                        "density_per_sr": number((*pdf).into()),
                        "specular": specular,
                    });
                }
                PathEvent::Ended(why) => vertex["ended"] = json!(why),
            }
        }
        vertices
    }

    /// Where a ray led.
    fn end(&self, ray: &Ray, end: &RayEnd) -> Value {
        let mut vertex = json!({
            "from": self.to_world(ray.origin),
            "departure": vector(ray.direction),
            "footprint": number(ray.footprint),
        });
        if end.swept != 0.0 {
            vertex["swept_angle"] = number(end.swept);
        }
        vertex["outcome"] = json!(match end.arrival {
            Arrival::Surface(_) => "hit",
            Arrival::Sky(..) => "escaped",
            Arrival::Captured => "captured",
            Arrival::OutOfSteps => "out of steps",
        });
        match end.arrival {
            Arrival::Surface(hit) => self.surface(&hit, &mut vertex),
            Arrival::Sky(direction, _) => vertex["direction"] = vector(direction),
            Arrival::Captured | Arrival::OutOfSteps => {}
        }
        vertex
    }

    fn surface(&self, hit: &SurfaceHit, vertex: &mut Value) {
        let scene = &self.built.scene;
        let surface = scene.world.surface(hit);
        let shape = scene.shapes[hit.geometry as usize].index;
        vertex["point"] = self.to_world(hit.point);
        vertex["direction"] = vector(hit.direction);
        vertex["normal"] = vector(surface.normal);
        vertex["shading_normal"] = vector(surface.shading_normal);
        vertex["uv"] = json!([number(surface.uv.x.into()), number(surface.uv.y.into())]);
        vertex["shape"] = json!(shape);
        vertex["triangle"] = json!(hit.primitive);
        vertex["surface"] = named(self.labels.shape(shape, self.sources));
    }

    /// A sample of a light.
    fn light(&self, number: u32, place: LightPlace, radiance: SampledSpectrum, visible: bool) -> Value {
        let scene = &self.built.scene;
        let label = match scene.light_sampler.emitters.get(number as usize) {
            Some(emitter) => self.labels.shape(scene.shapes[emitter.geometry as usize].index, self.sources),
            None => self.labels.light(number - scene.light_sampler.emitters.len() as u32, self.sources),
        };
        let mut object = json!({ "light": named(label), "radiance": spectrum(radiance), "visible": visible });
        match place {
            LightPlace::Point(p) => object["point"] = self.to_world(p),
            LightPlace::Sky(direction) => object["direction"] = vector(direction),
        }
        object
    }
}
