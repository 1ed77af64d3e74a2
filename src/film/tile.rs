//! Tiles: the sums of a rectangle of pixels, which one thread works on at a time.

use super::exact::ExactSums;
use super::layer_sums::{VARIANCE_NUMBERS, add_color, stride};
use super::least_and_most;
use super::noise::PixelNoise;
use crate::render::waves::Wave;
use bhs_engine::layer::{NamedLayer, Statistic, Value};
use std::collections::TryReserveError;

/// A rectangle of pixels.
pub struct Tile {
    /// First column and row, in the whole frame.
    pub origin: [u32; 2],
    /// Width and height.
    pub size: [u32; 2],
    /// Sums of the channels, pixel by pixel.
    pub sums: ExactSums,
    /// Sums of the weights, pixel by pixel.
    pub weights: ExactSums,
    /// For each pixel and each layer: the sums of the layer's channels, then of the weights of the samples that have a value.
    /// Empty, without memory, in a film that has no layers.
    pub layers: ExactSums,
    /// What adaptive sampling knows of each pixel. Empty, without memory, where all pixels get as many samples.
    pub noise: Vec<PixelNoise>,
    /// How far it has come.
    pub progress: TileProgress,
    /// Number of the last snapshot of the render that has this tile.
    pub snapshot: u32,
}

/// How far a tile has come. Samples are made in ranges of their numbers: all of a range for one pixel, then for the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileProgress {
    /// The first sample of each pixel: not 0 in parts of pictures.
    pub first: u32,
    /// Samples before this one are done, for every pixel, from `first` on; the range under way begins with it.
    pub done: u32,
    /// End of the range under way; no more than `done` if there is none.
    pub end: u32,
    /// Samples of the range under way that are done, those of all pixels together.
    pub position: u32,
}

impl TileProgress {
    /// Nothing yet of samples from the given one on.
    pub fn from(first: u32) -> Self {
        Self { first, done: first, end: first, position: 0 }
    }

    /// Whether all samples before the given one are done, and none from it on.
    pub fn is_at(self, sample: u32) -> bool {
        self.done == sample && self.position == 0
    }

    /// Whether there is any sample.
    pub fn has_samples(self) -> bool {
        self.done > self.first || self.position > 0
    }

    /// The end of the samples that the pixel with the most has.
    pub fn most(self) -> u32 {
        if self.position > 0 { self.end } else { self.done }
    }
}

impl Tile {
    /// A tile without samples, of so many channels and numbers of layers a pixel, whose first sample is given.
    ///
    /// # Errors
    /// If there is not enough memory for it.
    pub fn empty(origin: [u32; 2], size: [u32; 2], [channels, layers]: [usize; 2], first: u32) -> Result<Self, TryReserveError> {
        let pixels = (size[0] * size[1]) as usize;
        Ok(Self {
            origin,
            size,
            sums: ExactSums::new(pixels * channels)?,
            weights: ExactSums::new(pixels)?,
            layers: ExactSums::new(pixels * layers)?,
            noise: Vec::new(),
            progress: TileProgress::from(first),
            snapshot: 0,
        })
    }

    /// Has adaptive sampling look at its pixels, before it has any sample.
    ///
    /// # Errors
    /// If there is not enough memory for it.
    pub fn watch_noise(&mut self) -> Result<(), TryReserveError> {
        self.noise.try_reserve_exact(self.weights.len())?;
        self.noise.resize(self.weights.len(), PixelNoise::beginning());
        Ok(())
    }

    /// The pixels that take part in the range under way, of so many samples, each with the number of its first sample in it.
    pub fn under_way(&self, samples: u32) -> Vec<(usize, u32)> {
        if self.noise.is_empty() {
            return (0..self.weights.len()).map(|i| (i, self.progress.done)).collect();
        }
        scheduled(&self.noise, self.progress.position, samples).unwrap_or_default()
    }

    /// The number here of a pixel of the whole frame that lies within.
    pub fn index(&self, [x, y]: [u32; 2]) -> usize {
        ((y - self.origin[1]) * self.size[0] + (x - self.origin[0])) as usize
    }

    /// Column and row of the pixel `i` in the whole frame.
    pub fn pixel(&self, i: usize) -> [u32; 2] {
        [self.origin[0] + i as u32 % self.size[0], self.origin[1] + i as u32 / self.size[0]]
    }

    /// Adds what a sample of the pixel `i` brings to the channels, and its weight.
    #[inline]
    pub fn add_color(&mut self, i: usize, channels: &[f64], weight: f64) {
        for (c, value) in channels.iter().enumerate() {
            // Of many channels, a sample has something in a few.
            if *value != 0.0 {
                self.sums.add(i * channels.len() + c, *value);
            }
        }
        self.weights.add(i, weight);
    }

    /// Adds a sample's values of all layers to the pixel `i`.
    pub fn add_layers(&mut self, i: usize, layers: &[NamedLayer], values: impl Iterator<Item = Option<Value>>, weight: f64) {
        let mut at = self.layers_at(i);
        for (layer, value) in layers.iter().zip(values) {
            let numbers = stride(&layer.format);
            if let Some(value) = value {
                let weight = if layer.format.statistic == Statistic::Sum { 1.0 } else { weight };
                for (c, value) in value.iter().take(numbers - 1).enumerate() {
                    self.layers.add(at + c, weight * value);
                }
                self.layers.add(at + numbers - 1, weight);
            }
            at += numbers;
        }
    }

    /// Adds the colour of a sample to the variance of the pixel `i`, which stands at [`super::variance_at`].
    pub fn add_variance(&mut self, i: usize, at: usize, color: Value) {
        let at = self.layers_at(i) + at;
        debug_assert!(at + VARIANCE_NUMBERS <= self.layers.len());
        add_color(color, &mut self.layers, at);
    }

    /// Where the numbers of all layers of the pixel `i` begin.
    #[inline]
    fn layers_at(&self, i: usize) -> usize {
        i * (self.layers.len() / self.weights.len())
    }

    /// Samples so far, those of all pixels together.
    pub fn samples(&self) -> u64 {
        let TileProgress { first, done, position, .. } = self.progress;
        if !self.noise.is_empty() {
            return self.noise.iter().map(|noise| u64::from(noise.samples)).sum();
        }
        u64::from(done - first) * self.weights.len() as u64 + u64::from(position)
    }

    /// Samples of the pixel with the fewest, and of the one with the most.
    pub fn pixel_samples(&self) -> [u32; 2] {
        let counts = self.noise.iter().map(|noise| [noise.samples; 2]);
        counts.reduce(least_and_most).unwrap_or([self.progress.done, self.progress.most()])
    }

    /// Its progress and its numbers, exactly (little-endian); nothing without samples.
    pub fn to_bytes(&self) -> Vec<u8> {
        let TileProgress { done, end, position, .. } = self.progress;
        if !self.progress.has_samples() {
            return Vec::new();
        }
        let numbers = self.sums.len() + self.weights.len() + self.layers.len();
        let mut bytes = Vec::with_capacity(24 + 8 * numbers);
        [done, end, position].iter().for_each(|n| bytes.extend_from_slice(&n.to_le_bytes()));
        [&self.sums, &self.weights, &self.layers].iter().for_each(|sums| sums.write_to(&mut bytes));
        self.noise.iter().for_each(|noise| noise.write_to(&mut bytes));
        bytes
    }

    /// Takes over what [`Tile::to_bytes`] of the same tile returned; `None`, and unchanged, if it is not that.
    pub fn restore(&mut self, bytes: &[u8]) -> Option<()> {
        let (head, mut numbers) = bytes.split_first_chunk::<12>()?;
        let [done, end, position] = [0, 4, 8].map(|at| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]));
        let first = self.progress.first;
        // A range under way is part of a wave, and has samples that are not done yet.
        let is_of_wave = end <= done || Wave::of(done) == Wave::of(end - 1);
        if done < first || !is_of_wave {
            return None;
        }
        let [sums, weights, layers] = [&self.sums, &self.weights, &self.layers].map(|own| own.read_like(&mut numbers));
        let (sums, weights, layers) = (sums?, weights?, layers?);
        let (noise, rest) = numbers.as_chunks::<{ PixelNoise::BYTES }>();
        if noise.len() != self.noise.len() || !rest.is_empty() {
            return None;
        }
        let noise = noise.iter().map(PixelNoise::read).collect::<Option<Vec<_>>>()?;
        let range = end.saturating_sub(done);
        let pixels = if noise.is_empty() { self.weights.len() } else { scheduled(&noise, position, range)?.len() };
        if position > 0 && u64::from(position) >= u64::from(range) * pixels as u64 {
            return None;
        }
        *self = Self { sums, weights, layers, noise, progress: TileProgress { first, done, end, position }, ..*self };
        Some(())
    }

    /// Adds the sums of the pixel `j` of another tile, of the same film, to those of the pixel `i`.
    pub fn add_pixel(&mut self, i: usize, other: &Self, j: usize) {
        let pixels = (self.weights.len(), other.weights.len());
        let each = |sums: &mut ExactSums, others: &ExactSums| {
            let numbers = sums.len() / pixels.0;
            (0..numbers).for_each(|c| sums.add_sum(i * numbers + c, others, j * numbers + c));
        };
        each(&mut self.sums, &other.sums);
        each(&mut self.weights, &other.weights);
        each(&mut self.layers, &other.layers);
    }
}

/// The pixels under way in a range of so many samples, each with the number of its first sample in it, where so many samples of the range are done,
/// pixel after pixel; `None` if a pixel has less.
fn scheduled(noise: &[PixelNoise], mut position: u32, samples: u32) -> Option<Vec<(usize, u32)>> {
    let under_way = (0..).zip(noise).filter(|(_, noise)| noise.under_way);
    under_way
        .map(|(i, noise)| {
            let done = position.min(samples);
            position -= done;
            Some((i, noise.samples.checked_sub(done)?))
        })
        .collect()
}
