//! Frames of an animation: which there are, what moves them ([`keys`]), and a small film of them ([`preview`]).

pub mod keys;
pub mod preview;

use std::fmt;

/// The largest number of a frame: names of files stay short.
pub const LAST_FRAME: u32 = 9_999_999;
/// Frames that one command renders: more than an hour at 24 a second.
pub const MOST_FRAMES: usize = 100_000;

/// The numbers of the frames to render: `first-last` or `first-last:step`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    first: u32,
    last: u32,
    step: u32,
}

impl FrameRange {
    /// Reads `A`, `A-B` or `A-B:STEP`.
    ///
    /// # Errors
    /// What is expected in its place.
    pub fn parse(text: &str) -> Result<Self, String> {
        let number = |text: &str| match text.trim().parse::<u32>() {
            Ok(n) if n <= LAST_FRAME => Ok(n),
            _ => Err(format!("expected frames from 0 to {LAST_FRAME}, such as 1-60 or 1-60:2, found `{text}`")),
        };
        let (range, step) = text.split_once(':').unwrap_or((text, "1"));
        let (first, last) = match range.split_once('-') {
            Some((first, last)) if !first.trim().is_empty() => (number(first)?, number(last)?),
            Some(_) => return Err("frames are numbered from 0, as names of files: begin with 0, and move the keys".to_owned()),
            None => (number(range)?, number(range)?),
        };
        let step = step.trim().parse::<u32>().ok().filter(|n| *n > 0).ok_or("the step is a whole number above 0")?;
        if last < first {
            return Err(format!("the first frame, {first}, comes after the last one, {last}"));
        }
        let range = Self { first, last, step };
        if range.count() > MOST_FRAMES {
            return Err(format!("these are {} frames; at most {MOST_FRAMES} are rendered at once", range.count()));
        }
        Ok(range)
    }

    /// The numbers, in order.
    pub fn numbers(self) -> impl Iterator<Item = u32> {
        (self.first..=self.last).step_by(self.step as usize)
    }

    /// How many there are: at least one.
    pub fn count(self) -> usize {
        ((self.last - self.first) / self.step) as usize + 1
    }

    /// The first one.
    pub fn first(self) -> u32 {
        self.first
    }

    /// From one to the next.
    pub fn step(self) -> u32 {
        self.step
    }
}

/// How the number of a frame stands in names of files: with four digits, or as many as it has.
pub fn digits(frame: u32) -> String {
    format!("{frame:04}")
}

/// Numbers of frames as people write them: `3, 5-9`.
pub struct Ranges<'a>(pub &'a [u32]);

impl fmt::Display for Ranges<'_> {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let mut separator = "";
        for run in self.0.chunk_by(|a, b| a + 1 == *b) {
            match run {
                [one] => write!(f, "{separator}{one}")?,
                [first, .., last] => write!(f, "{separator}{first}-{last}")?,
                [] => {}
            }
            separator = ", ";
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_are_read_and_refused() {
        let numbers = |text: &str| FrameRange::parse(text).map(|range| range.numbers().collect::<Vec<_>>());
        assert_eq!(numbers("3"), Ok(vec![3]));
        assert_eq!(numbers("0-2"), Ok(vec![0, 1, 2]));
        assert_eq!(numbers("1-8:3"), Ok(vec![1, 4, 7]));
        assert_eq!(numbers("9999999-9999999"), Ok(vec![LAST_FRAME]));
        assert_eq!(FrameRange::parse("1-9:3").map(FrameRange::count), Ok(3));
        for (text, why) in [
            ("", "expected frames"),
            ("a-b", "expected frames"),
            ("1-", "expected frames"),
            ("1.5-2", "expected frames"),
            ("-5-5", "numbered from 0"),
            ("1-10000000", "expected frames"),
            ("5-1", "comes after"),
            ("1-5:0", "the step"),
            ("1-5:x", "the step"),
            ("0-9999999", "at most"),
        ] {
            let found = numbers(text).expect_err(text);
            assert!(found.contains(why), "{text}: {found}");
        }
        assert_eq!((digits(7), digits(12345)), ("0007".to_owned(), "12345".to_owned()));
        assert_eq!(Ranges(&[1, 2, 3, 7, 9, 10]).to_string(), "1-3, 7, 9-10");
    }
}
