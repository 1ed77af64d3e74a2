//! `Option`: what holds for the whole render.

use crate::lang::seed;
use crate::lang::source::SourceMap;
use crate::registry::{Registry, bare_context};
use bhs_core::diagnostics::{Diagnostic, Span, Spanned};
use bhs_core::intersector::IntersectorBuilder;
use bhs_core::params::{Context, ParamInfo, Params};
use bhs_core::value::Param;

/// The seed, and the name of the intersector.
pub(super) fn build_options(
    options: &[Param],
    registry: &Registry,
    context: Context,
    sources: &SourceMap,
    found: &mut Vec<Diagnostic>,
) -> (u64, Spanned<String>) {
    let owner = Spanned::new("Option".to_owned(), options.first().map_or(Span::default(), |p| p.name.span));
    let p = Params::new(owner, options, context);
    let read = read_options(&p, registry, sources);
    found.extend(p.finish().0);
    read
}

fn read_options(p: &Params, registry: &Registry, sources: &SourceMap) -> (u64, Spanned<String>) {
    let default = registry.names::<dyn IntersectorBuilder>().first().copied().unwrap_or("embree");
    let seed = seed::read(p, sources);
    let intersector = p.get("intersector", default.to_owned(), "", "what finds the surfaces along a chord");
    (seed, Spanned::new(intersector, p.span_of("intersector")))
}

/// The parameters of `Option`.
pub fn option_params(registry: &Registry) -> Vec<ParamInfo> {
    let sources = SourceMap::new();
    let owner = Spanned::new("Option".to_owned(), Span::default());
    let p = Params::new(owner, &[], bare_context(&sources, registry.spectra()));
    read_options(&p, registry, &sources);
    p.finish().1
}
