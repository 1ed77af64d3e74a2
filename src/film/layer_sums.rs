//! What the sums of a layer in a pixel are, and what becomes of them.

use super::exact::{ExactSums, significant};
use bhs_engine::layer::{LayerFormat, NamedLayer, Statistic, Value};
use glam::DVec3;

/// Significant bits of the colours that the variance is made of. Their squares are exact in twice as many; where all samples are the same, the
/// variance is nothing.
const VARIANCE_BITS: u32 = 20;

/// Numbers that the variance of a pixel takes: sums of the colours, of their squares, and a count.
pub(super) const VARIANCE_NUMBERS: usize = 7;

/// Numbers that a layer of a pixel takes: its channels, and a weight; the variance has sums of squares besides.
pub(super) fn stride(layer: &LayerFormat) -> usize {
    match layer.statistic {
        Statistic::ColorVariance => VARIANCE_NUMBERS,
        Statistic::Mean | Statistic::MeanDirection | Statistic::Sum => layer.channels.len() + 1,
    }
}

/// Numbers that some layers of a pixel take.
pub fn numbers(layers: &[NamedLayer]) -> usize {
    layers.iter().map(|layer| stride(&layer.format)).sum()
}

/// Adds the colour of a sample to the numbers of the variance, which begin at `at`.
pub(super) fn add_color(color: Value, sums: &mut ExactSums, at: usize) {
    for c in 0..3 {
        let value = significant::<VARIANCE_BITS>(color[c]);
        sums.add(at + c, value);
        sums.add(at + 3 + c, value * value);
    }
    sums.add(at + 6, 1.0);
}

/// The mean of a layer's samples, from its numbers in a pixel, which begin at `at`; of the variance, the unbiased estimate.
pub(super) fn mean(layer: &LayerFormat, sums: &ExactSums, at: usize) -> Option<Value> {
    if layer.statistic == Statistic::ColorVariance {
        let count = sums.value(at + 6);
        return (count >= 2.0).then(|| std::array::from_fn(|c| variance(count, sums, at + c)));
    }
    let channels = stride(layer) - 1;
    let weight = sums.value(at + channels);
    if weight == 0.0 {
        return None;
    }
    let weight = if layer.statistic == Statistic::Sum { 1.0 } else { weight };
    let mean: Value = std::array::from_fn(|c| if c < channels { sums.value(at + c) / weight } else { 0.0 });
    // As in pbrt-v4; opposite normals may cancel.
    Some(if layer.statistic == Statistic::MeanDirection { DVec3::from_array(mean).normalize_or_zero().to_array() } else { mean })
}

/// The unbiased estimate of the variance of `count` numbers, whose sum stands at `at` and whose sum of squares three places after it: in the
/// precision of two doubles, for the two squares may be nearly the same.
fn variance(count: f64, sums: &ExactSums, at: usize) -> f64 {
    let ([sum, sum_rest], [squares, squares_rest]) = (sums.value_and_rest(at), sums.value_and_rest(at + 3));
    let product = |a: f64, b: f64| (a * b, a.mul_add(b, -(a * b)));
    let (of_squares, of_squares_rest) = product(count, squares);
    let (of_sum, of_sum_rest) = product(sum, sum);
    let rest = of_squares_rest + count * squares_rest - of_sum_rest - 2.0 * sum * sum_rest;
    let difference = (of_squares - of_sum) + rest;
    (difference / count / (count - 1.0)).max(0.0)
}

/// Where the numbers of the variance stand among those of the layers of a pixel, if it is one of them.
pub fn variance_at(layers: &[NamedLayer]) -> Option<usize> {
    let before = layers.iter().position(|l| l.format.statistic == Statistic::ColorVariance)?;
    Some(numbers(&layers[..before]))
}
