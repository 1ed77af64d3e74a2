//! `adaptive`: light in any spacetime, as precise as it is asked to be.
//!
//! Around a hole, charged or not, by Taylor series of the orbit, two or three steps a ray; among several extremal holes and in wormholes by their
//! refractive index; in all other spacetimes by Hamilton's equations. Chords of the curve go to the intersector. Both keep within `tolerance`
//! together: at most a quarter of it is the integration's, and never more than a relative error of 1e-6; the rest is the chords'.
//! What the chords meet is refined to where the curve meets the surface: what is left to the tolerance is which surface is met.
//! Rays that come together are followed side by side. The default where something bends light.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `tolerance` | float | a tenth of the ray's footprint | scene | largest distance between the true ray and what is traced |
//! | `maxsteps` | integer | 100000 | | steps after which a ray is given up |
//! | `connections` | bool | false | | whether lights are sampled in wormholes and among several holes, where the rays to them take long to find |
//! | `windings` | integer | 0 | | whole turns around the hole of the longest light that is sampled |
//!
//! ```bhs
//! Integrator "adaptive" "float tolerance" 1e-4
//! WorldBegin
//! BlackHole "schwarzschild" "point3 center" [0 1 4] "float rs" 0.1
//! ```

use crate::graded_index::connect::GradedConnections;
use crate::spherical::connections::{Chord, SphericalConnections, read_turns};
use crate::straight::Straight;
use crate::tolerance::Tolerance;
use crate::tracer::{Method, Tracer};
use bhs_core::Plugin;
use bhs_core::integrator::{Connections, Integrator, IntegratorBuilder, Ray, RayEnd};
use bhs_core::params::Params;
use bhs_core::spacetime::{Class, Spacetime};
use bhs_core::world::World;
use glam::DVec3;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn IntegratorBuilder> =
    Plugin { name: "adaptive", summary: "light in any spacetime to a given tolerance, by what suits it best", build };

/// Light to a given tolerance.
#[derive(Clone, Copy, Debug)]
pub struct Adaptive {
    /// Largest distance between the true ray and what is traced.
    pub tolerance: Tolerance,
    /// Steps after which a ray is given up.
    pub max_steps: u64,
    /// Whether rays between two points are searched in spacetimes where that takes long.
    pub connections: bool,
    /// Pairs of geodesics around a hole that light sampling looks for.
    turns: u32,
    offered: Offered,
}

/// The rays between two points that are offered for light sampling.
#[derive(Clone, Copy, Debug)]
enum Offered {
    Nothing,
    Spherical(SphericalConnections),
    Graded(GradedConnections),
}

impl Adaptive {
    /// To that tolerance; gives up after so many steps. Offers rays between two points around a hole without charge, until it is built for another
    /// spacetime.
    pub fn new(tolerance: Tolerance, max_steps: u64) -> Self {
        let offered = Offered::Spherical(SphericalConnections { turns: 1, chord: Chord::Tolerance(tolerance) });
        Self { tolerance, max_steps, connections: false, turns: 1, offered }
    }

    fn tracer(&self) -> Tracer {
        Tracer { method: Method::Adaptive(self.tolerance), max_steps: self.max_steps }
    }

    fn offered_in(&self, spacetime: &dyn Spacetime) -> Offered {
        let Self { tolerance, turns, .. } = *self;
        match spacetime.class() {
            Class::Spherical(hole) if hole.charge_squared == 0.0 => {
                Offered::Spherical(SphericalConnections { turns, chord: Chord::Tolerance(tolerance) })
            }
            Class::Index(_) if self.connections => {
                GradedConnections::new(spacetime, tolerance).map_or(Offered::Nothing, Offered::Graded)
            }
            _ => Offered::Nothing,
        }
    }
}

fn build(p: &Params) -> Option<Box<dyn IntegratorBuilder>> {
    let tolerance = Tolerance::read(p);
    let max_steps = p.get_in("maxsteps", 100_000, 1..=1_000_000_000, "", "steps after which a ray is given up");
    let turns = read_turns(p);
    let about = "whether lights are sampled in wormholes and among several holes, where the rays to them take long to find";
    let connections = p.get("connections", false, "", about);
    Some(Box::new(Adaptive { connections, turns, ..Adaptive::new(tolerance, max_steps as u64) }))
}

impl IntegratorBuilder for Adaptive {
    fn build(&self, spacetime: &dyn Spacetime) -> Result<Box<dyn Integrator>, String> {
        if matches!(spacetime.class(), Class::Flat) {
            return Ok(Box::new(Straight));
        }
        Ok(Box::new(Self { offered: self.offered_in(spacetime), ..*self }))
    }
}

impl Integrator for Adaptive {
    fn trace_all(&self, world: &World, rays: &[Ray], ends: &mut [RayEnd]) {
        self.tracer().trace_all(world, rays, ends);
    }

    fn polyline(&self, world: &World, ray: &Ray) -> (RayEnd, Vec<DVec3>) {
        self.tracer().polyline(world, ray)
    }

    fn connections(&self) -> Option<&dyn Connections> {
        match &self.offered {
            Offered::Nothing => None,
            Offered::Spherical(connections) => Some(connections),
            Offered::Graded(connections) => Some(connections),
        }
    }
}
