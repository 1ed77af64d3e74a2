//! Whether guiding pays: blocks of pixels all over the picture are rendered with what was learned and without, twice each. How far the two pictures of one kind
//! are apart is their noise, however well their samples are distributed; the rays that they took are their cost. It is a function of scene and seed, as all that is
//! learned.
//!
//! Noise counts relative to the light of its block: relative to that of its own pixel it would look least where light is hardly ever found.

use super::Guide;
use bhs_core::sampling::{SampleStream, r2_point};
use bhs_core::spectrum::SampledWavelengths;
use bhs_engine::stats::PathLog;
use bhs_engine::transport::{BATCH, PathSample, RenderSetting};
use glam::Vec2;
use rayon::prelude::*;

/// Width and height of a block (pixels).
const BLOCK: [usize; 2] = [4, 2];
const PIXELS: usize = BLOCK[0] * BLOCK[1];
/// Samples of a pixel in a picture.
const SAMPLES: usize = 16;
/// Pixels of the whole picture for each block: all trials together take as many paths as that has pixels. And how many blocks there are at least and at most.
const PIXELS_PER_BLOCK: u64 = 4 * (PIXELS * SAMPLES) as u64;
const BLOCKS: [u64; 2] = [8, 256];
/// The columns of pixels that no picture has whose random numbers these are, one for each of two pictures.
const COLUMNS: [u32; 2] = [u32::MAX - 2, u32::MAX - 3];
/// What a guided ray costs, over one that is not: its place is to be found, and its table.
const COST: f64 = 1.15;
/// Noise counts relative to the light of its block and this share of the picture's mean.
const DARK: f64 = 0.02;

/// Share of all blocks whose noise counts as the least of them: single bright paths shall not decide.
const BRIGHTEST: f64 = 0.02;

/// How paths are followed: with a guide or without.
pub type Follow<'f> = dyn Fn(Option<&Guide>, &mut [PathSample], &mut PathLog) + Sync + 'f;

/// A block, rendered without guiding and with it.
#[derive(Clone, Copy, Default)]
struct Block {
    /// Mean of its light.
    mean: f64,
    /// Mean square of the differences between two pictures of each kind.
    noise: [f64; 2],
    /// Rays of each kind.
    rays: [u64; 2],
}

/// By how much `guide` lowers noise times cost; `None` if the render is to end meanwhile.
pub fn gain(setting: &RenderSetting, guide: &Guide, follow: &Follow<'_>) -> Option<f64> {
    let count = (setting.all_pixels() / PIXELS_PER_BLOCK).clamp(BLOCKS[0], BLOCKS[1]) as usize;
    let blocks: Vec<Block> = (0..count).into_par_iter().map(|number| block(setting, number, guide, follow)).collect();
    (!(setting.is_stopped)()).then(|| gain_of(&blocks))
}

/// The same of `blocks`.
fn gain_of(blocks: &[Block]) -> f64 {
    let dark = DARK * blocks.iter().map(|b| b.mean).sum::<f64>() / blocks.len() as f64;
    let relative = |b: &Block| b.noise.map(|n| n / (b.mean * b.mean + dark * dark));
    let noise: Vec<[f64; 2]> = blocks.iter().map(relative).filter(|n| n.iter().all(|n| n.is_finite())).collect();
    let mut sorted: Vec<f64> = noise.iter().flatten().copied().collect();
    sorted.sort_by(f64::total_cmp);
    let Some(most) = sorted.get((sorted.len() as f64 * (1.0 - BRIGHTEST)) as usize) else { return 0.0 };
    let [without, with] = [0, 1].map(|kind| {
        let noise = noise.iter().map(|n| n[kind].min(*most)).sum::<f64>();
        noise * blocks.iter().map(|b| b.rays[kind]).sum::<u64>() as f64
    });
    without / (with * COST)
}

/// Block number `number`; nothing if the render is to end.
fn block(setting: &RenderSetting, number: usize, guide: &Guide, follow: &Follow<'_>) -> Block {
    let mut block = Block::default();
    for (kind, guide) in [None, Some(guide)].into_iter().enumerate() {
        if (setting.is_stopped)() {
            return block;
        }
        let [one, other] = COLUMNS.map(|column| {
            let mut paths = paths(setting, number, column);
            let mut log = PathLog::default();
            paths.chunks_mut(BATCH).for_each(|paths| follow(guide, paths, &mut log));
            block.rays[kind] += log.counters.geodesics + log.counters.shadow_rays;
            let mean =
                |samples: &[PathSample]| samples.iter().map(|p| f64::from(p.radiance.mean())).sum::<f64>() / SAMPLES as f64;
            std::array::from_fn::<f64, PIXELS, _>(|pixel| mean(&paths[pixel * SAMPLES..][..SAMPLES]))
        });
        for (one, other) in one.into_iter().zip(other) {
            block.mean += 0.25 * (one + other) / PIXELS as f64;
            block.noise[kind] += (one - other) * (one - other) / PIXELS as f64;
        }
    }
    block
}

/// The paths of block number `number`, pixel by pixel, in the picture whose random numbers are those of `column`.
fn paths<'a>(setting: &RenderSetting<'a>, number: usize, column: u32) -> Vec<PathSample<'a>> {
    let RenderSetting { sampler, lambda_range: [lo, hi], camera_ray, resolution, .. } = setting;
    let size = Vec2::from_array(resolution.map(|n| n as f32));
    // All over the picture, whatever its width.
    let place = r2_point(number as u64).map(|x| x as f32);
    let room = (size - Vec2::from_array(BLOCK.map(|n| n as f32))).max(Vec2::ZERO);
    let corner = (Vec2::from_array(place) * room).round();
    let path = |i: usize| {
        let (pixel, sample) = (i / SAMPLES, i % SAMPLES);
        let within = Vec2::new((pixel % BLOCK[0]) as f32, (pixel / BLOCK[0]) as f32);
        let mut stream = SampleStream::new(*sampler, [column, (number * PIXELS + pixel) as u32], sample as u32);
        let (film, lens) = (stream.next_2d(), stream.next_2d());
        let lambda = SampledWavelengths::visible(stream.wavelengths(), *lo, *hi);
        PathSample::new(camera_ray(((corner + within + film) / size).min(Vec2::ONE), lens), lambda, stream)
    };
    (0..PIXELS * SAMPLES).map(path).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Blocks of which every fourth is dark, with the noise of each kind relative to their light.
    fn blocks(noise: [f64; 2], rays: [u64; 2]) -> Vec<Block> {
        let block = |i: usize| {
            let mean = if i.is_multiple_of(4) { 0.1 } else { 10.0 };
            Block { mean, noise: noise.map(|n| n * mean * mean), rays }
        };
        (0..64).map(block).collect()
    }

    #[test]
    fn half_of_the_noise_is_worth_twice_the_rays() {
        for (noise, rays, expected) in
            [([1.0, 0.5], [100, 200], 1.0), ([1.0, 1.0], [100, 100], 1.0), ([3.0, 1.0], [50, 100], 1.5)]
        {
            let gain = gain_of(&blocks(noise, rays)) * COST;
            assert!((gain / expected - 1.0).abs() < 1e-12, "{gain} {expected}");
        }
    }

    #[test]
    fn what_is_dark_and_light_that_is_not_there_decide_nothing() {
        let mut blocks = blocks([1.0, 0.5], [100, 100]);
        let before = gain_of(&blocks);
        blocks.push(Block { mean: 1e-9, noise: [0.0, 1e-9], rays: [100, 100] });
        assert!((gain_of(&blocks) / before - 1.0).abs() < 0.01);
        // A picture without light has no gain that is above anything.
        assert_eq!(gain_of(&[Block::default(); 8]), 0.0);
    }
}
