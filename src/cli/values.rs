//! Values of flags: how they are read, and what is said of those that are none.

use crate::animation::preview::Format;
use bhs_core::sampling::{NoiseOver, NoiseTarget};
use std::path::{Path, PathBuf};
use std::time::Duration;

pub(super) fn frames_per_second(text: &str) -> Result<f64, String> {
    let fps = text.parse::<f64>().ok().filter(|fps| (0.001..=10_000.0).contains(fps));
    fps.ok_or_else(|| "expected a number of frames a second, such as 24 or 29.97".to_owned())
}

pub(super) fn preview(text: &str) -> Result<PathBuf, String> {
    Format::of(Path::new(text)).map(|_| text.into())
}

/// A noise that pixels may have.
pub(super) fn noise(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|noise| NoiseTarget::takes(*noise)).ok_or_else(|| NoiseTarget::EXPECTED.to_owned())
}

/// What has to have so little noise.
pub(super) fn noise_over(text: &str) -> Result<NoiseOver, String> {
    NoiseOver::find(text).ok_or_else(|| NoiseOver::EXPECTED.to_owned())
}

/// A time in seconds.
pub(super) fn seconds(text: &str) -> Result<Duration, String> {
    let seconds = text.parse::<f64>().ok().filter(|s| *s >= 0.0);
    seconds
        .and_then(|s| Duration::try_from_secs_f64(s).ok())
        .ok_or_else(|| "expected a number of seconds, such as 300 or 0.5".to_owned())
}

/// The name of a layer.
pub(super) fn layer_name(text: &str) -> Result<String, String> {
    bhs_engine::layer::find(text, bhs_layers::ALL).map(|layer| layer.name.to_owned())
}

pub(super) fn crop(text: &str) -> Result<[f64; 4], String> {
    let numbers: Result<Vec<f64>, _> = text.split(',').map(|n| n.trim().parse::<f64>()).collect();
    match numbers.as_deref() {
        Ok(&[x0, x1, y0, y1]) if 0.0 <= x0 && x0 < x1 && x1 <= 1.0 && 0.0 <= y0 && y0 < y1 && y1 <= 1.0 => Ok([x0, x1, y0, y1]),
        _ => Err("expected four numbers between 0 and 1, from below to: x0,x1,y0,y1".into()),
    }
}

pub(super) fn pixel(text: &str) -> Result<[u32; 2], String> {
    let numbers = text.split_once(',').map(|(x, y)| (x.trim().parse(), y.trim().parse()));
    match numbers {
        Some((Ok(x), Ok(y))) => Ok([x, y]),
        _ => Err("expected column and row, counted from 0, such as 12,34".into()),
    }
}

pub(super) fn resolution(text: &str) -> Result<[u32; 2], String> {
    let sizes = text.split_once(['x', 'X']).map(|(w, h)| (w.parse::<u32>(), h.parse::<u32>()));
    match sizes {
        Some((Ok(w), Ok(h))) if (1..=65_536).contains(&w) && (1..=65_536).contains(&h) => Ok([w, h]),
        _ => Err("expected width and height in pixels, such as 640x480".into()),
    }
}
