//! What is counted while light is traced.

use crate::connections::MOST_TURNS;
use crate::path_log::PathEvent;
use bhs_core::ray::{Arrival, Cost, RayEnd};
use std::ops::AddAssign;

/// Declares [`Counters`]: each count is written down once, and is added up, saved and restored from there.
macro_rules! counters {
    ($($(#[$about:meta])* $name:ident,)*) => {
        /// Counts over any number of rays. Sums of these do not depend on the order of work.
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        pub struct Counters {
            $($(#[$about])* pub $name: u64,)*
        }

        impl AddAssign for Counters {
            fn add_assign(&mut self, o: Self) {
                // Counts that come from a file may be anything.
                $(self.$name = self.$name.saturating_add(o.$name);)*
            }
        }

        impl Counters {
            /// All counts with their names, to be saved.
            pub fn named(&self) -> impl Iterator<Item = (&'static str, u64)> {
                [$((stringify!($name), self.$name)),*].into_iter()
            }

            /// The count of the given name; `None` if there is no such count.
            pub fn by_name_mut(&mut self, name: &str) -> Option<&mut u64> {
                match name {
                    $(stringify!($name) => Some(&mut self.$name),)*
                    _ => None,
                }
            }
        }
    };
}

counters! {
    /// Camera paths.
    paths,
    /// Rays followed, straight or curved.
    geodesics,
    /// Steps of the orbit integrator.
    steps,
    /// Segments put to the intersector.
    queries,
    /// Chords that lay outside the scene's bounds and were not put to it.
    chords_skipped,
    /// Stretches of orbits that were passed over because nothing was near.
    leaps,
    /// Pairs of points, and points with directions of the sky, between which geodesics were sought.
    connections_sought,
    /// Of the geodesics of each number that were sought there, those that were not found, though they may be there.
    connections_missed_1,
    /// See [`Counters::connections_missed_1`].
    connections_missed_2,
    /// See [`Counters::connections_missed_1`].
    connections_missed_3,
    /// See [`Counters::connections_missed_1`].
    connections_missed_4,
    /// See [`Counters::connections_missed_1`].
    connections_missed_5,
    /// See [`Counters::connections_missed_1`].
    connections_missed_6,
    /// Of those of each number, those that were not looked for, since they promised little.
    connections_passed_over_1,
    /// See [`Counters::connections_passed_over_1`].
    connections_passed_over_2,
    /// Geodesics that were found between pairs of points for light sampling.
    connections,
    /// Those that carry no light: from behind a surface, or from the back of a light.
    connections_dark,
    /// Those that carry so little that Russian roulette ended them before a shadow ray was traced.
    connections_ended,
    /// Shadow rays traced along the others.
    shadow_rays,
    /// Shadow rays that are occluded.
    shadow_rays_occluded,
    /// Segments put to the intersector along shadow rays, counted in `queries` too.
    shadow_ray_queries,
    /// Paths that ended where there is no static observer: on a surface within the horizon.
    no_static_observer,
    /// Rays of the camera that ended on a surface.
    camera_hit,
    /// Rays of the camera that left the scene for good.
    camera_escaped,
    /// Rays of the camera that fell into the hole.
    camera_captured,
    /// Rays of the camera that the integrator gave up.
    camera_out_of_steps,
    /// Rays that ended on a surface.
    hit,
    /// Rays that left the scene for good.
    escaped,
    /// Rays that fell into the hole.
    captured,
    /// Rays that the integrator gave up.
    out_of_steps,
    /// Path samples that were not finite and were left out.
    not_finite,
}

impl Counters {
    /// Counts of the geodesics between pairs of points that were sought and not found, by their number.
    pub fn connections_missed(&mut self) -> [&mut u64; 2 * MOST_TURNS] {
        [
            &mut self.connections_missed_1,
            &mut self.connections_missed_2,
            &mut self.connections_missed_3,
            &mut self.connections_missed_4,
            &mut self.connections_missed_5,
            &mut self.connections_missed_6,
        ]
    }

    /// Counts of the geodesics between pairs of points that were not looked for, by their number.
    pub fn connections_passed_over(&mut self) -> [&mut u64; 2] {
        [&mut self.connections_passed_over_1, &mut self.connections_passed_over_2]
    }

    /// Counts a ray that has been followed.
    #[inline]
    pub fn add_ray(&mut self, end: &RayEnd) {
        self.geodesics += 1;
        let ended = match end.arrival {
            Arrival::Surface(_) => &mut self.hit,
            Arrival::Sky(..) => &mut self.escaped,
            Arrival::Captured => &mut self.captured,
            Arrival::OutOfSteps => &mut self.out_of_steps,
        };
        *ended += 1;
        self.steps += u64::from(end.cost.steps);
        self.add_queries(end.cost);
    }

    /// Counts what became of a ray of the camera, which is counted by [`Counters::add_ray`] too.
    #[inline]
    pub fn add_camera_ray(&mut self, end: &RayEnd) {
        *match end.arrival {
            Arrival::Surface(_) => &mut self.camera_hit,
            Arrival::Sky(..) => &mut self.camera_escaped,
            Arrival::Captured => &mut self.camera_captured,
            Arrival::OutOfSteps => &mut self.camera_out_of_steps,
        } += 1;
    }

    /// Counts `count` shadow rays that have been traced, and what all of them took: their steps are none of a path's rays.
    pub fn add_shadow_rays(&mut self, count: usize, cost: Cost) {
        self.shadow_rays += count as u64;
        self.shadow_ray_queries += u64::from(cost.queries);
        self.add_queries(cost);
    }

    #[inline]
    fn add_queries(&mut self, cost: Cost) {
        self.queries += u64::from(cost.queries);
        self.leaps += u64::from(cost.leaps);
        self.chords_skipped += u64::from(cost.chords_skipped);
    }
}

/// What following paths leaves behind besides what they find.
#[derive(Clone, Debug, Default)]
pub struct PathLog {
    /// Counts, added to.
    pub counters: Counters,
    /// What happens to a path that is followed alone, if somebody wants to know.
    pub path: Option<Vec<PathEvent>>,
}

impl PathLog {
    /// Notes what happens to a path, if wanted.
    #[inline]
    pub fn note(&mut self, event: impl FnOnce() -> PathEvent) {
        if self.path.is_some() {
            self.keep(event);
        }
    }

    /// Apart, so that what nobody wants takes no room where paths are followed.
    #[cold]
    #[inline(never)]
    fn keep(&mut self, event: impl FnOnce() -> PathEvent) {
        if let Some(path) = &mut self.path {
            path.push(event());
        }
    }
}
