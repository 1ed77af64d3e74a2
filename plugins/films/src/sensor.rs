//! How strongly a film records, which white it takes for white, and how much light of one sample it takes: in the EXR file too.

use bhs_colour::{D65_XYZ, standard_observer};
use bhs_core::params::Params;
use glam::{DMat3, DVec3};

/// Bradford's matrix, from CIE XYZ to the responses in which white points are adapted (Lam 1985; ICC.1:2022, annex E), by columns.
const BRADFORD: DMat3 = DMat3::from_cols_array(&[0.8951, -0.7502, 0.0389, 0.2664, 1.7135, -0.0685, -0.1614, 0.0367, 1.0296]);

/// The sensor behind a film.
pub struct Sensor {
    /// What is multiplied with what falls on it.
    pub ratio: f64,
    /// From the white of the scene to D65; `None`: it is that.
    adapt: Option<DMat3>,
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
        let adapt = white.map(|t| adaptation(daylight(t), DVec3::from_array(D65_XYZ)));
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
        self.adapt.map_or(scaled, |m| (m * DVec3::from_array(scaled)).to_array())
    }
}

/// Takes colours under one white to those under another.
fn adaptation(from: DVec3, to: DVec3) -> DMat3 {
    let ratio = (BRADFORD * to) / (BRADFORD * from);
    BRADFORD.inverse() * DMat3::from_diagonal(ratio) * BRADFORD
}

/// XYZ of daylight of a correlated colour temperature (CIE 15:2004, 3.1); below 4000 K, where there is none, of a black body, as pbrt-v4.
fn daylight(kelvin: f64) -> DVec3 {
    // The second radiation constant has changed since the illuminants were made.
    let t = kelvin * 1.4388 / 1.4380;
    if t < 4000.0 {
        let planck = |nm: f64| 1.0 / (nm.powi(5) * ((1.438_776_877e7 / (nm * t)).exp_m1()));
        let xyz: DVec3 = standard_observer().iter().map(|[nm, x, y, z]| DVec3::new(*x, *y, *z) * planck(*nm)).sum();
        return xyz / xyz.y;
    }
    let x = match t <= 7000.0 {
        true => -4.607e9 / t.powi(3) + 2.9678e6 / t.powi(2) + 0.09911e3 / t + 0.244_063,
        false => -2.0064e9 / t.powi(3) + 1.9018e6 / t.powi(2) + 0.24748e3 / t + 0.237_040,
    };
    let y = -3.0 * x * x + 2.870 * x - 0.275;
    DVec3::new(x / y, 1.0, (1.0 - x - y) / y)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn daylight_of_6500_kelvin_is_d65_and_keeps_white() {
        let [x, y, z] = daylight(6500.0).to_array();
        assert!((x / (x + y + z) - 0.3127).abs() < 3e-4 && (y / (x + y + z) - 0.3290).abs() < 3e-4);
        let warm = Sensor { ratio: 2.0, adapt: Some(adaptation(daylight(3000.0), DVec3::from_array(D65_XYZ))), most: 1.0 };
        // White of 3000 K is recorded as D65, twice as bright.
        let white = warm.developed(daylight(3000.0).to_array());
        assert!(white.iter().zip(D65_XYZ).all(|(a, b)| (a - 2.0 * b).abs() < 1e-9), "{white:?}");
        assert_eq!([warm.limit([0.1, 0.5, 0.2]), warm.limit([0.1, 1.0, 0.2])], [1.0, 0.5]);
    }
}
