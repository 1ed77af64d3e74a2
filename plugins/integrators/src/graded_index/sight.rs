//! What stands between two points of a ray of a refractive index.

use crate::graded_index::course::Setting;
use crate::tracing::driver::{End, Start, follow};
use bhs_core::geometry::Segment;
use bhs_core::integrator::Sight;
use bhs_core::intersector::Ends;
use bhs_core::spacetime::Class;
use bhs_core::stats::TraceLog;
use bhs_core::world::World;
use glam::DVec3;

/// How close to its end a ray may meet a surface without being blocked by it, relative to the coordinates there: the surface at the end must not
/// shadow itself.
const SHADOW_END: f64 = 64.0 * f32::EPSILON as f64;

/// Relative error of the ray between the ends; it is to meet the end closer than [`SHADOW_END`].
const ERROR: f64 = 1e-7;

/// Steps after which a ray is given up.
const MOST_STEPS: u64 = 100_000;

/// Whether nothing stands between the start of `sight` and the point of its ray at the parameter `sigma_end`, which is about where `sight` ends; chords
/// stray from the ray by at most `tolerance` (scene units). `false` in spacetimes that have no refractive index.
///
/// Makes what is told of the world anew: [`reaches_in`] is for several sights.
pub fn reaches(world: &World, sight: &Sight, sigma_end: f64, tolerance: f64, log: &mut TraceLog) -> bool {
    let Some(spacetime) = world.spacetime.as_deref() else { return false };
    let Class::Index(index) = spacetime.class() else { return false };
    reaches_in(&Setting::new(world, spacetime, index), world, sight, (sigma_end, tolerance), log)
}

/// The same with what is told of the world once. Counts queries and leaps, but no ray and no steps.
pub fn reaches_in(
    setting: &Setting<'_>,
    world: &World,
    sight: &Sight,
    (sigma_end, tolerance): (f64, f64),
    log: &mut TraceLog,
) -> bool {
    let Sight { start, from, to, connection, .. } = *sight;
    let close = SHADOW_END * to.x.abs().max_element().max(from.abs().max_element());
    let n = setting.medium.at::<f64>(to.x.into()).0.sqrt();
    let gap = tolerance;
    // The last chord ends just before the end: |dx/dsigma| = n.
    let limit = (sigma_end - close / n).max(0.0);
    let whole = Start {
        origin: start.origin,
        launch: connection.launch,
        side: start.side,
        leaving: start.leaving,
        gap,
        limit,
        max_steps: MOST_STEPS,
    };
    let steps = log.counters.steps;
    let (end, _) = follow(world, &whole, &mut setting.ray(from, connection.launch, start.side, ERROR), log);
    log.counters.steps = steps;
    is_open(world, sight, end, close, log)
}

/// Whether nothing stands in the way of `sight` if its ray, which was to be followed to just before its end, has ended at `end`; surfaces within some
/// times the distance `close` are where it ends.
pub(crate) fn is_open(world: &World, sight: &Sight, end: End, close: f64, log: &mut TraceLog) -> bool {
    let Sight { to, target, .. } = *sight;
    let crowded = target.filter(|_| world.half(to.side).is_some_and(|half| half.is_crowded(to.x)));
    match end {
        End::Surface(hit) => {
            let at_end = world.side_of(hit.geometry) == to.side && is_near(hit.point, to.x, close);
            // Other surfaces may be as near to a crowded end as that.
            at_end && crowded.is_none_or(|target| target.geometry == hit.geometry)
        }
        End::Limit(point, side) => {
            let (Some(target), Some(half)) = (crowded, world.half(side)) else { return true };
            log.counters.queries += 1;
            let segment = Segment { origin: point, direction: to.x - point, t_min: 0.0, t_max: 1.0 };
            !half.blocked_between(&segment, Ends { leaving: None, target: Some(target) })
        }
        // Beyond all surfaces nothing stands in the way.
        End::Sky(_, side) => side == to.side,
        End::Fallen => true,
        End::Lost => false,
    }
}

fn is_near(a: DVec3, b: DVec3, close: f64) -> bool {
    (a - b).length() <= 4.0 * close
}
