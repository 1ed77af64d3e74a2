//! Round static spacetimes as one family: the optical radius as a function of one radial coordinate.
//!
//! Light moves in planes through the centre, whose optical metric is conformally flat: `R^2 (ds^2 + dpsi^2)` with `s = ln rho` and the optical
//! radius `R = n rho` of the isotropic chart. `ln R` is a convex function of s with one minimum: the throat of a wormhole, or the photon sphere
//! of a hole (`docs/physics.md`, sections 6 and 7). Along a ray `h = R sin(alpha)` is constant.
//!
//! The coordinate here is `x = sinh(s - s_0)` with `s_0` at the minimum: R^2 is nearly a quadratic function of it.

use crate::graded_index::medium::{Medium, Refracted};
use bhs_core::real::Vector;
use bhs_core::spacetime::{Class, GradedIndex, Spacetime, Spherical};
use glam::DVec3;
use std::sync::Arc;

/// What the optical radius is computed from.
#[derive(Clone, Debug)]
enum Kind {
    /// A hole of some mass; `mass^2 - charge^2`, 0 of an extremal one.
    Hole { mass: f64, rest: f64 },
    /// A wormhole with a refractive index, around the centre that it was built with.
    Throat { spacetime: Arc<dyn Spacetime>, center: DVec3 },
}

/// A round static spacetime.
#[derive(Clone, Debug)]
pub struct Profile {
    kind: Kind,
    /// Isotropic radius of the minimum (scene units).
    pub middle: f64,
    /// Optical radius there (scene units).
    pub least: f64,
    /// Up to this |x| the optical radius is that of the minimum: 0 but for wormholes whose throat is a cylinder.
    pub edge: f64,
    /// Places |x| > 0 at which a derivative of R jumps, from the inside outwards; the first one may be `edge`.
    pub breaks: Vec<f64>,
}

/// The radii of one place or of several.
#[derive(Clone, Copy, Debug)]
pub struct Radii<F> {
    /// Square of the optical radius.
    pub square: F,
    /// Half its derivative by |x|.
    pub slope: F,
    /// Isotropic radius (scene units).
    pub rho: F,
    /// ds/dx = 1 / sqrt(1 + x^2).
    pub pace: F,
}

/// Indices at these multiples of the radius of the photon sphere tell whether a hole is an extremal one.
const PROBES: [f64; 3] = [0.3, 1.0, 2.5];

impl Profile {
    /// That of `spacetime`, if it is a wormhole or one extremal hole of the class [`Class::Index`].
    pub fn of_index(spacetime: &dyn Spacetime) -> Option<Self> {
        let Class::Index(index) = spacetime.class() else { return None };
        let captures = spacetime.captures();
        match (index.throat(), captures.as_slice()) {
            (Some(throat), []) => Some(Self::of_throat(spacetime, index, throat.center, throat.radius)),
            (None, [hole]) => {
                // n^2 = (1 + M/rho)^4.
                let is_extremal = PROBES.iter().all(|over| {
                    let square = index.index(hole.center + DVec3::X * (hole.radius * over)).0;
                    (square * (1.0 + 1.0 / over).powi(-4) - 1.0).abs() < 1e-9
                });
                is_extremal.then(|| Self::of_hole(hole.radius, 0.0))
            }
            _ => None,
        }
    }

    /// That of a round hole.
    pub fn of_spherical(hole: &Spherical) -> Self {
        let mass = 0.5 * hole.rs;
        let rest = ((mass * mass - hole.charge_squared) / (mass * mass)).max(0.0);
        Self::of_hole(mass, rest * mass * mass)
    }

    /// That of a hole of the given mass (scene units), with `rest = mass^2 - charge^2`.
    pub fn of_hole(mass: f64, rest: f64) -> Self {
        let charge_squared = mass * mass - rest;
        let photons = 0.5 * (3.0 * mass + (9.0 * mass * mass - 8.0 * charge_squared).sqrt());
        let middle = isotropic_radius(photons, mass, rest);
        let kind = Kind::Hole { mass, rest };
        let least = optical_radius(middle, mass, rest).0;
        Self { kind, middle, least, edge: 0.0, breaks: Vec::new() }
    }

    fn of_throat(spacetime: &dyn Spacetime, index: &dyn GradedIndex, center: DVec3, radius: f64) -> Self {
        let kind = Kind::Throat { spacetime: spacetime.moved(DVec3::ZERO), center };
        let breaks = Medium::new(index, Vec::new()).breaks.into_iter().filter(|b| *b > radius * (1.0 + 1e-12));
        let mut profile = Self { kind, middle: radius, least: 0.0, edge: 0.0, breaks: Vec::new() };
        profile.breaks = breaks.map(|b| profile.coordinate(b)).collect();
        profile.least = profile.at(0.0, false).square.sqrt();
        let is_least = |x: &f64| profile.at(*x, false).square.sqrt() <= profile.least * (1.0 + 1e-12);
        profile.edge = profile.breaks.iter().copied().filter(is_least).fold(0.0, f64::max);
        profile
    }

    /// Whether x < 0 is the far side of a wormhole; else it is what lies within the photon sphere.
    pub fn is_throat(&self) -> bool {
        matches!(self.kind, Kind::Throat { .. })
    }

    /// The coordinate x of the isotropic radius `rho` on the near side.
    pub fn coordinate(&self, rho: f64) -> f64 {
        let ratio = rho / self.middle;
        0.5 * (ratio - 1.0 / ratio)
    }

    /// The radii at `x` >= 0 or, if `is_inner`, within the photon sphere at `-x`.
    #[inline(always)]
    pub fn at<F: Refracted>(&self, x: F, is_inner: bool) -> Radii<F> {
        let c = F::splat;
        let root = x.times_plus(x, c(1.0)).sqrt();
        let pace = c(1.0) / root;
        let growth = x + root;
        let rho = if is_inner { c(self.middle) / growth } else { c(self.middle) * growth };
        let (square, by_rho) = self.by_radius(rho);
        let slope = by_rho * rho * pace;
        Radii { square, slope: if is_inner { -slope } else { slope }, rho, pace }
    }

    /// R^2 and half its derivative by rho.
    #[inline(always)]
    fn by_radius<F: Refracted>(&self, rho: F) -> (F, F) {
        let c = F::splat;
        match &self.kind {
            Kind::Hole { mass, rest } => {
                let over = c(1.0) / rho;
                let quarter = c(0.25 * rest) * over;
                let (areal, q) = (rho + c(*mass) + quarter, rho - quarter);
                let share = areal / q;
                let radius = areal * share;
                let slope = c(2.0) * areal * over - share * share * (rho + quarter) * over;
                (radius * radius, radius * slope)
            }
            Kind::Throat { spacetime, center } => {
                let Class::Index(index) = spacetime.class() else { return (rho * rho, rho) };
                let zero = c(0.0);
                let (square, acceleration) = F::index(index, Vector { x: rho, y: zero, z: zero } + Vector::all(*center));
                (square * rho * rho, rho * rho.times_plus(acceleration.x, square))
            }
        }
    }

    /// Half the second derivative of R^2 by |x|, as at [`Profile::at`].
    pub fn bend(&self, x: f64, is_inner: bool) -> f64 {
        let Radii { rho, pace, .. } = self.at(x, is_inner);
        let sign = if is_inner { -1.0 } else { 1.0 };
        let (_, slope) = self.by_radius(rho);
        let second = match &self.kind {
            Kind::Hole { mass, rest } => optical_radius(rho, *mass, *rest).1,
            Kind::Throat { spacetime, center } => {
                let Class::Index(index) = spacetime.class() else { return 0.0 };
                let at = *center + DVec3::X * rho;
                let (square, acceleration) = index.index(at);
                square + rho * (4.0 * acceleration.x + rho * index.hessian(at).x_axis.x)
            }
        };
        let along = rho * pace;
        second * along * along + slope * (along * pace - sign * along * x * pace * pace)
    }
}

/// Isotropic radius of the areal radius `areal` around a hole: `areal = rho + mass + rest / (4 rho)`.
pub fn isotropic_radius(areal: f64, mass: f64, rest: f64) -> f64 {
    let from_middle = areal - mass;
    0.5 * (from_middle + (from_middle * from_middle - rest).max(0.0).sqrt())
}

/// Optical radius at the isotropic radius `rho` around a hole, and half the second derivative of its square.
fn optical_radius(rho: f64, mass: f64, rest: f64) -> (f64, f64) {
    let quarter = 0.25 * rest / rho;
    let (areal, q) = (rho + mass + quarter, rho - quarter);
    // r' = q / rho.
    let (areal_slope, q_slope, q_bend) = (q / rho, 1.0 + quarter / rho, -2.0 * quarter / (rho * rho));
    let radius = areal * areal / q;
    let slope = 2.0 * areal / rho - areal * areal * q_slope / (q * q);
    let bend = 2.0 * areal_slope / rho
        - 2.0 * areal / (rho * rho)
        - 2.0 * areal * areal_slope * q_slope / (q * q)
        - areal * areal * q_bend / (q * q)
        + 2.0 * areal * areal * q_slope * q_slope / (q * q * q);
    (radius, slope * slope + radius * bend)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bhs_spacetimes::{Dneg, Ellis};

    fn profiles() -> Vec<Profile> {
        let ellis = Ellis { center: DVec3::new(0.3, 0.1, -0.2), throat: 0.9 };
        let dneg = Dneg::new(DVec3::ZERO, 1.0, 1.0, 0.1).unwrap();
        let charged = Spherical { center: DVec3::ZERO, rs: 1.4, charge_squared: 0.3 };
        vec![
            Profile::of_index(&ellis).unwrap(),
            Profile::of_index(&dneg).unwrap(),
            Profile::of_spherical(&charged),
            Profile::of_hole(0.7, 0.0),
        ]
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        for profile in profiles() {
            for (x, is_inner) in [(0.3, true), (0.01, true), (0.02, false), (0.9, false), (4.0, false), (60.0, false)] {
                if is_inner && profile.is_throat() {
                    continue;
                }
                let h = 1e-5 * (1.0 + x);
                let [a, b] = [x - h, x + h].map(|x| profile.at(x, is_inner));
                let here = profile.at(x, is_inner);
                let slope = 0.25 * (b.square - a.square) / h;
                let bend = 0.5 * (b.slope - a.slope) / h;
                let scale = here.square / (1.0 + x);
                assert!((slope - here.slope).abs() < 1e-8 * scale, "{x} {slope} {here:?}");
                let is_smooth = profile.breaks.iter().all(|b| (x - b).abs() > h);
                let right = profile.bend(x, is_inner);
                assert!(!is_smooth || (bend - right).abs() < 1e-7 * scale, "{x}: {bend} {right}");
            }
        }
    }

    #[test]
    fn the_middle_is_the_minimum() {
        for profile in profiles() {
            let here = profile.at(0.0, false);
            assert!(
                here.slope.abs() < 1e-12 * here.square && (here.square.sqrt() / profile.least - 1.0).abs() < 1e-14,
                "{here:?}"
            );
        }
        // The photon sphere of a hole without charge, and sqrt(27) M.
        let plain = Profile::of_spherical(&Spherical { center: DVec3::ZERO, rs: 2.0, charge_squared: 0.0 });
        assert!((plain.least - 27.0_f64.sqrt()).abs() < 1e-14);
    }
}
