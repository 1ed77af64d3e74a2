//! `zamo`: dragged along with space, without angular momentum (zero angular momentum observer).
//!
//! To such an observer light that comes and goes with the spin and against it is alike. There is one everywhere outside of horizons, also in
//! ergospheres, where nothing can stand still. Where nothing spins, it is at rest (`docs/physics.md`, section 5).
//!
//! ```bhs
//! Camera "perspective" "string motion" "zamo"
//! WorldBegin
//! Spacetime "kerr" "float rs" 0.5 "float spin" 0.9 "point3 center" [0 0 3]
//! ```

use bhs_core::Plugin;
use bhs_core::motion::{Motion, Surroundings};
use bhs_core::observer::Observer;
use bhs_core::params::Params;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Motion> =
    Plugin { name: "zamo", summary: "dragged along with space, without angular momentum; also in ergospheres", build };

#[derive(Debug)]
struct Zamo;

fn build(_: &Params) -> Option<Box<dyn Motion>> {
    Some(Box::new(Zamo))
}

impl Motion for Zamo {
    fn observer(&self, here: &Surroundings) -> Option<Observer> {
        here.normal().map(|normal| here.conventions.normal_observer(&normal))
    }
}
