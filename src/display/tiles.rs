//! The tiles of a frame that have changed, as viewers take them: side by side in one piece.

use super::packet::Pixels;
use crate::film::{Framebuffer, SeenTile, TileValues, tile_side};

impl Framebuffer {
    /// Calls `send` with the pixels of all tiles that have more samples than have been `seen`, which is brought up to date. Neighbours in a
    /// row are one piece.
    ///
    /// # Errors
    /// The first of `send`.
    pub(super) fn changed<E>(&self, seen: &mut [SeenTile], mut send: impl FnMut(Pixels) -> Result<(), E>) -> Result<(), E> {
        let size = self.size_of_picture();
        let in_row = size[0].div_ceil(tile_side(size)).max(1) as usize;
        let mut run: Vec<TileValues> = Vec::new();
        for (number, seen) in seen.iter_mut().enumerate() {
            let tile = self.news_of(number, seen);
            if (tile.is_none() || number % in_row == 0) && !run.is_empty() {
                send_run(&run, &mut send)?;
                run.clear();
            }
            if let Some(tile) = tile {
                run.push(tile);
            }
        }
        if run.is_empty() { Ok(()) } else { send_run(&run, &mut send) }
    }
}

/// Sends tiles that stand side by side.
fn send_run<E>(run: &[TileValues], send: &mut impl FnMut(Pixels) -> Result<(), E>) -> Result<(), E> {
    let (at, height) = (run[0].at, run[0].size[1]);
    let width = run.iter().map(|tile| tile.size[0]).sum();
    let mut data = Vec::with_capacity(run.iter().map(|tile| tile.data.len()).sum());
    for y in 0..height as usize {
        for tile in run {
            let row = tile.data.len() / height as usize;
            data.extend_from_slice(&tile.data[y * row..][..row]);
        }
    }
    send(Pixels { at, size: [width, height], data: &data })
}
