//! The description of a scene to a scene that can be rendered: every plugin made, everything joined, moved to render space.

use crate::lang::assemble;
use crate::lang::create::{create, create_with};
use crate::lang::defaults;
use crate::lang::description::{Entity, SceneDescription};
use crate::lang::errors::ErrorCount;
use crate::lang::names::{Names, Pictures};
use crate::lang::options::build_options;
use crate::lang::overrides::{Overrides, Settings, set_integer};
use crate::lang::parse::MAX_ERRORS;
use crate::lang::parts::{PartAreaLight, PartCamera, PartLight, Parts, View};
use crate::lang::pictured::Pictured;
use crate::lang::shapes::build_shapes;
use crate::lang::source::SourceMap;
use crate::lang::spacetime::build_spacetime;
use crate::lang::statements::{CameraStatement, Statements};
use crate::look::Look;
use crate::memory::picture::{self, TooLarge};
use crate::registry::{Registry, bare_context};
use bhs_core::camera::{Camera, Film, Filter, Viewpoint};
use bhs_core::diagnostics::{Diagnostic, Severity, Span, Spanned};
use bhs_core::intersector::IntersectorBuilder;
use bhs_core::light::{AreaLight, Light};
use bhs_core::material::Material;
use bhs_core::params::{Context, Params};
use bhs_core::sampling::Sampler;
use bhs_engine::integrator::IntegratorBuilder;
use bhs_engine::layer::NamedLayer;
use bhs_engine::scene::Scene;
use bhs_engine::transport::LightTransport;
use std::collections::VecDeque;

pub use crate::lang::parts::LoadCounters;

/// A scene that can be rendered.
pub struct BuiltScene {
    /// Geometry, lights, hole and integrator, in render space.
    pub scene: Scene,
    /// Where it is seen from, in render space.
    pub camera: Box<dyn Camera>,
    /// How that stands there.
    pub viewpoint: Viewpoint,
    /// The camera's name, if it has one.
    pub camera_name: Option<String>,
    /// The scene's other cameras, in their order.
    further_views: VecDeque<View>,
    /// What records it.
    pub film: Box<dyn Film>,
    /// What it records besides colour.
    pub layers: Vec<NamedLayer>,
    /// Where the scene names the file of the picture, if it does.
    pub filename_span: Option<Span>,
    /// Where samples of a pixel go.
    pub filter: Box<dyn Filter>,
    /// Random numbers.
    pub sampler: Box<dyn Sampler>,
    /// The method.
    pub transport: Box<dyn LightTransport>,
    /// The integrator's name; `straight` where nothing bends light, whatever the scene asks for.
    pub integrator_name: String,
    /// The method's name.
    pub transport_name: String,
    /// The intersector's name.
    pub intersector_name: String,
    /// The seed of the render.
    pub seed: u64,
    /// A hash of all that the scene has read, texts, meshes, pictures and spectra: 64 hexadecimal digits.
    pub hash: String,
    /// A hash of its texts alone, without the numbers of variables: frames of a film have that in common.
    pub texts_hash: String,
    /// The directive of the film, as the command line has changed it.
    pub film_directive: String,
    /// The variables that the scene reads and that come from outside, with their numbers.
    pub variables: Vec<(String, f64)>,
    /// How its picture is shown, as the film says; the command line may change it.
    pub look: Look,
    /// What was loaded.
    pub load: LoadCounters,
    /// Where its parts stand in the text.
    pub statements: Statements,
    /// What the user should know; no errors.
    pub warnings: Vec<Diagnostic>,
}

impl BuiltScene {
    /// The names of the cameras that have not had their turn, the current one first.
    pub fn camera_names(&self) -> impl Iterator<Item = Option<&str>> {
        std::iter::once(self.camera_name.as_deref()).chain(self.further_views.iter().map(|v| v.name.as_deref()))
    }

    /// The statement of the current camera.
    pub fn camera_statement(&self) -> Option<&CameraStatement> {
        let all = &self.statements.cameras;
        all.get(all.len().checked_sub(1 + self.further_views.len())?)
    }

    /// Looks through the next camera of the scene in place of the current one; false if there is none.
    pub fn next_camera(&mut self) -> bool {
        let Some(view) = self.further_views.pop_front() else { return false };
        let View { name, camera, viewpoint, footprints, draws_points } = view;
        self.camera = camera;
        self.viewpoint = viewpoint;
        self.camera_name = name;
        self.scene.footprints = footprints;
        self.scene.draws_points = draws_points;
        true
    }
}

/// Builds the scene that `description` describes, as `overrides` change it. `found` is what was found wrong with its text;
/// the scene is built as far as it goes nonetheless, to find all that is wrong.
///
/// # Errors
/// Everything that is wrong with the scene, with warnings between; at least one of them is an error.
pub fn build(
    mut description: SceneDescription,
    mut found: Vec<Diagnostic>,
    registry: &Registry,
    overrides: &Overrides,
    sources: &mut SourceMap,
) -> Result<BuiltScene, Vec<Diagnostic>> {
    sources.hash_texts();
    let texts_hash = sources.scene_hash();
    sources.hash_variables(&description.variables.read);
    let camera_given = !description.cameras.is_empty();
    let mut settings = Settings::take(&mut description, overrides, registry, sources, &mut found);

    let statements = Statements::of(&description, &settings, sources);

    // What the other plugins may ask for comes first: seed, film, spacetime.
    let context = bare_context(sources, registry.spectra());
    let (seed, intersector) = build_options(&settings.options, registry, context, sources, &mut found);
    // Frames share all that random numbers make of a scene, and have samples of their own.
    let seed_of_samples = overrides.seed_of_samples(seed);
    let context = Context { seed: overrides.seed.unwrap_or(seed), ..context };
    let (mut film, mut layers) = registry.create_film(&settings.film, context, &mut found);
    if let Some([x, y]) = film.as_ref().and_then(|f| overrides.quick_resolution(f.resolution())) {
        set_integer(&mut settings.film.params, "xresolution", x, settings.quick);
        set_integer(&mut settings.film.params, "yresolution", y, settings.quick);
        (film, layers) = registry.create_film(&settings.film, context, &mut found);
    }
    if let Some(finding) = film.as_deref().and_then(|film| too_large(film, &layers, &settings.film, overrides.too_large)) {
        let refused = finding.severity == Severity::Error;
        found.push(finding);
        if refused {
            // At once: the rest may take long to load.
            in_order(&mut found);
            return Err(found);
        }
    }
    let gravity = description.spacetime.as_ref().and_then(|e| build_spacetime(e, registry, context, &mut found));
    let context = Context {
        resolution: film.as_ref().map_or([640, 480], |f| f.resolution()),
        lambda_range: film.as_ref().map_or([360.0, 830.0], |f| f.lambda_range()),
        ..context
    };

    let of_samples = Context { seed: seed_of_samples, ..context };
    let mut sampler = registry.create::<dyn Sampler>(&settings.sampler, of_samples, &mut found);
    if let Some(spp) = sampler.as_ref().and_then(|s| overrides.quick_samples(s.samples_per_pixel())) {
        set_integer(&mut settings.sampler.params, "pixelsamples", spp, settings.quick);
        sampler = registry.create::<dyn Sampler>(&settings.sampler, of_samples, &mut found);
    }
    let filter = registry.create::<dyn Filter>(&settings.filter, context, &mut found);
    let transport = registry.create::<dyn LightTransport>(&settings.transport, context, &mut found);
    // Of very many materials and shapes, what describes them is let go before more room is needed.
    let names = Names::new(registry, &description);
    let area_light = |e: &Entity| PartAreaLight { span: e.name.span, light: names.make::<dyn AreaLight>(e, context) };
    let area_lights = description.area_lights.iter().map(|l| area_light(&l.entity)).collect();
    let (materials, wants_patches) = names.make_all(context, &mut found);
    let mut pictured = Pictured::new(&description);
    description.materials = Vec::new();
    let (shapes, motions, objects) = build_shapes(&mut description, (registry, sources), context, (&mut pictured, &mut found));
    pictured.report(&mut found);
    let parts = Parts {
        integrator: build_integrator(&settings.integrator, registry, context, &mut found),
        intersector: find_intersector(&intersector, registry, context, &mut found),
        cameras: settings
            .cameras
            .iter()
            .map(|c| {
                let read = |p: &Params| registry.viewpoint(p);
                let (camera, viewpoint) = create_with::<dyn Camera, _>(&c.entity, registry, context, &mut found, read);
                PartCamera {
                    name: c.name.as_ref().map(|n| n.value.clone()),
                    span: camera_given.then_some(c.entity.name.span),
                    camera,
                    viewpoint: viewpoint.unwrap_or_default(),
                    target: c.look_at.map(|look_at| look_at.target),
                }
            })
            .collect(),
        lambda_range: context.lambda_range,
        materials,
        wants_patches,
        default_material: create::<dyn Material>(&settings.material, registry, context, &mut found),
        area_lights,
        lights: {
            let context = Context { named: &Pictures, ..context };
            let light = |e: &Entity| PartLight {
                span: e.name.span,
                side: e.side,
                light: create::<dyn Light>(e, registry, context, &mut found),
            };
            description.lights.iter().map(light).collect()
        },
        samples_lights: transport.as_ref().is_none_or(|t| t.samples_lights()),
        shapes,
        motions,
        objects,
        gravity,
    };

    // All has been checked that can be checked alone; now what it makes together.
    let assembled = assemble::assemble(parts, registry, overrides, &mut found);
    if !crate::lang::has_errors(&found) {
        defaults::warn_unused(&description.attributes, &mut found);
    }
    if ErrorCount::default().count(&found) >= MAX_ERRORS && !found.iter().any(|d| d.code == "too-many-errors") {
        let message = format!("there are more than {MAX_ERRORS} errors; not all of the scene has been looked at");
        found.push(Diagnostic::error("too-many-errors", message));
    }
    in_order(&mut found);
    // What `Attribute` states wrongly is found again with every directive that takes it.
    found.dedup();
    let failed = crate::lang::has_errors(&found);
    match (assembled, film, filter, sampler, transport) {
        (Some(a), Some(film), Some(filter), Some(sampler), Some(transport)) if !failed => Ok(BuiltScene {
            scene: a.scene,
            camera: a.view.camera,
            viewpoint: a.view.viewpoint,
            camera_name: a.view.name,
            further_views: a.further_views,
            look: overrides.look.over(film.look().into()),
            filename_span: settings.film.params.iter().find(|p| p.name.value == "filename").map(|p| p.span),
            film,
            layers,
            filter,
            sampler,
            transport,
            integrator_name: a.integrator_name,
            transport_name: settings.transport.name.value,
            intersector_name: intersector.value,
            seed: seed_of_samples,
            hash: sources.scene_hash(),
            texts_hash,
            film_directive: film_directive(&settings.film),
            variables: description.variables.read,
            load: a.load,
            statements,
            warnings: found,
        }),
        _ if failed => Err(found),
        _ => Err(vec![Diagnostic::error("incomplete", "the scene could not be built").help("this is a fault of bhs")]),
    }
}

/// The directive of a film, without the file that it names.
fn film_directive(film: &Entity) -> String {
    let params = film.params.iter().filter(|p| p.name.value != "filename").cloned().collect();
    Entity { params, ..film.clone() }.to_directive("Film")
}

/// What is said of a picture that is too large for the memory that there is.
fn too_large(film: &dyn Film, layers: &[NamedLayer], entity: &Entity, then: TooLarge) -> Option<Diagnostic> {
    if then == TooLarge::Ignore {
        return None;
    }
    let size = entity.params.iter().find(|p| p.name.value == "xresolution");
    let found = picture::check_at(film, layers, size.map_or(entity.name.span, |p| p.name.span))?;
    let severity = if then == TooLarge::Refuse { Severity::Error } else { Severity::Warning };
    Some(Diagnostic { severity, ..found })
}

fn find_intersector(
    name: &Spanned<String>,
    registry: &Registry,
    context: Context,
    found: &mut Vec<Diagnostic>,
) -> Option<(Span, Box<dyn IntersectorBuilder>)> {
    let Some(plugin) = registry.find::<dyn IntersectorBuilder>(&name.value) else {
        found.push(registry.unknown::<dyn IntersectorBuilder>(name));
        return None;
    };
    let p = Params::new(name.clone(), &[], context);
    let made = (plugin.build)(&p);
    found.extend(p.finish().0);
    made.map(|m| (name.span, m))
}

/// The integrators of pbrt, which are light transports here.
const PBRT_INTEGRATORS: &[&str] =
    &["ambientocclusion", "bdpt", "lightpath", "mlt", "path", "randomwalk", "simplepath", "simplevolpath", "sppm", "volpath"];

pub(super) fn build_integrator(
    entity: &Entity,
    registry: &Registry,
    context: Context,
    found: &mut Vec<Diagnostic>,
) -> Option<(String, Box<dyn IntegratorBuilder>)> {
    let name = entity.name.value.as_str();
    let is_transport = registry.find::<dyn LightTransport>(name).is_some();
    if registry.find::<dyn IntegratorBuilder>(name).is_none() && (is_transport || PBRT_INTEGRATORS.contains(&name)) {
        let instead = if is_transport { name } else { "path" };
        found.push(
            Diagnostic::error("pbrt-integrator", format!("`{name}` is a light transport, not an integrator of light rays"))
                .at(entity.keyword.to(entity.name.span), "")
                .help(format!("write LightTransport \"{instead}\"; `Integrator` says how light travels here")),
        );
        return None;
    }
    Some((name.to_owned(), registry.create::<dyn IntegratorBuilder>(entity, context, found)?))
}

/// Puts findings into the order of the text, those without a place last.
fn in_order(found: &mut [Diagnostic]) {
    found.sort_by_key(|d| match &d.primary {
        Some(label) => (0, label.span.file, label.span.start, d.severity == Severity::Warning),
        None => (1, 0, 0, d.severity == Severity::Warning),
    });
}
