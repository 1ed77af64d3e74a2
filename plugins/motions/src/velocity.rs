//! `velocity`: a constant velocity against the static observer of the place, as that one measures it.
//!
//! Directions are aberrated and wavelengths shifted by the Doppler effect (`docs/physics.md`, section 2).
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `velocity` | vector3 | [0 0 0] | c | velocity against the static observer, along right, up and ahead; less than 1 |
//!
//! ```bhs
//! Camera "perspective" "vector3 velocity" [0 0 0.5]
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::motion::{Motion, Surroundings};
use bhs_core::observer::Observer;
use bhs_core::params::{Params, Vector3};
use glam::DVec3;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Motion> =
    Plugin { name: "velocity", summary: "a constant velocity against the static observer of the place", build };

#[derive(Debug)]
struct Velocity {
    /// In the frame of the static observer along the axes of the chart (units of c, less than 1).
    velocity: DVec3,
}

fn build(p: &Params) -> Option<Box<dyn Motion>> {
    let about = "velocity against the static observer, along right, up and ahead; less than 1";
    let Vector3(v) = p.get("velocity", Vector3(DVec3::ZERO), "c", about);
    if v.length_squared() >= 1.0 || v.is_nan() {
        p.reject("velocity", "nothing is as fast as light", "its length is 1 or more");
        return None;
    }
    // The axes of what moves, whatever its size: a mirrored one mirrors the velocity too.
    let axes = p.context().world_from_object.matrix3;
    let velocity = [(axes.x_axis, v.x), (axes.y_axis, v.y), (axes.z_axis, v.z)].map(|(axis, v)| axis.normalize_or_zero() * v);
    Some(Box::new(Velocity { velocity: velocity.into_iter().sum() }))
}

impl Motion for Velocity {
    fn observer(&self, here: &Surroundings) -> Option<Observer> {
        here.stationary().map(|metric| here.conventions.observer(&metric).moving_where(metric.beta, self.velocity))
    }

    fn is_static(&self) -> bool {
        self.velocity == DVec3::ZERO
    }
}
