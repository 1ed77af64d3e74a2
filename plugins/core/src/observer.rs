//! Who measures light at a place: the frame of a 4-velocity, relative to the chart.
//!
//! A static observer measures chart vectors by the symmetric root of the spatial metric, and every light at `lapse` times its wavelength at
//! E = 1 (that far away, where the lapse is 1). One who moves past with the velocity `v` sees directions aberrated and wavelengths
//! shifted, each direction otherwise (special relativity):
//!
//! `Dop = k (1 + v.d)`, `k = 1/sqrt(1 - v^2)`; `d' = (d + (k/(k+1) v.d + 1) k v) / Dop`; `lambda' = lambda / Dop`; `domega' = domega / Dop^2`
//!
//! with `d` the static observer's unit direction that is *looked* in: the light moves along `-d`. Of light that a surface sends along `n`,
//! `d = -n`.
//!
//! Where space is dragged along, everything can be told as well against the observer who is dragged with it ([`Normal`]), who exists also where
//! nothing can stand still (`docs/physics.md`, section 5). That one measures the unit direction `l` where the chart has, not scaled,
//! `d = h^(-1/2) l - W/alpha`, and light has the energy 1 far away where it has here `1 / (alpha (1 - l . h^(1/2) W/alpha))`.

use crate::spacetime::{Normal, Stationary, Stretch};
use glam::DVec3;

mod conventions;

pub use conventions::{Conventions, FrameConvention};

/// Who measures light at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observer {
    /// What the reference, which is the static observer at the place or the one dragged with space, measures of chart vectors.
    pub frame: Stretch,
    /// Rate of the reference's clock against that of one far away; 1 where nothing shifts.
    lapse: f64,
    /// The same of this observer's: `1/U^t`.
    clock: f64,
    /// Velocity against the reference, in its frame (units of c).
    velocity: DVec3,
    /// How the reference moves through the chart: dx/dt over its lapse; 0 of the static observer.
    drift: DVec3,
    /// Whether there is more to it than a static observer.
    moves: bool,
    /// Whether motion shifts wavelengths.
    shifts: bool,
}

impl Observer {
    /// The observer at rest in flat space.
    pub const FLAT: Self = Self {
        frame: Stretch::IDENTITY,
        lapse: 1.0,
        clock: 1.0,
        velocity: DVec3::ZERO,
        drift: DVec3::ZERO,
        moves: false,
        shifts: true,
    };

    /// The static observer where the metric is `here`.
    #[inline]
    pub fn at_rest(here: &Stationary) -> Self {
        Self { frame: here.root, lapse: here.lapse, clock: here.lapse, ..Self::FLAT }
    }

    /// The observer dragged with space where the metric is `here`.
    pub fn dragged(here: &Normal) -> Self {
        let drift = here.drag / here.lapse;
        Self { frame: here.root, lapse: here.lapse, clock: here.lapse, drift, moves: drift != DVec3::ZERO, ..Self::FLAT }
    }

    /// The same place and motion for one to whom all light keeps its wavelength: a convention of pictures, not of nature.
    #[inline]
    pub fn without_shift(self) -> Self {
        Self { lapse: 1.0, clock: 1.0, shifts: false, ..self }
    }

    /// The same place and motion for one who takes the chart's directions for those measured: a convention of pictures, not of nature.
    #[inline]
    pub fn in_chart(self) -> Self {
        Self { frame: Stretch::IDENTITY, drift: DVec3::ZERO, moves: self.velocity != DVec3::ZERO, ..self }
    }

    /// One who passes this observer with the velocity `velocity` in its frame (units of c, less than 1); this one is a reference: static, or dragged
    /// with space.
    pub fn moving(self, velocity: DVec3) -> Self {
        self.moving_where(DVec3::ZERO, velocity)
    }

    /// The same of a static observer where the rotation of space is `beta` ([`Stationary::beta`]), on which the clock depends.
    pub fn moving_where(self, beta: DVec3, velocity: DVec3) -> Self {
        let moved = Self { velocity, moves: velocity != DVec3::ZERO || self.drift != DVec3::ZERO, ..self };
        if !self.shifts {
            return moved;
        }
        // U^t = k (1/N - beta(v)): times of the static observer's space are not those of the chart.
        Self { clock: self.lapse / (moved.gamma() * (1.0 - self.lapse * beta.dot(self.frame.unapply(velocity)))), ..moved }
    }

    /// A chart vector along which it moves, dx/dt of any length; 0 of one at rest.
    pub fn flow(&self) -> DVec3 {
        self.frame.unapply(self.velocity) + self.drift
    }

    /// Velocity against the reference, in its frame (units of c).
    #[inline]
    pub fn velocity(&self) -> DVec3 {
        self.velocity
    }

    /// Whether there is more to it than a static observer.
    #[inline]
    pub fn moves(&self) -> bool {
        self.moves
    }

    #[inline]
    fn rests(&self) -> bool {
        !self.moves
    }

    /// `1/sqrt(1 - v^2)`
    #[inline]
    fn gamma(&self) -> f64 {
        1.0 / (1.0 - self.velocity.length_squared()).sqrt()
    }

    /// Energy of the light that arrives from the reference's unit direction `d`, over that which the reference measures.
    fn doppler(&self, d: DVec3) -> f64 {
        self.gamma() * (1.0 + self.velocity.dot(d))
    }

    /// What the quadratic equation of [`Observer::reference_direction`] is made of: the chart direction and the drift as the reference measures
    /// them, and the root of its discriminant, which is not above 0 where no light of positive energy comes from.
    fn discriminant(&self, looked: DVec3) -> (DVec3, DVec3, f64) {
        let (d, drift) = (self.frame.apply(looked), self.frame.apply(self.drift));
        let along = d.dot(drift);
        (d, drift, (along * along - d.length_squared() * (drift.length_squared() - 1.0)).max(0.0).sqrt())
    }

    /// The unit direction that the reference measures of the chart direction `looked`.
    #[cold]
    fn reference_direction(&self, looked: DVec3) -> DVec3 {
        if self.drift == DVec3::ZERO {
            return self.frame.local_direction(looked);
        }
        // |s d + drift| = 1; the larger s is that of light of positive energy.
        let (d, drift, root) = self.discriminant(looked);
        (d * ((root - d.dot(drift)) / d.length_squared()) + drift).normalize()
    }

    /// Energy far away over that which the reference measures, of light that arrives from its unit direction `d`, over its lapse.
    fn dragging(&self, d: DVec3) -> f64 {
        if self.drift == DVec3::ZERO { 1.0 } else { 1.0 - d.dot(self.frame.apply(self.drift)) }
    }

    /// Rate of its clock against that of one far away: `1/U^t`; 1 where nothing shifts.
    #[inline]
    pub fn clock_rate(&self) -> f64 {
        self.clock
    }

    /// Wavelength here over wavelength at E = 1, of light that arrives from the unit chart direction `looked`.
    #[inline]
    pub fn ratio(&self, looked: DVec3) -> f64 {
        if self.rests() || !self.shifts { self.lapse } else { self.moving_ratio(looked) }
    }

    #[cold]
    fn moving_ratio(&self, looked: DVec3) -> f64 {
        let d = self.reference_direction(looked);
        self.lapse * self.dragging(d) / self.doppler(d)
    }

    /// The unit measured direction of the unit chart direction `looked`, in which one looks.
    #[inline]
    pub fn local_direction(&self, looked: DVec3) -> DVec3 {
        if self.rests() { self.frame.local_direction(looked) } else { self.aberrated(self.reference_direction(looked)) }
    }

    /// The direction that this observer measures where the reference measures the unit direction `d`.
    #[cold]
    fn aberrated(&self, d: DVec3) -> DVec3 {
        let (v, k) = (self.velocity, self.gamma());
        ((d + v * (k * (k / (k + 1.0) * v.dot(d) + 1.0))) / self.doppler(d)).normalize()
    }

    /// A direction, not a unit vector, that the reference measures where this one measures the unit direction `d`.
    #[cold]
    fn at_rest_direction(&self, d: DVec3) -> DVec3 {
        let (v, k) = (self.velocity, self.gamma());
        d + v * (k * (k / (k + 1.0) * v.dot(d) - 1.0))
    }

    /// The unit chart direction of the unit measured direction `local`, in which one looks.
    #[inline]
    pub fn chart_direction(&self, local: DVec3) -> DVec3 {
        if self.rests() { self.frame.chart_direction(local) } else { self.moving_chart_direction(local) }
    }

    #[cold]
    fn moving_chart_direction(&self, local: DVec3) -> DVec3 {
        let d = self.at_rest_direction(local);
        if self.drift == DVec3::ZERO {
            return self.frame.chart_direction(d);
        }
        (self.frame.unapply(d.normalize()) - self.drift).normalize()
    }

    /// Whether light that arrives from the unit measured direction `local` has a positive energy far away: other light, which there is in
    /// ergospheres only, comes from nowhere outside.
    #[inline]
    pub fn has_positive_energy(&self, local: DVec3) -> bool {
        self.rests() || self.drift == DVec3::ZERO || self.dragging(self.at_rest_direction(local).normalize()) > 0.0
    }

    /// Measured over chart solid angle around the unit chart direction `looked`.
    #[inline]
    pub fn solid_angle_factor(&self, looked: DVec3) -> f64 {
        if self.rests() { self.frame.solid_angle_factor(looked) } else { self.moving_solid_angle_factor(looked) }
    }

    #[cold]
    fn moving_solid_angle_factor(&self, looked: DVec3) -> f64 {
        let d = self.reference_direction(looked);
        let doppler = self.doppler(d);
        let of_reference = if self.drift == DVec3::ZERO {
            self.frame.solid_angle_factor(looked)
        } else {
            let length = (self.frame.unapply(d) - self.drift).length();
            self.frame.volume_factor() * length * length * length / self.dragging(d)
        };
        of_reference / (doppler * doppler)
    }

    /// The unit measured normal, at rest, of a surface with the given unit chart normal.
    #[inline]
    pub fn local_normal(&self, chart: DVec3) -> DVec3 {
        self.frame.local_normal(chart)
    }

    /// Measured over chart area across a bundle of light in the unit chart direction `d`: the same for all observers at a place.
    #[inline]
    pub fn bundle_area_factor(&self, d: DVec3) -> f64 {
        if self.drift == DVec3::ZERO {
            return self.frame.bundle_area_factor(d);
        }
        self.frame.volume_factor() / self.discriminant(d).2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::Dual;
    use crate::spacetime::{Kerr, Metric, Place, Spacetime, Spherical};

    fn observer() -> Observer {
        let root = Stretch::along_two([DVec3::X, DVec3::Z], [1.4, 0.8]);
        let here = Stationary { lapse: 0.7, root, beta: DVec3::ZERO };
        Observer::at_rest(&here).moving(DVec3::new(0.3, -0.5, 0.2))
    }

    #[test]
    fn directions_round_trip() {
        let o = observer();
        for d in [DVec3::X, DVec3::new(0.3, -0.4, 0.8), DVec3::new(-0.9, 0.1, -0.3)] {
            let d = d.normalize();
            assert!((o.chart_direction(o.local_direction(d)) - d).length() < 1e-14);
        }
    }

    #[test]
    fn solid_angles_agree_with_finite_differences() {
        let (o, d, eps) = (observer(), DVec3::new(0.2, -0.7, 0.4).normalize(), 1e-5);
        let (a, b) = d.any_orthonormal_pair();
        let moved = |s: f64, t: f64| o.local_direction((d + a * s * eps + b * t * eps).normalize());
        let cell = (moved(0.5, 0.0) - moved(-0.5, 0.0)).cross(moved(0.0, 0.5) - moved(0.0, -0.5)).length();
        assert!((cell / (eps * eps) / o.solid_angle_factor(d) - 1.0).abs() < 1e-6);
    }

    /// Against the static observer, where there is one, boosted to the same 4-velocity; and in the ergosphere against the metric.
    #[test]
    fn who_is_dragged_measures_what_the_static_one_does_who_moves_so() {
        let round = Spherical { center: DVec3::ZERO, rs: 2.0, charge_squared: 0.0 };
        let hole = Kerr::new(round, DVec3::new(0.6, 0.0, 0.8), 0.9);
        for x in [DVec3::new(4.0, 1.0, -2.0), DVec3::new(-0.5, 3.0, 0.2)] {
            let (normal, here) = (hole.normal(Place::near(x)).unwrap(), hole.at(Place::near(x)).unwrap());
            // v = gamma^(1/2) V / (N (1 + beta V))
            let v = here.root.apply(normal.drag) / (here.lapse * (1.0 + here.beta.dot(normal.drag)));
            let (a, b) = (Observer::dragged(&normal), Observer::at_rest(&here).moving_where(here.beta, v));
            let turned = Observer::dragged(&normal).moving(DVec3::new(0.1, -0.5, 0.3));
            assert!((a.clock_rate() - b.clock_rate()).abs() < 1e-14);
            for d in [DVec3::X, DVec3::new(0.3, -0.4, 0.8), DVec3::new(-0.9, 0.1, -0.3)] {
                let d = d.normalize();
                assert!((a.ratio(d) - b.ratio(d)).abs() < 1e-13);
                assert!((a.solid_angle_factor(d) / b.solid_angle_factor(d) - 1.0).abs() < 1e-12);
                assert!((a.bundle_area_factor(d) / b.bundle_area_factor(d) - 1.0).abs() < 1e-12);
                for o in [a, turned] {
                    assert!((o.chart_direction(o.local_direction(d)) - d).length() < 1e-13);
                    let (s, t) = d.any_orthonormal_pair();
                    let (h, moved) = (1e-5, |u: f64, v: f64| o.local_direction((d + (s * u + t * v) * 1e-5).normalize()));
                    let cell = (moved(0.5, 0.0) - moved(-0.5, 0.0)).cross(moved(0.0, 0.5) - moved(0.0, -0.5)).length();
                    assert!((cell / (h * h) / o.solid_angle_factor(d) - 1.0).abs() < 1e-6);
                }
            }
        }
        // Static observers are the same whatever the reference: from the one to the other with -drag.
        let x = DVec3::new(-0.5, 1.7, 0.5);
        assert!(hole.at(Place::near(x)).is_none(), "the ergosphere");
        let normal = hole.normal(Place::near(x)).unwrap();
        let o = Observer::dragged(&normal).moving(DVec3::new(0.2, 0.3, -0.1));
        let inverse = hole.inverse(Dual::variables(x));
        for local in [DVec3::X, DVec3::new(0.3, -0.4, 0.8), DVec3::new(-0.9, 0.1, -0.3)] {
            let local = local.normalize();
            if !o.has_positive_energy(local) {
                continue;
            }
            let looked = o.chart_direction(local);
            assert!((o.local_direction(looked) - local).length() < 1e-12);
            // Light that arrives from there moves along -looked: its momentum as the dragged one has it, of energy 1 far away.
            let l = Observer::dragged(&normal).local_direction(looked);
            let energy = 1.0 / (normal.lapse - l.dot(normal.root.apply(normal.drag)));
            let p = normal.root.apply(-l) * energy;
            assert!(inverse.norm(p).value.abs() < 1e-11, "{}", inverse.norm(p).value);
            assert!(inverse.velocity(p).normalize().distance(-looked) < 1e-12);
            assert!((Observer::dragged(&normal).ratio(looked) * energy - 1.0).abs() < 1e-12);
        }
    }

    /// Against the Lorentz transformation of the light's 4-vector, component by component.
    #[test]
    fn light_is_boosted() {
        let v = 0.6;
        let o = Observer::FLAT.moving(DVec3::X * v);
        let looked = DVec3::new(0.28, 0.96, 0.0);
        // Momentum of light of energy 1 that moves along -looked, seen from one who moves along x.
        let k = 1.0 / (1.0f64 - v * v).sqrt();
        let p = -looked;
        let (energy, moved) = (k * (1.0 - v * p.x), DVec3::new(k * (p.x - v), p.y, p.z));
        assert!((o.ratio(looked) - 1.0 / energy).abs() < 1e-15);
        assert!((o.local_direction(looked) + moved / energy).length() < 1e-15);
        // Ahead everything is blue, and a clock that passes is slow.
        assert!(o.ratio(DVec3::X) < 1.0 && o.ratio(-DVec3::X) > 1.0);
        assert!((o.clock_rate() - 0.8).abs() < 1e-15);
        assert_eq!((o.without_shift().ratio(looked), o.without_shift().clock_rate()), (1.0, 1.0));
    }
}
