//! Emissions of surfaces: they are told what light moves through, and the surfaces what they need of them.

use crate::lang::parts::{Part, PartAreaLight};
use crate::lang::spacetime::{Gravity, points_of};
use bhs_core::diagnostics::{Diagnostic, Span};
use bhs_core::geometry::{Geometry, WorldGeometry};
use bhs_core::light::{AreaLight, Matter};
use bhs_core::motion::{Motion, Surroundings};
use bhs_core::observer::Observer;
use bhs_core::spacetime::{Minkowski, Place, Side, Spacetime};
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

/// Warns of a surface (render space), with the place of its name, whose emission supposes matter that is elsewhere or moves otherwise.
pub(super) fn check(
    (geometry, motion): (&Geometry, Option<&Arc<dyn Motion>>),
    light: &dyn AreaLight,
    gravity: Option<&Gravity>,
    (side, span): (Side, Span),
    found: &mut Vec<Diagnostic>,
) {
    let Some(gravity) = gravity else { return };
    let (spacetime, conventions) = (Some(gravity.spacetime.as_ref()), gravity.conventions);
    let (mut elsewhere, mut otherwise) = (false, false);
    for x in points_of(geometry) {
        let velocity = match light.matter(x) {
            Matter::Any => continue,
            Matter::Elsewhere => {
                elsewhere = true;
                continue;
            }
            Matter::Moving(velocity) => velocity,
        };
        let here = Surroundings { spacetime, place: Place { x, side }, conventions };
        // Where no matter moves so, nothing emits.
        let Some(supposed) = here.moving(velocity) else { continue };
        let observer = motion.map_or_else(|| here.at_rest(), |m| m.observer(&here));
        otherwise |= observer.is_none_or(|o| !is_same_motion(&o, &supposed));
    }
    if elsewhere {
        found.push(
            Diagnostic::warning("off-plane", "this shape does not lie in the plane of what it emits")
                .at(span, "matter circles the hole in the plane through its centre, across the axis")
                .help("a `disk` lies in its own plane z = 0: turn it with `Rotate -90 1 0 0` for the axis +y"),
        );
    }
    if otherwise {
        found.push(
            Diagnostic::warning("other-motion", "this shape does not move as what it emits")
                .at(span, "frequencies and angles are those of how the shape moves")
                .help("add \"string motion\" \"keplerian\", with `retrograde` and `axis` as the light has them"),
        );
    }
}

/// Whether two observers at a place move alike, by their clocks and their directions in the chart.
fn is_same_motion(a: &Observer, b: &Observer) -> bool {
    let [u, v] = [a, b].map(|o| o.flow().normalize_or_zero());
    (a.clock_rate() - b.clock_rate()).abs() < 1e-6 && (u - v).length() < 1e-6
}
