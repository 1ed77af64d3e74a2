//! `rk4`: light around holes and in wormholes, by fixed steps in the swept angle.
//!
//! Classic Runge-Kutta (order 4) on the orbit's equation, `u'' = (3/2) rs u^2 - u` without charge, `u = 1/r`; in a refractive index, on
//! `x'' = grad(n^2)/2`. The chords between steps go to the intersector (order 2: around a hole their sagitta is `(3/16) rs step^2`, at every
//! distance from it), and what they meet is refined to where the curve meets it. With `"string hits" "chord"` it is [`crate::MicroSteps`], the
//! method of the paper.
//! Source: Aikawa, Zhou and Wang 2019, "Diffuse Relativistic Black Hole in the Cornell Box", sections 2 and 3.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `step` | float | 0.1 | rad | angle swept by one step |
//! | `maxsteps` | integer | 100000 | | steps after which a ray is given up |
//! | `hits` | string | "orbit" | | where a ray meets a surface: its `orbit`, or a `chord` of it |
//! | `windings` | integer | 0 | | whole turns around the hole of the longest light that is sampled |
//!
//! ```bhs
//! Integrator "rk4" "float step" 0.05
//! WorldBegin
//! BlackHole "schwarzschild" "point3 center" [0 1 4] "float rs" 0.1
//! ```

use crate::connections::AnyConnections;
use crate::micro_steps::{MicroSteps, read_steps};
use crate::spherical::connections::{Chord, SphericalConnections, read_turns};
use crate::straight::Straight;
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
    Plugin { name: "rk4", summary: "light around holes and in wormholes by fixed Runge-Kutta steps", build };

/// Light by fixed steps.
#[derive(Clone, Debug)]
pub struct Rk4 {
    /// Angle swept by one step, in radians.
    pub step: f64,
    /// Steps after which a ray is given up.
    pub max_steps: u64,
    /// Pairs of geodesics around a centre that light sampling looks for.
    turns: u32,
    connections: Option<AnyConnections>,
}

impl Rk4 {
    /// With steps of that angle (rad); gives up after so many.
    pub fn new(step: f64, max_steps: u64) -> Self {
        let connections = SphericalConnections { turns: 1, chord: Chord::Angle(step) };
        Self { step, max_steps, turns: 1, connections: Some(AnyConnections::Spherical(connections)) }
    }

    fn tracer(&self) -> Tracer {
        Tracer::new(Method::RungeKutta(self.step), self.max_steps)
    }
}

fn build(p: &Params) -> Option<Box<dyn IntegratorBuilder>> {
    let (step, max_steps) = read_steps(p);
    let turns = read_turns(p);
    let about = "where a ray meets a surface: its `orbit`, or a `chord` of it";
    match p.get("hits", "orbit".to_owned(), "", about).as_str() {
        "orbit" => Some(Box::new(Rk4 { turns, ..Rk4::new(step, max_steps) })),
        "chord" => Some(Box::new(MicroSteps::read(p))),
        other => {
            p.reject("hits", "unknown kind of hits", format!("expected `orbit` or `chord`, found `{other}`"));
            None
        }
    }
}

impl IntegratorBuilder for Rk4 {
    fn build(&self, spacetime: &dyn Spacetime) -> Result<Box<dyn Integrator>, String> {
        match spacetime.class() {
            Class::Flat => Ok(Box::new(Straight)),
            Class::Spherical(_) | Class::Kerr(_) | Class::Index(_) => {
                let connections = AnyConnections::new(spacetime, Chord::Angle(self.step), self.turns);
                Ok(Box::new(Self { connections: connections.filter(AnyConnections::pays), ..*self }))
            }
            Class::General(_) => Err(
                "needs a hole, round or spinning, or a spacetime with a refractive index: several extremal holes, or a wormhole"
                    .to_owned(),
            ),
        }
    }
}

impl Integrator for Rk4 {
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
