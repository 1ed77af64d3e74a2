//! `schwarzschild-adaptive`: light around a Schwarzschild hole, as precise as it is asked to be.
//!
//! Taylor series of the orbit, two or three steps a ray (`taylor.rs`), between which chords go to the intersector. Both keep within
//! `tolerance` together: a quarter of it is the integration's, the rest the chords'. What the chords meet is refined to where
//! the orbit meets the surface.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `tolerance` | float | 1e-4 of the scene's diagonal | scene | largest distance between the true ray and what is traced |
//! | `maxsteps` | integer | 100000 | | steps after which a ray is given up |
//!
//! ```bhs
//! Integrator "schwarzschild-adaptive" "float tolerance" 1e-4
//! WorldBegin
//! BlackHole "schwarzschild" "point3 center" [0 1 4] "float rs" 0.1
//! ```

use crate::flight::{Flight, Tolerance, static_observer};
use crate::taylor::TaylorOrbit;
use bhs_core::Plugin;
use bhs_core::blackhole::Observer;
use bhs_core::integrator::{Arrival, Connections, Integrator, Ray};
use bhs_core::params::Params;
use bhs_core::stats::TraceLog;
use bhs_core::world::World;
use glam::DVec3;

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
}

/// The integration's share of the tolerance; its error costs little to lower, that of the chords much.
const INTEGRATION: f64 = 0.25;

fn build(p: &Params) -> Option<Box<dyn Integrator>> {
    let tolerance = Tolerance::read(p);
    let max_steps = p.get_in("maxsteps", 100_000, 1..=1_000_000_000, "", "steps after which a ray is given up");
    Some(Box::new(Adaptive { tolerance, max_steps: max_steps as u64 }))
}

impl Integrator for Adaptive {
    fn trace(&self, world: &World, ray: &Ray, log: &mut TraceLog) -> Arrival {
        let flight = match Flight::begin(world, ray, log) {
            Ok(flight) => flight,
            Err(arrival) => return arrival,
        };
        let orbit = TaylorOrbit::new(flight.hole.rs, flight.start, self.tolerance.relative(&flight, INTEGRATION));
        let chord = self.tolerance.chord(&flight, 1.0 - INTEGRATION);
        flight.follow(orbit, chord, self.max_steps, log)
    }

    fn observer(&self, world: &World, point: DVec3) -> Option<Observer> {
        static_observer(world, point)
    }

    fn connections(&self) -> Option<&dyn Connections> {
        None
    }

    fn is_curved(&self) -> bool {
        true
    }
}
