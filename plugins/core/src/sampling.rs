//! Random numbers as a pure function of (seed, pixel, sample, dimension), and the usual maps from the unit square.

use bhs_elementary::Elementary;
use glam::{Vec2, Vec3};
use std::f32::consts::{FRAC_PI_4, PI};

/// Numbers that a sampler gives at a time, well distributed together.
pub const SET: usize = 4;

/// A source of numbers in [0,1), without state: the same arguments give the same numbers, on any thread, in any order.
pub trait Sampler: Send + Sync {
    /// Set number `set` of sample `index` of the pixel: [`SET`] numbers that are well distributed together over the pixel's
    /// samples, and independent of those of other sets and pixels.
    fn numbers(&self, pixel: [u32; 2], index: u32, set: u32) -> [f32; SET];

    /// The number in [0,1) from which the wavelengths of sample `index` of the pixel are made
    /// ([`VisibleWavelengths::sample`](crate::spectrum::VisibleWavelengths::sample)). A sample has wavelengths a quarter apart: a sampler that spreads
    /// its numbers spreads these over the samples of a pixel and over neighbouring pixels, and their remainders of a quarter as well.
    fn wavelengths(&self, pixel: [u32; 2], index: u32) -> f32 {
        self.numbers(pixel, index, WAVELENGTHS)[0]
    }

    /// Samples a pixel that the scene asks for.
    fn samples_per_pixel(&self) -> u32;

    /// The noise with which a pixel has samples enough, if pixels need not all have as many.
    fn noise_target(&self) -> Option<NoiseTarget> {
        None
    }

    /// Whether the numbers of a sample depend on how many samples a pixel has in all: a render with such a sampler cannot go on to more
    /// samples than it was begun with.
    fn depends_on_count(&self) -> bool {
        false
    }
}

/// Samples that a pixel may have at most; where they are to be so many, nothing but the noise ends them.
pub const MOST_SAMPLES: u32 = 1_000_000_000;

/// The noise with which a pixel has samples enough: adaptive sampling leaves it alone then.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NoiseTarget {
    /// Standard error of the pixel's luminance, in the measure below.
    pub noise: f64,
    /// What it is measured in.
    pub measure: NoiseMeasure,
    /// What has to be below it.
    pub over: NoiseOver,
}

impl NoiseTarget {
    /// What is expected of a noise, in words.
    pub const EXPECTED: &str = "expected a number above 0 and up to 1, such as 0.01";

    /// Whether that much noise can be asked for.
    pub fn takes(noise: f64) -> bool {
        noise > 0.0 && noise <= 1.0
    }
}

/// What a target of noise holds for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseOver {
    /// Each pixel: the hardest ones take most of the samples.
    Pixel,
    /// The picture: the root of the mean square of its pixels' noise. Samples go where they lower that most, and far fewer of them do.
    Picture,
}

impl NoiseOver {
    /// What is expected of its name, in words.
    pub const EXPECTED: &str = "expected `pixel` or `picture`";

    /// What scenes and the command line call it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pixel => "pixel",
            Self::Picture => "picture",
        }
    }

    /// The one of that name.
    pub fn find(name: &str) -> Option<Self> {
        [Self::Pixel, Self::Picture].into_iter().find(|over| over.name() == name)
    }
}

/// What the standard error of a pixel's luminance is measured in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoiseMeasure {
    /// Its luminance, or 2 % of the picture's mean where it is darker.
    Relative,
    /// What a screen shows of it, where white is 1: noise of what is shown white, or black, does not count.
    Shown,
}

/// A set of numbers that no path comes to.
const WAVELENGTHS: u32 = u32::MAX;

/// More sets of numbers than one sample needs.
const SETS_OF_A_WAVE: u32 = 1 << 20;

/// The numbers of one sample of one pixel, in the order in which they are asked for.
#[derive(Clone)]
pub struct SampleStream<'a> {
    sampler: &'a dyn Sampler,
    pixel: [u32; 2],
    index: u32,
    next_set: u32,
    numbers: [f32; SET],
    used: usize,
}

impl<'a> SampleStream<'a> {
    /// The stream of sample `index` of `pixel`, from its first number.
    pub fn new(sampler: &'a dyn Sampler, pixel: [u32; 2], index: u32) -> Self {
        Self { sampler, pixel, index, next_set: 0, numbers: [0.0; SET], used: SET }
    }

    /// The same from other sets of numbers: those of different `wave` are independent of each other.
    pub fn of_wave(sampler: &'a dyn Sampler, pixel: [u32; 2], index: u32, wave: u32) -> Self {
        Self { next_set: wave.wrapping_mul(SETS_OF_A_WAVE), ..Self::new(sampler, pixel, index) }
    }

    /// The number from which the sample's wavelengths are made: [`Sampler::wavelengths`].
    #[inline]
    pub fn wavelengths(&self) -> f32 {
        self.sampler.wavelengths(self.pixel, self.index)
    }

    /// The next number.
    #[inline]
    pub fn next_1d(&mut self) -> f32 {
        self.reserve(1);
        self.used += 1;
        self.numbers[self.used - 1]
    }

    /// The next two numbers, well distributed together.
    #[inline]
    pub fn next_2d(&mut self) -> Vec2 {
        self.reserve(2);
        self.used += 2;
        Vec2::new(self.numbers[self.used - 2], self.numbers[self.used - 1])
    }

    /// Begins a new set unless `count` numbers of the current one are left.
    fn reserve(&mut self, count: usize) {
        if self.used + count > SET {
            self.numbers = self.sampler.numbers(self.pixel, self.index, self.next_set);
            self.next_set += 1;
            self.used = 0;
        }
    }
}

/// The largest number below one.
pub const ONE_MINUS_EPSILON: f32 = 1.0 - f32::EPSILON / 2.0;

/// A well mixed 64-bit hash of a 64-bit number (the finaliser of SplitMix64; Steele, Lea and Flood 2014).
#[inline]
pub fn mix64(mut z: u64) -> u64 {
    z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The top 24 bits of `bits` as a number in [0,1).
#[inline]
pub fn unit_f32(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// Cosine and sine of an angle of at most an eighth of a turn either way (rad), by their power series.
#[inline]
fn cos_sin_eighth(x: f32) -> (f32, f32) {
    let xx = x * x;
    let cos = 1.0 + xx * (-1.0 / 2.0 + xx * (1.0 / 24.0 + xx * (-1.0 / 720.0 + xx * (1.0 / 40320.0))));
    let sin = x * (1.0 + xx * (-1.0 / 6.0 + xx * (1.0 / 120.0 + xx * (-1.0 / 5040.0 + xx * (1.0 / 362_880.0)))));
    (cos, sin)
}

/// The angle of at most an eighth of a turn either way (rad) whose tangent is `x`: Hastings's polynomial, to 4e-8 (Abramowitz and Stegun
/// 1964, 4.4.49).
#[inline]
fn atan_eighth(x: f32) -> f32 {
    const A: [f32; 8] =
        [-0.333_331_45, 0.199_935_5, -0.142_089, 0.106_562_64, -0.075_289_64, 0.042_909_615, -0.016_165_737, 0.002_866_225_7];
    let xx = x * x;
    x * (1.0 + xx * A.iter().rev().fold(0.0, |sum, a| sum * xx + a))
}

/// Point number `i` of the sequence R2 (Roberts 2018), in the unit square: however many there are, they lie evenly.
#[inline]
pub fn r2_point(i: u64) -> [f64; 2] {
    [0.754_877_666_246_692_7, 0.569_840_290_998_053_2].map(|step| (0.5 + i as f64 * step).fract())
}

/// A point of the unit disk, uniform, by the concentric map (Shirley and Chiu 1997).
#[inline]
pub fn concentric_disk(u: Vec2) -> Vec2 {
    let o = 2.0 * u - 1.0;
    if o == Vec2::ZERO {
        return Vec2::ZERO;
    }
    if o.x.abs() > o.y.abs() {
        let (cos, sin) = cos_sin_eighth(FRAC_PI_4 * (o.y / o.x));
        o.x * Vec2::new(cos, sin)
    } else {
        let (cos, sin) = cos_sin_eighth(FRAC_PI_4 * (o.x / o.y));
        o.y * Vec2::new(sin, cos)
    }
}

/// The point of the unit square that [`concentric_disk`] maps to `d`, a point of the unit disk.
#[inline]
pub fn concentric_square(d: Vec2) -> Vec2 {
    let r = d.length();
    let o = if d.x.abs() > d.y.abs() {
        let x = r.copysign(d.x);
        Vec2::new(x, x * (atan_eighth(d.y / d.x) / FRAC_PI_4))
    } else if d.y != 0.0 {
        let y = r.copysign(d.y);
        Vec2::new(y * (atan_eighth(d.x / d.y) / FRAC_PI_4), y)
    } else {
        Vec2::ZERO
    };
    (0.5 * o + 0.5).clamp(Vec2::ZERO, Vec2::splat(ONE_MINUS_EPSILON))
}

/// A direction of the hemisphere z > 0 with density cos(theta)/pi.
#[inline]
pub fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let d = concentric_disk(u);
    d.extend((1.0 - d.length_squared()).max(0.0).sqrt())
}

/// A direction of the hemisphere z >= 0 with density 1/(2 pi).
#[inline]
pub fn uniform_hemisphere(u: Vec2) -> Vec3 {
    let z = u.x;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (2.0 * PI * u.y).sine_cosine();
    Vec3::new(r * cos, r * sin, z)
}

/// Barycentric coordinates (of the second and third vertex) of a point of a triangle, uniform by area (Heitz 2019).
#[inline]
pub fn uniform_triangle(u: Vec2) -> Vec2 {
    if u.x < u.y {
        let b0 = u.x / 2.0;
        Vec2::new(b0, u.y - b0)
    } else {
        let b1 = u.y / 2.0;
        Vec2::new(u.x - b1, b1)
    }
}

/// The balance heuristic's weight of a sample drawn with density `f` where the other technique has density `g`.
#[inline]
pub fn balance_heuristic(f: f32, g: f32) -> f32 {
    if f.is_infinite() { 1.0 } else { f / (f + g) }
}

/// A discrete distribution over indices, sampled by bisection of its cumulative sum.
#[derive(Clone, Debug, Default)]
pub struct Discrete {
    cumulative: Vec<f64>,
}

impl Discrete {
    /// A distribution proportional to `weights`, which are finite and not negative.
    pub fn new(weights: impl IntoIterator<Item = f64>) -> Self {
        let mut sum = 0.0;
        let cumulative = weights
            .into_iter()
            .map(|w| {
                sum += w;
                sum
            })
            .collect();
        Self { cumulative }
    }

    /// The sum of the weights.
    #[inline]
    pub fn total(&self) -> f64 {
        self.cumulative.last().copied().unwrap_or(0.0)
    }

    /// Probability of index `i`.
    #[inline]
    pub fn probability(&self, i: usize) -> f64 {
        let before = if i == 0 { 0.0 } else { self.cumulative[i - 1] };
        (self.cumulative[i] - before) / self.total()
    }

    /// Draws an index and rescales `u` in [0,1) to a fresh number in [0,1). `None` if all weights are zero.
    #[inline]
    pub fn sample(&self, u: f32) -> Option<(usize, f32)> {
        let total = self.total();
        if total <= 0.0 {
            return None;
        }
        let x = f64::from(u) * total;
        let i = self.cumulative.partition_point(|c| *c <= x).min(self.cumulative.len() - 1);
        let before = if i == 0 { 0.0 } else { self.cumulative[i - 1] };
        let rest = ((x - before) / (self.cumulative[i] - before)) as f32;
        Some((i, rest.clamp(0.0, ONE_MINUS_EPSILON)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_the_sequence_lie_evenly() {
        // So many lie in each of 64 squares as belong there, within one or two.
        let mut counts = [0_i32; 64];
        for [x, y] in (0..1024).map(r2_point) {
            counts[(8.0 * x) as usize * 8 + (8.0 * y) as usize] += 1;
        }
        assert!(counts.iter().all(|count| (count - 16).abs() <= 3), "{counts:?}");
    }

    #[test]
    fn the_concentric_map_has_an_inverse() {
        for i in 0..=100 {
            for j in 0..=100 {
                let u = Vec2::new(i as f32, j as f32) / 100.0;
                let back = concentric_square(concentric_disk(u));
                assert!((back - u).abs().max_element() < 1e-6, "{u} {back}");
            }
        }
        assert_eq!(concentric_square(Vec2::ZERO), Vec2::splat(0.5));
    }
}
