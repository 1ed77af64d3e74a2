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
//! | `connections` | bool | by spacetime | | whether lights are sampled in spacetimes other than the plain hole: by default, in round ones |
//! | `windings` | integer | 0 | | whole turns around the hole of the longest light that is sampled |
//!
//! ```bhs
//! Integrator "schwarzschild-adaptive" "float tolerance" 1e-4
//! WorldBegin
//! BlackHole "schwarzschild" "point3 center" [0 1 4] "float rs" 0.1
//! ```

use crate::flight::{Flight, Tolerance};
use crate::in_spacetime::{InSpacetime, Joining, Method};
use crate::joined::{Chord, Joined, read_turns};
use crate::packet::{Course, End, NOWHERE, follow};
use crate::taylor::TaylorOrbit;
use bhs_core::Plugin;
use bhs_core::integrator::{Arrival, Connections, Integrator, Ray, Traced};
use bhs_core::lanes::LANES;
use bhs_core::observer::Observer;
use bhs_core::params::Params;
use bhs_core::spacetime::{Place, Side, Spacetime};
use bhs_core::stats::TraceLog;
use bhs_core::world::World;
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
    /// Whether rays between two points are searched in spacetimes other than the plain hole; `None`: where that pays.
    pub connections: Option<bool>,
    joined: Joined,
}

impl Adaptive {
    /// To that tolerance; gives up after so many steps.
    pub fn new(tolerance: Tolerance, max_steps: u64) -> Self {
        Self { tolerance, max_steps, connections: None, joined: Joined { turns: 1, chord: Chord::Tolerance(tolerance) } }
    }
}

/// The integration's share of the tolerance; its error costs little to lower, that of the chords much.
const INTEGRATION: f64 = 0.25;

fn build(p: &Params) -> Option<Box<dyn Integrator>> {
    let tolerance = Tolerance::read(p);
    let max_steps = p.get_in("maxsteps", 100_000, 1..=1_000_000_000, "", "steps after which a ray is given up");
    let made = Adaptive::new(tolerance, max_steps as u64);
    let joined = Joined { turns: read_turns(p), ..made.joined };
    let about = "whether lights are sampled in spacetimes other than the plain hole; by default in wormholes and around a charged hole, not among several holes";
    let connections = p.optional("connections", "", about);
    Some(Box::new(Adaptive { connections, joined, ..made }))
}

impl Integrator for Adaptive {
    fn for_spacetime(&self, spacetime: &Arc<dyn Spacetime>) -> Result<Box<dyn Integrator>, String> {
        let found = || Joining::new(&**spacetime, self.tolerance, self.joined.turns);
        let connections = match self.connections {
            Some(wanted) => wanted.then(found).flatten(),
            None => found().filter(Joining::pays),
        };
        Ok(Box::new(InSpacetime { method: Method::Adaptive(self.tolerance), max_steps: self.max_steps, connections }))
    }

    fn trace(&self, world: &World, ray: &Ray, log: &mut TraceLog) -> Arrival {
        let flight = match Flight::begin(world, ray, log) {
            Ok(flight) => flight,
            Err(arrival) => return arrival,
        };
        let error = self.tolerance.relative(world, ray.footprint, INTEGRATION);
        let orbit = TaylorOrbit::new(flight.hole.rs, flight.start, error);
        let chord = self.tolerance.chord(world, flight.hole, ray.footprint, error);
        flight.follow(orbit, chord, self.max_steps, log)
    }

    fn trace_all(&self, world: &World, rays: &[Ray], traced: &mut [Traced], log: &mut TraceLog) {
        let one = |ray: &Ray, log: &mut TraceLog| {
            let arrival = self.trace(world, ray, log);
            Traced { arrival, phi: log.phi }
        };
        let hole = world.hole.as_ref().filter(|h| h.rs > 0.0 && log.polyline.is_none());
        let Some(hole) = hole else {
            for (ray, traced) in rays.iter().zip(traced) {
                *traced = one(ray, log);
            }
            return;
        };
        // Neighbours mostly have the same footprint.
        let mut known = None;
        let mut precision = |footprint: f64| match known {
            Some((of, chord, error)) if of == footprint => (chord, error),
            _ => {
                let error = self.tolerance.relative(world, footprint, INTEGRATION);
                let chord = self.tolerance.chord(world, hole, footprint, error);
                known = Some((footprint, chord, error));
                (chord, error)
            }
        };
        for (rays, traced) in rays.chunks(LANES).zip(traced.chunks_mut(LANES)) {
            // Lanes without a ray repeat the last one.
            let courses = std::array::from_fn(|i| {
                let ray = &rays[i.min(rays.len() - 1)];
                let (chord, error) = precision(ray.footprint);
                let Ray { origin, direction, leaving, .. } = *ray;
                let is_exact = leaving.is_some();
                Course { from: origin, direction, origin, chord, error, end: f64::INFINITY, target: NOWHERE, is_exact }
            });
            let ends = follow(world, hole, &courses, rays.len(), self.max_steps, log);
            for ((ray, traced), (end, phi)) in rays.iter().zip(traced).zip(ends) {
                let counters = &mut log.counters;
                let arrival = match end {
                    End::Odd => {
                        *traced = one(ray, log);
                        continue;
                    }
                    End::Surface(hit) => Arrival::Surface(hit),
                    End::Sky(direction) => {
                        counters.escaped += 1;
                        Arrival::Sky(direction, Side::Near)
                    }
                    End::Hole => {
                        counters.captured += 1;
                        Arrival::Hole
                    }
                    End::There | End::OutOfSteps => {
                        counters.out_of_steps += 1;
                        Arrival::OutOfSteps
                    }
                };
                counters.geodesics += 1;
                *traced = Traced { arrival, phi };
            }
        }
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
