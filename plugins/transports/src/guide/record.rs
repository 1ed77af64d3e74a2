//! A guide as bytes and back, for renders that are broken off and resumed.
//!
//! Little-endian: the unit, exponents, number found and waves; the number of slots and the slots; the number of cells, and for each the
//! samples, the sums of the squares, and the sums of the warp that is in use. The warp is saved because it stems from the sums at the end
//! of the last wave, which have grown since. The grid follows from the scene.

use super::{Cell, Guide, SEEN, SQUARES, Warp};
use std::sync::atomic::Ordering::Relaxed;
use std::sync::atomic::{AtomicU32, AtomicU64};

/// Numbers of 32 bits of a warp.
const WARP: usize = 72;
/// Bytes of a cell.
const CELL: usize = 4 + 8 * SQUARES + 4 * WARP;

impl Guide {
    /// Everything that has been learned, as bytes.
    pub fn save(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(64 + 4 * self.slots.len() + CELL * self.cells.len());
        let mut put = |number: &[u8]| bytes.extend_from_slice(number);
        put(&self.units.to_le_bytes());
        put(&self.exponents.load(Relaxed).to_le_bytes());
        put(&self.found.load(Relaxed).to_le_bytes());
        put(&self.waves.to_le_bytes());
        put(&(self.slots.len() as u64).to_le_bytes());
        self.slots.iter().for_each(|slot| put(&slot.load(Relaxed).to_le_bytes()));
        put(&(self.cells.len() as u64).to_le_bytes());
        for (cell, warp) in self.cells.iter().zip(&self.warps) {
            put(&cell.samples.load(Relaxed).to_le_bytes());
            cell.sums.iter().for_each(|sum| put(&sum.load(Relaxed).to_le_bytes()));
            warp.sums().for_each(|sum| put(&sum.to_le_bytes()));
        }
        bytes
    }

    /// Takes over what [`Guide::save`] returned for the same scene; unchanged if that fails.
    ///
    /// # Errors
    /// If `saved` is not what a guide of this scene saves.
    pub fn restore(&mut self, saved: &[u8]) -> Result<(), String> {
        self.read(saved).ok_or_else(|| "what it says of the guide does not fit this scene".to_owned())
    }

    fn read(&mut self, saved: &[u8]) -> Option<()> {
        let mut bytes = Bytes(saved);
        let units = f64::from_le_bytes(bytes.take()?);
        let exponents = i64::from_le_bytes(bytes.take()?);
        let [found, waves] = [u32::from_le_bytes(bytes.take()?), u32::from_le_bytes(bytes.take()?)];
        if !(units.is_finite() && units >= 0.0 && u64::from_le_bytes(bytes.take()?) == self.slots.len() as u64) {
            return None;
        }
        let slots = bytes.numbers(self.slots.len())?;
        let count = u64::from_le_bytes(bytes.take()?);
        // The rest is cells, so that a false number asks for no memory.
        if bytes.0.len() as u64 != count.checked_mul(CELL as u64)? {
            return None;
        }
        // Every slot names a cell that there is.
        if slots.iter().any(|s| *s > SEEN && u64::from(*s - 2) >= count) {
            return None;
        }
        let (mut cells, mut warps) = (Vec::with_capacity(count as usize), Vec::with_capacity(count as usize));
        for _ in 0..count {
            let samples = AtomicU32::new(u32::from_le_bytes(bytes.take()?));
            let mut sums = [0; SQUARES];
            for sum in &mut sums {
                *sum = u64::from_le_bytes(bytes.take()?);
            }
            cells.push(Cell { sums: sums.map(AtomicU64::new), samples });
            warps.push(Warp::from_sums(|| bytes.take().map(f32::from_le_bytes))?);
        }
        (self.units, self.waves) = (units, waves);
        (self.exponents, self.found) = (exponents.into(), found.into());
        self.slots = slots.into_iter().map(AtomicU32::new).collect();
        (self.cells, self.warps) = (cells, warps);
        Some(())
    }
}

/// Bytes that have not been read yet.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*first)
    }

    fn numbers(&mut self, count: usize) -> Option<Vec<u32>> {
        let (numbers, rest) = self.0.split_at_checked(count.checked_mul(4)?)?;
        self.0 = rest;
        Some(numbers.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect())
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::{guide, trained};

    #[test]
    fn what_is_saved_is_restored_to_the_bit() {
        for waves in [0, 1, 4] {
            let saved = trained(1, waves).save();
            let mut restored = guide();
            restored.restore(&saved).expect("it fits");
            assert_eq!(restored.save(), saved, "{waves} waves");
        }
    }

    #[test]
    fn nothing_that_is_damaged_is_restored() {
        let saved = trained(1, 4).save();
        for length in (0..saved.len()).step_by(97) {
            assert!(guide().restore(&saved[..length]).is_err(), "{length} bytes");
        }
        let last = saved.len() - 1;
        // A slot without a cell, a number of slots, a sum of the warp.
        for (at, byte) in [(32, 0xff), (24, 1), (last, 0x7f)] {
            let mut damaged = saved.clone();
            damaged[at] = byte;
            damaged[at + usize::from(at != last)] = 0xff;
            assert!(guide().restore(&damaged).is_err(), "{at}");
        }
    }
}
