//! The black hole and the frames of those who stand near it.
//!
//! World space is the areal Schwarzschild chart drawn as Euclidean space: a point's distance from the centre *is* the
//! Schwarzschild r, angles are Euclidean ("chart" below). What a surface or a camera does with light it does in the frame of a
//! static observer at its place ("local"). `f(r) = 1 - rs/r`.

use glam::DVec3;

/// Which frame surfaces and the camera measure angles in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameConvention {
    /// The static observer's: physically right.
    Static,
    /// The chart's own angles, as in Aikawa, Zhou and Wang 2019.
    Chart,
}

/// A Schwarzschild black hole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlackHole {
    /// Centre (scene units); render space in a built [`crate::scene::Scene`].
    pub center: DVec3,
    /// Schwarzschild radius, 2M with G = c = 1 (scene units).
    pub rs: f64,
    /// Whether wavelengths shift along a ray.
    pub redshift: bool,
    /// Whether radiance shifts with them, as it does in nature (`L lambda^5` is constant); without it, as in Aikawa, Zhou and
    /// Wang 2019, wavelengths alone do.
    pub radiance_shift: bool,
    /// The frame of cameras, lights and materials.
    pub frame: FrameConvention,
}

impl BlackHole {
    /// Critical impact parameter: rays that come from far away with a smaller one are captured.
    pub fn critical_impact_parameter(&self) -> f64 {
        1.5 * 3f64.sqrt() * self.rs
    }

    /// The observer who stands still at `point`; `None` at and inside the horizon, where nobody can.
    #[inline]
    pub fn observer(&self, point: DVec3) -> Option<Observer> {
        let from_center = point - self.center;
        let r = from_center.length();
        let f = 1.0 - self.rs / r;
        if f <= 0.0 || !f.is_finite() {
            return None;
        }
        let frame = match self.frame {
            FrameConvention::Static => LocalFrame { radial: from_center / r, sqrt_f: f.sqrt() },
            FrameConvention::Chart => LocalFrame::FLAT,
        };
        Some(Observer { frame, lapse: if self.redshift { f.sqrt() } else { 1.0 } })
    }
}

/// Who measures at one place: axes, and the rate of the clock.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observer {
    /// Turns chart directions into measured ones.
    pub frame: LocalFrame,
    /// Wavelength here over wavelength at infinity: `sqrt(f(r))`; 1 where nothing shifts. One observer sees the light of
    /// another shifted by the ratio: `lambda_observed / lambda_emitted = observer.lapse / emitter.lapse`.
    pub lapse: f64,
}

impl Observer {
    /// The observer of flat space.
    pub const FLAT: Self = Self { frame: LocalFrame::FLAT, lapse: 1.0 };
}

/// The frame of a static observer, relative to the chart: the same axes, with lengths along `radial` multiplied by
/// `1/sqrt(f)`. `sqrt_f = 1` is flat space and the chart convention.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LocalFrame {
    /// Unit vector away from the hole.
    pub radial: DVec3,
    /// `sqrt(1 - rs/r)`.
    pub sqrt_f: f64,
}

impl LocalFrame {
    /// The frame in which chart and local directions agree.
    pub const FLAT: Self = Self { radial: DVec3::Z, sqrt_f: 1.0 };

    #[inline]
    fn scale_radial(&self, v: DVec3, factor: f64) -> DVec3 {
        if self.sqrt_f == 1.0 { v } else { v + self.radial * (v.dot(self.radial) * (factor - 1.0)) }
    }

    /// The unit local direction of a unit chart direction.
    #[inline]
    pub fn local_direction(&self, chart: DVec3) -> DVec3 {
        if self.sqrt_f == 1.0 {
            return chart;
        }
        self.scale_radial(chart, 1.0 / self.sqrt_f).normalize()
    }

    /// The unit chart direction of a local direction.
    #[inline]
    pub fn chart_direction(&self, local: DVec3) -> DVec3 {
        self.scale_radial(local, self.sqrt_f).normalize()
    }

    /// The unit local normal of a surface with the given unit chart normal: normals scale inversely to directions.
    #[inline]
    pub fn local_normal(&self, chart: DVec3) -> DVec3 {
        if self.sqrt_f == 1.0 {
            return chart;
        }
        self.scale_radial(chart, self.sqrt_f).normalize()
    }

    /// Local area over chart area, for a surface element with unit chart normal `n`.
    #[inline]
    pub fn area_factor(&self, n: DVec3) -> f64 {
        if self.sqrt_f == 1.0 {
            return 1.0;
        }
        self.scale_radial(n, self.sqrt_f).length() / self.sqrt_f
    }

    /// Local over chart area across a bundle of light in the unit chart direction `d`.
    #[inline]
    pub fn bundle_area_factor(&self, d: DVec3) -> f64 {
        if self.sqrt_f == 1.0 {
            return 1.0;
        }
        // Of the surface element at right angles to it in the chart, what the observer sees across the bundle.
        self.area_factor(d) * self.local_normal(d).dot(self.local_direction(d))
    }

    /// Local solid angle over chart solid angle, around the unit chart direction `d`.
    #[inline]
    pub fn solid_angle_factor(&self, d: DVec3) -> f64 {
        if self.sqrt_f == 1.0 {
            return 1.0;
        }
        let stretched = self.scale_radial(d, 1.0 / self.sqrt_f).length();
        1.0 / (self.sqrt_f * stretched * stretched * stretched)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hole() -> BlackHole {
        BlackHole {
            center: DVec3::new(1.0, 2.0, 3.0),
            rs: 0.5,
            redshift: true,
            radiance_shift: true,
            frame: FrameConvention::Static,
        }
    }

    #[test]
    fn nobody_stands_inside_the_horizon() {
        let h = hole();
        for r in [0.0, 0.25, 0.5] {
            assert_eq!(h.observer(h.center + DVec3::X * r), None);
        }
        assert!(h.observer(h.center + DVec3::X * 0.500001).is_some());
    }

    #[test]
    fn directions_round_trip_and_angles_follow_the_tangent_rule() {
        let h = hole();
        let frame = h.observer(h.center + DVec3::Z * 0.8).unwrap().frame;
        for i in 0..50 {
            let alpha = 0.03 + i as f64 * 0.06;
            let chart = DVec3::new(alpha.sin(), 0.0, alpha.cos());
            let local = frame.local_direction(chart);
            assert!((frame.chart_direction(local) - chart).length() < 1e-14);
            // tan(alpha_local) = sqrt(f) tan(alpha_chart)
            let (t, expected) = (local.x / local.z, frame.sqrt_f * chart.x / chart.z);
            assert!((t - expected).abs() < 1e-12 * expected.abs().max(1.0));
        }
    }

    #[test]
    fn measures_agree_with_finite_differences() {
        let h = hole();
        let frame = h.observer(h.center + DVec3::new(0.3, 0.5, -0.4)).unwrap().frame;
        let d = DVec3::new(0.2, -0.7, 0.4).normalize();
        let (a, b) = d.any_orthonormal_pair();
        let eps = 1e-5;
        // A small parallelogram of directions.
        let moved = |s: f64, t: f64| frame.local_direction((d + a * s * eps + b * t * eps).normalize());
        let cell = (moved(0.5, 0.0) - moved(-0.5, 0.0)).cross(moved(0.0, 0.5) - moved(0.0, -0.5)).length();
        assert!((cell / (eps * eps) / frame.solid_angle_factor(d) - 1.0).abs() < 1e-6);
        // A small parallelogram of surface with normal d: proper lengths stretch radially by 1/sqrt(f).
        let proper = |v: DVec3| frame.scale_radial(v, 1.0 / frame.sqrt_f);
        let area = proper(a).cross(proper(b));
        assert!((area.length() / frame.area_factor(d) - 1.0).abs() < 1e-12);
        assert!((area.normalize().dot(frame.local_normal(d)).abs() - 1.0).abs() < 1e-12);
    }
}
