//! Which part of a picture is rendered: what the command line asks for.

use super::Cover;
use bhs_core::camera::Film;
use clap::Args;

/// Which part of a picture is rendered, if not all of it.
#[derive(Args, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PartArgs {
    /// Render these samples alone, of those of --spp, counted from 0, B excluded: the output is a part, NAME.bhspart, of the window of --crop,
    /// which `bhs merge` joins with the others
    #[arg(long, value_name = "A..B", value_parser = samples, conflicts_with = "part")]
    pub samples: Option<[u32; 2]>,
    /// Render part K of N, counted from 1, with which samples and which window is chosen: the output is a part, NAME.bhspart
    #[arg(long, value_name = "K/N", value_parser = part)]
    pub part: Option<[u32; 2]>,
}

/// Parts that a picture is divided into at most.
const MOST_PARTS: u32 = 1_000_000;

fn samples(text: &str) -> Result<[u32; 2], String> {
    match text.split_once("..").map(|(from, to)| (from.trim().parse(), to.trim().parse())) {
        Some((Ok(from), Ok(to))) if from < to => Ok([from, to]),
        Some((Ok(_), Ok(_))) => Err("they hold no sample: the second number, which is excluded, is above the first".to_owned()),
        _ => Err("expected the first sample and the one after the last, counted from 0, such as 0..16".to_owned()),
    }
}

fn part(text: &str) -> Result<[u32; 2], String> {
    match text.split_once('/').map(|(k, n)| (k.trim().parse(), n.trim().parse())) {
        Some((Ok(k), Ok(n))) if (1..=n).contains(&k) && n <= MOST_PARTS => Ok([k, n]),
        Some((Ok::<u32, _>(_), Ok::<u32, _>(n))) if n > MOST_PARTS => Err(format!("at most {MOST_PARTS} parts can be merged")),
        _ => Err("expected the number of the part, counted from 1, and how many there are, such as 3/8".to_owned()),
    }
}

impl PartArgs {
    /// Whether it is a part.
    pub fn is_given(&self) -> bool {
        self.samples.is_some() || self.part.is_some()
    }

    /// What the name of the part has that nobody names.
    pub fn label(&self, crop: Option<[f64; 4]>) -> Option<String> {
        let label = match (self.samples, self.part) {
            (Some([from, to]), _) => format!("samples-{from}-{to}"),
            (None, Some([k, n])) => {
                let digits = n.to_string().len();
                format!("part-{k:0digits$}-of-{n}")
            }
            (None, None) => return None,
        };
        // Other windows have other files.
        let window = crop.map(|[x0, x1, y0, y1]| format!("-crop-{x0}-{x1}-{y0}-{y1}"));
        Some(label + &window.unwrap_or_default())
    }

    /// What is rendered of a film with `total` samples a pixel, in the window that `crop` gives as fractions of its size; `None`: all of it.
    ///
    /// # Errors
    /// If that is nothing, or not in the picture.
    pub fn cover(&self, film: &dyn Film, total: u32, crop: Option<[f64; 4]>) -> Result<Option<Cover>, String> {
        if !self.is_given() {
            return Ok(None);
        }
        let window = Cover { window: window(film, crop), samples: [0, total] };
        let whole = Cover::whole(film, total);
        let window = (window.window[0] < window.window[1] && window.window[2] < window.window[3]).then_some(window);
        let window = window.and_then(|w| w.common(&whole)).ok_or("the window of --crop holds no pixel of the picture")?;
        if let Some([from, to]) = self.samples {
            if to > total {
                return Err(format!(
                    "--samples {from}..{to} goes beyond the {total} samples a pixel that the picture has; --spp says how many these are in all"
                ));
            }
            return Ok(Some(Cover { samples: [from, to], ..window }));
        }
        let [k, n] = self.part.unwrap_or([1, 1]);
        if u64::from(n) > window.size() {
            return Err(format!("--part divides {} samples into {n} parts: some would hold none", window.size()));
        }
        Ok(Some(share(window, k - 1, n)))
    }
}

/// The window of a film that fractions of its size give, as its `cropwindow` does.
fn window(film: &dyn Film, crop: Option<[f64; 4]>) -> [u32; 4] {
    let Some([x0, x1, y0, y1]) = crop else { return film.crop() };
    let [width, height] = film.resolution();
    let at = |f: f64, n: u32| (f * f64::from(n)).ceil() as u32;
    [at(x0, width), at(x1, width), at(y0, height), at(y1, height)]
}

/// Where piece `k` of `n` pieces of a range begins, and ends, as even as can be.
fn piece([from, to]: [u32; 2], k: u32, n: u32) -> [u32; 2] {
    let at = |k: u32| from + (u64::from(to - from) * u64::from(k) / u64::from(n)) as u32;
    [at(k), at(k + 1)]
}

/// Ranges of samples that a picture is divided into at most, if nobody names them: each has sums of all pixels, which are to be moved and joined.
const MOST_RANGES: u32 = 64;

/// Share `k` of `n`: of the samples, which are alike, and of the pixels only where there are more shares than samples, or than [`MOST_RANGES`]. All
/// shares together are the whole, and no two of them have a sample in common.
fn share(whole: Cover, k: u32, n: u32) -> Cover {
    let [from, to] = whole.samples;
    // Every share has a pixel at least.
    let pixels = (whole.size() / u64::from(to - from)).min(u64::from(u32::MAX)) as u32;
    let count = n.div_ceil(n.div_ceil(MOST_RANGES)).max(n.div_ceil(pixels)).min(to - from);
    if n == count {
        return Cover { samples: piece(whole.samples, k, n), ..whole };
    }
    // Which range of samples it is of, and which of the shares of that range.
    let range = (u64::from(k) * u64::from(count) / u64::from(n)) as u32;
    let first = |range: u32| (u64::from(range) * u64::from(n)).div_ceil(u64::from(count)) as u32;
    let samples = piece(whole.samples, range, count);
    let (k, n) = (k - first(range), first(range + 1) - first(range));
    let [x0, x1, y0, y1] = whole.window;
    let rows = (y1 - y0).min(n);
    // Rows of pixels, or pieces of them.
    let row = (u64::from(k) * u64::from(rows) / u64::from(n)) as u32;
    let first = |row: u32| (u64::from(row) * u64::from(n)).div_ceil(u64::from(rows)) as u32;
    let [y0, y1] = piece([y0, y1], row, rows);
    let [x0, x1] = piece([x0, x1], k - first(row), first(row + 1) - first(row));
    Cover { window: [x0, x1, y0, y1], samples }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_the_whole_and_have_nothing_in_common() {
        for (window, samples) in
            [([0, 7, 0, 5], 8), ([3, 40, 2, 9], 1), ([0, 3, 0, 1], 5), ([1, 2, 1, 4], 64), ([1, 2, 1, 4], 200)]
        {
            let whole = Cover { window, samples: [0, samples] };
            for n in (1..=whole.size().min(300) as u32).chain([whole.size() as u32]) {
                let shares: Vec<Cover> = (0..n).map(|k| share(whole, k, n)).collect();
                assert_eq!(shares.iter().map(Cover::size).sum::<u64>(), whole.size(), "{whole} {n}");
                assert!(whole.missing(shares.iter()).is_empty(), "{whole} {n}");
                assert!(shares.iter().all(|s| s.size() > 0), "{whole} {n}");
                let most = shares.iter().map(Cover::size).max();
                assert!(most <= Some(5 * whole.size().div_ceil(u64::from(n))), "{whole} {n}: {most:?}");
            }
        }
    }

    #[test]
    fn what_is_no_part_is_refused() {
        assert_eq!((samples("0..16"), samples(" 3 .. 4 ")), (Ok([0, 16]), Ok([3, 4])));
        assert!(["4..4", "5..4", "1-4", "..4", "-1..4", "0..x"].iter().all(|t| samples(t).is_err()));
        assert_eq!((part("1/1"), part("3/8")), (Ok([1, 1]), Ok([3, 8])));
        assert!(["0/8", "9/8", "1", "1/0", "-1/3", "1/9999999", "a/b"].iter().all(|t| part(t).is_err()));
    }
}
