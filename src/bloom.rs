//! Glare: what the aperture of a camera or an eye makes of a bright point, in the picture that is shown.
//!
//! Light that passes a round aperture of diameter D is diffracted; the wings of the Airy pattern, averaged over their rings, fall off with the
//! cube of the angle. The point-spread function `p(r) = r0 / (2 pi (r^2 + r0^2)^(3/2))`, `r0 = 2 lambda / (pi^2 D)`, has these wings, holds all of
//! the light, and has the transfer function `exp(-2 pi r0 f)`, which begins as that of the aperture does. Formulas: docs/physics.md, section 16.
//!
//! The picture goes on beyond its edges as in mirrors, so that what is as bright everywhere stays so, and no light is lost. The convolution is then
//! a product of cosine transforms.

use crate::image::Picture;
use bhs_elementary::Elementary;
use rayon::prelude::*;
use rustdct::{DctPlanner, TransformType2And3};
use std::borrow::Cow;
use std::f64::consts::TAU;
use std::sync::Arc;

/// Dominant wavelengths of the primaries of sRGB over 550 nm, for which the radius is stated.
const WAVELENGTHS: [f64; 3] = [611.0 / 550.0, 549.0 / 550.0, 464.0 / 550.0];

/// The picture with glare of the radius `radius` (pixels) in its first three channels; as it is for 0.
pub fn with_glare(picture: &Picture, radius: f64) -> Cow<'_, Picture> {
    if radius <= 0.0 {
        return Cow::Borrowed(picture);
    }
    let mut shown = picture.clone();
    let (size, channels) = (picture.size, picture.channels.len());
    for (c, wavelength) in WAVELENGTHS.iter().enumerate().take(channels) {
        let plane = picture.data.iter().skip(c).step_by(channels).map(|v| f64::from(*v)).collect();
        let spread = convolve(Plane { size, values: plane }, radius * wavelength);
        for (to, value) in shown.data.iter_mut().skip(c).step_by(channels).zip(spread.values) {
            *to = value as f32;
        }
    }
    Cow::Owned(shown)
}

/// One channel of a picture, row by row.
struct Plane {
    size: [usize; 2],
    values: Vec<f64>,
}

impl Plane {
    /// Changes all rows.
    fn rows(&mut self, change: impl Fn(&mut [f64]) + Send + Sync) {
        self.values.par_chunks_exact_mut(self.size[0]).for_each(change);
    }

    /// Columns for rows.
    fn transposed(&self) -> Self {
        let [width, height] = self.size;
        let values = (0..width * height).map(|i| self.values[(i % height) * width + i / height]).collect();
        Self { size: [height, width], values }
    }
}

/// The plane convolved with the point-spread function of the radius `radius` (pixels).
fn convolve(mut plane: Plane, radius: f64) -> Plane {
    let [width, height] = plane.size;
    let mut planner = DctPlanner::new();
    let [across, down]: [Arc<dyn TransformType2And3<f64>>; 2] = [width, height].map(|n| planner.plan_dct2(n));
    plane.rows(|row| across.process_dct2(row));
    let mut plane = plane.transposed();
    plane.rows(|column| down.process_dct2(column));
    let transfer = transfer(plane.size, radius);
    let all = transfer.values[0];
    // What lies farther off than the picture is wide counts as glare all over it.
    let scale = 4.0 / (width * height) as f64 / all;
    let own = plane.values.par_chunks_exact_mut(height).zip(transfer.values.par_chunks_exact(height + 1));
    own.for_each(|(own, transfer)| own.iter_mut().zip(transfer).for_each(|(v, t)| *v *= t * scale));
    plane.rows(|column| down.process_dct3(column));
    let mut plane = plane.transposed();
    plane.rows(|row| across.process_dct3(row));
    plane
}

/// What each cosine of a picture of the given size is multiplied by: the cosine transform of the light that pixels get from one at a distance.
fn transfer([width, height]: [usize; 2], radius: f64) -> Plane {
    let values = (0..=height).flat_map(|y| (0..=width).map(move |x| share([x as f64, y as f64], radius))).collect();
    let mut plane = Plane { size: [width + 1, height + 1], values };
    let mut planner = DctPlanner::new();
    let [across, down] = [width + 1, height + 1].map(|n| planner.plan_dct1(n));
    plane.rows(|row| across.process_dct1(row));
    let mut plane = plane.transposed();
    plane.rows(|column| down.process_dct1(column));
    plane.transposed()
}

/// The share of a point's light that falls on a pixel whose middle is `x`, `y` pixels off. The point-spread function is that of the solid angle
/// of a plane at the distance `radius`, so that the integral over a rectangle is known.
fn share([x, y]: [f64; 2], radius: f64) -> f64 {
    let corner = |x: f64, y: f64| (x * y / (radius * (x * x + y * y + radius * radius).sqrt())).arctangent() / TAU;
    corner(x + 0.5, y + 0.5) - corner(x - 0.5, y + 0.5) - corner(x + 0.5, y - 0.5) + corner(x - 0.5, y - 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Frame;

    fn picture(size: [usize; 2], value: impl Fn(usize, usize) -> f32) -> Picture {
        let data = (0..size[0] * size[1]).flat_map(|i| [value(i % size[0], i / size[0]); 3]).collect();
        let channels = ["R", "G", "B"].map(str::to_owned).to_vec();
        Picture { size, frame: Frame { offset: [0, 0], size }, channels, data }
    }

    /// Against the sum over all pixels and their mirror images, one by one.
    #[test]
    fn glare_is_the_plain_sum() {
        let (size, radius) = ([9, 6], 0.7);
        let bright = picture(size, |x, y| (x * x + 3 * y) as f32 + if (x, y) == (2, 4) { 500.0 } else { 0.0 });
        let shown = with_glare(&bright, radius);
        let [w, h] = size.map(|s| s as i64);
        // Far mirror images are left out there as here: those of one period around each pixel.
        let kernel = |dx: i64, dy: i64| {
            let half = |d: i64, n: i64| if d.abs() == n { 0.5 } else { 1.0 };
            half(dx, w) * half(dy, h) * share([dx as f64, dy as f64], radius * WAVELENGTHS[1])
        };
        let total: f64 = (-h..=h).flat_map(|dy| (-w..=w).map(move |dx| (dx, dy))).map(|(dx, dy)| kernel(dx, dy)).sum();
        let mirrored = |i: i64, n: i64| {
            let i = i.rem_euclid(2 * n);
            (if i < n { i } else { 2 * n - 1 - i }) as usize
        };
        for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
            let mut sum = 0.0;
            for (dx, dy) in (-h..=h).flat_map(|dy| (-w..=w).map(move |dx| (dx, dy))) {
                let from = bright.pixel(mirrored(x + dx, w), mirrored(y + dy, h))[1];
                sum += kernel(dx, dy) * f64::from(from) / total;
            }
            let got = f64::from(shown.pixel(x as usize, y as usize)[1]);
            assert!((got / sum - 1.0).abs() < 1e-5, "{x} {y}: {got} {sum}");
        }
    }

    #[test]
    fn light_is_kept_and_wings_are_those_of_an_aperture() {
        let even = picture([33, 20], |_, _| 0.25);
        assert!(with_glare(&even, 2.0).data.iter().all(|v| (v - 0.25).abs() < 1e-6));
        let point = picture([401, 401], |x, y| if (x, y) == (200, 200) { 1e6 } else { 0.0 });
        let shown = with_glare(&point, 0.5);
        for (c, wavelength) in WAVELENGTHS.into_iter().enumerate() {
            let sum: f64 = shown.data.iter().skip(c).step_by(3).map(|v| f64::from(*v)).sum();
            assert!((sum / 1e6 - 1.0).abs() < 1e-5, "{sum}");
            // lambda / (pi^3 D r^3) is the mean of the Airy pattern over its rings, with r0 = 2 lambda / (pi^2 D).
            let d = 30.0f64;
            let wing = 1e6 * (0.5 * wavelength) * std::f64::consts::PI / 2.0 / std::f64::consts::PI.powi(2) / d.powi(3);
            let got = f64::from(shown.pixel(230, 200)[c]);
            assert!((got / wing - 1.0).abs() < 0.02, "{c}: {got} {wing}");
        }
        assert!(shown.data.iter().all(|v| *v >= 0.0));
        assert!(matches!(with_glare(&point, 0.0), Cow::Borrowed(_)));
    }
}
