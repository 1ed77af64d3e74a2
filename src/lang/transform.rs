//! The transforms of the language, with pbrt's conventions: left-handed world, column vectors, a directive multiplies the
//! current transform from the right.

use bhs_elementary::rotation;
use glam::{DAffine3, DMat3, DVec3};

/// Rotation by `degrees` around `axis`, which is not zero.
pub fn rotate(degrees: f64, axis: DVec3) -> Option<DAffine3> {
    Some(DAffine3::from_mat3(rotation(axis.try_normalize()?, degrees.to_radians())))
}

/// The camera's view: camera space has its origin at `eye`, +z towards `target`, and `up` in the half plane of +y and z.
/// Takes world space to camera space. `None` if the three do not span a view.
pub fn look_at(eye: DVec3, target: DVec3, up: DVec3) -> Option<DAffine3> {
    let forward = (target - eye).try_normalize()?;
    let across = up.try_normalize()?.cross(forward);
    // Up along the view: rounding alone would choose the picture's orientation.
    if across.length() < 1e-10 {
        return None;
    }
    let right = across.normalize();
    let world_from_camera = DAffine3::from_mat3_translation(DMat3::from_cols(right, forward.cross(right), forward), eye);
    Some(world_from_camera.inverse())
}

/// Why sixteen numbers are no transform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NotAffine {
    /// The fourth row is not 0 0 0 1.
    Projective,
    /// It flattens space.
    Singular,
}

/// The transform with the given 4x4 matrix, column after column: the translation is in elements 12 to 14.
///
/// # Errors
/// If it cannot be used as a transform of a scene.
pub fn matrix(m: &[f64; 16]) -> Result<DAffine3, NotAffine> {
    let column = |i: usize| DVec3::new(m[4 * i], m[4 * i + 1], m[4 * i + 2]);
    if m[3] != 0.0 || m[7] != 0.0 || m[11] != 0.0 || m[15] == 0.0 {
        // A translation in the last *row* is the usual mistake.
        return Err(NotAffine::Projective);
    }
    let w = m[15];
    let t = DAffine3::from_mat3_translation(DMat3::from_cols(column(0) / w, column(1) / w, column(2) / w), column(3) / w);
    if is_invertible(&t) { Ok(t) } else { Err(NotAffine::Singular) }
}

/// Whether the transform is finite and has a finite inverse.
pub fn is_invertible(t: &DAffine3) -> bool {
    t.is_finite() && t.matrix3.determinant().is_normal() && t.inverse().is_finite()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn look_at_is_pbrts() {
        let t = look_at(DVec3::new(1.0, 2.0, 3.0), DVec3::new(1.0, 2.0, 8.0), DVec3::Y).unwrap();
        // Left-handed: looking along +z with +y up, +x is on the right.
        assert!((t.transform_point3(DVec3::new(2.0, 2.5, 5.0)) - DVec3::new(1.0, 0.5, 2.0)).length() < 1e-14);
        assert_eq!(look_at(DVec3::ZERO, DVec3::ZERO, DVec3::Y), None);
        assert_eq!(look_at(DVec3::ZERO, DVec3::Y, DVec3::Y), None);
    }

    #[test]
    fn matrices_are_stored_by_column() {
        let m = [1., 0., 0., 0., 0., 2., 0., 0., 0., 0., 1., 0., 5., 6., 7., 1.];
        let t = matrix(&m).unwrap();
        assert_eq!(t.transform_point3(DVec3::ONE), DVec3::new(6.0, 8.0, 8.0));
        let mut transposed = m;
        transposed.swap(3, 12);
        assert_eq!(matrix(&transposed), Err(NotAffine::Projective));
        let mut flat = m;
        flat[0] = 0.0;
        assert_eq!(matrix(&flat), Err(NotAffine::Singular));
    }
}
