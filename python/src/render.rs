//! Pictures under way.

use crate::arguments::RenderOptions;
use crate::fault::Fault;
use crate::picture::Picture;
use crate::scene::{Made, Maker, Origin};
use bhs::denoise::{self, Denoiser};
use bhs::film::PixelNoise;
use bhs::finished::{self, Finished};
use bhs::lang::{BuiltScene, Overrides};
use bhs::memory::picture::check_shown;
use bhs::not_finite::{self, SampleId};
use bhs::progress::{Progress, ProgressForm, Reached};
use bhs::render::{JUDGED_FROM, Job, Limits, RenderState};
use bhs::signals::Signals;
use bhs::stats::Phases;
use bhs::{diagnosis, threads};
use bhs_core::diagnostics::Diagnostic;
use pyo3::prelude::*;
use std::sync::{Arc, OnceLock};

/// A picture under way, as the thread that renders it and the one that waits for it know it.
#[derive(Clone)]
pub struct Under {
    options: Arc<RenderOptions>,
    overrides: Overrides,
    maker: Maker,
    loaded: Arc<Made>,
    signals: Arc<Signals>,
    /// Once it is known how much there is to do.
    progress: Arc<OnceLock<Progress>>,
}

impl Under {
    /// One of a scene that has been loaded.
    pub fn new(maker: &Maker, loaded: &Arc<Made>, options: RenderOptions) -> Result<Self, Fault> {
        let overrides = options.overrides()?;
        options.limit()?;
        Ok(Self {
            options: Arc::new(options),
            overrides,
            maker: maker.clone(),
            loaded: Arc::clone(loaded),
            signals: Arc::default(),
            progress: Arc::default(),
        })
    }

    /// Has it stopped soon.
    pub fn stop(&self) {
        self.signals.interrupt();
    }

    /// Calls `progress` with how far it is: share, samples a pixel done and to be done, seconds gone and left, million rays a second.
    pub fn tell(&self, progress: &Bound<PyAny>) -> PyResult<()> {
        let Some(Reached { percent, spp: [done, total], elapsed, remaining, rate, .. }) =
            self.progress.get().map(Progress::reached)
        else {
            return Ok(());
        };
        progress.call1((percent / 100.0, done, total, elapsed, remaining, rate)).map(|_| ())
    }

    /// The scene as it is to be rendered: the one that was loaded, if nothing is changed.
    fn scene(&self) -> Result<Arc<Made>, Fault> {
        let states_camera =
            self.loaded.built.camera_statement().is_some_and(|c| self.loaded.built.statements.place(c.camera.at).is_some());
        let unchanged = Overrides { too_large: self.overrides.too_large, ..Overrides::default() };
        if states_camera && self.overrides == unchanged {
            return Ok(Arc::clone(&self.loaded));
        }
        let made = self.maker.make(self.overrides.clone())?;
        if made.built.hash != self.loaded.built.hash {
            return Err(Fault::new("the scene, or a file that it reads, has changed since it was loaded: load it again"));
        }
        Ok(Arc::new(made))
    }

    /// Renders it.
    pub fn render(&self) -> Result<Picture, Fault> {
        let options = &self.options;
        let mut phases = Phases::default();
        let denoiser =
            options.denoise.then(|| Denoiser::load(threads::count(options.threads))).transpose().map_err(anyhow::Error::from)?;
        let made = self.scene()?;
        let built = &made.built;
        let denoising = if options.denoise { denoise::bytes(pixels(built), channels(built)) } else { 0 };
        let is_adaptive = built.sampler.noise_target().is_some();
        let besides = denoising + if is_adaptive { pixels(built) * size_of::<PixelNoise>() as u64 } else { 0 };
        if let Some(Diagnostic { message, help, .. }) = check_shown(&*built.film, &built.layers, built.look.bloom, besides) {
            return Err(Fault::new([Some(message), help].into_iter().flatten().collect::<Vec<_>>().join("; ")));
        }
        phases.end("load");

        let pool = threads::start(options.threads)?;
        let most = built.sampler.samples_per_pixel();
        let limits = Limits {
            most,
            least: options.min_spp.unwrap_or(1).min(most),
            judged_from: options.min_spp.unwrap_or(JUDGED_FROM),
            time: options.limit()?,
        };
        let all = pixels(built) * u64::from(most);
        let progress = self.progress.get_or_init(|| Progress::new([all, 1], ProgressForm::None, [0, 1]));
        progress.picture(String::new(), 0, limits.time);
        let rendered = pool.install(|| {
            let state = RenderState::new(Job::of(built))?;
            let ended = state.run(&limits, progress, &self.signals);
            Ok::<_, anyhow::Error>(state.rendered(ended))
        })?;
        progress.picture_done(rendered.samples, true);
        phases.end("render");

        let mut finished = Finished::of(&rendered);
        if let Some(denoiser) = &denoiser {
            finished.denoise(denoiser).map_err(|why| Fault::new(format!("the picture cannot be denoised: {why}")))?;
            phases.end("denoise");
        }
        let program = match &self.maker.origin {
            Origin::File(path) => format!("bhs render {}", path.display()),
            Origin::Text(_) => "bhs render SCENE".to_owned(),
        };
        let replay = |SampleId { pixel: [x, y], sample }: &SampleId| format!("{program} --pixel {x},{y} --sample {sample}");
        let (count, first) = (rendered.counters.not_finite, &rendered.not_finite);
        let mut notes = made.of_picture.clone();
        notes.extend(not_finite::warnings(count, first, &rendered.frame, built.seed, replay));
        notes.extend(finished::notes(&rendered));
        notes.extend(diagnosis::after(built, &rendered).map(|said| said.to_string()));
        Ok(Picture::new(built, finished, notes, finished::stats_json(built, &rendered, &phases).to_string()))
    }
}

/// Pixels of the picture of a scene.
fn pixels(built: &BuiltScene) -> u64 {
    let [x0, x1, y0, y1] = built.film.crop().map(u64::from);
    (x1 - x0) * (y1 - y0)
}

/// Channels of its file.
fn channels(built: &BuiltScene) -> usize {
    built.film.channels().len() + built.layers.iter().map(|layer| layer.format.channels.len()).sum::<usize>()
}
