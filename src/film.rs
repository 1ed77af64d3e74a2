//! The frame under way: sums and weights of pixels, in tiles that are each worked on by one thread at a time.

mod values;

pub use values::TileValues;

use crate::image::{Frame, Picture, single_precision};
use crate::layers::LayerPicture;
use crate::memory::{self, OutOfMemory};
use crate::point_picture::PointPicture;
use crate::render::waves::Wave;
use bhs_core::camera::Film;
use bhs_engine::layer::{LayerFormat, NamedLayer, Statistic, Value};
use glam::DVec3;
use std::collections::TryReserveError;
use std::sync::Mutex;

/// Side of a tile (pixels).
pub const TILE: u32 = 16;

/// A rectangle of pixels.
pub struct Tile {
    /// First column and row, in the whole frame.
    pub origin: [u32; 2],
    /// Width and height.
    pub size: [u32; 2],
    /// Sums of the channels, pixel by pixel.
    pub sums: Vec<f64>,
    /// Sums of the weights, pixel by pixel.
    pub weights: Vec<f64>,
    /// For each pixel and each layer: the sums of the layer's channels, then of the weights of the samples that have a value.
    /// Empty, without memory, in a film that has no layers.
    pub layers: Vec<f64>,
    /// How far it has come.
    pub progress: TileProgress,
    /// Number of the last snapshot of the render that has this tile.
    pub snapshot: u32,
}

/// How far a tile has come. Samples are made in ranges of their numbers: all of a range for one pixel, then for the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileProgress {
    /// Samples that every pixel has; the range under way begins with this one.
    pub done: u32,
    /// End of the range under way; no more than `done` if there is none.
    pub end: u32,
    /// Samples of the range under way that are done, those of all pixels together.
    pub position: u32,
}

impl TileProgress {
    /// Whether there is any sample.
    pub fn has_samples(self) -> bool {
        self.done > 0 || self.position > 0
    }

    /// Samples that the pixel with the most has.
    pub fn most(self) -> u32 {
        if self.position > 0 { self.end } else { self.done }
    }
}

/// All tiles of the part of the frame that is rendered.
pub struct Framebuffer {
    /// The tiles, row by row.
    pub tiles: Vec<Mutex<Tile>>,
    crop: [u32; 4],
    frame: [u32; 2],
    channels: Vec<String>,
    layers: Vec<NamedLayer>,
    /// What is added to the means of samples.
    points: Option<PointPicture>,
}

impl Tile {
    /// The number here of a pixel of the whole frame that lies within.
    pub fn index(&self, [x, y]: [u32; 2]) -> usize {
        ((y - self.origin[1]) * self.size[0] + (x - self.origin[0])) as usize
    }

    /// Column and row of the pixel `i` in the whole frame.
    pub fn pixel(&self, i: usize) -> [u32; 2] {
        [self.origin[0] + i as u32 % self.size[0], self.origin[1] + i as u32 / self.size[0]]
    }

    /// Adds a sample's values of all layers to the pixel `i`; the samples of a pixel come in their order.
    pub fn add_layers(&mut self, i: usize, layers: &[NamedLayer], values: impl Iterator<Item = Option<Value>>, weight: f64) {
        let mut sums = self.layers_of(i);
        for (layer, value) in layers.iter().zip(values) {
            let (own, rest) = sums.split_at_mut(stride(&layer.format));
            if let Some(value) = value {
                add(value, weight, own);
            }
            sums = rest;
        }
    }
}

impl Tile {
    /// Adds the colour of a sample to the variance of the pixel `i`, which stands at [`variance_at`].
    pub fn add_variance(&mut self, i: usize, at: usize, color: Value) {
        add_variance(color, &mut self.layers_of(i)[at..][..VARIANCE_NUMBERS]);
    }

    /// The numbers of all layers of the pixel `i`, and those of the pixels after it.
    #[inline]
    fn layers_of(&mut self, i: usize) -> &mut [f64] {
        let numbers = self.layers.len() / self.weights.len();
        &mut self.layers[i * numbers..]
    }
}

impl Tile {
    /// Samples so far, those of all pixels together.
    pub fn samples(&self) -> u64 {
        u64::from(self.progress.done) * self.weights.len() as u64 + u64::from(self.progress.position)
    }

    /// Its progress and its numbers, exactly (little-endian); nothing without samples.
    pub fn to_bytes(&self) -> Vec<u8> {
        let TileProgress { done, end, position } = self.progress;
        if !self.progress.has_samples() {
            return Vec::new();
        }
        let numbers = || self.sums.iter().chain(&self.weights).chain(&self.layers);
        let mut bytes = Vec::with_capacity(12 + 8 * numbers().count());
        [done, end, position].iter().for_each(|n| bytes.extend_from_slice(&n.to_le_bytes()));
        numbers().for_each(|n| bytes.extend_from_slice(&n.to_le_bytes()));
        bytes
    }

    /// Takes over what [`Tile::to_bytes`] of the same tile returned; `None`, and unchanged, if it is not that.
    pub fn restore(&mut self, bytes: &[u8]) -> Option<()> {
        let (head, numbers) = bytes.split_first_chunk::<12>()?;
        let [done, end, position] = [0, 4, 8].map(|at| u32::from_le_bytes([head[at], head[at + 1], head[at + 2], head[at + 3]]));
        // A range under way is part of a wave, and has samples that are not done yet.
        let is_of_wave = end <= done || Wave::of(done) == Wave::of(end - 1);
        let range = u64::from(end.saturating_sub(done)) * self.weights.len() as u64;
        if numbers.len() != 8 * (self.sums.len() + self.weights.len() + self.layers.len())
            || !is_of_wave
            || (position > 0 && u64::from(position) >= range)
        {
            return None;
        }
        let own = self.sums.iter_mut().chain(&mut self.weights).chain(&mut self.layers);
        for (own, number) in own.zip(numbers.as_chunks::<8>().0) {
            *own = f64::from_le_bytes(*number);
        }
        self.progress = TileProgress { done, end, position };
        Some(())
    }
}

impl Framebuffer {
    /// Memory that the frame of a film with these layers takes (bytes): for its sums, and for the tiles that they are divided into.
    pub fn bytes(film: &dyn Film, layers: &[NamedLayer]) -> [u64; 2] {
        let [width, height] = Self::size(film);
        let numbers = film.channels().len() + 1 + numbers(layers);
        let tiles = u64::from(width.div_ceil(TILE)) * u64::from(height.div_ceil(TILE));
        // A tile has three lists, before each of which stands a word or two of the allocator's.
        let tile = size_of::<Mutex<Tile>>() + 3 * 2 * size_of::<usize>();
        [u64::from(width) * u64::from(height) * (numbers * size_of::<f64>()) as u64, tiles * tile as u64]
    }

    /// Width and height of what is rendered (pixels).
    fn size(film: &dyn Film) -> [u32; 2] {
        let [x0, x1, y0, y1] = film.crop();
        [x1.saturating_sub(x0), y1.saturating_sub(y0)]
    }

    /// An empty frame of a film that records these layers.
    ///
    /// # Errors
    /// If there is not enough memory for it.
    pub fn new(film: &dyn Film, layers: &[NamedLayer]) -> Result<Self, OutOfMemory> {
        Self::try_new(film, layers).map_err(|_| OutOfMemory::new("the film", Self::bytes(film, layers).iter().sum()))
    }

    fn try_new(film: &dyn Film, layers: &[NamedLayer]) -> Result<Self, TryReserveError> {
        let [x0, x1, y0, y1] = film.crop();
        let channels = film.channels();
        let layer_numbers = numbers(layers);
        let mut tiles = Vec::new();
        let [width, height] = Self::size(film);
        tiles.try_reserve_exact((width.div_ceil(TILE) as usize).saturating_mul(height.div_ceil(TILE) as usize))?;
        for y in (y0..y1).step_by(TILE as usize) {
            for x in (x0..x1).step_by(TILE as usize) {
                let size = [TILE.min(x1 - x), TILE.min(y1 - y)];
                let pixels = (size[0] * size[1]) as usize;
                tiles.push(Mutex::new(Tile {
                    origin: [x, y],
                    size,
                    sums: memory::filled(pixels * channels.len(), 0.0)?,
                    weights: memory::filled(pixels, 0.0)?,
                    layers: memory::filled(pixels * layer_numbers, 0.0)?,
                    progress: TileProgress::default(),
                    snapshot: 0,
                }));
            }
        }
        Ok(Self { tiles, crop: film.crop(), frame: film.resolution(), channels, layers: layers.to_vec(), points: None })
    }

    /// The same frame with the points of the sky that its picture shows besides samples.
    pub fn with_points(self, points: Option<PointPicture>) -> Self {
        Self { points, ..self }
    }

    /// The points of the sky, if it shows any.
    pub fn points(&self) -> Option<&PointPicture> {
        self.points.as_ref()
    }

    /// Number of channels.
    pub fn channel_count(&self) -> usize {
        self.channels.len()
    }

    /// Number of pixels that are rendered.
    pub fn pixel_count(&self) -> u64 {
        let [x0, x1, y0, y1] = self.crop;
        u64::from(x1 - x0) * u64::from(y1 - y0)
    }

    /// Samples so far, those of all pixels together. Waits for threads that are at work on a tile.
    pub fn samples(&self) -> u64 {
        self.tiles.iter().map(|tile| tile.lock().unwrap_or_else(std::sync::PoisonError::into_inner).samples()).sum()
    }

    /// Samples that every pixel has, and that the pixel with the most has. Waits for threads that are at work on a tile.
    pub fn sample_counts(&self) -> [u32; 2] {
        let progress = |tile: &Mutex<Tile>| tile.lock().unwrap_or_else(std::sync::PoisonError::into_inner).progress;
        let counts = self.tiles.iter().map(progress).map(|p| [p.done, p.most()]);
        counts.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1])]).unwrap_or_default()
    }

    /// The picture as it stands, without the layers: every pixel the weighted mean of the samples that it has, none without any, and what points
    /// of the sky add to it.
    pub fn picture(&self) -> Picture {
        let n = self.channels.len();
        let mut data = vec![0.0f32; self.pixel_count() as usize * n];
        self.each_pixel(|pixel, tile, i| {
            for (c, value) in self.values(tile, i).enumerate() {
                data[pixel * n + c] = single_precision(value);
            }
        });
        let [x0, x1, y0, y1] = self.crop.map(|c| c as usize);
        let frame = Frame { offset: [x0, y0], size: self.frame.map(|s| s as usize) };
        Picture { size: [x1 - x0, y1 - y0], frame, channels: self.channels.clone(), data }
    }

    /// The channels of the picture and of its layers, in their order, that have values beyond single precision, in which files keep them:
    /// sums of finite samples may be so large, and squares of them in the variance.
    pub fn beyond_single_precision(&self) -> Vec<BeyondSinglePrecision> {
        let mut found: Vec<BeyondSinglePrecision> = Vec::new();
        let [x0, x1, y0, _] = self.crop;
        let mut note = |channel: &str, pixel: usize| match found.iter_mut().find(|f| f.channel == channel) {
            Some(known) => known.pixels += 1,
            None => {
                let width = (x1 - x0) as usize;
                let first = [x0 + (pixel % width) as u32, y0 + (pixel / width) as u32];
                found.push(BeyondSinglePrecision { channel: channel.to_owned(), pixels: 1, first });
            }
        };
        self.each_pixel(|pixel, tile, i| {
            for (channel, value) in self.channels.iter().zip(self.values(tile, i)) {
                if !(value as f32).is_finite() {
                    note(channel, pixel);
                }
            }
        });
        for LayerPicture { format, values, .. } in self.layers() {
            for (pixel, value) in values.iter().enumerate() {
                for (channel, value) in format.channels.iter().zip(value.unwrap_or_default()) {
                    if !(value as f32).is_finite() {
                        note(channel, pixel);
                    }
                }
            }
        }
        found
    }

    /// The layers as they stand, in the film's order.
    pub fn layers(&self) -> Vec<LayerPicture> {
        let pixels = self.pixel_count() as usize;
        let layer_numbers = numbers(&self.layers);
        let empty = |l: &NamedLayer| LayerPicture { name: l.name, format: l.format, values: vec![None; pixels] };
        let mut pictures: Vec<LayerPicture> = self.layers.iter().map(empty).collect();
        self.each_pixel(|pixel, tile, i| {
            let mut sums = &tile.layers[i * layer_numbers..];
            for LayerPicture { format, values, .. } in &mut pictures {
                let (own, rest) = sums.split_at(stride(format));
                values[pixel] = mean(format, own);
                sums = rest;
            }
        });
        pictures
    }

    /// The channels of the picture in the pixel `i` of a tile.
    fn values<'t>(&'t self, tile: &'t Tile, i: usize) -> impl Iterator<Item = f64> + 't {
        let n = self.channels.len();
        let points = self.points.as_ref().and_then(|points| points.pixel(tile.pixel(i))).unwrap_or_default();
        let weight = tile.weights[i];
        tile.sums[i * n..][..n].iter().enumerate().map(move |(c, sum)| {
            let mean = if weight != 0.0 { sum / weight } else { 0.0 };
            // Nothing is added where nothing is drawn: not even a sign of zero changes.
            points.get(c).map_or(mean, |point| mean + point)
        })
    }

    /// Calls `f` with the index of every pixel in the picture, its tile, and its index there.
    fn each_pixel(&self, mut f: impl FnMut(usize, &Tile, usize)) {
        let [x0, x1, y0, _] = self.crop;
        for tile in &self.tiles {
            let tile = tile.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            for i in 0..tile.weights.len() {
                let [x, y] = tile.pixel(i);
                f((y - y0) as usize * (x1 - x0) as usize + (x - x0) as usize, &tile, i);
            }
        }
    }
}

/// A channel with values that single precision cannot hold.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BeyondSinglePrecision {
    /// Its name.
    pub channel: String,
    /// How many pixels have such a value.
    pub pixels: u64,
    /// Column and row of one of them in the whole frame.
    pub first: [u32; 2],
}

/// Numbers that a layer of a pixel takes: its channels, and a weight; the variance has sums of squares besides.
fn stride(layer: &LayerFormat) -> usize {
    match layer.statistic {
        Statistic::ColorVariance => VARIANCE_NUMBERS,
        Statistic::Mean | Statistic::MeanDirection => layer.channels.len() + 1,
    }
}

/// Numbers that the variance of a pixel takes: see [`add_variance`].
const VARIANCE_NUMBERS: usize = 7;

/// Numbers that some layers of a pixel take.
fn numbers(layers: &[NamedLayer]) -> usize {
    layers.iter().map(|layer| stride(&layer.format)).sum()
}

/// Adds one sample of a layer, of the given weight, to its numbers in a pixel.
fn add(value: Value, weight: f64, sums: &mut [f64]) {
    let channels = sums.len() - 1;
    for c in 0..channels {
        sums[c] += weight * value[c];
    }
    sums[channels] += weight;
}

/// Adds a sample to means, sums of squared differences from them, and a count (Welford 1962).
fn add_variance(color: Value, numbers: &mut [f64]) {
    numbers[6] += 1.0;
    for c in 0..3 {
        let difference = color[c] - numbers[c];
        numbers[c] += difference / numbers[6];
        numbers[3 + c] += difference * (color[c] - numbers[c]);
    }
}

/// The mean of a layer's samples, from its numbers in a pixel; of the variance, the unbiased estimate.
fn mean(layer: &LayerFormat, sums: &[f64]) -> Option<Value> {
    if layer.statistic == Statistic::ColorVariance {
        let count = sums[6];
        return (count >= 2.0).then(|| std::array::from_fn(|c| sums[3 + c] / (count - 1.0)));
    }
    let (weight, sums) = sums.split_last().filter(|(w, _)| **w != 0.0)?;
    let mean: Value = std::array::from_fn(|c| sums.get(c).map_or(0.0, |s| s / weight));
    // As in pbrt-v4; opposite normals may cancel.
    Some(if layer.statistic == Statistic::MeanDirection { DVec3::from_array(mean).normalize_or_zero().to_array() } else { mean })
}

/// Where the numbers of the variance stand among those of the layers of a pixel, if it is one of them.
pub fn variance_at(layers: &[NamedLayer]) -> Option<usize> {
    let before = layers.iter().position(|l| l.format.statistic == Statistic::ColorVariance)?;
    Some(numbers(&layers[..before]))
}
