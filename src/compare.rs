//! How far two pictures are apart.

use crate::image::Picture;
use anyhow::{Result, bail};
use bhs_elementary::Elementary;
use serde_json::{Value, json};

/// Differences of two pictures over all pixels and the channels R, G and B, or, if one of them lacks these, all that both have.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Names of the compared channels.
    pub channels: Vec<String>,
    /// Mean of the squared differences.
    pub mse: f64,
    /// Mean of squared difference over squared reference (the second picture), with 1e-2 of its mean square added below.
    pub relative_mse: f64,
    /// Peak signal-to-noise ratio for a peak of 1 (dB); infinite for equal pictures.
    pub psnr: f64,
    /// Largest difference of two values.
    pub largest: f64,
    /// Mean of the first picture over mean of the second, per channel.
    pub mean_ratio: Vec<f64>,
}

/// Compares `a` with the reference `b`.
///
/// # Errors
/// If the sizes differ, or no channel is in both.
pub fn compare(a: &Picture, b: &Picture) -> Result<Comparison> {
    if a.size != b.size {
        bail!("the pictures differ in size: {}x{} and {}x{}", a.size[0], a.size[1], b.size[0], b.size[1]);
    }
    let mut shared: Vec<(usize, usize)> =
        a.channels.iter().enumerate().filter_map(|(i, n)| Some((i, b.channels.iter().position(|m| m == n)?))).collect();
    // Layers have units of their own: their differences do not add to those of the colours.
    let is_color = |name: &str| matches!(name, "R" | "G" | "B");
    if shared.iter().filter(|(i, _)| is_color(&a.channels[*i])).count() == 3 {
        shared.retain(|(i, _)| is_color(&a.channels[*i]));
    }
    if shared.is_empty() {
        bail!("the pictures have no channel in common: {} and {}", a.channels.join(" "), b.channels.join(" "));
    }
    let pixels = a.size[0] * a.size[1];
    let pairs = || {
        (0..pixels).flat_map(|p| {
            let (x, y) = (&a.data[p * a.channels.len()..], &b.data[p * b.channels.len()..]);
            shared.iter().map(move |&(i, j)| (f64::from(x[i]), f64::from(y[j])))
        })
    };
    let count = (pixels * shared.len()) as f64;
    let reference_power = pairs().map(|(_, y)| y * y).sum::<f64>() / count;
    let floor = (1e-2 * reference_power).max(f64::MIN_POSITIVE);
    let mut c = Comparison {
        channels: shared.iter().map(|&(i, _)| a.channels[i].clone()).collect(),
        mse: 0.0,
        relative_mse: 0.0,
        psnr: f64::INFINITY,
        largest: 0.0,
        mean_ratio: Vec::new(),
    };
    for (x, y) in pairs() {
        let square = (x - y) * (x - y);
        c.mse += square / count;
        c.relative_mse += square / (y * y + floor) / count;
        // A NaN anywhere must not hide behind `max`, wherever it stands.
        let difference = (x - y).abs();
        c.largest = if difference.is_nan() || c.largest.is_nan() { f64::NAN } else { c.largest.max(difference) };
    }
    if c.mse != 0.0 {
        c.psnr = -10.0 * c.mse.logarithm10();
    }
    for &(i, j) in &shared {
        let mean = |p: &Picture, k: usize| p.data.iter().skip(k).step_by(p.channels.len()).map(|v| f64::from(*v)).sum::<f64>();
        c.mean_ratio.push(mean(a, i) / mean(b, j));
    }
    Ok(c)
}

impl Comparison {
    /// As JSON; numbers that JSON does not have (infinity, NaN) become null.
    pub fn to_json(&self) -> Value {
        json!({
            "channels": self.channels,
            "mse": self.mse,
            "relative_mse": self.relative_mse,
            "psnr": self.psnr,
            "largest": self.largest,
            "mean_ratio": self.mean_ratio,
        })
    }
}

impl std::fmt::Display for Comparison {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        writeln!(f, "mean squared error   {:.6e}", self.mse)?;
        writeln!(f, "relative MSE         {:.6e}", self.relative_mse)?;
        writeln!(f, "PSNR                 {:.2} dB", self.psnr)?;
        writeln!(f, "largest difference   {:.6e}", self.largest)?;
        for (name, ratio) in self.channels.iter().zip(&self.mean_ratio) {
            writeln!(f, "mean ratio, {name:<8} {ratio:.6}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Frame;

    #[test]
    fn what_is_no_number_is_not_hidden() {
        let picture = |data: [f32; 4]| {
            let size = [4, 1];
            Picture { size, frame: Frame { offset: [0, 0], size }, channels: vec!["Y".to_owned()], data: data.to_vec() }
        };
        for place in 0..4 {
            let mut data = [1.0, 2.0, 3.0, 4.0];
            data[place] = f32::NAN;
            let found = compare(&picture(data), &picture([1.0, 2.5, 3.0, 4.5])).expect("comparable");
            assert!(found.largest.is_nan() && found.mse.is_nan() && found.psnr.is_nan(), "{place}: {found:?}");
            assert!(found.to_json()["largest"].is_null());
        }
    }
}
