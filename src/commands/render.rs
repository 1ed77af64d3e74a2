//! `bhs render`: a picture for each camera.

use super::frames::{self, Film};
use super::naming::Naming;
use super::outputs::Outputs;
use super::part;
use super::picture::{Session, samples};
use super::several::Earlier;
use super::{Common, ExitStatus, diagnose, load, overrides, replay, several, show};
use crate::cli::RenderArgs;
use crate::denoise::{self, Denoiser};
use crate::diagnosis::BlackFrames;
use crate::display::Display;
use crate::film::PixelNoise;
use crate::finished::{find_layer, notes};
use crate::lang::{BuiltScene, Overrides, SourceMap};
use crate::memory;
use crate::memory::picture::TooLarge;
use crate::not_finite::SampleId;
use crate::output::{self, Plan, Rescue};
use crate::parts::Windowed;
use crate::progress::{Progress, ProgressForm};
use crate::render::{Ended, Rendered};
use crate::signals::Signals;
use crate::stats::Phases;
use crate::{say, threads};
use anyhow::Result;
use bhs_core::camera;
use serde_json::json;
use std::path::Path;
use std::sync::Arc;

/// What programs are told of a render that begins.
pub fn start(scenes: &[impl AsRef<Path>]) -> serde_json::Value {
    let scenes: Vec<_> = scenes.iter().map(|scene| scene.as_ref().to_string_lossy()).collect();
    json!({ "program": "bhs", "version": env!("CARGO_PKG_VERSION"), "scenes": scenes })
}

/// `bhs render`
///
/// # Errors
/// If a file cannot be written.
pub fn render(args: &RenderArgs, common: &Common, signals: &Signals) -> Result<ExitStatus> {
    let display = args.show.display(args.quiet);
    let mut each = args.each();
    match (each.next(), each.next()) {
        (Some(one), None) => render_one(&one, common, signals, (display.as_ref(), &Earlier::default())),
        _ => several::render(args, common, signals, display.as_ref()),
    }
}

/// Renders one scene.
///
/// # Errors
/// If a file cannot be written.
pub(super) fn render_one(
    args: &RenderArgs,
    common: &Common,
    signals: &Signals,
    (display, earlier): (Option<&Display>, &Earlier),
) -> Result<ExitStatus> {
    let mut phases = Phases::default();
    let overrides = Overrides {
        camera: args.camera.clone(),
        // That of a part is a window of the picture, which stays whole.
        crop: args.picture.crop.filter(|_| !args.parts.is_given()),
        layers: layers(args),
        look: args.look.changes(),
        // Parts know nothing of the noise of the whole.
        noise: args.noise.filter(|_| !args.parts.is_given()),
        noise_over: args.noise_over.filter(|_| !args.parts.is_given()),
        quick: args.quick,
        ..overrides(&args.scene_args, &args.picture)
    };
    if let (Some(pixel), Some(sample)) = (args.pixel, args.sample) {
        return replay::replay(args, &overrides, SampleId { pixel, sample }, common);
    }
    if let Some(why) = part::unfit(args) {
        say!("error: {why}");
        return Ok(ExitStatus::CommandLine);
    }
    if args.parts.is_given() && args.noise.is_some() {
        say!("note: --noise is for whole pictures: all pixels of a part have as many samples as `pixelsamples` or --spp says");
    }
    let too_large = if args.parts.is_given() { TooLarge::Ignore } else { TooLarge::Refuse };
    let overrides = Overrides { too_large, ..overrides };
    // Whether the noise can be taken out in the end is found out first.
    let denoiser = if args.denoise { Some(Denoiser::load(threads::count(args.picture.threads))?) } else { None };
    let denoiser = denoiser.as_ref();
    if let Some(range) = args.frames.range {
        return frames::render(&Film {
            args,
            range,
            overrides,
            common,
            signals,
            denoiser,
            cache: Arc::default(),
            display,
            earlier,
            black: BlackFrames::new(range.numbers().count()),
        });
    }
    let Some((mut built, sources)) = load(&args.scene, &overrides, common) else { return Ok(ExitStatus::Fault) };
    diagnose(&mut built, &sources, common);
    phases.end("load");
    if let Some(status) = refuse(args, &built, &sources, common) {
        return Ok(status);
    }

    // From here on there may be something to write when a signal comes.
    signals.stop_gracefully(output::discard_all);
    // Whether the results can be kept is found out before they are made.
    let mut plan = Plan::new(&sources);
    earlier.leave(&mut plan);
    let outputs = Outputs::plan(&Naming::of(args), &built, &mut plan);
    earlier.note(&args.scene, &plan);
    if let Err(found) = plan.finish() {
        show(&found, &sources, common.color);
        return Ok(ExitStatus::Fault);
    }
    outputs.iter().try_for_each(Outputs::probe)?;
    // The texts of a scene may be large.
    drop(sources);

    let pool = threads::start(args.picture.threads)?;
    let rescue = Rescue::beside(&args.scene, common.root.as_ref());
    let a_picture = samples(&built, part::cover(args, &built).map_err(anyhow::Error::msg)?);
    let pictures = outputs.len() as u64;
    let progress = Progress::new([a_picture, pictures], ProgressForm::choose(args.show.progress, args.quiet), args.of_scenes);
    let session = Session {
        args,
        common,
        signals,
        pool: &pool,
        rescue,
        denoiser,
        progress: &progress,
        is_film: false,
        display,
        black_frames: None,
    };
    let mut status = ExitStatus::Done;
    for (number, outputs) in (0..).zip(outputs) {
        let camera = built.camera_name.as_deref().filter(|_| pictures > 1);
        progress.picture(camera.map_or(String::new(), |name| format!("{name}, ")), number * a_picture, args.time);
        let (ended, in_place) = session.render(&built, outputs, &mut phases)?;
        if !in_place {
            // The other pictures may be of use all the same.
            status = ExitStatus::Fault;
        }
        if let Ended::Stopped(signal) = ended {
            return Ok(part::stopped(args, status, signal));
        }
        // Loading counts as the first picture's.
        phases = Phases::default();
        built.next_camera();
    }
    Ok(status)
}

/// Says why a scene that has been loaded is not rendered, if it is not.
pub(super) fn refuse(args: &RenderArgs, built: &BuiltScene, sources: &SourceMap, common: &Common) -> Option<ExitStatus> {
    let part = match part::cover(args, built) {
        Ok(part) => part,
        Err(why) => {
            say!("error: {why}");
            return Some(ExitStatus::Fault);
        }
    };
    let windowed = part.map(|cover| Windowed::new(&*built.film, cover.window));
    let film: &dyn camera::Film = windowed.as_ref().map_or(&*built.film, |windowed| windowed);
    // Meshes and skies have their memory now.
    let channels = film.channels().len() + built.layers.iter().map(|l| l.format.channels.len()).sum::<usize>();
    let [x0, x1, y0, y1] = film.crop().map(u64::from);
    let pixels = (x1 - x0) * (y1 - y0);
    let denoising = if args.denoise { denoise::bytes(pixels, channels) } else { 0 };
    let is_adaptive = part.is_none() && built.sampler.noise_target().is_some();
    let besides = denoising + if is_adaptive { pixels * size_of::<PixelNoise>() as u64 } else { 0 };
    if let Some(found) = memory::picture::check_shown(film, &built.layers, built.look.bloom, besides) {
        show(&[found], sources, common.color);
        return Some(ExitStatus::Fault);
    }
    if args.look.false_color && args.look.layer.is_none() && built.layers.is_empty() {
        say!("error: --false-color shows layers, and none is asked for; add `--aov NAME`");
        return Some(ExitStatus::CommandLine);
    }
    if let Some(name) = &args.look.layer
        && let Err(why) = find_layer(built, args.denoise, name)
    {
        say!("error: --layer: {why}");
        return Some(ExitStatus::CommandLine);
    }
    None
}

/// The layers that are asked for, and the one that is shown.
pub(super) fn layers(args: &RenderArgs) -> Vec<String> {
    let shown = args.look.layer.iter().filter(|name| bhs_engine::layer::find(name, bhs_layers::ALL).is_ok());
    let guides = denoise::LAYERS.iter().filter(|_| args.denoise).map(|name| (*name).to_owned());
    args.aov.iter().chain(shown).cloned().chain(guides).collect()
}

pub(super) fn closing_words(path: &Path, rendered: &Rendered, phases: &Phases) {
    let (c, seconds) = (&rendered.counters, rendered.seconds);
    let rays = c.geodesics as f64 / seconds.max(1e-9) / 1e6;
    let queries = c.queries as f64 / c.geodesics.max(1) as f64;
    let spp = rendered.spp();
    let state = match rendered.ended {
        Ended::Stopped(_) => "interrupted; ",
        Ended::TimeOver => "time is over; ",
        Ended::Complete | Ended::Underway => "",
    };
    say!(
        "{state}{} and .png: {spp} spp in {seconds:.1} s ({rays:.2} Mray/s, {queries:.1} queries a ray), {:.1} s in all",
        path.display(),
        phases.total()
    );
    notes(rendered).iter().for_each(|note| say!("{note}"));
}
