//! Emissions of surfaces: they are told what light moves through, and the surfaces what they need of them.

use crate::lang::parts::{Part, PartAreaLight};
use crate::lang::spacetime::Gravity;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::geometry::WorldGeometry;
use bhs_core::light::AreaLight;
use bhs_core::spacetime::{Minkowski, Spacetime};
use std::sync::Arc;

/// Tells each of the lights once what light moves through, in render space.
pub(super) fn bind(
    lights: Vec<PartAreaLight>,
    gravity: Option<&Gravity>,
    found: &mut Vec<Diagnostic>,
) -> Vec<Option<Arc<dyn AreaLight>>> {
    let flat = Minkowski::default();
    let spacetime: &dyn Spacetime = gravity.map_or(&flat, |g| g.spacetime.as_ref());
    let bound = |PartAreaLight { span, light }: PartAreaLight| {
        let mut light = light?;
        if let Err(why) = light.bind(spacetime) {
            found.push(Diagnostic::error("no-emission", "this light cannot emit in this spacetime").at(span, why));
        }
        Some(Arc::from(light))
    };
    lights.into_iter().map(bound).collect()
}

/// Gives disks that do not say where they begin the inner edge of their emission.
pub(super) fn open(shapes: &mut [Part], lights: &[Option<Arc<dyn AreaLight>>], found: &mut Vec<Diagnostic>) {
    for part in shapes {
        let Some(light) = part.area_light.and_then(|l| lights.get(l)?.as_ref()) else { continue };
        let (Some(edge), WorldGeometry::Analytic(surface)) = (light.inner_edge(), &mut part.geometry) else { continue };
        if !surface.open(edge) {
            found.push(
                Diagnostic::error("inner-edge", "this disk lies within the inner edge of what it emits")
                    .at(part.span, format!("it emits from {edge:.6} on"))
                    .help("make its `radius` larger"),
            );
        }
    }
}
