//! What the program's commands do.

use crate::cli::{BenchArgs, RenderArgs, SceneArgs, TraceArgs};
use crate::false_color::{self, FalseColor};
use crate::image::{self, Attribute, OutputFile, Picture};
use crate::lang::{self, BuiltScene, Overrides, SourceMap};
use crate::progress::Progress;
use crate::registry::Registry;
use crate::render::{Job, Rendered};
use crate::stats::{Phases, counters_to_json, peak_memory};
use crate::{plugins_table, report};
use anyhow::{Context, Result, bail};
use bhs_core::diagnostics::Diagnostic;
use serde_json::json;
use std::io::{BufReader, IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;
use std::sync::atomic::AtomicBool;

/// How the program ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum ExitStatus {
    /// Done.
    Done = 0,
    /// The scene or a file is at fault.
    Fault = 1,
    /// The command line is at fault.
    CommandLine = 2,
    /// Interrupted; what was rendered is written.
    Interrupted = 130,
}

impl From<ExitStatus> for ExitCode {
    fn from(status: ExitStatus) -> Self {
        ExitCode::from(status as u8)
    }
}

/// Whether somebody has closed the pipe that was written to, such as `head`: no fault of anybody's.
pub fn is_closed_pipe(error: &anyhow::Error) -> bool {
    error.chain().filter_map(|e| e.downcast_ref::<std::io::Error>()).any(|e| e.kind() == std::io::ErrorKind::BrokenPipe)
}

/// Loads a scene and says on standard error what is wrong with it. `None` if it cannot be built.
fn load(scene: &Path, overrides: &Overrides) -> Option<BuiltScene> {
    let mut sources = SourceMap::new();
    match lang::load(&scene.to_string_lossy(), &Registry::builtin(), overrides, &mut sources) {
        Ok(built) => {
            say(&built.warnings, &sources);
            Some(built)
        }
        Err(found) => {
            say(&found, &sources);
            None
        }
    }
}

fn say(found: &[Diagnostic], sources: &SourceMap) {
    if !found.is_empty() {
        eprint!("{}", report::render(found, sources, std::io::stderr().is_terminal()));
    }
}

fn overrides(args: &SceneArgs) -> Overrides {
    Overrides { integrator: args.integrator.clone(), seed: args.seed, ..Default::default() }
}

/// `bhs render`
///
/// # Errors
/// If a file cannot be written.
pub fn render(args: &RenderArgs, stop: &AtomicBool) -> Result<ExitStatus> {
    let mut phases = Phases::default();
    let overrides = Overrides {
        transport: args.transport.clone(),
        spp: args.spp,
        resolution: args.resolution,
        crop: args.crop,
        layers: args.aov.clone(),
        quick: args.quick,
        ..overrides(&args.scene_args)
    };
    let Some(built) = load(&args.scene, &overrides) else { return Ok(ExitStatus::Fault) };
    phases.end("load");

    // Whether the results can be kept is found out before they are made.
    let exr_path = args.output.clone().unwrap_or_else(|| built.film.filename().into());
    if exr_path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("exr")) {
        bail!("cannot write `{}`: the output's name ends in .exr (a .png is written beside it)", exr_path.display());
    }
    let exr = OutputFile::reserve(&exr_path)?;
    let png = OutputFile::reserve(&exr_path.with_extension("png"))?;
    let layers = built.film.layers();
    if args.false_color && layers.is_empty() {
        eprintln!("error: --false-color shows layers, and none is asked for; add `--aov NAME`");
        return Ok(ExitStatus::CommandLine);
    }
    let shown = if args.false_color { layers } else { &[] };
    let shown =
        shown.iter().map(|l| OutputFile::reserve(&false_color::path(&exr_path, *l))).collect::<Result<Vec<OutputFile>>>()?;
    let stats = args.stats.as_deref().map(OutputFile::reserve).transpose()?;

    let mut pool = rayon::ThreadPoolBuilder::new();
    if let Some(threads) = args.threads {
        pool = pool.num_threads(threads as usize);
    }
    let pool = pool.build().context("cannot start the threads")?;
    let job = Job::of(&built);
    let [x0, x1, y0, y1] = built.film.crop();
    let samples = u64::from(x1 - x0) * u64::from(y1 - y0) * u64::from(built.sampler.samples_per_pixel());
    let progress = Progress::new(samples, args.quiet);
    let rendered = pool.install(|| crate::render::render(&job, &progress, stop));
    progress.finish();
    phases.end("render");

    let (picture, layers) = (rendered.frame.picture(), rendered.frame.layers());
    let attributes = provenance(&built, &rendered, &phases);
    png.finish(|to| picture.write_png(to, |pixel| built.film.display(pixel)))?;
    for (file, layer) in shown.into_iter().zip(&layers) {
        let colors = FalseColor::new(layer);
        if !args.quiet {
            eprintln!("{} shows {colors}", file.path().display());
        }
        file.finish(|to| image::write_png(to, picture.size, colors.pixels().as_flattened()))?;
    }
    let picture = picture.with_layers(&layers);
    exr.finish(|to| picture.write_exr(to, &attributes))?;
    phases.end("write");

    if let Some(stats) = stats {
        let text = serde_json::to_string_pretty(&stats_json(&built, &rendered, &phases))?;
        stats.finish(|to| Ok(writeln!(to, "{text}")?))?;
    }
    if !args.quiet {
        closing_words(&exr_path, &rendered, &phases);
    }
    Ok(if rendered.interrupted { ExitStatus::Interrupted } else { ExitStatus::Done })
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
    let texts = texts.into_iter().map(|(n, v)| (n.to_owned(), Attribute::Text(v)));
    texts.chain(numbers).collect()
}

fn stats_json(built: &BuiltScene, rendered: &Rendered, phases: &Phases) -> serde_json::Value {
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "scene": built.hash,
        "seed": built.seed,
        "integrator": built.integrator_name,
        "transport": built.transport_name,
        "samples_per_pixel": rendered.samples,
        "interrupted": rendered.interrupted,
        "seconds": phases.to_json(),
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

/// `bhs check`
///
/// # Errors
/// None so far.
pub fn check(scene: &Path) -> Result<ExitStatus> {
    match load(scene, &Overrides::default()) {
        Some(_) => {
            eprintln!("{}: no errors", scene.display());
            Ok(ExitStatus::Done)
        }
        None => Ok(ExitStatus::Fault),
    }
}

/// `bhs plugins`
///
/// # Errors
/// If standard output is closed.
pub fn plugins(kind: Option<&str>, name: Option<&str>) -> Result<ExitStatus> {
    match plugins_table::render(&Registry::builtin(), kind, name) {
        Ok(text) => {
            std::io::stdout().write_all(text.as_bytes())?;
            Ok(ExitStatus::Done)
        }
        Err(unknown) => {
            eprintln!("error: {unknown}");
            Ok(ExitStatus::CommandLine)
        }
    }
}

/// `bhs trace`
///
/// # Errors
/// If the rays cannot be read.
pub fn trace(args: &TraceArgs) -> Result<ExitStatus> {
    // One of the two is given: the command line sees to it.
    let Some(input) = args.rays.as_ref().or(args.connect.as_ref()) else { return Ok(ExitStatus::CommandLine) };
    if input == Path::new("-") && args.scene == Path::new("-") {
        eprintln!(
            "error: the scene and its {} cannot both come from standard input",
            if args.rays.is_some() { "rays" } else { "pairs" }
        );
        return Ok(ExitStatus::CommandLine);
    }
    let overrides = Overrides { without_camera: true, ..overrides(&args.scene_args) };
    let Some(built) = load(&args.scene, &overrides) else { return Ok(ExitStatus::Fault) };
    let mut out = std::io::BufWriter::new(std::io::stdout().lock());
    let mut answer = |lines: &mut dyn std::io::BufRead| match args.connect {
        Some(_) => crate::trace::connect(&built.scene, lines, &mut out),
        None => crate::trace::trace(&built.scene, lines, args.path, &mut out),
    };
    if input == Path::new("-") {
        answer(&mut std::io::stdin().lock()).context("standard input")?;
    } else {
        let name = input.display();
        let file = std::fs::File::open(input).with_context(|| format!("cannot read `{name}`"))?;
        answer(&mut BufReader::new(file)).with_context(|| format!("`{name}`"))?;
    }
    Ok(ExitStatus::Done)
}

/// `bhs bench`
///
/// # Errors
/// If the scene cannot be measured or a file cannot be written.
pub fn bench(args: &BenchArgs) -> Result<ExitStatus> {
    if args.scene == Path::new("-") {
        // It is built many times.
        eprintln!("error: `bhs bench` needs a file");
        return Ok(ExitStatus::CommandLine);
    }
    // Integrators at the scene's own resolution, which sets what they need not tell apart.
    let Some(built) = load(&args.scene, &Overrides::default()) else { return Ok(ExitStatus::Fault) };
    if let Some(folder) = &args.output {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder `{}`", folder.display()))?;
    }
    let wanted = |what: &str| args.only.as_deref().is_none_or(|only| only == what);
    let mut measured = Vec::new();
    if wanted("integrators") {
        measured.extend(crate::bench::integrators::measure(&built, args.rays as usize, args.rounds));
    }
    if wanted("transports") {
        let quietly = |overrides: &Overrides| {
            let mut sources = SourceMap::new();
            lang::load(&args.scene.to_string_lossy(), &Registry::builtin(), overrides, &mut sources).ok()
        };
        let curved = built.scene.integrator.is_curved();
        measured.push(crate::bench::transports::measure(quietly, args.resolution, curved, args.rounds)?);
    }
    let mut out = std::io::stdout().lock();
    if args.json {
        let tables: serde_json::Map<_, _> = measured.iter().map(|m| (m.name.to_owned(), m.table.to_json())).collect();
        writeln!(out, "{}", serde_json::to_string_pretty(&json!({ "scene": built.hash, "tables": tables }))?)?;
    } else {
        for m in &measured {
            writeln!(out, "{}\n\n{}", m.chart.title, m.table.to_markdown())?;
        }
    }
    if let Some(folder) = &args.output {
        for m in &measured {
            for (ending, text) in [("csv", m.table.to_csv()), ("svg", m.chart.to_svg())] {
                let file = OutputFile::reserve(&folder.join(format!("{}.{ending}", m.name)))?;
                file.finish(|to| Ok(to.write_all(text.as_bytes())?))?;
            }
        }
    }
    Ok(ExitStatus::Done)
}

/// `bhs compare`
///
/// # Errors
/// If a file cannot be read, or the pictures cannot be compared.
pub fn compare(a: &Path, b: &Path, as_json: bool) -> Result<ExitStatus> {
    let comparison = crate::compare::compare(&Picture::read_exr(a)?, &Picture::read_exr(b)?)?;
    let mut out = std::io::stdout().lock();
    if as_json {
        writeln!(out, "{}", serde_json::to_string_pretty(&comparison.to_json())?)?;
    } else {
        write!(out, "{comparison}")?;
    }
    Ok(ExitStatus::Done)
}
