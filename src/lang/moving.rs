//! Surfaces in motion: what the parameters of a shape state, and where that is no motion of a surface.

use crate::lang::spacetime::{Gravity, points_of, samples_of};
use bhs_core::diagnostics::{Diagnostic, Span};
use bhs_core::geometry::Geometry;
use bhs_core::motion::{Motion, Surroundings};
use bhs_core::observer::Conventions;
use bhs_core::spacetime::{Place, Side};
use glam::DVec3;
use std::sync::Arc;

/// Largest sine of the angle between a surface and how it moves: meshes are surfaces of revolution nearly.
const LARGEST_SINE: f64 = 0.1;

/// Triangles of a mesh that are looked at.
const MOST_TRIANGLES: usize = 4096;

/// A place of a surface with its unit normal.
type Spot = (DVec3, DVec3);

/// Places all over `geometry`.
fn spots(geometry: &Geometry) -> Box<dyn Iterator<Item = Spot> + '_> {
    match geometry {
        Geometry::Analytic(surface) => Box::new(samples_of(&**surface).map(|sample| (sample.point, sample.normal))),
        mesh => {
            let count = mesh.triangle_count();
            let every = count.div_ceil(MOST_TRIANGLES).max(1);
            let corners = (0..count).step_by(every).filter_map(|t| mesh.corners(t as u32));
            Box::new(corners.filter_map(|[a, b, c]| Some(((a + b + c) / 3.0, (b - a).cross(c - a).try_normalize()?))))
        }
    }
}

/// What is wrong with a surface (render space) that moves so, or stands still; on its own side, with the place of its name.
pub(super) fn check(
    (geometry, motion): (&Geometry, Option<&Arc<dyn Motion>>),
    gravity: Option<&Gravity>,
    (side, span): (Side, Span),
    found: &mut Vec<Diagnostic>,
) {
    let Some(motion) = motion else {
        if let Some(gravity) = gravity {
            check_ergosphere(geometry, gravity, (side, span), found);
        }
        return;
    };
    let spacetime = gravity.map(|g| g.spacetime.as_ref());
    if let Some(why) = motion.fault(spacetime) {
        found.push(Diagnostic::error("no-such-motion", "nothing can move so here").at(span, why));
        return;
    }
    let conventions = gravity.map_or(Conventions::NATURE, |g| g.conventions);
    let (mut all, mut none, mut leaves) = (0_u32, 0_u32, 0_u32);
    for (x, normal) in spots(geometry) {
        all += 1;
        match motion.observer(&Surroundings { spacetime, place: Place { x, side }, conventions }) {
            None => none += 1,
            Some(observer) => {
                let flow = observer.flow();
                leaves += u32::from(flow.dot(normal).abs() > LARGEST_SINE * flow.length());
            }
        }
    }
    if leaves > 0 {
        found.push(
            Diagnostic::error("surface-moves-away", "a surface can move within itself only")
                .at(span, "this motion leads out of it")
                .help("let it turn about the axis of what it is a surface of revolution about; other solids in motion are not supported"),
        );
    } else if all > 0 && none == all {
        found.push(
            Diagnostic::error("no-such-motion", "nothing can move so at any place of this shape")
                .at(span, "it would be as fast as light, or there is no such orbit")
                .help("move the shape away from the hole, or let it move otherwise"),
        );
    } else if none > 0 {
        found.push(
            Diagnostic::warning("partly-no-motion", "nothing can move so at some places of this shape")
                .at(span, "it is black there")
                .help("make the shape smaller, or let it move otherwise"),
        );
    }
}

/// What stands still in an ergosphere.
fn check_ergosphere(geometry: &Geometry, gravity: &Gravity, (side, span): (Side, Span), found: &mut Vec<Diagnostic>) {
    if !gravity.spacetime.drags() {
        return;
    }
    let (mut all, mut dragged) = (0_u32, 0_u32);
    for x in points_of(geometry) {
        all += 1;
        let place = Place { x, side };
        dragged += u32::from(gravity.spacetime.at(place).is_none() && gravity.spacetime.normal(place).is_some());
    }
    let help = "move it out, or let it be dragged along: \"string motion\" \"zamo\"";
    if all > 0 && dragged == all {
        found.push(
            Diagnostic::error("in-ergosphere", "nothing can stand still in the ergosphere")
                .at(span, "all of this shape is there")
                .and(gravity.span, "of this hole")
                .help(help),
        );
    } else if dragged > 0 {
        found.push(
            Diagnostic::warning("in-ergosphere", "nothing can stand still in the ergosphere")
                .at(span, "what of this shape is there is black")
                .and(gravity.span, "of this hole")
                .help(help),
        );
    }
}
