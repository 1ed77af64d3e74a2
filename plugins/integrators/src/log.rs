//! What is noted while one ray is followed.

use bhs_core::integrator::{Arrival, Cost, RayEnd};
use glam::DVec3;

#[derive(Clone, Copy, Debug, Default)]
pub struct Counts {
    pub geodesics: u32,
    pub steps: u32,
    pub queries: u32,
    pub leaps: u32,
    pub chords_skipped: u32,
    pub hit: u32,
    pub escaped: u32,
    pub captured: u32,
    pub out_of_steps: u32,
}

#[derive(Clone, Debug, Default)]
pub struct TraceLog {
    pub counters: Counts,
    pub phi: f64,
    pub polyline: Option<Vec<DVec3>>,
}

impl TraceLog {
    pub fn point(&mut self, p: DVec3) {
        if let Some(polyline) = &mut self.polyline {
            polyline.push(p);
        }
    }

    pub fn cost(&self) -> Cost {
        let Counts { steps, queries, leaps, chords_skipped, .. } = self.counters;
        Cost { steps, queries, leaps, chords_skipped }
    }

    pub fn end(&self, arrival: Arrival) -> RayEnd {
        RayEnd { arrival, swept: self.phi, cost: self.cost() }
    }
}
