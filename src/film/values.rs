//! The values of single tiles, for whoever looks at a frame under way.

use super::{Framebuffer, mean, numbers, stride};
use crate::image::single_precision;
use crate::layers::numbers_in_files;
use std::sync::{PoisonError, TryLockError};

/// How often a tile that somebody is at work on is left for another time. A picture of few tiles has hardly one that nobody works on.
const PATIENCE: u8 = 2;

/// What a picture has of one tile: the same numbers, to the bit, as [`Framebuffer::picture`] with its layers.
pub struct TileValues {
    /// Column and row of its first pixel in what is rendered.
    pub at: [u32; 2],
    /// Width and height (pixels).
    pub size: [u32; 2],
    /// Row by row from the top, the channels of a pixel together, those of the layers last.
    pub data: Vec<f32>,
}

/// What somebody who looks at a tile now and then has seen of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct SeenTile {
    /// Samples that it had, those of all pixels together.
    samples: u64,
    /// How often it has been left for another time since.
    missed: u8,
}

impl Framebuffer {
    /// The tile `number` as it stands, if it has more samples than have been `seen`, which is brought up to date. One that somebody is at work
    /// on is left for another time, but not for long.
    pub fn news_of(&self, number: usize, seen: &mut SeenTile) -> Option<TileValues> {
        let tile = match self.tiles[number].try_lock() {
            Ok(tile) => tile,
            Err(TryLockError::Poisoned(tile)) => tile.into_inner(),
            Err(TryLockError::WouldBlock) if seen.missed < PATIENCE => {
                seen.missed += 1;
                return None;
            }
            Err(TryLockError::WouldBlock) => self.tiles[number].lock().unwrap_or_else(PoisonError::into_inner),
        };
        seen.missed = 0;
        if tile.samples() <= seen.samples {
            return None;
        }
        seen.samples = tile.samples();
        let layer_numbers = numbers(&self.layers);
        let mut data = Vec::with_capacity(tile.weights.len() * self.all_channels().len());
        for i in 0..tile.weights.len() {
            data.extend(self.values(&tile, i).map(single_precision));
            let mut at = i * layer_numbers;
            for layer in &self.layers {
                let own = numbers_in_files(mean(&layer.format, &tile.layers, at));
                data.extend_from_slice(&own[..layer.format.channels.len()]);
                at += stride(&layer.format);
            }
        }
        let at = [tile.origin[0] - self.crop[0], tile.origin[1] - self.crop[2]];
        Some(TileValues { at, size: tile.size, data })
    }

    /// The names of the channels, those of the layers last.
    pub fn all_channels(&self) -> Vec<String> {
        let of_layers = self.layers.iter().flat_map(|layer| layer.format.channels.iter().map(|c| (*c).to_owned()));
        self.channels.iter().cloned().chain(of_layers).collect()
    }

    /// Width and height of what is rendered (pixels).
    pub fn size_of_picture(&self) -> [u32; 2] {
        let [x0, x1, y0, y1] = self.crop;
        [x1 - x0, y1 - y0]
    }
}

#[cfg(test)]
mod tests {
    use super::{PATIENCE, SeenTile};
    use crate::lang::{Overrides, SourceMap, load_text};
    use crate::registry::Registry;
    use crate::render::render_quietly;

    #[test]
    fn tiles_are_the_picture_to_the_bit() {
        let scene = r#"Film "rgb" "integer xresolution" 37 "integer yresolution" 21 "string layers" ["normal" "depth" "variance"]
            "float cropwindow" [0.1 0.9 0.2 1]
            Sampler "sobol" "integer pixelsamples" 3
            WorldBegin
            LightSource "infinite"
            Translate 0 0 3
            Shape "sphere""#;
        let built = load_text("a", scene, &Registry::builtin(), &Overrides::default(), &mut SourceMap::new());
        let frame = render_quietly(&built.unwrap_or_else(|found| panic!("{found:?}"))).frame;
        let picture = frame.picture().with_layers(&frame.layers());
        assert_eq!(frame.all_channels(), picture.channels);
        let n = picture.channels.len();
        let mut pixels = 0;
        for number in 0..frame.tiles.len() {
            let mut seen = SeenTile::default();
            let worker = frame.tiles[number].lock().expect("nobody else");
            assert!((0..PATIENCE).all(|_| frame.news_of(number, &mut seen).is_none()), "somebody is at work on it");
            drop(worker);
            let tile = frame.news_of(number, &mut seen).expect("nobody is at work on it");
            assert!(frame.news_of(number, &mut seen).is_none(), "all of it has been seen");
            for (i, own) in tile.data.chunks_exact(n).enumerate() {
                let (x, y) = (tile.at[0] + i as u32 % tile.size[0], tile.at[1] + i as u32 / tile.size[0]);
                let whole = picture.pixel(x as usize, y as usize);
                assert!(own.iter().map(|v| v.to_bits()).eq(whole.iter().map(|v| v.to_bits())), "{x} {y}");
                pixels += 1;
            }
        }
        assert_eq!(pixels, picture.size[0] * picture.size[1]);
        assert!(picture.data.iter().any(|v| *v != 0.0));
    }
}
