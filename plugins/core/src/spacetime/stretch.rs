//! The symmetric root of a spatial metric: what turns chart vectors into measured ones.

use bhs_elementary::Elementary;
use glam::{DMat3, DVec3};

/// A symmetric positive matrix by two of its axes: the third has the factor 1, and all are multiplied by `scale`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stretch {
    scale: f64,
    /// Unit vectors; the second one means nothing where its factor is 1.
    axes: [DVec3; 2],
    /// 1 over the factors along the axes: what chart directions of measured ones take, which are asked for most.
    inverses: [f64; 2],
}

impl Stretch {
    /// Chart and measured lengths are the same.
    pub const IDENTITY: Self = Self::isotropic(1.0);

    /// The same `factor` in all directions.
    pub const fn isotropic(factor: f64) -> Self {
        Self { scale: factor, axes: [DVec3::Z, DVec3::X], inverses: [1.0, 1.0] }
    }

    /// Lengths along the unit vector `axis` are divided by `divisor`.
    #[inline]
    pub fn along(axis: DVec3, divisor: f64) -> Self {
        Self { axes: [axis, axis], inverses: [divisor, 1.0], scale: 1.0 }
    }

    /// Lengths along each of two unit vectors at right angles are multiplied by its factor.
    pub fn along_two(axes: [DVec3; 2], factors: [f64; 2]) -> Self {
        Self { scale: 1.0, axes, inverses: factors.map(f64::recip) }
    }

    /// The root of the symmetric matrix `gamma`; `None` if it is not positive.
    pub fn of_metric(gamma: DMat3) -> Option<Self> {
        let (values, vectors) = eigen(gamma);
        let roots = values.map(f64::sqrt);
        let usable = roots.iter().all(|r| *r > 0.0 && r.is_finite());
        // The middle one is the scale, so that factors stay moderate.
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| roots[*a].total_cmp(&roots[*b]));
        let [low, middle, high] = order;
        let scale = roots[middle];
        let factors = [roots[high] / scale, roots[low] / scale];
        usable.then(|| Self { scale, ..Self::along_two([vectors[high], vectors[low]], factors) })
    }

    /// Whether directions are the same in the chart and as measured.
    #[inline]
    pub fn keeps_directions(&self) -> bool {
        self.inverses == [1.0, 1.0]
    }

    #[inline]
    fn factors(&self) -> [f64; 2] {
        self.inverses.map(f64::recip)
    }

    #[inline]
    fn stretched(&self, v: DVec3, by: [f64; 2]) -> DVec3 {
        let [first, second] = self.axes;
        let mut sum = v + first * (v.dot(first) * (by[0] - 1.0));
        if by[1] != 1.0 {
            sum += second * (v.dot(second) * (by[1] - 1.0));
        }
        sum
    }

    /// The measured vector of a chart vector.
    #[inline]
    pub fn apply(&self, chart: DVec3) -> DVec3 {
        self.stretched(chart, self.factors()) * self.scale
    }

    /// The chart vector of a measured vector.
    #[inline]
    pub fn unapply(&self, local: DVec3) -> DVec3 {
        self.stretched(local, self.inverses) / self.scale
    }

    /// The unit measured direction of a unit chart direction.
    #[inline]
    pub fn local_direction(&self, chart: DVec3) -> DVec3 {
        if self.keeps_directions() { chart } else { self.stretched(chart, self.factors()).normalize() }
    }

    /// The unit chart direction of a measured direction.
    #[inline]
    pub fn chart_direction(&self, local: DVec3) -> DVec3 {
        if self.keeps_directions() { normalized(local) } else { self.stretched(local, self.inverses).normalize() }
    }

    /// The unit measured normal of a surface with the given unit chart normal.
    #[inline]
    pub fn local_normal(&self, chart: DVec3) -> DVec3 {
        if self.keeps_directions() { chart } else { self.chart_direction(chart) }
    }

    /// Measured volume over chart volume: the root of the determinant of the metric.
    #[inline]
    pub fn volume_factor(&self) -> f64 {
        self.scale * self.scale * self.scale / (self.inverses[0] * self.inverses[1])
    }

    /// Measured area over chart area of a surface with the unit chart normal `n`.
    #[inline]
    pub fn area_factor(&self, n: DVec3) -> f64 {
        self.volume_factor() * self.unapply(n).length()
    }

    /// Measured over chart area across a bundle of light in the unit chart direction `d`.
    #[inline]
    pub fn bundle_area_factor(&self, d: DVec3) -> f64 {
        self.volume_factor() / self.apply(d).length()
    }

    /// Measured over chart solid angle around the unit chart direction `d`.
    #[inline]
    pub fn solid_angle_factor(&self, d: DVec3) -> f64 {
        if self.keeps_directions() {
            return 1.0;
        }
        let length = self.apply(d).length();
        self.volume_factor() / (length * length * length)
    }
}

/// The unit vector along `v`. Of one that has the length 1 but for the rounding of single precision, as directions that materials choose,
/// by the series of the root, to all digits: it takes a third of the time of a root and a division.
#[inline]
fn normalized(v: DVec3) -> DVec3 {
    let over = v.length_squared() - 1.0;
    if over.abs() < 4e-6 { v * (1.0 - over * (0.5 - over * (0.375 - over * 0.3125))) } else { v.normalize() }
}

/// Eigenvalues and unit eigenvectors of a symmetric matrix, by Jacobi's rotations.
fn eigen(m: DMat3) -> ([f64; 3], [DVec3; 3]) {
    let mut a: [[f64; 3]; 3] = m.to_cols_array_2d();
    let mut v: [[f64; 3]; 3] = DMat3::IDENTITY.to_cols_array_2d();
    for _ in 0..32 {
        let off = a[0][1].abs() + a[0][2].abs() + a[1][2].abs();
        if off <= f64::MIN_POSITIVE {
            break;
        }
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            if a[p][q] == 0.0 {
                continue;
            }
            let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
            let t = theta.signum() / (theta.abs() + theta.hypotenuse(1.0));
            let c = 1.0 / t.hypotenuse(1.0);
            let s = t * c;
            let before = a;
            for k in 0..3 {
                a[k][p] = c * before[k][p] - s * before[k][q];
                a[k][q] = s * before[k][p] + c * before[k][q];
            }
            let before = a;
            for k in 0..3 {
                a[p][k] = c * before[p][k] - s * before[q][k];
                a[q][k] = s * before[p][k] + c * before[q][k];
            }
            (a[p][q], a[q][p]) = (0.0, 0.0);
            for k in 0..3 {
                let (x, y) = (v[p][k], v[q][k]);
                v[p][k] = c * x - s * y;
                v[q][k] = s * x + c * y;
            }
        }
    }
    ([a[0][0], a[1][1], a[2][2]], v.map(DVec3::from_array))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gamma() -> DMat3 {
        let a = DMat3::from_cols_array(&[1.3, 0.2, -0.4, 0.1, 0.9, 0.3, 0.5, -0.2, 1.7]);
        a.transpose() * a
    }

    #[test]
    fn roots_square_to_the_metric() {
        let root = Stretch::of_metric(gamma()).unwrap();
        for v in [DVec3::X, DVec3::Y, DVec3::new(0.3, -0.7, 0.2)] {
            assert!((root.apply(root.apply(v)) - gamma() * v).length() < 1e-14);
            assert!((root.unapply(root.apply(v)) - v).length() < 1e-14);
            assert!((root.chart_direction(root.local_direction(v.normalize())) - v.normalize()).length() < 1e-14);
        }
        assert!((root.volume_factor() - gamma().determinant().sqrt()).abs() < 1e-13);
        assert!(Stretch::of_metric(DMat3::from_diagonal(DVec3::new(1.0, -1.0, 1.0))).is_none());
        assert_eq!(Stretch::of_metric(DMat3::IDENTITY).unwrap().apply(DVec3::X), DVec3::X);
    }

    /// To the last digit but one, on both sides of where the series ends.
    #[test]
    fn nearly_unit_vectors_become_unit_vectors() {
        let unit = DVec3::new(0.48, -0.64, 0.6);
        for length in [1.0, 1.0 + 1e-9, 1.0 - 6e-8, 1.0 + 1.9e-6, 1.0 - 1.9e-6, 1.0 + 2.1e-6, 0.5, 3.0] {
            let error = (Stretch::IDENTITY.chart_direction(unit * length) - unit).length();
            assert!(error <= 4e-16, "{length}: {error}");
        }
    }

    #[test]
    fn measures_agree_with_finite_differences() {
        let root = Stretch::of_metric(gamma()).unwrap();
        let d = DVec3::new(0.2, -0.7, 0.4).normalize();
        let (a, b) = d.any_orthonormal_pair();
        let eps = 1e-5;
        let moved = |s: f64, t: f64| root.local_direction((d + a * s * eps + b * t * eps).normalize());
        let cell = (moved(0.5, 0.0) - moved(-0.5, 0.0)).cross(moved(0.0, 0.5) - moved(0.0, -0.5)).length();
        assert!((cell / (eps * eps) / root.solid_angle_factor(d) - 1.0).abs() < 1e-6);
        // A parallelogram of surface with normal d, and its part across a bundle along d.
        let area = root.apply(a).cross(root.apply(b));
        assert!((area.length() / root.area_factor(d) - 1.0).abs() < 1e-12);
        assert!((area.normalize().dot(root.local_normal(d)).abs() - 1.0).abs() < 1e-12);
        assert!((area.dot(root.local_direction(d)).abs() / root.bundle_area_factor(d) - 1.0).abs() < 1e-12);
    }
}
