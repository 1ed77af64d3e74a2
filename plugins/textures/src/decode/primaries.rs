//! From colours of any primaries to linear sRGB.

use bhs_colour::{D65_XYZ, SRGB_FROM_XYZ, SRGB_PRIMARIES, bradford, product};
use glam::{DMat3, DVec2, DVec3, Mat3, Vec3};

/// Chromaticities (CIE 1931 x, y) of red, green, blue and white.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Primaries(pub(super) [DVec2; 4]);

/// IEC 61966-2-1, with the white as files write it.
pub(super) const SRGB: Primaries = {
    let [red, green, blue] = SRGB_PRIMARIES;
    Primaries([DVec2::from_array(red), DVec2::from_array(green), DVec2::from_array(blue), DVec2::new(0.3127, 0.3290)])
};
/// The white of equal energy.
pub(super) const EQUAL_ENERGY: DVec2 = DVec2::new(1.0 / 3.0, 1.0 / 3.0);

/// Nearer than this to sRGB's, in each number, is sRGB: files round.
const SAME: f64 = 1e-3;

/// XYZ of a chromaticity, Y = 1.
fn xyz(c: DVec2) -> DVec3 {
    DVec3::new(c.x / c.y, 1.0, (1.0 - c.x - c.y) / c.y)
}

/// From colours of these primaries to CIE XYZ, white of Y = 1; `None` if they span no colours.
fn xyz_from_rgb(Primaries([r, g, b, white]): Primaries) -> Option<DMat3> {
    let unscaled = DMat3::from_cols(xyz(r), xyz(g), xyz(b));
    let scale = unscaled.inverse() * xyz(white);
    let matrix = unscaled * DMat3::from_diagonal(scale);
    let usable = matrix.is_finite() && unscaled.determinant().abs() > 1e-9 && scale.min_element() > 0.0;
    usable.then_some(matrix)
}

/// From XYZ under a white point to linear sRGB, white to white, as colour managers do.
fn srgb_from_xyz(white: DVec2) -> DMat3 {
    DMat3::from_cols_array_2d(&product(SRGB_FROM_XYZ, bradford(xyz(white).to_array(), D65_XYZ))).transpose()
}

/// What takes colours of these primaries to linear sRGB, white to white; `None` if they are sRGB's.
///
/// # Errors
/// That the primaries span no colours.
pub(super) fn srgb_from(primaries: Primaries) -> Result<Option<Mat3>, &'static str> {
    // Not true for what is no number.
    let is_near = |(a, b): (DVec2, DVec2)| (a - b).abs().cmplt(DVec2::splat(SAME)).all();
    if primaries.0.into_iter().zip(SRGB.0).all(is_near) {
        return Ok(None);
    }
    let matrix = xyz_from_rgb(primaries).map(|m| srgb_from_xyz(primaries.0[3]) * m);
    match matrix {
        Some(m) if m.is_finite() => Ok(Some(m.as_mat3())),
        _ => Err("its primaries span no colours, and are taken for those of sRGB"),
    }
}

/// Shares of red, green and blue in the luminance; `None` if they span no colours.
pub(super) fn luminance_weights(primaries: Primaries) -> Option<Vec3> {
    let row = xyz_from_rgb(primaries)?.row(1).as_vec3();
    (row.y.abs() > 1e-3).then_some(row)
}

/// What takes CIE XYZ of a white point to linear sRGB.
pub(super) fn srgb_from_xyz_of(white: DVec2) -> Mat3 {
    srgb_from_xyz(white).as_mat3()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn primaries(n: [f64; 8]) -> Primaries {
        Primaries(std::array::from_fn(|i| DVec2::new(n[2 * i], n[2 * i + 1])))
    }

    #[test]
    fn rec_2020_and_aces_become_srgb() {
        // ITU-R BT.2087-0, table 1 (Rec. 2020 to 709).
        let rec2020 = primaries([0.708, 0.292, 0.17, 0.797, 0.131, 0.046, 0.3127, 0.329]);
        let m = srgb_from(rec2020).expect("colours").expect("others");
        let wanted = [[1.6605, -0.5876, -0.0728], [-0.1246, 1.1329, -0.0083], [-0.0182, -0.1006, 1.1187]];
        for (i, row) in wanted.iter().enumerate() {
            assert!((m.row(i) - Vec3::from_array(*row)).abs().max_element() < 2e-4, "{m}");
        }
        // AP1 with the white D60, by Bradford: the matrix of ACEScg to linear sRGB as OpenColorIO's ACES configuration has it.
        let ap1 = primaries([0.713, 0.293, 0.165, 0.83, 0.128, 0.044, 0.32168, 0.33767]);
        let m = srgb_from(ap1).expect("colours").expect("others");
        let wanted = [[1.705_05, -0.621_79, -0.083_26], [-0.130_26, 1.140_80, -0.010_55], [-0.024_00, -0.128_97, 1.152_97]];
        for (i, row) in wanted.iter().enumerate() {
            assert!((m.row(i) - Vec3::from_array(*row)).abs().max_element() < 3e-4, "{m}");
        }
        assert!((m * Vec3::ONE - Vec3::ONE).abs().max_element() < 1e-6);
    }

    #[test]
    fn srgb_stays_and_nonsense_is_told() {
        assert_eq!(srgb_from(SRGB), Ok(None));
        assert_eq!(srgb_from(primaries([0.6400, 0.3300, 0.3000, 0.6000, 0.1500, 0.0600, 0.3127, 0.3291])), Ok(None));
        for nonsense in [[0.0; 8], [f64::NAN; 8], [0.3; 8], [0.64, 0.33, 0.3, 0.6, 0.15, 0.06, 0.9, 0.05]] {
            srgb_from(primaries(nonsense)).expect_err("no colours");
        }
    }
}
