//! How far what is traced may stray from the true ray.

use bhs_core::params::Params;

/// How far what is traced may stray from the true ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// A distance (scene units).
    Absolute(f64),
    /// A tenth of the ray's footprint; 1e-4 of the diagonal of all surfaces for one of unknown footprint.
    Footprint,
}

impl Tolerance {
    /// What scenes get that do not ask for anything.
    pub const DEFAULT: Self = Self::Footprint;

    /// The parameter `tolerance`.
    pub fn read(p: &Params) -> Self {
        let about = "largest distance between the true ray and what is traced; by default a tenth of the ray's footprint";
        match p.optional::<f64>("tolerance", "scene", about) {
            Some(t) if t > 0.0 => Self::Absolute(t),
            Some(t) => {
                p.reject("tolerance", "`tolerance` must be above 0", format!("found {t}"));
                Self::DEFAULT
            }
            None => Self::DEFAULT,
        }
    }
}
