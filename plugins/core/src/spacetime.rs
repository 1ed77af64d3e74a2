//! What light moves through: the contract of the spacetimes.
//!
//! Every spacetime here is stationary and is drawn in one Euclidean chart (a wormhole: in one a side). All that a renderer needs to know of it
//! at a point are the lapse `N` of static observers, the spatial metric `gamma`, and the rotation `beta`:
//!
//! `ds^2 = -N^2 (dt + beta_i dx^i)^2 + gamma_ij dx^i dx^j`
//!
//! Light has a conserved energy, which is 1. *Chart* vectors are coordinates, *local* ones are what the static observer measures; a symmetric
//! root of `gamma` turns the one into the other. Units: G = c = 1, lengths in scene units.

use crate::dual::Dual;
use crate::lanes::Lanes;
use crate::real::Vectors;
use glam::{DMat3, DVec3};
use std::fmt::Debug;
use std::sync::Arc;

mod axial;
mod kerr;
mod metric;
mod normal;
mod stretch;

pub use axial::Axial;
pub use kerr::{Kerr, Oblate};
pub use metric::{Fields, Inverse, LightStep, Metric, light_step, stationary};
pub use normal::Normal;
pub use stretch::Stretch;

/// Which of the two sides of a wormhole; all other spacetimes have the near one only.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Side {
    /// Where scenes are unless they say otherwise.
    #[default]
    Near,
    /// Through the throat.
    Far,
}

impl Side {
    /// The side on the other end of the throat.
    pub fn other(self) -> Self {
        match self {
            Self::Near => Self::Far,
            Self::Far => Self::Near,
        }
    }
}

/// A point of space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Place {
    /// Chart position (scene units).
    pub x: DVec3,
    /// The side whose chart that is.
    pub side: Side,
}

impl Place {
    /// The point `x` of the near side.
    pub fn near(x: DVec3) -> Self {
        Self { x, side: Side::Near }
    }
}

/// A ball of the chart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Centre (scene units).
    pub center: DVec3,
    /// Radius (scene units).
    pub radius: f64,
}

/// The metric at a point, split as the static observer there has it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stationary {
    /// Rate of the static observer's clock against that of a clock far away; its light has the wavelength `lapse` times that at E = 1.
    pub lapse: f64,
    /// Symmetric root of the spatial metric.
    pub root: Stretch,
    /// Rotation, a chart covector (scene units of time per length): 0 in static spacetimes.
    pub beta: DVec3,
}

impl Stationary {
    /// Flat space.
    pub const FLAT: Self = Self { lapse: 1.0, root: Stretch::IDENTITY, beta: DVec3::ZERO };

    /// Covector `p_i` of light of energy E = 1 that moves into the future along the chart direction `d` (any length but 0).
    pub fn momentum(&self, d: DVec3) -> DVec3 {
        let local = self.root.apply(d);
        self.root.apply(local) / (self.lapse * local.length()) - self.beta
    }

    /// Time that light takes along the short chart vector `step`, into the future.
    pub fn travel_time(&self, step: DVec3) -> f64 {
        self.root.apply(step).length() / self.lapse - self.beta.dot(step)
    }
}

/// What light moves through. One implementation, one plugin; any scene works in any of them.
///
/// The coordinates of its places are those that it was built with; [`Spacetime::moved`] makes one for others.
pub trait Spacetime: Debug + Send + Sync {
    /// The metric as the static observer at `place` has it; `None` where nothing can stand still, or where there is no such place.
    fn at(&self, place: Place) -> Option<Stationary>;

    /// The metric as the observer at `place` has it who does not turn with respect to space; `None` where there is none, as within horizons. Also
    /// where nothing can stand still.
    fn normal(&self, place: Place) -> Option<Normal> {
        Normal::of(self, place)
    }

    /// Whether space is dragged along somewhere, so that there may be places where nothing can stand still and much can move.
    fn drags(&self) -> bool {
        matches!(self.class(), Class::Kerr(_) | Class::General(_))
    }

    /// Balls around the holes, one a hole that has mass, in the order of the scene: the distance from the centre of light that crosses one inwards gets
    /// less from there on, and it never comes out again.
    ///
    /// Where [`Spacetime::at`] answers, things may stand in such a ball and be seen; light that starts there and moves outwards may leave. So
    /// a ray may be given up in a ball when it moves inwards and nothing that could stop it stands nearer to the centre. The balls of
    /// Schwarzschild and Reissner-Nordstroem holes are their horizons: no place, and rays end on them.
    fn captures(&self) -> Vec<Ball>;

    /// A ball around what bends light, of the size of it, where neither [`Spacetime::captures`] nor a throat says where that is: from some times its
    /// radius on, space is nearly flat. Steps are measured by it, and rays are taken to leave for ever outside.
    fn bends(&self) -> Option<Ball> {
        None
    }

    /// What solvers may know about it: how its rays are found fastest.
    fn class(&self) -> Class<'_>;

    /// What circular orbits need to know, if it is a single round or spinning hole.
    fn axial(&self) -> Option<Axial> {
        Axial::of(self)
    }

    /// Its metric as functions of the place, for Hamilton's equations: every spacetime has it, whatever its class. The two sides of a
    /// wormhole have the same.
    fn metric(&self) -> &dyn Metric;

    /// Whether it has a far side.
    fn has_far_side(&self) -> bool {
        false
    }

    /// The ball through which all light from far away that comes into `ball` would pass if nothing bent it: of its impact parameters, to be shone at.
    /// `None` where that is not known.
    fn aim(&self, ball: Ball) -> Option<Ball> {
        let hole = match self.class() {
            Class::Flat => return Some(ball),
            Class::Spherical(hole) => hole,
            Class::Kerr(hole) => hole.round(),
            Class::Index(_) | Class::General(_) => return None,
        };
        // Light that comes as near to a hole as r passes far away at r/N(r), which grows with r beyond the orbits of light; spin moves it by less than rs.
        let r = ((ball.center - hole.center).length() + ball.radius).max(3.0 * hole.rs);
        Some(Ball { center: hole.center, radius: r / hole.lapse_squared(r).sqrt() + hole.rs })
    }

    /// The spacetime whose time runs the other way, if it is another one and is known: light goes forwards here where it is followed back there.
    fn reversed(&self) -> Option<Arc<dyn Spacetime>> {
        None
    }

    /// Light of energy 1 that moves into the future along the short chart vector `step` at `place`; `None` where none does.
    fn light_step(&self, place: Place, step: DVec3) -> Option<LightStep> {
        match self.at(place) {
            Some(here) if here.beta == DVec3::ZERO => {
                Some(LightStep { time: here.travel_time(step), momentum: here.momentum(step) })
            }
            // Also where nothing can stand still; and to all digits next to there.
            _ => light_step(self.metric(), place.x, step),
        }
    }

    /// The same spacetime in coordinates whose origin lies at `origin` of the present ones.
    fn moved(&self, origin: DVec3) -> Arc<dyn Spacetime>;
}

/// Kinds of spacetimes by how their rays can be followed.
#[derive(Clone, Copy, Debug)]
pub enum Class<'a> {
    /// Straight lines: flat space, and every spacetime without mass.
    Flat,
    /// Orbits in planes through one centre, drawn with the areal radius: Schwarzschild and Reissner-Nordstroem.
    Spherical(Spherical),
    /// Orbits around a hole that spins, charged or not: separable in its oblate chart.
    Kerr(Kerr),
    /// Rays of a refractive index in the isotropic chart: several extremal holes, wormholes.
    Index(&'a dyn GradedIndex),
    /// Whatever gives its metric: by Hamilton's equations.
    General(&'a dyn Metric),
}

/// Flat space, or two of them that are not connected.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Minkowski {
    /// Whether there is a far side, to which no light comes: what a wormhole without a throat leaves.
    pub far_side: bool,
}

impl Spacetime for Minkowski {
    fn at(&self, place: Place) -> Option<Stationary> {
        (place.side == Side::Near || self.far_side).then_some(Stationary::FLAT)
    }

    fn captures(&self) -> Vec<Ball> {
        Vec::new()
    }

    fn class(&self) -> Class<'_> {
        Class::Flat
    }

    fn metric(&self) -> &dyn Metric {
        self
    }

    fn has_far_side(&self) -> bool {
        self.far_side
    }

    fn moved(&self, _: DVec3) -> Arc<dyn Spacetime> {
        Arc::new(*self)
    }
}

impl Metric for Minkowski {
    fn fields(&self, _: [Dual; 3]) -> Fields {
        Fields::isotropic(Dual::constant(1.0), Dual::constant(1.0))
    }
}

/// A round hole in the areal chart: `N^2 = 1 - rs/r + q^2/r^2`, `gamma = 1 + (1/N^2 - 1) e_r e_r`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spherical {
    /// Centre (scene units).
    pub center: DVec3,
    /// `2 G M / c^2` (scene units), whatever the charge.
    pub rs: f64,
    /// Square of the charge, as a length (scene units^2); at most `rs^2 / 4`.
    pub charge_squared: f64,
}

impl Spherical {
    /// Areal radius of the outer horizon: `M + sqrt(M^2 - q^2)`.
    pub fn horizon(&self) -> f64 {
        let m = 0.5 * self.rs;
        m + (m * m - self.charge_squared).max(0.0).sqrt()
    }

    /// Square of the lapse at the areal radius `r`.
    #[inline]
    pub fn lapse_squared(&self, r: f64) -> f64 {
        1.0 - self.rs / r + self.charge_squared / (r * r)
    }

    /// The metric at the point `x`; `None` at and inside the horizon.
    #[inline]
    pub fn at(&self, x: DVec3) -> Option<Stationary> {
        let from_center = x - self.center;
        let r = from_center.length();
        let f = self.lapse_squared(r);
        // With a charge, the square of the lapse is above 0 again behind the inner horizon.
        if f <= 0.0 || !f.is_finite() || (self.charge_squared > 0.0 && r <= self.horizon()) {
            return None;
        }
        let lapse = f.sqrt();
        Some(Stationary { lapse, root: Stretch::along(from_center / r, lapse), beta: DVec3::ZERO })
    }
}

impl Spacetime for Spherical {
    fn at(&self, place: Place) -> Option<Stationary> {
        if place.side == Side::Far { None } else { Self::at(self, place.x) }
    }

    fn captures(&self) -> Vec<Ball> {
        vec![Ball { center: self.center, radius: self.horizon() }]
    }

    fn class(&self) -> Class<'_> {
        if self.rs == 0.0 && self.charge_squared == 0.0 { Class::Flat } else { Class::Spherical(*self) }
    }

    fn metric(&self) -> &dyn Metric {
        self
    }

    fn moved(&self, origin: DVec3) -> Arc<dyn Spacetime> {
        Arc::new(Self { center: self.center - origin, ..*self })
    }
}

/// The passage between the two sides of a wormhole: the sphere on which the charts of both are joined.
///
/// The point `x` of the one chart is `center + (x - center) (radius / |x - center|)^2` in the other, and a tangent loses twice its radial
/// part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Throat {
    /// Centre, the same in both charts (scene units).
    pub center: DVec3,
    /// Radius in the isotropic chart (scene units).
    pub radius: f64,
}

impl Throat {
    /// The same point in the chart of the other side.
    pub fn through(&self, x: DVec3) -> DVec3 {
        let from_center = x - self.center;
        self.center + from_center * (self.radius * self.radius / from_center.length_squared())
    }

    /// The tangent `d` at `x` in the chart of the other side (not scaled).
    pub fn turned(&self, x: DVec3, d: DVec3) -> DVec3 {
        let radial = (x - self.center).normalize();
        d - radial * (2.0 * radial.dot(d))
    }
}

/// A static spacetime whose chart is isotropic, `gamma = U^2 1`: its rays are those of the refractive index `n = U/N`.
///
/// With a parameter in which `|x'| = n`, rays obey `x'' = grad(n^2) / 2`, which has no square root and no turning points.
pub trait GradedIndex: Debug + Send + Sync {
    /// `n^2` and half its gradient at `x`.
    fn index(&self, x: DVec3) -> (f64, DVec3);

    /// The same of eight points.
    fn index_each(&self, x: Vectors) -> (Lanes, Vectors);

    /// Half the matrix of second derivatives of `n^2` at `x`: neighbouring rays obey `J'' = hessian J`.
    fn hessian(&self, x: DVec3) -> DMat3;

    /// The passage to the other side, if there is one. The index is the same function on both sides.
    fn throat(&self) -> Option<Throat> {
        None
    }

    /// Distances from the centre of the throat at which a derivative of the index jumps: a step of high order ends there.
    fn breaks(&self) -> &[f64] {
        &[]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_has_energy_one_and_no_length() {
        let metric = Spherical { center: DVec3::new(1.0, 0.0, 0.0), rs: 1.0, charge_squared: 0.1 };
        let here = metric.at(DVec3::new(2.5, 1.0, -0.5)).unwrap();
        let here = Stationary { beta: DVec3::new(0.1, -0.2, 0.05), ..here };
        let d = DVec3::new(0.3, -0.8, 0.2);
        // g^ab p_a p_b = 0 with p_t = -1: gamma^-1 (p + beta, p + beta) = 1 / N^2.
        let kinetic = here.root.unapply(here.momentum(d) + here.beta).length_squared();
        assert!((kinetic * here.lapse * here.lapse - 1.0).abs() < 1e-14);
        assert!((here.momentum(d).dot(d) - here.travel_time(d)).abs() < 1e-14);
    }

    #[test]
    fn throats_are_passed_both_ways() {
        let throat = Throat { center: DVec3::new(0.0, 1.0, 0.0), radius: 0.5 };
        let (x, d) = (DVec3::new(0.2, 1.1, -0.1), DVec3::new(0.1, 0.9, 0.4).normalize());
        let there = throat.through(x);
        assert!((throat.through(there) - x).length() < 1e-15);
        assert!((throat.turned(there, throat.turned(x, d)) - d).length() < 1e-15);
        // The derivative of the map of points is the map of tangents, scaled.
        let moved = (throat.through(x + d * 1e-6) - throat.through(x - d * 1e-6)).normalize();
        assert!((moved - throat.turned(x, d)).length() < 1e-9);
    }

    #[test]
    fn nothing_stands_on_a_horizon() {
        let hole = Spherical { center: DVec3::ZERO, rs: 1.0, charge_squared: 0.25 };
        assert_eq!(hole.horizon(), 0.5);
        assert!(hole.at(DVec3::X * 0.5).is_none() && hole.at(DVec3::X * 0.3).is_none() && hole.at(DVec3::ZERO).is_none());
        assert!(hole.at(DVec3::X * 0.50001).is_some());
    }
}
