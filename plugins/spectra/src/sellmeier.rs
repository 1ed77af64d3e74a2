//! The refractive index of a glass by Sellmeier's formula.

use bhs_core::spectrum::Spectrum;

/// `n^2 = 1 + sum_i B_i L^2 / (L^2 - C_i)`, L the wavelength in micrometres (Sellmeier 1871).
#[derive(Debug)]
pub struct Sellmeier {
    /// B and C [um^2] of the three resonances.
    pub terms: [[f64; 2]; 3],
    /// The range for which the formula was fitted (nm); outside it the index keeps its end value.
    pub valid_nm: [f64; 2],
}

impl Sellmeier {
    /// The index at a wavelength (nm).
    pub fn index(&self, lambda_nm: f64) -> f64 {
        let micrometres = lambda_nm.clamp(self.valid_nm[0], self.valid_nm[1]) * 1e-3;
        let square = micrometres * micrometres;
        (1.0 + self.terms.iter().map(|[b, c]| b * square / (square - c)).sum::<f64>()).sqrt()
    }
}

impl Spectrum for Sellmeier {
    fn at(&self, lambda_nm: f32) -> f32 {
        self.index(f64::from(lambda_nm)) as f32
    }

    fn max(&self, lo: f32, _: f32) -> f32 {
        // Between its resonances the index falls with wavelength: each term's derivative by L^2 is -B C / (L^2 - C)^2.
        self.at(lo)
    }
}
