//! `bhs render`: a picture for each camera.

use super::{ExitStatus, load, overrides};
use crate::cli::RenderArgs;
use crate::false_color::{self, FalseColor};
use crate::image::{self, Attribute, OutputFile};
use crate::lang::{BuiltScene, Overrides};
use crate::progress::Progress;
use crate::render::{Job, Rendered};
use crate::stats::{Phases, counters_to_json, peak_memory};
use anyhow::{Context, Result, bail};
use serde_json::json;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;

/// `bhs render`
///
/// # Errors
/// If a file cannot be written.
pub fn render(args: &RenderArgs, color: bool, stop: &AtomicBool) -> Result<ExitStatus> {
    let mut phases = Phases::default();
    let overrides = Overrides {
        transport: args.transport.clone(),
        camera: args.camera.clone(),
        spp: args.spp,
        resolution: args.resolution,
        crop: args.crop,
        layers: args.aov.clone(),
        quick: args.quick,
        ..overrides(&args.scene_args)
    };
    let Some(mut built) = load(&args.scene, &overrides, color) else { return Ok(ExitStatus::Fault) };
    phases.end("load");
    if args.false_color && built.film.layers().is_empty() {
        eprintln!("error: --false-color shows layers, and none is asked for; add `--aov NAME`");
        return Ok(ExitStatus::CommandLine);
    }

    // Whether the results can be kept is found out before they are made.
    let outputs = built.camera_names().map(|camera| Outputs::reserve(args, &built, camera)).collect::<Result<Vec<_>>>()?;

    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(threads) = args.threads {
        pool = pool.num_threads(threads as usize);
    }
    let pool = pool.build().context("cannot start the threads")?;
    for outputs in outputs {
        let [x0, x1, y0, y1] = built.film.crop();
        let samples = u64::from(x1 - x0) * u64::from(y1 - y0) * u64::from(built.sampler.samples_per_pixel());
        let progress = Progress::new(samples, args.quiet);
        let rendered = pool.install(|| crate::render::render(&Job::of(&built), &progress, stop));
        progress.finish();
        phases.end("render");
        outputs.write(&built, &rendered, &mut phases, args.quiet)?;
        if rendered.interrupted {
            return Ok(ExitStatus::Interrupted);
        }
        // Loading counts as the first picture's.
        phases = Phases::default();
        built.next_camera();
    }
    Ok(ExitStatus::Done)
}

/// The files of one picture.
struct Outputs {
    exr: OutputFile,
    png: OutputFile,
    /// A false-colour picture for each layer, if they are asked for.
    shown: Vec<OutputFile>,
    stats: Option<OutputFile>,
}

impl Outputs {
    /// Makes sure that the files of the given camera can be written.
    fn reserve(args: &RenderArgs, built: &BuiltScene, camera: Option<&str>) -> Result<Self> {
        let one = built.camera_names().count() == 1;
        // The only picture is called what the command line says.
        let exr_path = match &args.output {
            Some(path) if one => path.clone(),
            Some(path) => named(path, camera),
            None => named(Path::new(built.film.filename()), camera),
        };
        if exr_path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("exr")) {
            bail!("cannot write `{}`: the output's name ends in .exr (a .png is written beside it)", exr_path.display());
        }
        let exr = OutputFile::reserve(&exr_path)?;
        let png = OutputFile::reserve(&exr_path.with_extension("png"))?;
        let layers = if args.false_color { built.film.layers() } else { &[] };
        let shown = layers.iter().map(|l| OutputFile::reserve(&false_color::path(&exr_path, *l))).collect::<Result<_>>()?;
        let stats = args.stats.as_ref().map(|path| if one { path.clone() } else { named(path, camera) });
        let stats = stats.as_deref().map(OutputFile::reserve).transpose()?;
        Ok(Self { exr, png, shown, stats })
    }

    /// Writes all of them.
    fn write(self, built: &BuiltScene, rendered: &Rendered, phases: &mut Phases, quiet: bool) -> Result<()> {
        let exr_path = self.exr.path().to_owned();
        let (picture, layers) = (rendered.frame.picture(), rendered.frame.layers());
        let attributes = provenance(built, rendered, phases);
        self.png.finish(|to| picture.write_png(to, |pixel| built.film.display(pixel)))?;
        for (file, layer) in self.shown.into_iter().zip(&layers) {
            let colors = FalseColor::new(layer);
            if !quiet {
                eprintln!("{} shows {colors}", file.path().display());
            }
            file.finish(|to| image::write_png(to, picture.size, colors.pixels().as_flattened()))?;
        }
        let picture = picture.with_layers(&layers);
        self.exr.finish(|to| picture.write_exr(to, &attributes))?;
        phases.end("write");
        if let Some(stats) = self.stats {
            let text = serde_json::to_string_pretty(&stats_json(built, rendered, phases))?;
            stats.finish(|to| Ok(writeln!(to, "{text}")?))?;
        }
        if !quiet {
            closing_words(&exr_path, rendered, phases);
        }
        Ok(())
    }
}

/// `path` with the camera's name before its ending, if it has one.
fn named(path: &Path, camera: Option<&str>) -> PathBuf {
    let Some(camera) = camera else { return path.to_owned() };
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().map(|e| format!(".{}", e.to_string_lossy())).unwrap_or_default();
    path.with_file_name(format!("{stem}.{camera}{ending}"))
}

/// What the EXR header says of the picture's making.
fn provenance(built: &BuiltScene, rendered: &Rendered, phases: &Phases) -> Vec<(String, Attribute)> {
    let c = &rendered.counters;
    let queries = c.queries as f64 / c.geodesics.max(1) as f64;
    let numbers = [
        ("bhs:spp", f64::from(rendered.samples)),
        ("bhs:seconds", phases.seconds("render")),
        ("bhs:queriesPerGeodesic", queries),
    ];
    let texts = [
        ("bhs:version", env!("CARGO_PKG_VERSION").to_owned()),
        ("bhs:scene", built.hash.clone()),
        ("bhs:seed", built.seed.to_string()),
        ("bhs:integrator", built.integrator_name.clone()),
        ("bhs:transport", built.transport_name.clone()),
    ];
    let numbers = numbers.into_iter().map(|(n, v)| (n.to_owned(), Attribute::Number(v)));
    let camera = built.camera_name.iter().map(|name| ("bhs:camera", name.clone()));
    let texts = texts.into_iter().chain(camera).map(|(n, v)| (n.to_owned(), Attribute::Text(v)));
    texts.chain(numbers).collect()
}

fn stats_json(built: &BuiltScene, rendered: &Rendered, phases: &Phases) -> serde_json::Value {
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "scene": built.hash,
        "seed": built.seed,
        "integrator": built.integrator_name,
        "transport": built.transport_name,
        "camera": built.camera_name,
        "samples_per_pixel": rendered.samples,
        "interrupted": rendered.interrupted,
        "seconds": phases.to_json(),
        "processor_seconds": phases.processor_to_json(),
        "peak_memory_bytes": peak_memory(),
        "instances": built.load.instances,
        "triangles": built.load.triangles,
        "zero_area_triangles_dropped": built.load.zero_area_triangles,
        "counts": counters_to_json(&rendered.counters),
    })
}

fn closing_words(path: &Path, rendered: &Rendered, phases: &Phases) {
    let (c, seconds) = (&rendered.counters, phases.seconds("render"));
    let rays = c.geodesics as f64 / seconds.max(1e-9) / 1e6;
    let queries = c.queries as f64 / c.geodesics.max(1) as f64;
    let state = if rendered.interrupted { "interrupted; " } else { "" };
    eprintln!(
        "{state}{} and .png: {} spp in {seconds:.1} s ({rays:.2} Mray/s, {queries:.1} queries a ray), {:.1} s in all",
        path.display(),
        rendered.samples,
        phases.total()
    );
    if c.not_finite > 0 {
        eprintln!(
            "warning: {} samples were not finite and were left out; this is a fault of bhs, please report it",
            c.not_finite
        );
    }
    if c.out_of_steps > 0 {
        eprintln!("warning: {} rays ran out of steps and count as black; raise the integrator's `maxsteps`", c.out_of_steps);
    }
}
