//! The frame under way: sums and weights of pixels, in tiles that are each worked on by one thread at a time.

mod exact;
mod layer_sums;
mod noise;
mod tile;
mod values;

pub use exact::ExactSums;
pub use layer_sums::{numbers as layer_numbers, variance_at};
pub use noise::PixelNoise;
pub use tile::{Tile, TileProgress};
pub use values::{SeenTile, TileValues};

use crate::image::{Frame, Picture, single_precision};
use crate::layers::LayerPicture;
use crate::memory::OutOfMemory;
use crate::point_picture::PointPicture;
use bhs_core::camera::Film;
use bhs_engine::layer::NamedLayer;
use layer_sums::{mean, numbers, stride};
use std::collections::TryReserveError;
use std::sync::{Mutex, PoisonError};

/// Sides that tiles may have (pixels).
const SIDES: [u32; 3] = [16, 8, 4];
/// Tiles that a picture has where it can: one thread at a time works on a tile.
const TILES: u64 = 64;

/// Side of the tiles of a picture of this width and height (pixels): small pictures have small tiles, so that there is work for all threads.
pub fn tile_side([width, height]: [u32; 2]) -> u32 {
    let tiles = |side: u32| u64::from(width.div_ceil(side)) * u64::from(height.div_ceil(side));
    SIDES.into_iter().find(|side| tiles(*side) >= TILES).unwrap_or(SIDES[2])
}

/// The least and the greatest of two such pairs.
fn least_and_most(a: [u32; 2], b: [u32; 2]) -> [u32; 2] {
    [a[0].min(b[0]), a[1].max(b[1])]
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

impl Framebuffer {
    /// Memory that the frame of a film with these layers takes (bytes): for its sums, and for the tiles that they are divided into.
    pub fn bytes(film: &dyn Film, layers: &[NamedLayer]) -> [u64; 2] {
        let [width, height] = Self::size(film);
        let numbers = film.channels().len() + 1 + numbers(layers);
        let side = tile_side([width, height]);
        let tiles = u64::from(width.div_ceil(side)) * u64::from(height.div_ceil(side));
        // A tile has three lists of sums, before each of which stands a word or two of the allocator's.
        let tile = size_of::<Mutex<Tile>>() + 3 * 2 * size_of::<usize>();
        [u64::from(width) * u64::from(height) * (numbers * ExactSums::BYTES) as u64, tiles * tile as u64]
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
        Self::from_sample(0, film, layers)
    }

    /// The same, whose pixels get the samples from the given one on: those before are another part's.
    ///
    /// # Errors
    /// If there is not enough memory for it.
    pub fn from_sample(first: u32, film: &dyn Film, layers: &[NamedLayer]) -> Result<Self, OutOfMemory> {
        Self::try_new(first, film, layers).map_err(|_| OutOfMemory::new("the film", Self::bytes(film, layers).iter().sum()))
    }

    fn try_new(first: u32, film: &dyn Film, layers: &[NamedLayer]) -> Result<Self, TryReserveError> {
        let [x0, x1, y0, y1] = film.crop();
        let channels = film.channels();
        let layer_numbers = numbers(layers);
        let mut tiles = Vec::new();
        let [width, height] = Self::size(film);
        let side = tile_side([width, height]);
        tiles.try_reserve_exact((width.div_ceil(side) as usize).saturating_mul(height.div_ceil(side) as usize))?;
        for y in (y0..y1).step_by(side as usize) {
            for x in (x0..x1).step_by(side as usize) {
                let size = [side.min(x1 - x), side.min(y1 - y)];
                tiles.push(Mutex::new(Tile::empty([x, y], size, [channels.len(), layer_numbers], first)?));
            }
        }
        Ok(Self { tiles, crop: film.crop(), frame: film.resolution(), channels, layers: layers.to_vec(), points: None })
    }

    /// The same frame with the points of the sky that its picture shows besides samples.
    pub fn with_points(self, points: Option<PointPicture>) -> Self {
        Self { points, ..self }
    }

    /// The tile that has a pixel of the whole frame, which lies within what is rendered.
    pub fn tile_of(&self, [x, y]: [u32; 2]) -> &Mutex<Tile> {
        let side = tile_side(self.size_of_picture());
        let across = (self.crop[1] - self.crop[0]).div_ceil(side);
        let (column, row) = ((x - self.crop[0]) / side, (y - self.crop[2]) / side);
        &self.tiles[row as usize * across as usize + column as usize]
    }

    /// The points of the sky, if it shows any.
    pub fn points(&self) -> Option<&PointPicture> {
        self.points.as_ref()
    }

    /// What is rendered of the frame: x0, x1, y0, y1 (pixels).
    pub fn crop(&self) -> [u32; 4] {
        self.crop
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

    /// What `of` says of each tile. Waits for threads that are at work on it.
    fn of_tiles<T>(&self, of: impl Fn(&Tile) -> T) -> impl Iterator<Item = T> {
        self.tiles.iter().map(move |tile| of(&tile.lock().unwrap_or_else(PoisonError::into_inner)))
    }

    /// Samples so far, those of all pixels together. Waits for threads that are at work on a tile.
    pub fn samples(&self) -> u64 {
        self.of_tiles(Tile::samples).sum()
    }

    /// The ends of the samples that every tile has, and that the pixel with the most may have. Waits for threads that are at work on a tile.
    pub fn sample_counts(&self) -> [u32; 2] {
        self.of_tiles(|tile| [tile.progress.done, tile.progress.most()]).reduce(least_and_most).unwrap_or_default()
    }

    /// Samples of the pixel with the fewest, and of the one with the most: [`Framebuffer::sample_counts`], but for adaptive sampling. Waits for threads
    /// that are at work on a tile.
    pub fn pixel_samples(&self) -> [u32; 2] {
        self.of_tiles(Tile::pixel_samples).reduce(least_and_most).unwrap_or_default()
    }

    /// Has adaptive sampling look at all pixels, before there is any sample.
    ///
    /// # Errors
    /// If there is not enough memory for it.
    pub fn watching_noise(mut self) -> Result<Self, OutOfMemory> {
        let bytes = self.pixel_count() * size_of::<PixelNoise>() as u64;
        let mut tiles = self.tiles.iter_mut().map(|tile| tile.get_mut().unwrap_or_else(PoisonError::into_inner));
        let watched = tiles.try_for_each(Tile::watch_noise);
        watched.map(|()| self).map_err(|_| OutOfMemory::new("adaptive sampling", bytes))
    }

    /// Pixels that take part in the wave under way, where adaptive sampling decides. Waits for threads that are at work on a tile.
    pub fn pixels_under_way(&self) -> u64 {
        self.of_tiles(|tile| tile.noise.iter().filter(|noise| noise.under_way).count() as u64).sum()
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
            let mut at = i * layer_numbers;
            for LayerPicture { format, values, .. } in &mut pictures {
                values[pixel] = mean(format, &tile.layers, at);
                at += stride(format);
            }
        });
        pictures
    }

    /// Calls `f` with red, green and blue of each pixel of the picture, and with the greatest magnitude of all its channels.
    pub fn each_color(&self, mut f: impl FnMut([f64; 3], f64)) {
        self.each_pixel(|_, tile, i| {
            let mut values = self.values(tile, i);
            let color: [f64; 3] = std::array::from_fn(|_| values.next().unwrap_or_default());
            f(color, color.into_iter().chain(values).fold(0.0, |most, c| most.max(c.abs())));
        });
    }

    /// The channels of the picture in the pixel `i` of a tile.
    fn values<'t>(&'t self, tile: &'t Tile, i: usize) -> impl Iterator<Item = f64> + 't {
        let n = self.channels.len();
        let points = self.points.as_ref().and_then(|points| points.pixel(tile.pixel(i))).unwrap_or_default();
        let weight = tile.weights.value(i);
        (0..n).map(move |c| {
            let mean = if weight != 0.0 { tile.sums.value(i * n + c) / weight } else { 0.0 };
            // Nothing is added where nothing is drawn: not even a sign of zero changes.
            points.get(c).map_or(mean, |point| mean + point)
        })
    }

    /// Calls `f` with the index of every pixel in the picture, its tile, and its index there.
    pub(crate) fn each_pixel(&self, mut f: impl FnMut(usize, &Tile, usize)) {
        let [x0, x1, y0, _] = self.crop;
        for tile in &self.tiles {
            let tile = tile.lock().unwrap_or_else(PoisonError::into_inner);
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
