//! `schwarzschild-adaptive`: light around a Schwarzschild hole, as precise as it is asked to be.
//!
//! Taylor series of the orbit, two or three steps a ray (`taylor.rs`), between which chords go to the intersector. Both keep within
//! `tolerance` together: at most a quarter of it is the integration's, and never more than a relative error of 1e-6; the rest is the chords'.
//! Rays that come together are followed side by side (`packet.rs`).
//! What the chords meet is refined to where the orbit meets the surface: what is left to the tolerance is which surface is met.
//!
//! In other spacetimes rays are followed by what suits those best, to the same tolerance: around a charged hole by the same series, several extremal
//! holes and wormholes by their refractive index, all others by Hamilton's equations.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `tolerance` | float | a tenth of the ray's footprint | scene | largest distance between the true ray and what is traced |
//! | `maxsteps` | integer | 100000 | | steps after which a ray is given up |
//! | `connections` | bool | false | | whether lights are sampled in wormholes and among several holes, where the rays to them take long to find |
//! | `windings` | integer | 0 | | whole turns around the hole of the longest light that is sampled |
//!
//! ```bhs
//! Integrator "schwarzschild-adaptive" "float tolerance" 1e-4
//! WorldBegin
//! BlackHole "schwarzschild" "point3 center" [0 1 4] "float rs" 0.1
//! ```

use crate::flight::{Flight, Tolerance};
use crate::graded_index::connect::GradedConnections;
use crate::in_spacetime::{InSpacetime, Method};
use crate::joined::{Chord, Joined, read_turns};
use crate::packet::{Course, End, NOWHERE, follow};
use crate::taylor::TaylorOrbit;
use bhs_core::Plugin;
use bhs_core::integrator::{Arrival, Connections, Integrator, Ray, RayEnd};
use bhs_core::lanes::LANES;
use bhs_core::observer::Observer;
use bhs_core::params::Params;
use bhs_core::spacetime::{Place, Side, Spacetime};
use crate::log::TraceLog;
use bhs_core::world::World;
use glam::DVec3;
use std::sync::Arc;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Integrator> =
    Plugin { name: "schwarzschild-adaptive", summary: "light around a Schwarzschild hole to a given tolerance", build };

/// Light around a Schwarzschild hole to a given tolerance.
#[derive(Clone, Copy, Debug)]
pub struct Adaptive {
    /// Largest distance between the true ray and what is traced.
    pub tolerance: Tolerance,
    /// Steps after which a ray is given up.
    pub max_steps: u64,
    /// Whether rays between two points are searched in spacetimes where that takes long.
    pub connections: bool,
    joined: Joined,
}

impl Adaptive {
    /// To that tolerance; gives up after so many steps.
    pub fn new(tolerance: Tolerance, max_steps: u64) -> Self {
        Self { tolerance, max_steps, connections: false, joined: Joined { turns: 1, chord: Chord::Tolerance(tolerance) } }
    }
}

/// The integration's share of the tolerance; its error costs little to lower, that of the chords much.
const INTEGRATION: f64 = 0.25;

fn build(p: &Params) -> Option<Box<dyn Integrator>> {
    let tolerance = Tolerance::read(p);
    let max_steps = p.get_in("maxsteps", 100_000, 1..=1_000_000_000, "", "steps after which a ray is given up");
    let made = Adaptive::new(tolerance, max_steps as u64);
    let joined = Joined { turns: read_turns(p), ..made.joined };
    let about = "whether lights are sampled in wormholes and among several holes, where the rays to them take long to find";
    let connections = p.get("connections", false, "", about);
    Some(Box::new(Adaptive { connections, joined, ..made }))
}

impl Adaptive {
    fn arrival(&self, world: &World, ray: &Ray, log: &mut TraceLog) -> Arrival {
        let flight = match Flight::begin(world, ray, log) {
            Ok(flight) => flight,
            Err(arrival) => return arrival,
        };
        let error = self.tolerance.relative(world, ray.footprint, INTEGRATION);
        let orbit = TaylorOrbit::new(flight.hole.rs, flight.start, error);
        let chord = self.tolerance.chord(world, flight.hole, ray.footprint, error);
        flight.follow(orbit, chord, self.max_steps, log)
    }

    fn follow_one(&self, world: &World, ray: &Ray, log: &mut TraceLog) -> RayEnd {
        let arrival = self.arrival(world, ray, log);
        log.end(arrival)
    }
}

impl Integrator for Adaptive {
    fn for_spacetime(&self, spacetime: &Arc<dyn Spacetime>) -> Result<Box<dyn Integrator>, String> {
        let connections = if self.connections { GradedConnections::new(&**spacetime, self.tolerance) } else { None };
        Ok(Box::new(InSpacetime { method: Method::Adaptive(self.tolerance), max_steps: self.max_steps, connections }))
    }

    fn trace_all(&self, world: &World, rays: &[Ray], ends: &mut [RayEnd]) {
        for (ray, end) in rays.iter().zip(ends) {
            let mut log = TraceLog::default();
            *end = self.follow_one(world, ray, &mut log);
        }
    }

    fn polyline(&self, world: &World, ray: &Ray) -> (RayEnd, Vec<DVec3>) {
        let mut log = TraceLog { polyline: Some(Vec::new()), ..TraceLog::default() };
        let end = self.follow_one(world, ray, &mut log);
        (end, log.polyline.unwrap_or_default())
    }

    fn observer(&self, world: &World, place: Place) -> Option<Observer> {
        world.static_observer(place)
    }

    fn connections(&self) -> Option<&dyn Connections> {
        Some(&self.joined)
    }

    fn is_curved(&self) -> bool {
        true
    }
}
