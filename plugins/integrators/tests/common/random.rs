//! Random rays.

use bhs_core::spacetime::{Place, Spacetime};
use glam::DVec3;

/// Numbers between -1 and 1 (a linear congruential generator: Knuth 1998, volume 2, section 3.3.4).
pub struct Random(pub u64);

impl Random {
    /// The next one.
    pub fn number(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    /// A vector of length 0.1 to 1.
    pub fn vector(&mut self) -> DVec3 {
        loop {
            let v = DVec3::new(self.number(), self.number(), self.number());
            if v.length() < 1.0 && v.length() > 0.1 {
                return v;
            }
        }
    }

    /// A place of `spacetime` within `size` of the origin, and a direction.
    pub fn ray(&mut self, size: f64, spacetime: &dyn Spacetime) -> (DVec3, DVec3) {
        loop {
            let x = self.vector() * size;
            if spacetime.at(Place::near(x)).is_some() {
                return (x, self.vector().normalize());
            }
        }
    }
}
