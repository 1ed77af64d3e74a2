//! What is counted while light is traced.

use glam::DVec3;
use std::ops::AddAssign;

/// Counts over any number of rays. Sums of these do not depend on the order of work.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counters {
    /// Camera paths.
    pub paths: u64,
    /// Rays followed, straight or curved.
    pub geodesics: u64,
    /// Steps of the orbit integrator.
    pub steps: u64,
    /// Questions put to the intersector.
    pub queries: u64,
    /// Chords that lay outside the scene's bounds and were not put to it.
    pub chords_skipped: u64,
    /// Stretches of orbits that were passed over because nothing was near.
    pub leaps: u64,
    /// Geodesics that were found between pairs of points for light sampling.
    pub connections: u64,
    /// Those that were searched for something in their way.
    pub connections_searched: u64,
    /// Those that no light comes along: from behind a surface, or from the back of a lamp.
    pub connections_dark: u64,
    /// Those that were so faint that they were left to chance, and not searched.
    pub connections_faint: u64,
    /// Those that were searched and that something stands in the way of.
    pub connections_blocked: u64,
    /// Questions put to the intersector along them, counted in `queries` too.
    pub connection_queries: u64,
    /// Paths that ended on a surface within the horizon, where nobody can stand.
    pub inside_horizon: u64,
    /// Rays that ended on a surface.
    pub hit: u64,
    /// Rays that left the scene for good.
    pub escaped: u64,
    /// Rays that fell into the hole.
    pub captured: u64,
    /// Rays that the integrator gave up.
    pub out_of_steps: u64,
    /// Path samples that were not finite and were left out.
    pub not_finite: u64,
}

impl AddAssign for Counters {
    fn add_assign(&mut self, o: Self) {
        self.paths += o.paths;
        self.geodesics += o.geodesics;
        self.steps += o.steps;
        self.queries += o.queries;
        self.chords_skipped += o.chords_skipped;
        self.leaps += o.leaps;
        self.connections += o.connections;
        self.connections_searched += o.connections_searched;
        self.connections_dark += o.connections_dark;
        self.connections_faint += o.connections_faint;
        self.connections_blocked += o.connections_blocked;
        self.connection_queries += o.connection_queries;
        self.inside_horizon += o.inside_horizon;
        self.hit += o.hit;
        self.escaped += o.escaped;
        self.captured += o.captured;
        self.out_of_steps += o.out_of_steps;
        self.not_finite += o.not_finite;
    }
}

/// What tracing leaves behind besides its result.
#[derive(Clone, Debug, Default)]
pub struct TraceLog {
    /// Counts, added to.
    pub counters: Counters,
    /// Angle swept around the hole by the last ray that was traced (rad); 0 for straight rays.
    pub phi: f64,
    /// The points of the polyline that is traced, render space, if somebody wants them.
    pub polyline: Option<Vec<DVec3>>,
}

impl TraceLog {
    /// Notes a point of the polyline, if wanted.
    #[inline]
    pub fn point(&mut self, p: DVec3) {
        if let Some(polyline) = &mut self.polyline {
            polyline.push(p);
        }
    }
}
