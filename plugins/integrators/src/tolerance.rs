//! How far what is traced may stray from the true ray, and after how many steps it is given up.

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

/// The parameter `maxsteps`, which `about` describes.
pub(crate) fn read_max_steps(p: &Params, about: &'static str) -> u64 {
    p.get_in("maxsteps", 100_000, 1..=1_000_000_000, "", about) as u64
}

/// What it is of integrators that go by steps.
pub(crate) const STEPS: &str = "steps after which a ray is given up";
