//! `schwarzschild-rk4`: light around a Schwarzschild hole, by fixed steps in the swept angle.
//!
//! Classic Runge-Kutta (order 4) on `u'' = (3/2) rs u^2 - u`, `u = 1/r`; the chords between steps go to the intersector
//! (order 2: their sagitta is `(3/16) rs step^2`, at every distance from the hole), and what they meet is refined to where the
//! orbit meets it; where nothing is near, several steps make one chord. With `"string hits" "chord"` every step is a question and what
//! its chord meets counts as it is (order 2): that is the method of the paper, which has the name `micro-steps` too. Ends on a surface, in the sky or behind the horizon, after as many windings as the orbit makes. The
//! default in a scene with a hole.
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
//! Integrator "schwarzschild-rk4" "float step" 0.05
//! WorldBegin
//! BlackHole "schwarzschild" "point3 center" [0 1 4] "float rs" 0.1
//! ```

use crate::flight::{Flight, Tolerance};
use crate::in_spacetime::{InSpacetime, Joining, Method};
use crate::joined::{Chord, Joined, read_turns};
use crate::micro_steps;
use crate::orbit::Rk4Orbit;
use crate::straight::Straight;
use bhs_core::Plugin;
use bhs_core::integrator::{Arrival, Connections, Integrator, Ray};
use bhs_core::observer::Observer;
use bhs_core::params::Params;
use bhs_core::spacetime::{Class, Place, Spacetime};
use bhs_core::stats::TraceLog;
use bhs_core::world::World;
use std::sync::Arc;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Integrator> =
    Plugin { name: "schwarzschild-rk4", summary: "light around a Schwarzschild hole by fixed Runge-Kutta steps", build };

/// Light around a Schwarzschild hole by fixed steps.
#[derive(Clone, Copy, Debug)]
pub struct Rk4 {
    /// Angle swept by one step, in radians.
    pub step: f64,
    /// Steps after which a ray is given up.
    pub max_steps: u64,
    hits: Hits,
    joined: Joined,
}

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Hits {
    /// Where its orbit does.
    Orbit,
    /// Where the chord of a step does.
    Chord,
}

impl Rk4 {
    /// With steps of that angle (rad); gives up after so many.
    pub fn new(step: f64, max_steps: u64) -> Self {
        Self { step, max_steps, hits: Hits::Orbit, joined: Joined { turns: 1, chord: Chord::Angle(step) } }
    }

    /// With the parameters `step` and `maxsteps`.
    fn read(p: &Params) -> Self {
        let step = p.get_in("step", 0.1, 1e-6..=0.5, "rad", "angle swept by one step");
        let max_steps = p.get_in("maxsteps", 100_000, 1..=1_000_000_000, "", "steps after which a ray is given up");
        Self::new(step, max_steps as u64)
    }

    /// The same, but hits are where a chord meets a surface: the method of Aikawa, Zhou and Wang 2019.
    pub fn micro_steps(step: f64, max_steps: u64) -> Self {
        Self { hits: Hits::Chord, ..Self::new(step, max_steps) }
    }
}

fn build(p: &Params) -> Option<Box<dyn Integrator>> {
    let made = Rk4::read(p);
    let hits =
        match p.get("hits", "orbit".to_owned(), "", "where a ray meets a surface: its `orbit`, or a `chord` of it").as_str() {
            "orbit" => Hits::Orbit,
            "chord" => Hits::Chord,
            other => {
                p.reject("hits", "unknown kind of hits", format!("expected `orbit` or `chord`, found `{other}`"));
                return None;
            }
        };
    Some(Box::new(Rk4 { hits, joined: Joined { turns: read_turns(p), ..made.joined }, ..made }))
}

/// What `micro-steps` makes.
pub(crate) fn build_micro_steps(p: &Params) -> Option<Box<dyn Integrator>> {
    let made = Rk4::read(p);
    Some(Box::new(Rk4 { hits: Hits::Chord, joined: Joined { turns: read_turns(p), ..made.joined }, ..made }))
}

impl Integrator for Rk4 {
    fn for_spacetime(&self, spacetime: &Arc<dyn Spacetime>) -> Result<Box<dyn Integrator>, String> {
        let of_chords = self.hits == Hits::Chord;
        match spacetime.class() {
            Class::Flat => Ok(Box::new(Straight)),
            _ if of_chords => {
                Err("needs a spherical spacetime without charge, for its steps are those of a published method".to_owned())
            }
            Class::Spherical(_) | Class::Index(_) => {
                let found = Joining::new(&**spacetime, Tolerance::DEFAULT, self.joined.turns);
                let connections = found.filter(Joining::pays);
                Ok(Box::new(InSpacetime { method: Method::RungeKutta(self.step), max_steps: self.max_steps, connections }))
            }
            Class::General(_) => {
                Err("needs a spherical spacetime, or one with a refractive index: several extremal holes, or a wormhole"
                    .to_owned())
            }
        }
    }

    fn trace(&self, world: &World, ray: &Ray, log: &mut TraceLog) -> Arrival {
        if self.hits == Hits::Chord {
            return micro_steps::follow(world, ray, self.step, self.max_steps, log);
        }
        let flight = match Flight::begin(world, ray, log) {
            Ok(flight) => flight,
            Err(arrival) => return arrival,
        };
        // One chord a step.
        let orbit = Rk4Orbit { hole: flight.hole.rs.into(), step: self.step, state: flight.start };
        flight.follow(orbit, f64::INFINITY, self.max_steps, log)
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
