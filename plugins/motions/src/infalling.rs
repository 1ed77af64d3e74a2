//! `infalling`: falling freely into a hole, from rest far away.
//!
//! Energy 1 a mass, no angular momentum, at a constant polar angle: against the observer who is dragged with space it moves inwards with
//! `sqrt(1 - alpha^2)` (`docs/physics.md`, section 5). It comes down to the horizon, not through it.
//!
//! ```bhs
//! Camera "perspective" "string motion" "infalling"
//! WorldBegin
//! BlackHole "schwarzschild" "float rs" 0.5 "point3 center" [0 0 3]
//! ```

use bhs_core::Plugin;
use bhs_core::motion::{Motion, Surroundings};
use bhs_core::observer::Observer;
use bhs_core::params::Params;
use bhs_core::spacetime::Spacetime;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Motion> =
    Plugin { name: "infalling", summary: "falling freely into a hole, from rest far away", build };

#[derive(Debug)]
struct Infalling;

fn build(_: &Params) -> Option<Box<dyn Motion>> {
    Some(Box::new(Infalling))
}

impl Motion for Infalling {
    fn observer(&self, here: &Surroundings) -> Option<Observer> {
        let (hole, normal) = (here.axial()?, here.normal()?);
        let speed = (1.0 - normal.lapse * normal.lapse).max(0.0).sqrt();
        let inwards = normal.root.local_direction(-hole.outward(here.place.x));
        (speed < 1.0).then(|| here.conventions.normal_observer(&normal).moving(inwards * speed))
    }

    fn fault(&self, spacetime: Option<&dyn Spacetime>) -> Option<String> {
        spacetime
            .and_then(Spacetime::axial)
            .is_none()
            .then(|| "there is no single hole, round or spinning, to fall into".to_owned())
    }
}
