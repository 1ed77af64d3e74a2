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

use crate::diagnostics::shorten;
use crate::params::Params;
use crate::spacetime::{Stationary, Stretch};
use glam::DVec3;

/// Who measures light at one place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observer {
    /// What the static observer at the place measures of chart vectors.
    pub frame: Stretch,
    /// Rate of the static observer's clock against that of one far away; 1 where nothing shifts.
    lapse: f64,
    /// Velocity against the static observer, in the static frame (units of c).
    velocity: DVec3,
    /// Whether it moves.
    moves: bool,
    /// Whether motion shifts wavelengths.
    shifts: bool,
}

/// Which frame surfaces and the camera measure angles in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameConvention {
    /// The static observer's: physically right.
    Static,
    /// The chart's own angles, as in Aikawa, Zhou and Wang 2019.
    Chart,
}

/// What a picture takes of nature, and what it leaves out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conventions {
    /// Whether wavelengths shift along a ray.
    pub redshift: bool,
    /// Whether radiance shifts with them, as it does in nature (`L lambda^5` is constant); without it, as in Aikawa, Zhou and
    /// Wang 2019, wavelengths alone do.
    pub radiance_shift: bool,
    /// The frame of cameras, lights and materials.
    pub frame: FrameConvention,
}

impl Conventions {
    /// Spectral radiance per wavelength at E = 1 over that where the wavelength is `ratio` times as long: `L lambda^5` is constant along a
    /// ray (Liouville; I_nu/nu^3 is invariant).
    #[inline]
    pub fn radiance_factor(&self, ratio: f64) -> f32 {
        if ratio == 1.0 || !self.radiance_shift { 1.0 } else { ratio.powi(5) as f32 }
    }

    /// All that there is.
    pub const NATURE: Self = Self { redshift: true, radiance_shift: true, frame: FrameConvention::Static };

    /// Those that the parameters of a spacetime's directive state; `None` if something is wrong with them.
    pub fn read(p: &Params) -> Option<Self> {
        let redshift = p.get("redshift", true, "", "whether wavelengths and radiance shift along a ray");
        let radiance =
            p.get("radiance", "full".to_owned(), "", "what redshift does to radiance: `full`, or `shift-only`: nothing");
        let frame = p.get("frame", "static".to_owned(), "", "whose angles count: `static` observers' or the `chart`'s");
        let frame = match frame.as_str() {
            "static" => Some(FrameConvention::Static),
            "chart" => Some(FrameConvention::Chart),
            _ => {
                p.reject("frame", format!("unknown frame `{}`", shorten(&frame)), "expected `static` or `chart`");
                None
            }
        };
        let radiance_shift = match radiance.as_str() {
            "full" => Some(true),
            "shift-only" => Some(false),
            _ => {
                p.reject("radiance", format!("unknown radiance `{}`", shorten(&radiance)), "expected `full` or `shift-only`");
                None
            }
        };
        Some(Self { redshift, radiance_shift: radiance_shift?, frame: frame? })
    }

    /// The observer at rest where the metric is `here`.
    #[inline]
    pub fn observer(&self, here: &Stationary) -> Observer {
        let mut observer = Observer::at_rest(here);
        if self.frame == FrameConvention::Chart {
            observer = observer.in_chart();
        }
        if self.redshift { observer } else { observer.without_shift() }
    }
}

impl Observer {
    /// The observer at rest in flat space.
    pub const FLAT: Self = Self { frame: Stretch::IDENTITY, lapse: 1.0, velocity: DVec3::ZERO, moves: false, shifts: true };

    /// The static observer where the metric is `here`.
    #[inline]
    pub fn at_rest(here: &Stationary) -> Self {
        Self { frame: here.root, lapse: here.lapse, ..Self::FLAT }
    }

    /// The same place and motion for one to whom all light keeps its wavelength: a convention of pictures, not of nature.
    #[inline]
    pub fn without_shift(self) -> Self {
        Self { lapse: 1.0, shifts: false, ..self }
    }

    /// The same place and motion for one who takes the chart's directions for those measured: a convention of pictures, not of nature.
    #[inline]
    pub fn in_chart(self) -> Self {
        Self { frame: Stretch::IDENTITY, ..self }
    }

    /// One who passes this static observer with the velocity `velocity` in its frame (units of c, less than 1).
    pub fn moving(self, velocity: DVec3) -> Self {
        Self { velocity, moves: velocity != DVec3::ZERO, ..self }
    }

    /// Velocity against the static observer, in the static frame (units of c).
    #[inline]
    pub fn velocity(&self) -> DVec3 {
        self.velocity
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

    /// Energy of the light that arrives from the static observer's unit direction `d`, over that which the static observer measures.
    #[cold]
    fn doppler(&self, d: DVec3) -> f64 {
        self.gamma() * (1.0 + self.velocity.dot(d))
    }

    /// Rate of its clock against that of one far away: `1/U^t`; 1 where nothing shifts.
    #[inline]
    pub fn clock_rate(&self) -> f64 {
        if self.rests() || !self.shifts { self.lapse } else { self.lapse / self.gamma() }
    }

    /// Wavelength here over wavelength at E = 1, of light that arrives from the unit chart direction `looked`.
    #[inline]
    pub fn ratio(&self, looked: DVec3) -> f64 {
        if self.rests() || !self.shifts {
            return self.lapse;
        }
        self.lapse / self.doppler(self.frame.local_direction(looked))
    }

    /// The unit measured direction of the unit chart direction `looked`, in which one looks.
    #[inline]
    pub fn local_direction(&self, looked: DVec3) -> DVec3 {
        let d = self.frame.local_direction(looked);
        if self.rests() { d } else { self.aberrated(d) }
    }

    /// The direction that this observer measures where the static one measures the unit direction `d`.
    #[cold]
    fn aberrated(&self, d: DVec3) -> DVec3 {
        let (v, k) = (self.velocity, self.gamma());
        ((d + v * (k * (k / (k + 1.0) * v.dot(d) + 1.0))) / self.doppler(d)).normalize()
    }

    /// A direction, not a unit vector, that the static observer measures where this one measures the unit direction `d`.
    #[cold]
    fn at_rest_direction(&self, d: DVec3) -> DVec3 {
        let (v, k) = (self.velocity, self.gamma());
        d + v * (k * (k / (k + 1.0) * v.dot(d) - 1.0))
    }

    /// The unit chart direction of the unit measured direction `local`, in which one looks.
    #[inline]
    pub fn chart_direction(&self, local: DVec3) -> DVec3 {
        let d = if self.rests() { local } else { self.at_rest_direction(local) };
        self.frame.chart_direction(d)
    }

    /// Measured over chart solid angle around the unit chart direction `looked`.
    #[inline]
    pub fn solid_angle_factor(&self, looked: DVec3) -> f64 {
        let factor = self.frame.solid_angle_factor(looked);
        if self.rests() {
            return factor;
        }
        let doppler = self.doppler(self.frame.local_direction(looked));
        factor / (doppler * doppler)
    }

    /// The unit measured normal, at rest, of a surface with the given unit chart normal.
    #[inline]
    pub fn local_normal(&self, chart: DVec3) -> DVec3 {
        self.frame.local_normal(chart)
    }

    /// Measured over chart area across a bundle of light in the unit chart direction `d`: the same for all observers at a place.
    #[inline]
    pub fn bundle_area_factor(&self, d: DVec3) -> f64 {
        self.frame.bundle_area_factor(d)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
