//! The methods of a scene without the scene: what can be exchanged once it is built.

use crate::lang::overrides::{Overrides, Settings};
use crate::lang::source::SourceMap;
use crate::lang::spacetime::{build_spacetime, choose_integrator};
use crate::lang::{build, has_errors, options, resolve};
use crate::registry::{Registry, bare_context};
use bhs_core::diagnostics::Diagnostic;
use bhs_core::params::Context;
use bhs_core::sampling::Sampler;
use bhs_engine::integrator::Integrator;
use bhs_engine::transport::LightTransport;
use std::path::Path;

/// How a scene is rendered.
pub struct Method {
    /// How light travels.
    pub integrator: Box<dyn Integrator>,
    /// How it is gathered.
    pub transport: Box<dyn LightTransport>,
    /// Random numbers.
    pub sampler: Box<dyn Sampler>,
}

/// Reads the scene `path` and makes its methods as `overrides` change them, but none of its surfaces: takes no longer than reading the
/// text.
///
/// # Errors
/// As [`crate::lang::load`].
pub fn load_method(
    path: impl AsRef<Path>,
    registry: &Registry,
    overrides: &Overrides,
    sources: &mut SourceMap,
) -> Result<Method, Vec<Diagnostic>> {
    let file = sources.open(path).map_err(|d| vec![*d])?;
    let (mut description, mut found) = resolve::resolve_with(sources, file, &overrides.variables);
    let settings = Settings::take(&mut description, overrides, registry, sources, &mut found);
    let context = bare_context(sources, registry.spectra());
    let (seed, _) = options::build_options(&settings.options, registry, context, sources, &mut found);
    let context = Context { seed: overrides.seed.unwrap_or(seed), ..context };
    let (film, _) = registry.create_film(&settings.film, context, &mut found);
    let gravity = description.spacetime.as_ref().and_then(|e| build_spacetime(e, registry, context, &mut found));
    let context = Context {
        resolution: film.as_ref().map_or(context.resolution, |f| f.resolution()),
        lambda_range: film.as_ref().map_or(context.lambda_range, |f| f.lambda_range()),
        ..context
    };
    let builder = build::build_integrator(&settings.integrator, registry, context, &mut found);
    let (_, integrator, _) = choose_integrator(builder, gravity.as_ref(), registry, &mut found);
    let transport = registry.create::<dyn LightTransport>(&settings.transport, context, &mut found);
    let sampler = registry.create::<dyn Sampler>(&settings.sampler, context, &mut found);
    match (integrator, transport, sampler) {
        (Some(integrator), Some(transport), Some(sampler)) if !has_errors(&found) => {
            Ok(Method { integrator, transport, sampler })
        }
        _ => Err(found),
    }
}
