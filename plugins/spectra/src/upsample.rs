//! Smooth spectra between 0 and 1 for colours.
//!
//! Jakob and Hanika 2019, "A Low-Dimensional Function Space for Efficient Spectral Upsampling", eq. (8): a quadratic of
//! wavelength through the sigmoid `s(x) = 1/2 + x / (2 sqrt(1 + x^2))`. Their tables of coefficients are not needed: the fit
//! is done for each colour of a scene, by Levenberg and Marquardt's method in linear sRGB. It starts from grey, where the answer is
//! known, and goes on with few wavelengths until they are satisfied, then with all. Where that does not lead to the colour, which
//! happens at the edges of the gamut, the fit follows the colour from grey to where it is wanted, in small steps.

use crate::quadrature::Quadrature;
use bhs_colour::OBSERVER_RANGE;
use glam::{DMat3, DVec3};

/// Centre and half width of the observer's range (nm): the quadratic is one of `t = (lambda - centre) / half width`.
const CENTRE: f32 = (OBSERVER_RANGE[0] + OBSERVER_RANGE[1]) / 2.0;
const HALF_WIDTH: f32 = (OBSERVER_RANGE[1] - OBSERVER_RANGE[0]) / 2.0;

/// Colours are moved into this margin of the unit cube before the fit: at 0 and 1 the coefficients would be infinite.
pub(crate) const MARGIN: f64 = 1e-5;

/// A smooth function of wavelength between 0 and 1. Outside the observer's range it keeps its end value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sigmoid {
    /// Coefficients of t^2, t and 1.
    c: [f32; 3],
}

impl Sigmoid {
    /// The function with the given coefficients of t^2, t and 1.
    pub(crate) fn of_coefficients(c: [f32; 3]) -> Self {
        Self { c }
    }

    /// The function whose colour under D65 is `rgb` (linear sRGB, each between 0 and 1).
    pub fn fit(rgb: [f64; 3]) -> Self {
        let target = DVec3::from_array(rgb).clamp(DVec3::splat(MARGIN), DVec3::splat(1.0 - MARGIN));
        let near = solve(grey(target), target, Quadrature::coarse()).c;
        let direct = solve(near, target, Quadrature::fine());
        let c = if direct.is_exact() { direct.c } else { follow(target) };
        Self { c: c.to_array().map(|x| x as f32) }
    }

    /// The value at a wavelength (nm).
    pub fn at(&self, lambda_nm: f32) -> f32 {
        self.at_t(((lambda_nm - CENTRE) / HALF_WIDTH).clamp(-1.0, 1.0))
    }

    /// An upper bound of the value over `lo..=hi` (nm).
    pub fn max(&self, lo: f32, hi: f32) -> f32 {
        let [lo, hi] = [lo, hi].map(|l| ((l - CENTRE) / HALF_WIDTH).clamp(-1.0, 1.0));
        let ends = self.at_t(lo).max(self.at_t(hi));
        // The top of the parabola, if it has one in the range. A hair is added against round-off.
        let top = -self.c[1] / (2.0 * self.c[0]);
        let inside = if top > lo && top < hi { self.at_t(top) } else { 0.0 };
        (ends.max(inside) * (1.0 + 4.0 * f32::EPSILON)).min(1.0)
    }

    fn at_t(&self, t: f32) -> f32 {
        let x = (self.c[0] * t + self.c[1]) * t + self.c[2];
        // 1/2 + x/(2 sqrt(1+x^2)) cancels for x far below zero; there it is 1/(2 sqrt(1+x^2) (sqrt(1+x^2) - x)).
        let root = (1.0 + x * x).sqrt();
        if x < 0.0 { 0.5 / (root * (root - x)) } else { 0.5 + 0.5 * x / root }
    }
}

/// The coefficients of the grey that is as light as `target`: a grey reflectance is constant, so the sigmoid is inverted.
fn grey(target: DVec3) -> DVec3 {
    let y = 2.0 * target.element_sum() / 3.0 - 1.0;
    DVec3::new(0.0, 0.0, y / (1.0 - y * y).sqrt())
}

/// The coefficients for `target`, by way of the colours between it and grey.
fn follow(target: DVec3) -> DVec3 {
    let mean = DVec3::splat(target.element_sum() / 3.0);
    let stations = ((target - mean).abs().max_element() * 16.0).ceil().max(1.0);
    (1..=stations as u32)
        .fold(grey(target), |c, station| solve(c, mean.lerp(target, f64::from(station) / stations), Quadrature::fine()).c)
}

/// Where the search for coefficients has led.
pub(crate) struct Solution {
    /// The coefficients of t^2, t and 1.
    pub c: DVec3,
    /// Square of the distance between their colour and the one that was looked for.
    error: f64,
}

impl Solution {
    fn is_exact(&self) -> bool {
        self.error < 1e-20
    }
}

/// The coefficients nearest to `start` whose colour is nearest to `goal`.
pub(crate) fn solve(start: DVec3, goal: DVec3, quadrature: &Quadrature) -> Solution {
    let mut c = start;
    let (mut residual, mut jacobian) = residual(c, goal, quadrature);
    let mut damping = 1e-4;
    for _ in 0..60 {
        if residual.length_squared() < 1e-20 {
            break;
        }
        let normal = jacobian.transpose() * jacobian;
        let diagonal = DVec3::new(normal.x_axis.x, normal.y_axis.y, normal.z_axis.z);
        let damped = normal + DMat3::from_diagonal(damping * diagonal + 1e-14);
        let next = c - damped.inverse() * (jacobian.transpose() * residual);
        let (next_residual, next_jacobian) = self::residual(next, goal, quadrature);
        if next.is_finite() && next_residual.length_squared() < residual.length_squared() {
            (c, residual, jacobian) = (next, next_residual, next_jacobian);
            damping = (damping * 0.1).max(1e-12);
        } else {
            damping *= 10.0;
            if damping > 1e12 {
                break;
            }
        }
    }
    Solution { c, error: residual.length_squared() }
}

/// How far the colour of the coefficients `c` is from `goal`, and the derivative of that by `c`.
fn residual(c: DVec3, goal: DVec3, quadrature: &Quadrature) -> (DVec3, DMat3) {
    let (colour, jacobian) = quadrature.colour(c);
    (colour - goal, jacobian)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colorimetry::{colorimetry, tests::xyz};
    use bhs_colour::srgb_from_xyz;
    use bhs_core::spectrum::Spectrum;

    fn colour_under_d65(s: &Sigmoid) -> [f64; 3] {
        srgb_from_xyz(xyz(|l| s.at(l) * colorimetry().d65.at(l)))
    }

    /// The largest round-trip error over a grid of colours from `lo` to `hi` with `n` values a channel.
    fn worst(lo: f64, hi: f64, n: u32) -> f64 {
        let level = |i: u32| lo + (hi - lo) * f64::from(i) / f64::from(n - 1);
        let mut worst = 0.0f64;
        for i in 0..n * n * n {
            let rgb = [level(i % n), level(i / n % n), level(i / n / n)];
            let back = colour_under_d65(&Sigmoid::fit(rgb));
            let error = (0..3).map(|c| (back[c] - rgb[c]).abs()).fold(0.0, f64::max);
            worst = worst.max(error);
        }
        worst
    }

    #[test]
    fn colours_inside_the_cube_come_back() {
        let error = worst(0.05, 0.95, 7);
        assert!(error < 3e-5, "{error}");
    }

    #[test]
    fn colours_on_the_cubes_faces_come_back() {
        let error = worst(0.0, 1.0, 5);
        assert!(error < 3e-5, "{error}");
    }

    #[test]
    fn the_fit_itself_is_closer_still() {
        for i in 0..216u32 {
            let rgb = [i % 6, i / 6 % 6, i / 36].map(|l| f64::from(l) / 5.0);
            let s = Sigmoid::fit(rgb);
            for c in 0..3 {
                let weights = colorimetry().reflectance_weights.iter().enumerate();
                let back: f64 = weights.map(|(l, w)| w[c] * f64::from(s.at(OBSERVER_RANGE[0] + l as f32))).sum();
                assert!((back - rgb[c]).abs() < 2e-5, "{rgb:?} {c}: {back}");
            }
        }
    }

    #[test]
    fn the_direct_way_ends_where_the_long_one_does() {
        let mut direct = 0;
        for i in 0..9u32.pow(3) {
            let rgb = DVec3::from_array([i % 9, i / 9 % 9, i / 81].map(|l| f64::from(l) / 8.0));
            let target = rgb.clamp(DVec3::splat(MARGIN), DVec3::splat(1.0 - MARGIN));
            let near = solve(grey(target), target, Quadrature::coarse()).c;
            direct += u32::from(solve(near, target, Quadrature::fine()).is_exact());
            let [c, followed] = [Sigmoid::fit(rgb.to_array()), Sigmoid { c: follow(target).to_array().map(|x| x as f32) }];
            for l in 36..=83 {
                let (a, b) = (c.at(l as f32 * 10.0), followed.at(l as f32 * 10.0));
                assert!((a - b).abs() < 1e-5, "{rgb} {l}: {a} {b}");
            }
        }
        // All but the edges of the gamut.
        assert!(direct >= 7 * 7 * 7, "{direct}");
    }

    #[test]
    fn greys_are_flat_and_bounds_hold() {
        for grey in [0.0, 0.18, 0.5, 1.0] {
            let s = Sigmoid::fit([grey; 3]);
            assert!((400..700).all(|l| (f64::from(s.at(l as f32)) - grey).abs() < 2e-5));
        }
        for rgb in [[0.9, 0.1, 0.1], [0.1, 0.9, 0.1], [0.1, 0.2, 0.9], [0.9, 0.1, 0.9]] {
            let s = Sigmoid::fit(rgb);
            for (lo, hi) in [(360.0, 830.0), (450.0, 520.0), (100.0, 3000.0)] {
                let bound = s.max(lo, hi);
                let top = (0..=1000).map(|i| s.at(lo + (hi - lo) * i as f32 / 1000.0)).fold(0.0, f32::max);
                assert!(top <= bound && bound <= top + 1e-4, "{rgb:?} {lo} {hi}: {top} {bound}");
            }
            assert_eq!(s.at(200.0), s.at(360.0));
        }
    }
}
