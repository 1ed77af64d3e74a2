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

use crate::graded_index::connect::GradedConnections;
use crate::spherical::connections::{Chord, SphericalConnections, read_turns};
use crate::tolerance::Tolerance;
use crate::tracer::{Method, Tracer};
use bhs_core::Plugin;
use bhs_core::integrator::{Connections, Integrator, Ray, RayEnd};
use bhs_core::observer::Observer;
use bhs_core::params::Params;
use bhs_core::spacetime::{Place, Spacetime};
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
    offered: Offered,
}

impl Adaptive {
    /// To that tolerance; gives up after so many steps.
    pub fn new(tolerance: Tolerance, max_steps: u64) -> Self {
        let offered = Offered::Spherical(SphericalConnections { turns: 1, chord: Chord::Tolerance(tolerance) });
        Self { tolerance, max_steps, connections: false, offered }
    }
}

/// The rays between two points that are offered for light sampling.
#[derive(Clone, Copy, Debug)]
enum Offered {
    Nothing,
    Spherical(SphericalConnections),
    Graded(GradedConnections),
}

fn build(p: &Params) -> Option<Box<dyn Integrator>> {
    let tolerance = Tolerance::read(p);
    let max_steps = p.get_in("maxsteps", 100_000, 1..=1_000_000_000, "", "steps after which a ray is given up");
    let made = Adaptive::new(tolerance, max_steps as u64);
    let offered = Offered::Spherical(SphericalConnections { turns: read_turns(p), chord: Chord::Tolerance(tolerance) });
    let about = "whether lights are sampled in wormholes and among several holes, where the rays to them take long to find";
    let connections = p.get("connections", false, "", about);
    Some(Box::new(Adaptive { connections, offered, ..made }))
}

impl Adaptive {
    fn tracer(&self) -> Tracer {
        Tracer { method: Method::Adaptive(self.tolerance), max_steps: self.max_steps }
    }
}

impl Integrator for Adaptive {
    fn for_spacetime(&self, spacetime: &Arc<dyn Spacetime>) -> Result<Box<dyn Integrator>, String> {
        let graded = if self.connections { GradedConnections::new(&**spacetime, self.tolerance) } else { None };
        Ok(Box::new(Self { offered: graded.map_or(Offered::Nothing, Offered::Graded), ..*self }))
    }

    fn trace_all(&self, world: &World, rays: &[Ray], ends: &mut [RayEnd]) {
        self.tracer().trace_all(world, rays, ends);
    }

    fn polyline(&self, world: &World, ray: &Ray) -> (RayEnd, Vec<DVec3>) {
        self.tracer().polyline(world, ray)
    }

    fn observer(&self, world: &World, place: Place) -> Option<Observer> {
        world.static_observer(place)
    }

    fn connections(&self) -> Option<&dyn Connections> {
        match &self.offered {
            Offered::Nothing => None,
            Offered::Spherical(connections) => Some(connections),
            Offered::Graded(connections) => Some(connections),
        }
    }

    fn is_curved(&self) -> bool {
        true
    }
}
