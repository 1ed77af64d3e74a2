//! What adaptive sampling knows of pixels: how noisy each is, by what its own samples say.
//!
//! Samples that are spread over a pixel have less noise together than alone, and more so the more there are. So their variance says little. Means of
//! batches of consecutive samples are taken in its place, of which there are two or three, whose length doubles with the number of samples: each batch is
//! spread over the pixel as all of them are ("batch means"; Law and Kelton 2000, section 9.5.3). So few say little of one pixel; whoever asks takes many together.

/// Samples of a batch at first.
const SHORTEST: u32 = 4;
/// Of so many batches two become one each.
const BATCHES: usize = 4;

/// What is known of the luminance of a pixel. Samples are added in the order of their numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelNoise {
    /// Samples that it has, those that were not finite included.
    pub samples: u32,
    /// Whether it takes part in the wave under way.
    pub under_way: bool,
    /// Batches that are whole, and the samples of each.
    whole: u32,
    length: u32,
    /// Weighted sum and weight of each batch, of which the one after the whole ones is under way.
    batches: [[f64; 2]; BATCHES],
}

impl PixelNoise {
    /// Memory that it takes in a file (bytes).
    pub const BYTES: usize = 4 * 4 + 2 * BATCHES * 8;

    /// A pixel without samples, that takes part in the first wave.
    pub fn beginning() -> Self {
        Self { samples: 0, under_way: true, whole: 0, length: SHORTEST, batches: [[0.0; 2]; BATCHES] }
    }

    /// Adds the next sample: its luminance times its weight, and its weight; nothing of one that was not finite.
    pub fn add(&mut self, sample: Option<[f64; 2]>) {
        if let Some(sample) = sample {
            let batch = &mut self.batches[self.whole as usize];
            *batch = [batch[0] + sample[0], batch[1] + sample[1]];
        }
        self.samples += 1;
        self.whole += u32::from(self.samples.is_multiple_of(self.length));
        if self.whole as usize == BATCHES {
            let pair = |i: usize| std::array::from_fn(|k| self.batches[2 * i][k] + self.batches[2 * i + 1][k]);
            self.batches = std::array::from_fn(|i| if i < BATCHES / 2 { pair(i) } else { [0.0; 2] });
            self.whole /= 2;
            self.length *= 2;
        }
    }

    /// Luminance, and the variance of one sample as it shows in the mean of so many; `None` with less than two batches that have a weight.
    ///
    /// The batch under way counts as far as it is, or a pixel would be left alone right after a sample that stands out: the sum over all batches of their
    /// samples times the squared difference of their mean from that of all, over the number of batches less one, as in an analysis of variance.
    pub fn estimate(&self) -> Option<[f64; 2]> {
        let last = self.samples - self.whole * self.length;
        let lengths = (0..=self.whole).map(|i| f64::from(if i < self.whole { self.length } else { last }));
        let batches =
            || lengths.clone().zip(&self.batches).filter(|(_, batch)| batch[1] > 0.0).map(|(n, [sum, weight])| (n, sum / weight));
        let count = batches().count() as f64;
        let samples: f64 = batches().map(|(n, _)| n).sum();
        let mean = batches().map(|(n, mean)| n * mean).sum::<f64>() / samples;
        let squares: f64 = batches().map(|(n, own)| n * (own - mean) * (own - mean)).sum();
        (count >= 2.0).then(|| [mean, squares / (count - 1.0)])
    }

    /// As bytes (little-endian).
    pub fn write_to(&self, bytes: &mut Vec<u8>) {
        let counts = [self.samples, u32::from(self.under_way), self.whole, self.length];
        counts.iter().for_each(|n| bytes.extend_from_slice(&n.to_le_bytes()));
        self.batches.as_flattened().iter().for_each(|x| bytes.extend_from_slice(&x.to_le_bytes()));
    }

    /// What [`PixelNoise::write_to`] has written; `None` if `bytes` are not that.
    pub fn read(bytes: &[u8; Self::BYTES]) -> Option<Self> {
        let (counts, numbers) = bytes.split_first_chunk::<16>()?;
        let [samples, under_way, whole, length] =
            [0, 4, 8, 12].map(|i| u32::from_le_bytes([counts[i], counts[i + 1], counts[i + 2], counts[i + 3]]));
        let mut batches = [[0.0; 2]; BATCHES];
        for (to, from) in batches.as_flattened_mut().iter_mut().zip(numbers.as_chunks::<8>().0) {
            *to = f64::from_le_bytes(*from);
        }
        let is_length = length.is_power_of_two() && length >= SHORTEST;
        let are_counted = is_length && (whole as usize) < BATCHES && samples / length == whole && under_way <= 1;
        let is_one = are_counted && batches.as_flattened().iter().all(|x| x.is_finite());
        is_one.then_some(Self { samples, under_way: under_way == 1, whole, length, batches })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bhs_core::sampling::{mix64, unit_f32};

    #[test]
    fn it_knows_mean_and_variance_whatever_the_number_of_samples() {
        // Uniform numbers: mean 1/2, variance 1/12. Many pixels together, as each has two batches or three.
        for count in [16, 32, 40, 96, 160, 1000] {
            let pixels = 4000;
            let (mut mean, mut variance) = (0.0, 0.0);
            for i in 0..pixels {
                let mut pixel = PixelNoise::beginning();
                for k in 0..count {
                    let x = f64::from(unit_f32((mix64(mix64(i) ^ u64::from(k)) >> 32) as u32));
                    pixel.add(Some([2.0 * x, 2.0]));
                }
                assert!((2..=3).contains(&pixel.whole) && pixel.samples == count);
                let [own, of_one] = pixel.estimate().expect("there are two batches");
                (mean, variance) = (mean + own / pixels as f64, variance + of_one / pixels as f64);
            }
            assert!((mean - 0.5).abs() < 0.005 && (12.0 * variance - 1.0).abs() < 0.1, "{count}: {mean} {variance}");
        }
    }

    #[test]
    fn what_all_batches_share_is_no_noise_and_files_hold_it() {
        let mut pixel = PixelNoise::beginning();
        assert_eq!(pixel.estimate(), None);
        for k in 0..77 {
            // As in samples that are spread over a pixel, each four have all of it.
            pixel.add(Some([f64::from(k % 4), 1.0]));
            let mut bytes = Vec::new();
            pixel.write_to(&mut bytes);
            let bytes: [u8; PixelNoise::BYTES] = bytes.try_into().expect("as long as it says");
            assert_eq!(PixelNoise::read(&bytes), Some(pixel));
        }
        // All but the last of them, which is 0.
        let [mean, variance] = pixel.estimate().expect("there are two batches");
        assert!((mean - 1.5).abs() < 0.03 && variance < 1.2, "{mean} {variance}");
        pixel.add(Some([1000.0, 1.0]));
        assert!(pixel.estimate().is_some_and(|[_, variance]| variance > 1e4), "what stands out is seen at once");
        assert_eq!(PixelNoise::read(&[0xff; PixelNoise::BYTES]), None);
        assert_eq!(PixelNoise::read(&[0; PixelNoise::BYTES]), None);
    }

    #[test]
    fn samples_without_a_value_count_and_bring_nothing() {
        let mut pixel = PixelNoise::beginning();
        (0..40).for_each(|_| pixel.add(None));
        assert_eq!((pixel.samples, pixel.estimate()), (40, None));
    }
}
