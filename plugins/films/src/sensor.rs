//! How strongly a film records, which white it takes for white, and how much light of one sample it takes: in the EXR file too.

use bhs_colour::{D65_XYZ, Matrix, bradford, times, white_of};
use bhs_core::params::Params;

/// The sensor behind a film.
pub struct Sensor {
    /// What is multiplied with what falls on it.
    pub ratio: f64,
    /// From the white of the scene to D65; `None`: it is that.
    adapt: Option<Matrix>,
    /// Largest X, Y or Z of a sample that is recorded.
    most: f64,
}

impl Sensor {
    /// Reads its parameters.
    pub fn read(p: &Params) -> Self {
        let ratio = p.get_in("imagingratio", 1.0, 1e-30..=1e30, "", "multiplies what is recorded");
        let white = p.optional::<f64>("whitebalance", "K", "temperature of the daylight that is to look white");
        let most = p.optional::<f64>("maxcomponentvalue", "", "largest X, Y or Z of a sample; a brighter one keeps its colour");
        if white.is_some_and(|t| !(1000.0..=25_000.0).contains(&t)) {
            p.reject("whitebalance", "`whitebalance` is a temperature", "expected 1000 to 25000 (K)");
        }
        if most.is_some_and(|m| m <= 0.0) {
            p.reject("maxcomponentvalue", "`maxcomponentvalue` must be above 0", "");
        }
        let adapt = white.map(|t| bradford(daylight(t), D65_XYZ));
        Self { ratio, adapt, most: most.unwrap_or(f64::INFINITY) }
    }

    /// Whether some samples are too bright for it.
    pub fn is_limited(&self) -> bool {
        self.most.is_finite()
    }

    /// What a sample of the given XYZ is multiplied with.
    pub fn limit(&self, xyz: [f64; 3]) -> f32 {
        let greatest = xyz.into_iter().fold(0.0, f64::max) * self.ratio;
        if greatest > self.most { (self.most / greatest) as f32 } else { 1.0 }
    }

    /// XYZ as it is recorded.
    #[inline]
    pub fn developed(&self, xyz: [f64; 3]) -> [f64; 3] {
        let scaled = xyz.map(|v| v * self.ratio);
        self.adapt.map_or(scaled, |m| times(m, scaled))
    }
}

/// XYZ of daylight of a correlated colour temperature, below 4000 K of a black body, as pbrt-v4: in kelvins of before the second radiation constant was
/// changed, so that D65 is that of 6500.
fn daylight(kelvin: f64) -> [f64; 3] {
    white_of(kelvin * 1.4388 / 1.4380)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn daylight_of_6500_kelvin_is_d65_and_keeps_white() {
        let [x, y, z] = daylight(6500.0);
        assert!((x / (x + y + z) - 0.3127).abs() < 3e-4 && (y / (x + y + z) - 0.3290).abs() < 3e-4);
        let warm = Sensor { ratio: 2.0, adapt: Some(bradford(daylight(3000.0), D65_XYZ)), most: 1.0 };
        // White of 3000 K is recorded as D65, twice as bright.
        let white = warm.developed(daylight(3000.0));
        assert!(white.iter().zip(D65_XYZ).all(|(a, b)| (a - 2.0 * b).abs() < 1e-9), "{white:?}");
        assert_eq!([warm.limit([0.1, 0.5, 0.2]), warm.limit([0.1, 1.0, 0.2])], [1.0, 0.5]);
    }
}
