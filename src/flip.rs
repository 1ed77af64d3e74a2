//! FLIP: how much the difference of two pictures catches the eye of who flips between them.
//!
//! Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström and Fairchild 2020, "FLIP: A Difference Evaluator for Alternating Images" (LDR); Andersson, Nilsson,
//! Shirley and Akenine-Möller 2021, "Visualizing Errors in Rendered High Dynamic Range Images" (HDR: the greatest difference over exposures from where the
//! brightest point of the reference is white to where its median is). The numbers are those of the authors' program, `flip-evaluator`, with its defaults: a screen
//! of 3840 pixels and 0.7 m across, 0.7 m away, and the ACES curve; but that these exposures are `MOST_EXPOSURES` at most.

use bhs_elementary::Elementary;
use rayon::prelude::*;
use std::f32::consts::PI;

/// Pixels a degree of the eye's field.
const PIXELS_PER_DEGREE: f32 = 0.7 * (3840.0 / 0.7) * (PI / 180.0);

/// Exponents and the knee of the map from colour distances to differences: q_c, p_c, p_t; and q_f for features, of a width of w degrees.
const COLOUR_POWER: f32 = 0.7;
const KNEE: f32 = 0.4;
const KNEE_SHOWN: f32 = 0.95;
const FEATURE_POWER: f32 = 0.5;
const FEATURE_WIDTH: f32 = 0.082;

/// Linear sRGB to XYZ, as the authors have it.
const XYZ: [[f32; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];
/// Its inverse.
const RGB: [[f32; 3]; 3] =
    [[3.241_003_3, -1.537_399, -0.498_615_9], [-0.969_224_3, 1.875_93, 0.041_554_224], [0.055_639_42, -0.204_011_2, 1.057_149]];

/// Coefficients of Narkowicz' ACES curve with an exposure of 0.6: of x^2, x and 1 above and below.
const ACES: [f32; 6] = [0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.0, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14];

type Rgb = [f32; 3];

fn times(m: &[[f32; 3]; 3], v: Rgb) -> Rgb {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// XYZ of white.
fn white() -> Rgb {
    times(&XYZ, [1.0; 3])
}

/// The opponent space in which the eye's filters work: luminance, red and green, blue and yellow.
fn opponent(rgb: Rgb) -> Rgb {
    let (xyz, white) = (times(&XYZ, rgb), white());
    let [x, y, z] = std::array::from_fn(|k| xyz[k] / white[k]);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

fn from_opponent([l, c, z]: Rgb) -> Rgb {
    let y = (l + 16.0) / 116.0;
    let (xyz, white) = ([y + c / 500.0, y, y - z / 200.0], white());
    times(&RGB, std::array::from_fn(|k| xyz[k] * white[k]))
}

/// CIELAB, with less chroma where it is dark (Hunt).
fn lab(rgb: Rgb) -> Rgb {
    let (xyz, white) = (times(&XYZ, rgb), white());
    const DELTA: f32 = 6.0 / 29.0;
    let f = |t: f32| if t > DELTA * DELTA * DELTA { t.cube_root() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 };
    let [x, y, z] = std::array::from_fn(|k| f(xyz[k] / white[k]));
    let l = 116.0 * y - 16.0;
    [l, 0.01 * l * 500.0 * (x - y), 0.01 * l * 200.0 * (y - z)]
}

/// The distance HyAB of two colours: of lightness, and of the plane of chroma.
fn distance(a: Rgb, b: Rgb) -> f32 {
    (a[0] - b[0]).abs() + (a[1] - b[1]).hypotenuse(a[2] - b[2])
}

/// One number a pixel, row by row.
#[derive(Clone)]
struct Plane {
    size: [usize; 2],
    values: Vec<f32>,
}

impl Plane {
    /// Its convolution with a kernel of rows and one of columns of odd length; beyond its edges it goes on as they are.
    fn convolved(&self, across: &[f32], down: &[f32]) -> Self {
        let [width, height] = self.size;
        let radius = across.len() / 2;
        let mut rows = vec![0.0; self.values.len()];
        rows.par_chunks_exact_mut(width).zip(self.values.par_chunks_exact(width)).for_each(|(to, from)| {
            for (x, to) in to.iter_mut().enumerate() {
                *to = across.iter().enumerate().map(|(k, w)| w * from[(x + k).saturating_sub(radius).min(width - 1)]).sum();
            }
        });
        let radius = down.len() / 2;
        let mut values = vec![0.0; rows.len()];
        values.par_chunks_exact_mut(width).enumerate().for_each(|(y, to)| {
            for (k, w) in down.iter().enumerate() {
                let from = &rows[(y + k).saturating_sub(radius).min(height - 1) * width..][..width];
                to.iter_mut().zip(from).for_each(|(to, from)| *to += w * from);
            }
        });
        Self { size: self.size, values }
    }

    fn zip(self, other: &Self, f: impl Fn(f32, f32) -> f32 + Sync) -> Self {
        let mut values = self.values;
        values.par_iter_mut().zip(&other.values).for_each(|(a, b)| *a = f(*a, *b));
        Self { values, ..self }
    }
}

/// A picture as three planes.
struct Planes([Plane; 3]);

impl Planes {
    fn new(size: [usize; 2], pixels: &[Rgb], f: impl Fn(Rgb) -> Rgb + Sync) -> Self {
        let mapped: Vec<Rgb> = pixels.par_iter().map(|p| f(*p)).collect();
        Self(std::array::from_fn(|c| Plane { size, values: mapped.iter().map(|p| p[c]).collect() }))
    }
}

/// What the eye filters out of fine detail, of each of the opponent colours: sums of Gaussians `a sqrt(pi/b) exp(-pi^2 x^2/b)`.
fn filtered(Planes(planes): &Planes) -> Planes {
    const SENSITIVITY: [[[f32; 2]; 2]; 3] =
        [[[1.0, 0.0047], [0.0, 1e-5]], [[1.0, 0.0053], [0.0, 1e-5]], [[34.1, 0.04], [13.5, 0.025]]];
    // That of the widest one.
    let radius = (3.0 * (0.04 / (2.0 * PI * PI)).sqrt() * PIXELS_PER_DEGREE).ceil() as i32;
    Planes(std::array::from_fn(|c| {
        let mut sum: Option<Plane> = None;
        let kernels = SENSITIVITY[c].map(|[a, b]| {
            let kernel: Vec<f32> =
                (-radius..=radius).map(|x| (-(PI * x as f32 / PIXELS_PER_DEGREE).powi(2) / b).exponential()).collect();
            (a * (PI / b).sqrt(), kernel)
        });
        let total: f32 = kernels.iter().map(|(a, kernel)| a * kernel.iter().sum::<f32>().powi(2)).sum();
        for (a, kernel) in kernels.iter().filter(|(a, _)| *a > 0.0) {
            let down: Vec<f32> = kernel.iter().map(|w| w * a / total).collect();
            let part = planes[c].convolved(kernel, &down);
            sum = Some(match sum {
                Some(sum) => sum.zip(&part, |a, b| a + b),
                None => part,
            });
        }
        sum.unwrap_or_else(|| planes[c].clone())
    }))
}

/// How strongly edges and points stand out at each pixel of a picture of luminances.
fn features(luminance: &Plane) -> [Plane; 2] {
    let sigma = 0.5 * FEATURE_WIDTH * PIXELS_PER_DEGREE;
    let radius = (3.0 * sigma).ceil() as i32;
    let gauss: Vec<f32> = (-radius..=radius).map(|x| (-((x * x) as f32) / (2.0 * sigma * sigma)).exponential()).collect();
    let along = gauss.iter().sum::<f32>();
    let smooth: Vec<f32> = gauss.iter().map(|w| w / along).collect();
    // Weights above zero add up to 1, those below to -1.
    let balanced = |mut kernel: Vec<f32>| {
        let [above, below] = [1.0, -1.0].map(|sign| kernel.iter().map(|w| (sign * w).max(0.0)).sum::<f32>());
        kernel.iter_mut().for_each(|w| *w /= if *w < 0.0 { below } else { above });
        kernel
    };
    let steps = || (-radius..=radius).zip(&gauss);
    let edge = balanced(steps().map(|(x, w)| -(x as f32) * w).collect());
    let point = balanced(steps().map(|(x, w)| ((x * x) as f32 / (sigma * sigma) - 1.0) * w).collect());
    [edge, point].map(|kernel| {
        luminance.convolved(&kernel, &smooth).zip(&luminance.convolved(&smooth, &kernel), <f32 as Elementary>::hypotenuse)
    })
}

/// The difference of two pictures as they are on a screen, in linear sRGB from 0 to 1: a number from 0 to 1 a pixel.
pub fn ldr(size: [usize; 2], test: &[Rgb], reference: &[Rgb]) -> Vec<f32> {
    let [test, reference] = [test, reference].map(|pixels| Planes::new(size, pixels, opponent));
    let [[edges, points], [reference_edges, reference_points]] = [&test, &reference].map(|Planes([luminance, ..])| {
        let values = luminance.values.iter().map(|l| (l + 16.0) / 116.0).collect();
        features(&Plane { size, values })
    });
    let [test, reference] = [test, reference].map(|planes| filtered(&planes));
    let greatest = distance(lab([0.0, 1.0, 0.0]), lab([0.0, 0.0, 1.0])).power(COLOUR_POWER);
    let knee = KNEE * greatest;
    let at = |Planes(planes): &Planes, i: usize| {
        lab(from_opponent(std::array::from_fn(|c| planes[c].values[i])).map(|x| x.clamp(0.0, 1.0)))
    };
    (0..size[0] * size[1])
        .into_par_iter()
        .map(|i| {
            let powered = distance(at(&test, i), at(&reference, i)).power(COLOUR_POWER);
            let colour = match powered < knee {
                true => KNEE_SHOWN / knee * powered,
                false => KNEE_SHOWN + (powered - knee) / (greatest - knee) * (1.0 - KNEE_SHOWN),
            };
            let [edge, point] =
                [(&edges, &reference_edges), (&points, &reference_points)].map(|(a, b)| (a.values[i] - b.values[i]).abs());
            let feature = (edge.max(point) / 2f32.sqrt()).power(FEATURE_POWER).min(1.0);
            colour.power(1.0 - feature).clamp(0.0, 1.0)
        })
        .collect()
}

/// Most exposures. They lie a stop apart, and further only where the brightest point is more than 40 stops above the median: a picture with a lamp, most of
/// which is black.
const MOST_EXPOSURES: f32 = 40.0;

/// The exposures (stops) over which the greatest difference is sought.
fn exposures(reference: &[Rgb]) -> Vec<f32> {
    const SHOWN: f32 = 0.85;
    let [a, b, c] = std::array::from_fn(|k| ACES[k] - SHOWN * ACES[k + 3]);
    let middle = -0.5 * b / a;
    let x = middle + (middle * middle - c / a).sqrt();
    let mut luminances: Vec<f32> = reference.iter().map(|p| times(&XYZ, *p)[1]).collect();
    luminances.sort_unstable_by(f32::total_cmp);
    let n = luminances.len();
    let median = 0.5 * (luminances[(n - 1) / 2] + luminances[n / 2]);
    let [start, stop] = [luminances[n - 1], median].map(|y| (x / y.max(f32::EPSILON)).logarithm2());
    let count = (stop - start).ceil().clamp(2.0, MOST_EXPOSURES);
    (0..count as usize).map(|i| start + i as f32 * (stop - start) / (count - 1.0)).collect()
}

/// The difference of two pictures in linear sRGB of any brightness: a number from 0 to 1 a pixel. What is no number, or negative, counts as 0.
pub fn hdr(size: [usize; 2], test: &[Rgb], reference: &[Rgb]) -> Vec<f32> {
    let positive =
        |pixels: &[Rgb]| -> Vec<Rgb> { pixels.iter().map(|p| p.map(|x| if x > 0.0 { x.min(f32::MAX) } else { 0.0 })).collect() };
    let (test, reference) = (positive(test), positive(reference));
    let mut greatest = vec![0.0f32; test.len()];
    // Which takes no time; nor do pictures of no size.
    if test == reference {
        return greatest;
    }
    for stops in exposures(&reference) {
        let scale = stops.exponential2();
        let shown = |x: f32| {
            // As white as it gets, long before the squares are infinite.
            let x = (x * scale).min(1e6);
            let [a, b, c, d, e, f] = ACES;
            (((a * x + b) * x + c) / ((d * x + e) * x + f)).clamp(0.0, 1.0)
        };
        let [test, reference] = [&test, &reference].map(|pixels| pixels.par_iter().map(|p| p.map(shown)).collect::<Vec<_>>());
        greatest.iter_mut().zip(ldr(size, &test, &reference)).for_each(|(most, own)| *most = most.max(own));
    }
    greatest
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: [usize; 2] = [40, 28];

    /// A picture of waves and a pattern; with noise if `k` is not 0.
    fn picture(k: u32, hdr: bool) -> Vec<Rgb> {
        let pixel = |i: usize| -> Rgb {
            let (x, y) = ((i % SIZE[0]) as u64, (i / SIZE[0]) as u64);
            let noise = ((x * 7919 + y * 104_729 + u64::from(k) * 1_299_709) % 1009) as f64 / 1009.0;
            let pattern = ((x * 3 + y * 5) % 17) as f64 / 17.0;
            let (x, y, k) = (x as f64, y as f64, f64::from(k));
            let waves = [
                0.5 + 0.4 * (0.3 * x + 0.1 * k).sin() * (0.2 * y).cos(),
                0.5 + 0.4 * (0.25 * x - 0.15 * y + 0.2 * k).cos(),
                pattern,
            ];
            waves.map(|v| {
                let v = (if k > 0.0 { v * (0.8 + 0.4 * noise) } else { v }).clamp(0.0, 1.0);
                (if hdr { v.powi(4) * 20.0 } else { v }) as f32
            })
        };
        (0..SIZE[0] * SIZE[1]).map(pixel).collect()
    }

    /// Against the authors' program: flip-evaluator 1.7 from PyPI, `flip.evaluate(reference, test, "LDR" or "HDR", inputsRGB=False, applyMagma=False)`.
    #[test]
    fn differences_are_those_of_the_authors_program() {
        for (is_hdr, mean, some) in [
            (false, 0.536_273_36, [0.535_623_4, 0.651_143_5, 0.339_096_46, 0.264_594_32]),
            (true, 0.713_874_3, [0.701_603_4, 0.908_430_2, 0.545_897_36, 0.396_995_57]),
        ] {
            let (reference, test) = (picture(0, is_hdr), picture(3, is_hdr));
            let map = if is_hdr { hdr(SIZE, &test, &reference) } else { ldr(SIZE, &test, &reference) };
            let own = map.iter().map(|v| f64::from(*v)).sum::<f64>() / map.len() as f64;
            assert!((own - mean).abs() < 1e-4, "{own} {mean}");
            for ([x, y], expected) in [[0, 0], [7, 5], [20, 14], [39, 27]].into_iter().zip(some) {
                let own = map[y * SIZE[0] + x];
                assert!((own - expected).abs() < 1e-3, "{x} {y}: {own} {expected}");
            }
        }
    }

    #[test]
    fn equal_pictures_do_not_differ_and_nothing_odd_comes_out() {
        let pixels = picture(1, true);
        assert!(hdr(SIZE, &pixels, &pixels).iter().all(|v| *v == 0.0));
        // Of any range.
        let mut dark = vec![[0.0; 3]; pixels.len()];
        dark[7] = [f32::MAX; 3];
        assert_eq!(exposures(&dark).len(), MOST_EXPOSURES as usize);
        assert!((exposures(&pixels).len() as f32) < MOST_EXPOSURES);
        assert!(hdr(SIZE, &pixels, &dark).iter().all(|v| (0.0..=1.0).contains(v)));
        let odd: Vec<Rgb> =
            pixels.iter().enumerate().map(|(i, p)| if i % 3 == 0 { [f32::NAN, f32::INFINITY, -1.0] } else { *p }).collect();
        for (test, reference) in
            [(&odd, &pixels), (&pixels, &odd), (&vec![[0.0; 3]; pixels.len()], &pixels), (&pixels, &vec![[0.0; 3]; pixels.len()])]
        {
            assert!(hdr(SIZE, test, reference).iter().all(|v| (0.0..=1.0).contains(v)));
        }
        assert!(hdr([1, 1], &[[1.0; 3]], &[[0.5; 3]])[0] > 0.0 && hdr([0, 0], &[], &[]).is_empty());
    }
}
