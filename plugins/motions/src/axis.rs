//! What turning motions turn about.

use bhs_core::params::{Params, Vector3};
use bhs_core::spacetime::Axial;
use glam::DVec3;

/// Directions that differ by no more than this are the same axis.
const SAME: f64 = 1e-9;

/// The parameter `axis` in world space: `None` if it is not given, or has no direction, which is reported.
pub fn read(p: &Params) -> Option<DVec3> {
    let about = "what it turns about: dx/dt is along `axis x x`; under the current transform. By default the axis of the spin, or +y of the world";
    let Vector3(axis) = p.optional::<Vector3>("axis", "", about)?;
    // What is mirrored turns the other way, as the spin of a hole does.
    let world = p.context().world_from_object;
    let axis = world.transform_vector3(axis).try_normalize().map(|a| a * world.matrix3.determinant().signum());
    if axis.is_none() {
        p.reject("axis", "`axis` has no direction", "expected a vector that is not 0");
    }
    axis
}

/// The axis of a motion around `hole` that states `given`, and the sense of the hole's spin about it, 1 or -1; `None` if they are no axis of one
/// another.
pub fn around(given: Option<DVec3>, hole: &Axial) -> Option<(DVec3, f64)> {
    match (given, hole.axis) {
        (None, axis) => Some((axis.unwrap_or(DVec3::Y), 1.0)),
        (Some(given), None) => Some((given, 1.0)),
        (Some(given), Some(axis)) => {
            let cos = given.dot(axis);
            (cos.abs() > 1.0 - SAME).then(|| (given, cos.signum()))
        }
    }
}

/// Why there is no such axis.
pub const NO_AXIS: &str = "a hole that spins has one axis: leave `axis` out, or give that of the spin";
