//! What points of the sky add to a picture: the few pixels that have any of their light.

use std::collections::HashMap;

/// What was counted while points were drawn.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PointCounters {
    /// Points of all lights.
    pub points: u64,
    /// Images of them in the picture, or just outside of it, that were not occluded.
    pub images: u64,
    /// Images that were.
    pub occluded: u64,
}

/// What points of the sky add to the pixels of a picture.
#[derive(Clone, Debug, Default)]
pub struct PointPicture {
    /// Where the values of each pixel stand that has any, by column and row of the whole frame.
    slots: HashMap<[u32; 2], usize>,
    /// Channels of the film, pixel after pixel.
    values: Vec<f64>,
    channels: usize,
    /// What was counted.
    pub counters: PointCounters,
}

impl PointPicture {
    /// Of a film of so many channels; nothing yet.
    pub fn new(channels: usize) -> Self {
        Self { channels, ..Self::default() }
    }

    /// What they add to the channels of a pixel (column and row of the whole frame).
    pub fn pixel(&self, pixel: [u32; 2]) -> Option<&[f64]> {
        self.slots.get(&pixel).map(|slot| &self.values[slot * self.channels..][..self.channels])
    }

    /// Adds `weight` times `channels` to a pixel.
    pub fn add(&mut self, pixel: [u32; 2], weight: f64, channels: &[f64]) {
        let next = self.slots.len();
        let slot = *self.slots.entry(pixel).or_insert(next);
        if slot == next {
            self.values.resize(self.values.len() + self.channels, 0.0);
        }
        let own = &mut self.values[slot * self.channels..][..self.channels];
        own.iter_mut().zip(channels).for_each(|(own, value)| *own += weight * value);
    }
}
