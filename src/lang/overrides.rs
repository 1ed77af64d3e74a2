//! What the command line says over the scene's head.
//!
//! Flags become text of their own in the source map, so that what is wrong with them is reported like what is wrong with a
//! scene, with the flag underlined.

use crate::lang::defaults::Defaults;
use crate::lang::description::{CameraEntity, Entity, SceneDescription};
use crate::lang::seed;
use crate::lang::source::SourceMap;
use crate::lang::variables::{Origin, Unread, Variables};
use crate::look::LookChanges;
use crate::memory::picture::TooLarge;
use crate::registry::{Kind, Registry};
use bhs_core::diagnostics::{Diagnostic, Span, Spanned, did_you_mean};
use bhs_core::sampling::NoiseOver;
use bhs_core::spacetime::Side;
use bhs_core::value::{Param, ParamType, Values};
use bhs_engine::integrator::IntegratorBuilder;
use bhs_engine::transport::LightTransport;
use std::sync::Arc;

/// Longer side of a picture rendered with `--quick`, at most (pixels).
pub const QUICK_SIDE: u32 = 256;
/// Samples a pixel with `--quick`, at most.
pub const QUICK_SAMPLES: u32 = 16;

/// Changes to a scene before it is built.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Overrides {
    /// Name of the integrator of light rays. Parameters of the scene's own one are kept where this one has them too.
    pub integrator: Option<String>,
    /// Name of the light transport; parameters likewise.
    pub transport: Option<String>,
    /// Name of the one camera to look through, if not all.
    pub camera: Option<String>,
    /// Name of the intersector.
    pub intersector: Option<String>,
    /// Samples a pixel.
    pub spp: Option<u32>,
    /// The noise with which a pixel has samples enough; how many the scene asks for does not count then.
    pub noise: Option<f64>,
    /// What has so little noise.
    pub noise_over: Option<NoiseOver>,
    /// Switches of the light transport, by the names of their parameters, as far as it has these.
    pub switches: Vec<(&'static str, bool)>,
    /// Seed.
    pub seed: Option<u64>,
    /// Width and height (pixels).
    pub resolution: Option<[u32; 2]>,
    /// x0, x1, y0, y1 of the part to render, as fractions of width and height.
    pub crop: Option<[f64; 4]>,
    /// Names of layers that the film records besides those of the scene.
    pub layers: Vec<String>,
    /// How the picture is shown.
    pub look: LookChanges,
    /// File to write.
    pub output: Option<String>,
    /// A preview: the picture reduced, keeping its shape, to at most [`QUICK_SIDE`] pixels on its longer side, and to at most
    /// [`QUICK_SAMPLES`] samples a pixel. `spp` and `resolution` win over it.
    pub quick: bool,
    /// Numbers for the scene's variables.
    pub variables: Variables,
    /// Whether the camera does not matter, so that it may stand anywhere.
    pub without_camera: bool,
    /// Whether a scene that states no camera is none to be refused for where the camera then would stand: its rays may be all that is asked for.
    pub may_lack_camera: bool,
    /// What is done about a picture that is too large for the memory that there is.
    pub too_large: TooLarge,
}

/// A text that stands for the command line, while it is written.
struct Flags {
    text: String,
    file: u16,
}

impl Flags {
    /// The next text of `sources` will be this one.
    fn new(sources: &SourceMap) -> Self {
        Self { text: String::new(), file: sources.iter().count().min(usize::from(u16::MAX)) as u16 }
    }

    /// Adds a word; the place of it.
    fn word(&mut self, word: &str) -> Span {
        if !self.text.is_empty() {
            self.text.push(' ');
        }
        let start = self.text.len() as u32;
        self.text.push_str(word);
        Span { file: self.file, start, end: self.text.len() as u32 }
    }

    /// Adds the flag and its value; the place of the value.
    fn flag(&mut self, flag: &str, value: &str) -> Span {
        self.word(flag);
        self.word(value)
    }

    /// Puts the text into the source map.
    fn finish(self, sources: &mut SourceMap, name: &str) {
        sources.add(name, &self.text);
    }
}

/// A parameter that the scene does not state itself.
fn parameter(ty: ParamType, name: &str, values: Values, span: Span) -> Param {
    Param { ty: Spanned::new(ty, span), name: Spanned::new(name.to_owned(), span), values, span }
}

/// Puts a parameter in place of one of the same name.
fn set(params: &mut Vec<Param>, param: Param) {
    params.retain(|p| p.name.value != param.name.value);
    params.push(param);
}

/// Sets an integer parameter.
pub(crate) fn set_integer(params: &mut Vec<Param>, name: &str, value: u32, span: Span) {
    let values = Values::Numbers { values: vec![f64::from(value)], whole: true };
    set(params, parameter(ParamType::Integer, name, values, span));
}

/// Adds a text to a list of texts, unless it is in there already. A list that is at fault stays as it is, to be reported.
fn add_string(params: &mut Vec<Param>, name: &str, value: &str, span: Span) {
    let added = Spanned::new(value.to_owned(), span);
    match params.iter_mut().find(|p| p.name.value == name).map(|p| &mut p.values) {
        None => params.push(parameter(ParamType::String, name, Values::Strings(vec![added]), span)),
        Some(Values::Strings(list)) if list.iter().all(|s| s.value != value) => list.push(added),
        Some(_) => {}
    }
}

/// An entity that the scene does not state itself.
fn entity(name: &str, span: Span) -> Entity {
    Entity {
        name: Spanned::new(name.to_owned(), span),
        params: Vec::new(),
        defaults: Defaults::default(),
        span,
        keyword: span,
        faulty: false,
        world_from_object: Arc::default(),
        side: Side::Near,
    }
}

/// The entities of a scene's options, with what the command line changes and defaults for what is not there.
pub(crate) struct Settings {
    pub integrator: Entity,
    pub transport: Entity,
    /// At least one.
    pub cameras: Vec<CameraEntity>,
    pub film: Entity,
    pub sampler: Entity,
    pub filter: Entity,
    pub options: Vec<Param>,
    /// For shapes without a material.
    pub material: Entity,
    /// Place of `--quick`.
    pub quick: Span,
}

impl Settings {
    /// Takes the options of a scene and joins them with the command line's and the defaults.
    pub fn take(
        scene: &mut SceneDescription,
        overrides: &Overrides,
        registry: &Registry,
        sources: &mut SourceMap,
        found: &mut Vec<Diagnostic>,
    ) -> Self {
        let mut flags = Flags::new(sources);
        let unread = std::mem::take(&mut scene.variables.unread);
        found.extend(unread.iter().map(|unread| overrides.unread_variable(unread, &mut flags)));
        found.extend(overrides.choose_camera(&mut scene.cameras, &mut flags));
        overrides.replace_plugins(scene, registry, &mut flags);
        let quick = if overrides.quick { flags.word("--quick") } else { Span::default() };
        // Defaults come after the flags in the text, but flags may add to them.
        let mut defaults = Flags { text: String::new(), file: flags.file.saturating_add(1) };
        let mut or_default = |slot: Option<Entity>, keyword: &str, name: &str| {
            slot.unwrap_or_else(|| entity(name, defaults.flag(keyword, &format!("\"{name}\""))))
        };
        let bent = if scene.spacetime.is_some() { "adaptive" } else { "straight" };
        let mut settings = Self {
            integrator: or_default(scene.integrator.take(), "Integrator", bent),
            transport: or_default(scene.transport.take(), "LightTransport", "path"),
            cameras: match std::mem::take(&mut scene.cameras) {
                none if none.is_empty() => {
                    vec![CameraEntity { entity: or_default(None, "Camera", "perspective"), name: None, look_at: None }]
                }
                some => some,
            },
            film: or_default(scene.film.take(), "Film", "rgb"),
            sampler: or_default(scene.sampler.take(), "Sampler", "sobol"),
            filter: or_default(scene.filter.take(), "PixelFilter", "box"),
            options: std::mem::take(&mut scene.options),
            material: or_default(None, "Material", "diffuse"),
            quick,
        };
        overrides.change_parameters(&mut settings, &mut flags);
        overrides.set_switches(&mut settings.transport, registry);
        flags.finish(sources, "<command line>");
        defaults.finish(sources, "<defaults>");
        settings
    }
}

impl Overrides {
    /// Leaves the camera that is asked for; an error if there is none of that name.
    fn choose_camera(&self, cameras: &mut Vec<CameraEntity>, flags: &mut Flags) -> Option<Diagnostic> {
        let wanted = self.camera.as_ref()?;
        let span = flags.flag("--camera", wanted);
        let is_named = |c: &CameraEntity| c.name.as_ref().is_some_and(|n| n.value == *wanted);
        if cameras.iter().any(is_named) {
            cameras.retain(is_named);
            return None;
        }
        let names: Vec<&str> = cameras.iter().filter_map(|c| Some(c.name.as_ref()?.value.as_str())).collect();
        let help = match did_you_mean(wanted, names.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None if names.is_empty() => "no camera of the scene has a name; \"string name\" gives it one".to_owned(),
            None => format!("there is {}", names.join(", ")),
        };
        Some(Diagnostic::error("unknown-camera", format!("the scene has no camera `{wanted}`")).at(span, "").help(help))
    }

    /// What is said of a variable that nothing reads. Who types one wants it to do something; a file of keys may serve several scenes.
    fn unread_variable(&self, unread: &Unread, flags: &mut Flags) -> Diagnostic {
        let Unread { name, origin, near } = unread;
        let found = match origin {
            Origin::Keys => {
                let message = format!("the column `{name}` of the keys moves nothing: the scene has no `${name}`");
                Diagnostic::warning("unused-variable", message)
            }
            Origin::CommandLine | Origin::Frame => {
                let value = self.variables.find(name).map_or(0.0, |(value, _)| value);
                let span = flags.flag("-D", &format!("{name}={value}"));
                Diagnostic::error("unused-variable", format!("nothing in the scene reads `${name}`")).at(span, "changes nothing")
            }
        };
        found.maybe_help(near.as_ref().map(|near| format!("did you mean `{near}`?")))
    }

    fn replace_plugins(&self, scene: &mut SceneDescription, registry: &Registry, flags: &mut Flags) {
        if let Some(name) = &self.integrator {
            replace::<dyn IntegratorBuilder>(&mut scene.integrator, name, flags.flag("--integrator", name), registry);
        }
        if let Some(name) = &self.transport {
            replace::<dyn LightTransport>(&mut scene.transport, name, flags.flag("--transport", name), registry);
        }
        if let Some(name) = &self.intersector {
            let span = flags.flag("--intersector", name);
            let values = Values::Strings(vec![Spanned::new(name.clone(), span)]);
            set(&mut scene.options, parameter(ParamType::String, "intersector", values, span));
        }
    }

    fn change_parameters(&self, to: &mut Settings, flags: &mut Flags) {
        let film = &mut to.film.params;
        if let Some([x, y]) = self.resolution {
            let span = flags.flag("--resolution", &format!("{x}x{y}"));
            set_integer(film, "xresolution", x, span);
            set_integer(film, "yresolution", y, span);
        }
        if let Some(crop) = self.crop {
            let span = flags.flag("--crop", &crop.map(|f| f.to_string()).join(","));
            let values = Values::Numbers { values: crop.to_vec(), whole: false };
            set(film, parameter(ParamType::Float, "cropwindow", values, span));
        }
        for layer in &self.layers {
            let span = flags.flag("--aov", layer);
            add_string(film, "layers", layer, span);
        }
        if let Some(path) = &self.output {
            let span = flags.flag("-o", path);
            let values = Values::Strings(vec![Spanned::new(path.clone(), span)]);
            set(film, parameter(ParamType::String, "filename", values, span));
        }
        if let Some(noise) = self.noise {
            let span = flags.flag("--noise", &noise.to_string());
            let params = &mut to.sampler.params;
            params.retain(|p| p.name.value != "pixelsamples");
            set(params, parameter(ParamType::Float, "noise", Values::Numbers { values: vec![noise], whole: false }, span));
        }
        if let Some(over) = self.noise_over {
            let span = flags.flag("--noise-over", over.name());
            let values = Values::Strings(vec![Spanned::new(over.name().to_owned(), span)]);
            set(&mut to.sampler.params, parameter(ParamType::String, "noiseover", values, span));
        }
        if let Some(spp) = self.spp {
            let span = flags.flag("--spp", &spp.to_string());
            set_integer(&mut to.sampler.params, "pixelsamples", spp, span);
        }
    }

    /// Sets what only programs switch: nothing on the command line stands for it.
    fn set_switches(&self, transport: &mut Entity, registry: &Registry) {
        let known = registry.parameters::<dyn LightTransport>(&transport.name.value);
        for (name, is_on) in self.switches.iter().filter(|(name, _)| known.iter().any(|k| k.name == *name)) {
            set(&mut transport.params, parameter(ParamType::Bool, name, Values::Bools(vec![*is_on]), transport.span));
        }
    }

    /// The seed of the samples of a picture, where the scene has the seed `scene`: each frame of several has its own.
    pub(crate) fn seed_of_samples(&self, scene: u64) -> u64 {
        match (self.seed, self.variables.frame) {
            (Some(seed), _) => seed,
            (None, Some(frame)) => seed::of_frame(scene, frame),
            (None, None) => scene,
        }
    }

    /// The resolution of a preview of a picture of the given size, if it differs.
    pub(crate) fn quick_resolution(&self, [x, y]: [u32; 2]) -> Option<[u32; 2]> {
        let longer = x.max(y);
        if !self.quick || self.resolution.is_some() || longer <= QUICK_SIDE {
            return None;
        }
        let reduced = |n: u32| (f64::from(n) * f64::from(QUICK_SIDE) / f64::from(longer)).round().max(1.0) as u32;
        Some([reduced(x), reduced(y)])
    }

    /// The samples a pixel of a preview of a picture with the given number of them, if it differs.
    pub(crate) fn quick_samples(&self, samples: u32) -> Option<u32> {
        (self.quick && self.spp.is_none() && samples > QUICK_SAMPLES).then_some(QUICK_SAMPLES)
    }
}

/// Puts the plugin `name` in place of the scene's, with those of its parameters that it has too.
fn replace<T: Kind + ?Sized>(slot: &mut Option<Entity>, name: &str, span: Span, registry: &Registry) {
    let mut new = entity(name, span);
    if let Some(old) = slot.take() {
        let known = registry.parameters::<T>(name);
        let same = old.name.value == name;
        new.params = old.params.into_iter().filter(|p| same || known.iter().any(|k| k.name == p.name.value)).collect();
        new.faulty = old.faulty;
    }
    *slot = Some(new);
}
