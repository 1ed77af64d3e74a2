//! Numbers of a render that no picture can show: samples that are not finite, and sums too large for the file's single precision.
//!
//! Samples that are not finite are left out of their pixels; the first few are kept by name, so that they can be replayed.

use crate::film::{BeyondSinglePrecision, Framebuffer};
use serde_json::{Value, json};

/// A sample of a render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleId {
    /// Column and row of its pixel in the whole frame, from the upper left corner.
    pub pixel: [u32; 2],
    /// Its number among those of the pixel, from 0.
    pub sample: u32,
}

impl SampleId {
    /// Samples are in order of their number, then row by row.
    fn order(&self) -> [u32; 3] {
        [self.sample, self.pixel[1], self.pixel[0]]
    }
}

/// Samples that are kept by name.
const KEPT: usize = 5;

/// The first few of any number of samples. Which ones these are does not depend on the order in which they come.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FirstSamples(Vec<SampleId>);

impl FirstSamples {
    /// Adds a sample.
    pub fn insert(&mut self, sample: SampleId) {
        let at = self.0.partition_point(|s| s.order() < sample.order());
        if at < KEPT && self.0.get(at) != Some(&sample) {
            self.0.insert(at, sample);
            self.0.truncate(KEPT);
        }
    }

    /// Adds all of another set.
    pub fn merge(&mut self, other: &Self) {
        other.0.iter().for_each(|s| self.insert(*s));
    }

    /// The samples, in their order.
    pub fn iter(&self) -> impl Iterator<Item = &SampleId> {
        self.0.iter()
    }
}

/// What the user must know of a render, whatever else is shown: nothing if all its numbers are finite. So many samples were not, `first` are the
/// first of them; `replay` is the command that follows a sample once more.
pub fn warnings(
    count: u64,
    first: &FirstSamples,
    frame: &Framebuffer,
    seed: u64,
    replay: impl Fn(&SampleId) -> String,
) -> Vec<String> {
    let mut words = Vec::new();
    if count > 0 {
        let (samples, were) =
            if count == 1 { ("sample", "was not finite and was") } else { ("samples", "were not finite and were") };
        words.push(format!("warning: {count} {samples} {were} left out of the picture"));
        for id @ SampleId { pixel: [x, y], sample } in first.iter() {
            words.push(format!("  pixel {x},{y}, sample {sample}, seed {seed}: {}", replay(id)));
        }
        let unnamed = count.saturating_sub(first.iter().count() as u64);
        if unnamed > 0 {
            words.push(format!("  and {unnamed} more"));
        }
        words.push(
            "  Light, scales or indices in the scene that come close to the largest number of single precision (3.4e38) do this. \
             Where there are none, it is a fault of bhs: please report it with what such a command prints."
                .into(),
        );
    }
    for BeyondSinglePrecision { channel, pixels, first: [x, y] } in frame.beyond_single_precision() {
        let (pixels, have) = if pixels == 1 { ("1 pixel".to_owned(), "has") } else { (format!("{pixels} pixels"), "have") };
        words.push(format!(
            "warning: {pixels} {have} a value in the channel {channel} that single precision cannot hold (such as pixel {x},{y}); \
             the file has the largest number it can, 3.4e38, in its place"
        ));
    }
    words
}

/// The same for the statistics of a render.
pub fn to_json(count: u64, first: &FirstSamples, frame: &Framebuffer) -> Value {
    let samples = first.iter().map(|s| json!({ "pixel": s.pixel, "sample": s.sample }));
    let beyond = frame.beyond_single_precision();
    let beyond = beyond.iter().map(|b| json!({ "channel": b.channel, "pixels": b.pixels, "first_pixel": b.first }));
    json!({
        "samples": count,
        "first_samples": samples.collect::<Vec<_>>(),
        "beyond_single_precision": beyond.collect::<Vec<_>>(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_samples_are_the_same_in_any_order() {
        let all: Vec<SampleId> = (0..40).map(|i| SampleId { pixel: [i * 7 % 8, i * 3 % 5], sample: i * 11 % 4 }).collect();
        let mut ordered = all.clone();
        ordered.sort_by_key(SampleId::order);
        ordered.dedup();
        let mut forwards = FirstSamples::default();
        all.iter().for_each(|s| forwards.insert(*s));
        let (mut a, mut b) = (FirstSamples::default(), FirstSamples::default());
        all[..17].iter().for_each(|s| a.insert(*s));
        all[17..].iter().rev().for_each(|s| b.insert(*s));
        b.merge(&a);
        assert_eq!(forwards, b);
        assert!(forwards.iter().eq(&ordered[..KEPT]));
    }
}
