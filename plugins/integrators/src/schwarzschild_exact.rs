//! `schwarzschild-exact`: light around a Schwarzschild hole in closed form, without steps.
//!
//! Every point of the orbit comes from elliptic functions of its initial state, right to rounding at any angle, after any number of
//! windings (the formula and its sources: `closed_form.rs`). Chords of the orbit go to the intersector, and what they meet is refined
//! to where the orbit meets the surface, again in full precision. The measure of all other integrators, and fast enough to render with.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `tolerance` | float | a tenth of the ray's footprint | scene | largest distance between the true ray and its chords |
//! | `maxsteps` | integer | 100000 | | stretches of 1 rad after which a ray is given up |
//! | `windings` | integer | 0 | | whole turns around the hole of the longest light that is sampled |
//!
//! The tolerance decides which surface is met where a ray passes an edge, not how precisely.
//!
//! ```bhs
//! Integrator "schwarzschild-exact" "float tolerance" 1e-5
//! WorldBegin
//! BlackHole "schwarzschild" "point3 center" [0 1 4] "float rs" 0.1
//! ```

use crate::closed_form::{ClosedForm, ExactOrbit};
use crate::flight::{Flight, Tolerance};
use crate::joined::{Chord, Joined, read_turns};
use crate::straight::Straight;
use bhs_core::Plugin;
use bhs_core::integrator::{Arrival, Connections, Integrator, Ray, RayEnd};
use bhs_core::observer::Observer;
use bhs_core::params::Params;
use bhs_core::spacetime::{Class, Place, Spacetime};
use crate::log::TraceLog;
use bhs_core::world::World;
use glam::DVec3;
use std::sync::Arc;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Integrator> =
    Plugin { name: "schwarzschild-exact", summary: "light around a Schwarzschild hole by elliptic functions", build };

/// Light around a Schwarzschild hole in closed form.
#[derive(Clone, Copy, Debug)]
pub struct Exact {
    /// Largest distance between the true ray and its chords.
    pub tolerance: Tolerance,
    /// Stretches of 1 rad after which a ray is given up.
    pub max_steps: u64,
    joined: Joined,
}

impl Exact {
    /// To that tolerance; gives up after so many steps.
    pub fn new(tolerance: Tolerance, max_steps: u64) -> Self {
        Self { tolerance, max_steps, joined: Joined { turns: 1, chord: Chord::Tolerance(tolerance) } }
    }
}

fn build(p: &Params) -> Option<Box<dyn Integrator>> {
    let tolerance = Tolerance::read(p);
    let max_steps = p.get_in("maxsteps", 100_000, 1..=1_000_000_000, "", "stretches of 1 rad after which a ray is given up");
    let made = Exact::new(tolerance, max_steps as u64);
    Some(Box::new(Exact { joined: Joined { turns: read_turns(p), ..made.joined }, ..made }))
}

impl Exact {
    fn arrival(&self, world: &World, ray: &Ray, log: &mut TraceLog) -> Arrival {
        let flight = match Flight::begin(world, ray, log) {
            Ok(flight) => flight,
            Err(arrival) => return arrival,
        };
        let form = ClosedForm::new(flight.hole.rs, flight.start.u, flight.start.du);
        let chord = self.tolerance.chord(world, flight.hole, ray.footprint, 0.0);
        flight.follow(ExactOrbit::new(&form), chord, self.max_steps, log)
    }

    fn follow_one(&self, world: &World, ray: &Ray, log: &mut TraceLog) -> RayEnd {
        let arrival = self.arrival(world, ray, log);
        log.end(arrival)
    }
}

impl Integrator for Exact {
    fn for_spacetime(&self, spacetime: &Arc<dyn Spacetime>) -> Result<Box<dyn Integrator>, String> {
        match spacetime.class() {
            Class::Flat => Ok(Box::new(Straight)),
            _ => {
                Err("needs a spherical spacetime without charge, for its elliptic functions are those of one such hole"
                    .to_owned())
            }
        }
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
