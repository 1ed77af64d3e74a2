//! Which wavelengths the samples of a picture have: those that its light has.
//!
//! By themselves they follow the eye's sensitivity ([`VisibleWavelengths`]). That makes noise where lamps have lines, or where gravity has shifted what they
//! emit out of much of the film's range. So some paths are followed before the first sample, all over the picture, whose wavelengths are half the eye's and half those that
//! lamps emit, and what each of them brings to the film's channels is summed up in bins. Half of these paths says how wavelengths would be drawn by it, and the other half whether that leaves less noise, by the second
//! moments of what they bring; only if both halves say so by much, wavelengths are drawn so.
//!
//! The paths depend on scene, seed and size of the picture alone: parts of a picture, and a render that goes on, have the same wavelengths.

use crate::job::Job;
use crate::not_finite::SampleId;
use crate::sample::CameraSample;
use arrayvec::ArrayVec;
use bhs_core::sampling::{SampleStream, r2_point};
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, SampledWavelengths, VisibleWavelengths, WAVELENGTH_BINS};
use bhs_engine::stats::PathLog;
use bhs_engine::transport::{BATCH, PathSample};
use glam::DVec3;
use rayon::prelude::*;

/// Paths that are followed at most.
const MOST: u64 = 1024;
/// Pixels to a path: small pictures are not worth the time.
const PIXELS: u64 = 16;
/// Paths without which nothing is learned.
const LEAST: u64 = 64;
/// Share of the wavelengths that are drawn as the paths say; the others see to what they have missed.
const LEARNED: f64 = 0.7;
/// The second moment has to get lower by this factor, or all stays as it is.
const GAIN: f64 = 0.6;
/// What a wavelength of a path brings counts up to so many times the median.
const BRIGHT: f64 = 8.0;
/// Lamps whose spectra are looked at, at most.
const LAMPS: usize = 1000;
/// Numbers of these paths are those of a wave that no render comes to.
const WAVE: u32 = 4095;

/// What a wavelength of a path brings.
#[derive(Clone, Copy)]
struct Brought {
    bin: usize,
    /// Over all channels of the film, the density taken into account.
    amount: f64,
}

/// The wavelengths of the samples of a picture. Runs on the current rayon pool.
pub fn drawn(job: &Job) -> VisibleWavelengths {
    let [lo, hi] = job.film.lambda_range();
    let plain = VisibleWavelengths::new(lo, hi);
    let [width, height] = job.film.resolution().map(u64::from);
    let paths = (width * height / PIXELS).min(MOST);
    if paths < LEAST {
        return plain;
    }
    let own = plain.shares();
    let first = emitted(job, &plain).and_then(|lamps| plain.with_shares(&std::array::from_fn(|i| 0.5 * (own[i] + lamps[i]))));
    let first = first.unwrap_or_else(|| plain.clone());
    let batches: Vec<Vec<Brought>> = (0..paths / BATCH as u64).into_par_iter().map(|batch| follow(job, &first, batch)).collect();
    let batches = damped(batches);
    let halves = [0, 1].map(|half| batches.iter().skip(half).step_by(2).flatten().copied().collect::<Vec<_>>());
    let first = first.shares();
    let gains = |learned_from: &[Brought], judged_by: &[Brought]| {
        learned(&own, learned_from).is_some_and(|new| {
            let moment = |shares: &[f64; WAVELENGTH_BINS]| {
                judged_by.iter().map(|b| b.amount * b.amount * first[b.bin] / shares[b.bin]).sum::<f64>()
            };
            moment(&new) < GAIN * moment(&own)
        })
    };
    if gains(&halves[0], &halves[1]) && gains(&halves[1], &halves[0]) {
        let all = halves.concat();
        return learned(&own, &all).and_then(|shares| plain.with_shares(&shares)).unwrap_or(plain);
    }
    plain
}

/// The share that each bin has of what the film takes of the lamps' light where it leaves them, as far as that is cheap to say: of lamps that are alike all
/// over, and of points. `None` if there are none.
fn emitted(job: &Job, wavelengths: &VisibleWavelengths) -> Option<[f64; WAVELENGTH_BINS]> {
    let (lights, world) = (&job.scene.light_sampler, &job.scene.world);
    let emitters = || lights.emitters.iter().filter(|e| e.light.is_uniform()).take(LAMPS);
    let mut channels = vec![0.0; job.film.channels().len()];
    let mut of_bin = |i: usize| {
        let [lo, hi] = [i, i + 1].map(|edge| wavelengths.edge(edge));
        let middle = SampledWavelengths { lambda_nm: [0.5 * (lo + hi); N_LAMBDA], pdf: [1.0; N_LAMBDA] };
        let from_areas = emitters().map(|e| e.power(&world.geometries[e.geometry as usize], lo, hi)).sum::<f64>();
        let several: [f32; N_LAMBDA] = std::array::from_fn(|k| lo + (hi - lo) * (k as f32 + 0.5) / N_LAMBDA as f32);
        let along = [DVec3::X, DVec3::Y, DVec3::Z].into_iter().flat_map(|axis| [axis, -axis]);
        let from_points = lights.lights.iter().take(LAMPS).map(|light| {
            along
                .clone()
                .map(|direction| light.intensity(direction, several).0.iter().map(|x| f64::from(*x)).sum::<f64>())
                .sum::<f64>()
        });
        channels.fill(0.0);
        job.film.add(SampledSpectrum::ONE, &middle, &mut channels);
        (from_areas + from_points.sum::<f64>()) * channels.iter().map(|c| c.abs()).sum::<f64>()
    };
    let all: [f64; WAVELENGTH_BINS] = std::array::from_fn(&mut of_bin);
    let sum: f64 = all.iter().sum();
    (sum > 0.0 && sum.is_finite()).then(|| all.map(|share| share / sum))
}

/// The same, where nothing is more than [`BRIGHT`] times the median: a lamp that is seen by itself would outweigh all that it shines on.
fn damped(mut batches: Vec<Vec<Brought>>) -> Vec<Vec<Brought>> {
    let mut amounts: Vec<f64> = batches.iter().flatten().map(|b| b.amount).collect();
    if !amounts.is_empty() {
        let middle = amounts.len() / 2;
        let most = BRIGHT * *amounts.select_nth_unstable_by(middle, f64::total_cmp).1;
        batches.iter_mut().flatten().for_each(|b| b.amount = b.amount.min(most));
    }
    batches
}

/// The share that each bin has by what was brought; `None` if that is nothing.
fn learned(own: &[f64; WAVELENGTH_BINS], from: &[Brought]) -> Option<[f64; WAVELENGTH_BINS]> {
    let mut sums = [0.0; WAVELENGTH_BINS];
    from.iter().for_each(|b| sums[b.bin] += b.amount);
    let all: f64 = sums.iter().sum();
    (all > 0.0 && all.is_finite()).then(|| std::array::from_fn(|i| (1.0 - LEARNED) * own[i] + LEARNED * sums[i] / all))
}

/// What the paths of a batch bring.
fn follow(job: &Job, wavelengths: &VisibleWavelengths, batch: u64) -> Vec<Brought> {
    let [width, height] = job.film.resolution();
    let (mut seen, mut followed) = (ArrayVec::<CameraSample, BATCH>::new(), ArrayVec::<PathSample, BATCH>::new());
    for i in (0..BATCH as u64).map(|k| batch * BATCH as u64 + k) {
        // All over the picture, whatever its width.
        let place = r2_point(i);
        let pixel = [(place[0] * f64::from(width)) as u32, (place[1] * f64::from(height)) as u32];
        let stream = SampleStream::of_wave(job.sampler, pixel, 0, WAVE);
        let (sample, path) = CameraSample::new(job, wavelengths, SampleId { pixel, sample: 0 }, stream);
        seen.push(sample);
        followed.push(path);
    }
    let mut log = PathLog::default();
    job.transport.follow_all(job.scene, &mut followed, &mut log);
    let mut channels = vec![0.0; job.film.channels().len()];
    let mut brought = Vec::with_capacity(N_LAMBDA * BATCH);
    for (seen, path) in seen.iter().zip(&followed) {
        let radiance = seen.received(job, path.radiance, &mut log);
        for k in 0..N_LAMBDA {
            let mut one = SampledSpectrum::ZERO;
            one[k] = radiance[k];
            channels.fill(0.0);
            job.film.add(one, &seen.lambda, &mut channels);
            let amount = channels.iter().map(|c| c.abs()).sum::<f64>();
            if amount > 0.0 && amount.is_finite() {
                brought.push(Brought { bin: wavelengths.bin(seen.lambda.lambda_nm[k]), amount });
            }
        }
    }
    brought
}
