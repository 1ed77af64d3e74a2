//! In which order samples are made: waves, whose numbers do not depend on how many samples there are to be.

use bhs_core::sampling::Sampler;
use std::ops::Range;
use std::time::Duration;

/// Samples of the longest wave: short enough for progress and interruptions, long enough for coherent work.
const LONGEST_WAVE: u32 = 32;

/// Samples that a pixel has before it is asked whether it has enough, if nothing else is said.
pub const JUDGED_FROM: u32 = 16;

/// Number of a wave. Wave 0 is sample 0; each wave has as many samples as all before it, at most `LONGEST_WAVE`.
///
/// A total that ends within a wave cuts it short and does not end it: what transports learn from it counts once all of it is done, so that
/// going on with more samples gives the picture that as many samples would have given at once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct Wave(pub u32);

impl Wave {
    /// The wave that the sample belongs to.
    pub fn of(sample: u32) -> Self {
        match sample / LONGEST_WAVE {
            // 0, 1, 2..4, 4..8, ...
            0 => Self(u32::BITS - sample.leading_zeros()),
            steps => Self(LONGEST_WAVE.ilog2() + steps),
        }
    }

    /// The samples that belong to it.
    pub fn samples(self) -> Range<u32> {
        let doubling = LONGEST_WAVE.ilog2();
        match self.0 {
            0 => 0..1,
            w if w <= doubling => 1 << (w - 1)..1 << w,
            w => {
                let start = (w - doubling).saturating_mul(LONGEST_WAVE);
                start..start.saturating_add(LONGEST_WAVE)
            }
        }
    }

    /// The next one.
    pub fn next(self) -> Self {
        Self(self.0 + 1)
    }
}

/// When a render ends.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Samples a pixel at most.
    pub most: u32,
    /// Samples a pixel at least, whatever the time.
    pub least: u32,
    /// Samples that a pixel has at least before it is asked whether it has enough of them; they are as many for all.
    pub judged_from: u32,
    /// Time after which no more samples are begun.
    pub time: Option<Duration>,
}

impl Limits {
    /// All samples that the sampler is made for, however long it takes.
    pub fn of(sampler: &dyn Sampler) -> Self {
        Self { most: sampler.samples_per_pixel(), least: 1, judged_from: JUDGED_FROM, time: None }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_follow_one_another_and_know_their_samples() {
        let (mut wave, mut done) = (Wave::default(), 0);
        while done < 1000 {
            let samples = wave.samples();
            assert_eq!((samples.start, samples.len() as u32), (done, done.clamp(1, LONGEST_WAVE)));
            assert!(samples.clone().all(|s| Wave::of(s) == wave), "{samples:?}");
            (wave, done) = (wave.next(), samples.end);
        }
        let last = Wave::of(u32::MAX);
        assert!(last.samples().end >= 1_000_000_000);
    }
}
