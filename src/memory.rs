//! Memory that there is, and memory that a picture needs (`picture`).
//!
//! Both are known before anything is rendered or written, so that a picture that cannot be held is refused at once, and not in the
//! middle of the night.

pub mod picture;
mod system;

pub use system::{Available, available};

use std::collections::TryReserveError;
use std::fmt;

/// A number of bytes as people say it: `137 GB`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bytes(pub u64);

impl fmt::Display for Bytes {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        const UNITS: [&str; 6] = ["kB", "MB", "GB", "TB", "PB", "EB"];
        let (mut value, mut unit) = (self.0 as f64 / 1e3, 0);
        // What rounds to 1000 is one of the next unit.
        while value >= 999.5 && unit + 1 < UNITS.len() {
            value /= 1e3;
            unit += 1;
        }
        let digits = usize::from(value < 99.95) + usize::from(value < 9.995);
        write!(f, "{value:.digits$} {}", UNITS[unit])
    }
}

/// Memory that the system did not give.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is not enough memory for {what}, which takes {}", Bytes(*bytes))]
pub struct OutOfMemory {
    /// What it was for.
    what: &'static str,
    bytes: u64,
}

impl OutOfMemory {
    /// So many bytes for something.
    pub fn new(what: &'static str, bytes: u64) -> Self {
        Self { what, bytes }
    }
}

/// Makes sure that there are so many bytes for something, as far as the system tells.
///
/// # Errors
/// If there are not.
pub fn require(what: &'static str, bytes: u64) -> Result<(), OutOfMemory> {
    match available() {
        Some(available) if available.bytes < bytes => Err(OutOfMemory::new(what, bytes)),
        _ => Ok(()),
    }
}

/// Room for exactly `count` values, all of them `value`.
///
/// # Errors
/// If there is no such room.
pub fn filled<T: Clone>(count: usize, value: T) -> Result<Vec<T>, TryReserveError> {
    let mut all = Vec::new();
    all.try_reserve_exact(count)?;
    all.resize(count, value);
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_said_in_three_digits_and_a_unit() {
        let said = [0, 999, 1_000, 12_345, 999_499, 999_500, 137_438_953_472, 24_000_000_000_000, u64::MAX]
            .map(|b| Bytes(b).to_string());
        assert_eq!(said, ["0.00 kB", "1.00 kB", "1.00 kB", "12.3 kB", "999 kB", "1.00 MB", "137 GB", "24.0 TB", "18.4 EB"]);
    }

    #[test]
    fn room_that_there_is_not_is_an_error() {
        assert_eq!(filled(3, 1.5).as_deref(), Ok(&[1.5; 3][..]));
        assert!(filled(usize::MAX / 16, 0.0).is_err());
    }
}
