//! A first impression of a picture: a few samples for each square of pixels.

use super::{CameraSample, Job};
use crate::image::{Frame, Picture, single_precision};
use crate::not_finite::SampleId;
use crate::patches::Patches;
use arrayvec::ArrayVec;
use bhs_core::sampling::SampleStream;
use bhs_core::spectrum::VisibleWavelengths;
use bhs_engine::stats::PathLog;
use bhs_engine::transport::{BATCH, PathSample};
use rayon::prelude::*;

/// Samples of a square, at most: colours of a single one are those of four wavelengths.
const SAMPLES: u32 = 4;

/// The colours of the picture of a job, in squares of `side` pixels that have a few samples each, without points of the sky; `None` once
/// `stop` says so. Runs on the current rayon pool.
pub fn coarse(job: &Job, side: u32, stop: impl Fn() -> bool + Sync) -> Option<Picture> {
    let [x0, x1, y0, y1] = job.film.crop();
    let channels = job.film.channels();
    let n = channels.len();
    let (columns, rows) = ((x1 - x0).div_ceil(side), (y1 - y0).div_ceil(side));
    let samples = SAMPLES.min(job.sampler.samples_per_pixel());
    let row = |row: u32| -> Option<Vec<f32>> {
        let [lo, hi] = job.film.lambda_range();
        let wavelengths = VisibleWavelengths::new(lo, hi);
        let mut log = PathLog::default();
        let (mut sums, mut weights) = (vec![0.0; columns as usize * n], vec![0.0; columns as usize]);
        // The middle of each square.
        let middle = |start: u32, square: u32, end: u32| (start + square * side + side / 2).min(end - 1);
        let pixel = |column| [middle(x0, column, x1), middle(y0, row, y1)];
        let patches = Patches::of(job, (0..columns).map(pixel));
        let mut left = (0..columns).flat_map(|column| (0..samples).map(move |index| (column, index))).peekable();
        while left.peek().is_some() {
            if stop() {
                return None;
            }
            let (mut seen, mut paths) = (ArrayVec::<CameraSample, BATCH>::new(), ArrayVec::<PathSample, BATCH>::new());
            let mut squares = ArrayVec::<usize, BATCH>::new();
            for (column, index) in left.by_ref().take(BATCH) {
                let pixel = pixel(column);
                let stream = SampleStream::new(job.sampler, pixel, index);
                let (sample, mut path) = CameraSample::new(job, &wavelengths, SampleId { pixel, sample: index }, stream);
                path.patch = patches.get(column as usize);
                squares.push(column as usize);
                seen.push(sample);
                paths.push(path);
            }
            job.transport.follow_all(job.scene, &mut paths, &mut log);
            for ((seen, path), square) in seen.iter().zip(&paths).zip(squares) {
                weights[square] += seen.add(job, path, &mut sums[square * n..][..n], &mut log).unwrap_or(0.0);
            }
        }
        let mean = |(sum, at): (&f64, usize)| single_precision(if weights[at] != 0.0 { sum / weights[at] } else { 0.0 });
        Some(sums.iter().zip((0..columns as usize).flat_map(|column| std::iter::repeat_n(column, n))).map(mean).collect())
    };
    let squares = (0..rows).into_par_iter().map(row).collect::<Option<Vec<_>>>()?;
    let (width, height) = ((x1 - x0) as usize, (y1 - y0) as usize);
    let mut data = Vec::with_capacity(width * height * n);
    for y in 0..height {
        let row = &squares[y / side as usize];
        (0..width).for_each(|x| data.extend_from_slice(&row[x / side as usize * n..][..n]));
    }
    let frame = Frame { offset: [x0 as usize, y0 as usize], size: job.film.resolution().map(|s| s as usize) };
    Some(Picture { size: [width, height], frame, channels, data })
}
