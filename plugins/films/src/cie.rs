//! The CIE 1931 2-degree standard observer and the sRGB primaries.

/// First wavelength of the table (nm); the step is 1 nm.
const FIRST_NM: f32 = 360.0;

/// The integral of the colour matching function y over the table (nm): XYZ are divided by it, so that an equal-energy spectrum
/// of radiance 1 has Y = 1 (as in pbrt-v4 and Mitsuba 3).
pub const Y_INTEGRAL: f64 = 106.856_895;

/// Linear sRGB from XYZ (IEC 61966-2-1, D65 white; the rows are R, G, B).
const SRGB_FROM_XYZ: [[f64; 3]; 3] =
    [[3.240_479, -1.537_150, -0.498_535], [-0.969_256, 1.875_991, 0.041_556], [0.055_648, -0.204_043, 1.057_311]];

/// The colour matching functions in steps of 1 nm.
pub struct Observer {
    rows: Vec<[f32; 3]>,
}

impl Observer {
    /// The CIE 1931 2-degree observer, 360 to 830 nm.
    pub fn cie_1931() -> Self {
        let rows = include_str!("../data/cie1931_2deg_1nm.csv").lines().filter_map(|line| {
            let mut numbers = line.split(',').map(|n| n.trim().parse::<f32>());
            match (numbers.next(), numbers.next(), numbers.next(), numbers.next()) {
                (Some(Ok(_)), Some(Ok(x)), Some(Ok(y)), Some(Ok(z))) => Some([x, y, z]),
                _ => None,
            }
        });
        Self { rows: rows.collect() }
    }

    /// The functions x, y, z at a wavelength (nm), linear between the table's rows, zero outside.
    pub fn at(&self, lambda_nm: f32) -> [f32; 3] {
        let x = lambda_nm - FIRST_NM;
        if !(x >= 0.0 && x <= (self.rows.len() - 1) as f32) {
            return [0.0; 3];
        }
        let i = (x as usize).min(self.rows.len() - 2);
        let t = x - i as f32;
        std::array::from_fn(|k| self.rows[i][k] + t * (self.rows[i + 1][k] - self.rows[i][k]))
    }
}

/// Linear sRGB of XYZ.
pub fn srgb_from_xyz(xyz: [f64; 3]) -> [f64; 3] {
    SRGB_FROM_XYZ.map(|row| row[0] * xyz[0] + row[1] * xyz[1] + row[2] * xyz[2])
}

/// The sRGB encoding of a linear value, clipped to 0..1.
pub fn srgb_encode(linear: f32) -> f32 {
    let x = linear.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_is_whole_and_its_integrals_are_the_published_ones() {
        let observer = Observer::cie_1931();
        assert_eq!(observer.rows.len(), 471);
        let sums: [f64; 3] = std::array::from_fn(|k| observer.rows.iter().map(|r| f64::from(r[k])).sum());
        for (sum, published) in sums.into_iter().zip([106.8655, 106.8569, 106.8923]) {
            assert!((sum - published).abs() < 1e-3, "{sum} {published}");
        }
        assert!((sums[1] - Y_INTEGRAL).abs() < 1e-4);
        assert_eq!(observer.at(359.9), [0.0; 3]);
        assert_eq!(observer.at(830.1), [0.0; 3]);
        assert!(observer.at(830.0)[1] > 0.0);
    }

    #[test]
    fn the_white_of_srgb_is_d65() {
        // x = 0.3127, y = 0.3290 at Y = 1
        let rgb = srgb_from_xyz([0.3127 / 0.3290, 1.0, (1.0 - 0.3127 - 0.3290) / 0.3290]);
        assert!(rgb.iter().all(|c| (c - 1.0).abs() < 1e-3), "{rgb:?}");
        assert!((srgb_encode(0.214_041) - 0.5).abs() < 1e-4);
    }
}
