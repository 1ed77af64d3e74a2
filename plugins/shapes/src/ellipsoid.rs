//! Areas of the images of a sphere under linear maps.
//!
//! A linear map with cofactor matrix C stretches the area of the unit sphere around its point n by |C n|, so that the area of
//! an ellipsoid is the integral of |C n| over directions: 4 pi R_G(x, y, z) with the squared singular values of C, where R_G is
//! Carlson's complete symmetric integral (DLMF 19.16.2_5 and 19.33.1).

use bhs_elementary::Elementary;
use glam::{DMat3, DVec3};
use std::f64::consts::PI;

/// The cofactor matrix of `m`: its inverse transpose times its determinant.
pub(crate) fn cofactors(m: DMat3) -> DMat3 {
    DMat3::from_cols(m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis))
}

/// The area of the whole ellipsoid; `c` is the cofactor matrix of the map from the unit sphere, not singular.
pub(crate) fn whole_area(c: DMat3) -> f64 {
    let mut squares = singular_squares(c);
    squares.sort_by(f64::total_cmp);
    let [x, z, y] = squares;
    // Scaled to the largest, because R_D holds powers of the arguments.
    4.0 * PI * y.sqrt() * r_g(x / y, 1.0, z / y)
}

/// The area of the part with z in `z_min..z_max` and azimuth in `0..phi_max` (radians) of the unit sphere, by Gauss quadrature of
/// 64 x 64 points: 1e-9 for axes that differ threefold, 1e-5 for tenfold.
pub(crate) fn part_area(c: DMat3, z_min: f64, z_max: f64, phi_max: f64) -> f64 {
    let nodes = gauss_legendre();
    let mut sum = 0.0;
    for (s, ws) in &nodes {
        let z = z_min + (z_max - z_min) * s;
        let r = (1.0 - z * z).max(0.0).sqrt();
        for (t, wt) in &nodes {
            let (sin, cos) = (phi_max * t).sine_cosine();
            sum += ws * wt * (c * DVec3::new(r * cos, r * sin, z)).length();
        }
    }
    sum * (z_max - z_min) * phi_max
}

/// Nodes and weights of Gauss and Legendre's rule on 0..1.
pub(crate) fn gauss_legendre() -> [(f64, f64); 64] {
    let n = 64.0f64;
    std::array::from_fn(|i| {
        // Newton's method on the Legendre polynomial from Tricomi's guess of its roots.
        let mut x = (PI * (i as f64 + 0.75) / (n + 0.5)).cosine();
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut p0, mut p1) = (1.0, x);
            for k in 2..=64 {
                let k = f64::from(k);
                (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
            }
            slope = n * (x * p1 - p0) / (x * x - 1.0);
            x -= p1 / slope;
        }
        (0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope))
    })
}

/// The squared singular values of `m`, by one-sided Jacobi rotations (Hestenes 1958): small ones come out as exactly as large.
fn singular_squares(m: DMat3) -> [f64; 3] {
    let mut columns = [m.x_axis, m.y_axis, m.z_axis];
    for _ in 0..30 {
        let mut worst = 0.0f64;
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let (a, b) = (columns[p], columns[q]);
            let along = a.dot(b);
            let size = a.length() * b.length();
            if along.abs() <= f64::EPSILON * size {
                continue;
            }
            worst = worst.max(along.abs() / size);
            let zeta = (b.length_squared() - a.length_squared()) / (2.0 * along);
            let t = zeta.signum() / (zeta.abs() + zeta.hypotenuse(1.0));
            let cos = 1.0 / t.hypotenuse(1.0);
            columns[p] = (a - b * t) * cos;
            columns[q] = (a * t + b) * cos;
        }
        if worst == 0.0 {
            break;
        }
    }
    columns.map(DVec3::length_squared)
}

/// Carlson's R_G for positive arguments; `z` must be the middle one, so that no term is negative (DLMF 19.21.10).
fn r_g(x: f64, y: f64, z: f64) -> f64 {
    let (rf, rd) = r_f_and_r_d(x, y, z);
    0.5 * (z * rf - (x - z) * (y - z) * rd / 3.0 + (x * y / z).sqrt())
}

/// Carlson's R_F(x,y,z) and R_D(x,y,z) by duplication (Carlson 1995, DLMF 19.36.1 and 19.36.2).
fn r_f_and_r_d(mut x: f64, mut y: f64, mut z: f64) -> (f64, f64) {
    let (mut sum, mut power) = (0.0, 1.0);
    // The arguments approach each other fourfold a step; what is left out is of their spread's sixth power.
    for _ in 0..60 {
        let (sx, sy, sz) = (x.sqrt(), y.sqrt(), z.sqrt());
        let lambda = sx * sy + sy * sz + sz * sx;
        sum += power / (sz * (z + lambda));
        power *= 0.25;
        (x, y, z) = (0.25 * (x + lambda), 0.25 * (y + lambda), 0.25 * (z + lambda));
        if x.max(y).max(z) - x.min(y).min(z) < 1e-3 * z {
            break;
        }
    }
    let mean = (x + y + z) / 3.0;
    let (u, v) = (1.0 - x / mean, 1.0 - y / mean);
    let w = -u - v;
    let (e2, e3) = (u * v - w * w, u * v * w);
    let rf = (1.0 - e2 / 10.0 + e3 / 14.0 + e2 * e2 / 24.0 - 3.0 * e2 * e3 / 44.0) / mean.sqrt();

    let mean = (x + y + 3.0 * z) / 5.0;
    let (u, v) = (1.0 - x / mean, 1.0 - y / mean);
    let w = -(u + v) / 3.0;
    let (e2, e3) = (u * v - 6.0 * w * w, (3.0 * u * v - 8.0 * w * w) * w);
    let (e4, e5) = (3.0 * (u * v - w * w) * w * w, u * v * w * w * w);
    let series =
        1.0 - 3.0 * e2 / 14.0 + e3 / 6.0 + 9.0 * e2 * e2 / 88.0 - 3.0 * e4 / 22.0 - 9.0 * e2 * e3 / 52.0 + 3.0 * e5 / 26.0;
    (rf, 3.0 * sum + power * series / (mean * mean.sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check(axes: [f64; 3], area: f64, tolerance: f64) {
        // A rotation on either side changes nothing.
        let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 1.1, -0.7);
        for m in [DMat3::from_diagonal(axes.into()), turn * DMat3::from_diagonal(axes.into()) * turn.transpose() * turn] {
            let found = whole_area(cofactors(m));
            assert!((found / area - 1.0).abs() < tolerance, "{axes:?}: {found} instead of {area}");
        }
    }

    #[test]
    fn whole_areas_are_the_closed_forms() {
        check([2.0; 3], 16.0 * PI, 1e-13);
        // Spheroids (Beyer, CRC Standard Mathematical Tables): oblate and prolate, from round to flat.
        for ratio in [0.999, 0.5, 0.1, 1e-3, 1e-6] {
            let e = (1.0f64 - ratio * ratio).sqrt();
            check([1.0, 1.0, ratio], 2.0 * PI * (1.0 + ratio * ratio / e * e.atanh()), 1e-9);
            check([ratio, ratio, 1.0], 2.0 * PI * (ratio * ratio + ratio * e.asin() / e), 1e-9);
        }
    }

    #[test]
    fn parts_add_up_to_the_whole() {
        let m = DMat3::from_cols(DVec3::new(1.0, 0.2, 0.0), DVec3::new(-0.1, 2.0, 0.3), DVec3::new(0.5, 0.0, 1.5));
        let c = cofactors(m);
        let parts = part_area(c, -1.0, 0.25, 2.0 * PI) + part_area(c, 0.25, 1.0, 2.0 * PI);
        assert!((parts / whole_area(c) - 1.0).abs() < 1e-9, "{parts} {}", whole_area(c));
        assert!((part_area(DMat3::IDENTITY, -0.5, 1.0, 1.0) - 1.5).abs() < 1e-13);
    }
}
