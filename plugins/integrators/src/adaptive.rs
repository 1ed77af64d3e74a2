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
//! | `connections` | bool | by spacetime | | whether lights are sampled in spacetimes other than the plain hole: by default, around one centre |
//! | `windings` | integer | 0 | | whole turns around the hole of the longest light that is sampled |
//!
//! ```bhs
//! Integrator "adaptive" "float tolerance" 1e-4
//! WorldBegin
//! BlackHole "schwarzschild" "point3 center" [0 1 4] "float rs" 0.1
//! ```

use crate::connections::AnyConnections;
use crate::spherical::connections::{Chord, SphericalConnections, read_turns};
use crate::straight::Straight;
use crate::tolerance::{STEPS, Tolerance, read_max_steps};
use crate::tracer::{Method, Tracer};
use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_core::ray::{Ray, RayEnd};
use bhs_core::spacetime::{Class, Spacetime};
use bhs_engine::connections::Connections;
use bhs_engine::integrator::{Integrator, IntegratorBuilder};
use bhs_engine::way::Watch;
use bhs_engine::world::World;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn IntegratorBuilder> =
    Plugin { name: "adaptive", summary: "light in any spacetime to a given tolerance, by what suits it best", build };

/// Light to a given tolerance.
#[derive(Clone, Debug)]
pub struct Adaptive {
    /// Largest distance between the true ray and what is traced.
    pub tolerance: Tolerance,
    /// Steps after which a ray is given up.
    pub max_steps: u64,
    /// Whether lights are sampled in spacetimes other than the plain hole; `None`: where that pays.
    pub light_sampling: Option<bool>,
    /// Pairs of geodesics around a centre that light sampling looks for.
    turns: u32,
    connections: Option<AnyConnections>,
}

impl Adaptive {
    /// To that tolerance; gives up after so many steps. Offers rays between two points around a hole without charge, until it is built for another
    /// spacetime.
    pub fn new(tolerance: Tolerance, max_steps: u64) -> Self {
        let connections = SphericalConnections { turns: 1, chord: Chord::Tolerance(tolerance) };
        let connections = Some(AnyConnections::Spherical(connections));
        Self { tolerance, max_steps, light_sampling: None, turns: 1, connections }
    }

    fn tracer(&self) -> Tracer {
        Tracer::new(Method::Adaptive(self.tolerance), self.max_steps)
    }
}

fn build(p: &Params) -> Option<Box<dyn IntegratorBuilder>> {
    let tolerance = Tolerance::read(p);
    let max_steps = read_max_steps(p, STEPS);
    let turns = read_turns(p);
    let about = "whether lights are sampled in spacetimes other than the plain hole; by default in wormholes and around one hole, not among several";
    let light_sampling = p.optional("connections", "", about);
    Some(Box::new(Adaptive { light_sampling, turns, ..Adaptive::new(tolerance, max_steps) }))
}

impl IntegratorBuilder for Adaptive {
    fn build(&self, spacetime: &dyn Spacetime) -> Result<Box<dyn Integrator>, String> {
        if matches!(spacetime.class(), Class::Flat) {
            return Ok(Box::new(Straight));
        }
        let found = AnyConnections::new(spacetime, Chord::Tolerance(self.tolerance), self.turns);
        let is_wanted = |found: &AnyConnections| match found {
            AnyConnections::Spherical(_) => true,
            other => self.light_sampling.unwrap_or_else(|| other.pays()),
        };
        Ok(Box::new(Self { connections: found.filter(is_wanted), ..*self }))
    }
}

impl Integrator for Adaptive {
    fn trace_all(&self, world: &World, rays: &[Ray], ends: &mut [RayEnd]) {
        self.tracer().trace_all(world, rays, ends);
    }

    fn trace_forwards(&self, world: &World, rays: &[Ray], ends: &mut [RayEnd]) {
        self.tracer().forwards().trace_all(world, rays, ends);
    }

    fn watched(&self, world: &World, ray: &Ray, watch: &mut dyn Watch) -> RayEnd {
        self.tracer().watched(world, ray, watch)
    }

    fn connections(&self) -> Option<&dyn Connections> {
        self.connections.as_ref().map(AnyConnections::offered)
    }
}
