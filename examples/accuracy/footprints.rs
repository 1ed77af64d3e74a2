//! What the footprint of rays from rough surfaces does to pictures: the same paths with footprints of several sizes.

use crate::hits::RAYS;
use anyhow::Result;
use bhs::bench::clock::processor_seconds;
use bhs::bench::rays::{arrivals, bounce_rays, camera_rays, diagonal, differences, truth};
use bhs::bench::table::Table;
use bhs::lang::{BuiltScene, Overrides};
use bhs::render::render_quietly;
use bhs_engine::scene::Footprints;
use bhs_engine::stats::Counters;
use bhs_integrators::Adaptive;
use bhs_integrators::Tolerance;

/// Size of the pictures, and samples a pixel.
const SIZE: [u32; 2] = [64, 48];
const SAMPLES: u32 = 64;

/// Side of the blocks whose means are compared (pixels).
const BLOCK: usize = 8;

/// Footprints after a rough bounce, relative to the scene's diagonal.
const ROUGH: [f64; 4] = [1e-3, 1e-2, 3e-2, 1e-1];

/// The footprint that stands for the truth: a tolerance of 1e-6.
const TRUTH: f64 = 1e-5;

/// The resolution that the scenes ask for, whose pixels set the footprint of camera rays, over that of the pictures here.
const FINER: f64 = 10.0;

/// A picture: luminance by pixel, what was counted, seconds of processor time.
struct Rendered {
    luminance: Vec<f64>,
    counters: Counters,
    seconds: f64,
}

fn picture(built: &BuiltScene) -> Rendered {
    let start = processor_seconds();
    let rendered = render_quietly(built);
    let seconds = processor_seconds() - start;
    // Linear sRGB to luminance (IEC 61966-2-1).
    let luminance = |p: &[f32]| 0.2126 * f64::from(p[0]) + 0.7152 * f64::from(p[1]) + 0.0722 * f64::from(p[2]);
    Rendered {
        luminance: rendered.frame.picture().data.chunks_exact(3).map(luminance).collect(),
        counters: rendered.counters,
        seconds,
    }
}

/// Mean of some numbers, and its standard error if they are independent.
fn mean(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / (n - 1.0);
    (mean, (variance / n).sqrt())
}

/// The blocks of a picture, each as its pixels' values.
fn blocks(pixels: &[f64]) -> Vec<Vec<f64>> {
    let [width, height] = SIZE.map(|s| s as usize);
    let block = |i: usize| {
        let (x, y) = (i % (width / BLOCK) * BLOCK, i / (width / BLOCK) * BLOCK);
        (0..BLOCK * BLOCK).map(|p| pixels[(y + p / BLOCK) * width + x + p % BLOCK]).collect()
    };
    (0..width / BLOCK * (height / BLOCK)).map(block).collect()
}

/// Root mean square of block differences over the blocks' means, and over their standard errors; only of blocks that are lit.
fn block_differences(difference: &[f64], truth: &[f64]) -> (f64, f64) {
    let floor = 1e-2 * mean(truth).0;
    let both: Vec<(f64, f64)> = blocks(difference)
        .iter()
        .zip(blocks(truth))
        .filter_map(|(d, t)| {
            let ((d, error), t) = (mean(d), mean(&t).0);
            (t > floor && error > 0.0).then(|| (d / t, d / error))
        })
        .collect();
    let rms =
        |value: &dyn Fn(&(f64, f64)) -> f64| (both.iter().map(|b| value(b).powi(2)).sum::<f64>() / both.len() as f64).sqrt();
    (rms(&|b| b.0), rms(&|b| b.1))
}

pub fn measure() -> Result<()> {
    let mut table = Table::new(&[
        "scene",
        "footprint / diagonal",
        "bias of the mean",
        "its standard error",
        "blocks rms",
        "blocks rms / noise",
        "rays to another triangle",
        "elsewhere",
        "queries a ray",
        "processor time / truth",
    ]);
    for (name, transport) in
        [("cornell_hole", "path"), ("cornell_hole", "hemisphere"), ("spheres_hole", "path"), ("gold_dragon", "path")]
    {
        let overrides =
            Overrides { resolution: Some(SIZE), spp: Some(SAMPLES), transport: Some(transport.to_owned()), ..Default::default() };
        let shown_name = format!("{name} {transport}");
        let mut built = crate::scene(name, &overrides)?;
        let diagonal = diagonal(&built.scene.world);
        let camera = built.scene.footprints.camera / FINER;
        let bounces = bounce_rays(&built, &camera_rays(&built, RAYS));
        let world = &built.scene.world;
        let (ends, _) = arrivals(world, &truth(world), &bounces);
        let mut with = |rough: f64| {
            built.scene.footprints = Footprints { camera, rough: rough * diagonal };
            picture(&built)
        };
        let truth = with(TRUTH);
        let pictures: Vec<(f64, Rendered)> = ROUGH.map(|rough| (rough, with(rough))).into();
        let percent = |share: f64| format!("{:.3} %", 100.0 * share);
        let queries = |c: &Counters| format!("{:.1}", c.queries as f64 / (c.geodesics + c.shadow_rays) as f64);
        let level = mean(&truth.luminance).0;
        for (rough, found) in &pictures {
            let difference: Vec<f64> = found.luminance.iter().zip(&truth.luminance).map(|(f, t)| f - t).collect();
            let (bias, error) = mean(&difference);
            let (blocks, noise) = block_differences(&difference, &truth.luminance);
            let integrator = Adaptive::new(Tolerance::Absolute(0.1 * rough * diagonal), 100_000);
            let world = &built.scene.world;
            let d = differences(world, &arrivals(world, &integrator, &bounces).0, &ends);
            table.row(&[
                shown_name.clone(),
                format!("{rough:.0e}"),
                percent(bias / level),
                percent(error / level),
                percent(blocks),
                format!("{noise:.2}"),
                percent(d.other_triangle),
                percent(d.elsewhere),
                queries(&found.counters),
                format!("{:.3}", found.seconds / truth.seconds),
            ]);
        }
        let none = ["", "", "", "", "", ""].map(str::to_owned);
        let [a, b, c, d, e, f] = none;
        let shown = format!("{TRUTH:.0e} (truth)");
        table.row(&[shown_name, shown, a, b, c, d, e, f, queries(&truth.counters), format!("{:.0} s", truth.seconds)]);
    }
    crate::finish(&table, "footprints")
}
