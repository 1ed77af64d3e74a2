//! `keplerian`: on circular orbits around a hole, as the matter of a thin disc.
//!
//! `Omega = k / (r^2 + a k)`, `k = sqrt(M r - q^2)`, with Boyer and Lindquist's radius r, the areal one without spin (Bardeen, Press and
//! Teukolsky 1972, eq. 2.16; with a charge Dadhich and Kale 1977; `docs/physics.md`, section 5). It turns along `axis x x`, by components, also where
//! the spin is negative: the hole then turns against it. Off the plane of the equator everything turns as fast as in it at the same r. There are no
//! such orbits within that of light; those within the innermost stable one are orbits all the same.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `retrograde` | bool | false | | whether it turns the other way |
//! | `axis` | vector3 | that of the spin, else +y of the world | | what it turns about, under the current transform |
//!
//! ```bhs
//! WorldBegin
//! Spacetime "kerr" "float rs" 2 "float spin" 0.9 "point3 center" [0 0 30]
//! Translate 0 0 30
//! Rotate 90  -1 0 0
//! AreaLightSource "diffuse"
//! Shape "disk" "float radius" 12 "float innerradius" 3 "string motion" "keplerian"
//! ```

use crate::axis;
use bhs_core::Plugin;
use bhs_core::motion::{Motion, Surroundings};
use bhs_core::observer::Observer;
use bhs_core::params::Params;
use bhs_core::spacetime::Spacetime;
use glam::DVec3;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Motion> = Plugin { name: "keplerian", summary: "on circular orbits around a hole", build };

#[derive(Debug)]
struct Keplerian {
    axis: Option<DVec3>,
    /// 1, or -1 the other way.
    sense: f64,
}

fn build(p: &Params) -> Option<Box<dyn Motion>> {
    let retrograde = p.get("retrograde", false, "", "whether it turns the other way");
    Some(Box::new(Keplerian { axis: axis::read(p), sense: if retrograde { -1.0 } else { 1.0 } }))
}

impl Motion for Keplerian {
    fn observer(&self, here: &Surroundings) -> Option<Observer> {
        let hole = here.axial()?;
        let (axis, spin) = axis::around(self.axis, &hole)?;
        let r = hole.radius(here.place.x, axis);
        let k = (hole.mass * r - hole.charge_squared).sqrt();
        let omega = self.sense * k / (r * r + self.sense * spin * hole.a * k);
        here.moving(axis.cross(here.place.x - hole.center) * omega)
    }

    fn fault(&self, spacetime: Option<&dyn Spacetime>) -> Option<String> {
        match spacetime.and_then(Spacetime::axial) {
            None => Some("there are circular orbits around a single hole, round or spinning".to_owned()),
            Some(hole) => axis::around(self.axis, &hole).is_none().then(|| axis::NO_AXIS.to_owned()),
        }
    }
}
