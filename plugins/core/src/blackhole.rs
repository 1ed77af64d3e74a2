//! The black hole and the frames of those who stand near it.
//!
//! World space is the areal Schwarzschild chart drawn as Euclidean space: a point's distance from the centre *is* the
//! Schwarzschild r, angles are Euclidean ("chart" below). What a surface or a camera does with light it does in the frame of a
//! static observer at its place ("local"). `f(r) = 1 - rs/r`.

use crate::observer::{Conventions, FrameConvention, Observer};
use crate::spacetime::{Stationary, Stretch};
use glam::DVec3;

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
        let lapse = f.sqrt();
        let here = Stationary { lapse, root: Stretch::along(from_center / r, lapse), beta: DVec3::ZERO };
        Some(self.conventions().observer(&here))
    }

    /// What the picture takes of nature.
    #[inline]
    pub fn conventions(&self) -> Conventions {
        let Self { redshift, radiance_shift, frame, .. } = *self;
        Conventions { redshift, radiance_shift, frame }
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
            let (t, expected) = (local.x / local.z, (1.0 - 0.5f64 / 0.8).sqrt() * chart.x / chart.z);
            assert!((t - expected).abs() < 1e-12 * expected.abs().max(1.0));
        }
    }
}
