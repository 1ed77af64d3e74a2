//! `general`: light in any spacetime, by Hamilton's equations.
//!
//! Knows nothing of a spacetime but its metric (lapse, spatial metric, rotation, and their derivatives): one ray at a time, with error control. Slow, and
//! right wherever the metric is: the measure of all other integrators, and the only one for spacetimes that give no more than that. Offers no
//! geodesics for light sampling.
//!
//! `general/hamilton` has the equations, `path` the steps, `escape` says where rays go that leave: these know no surfaces; `course` is a ray
//! among them.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `tolerance` | float | a tenth of the ray's footprint | scene | largest distance between the true ray and what is traced |
//! | `maxsteps` | integer | 100000 | | steps after which a ray is given up |
//!
//! ```bhs
//! Integrator "general" "float tolerance" 1e-4
//! WorldBegin
//! BlackHole "schwarzschild" "point3 center" [0 1 4] "float rs" 0.1
//! ```

pub mod course;
mod escape;
pub mod hamilton;
pub mod path;

pub use path::{Advance, Fate, Paths, Surroundings};

use crate::tolerance::{STEPS, Tolerance, read_max_steps};
use crate::tracer::{Method, Tracer};
use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_core::ray::{Ray, RayEnd};
use bhs_core::spacetime::Spacetime;
use bhs_engine::connections::Connections;
use bhs_engine::integrator::{Integrator, IntegratorBuilder};
use bhs_engine::way::Watch;
use bhs_engine::world::World;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn IntegratorBuilder> =
    Plugin { name: "general", summary: "light in any spacetime by Hamilton's equations", build };

/// Light in any spacetime by Hamilton's equations.
#[derive(Clone, Copy, Debug)]
pub struct General(Tracer);

impl General {
    /// To that tolerance; gives up after so many steps.
    pub fn new(tolerance: Tolerance, max_steps: u64) -> Self {
        Self(Tracer::new(Method::General(tolerance), max_steps))
    }
}

fn build(p: &Params) -> Option<Box<dyn IntegratorBuilder>> {
    let tolerance = Tolerance::read(p);
    let max_steps = read_max_steps(p, STEPS);
    Some(Box::new(General::new(tolerance, max_steps)))
}

impl IntegratorBuilder for General {
    fn build(&self, _: &dyn Spacetime) -> Result<Box<dyn Integrator>, String> {
        Ok(Box::new(*self))
    }
}

impl Integrator for General {
    fn trace_all(&self, world: &World, rays: &[Ray], ends: &mut [RayEnd]) {
        self.0.trace_all(world, rays, ends);
    }

    fn trace_forwards(&self, world: &World, rays: &[Ray], ends: &mut [RayEnd]) {
        self.0.forwards().trace_all(world, rays, ends);
    }

    fn watched(&self, world: &World, ray: &Ray, watch: &mut dyn Watch) -> RayEnd {
        self.0.watched(world, ray, watch)
    }

    fn connections(&self) -> Option<&dyn Connections> {
        None
    }
}
