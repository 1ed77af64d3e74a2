//! The frame under way: sums and weights of pixels, in tiles that are each worked on by one thread at a time.

use crate::image::{Frame, Picture};
use bhs_core::camera::Film;
use std::sync::Mutex;

/// Side of a tile (pixels).
const TILE: u32 = 16;

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
}

/// All tiles of the part of the frame that is rendered.
pub struct Framebuffer {
    /// The tiles, row by row.
    pub tiles: Vec<Mutex<Tile>>,
    crop: [u32; 4],
    frame: [u32; 2],
    channels: Vec<String>,
}

impl Framebuffer {
    /// An empty frame of a film.
    pub fn new(film: &dyn Film) -> Self {
        let [x0, x1, y0, y1] = film.crop();
        let channels = film.channels();
        let mut tiles = Vec::new();
        for y in (y0..y1).step_by(TILE as usize) {
            for x in (x0..x1).step_by(TILE as usize) {
                let size = [TILE.min(x1 - x), TILE.min(y1 - y)];
                let pixels = (size[0] * size[1]) as usize;
                tiles.push(Mutex::new(Tile {
                    origin: [x, y],
                    size,
                    sums: vec![0.0; pixels * channels.len()],
                    weights: vec![0.0; pixels],
                }));
            }
        }
        Self { tiles, crop: film.crop(), frame: film.resolution(), channels }
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

    /// The picture as it stands: every pixel the weighted mean of the samples that it has; black without any.
    pub fn picture(&self) -> Picture {
        let [x0, x1, y0, y1] = self.crop.map(|c| c as usize);
        let (width, height, n) = (x1 - x0, y1 - y0, self.channels.len());
        let mut data = vec![0.0f32; width * height * n];
        for tile in &self.tiles {
            let tile = tile.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
            for (i, weight) in tile.weights.iter().enumerate().filter(|(_, w)| **w != 0.0) {
                let x = tile.origin[0] as usize - x0 + i % tile.size[0] as usize;
                let y = tile.origin[1] as usize - y0 + i / tile.size[0] as usize;
                for c in 0..n {
                    data[(y * width + x) * n + c] = (tile.sums[i * n + c] / weight) as f32;
                }
            }
        }
        let frame = Frame { offset: [x0, y0], size: self.frame.map(|s| s as usize) };
        Picture { size: [width, height], frame, channels: self.channels.clone(), data }
    }
}
