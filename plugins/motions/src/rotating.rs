//! `rotating`: turning rigidly about an axis.
//!
//! `dx/dt = omega axis x (x - center)`, by components, in the time of a clock far away, also in flat space (`docs/physics.md`, section 5). Where that
//! would be as fast as light, nothing moves so.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `omega` | float | required | rad/length | angle per time, which is measured as the length that light covers in it, in scene units |
//! | `axis` | vector3 | that of the spin, else +y of the world | | what it turns about, under the current transform |
//! | `center` | point3 | that of the hole, else [0 0 0] | scene | a point of the axis, under the current transform |
//!
//! ```bhs
//! WorldBegin
//! Translate 0 0 4
//! Shape "sphere" "string motion" "rotating" "float omega" 0.5
//! ```

use crate::axis;
use bhs_core::Plugin;
use bhs_core::motion::{Motion, Surroundings};
use bhs_core::observer::Observer;
use bhs_core::params::{Params, Point3};
use glam::DVec3;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Motion> = Plugin { name: "rotating", summary: "turning rigidly about an axis", build };

#[derive(Debug)]
struct Rotating {
    axis: Option<DVec3>,
    /// Angle per time.
    omega: f64,
    /// A point of the axis, if one was given.
    given: Option<DVec3>,
    /// The same where there is no hole.
    center: DVec3,
}

fn build(p: &Params) -> Option<Box<dyn Motion>> {
    let omega = p.require::<f64>("omega", "rad/length", "angle per time, measured as the length that light covers in it")?;
    let about = "a point of the axis, under the current transform; by default the centre of the hole";
    let world = p.context().world_from_object;
    let given = p.optional::<Point3>("center", "scene", about).map(|Point3(center)| world.transform_point3(center));
    if !omega.is_finite() {
        p.reject("omega", "`omega` is not a number", "expected an angle per time");
        return None;
    }
    let center = given.unwrap_or_else(|| world.transform_point3(DVec3::ZERO));
    Some(Box::new(Rotating { axis: axis::read(p), omega, given, center }))
}

impl Motion for Rotating {
    fn observer(&self, here: &Surroundings) -> Option<Observer> {
        let hole = here.axial();
        let axis = match &hole {
            // Matter may turn about any axis, whatever the hole does.
            Some(hole) => self.axis.or(hole.axis),
            None => self.axis,
        };
        let center = self.given.or(hole.map(|hole| hole.center)).unwrap_or(self.center);
        here.moving(axis.unwrap_or(DVec3::Y).cross(here.place.x - center) * self.omega)
    }

    fn is_static(&self) -> bool {
        self.omega == 0.0
    }

    fn rebase(&mut self, origin: DVec3) {
        self.center -= origin;
        self.given = self.given.map(|center| center - origin);
    }
}
