//! How spacetimes read places and lengths: under the current transform, which must scale alike in all directions.

use bhs_core::diagnostics::Diagnostic;
use bhs_core::params::{Params, Point3};
use bhs_elementary::Elementary;
use glam::{DAffine3, DVec3};

/// From the plugin's coordinates to world space.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    transform: DAffine3,
    scale: f64,
}

impl Placement {
    /// The current transform. It is reported if it scales by unlike factors; then there is no spacetime.
    pub fn of(p: &Params) -> Option<Self> {
        let transform = p.context().world_from_object;
        let scale = uniform_scale(&transform);
        if scale.is_none() {
            p.report(
                Diagnostic::error("bad-transform", format!("the current transform stretches `{}`", p.owner().value))
                    .at(p.owner().span, "lengths of a spacetime scale alike in all directions")
                    .help("put the spacetime outside of the transform, or scale by the same factor in all directions"),
            );
        }
        Some(Self { transform, scale: scale? })
    }

    /// The point `x` in world space.
    pub fn point(&self, x: DVec3) -> DVec3 {
        self.transform.transform_point3(x)
    }

    /// The length `x` in world space.
    pub fn length(&self, x: f64) -> f64 {
        self.scale * x
    }

    /// The world direction of the axis `v` of a rotation (unit length); `None` for no direction. A mirrored rotation turns the other way.
    pub fn axis(&self, v: DVec3) -> Option<DVec3> {
        let sense = self.transform.matrix3.determinant().signum();
        Some(self.transform.transform_vector3(v.try_normalize()?).try_normalize()? * sense)
    }
}

/// The factor by which a transform scales all lengths, if it is the same in all directions.
fn uniform_scale(t: &DAffine3) -> Option<f64> {
    let m = t.matrix3;
    let (x, y, z) = (m.x_axis, m.y_axis, m.z_axis);
    let scale = m.determinant().abs().cube_root();
    let tolerance = 1e-9 * scale * scale;
    let equal = [x, y, z].into_iter().all(|a| (a.length_squared() - scale * scale).abs() <= tolerance);
    let orthogonal = [x.dot(y), y.dot(z), z.dot(x)].into_iter().all(|d| d.abs() <= tolerance);
    (equal && orthogonal && scale > 0.0 && t.is_finite()).then_some(scale)
}

/// The parameter `center`.
pub fn center(p: &Params) -> DVec3 {
    p.get("center", Point3(DVec3::ZERO), "scene", "centre, under the current transform").0
}

/// The required length `name`, which may be 0.
pub fn length(p: &Params, name: &'static str, about: &'static str) -> Option<f64> {
    let length = p.require::<f64>(name, "scene", about)?;
    is_length(p, name, length).then_some(length)
}

/// Whether `length` is finite and not negative. If not, it is reported at the parameter `name`.
pub fn is_length(p: &Params, name: &'static str, length: f64) -> bool {
    if length < 0.0 {
        p.reject(name, format!("`{name}` is negative"), "expected 0 or more");
    } else if !length.is_finite() {
        p.reject(name, format!("`{name}` is out of range"), "expected a finite number");
    }
    (0.0..f64::INFINITY).contains(&length)
}

/// The parameter `charge`: a share of the largest charge that a hole of its mass can have.
pub fn charge(p: &Params) -> f64 {
    p.get_in("charge", 0.0, 0.0..=1.0, "", "charge, as a share of the largest that a hole of this mass can have")
}

/// Whether all of these coordinates and lengths in world space can be computed with. If not, it is reported.
pub fn in_range(p: &Params, places: &[DVec3], lengths: &[f64]) -> bool {
    // Cubes of lengths stay finite, and what is not 0 does not vanish.
    const LARGEST: f64 = 1e75;
    let usable = |x: f64| x.abs() <= LARGEST && (x == 0.0 || x.abs() >= 1.0 / LARGEST);
    let fits = places.iter().all(|x| x.is_finite() && x.abs().max_element() <= LARGEST) && lengths.iter().all(|x| usable(*x));
    if !fits {
        p.report(
            Diagnostic::error("out-of-range", format!("`{}` is out of range", p.owner().value))
                .at(p.owner().span, "a coordinate or a length under the current transform is too large or too small")
                .help("choose a unit of length near the size of the scene"),
        );
    }
    fits
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    #[test]
    fn uniform_scales_are_told_from_others() {
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 30f64.to_radians());
        let t = DAffine3::from_scale(DVec3::new(-2.0, 2.0, 2.0)) * DAffine3::from_quat(turn);
        assert!((uniform_scale(&t).unwrap() - 2.0).abs() < 1e-12);
        assert_eq!(uniform_scale(&DAffine3::from_scale(DVec3::new(1.0, 1.0, 1.1))), None);
    }
}
