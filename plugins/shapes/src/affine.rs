//! Images of surfaces under the current transform.

use crate::ellipsoid::cofactors;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::params::Params;
use bhs_elementary::Elementary;
use glam::{DMat3, DVec3};
use std::f64::consts::TAU;

/// Where a surface stands: `center + world_from_own p` for the points p of its own coordinates.
pub(crate) struct Affine {
    pub center: DVec3,
    pub world_from_own: DMat3,
    pub own_from_world: DMat3,
    /// Takes a unit normal on its outer side to a normal whose length is the stretch of area there.
    outward: DMat3,
}

impl Affine {
    /// The current transform after a stretch along the axes; `None` after a report that it cannot be used.
    pub(crate) fn new(p: &Params, stretch: DVec3) -> Option<Self> {
        let to_world = p.context().world_from_object;
        let world_from_own = to_world.matrix3 * DMat3::from_diagonal(stretch);
        let own_from_world = world_from_own.inverse();
        let c = cofactors(world_from_own);
        let in_range = to_world.translation.is_finite() && own_from_world.is_finite() && c.is_finite();
        if !in_range || c.determinant() == 0.0 {
            let message = format!("the current transform flattens the {}, or is out of range", p.owner().value);
            p.report(Diagnostic::error("bad-transform", message).at(p.owner().span, ""));
            return None;
        }
        // As in pbrt, the outer side is the transform of the object's own, mirrored or not.
        let inverts = (world_from_own.determinant() < 0.0) != p.context().reverse_orientation;
        let outward = if inverts { -c } else { c };
        Some(Self { center: to_world.translation, world_from_own, own_from_world, outward })
    }

    pub(crate) fn point_to_own(&self, point: DVec3) -> DVec3 {
        self.own_from_world * (point - self.center)
    }

    pub(crate) fn point_to_world(&self, own: DVec3) -> DVec3 {
        self.center + self.world_from_own * own
    }

    /// The unit normal in the world of a unit normal here, on the outer side.
    pub(crate) fn normal(&self, own: DVec3) -> DVec3 {
        (self.outward * own).normalize()
    }

    /// How much larger areas are in the world where the unit normal here is `own`.
    pub(crate) fn area_factor(&self, own: DVec3) -> f64 {
        (self.outward * own).length()
    }

    /// Half the sides of a box (own axes) that holds the box of the half sides `half` (world axes).
    pub(crate) fn half_to_own(&self, half: DVec3) -> DVec3 {
        let m = self.own_from_world;
        m.x_axis.abs() * half.x + m.y_axis.abs() * half.y + m.z_axis.abs() * half.z
    }
}

/// The parameter `phimax` in radians; `None` after a report.
pub(crate) fn phi_max(p: &Params) -> Option<f64> {
    let degrees = p.get("phimax", 360.0, "degrees", "the part at greater azimuth is left out");
    if !(0.0 < degrees && degrees <= 360.0) {
        p.reject("phimax", "`phimax` must be above 0 and at most 360", "");
        return None;
    }
    Some(if degrees < 360.0 { degrees.to_radians() } else { TAU })
}

/// The angle around z, from 0 to 2 pi.
pub(crate) fn azimuth(p: DVec3) -> f64 {
    let phi = p.y.arctangent2(p.x);
    if phi < 0.0 { phi + TAU } else { phi }
}
