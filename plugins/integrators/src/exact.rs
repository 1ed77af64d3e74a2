//! `exact`: light around a Schwarzschild hole in closed form, without steps.
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
//! Integrator "exact" "float tolerance" 1e-5
//! WorldBegin
//! BlackHole "schwarzschild" "point3 center" [0 1 4] "float rs" 0.1
//! ```

use crate::spherical::connections::{Chord, SphericalConnections, read_turns};
use crate::straight::Straight;
use crate::tolerance::{Tolerance, read_max_steps};
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
    Plugin { name: "exact", summary: "light around a Schwarzschild hole by elliptic functions", build };

/// Light around a Schwarzschild hole in closed form.
#[derive(Clone, Copy, Debug)]
pub struct Exact {
    /// Largest distance between the true ray and its chords.
    pub tolerance: Tolerance,
    /// Stretches of 1 rad after which a ray is given up.
    pub max_steps: u64,
    connections: SphericalConnections,
}

impl Exact {
    /// To that tolerance; gives up after so many steps.
    pub fn new(tolerance: Tolerance, max_steps: u64) -> Self {
        let connections = SphericalConnections { turns: 1, chord: Chord::Tolerance(tolerance) };
        Self { tolerance, max_steps, connections }
    }

    fn tracer(&self) -> Tracer {
        Tracer::new(Method::Exact(self.tolerance), self.max_steps)
    }
}

fn build(p: &Params) -> Option<Box<dyn IntegratorBuilder>> {
    let tolerance = Tolerance::read(p);
    let max_steps = read_max_steps(p, "stretches of 1 rad after which a ray is given up");
    let connections = SphericalConnections { turns: read_turns(p), chord: Chord::Tolerance(tolerance) };
    Some(Box::new(Exact { tolerance, max_steps, connections }))
}

impl IntegratorBuilder for Exact {
    fn build(&self, spacetime: &dyn Spacetime) -> Result<Box<dyn Integrator>, String> {
        match spacetime.class() {
            Class::Flat => Ok(Box::new(Straight)),
            Class::Spherical(hole) if hole.charge_squared == 0.0 => Ok(Box::new(*self)),
            _ => {
                Err("needs a spherical spacetime without charge, for its elliptic functions are those of one such hole"
                    .to_owned())
            }
        }
    }
}

impl Integrator for Exact {
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
        Some(&self.connections)
    }
}
