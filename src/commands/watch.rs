//! `bhs watch`: a picture that is rendered anew whenever what it is made of is saved.

mod picture;

use super::frames::read_keys;
use super::naming::{Naming, with_pngs};
use super::{Common, ExitStatus, diagnose, overrides, show};
use crate::animation::keys::Keys;
use crate::cli::WatchArgs;
use crate::display::Display;
use crate::files::Stamps;
use crate::lang::source::FileCache;
use crate::lang::{self, BuiltScene, Overrides, SourceMap, Variables};
use crate::memory::picture::{TooLarge, check};
use crate::output::{NamedBy, OutputFile, Plan, discard_all};
use crate::registry::Registry;
use crate::signals::Signals;
use crate::watch::Watched;
use crate::{say, threads};
use anyhow::Result;
use picture::Under;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Ending of the pictures.
const ENDING: &str = "watch.png";

/// What is watched.
struct Watch<'a> {
    args: &'a WatchArgs,
    common: &'a Common,
    registry: Registry,
    /// What has been made of files that have not changed.
    cache: Arc<FileCache>,
    pool: rayon::ThreadPool,
    display: Option<Display>,
}

/// `bhs watch`; returns only where it cannot begin, for a signal ends it.
///
/// # Errors
/// If there is no such scene, or no threads.
pub fn watch(args: &WatchArgs, common: &Common, signals: &Signals) -> Result<ExitStatus> {
    if args.scene == Path::new("-") {
        say!("error: `bhs watch` needs a file: standard input is never saved again");
        return Ok(ExitStatus::CommandLine);
    }
    // A name that is mistyped would be watched for good.
    common.open(&args.scene)?;
    let watch = Watch {
        args,
        common,
        registry: Registry::builtin(),
        cache: Arc::default(),
        pool: threads::start(args.picture.threads)?,
        display: args.show.display(args.quiet),
    };
    signals.end_at_once(discard_all);
    let mut watched = Watched::default();
    loop {
        let (loaded, files) = watch.load();
        watch.cache.forget_unused();
        watched.follow(files);
        let changed = match loaded {
            Some((built, file)) => watch.draw(&built, &file, &watched),
            None => {
                watch.say(&format!("waits until one of {} files is saved", watched.len()));
                watched.wait()
            }
        };
        watch.say(&format!("`{}` has changed: the picture is rendered anew", changed.display()));
        watched.settle();
    }
}

impl Watch<'_> {
    /// Says something that is no fault.
    fn say(&self, what: &str) {
        if !self.args.quiet {
            say!("{what}");
        }
    }

    /// The scene and the file of its picture, or nothing if something is wrong with it, which is said; and all files that it reads.
    fn load(&self) -> (Option<(BuiltScene, OutputFile)>, Stamps) {
        let args = self.args;
        let mut sources = self.common.sources().keeping(&self.cache);
        let keys = args.keys.as_ref().map_or(Ok(Ok(Keys::default())), |path| {
            sources.add_input(path, "the file of keys");
            read_keys(path, self.common)
        });
        let keys = match keys {
            Ok(Ok(keys)) => keys,
            Ok(Err((found, of_keys))) => {
                show(&found, &of_keys, self.common.color);
                return (None, sources.stamps());
            }
            Err(error) => {
                say!("error: {error:#}");
                return (None, sources.stamps());
            }
        };
        let mut built = match lang::load(&args.scene, &self.registry, &self.overrides(&keys), &mut sources) {
            Ok(built) => built,
            Err(found) => {
                show(&found, &sources, self.common.color);
                return (None, sources.stamps());
            }
        };
        show(&built.warnings, &sources, self.common.color);
        diagnose(&mut built, &sources, self.common);
        let too_large: Vec<_> = check(&*built.film, &built.layers).into_iter().collect();
        show(&too_large, &sources, self.common.color);
        let file = if too_large.is_empty() { self.claim(&built, &sources) } else { None };
        (file.map(|file| (built, file)), sources.stamps())
    }

    fn overrides(&self, keys: &Keys) -> Overrides {
        let args = self.args;
        let general = overrides(&args.scene_args, &args.picture);
        let variables = Variables {
            keys: args.frame.map_or_else(Vec::new, |frame| keys.at(f64::from(frame))),
            frame: args.frame,
            frames_per_second: args.fps,
            ..general.variables
        };
        Overrides {
            variables,
            camera: args.camera.clone(),
            layers: args.aov.clone(),
            quick: args.quick,
            look: args.tone.changes(),
            too_large: TooLarge::Refuse,
            ..general
        }
    }

    /// The file of the picture, which is none that the scene reads or writes.
    fn claim(&self, built: &BuiltScene, sources: &SourceMap) -> Option<OutputFile> {
        let naming = Naming::without_flags(&self.args.scene);
        let (exr, by) = naming.exr(built);
        let (path, by) = match &self.args.output {
            Some(path) => (path.clone(), NamedBy::CommandLine),
            None => (exr.with_extension(ENDING), by),
        };
        let mut plan = Plan::new(sources);
        // What `render` writes is left as it is, by whatever name it is called.
        let layers = || built.layers.iter().map(|layer| layer.name);
        for own in built.camera_names().flat_map(|camera| with_pngs(naming.exr_of(built, camera).0, layers())) {
            plan.leave_to("`bhs render`", &own);
        }
        let file = plan.claim(&path, by);
        if let Err(found) = plan.finish() {
            show(&found, sources, self.common.color);
        }
        file
    }

    /// Renders until a file changes; which.
    fn draw(&self, built: &BuiltScene, file: &OutputFile, watched: &Watched) -> PathBuf {
        let under = Under { watch: self, built, file };
        let stop = Signals::default();
        let drawing = std::thread::scope(|scope| {
            let drawing = scope.spawn(|| under.draw(&stop));
            watched.wait_while(|| !drawing.is_finished()).inspect(|_| stop.interrupt())
        });
        drawing.unwrap_or_else(|| watched.wait())
    }
}
