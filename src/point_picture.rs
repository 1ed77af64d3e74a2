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

    /// Whether they add nothing to any pixel.
    pub fn is_empty(&self) -> bool {
        self.slots.is_empty()
    }

    /// Column and row (4 bytes each) and channels (8 each) of all pixels that have some, little-endian, row by row.
    pub fn to_bytes(&self) -> Vec<u8> {
        let mut pixels: Vec<[u32; 2]> = self.slots.keys().copied().collect();
        pixels.sort_by_key(|[x, y]| [*y, *x]);
        let mut bytes = Vec::with_capacity(pixels.len() * (8 + 8 * self.channels));
        for pixel in pixels {
            pixel.iter().for_each(|n| bytes.extend_from_slice(&n.to_le_bytes()));
            self.pixel(pixel).into_iter().flatten().for_each(|value| bytes.extend_from_slice(&value.to_le_bytes()));
        }
        bytes
    }

    /// Adds what [`PointPicture::to_bytes`] of another one, of the same film, has returned; `None` if it is not that.
    pub fn add_bytes(&mut self, bytes: &[u8]) -> Option<()> {
        let size = 8 + 8 * self.channels;
        if !bytes.len().is_multiple_of(size) {
            return None;
        }
        for pixel in bytes.chunks_exact(size) {
            let (place, values) = pixel.split_first_chunk::<8>()?;
            let [x, y] = [0, 4].map(|at| u32::from_le_bytes([place[at], place[at + 1], place[at + 2], place[at + 3]]));
            let values: Vec<f64> = values.as_chunks().0.iter().map(|v| f64::from_le_bytes(*v)).collect();
            self.add([x, y], 1.0, &values);
        }
        Some(())
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
