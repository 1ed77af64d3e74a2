//! The bytes of a PLY file as a sliding window: the whole file where it is not compressed, a few hundred kilobytes of the
//! decompressed text where it is.

use flate2::bufread::MultiGzDecoder;
use std::borrow::Cow;
use std::io::{BufRead, Read};

/// Decompressed bytes asked for at a time: fits the second-level cache beside what is being built.
const BLOCK: usize = 1 << 18;

/// No line of a compressed file may be longer, in bytes, for it must fit the window: a polygon of a million corners does.
const LONGEST_LINE: usize = 1 << 24;

/// Deflate never gets more than this many bytes out of one (zlib's technical details, zlib.net).
const DEFLATE_RATIO: usize = 1032;

/// A file that is read from the front.
pub(crate) struct Input<'a> {
    window: Cow<'a, [u8]>,
    /// First byte of the window that has not been read.
    at: usize,
    /// Where more comes from; `None` at the end.
    more: Option<MultiGzDecoder<&'a [u8]>>,
    /// Bytes of the whole (decompressed) file, or a guess that no small file can make large.
    size: usize,
}

impl<'a> Input<'a> {
    /// The content of a file; decompressed on the way if it starts as gzip does.
    pub(crate) fn new(file: &'a [u8]) -> Self {
        if !file.starts_with(&[0x1f, 0x8b]) {
            return Self { window: Cow::Borrowed(file), at: 0, more: None, size: file.len() };
        }
        // A gzip file ends with its length modulo 2^32 (RFC 1952); a lie costs no more than the best compression would.
        let said = file.last_chunk().map_or(0, |b| u32::from_le_bytes(*b) as usize);
        let size = said.min(file.len().saturating_mul(DEFLATE_RATIO));
        Self { window: Cow::Owned(Vec::new()), at: 0, more: Some(MultiGzDecoder::new(file)), size }
    }

    /// Bytes that the file probably has, for reservations.
    pub(crate) fn size(&self) -> usize {
        self.size
    }

    /// What is in the window and not read yet.
    pub(crate) fn rest(&self) -> &[u8] {
        &self.window[self.at..]
    }

    /// Steps over `n` bytes of the window.
    pub(crate) fn consume(&mut self, n: usize) {
        self.at += n;
    }

    /// Brings at least `n` unread bytes into the window; `false` if the file ends before.
    #[inline]
    pub(crate) fn fill(&mut self, n: usize) -> Result<bool, String> {
        if self.window.len() - self.at >= n { Ok(true) } else { self.refill(n) }
    }

    #[cold]
    fn refill(&mut self, n: usize) -> Result<bool, String> {
        let Some(decoder) = &mut self.more else { return Ok(false) };
        let window = self.window.to_mut();
        window.drain(..self.at);
        self.at = 0;
        while window.len() < n {
            let got = decoder.by_ref().take(BLOCK as u64).read_to_end(window);
            if got.map_err(|e| format!("the gzip stream is damaged ({e})"))? == 0 {
                self.more = None;
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Steps over `n` bytes; `false` if the file ends before.
    pub(crate) fn skip(&mut self, mut n: u64) -> Result<bool, String> {
        while n > 0 {
            if !self.fill(1)? {
                return Ok(false);
            }
            let step = (self.rest().len() as u64).min(n);
            self.consume(step as usize);
            n -= step;
        }
        Ok(true)
    }

    /// The next line, as a range of [`Input::bytes`], without its end `eol`; `None` at the end of the file. Steps over it.
    pub(crate) fn line(&mut self, eol: u8) -> Result<Option<std::ops::Range<usize>>, String> {
        let mut searched = 0;
        loop {
            let mut rest = &self.rest()[searched..];
            // The standard library's fast search for a byte; slices cannot fail to be read.
            let passed = rest.skip_until(eol).unwrap_or(0);
            let next = self.at + searched + passed;
            if passed > 0 && self.window[next - 1] == eol {
                let line = self.at..next - 1;
                self.at = next;
                return Ok(Some(line));
            }
            searched = self.rest().len();
            if searched > LONGEST_LINE && self.more.is_some() {
                return Err(format!("a line has more than {LONGEST_LINE} bytes"));
            }
            if !self.fill(searched + 1)? {
                let line = self.at..self.at + searched;
                self.at = line.end;
                return Ok((searched > 0).then_some(line));
            }
        }
    }

    /// Bytes of the window by position, valid until the next call that reads.
    pub(crate) fn bytes(&self, range: std::ops::Range<usize>) -> &[u8] {
        &self.window[range]
    }
}
