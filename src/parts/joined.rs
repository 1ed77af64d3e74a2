//! Parts of one picture joined.

use super::Cover;
use super::file::{PartReader, Piece, empty_tile, film_of, restore};
use super::join::PictureParts;
use crate::checkpoint::format::ReadError;
use crate::film::Framebuffer;
use crate::not_finite::FirstSamples;
use crate::point_picture::PointPicture;
use crate::render::{Ended, Rendered};
use anyhow::{Context, Result, anyhow};
use bhs_core::camera::Film;
use bhs_engine::stats::Counters;
use std::fs::File;
use std::path::Path;
use std::sync::{Arc, PoisonError};

/// Adds up the parts of a picture. In memory there are the frame, and a tile of one part after the other.
///
/// # Errors
/// If a file is not as it was, or there is not enough memory.
pub fn join(picture: &PictureParts, open: impl Fn(&Path) -> Result<File, String>) -> Result<(Rendered, Box<dyn Film>)> {
    let first = picture.parts.first().context("there is no part")?;
    let (film, layers) = film_of(&first.head).context("the film of the parts cannot be made")?;
    let frame = Framebuffer::new(&*film, &layers)?;
    let mut points = PointPicture::new(film.channels().len());
    let (mut counters, mut not_finite, mut seconds) = (Counters::default(), FirstSamples::default(), 0.0);
    for part in &picture.parts {
        let shown = part.path.display();
        let changed = || format!("`{shown}` has changed while it was read");
        let file = open(&part.path).map_err(|why| anyhow!("cannot read `{shown}`: {why}"))?;
        let reader = PartReader::new(file).with_context(changed)?;
        if reader.head != part.head {
            return Err(anyhow!(changed()));
        }
        counters += reader.statistics.counters;
        not_finite.merge(&reader.statistics.not_finite);
        seconds += reader.statistics.seconds;
        let unfit = || ReadError::Damaged("it does not fit the film".to_owned());
        reader
            .pieces(|piece| match piece {
                Piece::Stars(bytes) => points.add_bytes(&bytes).ok_or_else(unfit),
                Piece::Tile(number, bytes) => {
                    let mut tile = empty_tile(&part.head, &*film, &layers, number).ok_or_else(unfit)?;
                    restore(&mut tile, &bytes, &part.head)?;
                    for i in 0..tile.weights.len() {
                        let pixel = tile.pixel(i);
                        let mut own = frame.tile_of(pixel).lock().unwrap_or_else(PoisonError::into_inner);
                        let at = own.index(pixel);
                        own.add_pixel(at, &tile, i);
                    }
                    Ok(())
                }
            })
            .with_context(changed)?;
    }
    let [samples, most_samples] = sample_counts(picture);
    let points = Some(points).filter(|points| !points.is_empty());
    let rendered = Rendered {
        frame: Arc::new(frame.with_points(points)),
        counters,
        not_finite,
        samples,
        most_samples,
        noise: None,
        seconds,
        ended: if picture.missing.is_empty() { Ended::Complete } else { Ended::Underway },
    };
    Ok((rendered, film))
}

/// Samples that every pixel has, and the end of those that some pixel has.
fn sample_counts(picture: &PictureParts) -> [u32; 2] {
    let most = picture.parts.iter().map(|p| p.head.cover.samples[1]).max().unwrap_or_default();
    let Some(whole) = picture.whole() else { return [0, most] };
    if picture.missing.is_empty() {
        return [most; 2];
    }
    let [x0, x1, y0, y1] = whole.window;
    let mut counts = vec![0u32; (x1 - x0) as usize * (y1 - y0) as usize];
    for Cover { window: [a, b, c, d], samples } in picture.parts.iter().map(|p| p.head.cover) {
        for y in c..d {
            let row = &mut counts[(y - y0) as usize * (x1 - x0) as usize..];
            row[(a - x0) as usize..(b - x0) as usize].iter_mut().for_each(|n| *n += samples[1] - samples[0]);
        }
    }
    [counts.into_iter().min().unwrap_or_default(), most]
}
