//! The values after the header of a PLY file, one by one: as text, or as little- or big-endian bytes.

use crate::ply_header::Type;
use crate::ply_input::Input;

/// What is said where the file stops too early.
const ENDS: &str = "the file ends here, before what its header announces";

/// The values of element after element. Every element starts with [`Values::begin`] and ends with [`Values::end`].
pub(crate) trait Values {
    fn begin(&mut self) -> Result<(), String>;
    /// The next number.
    fn number(&mut self, ty: Type) -> Result<f64, String>;
    /// The next number, of an integer type.
    fn integer(&mut self, ty: Type) -> Result<i64, String>;
    /// Steps over `n` numbers.
    fn skip(&mut self, ty: Type, n: u64) -> Result<(), String>;
    fn end(&mut self) -> Result<(), String>;
    /// The line that is being read, if there are lines; from 1.
    fn line(&self) -> Option<u64>;
    /// Whether anything but blanks is left after the last element.
    fn goes_on(&mut self) -> Result<bool, String>;
}

/// Bytes, big-endian if `BIG`.
pub(crate) struct Binary<'i, 'a, const BIG: bool>(pub(crate) &'i mut Input<'a>);

impl<const BIG: bool> Binary<'_, '_, BIG> {
    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        self.0.fill(N)?;
        let Some(bytes) = self.0.rest().first_chunk::<N>() else { return Err(ENDS.into()) };
        let mut bytes = *bytes;
        self.0.consume(N);
        if BIG {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl<const BIG: bool> Values for Binary<'_, '_, BIG> {
    fn begin(&mut self) -> Result<(), String> {
        Ok(())
    }

    #[inline]
    fn number(&mut self, ty: Type) -> Result<f64, String> {
        match ty {
            Type::F32 => self.take().map(|b| f64::from(f32::from_le_bytes(b))),
            Type::F64 => self.take().map(f64::from_le_bytes),
            _ => self.integer(ty).map(|i| i as f64),
        }
    }

    #[inline]
    fn integer(&mut self, ty: Type) -> Result<i64, String> {
        match ty {
            Type::I8 => self.take().map(|b| i8::from_le_bytes(b).into()),
            Type::U8 => self.take().map(|b| u8::from_le_bytes(b).into()),
            Type::I16 => self.take().map(|b| i16::from_le_bytes(b).into()),
            Type::U16 => self.take().map(|b| u16::from_le_bytes(b).into()),
            Type::I32 => self.take().map(|b| i32::from_le_bytes(b).into()),
            Type::U32 => self.take().map(|b| u32::from_le_bytes(b).into()),
            Type::F32 | Type::F64 => Err("expected an integer type".into()),
        }
    }

    fn skip(&mut self, ty: Type, n: u64) -> Result<(), String> {
        if self.0.skip(n.saturating_mul(ty.size() as u64))? { Ok(()) } else { Err(ENDS.into()) }
    }

    fn end(&mut self) -> Result<(), String> {
        Ok(())
    }

    fn line(&self) -> Option<u64> {
        None
    }

    fn goes_on(&mut self) -> Result<bool, String> {
        blanks_then_more(self.0)
    }
}

fn blanks_then_more(input: &mut Input) -> Result<bool, String> {
    while input.fill(1)? {
        let blanks = input.rest().iter().take_while(|b| b.is_ascii_whitespace()).count();
        if blanks < input.rest().len() {
            return Ok(true);
        }
        input.consume(blanks);
    }
    Ok(false)
}

/// Text, one element a line.
pub(crate) struct Ascii<'i, 'a> {
    input: &'i mut Input<'a>,
    eol: u8,
    number: u64,
    /// What is left of the line, as positions in the input's window.
    at: usize,
    to: usize,
}

impl<'i, 'a> Ascii<'i, 'a> {
    /// The text after the header, which has `lines` lines.
    pub(crate) fn new(input: &'i mut Input<'a>, eol: u8, lines: u64) -> Self {
        Self { input, eol, number: lines, at: 0, to: 0 }
    }

    /// Steps over blanks; `false` at the end of the line.
    #[inline]
    fn blanks(&mut self) -> bool {
        let rest = self.input.bytes(self.at..self.to);
        self.at += rest.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(rest.len());
        self.at < self.to
    }

    /// The next word.
    fn word(&mut self) -> Result<&[u8], String> {
        if !self.blanks() {
            return Err("the line has fewer values than the header announces".into());
        }
        let rest = self.input.bytes(self.at..self.to);
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += length;
        Ok(self.input.bytes(self.at - length..self.at))
    }

    /// Reads a number of digits with at most one point among them, at most 19 in all, and steps over it: its digits, how
    /// many of them stand after the point, and its sign. `None` for anything else.
    #[inline]
    fn decimal(&mut self) -> Option<(u64, usize, bool)> {
        let rest = self.input.bytes(self.at..self.to);
        let negative = rest.first() == Some(&b'-');
        let (mut digits, mut count, mut point) = (0u64, 0, None);
        let mut i = usize::from(negative);
        while let Some(b) = rest.get(i) {
            let digit = b.wrapping_sub(b'0');
            if digit < 10 {
                digits = digits.wrapping_mul(10).wrapping_add(u64::from(digit));
                count += 1;
            } else if *b == b'.' && point.is_none() {
                point = Some(count);
            } else if b.is_ascii_whitespace() {
                break;
            } else {
                return None;
            }
            i += 1;
        }
        if count == 0 || count > 19 {
            return None;
        }
        self.at += i;
        Some((digits, point.map_or(0, |p| count - p), negative))
    }
}

const POW10: [f64; 23] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21,
    1e22,
];

/// Rounds to single precision, unless `x` (rounded itself) lies where a second rounding could go wrong: half-way between
/// two neighbours, or among the subnormal numbers.
#[inline]
fn to_single(x: f64) -> Option<f64> {
    const DROPPED: u64 = (1 << 29) - 1;
    let safe = x.to_bits() & DROPPED != 1 << 28 && (x == 0.0 || (1.2e-38..3.4e38).contains(&x.abs()));
    safe.then_some(f64::from(x as f32))
}

impl Values for Ascii<'_, '_> {
    #[inline]
    fn begin(&mut self) -> Result<(), String> {
        loop {
            let line = self.input.line(self.eol)?.ok_or(ENDS)?;
            (self.at, self.to) = (line.start, line.end);
            self.number += 1;
            if self.blanks() {
                return Ok(());
            }
        }
    }

    #[inline]
    fn number(&mut self, ty: Type) -> Result<f64, String> {
        self.blanks();
        let start = self.at;
        // The quotient of two exactly known numbers is rounded once, hence right (Clinger 1990).
        if let Some((digits, places, negative)) = self.decimal()
            && digits < 1 << 53
            && places < POW10.len()
        {
            let x = digits as f64 / POW10[places];
            let x = if negative { -x } else { x };
            match if ty == Type::F32 { to_single(x) } else { Some(x) } {
                Some(x) => return Ok(x),
                None => self.at = start,
            }
        } else {
            self.at = start;
        }
        let word = self.word()?;
        let text = std::str::from_utf8(word).unwrap_or_default();
        let value = if ty == Type::F32 { text.parse::<f32>().map(f64::from) } else { text.parse() };
        // What is no number has many spellings.
        let value = value.ok().or_else(|| crate::obj_lines::number(word));
        value.ok_or_else(|| format!("expected a number, found `{}`", shown(word)))
    }

    #[inline]
    fn integer(&mut self, _: Type) -> Result<i64, String> {
        self.blanks();
        let start = self.at;
        if let Some((digits, 0, negative)) = self.decimal()
            && digits < 1 << 53
            && self.input.bytes(start..self.at).last() != Some(&b'.')
        {
            return Ok(if negative { -(digits as i64) } else { digits as i64 });
        }
        self.at = start;
        let word = self.word()?;
        let value = std::str::from_utf8(word).ok().and_then(|w| w.parse().ok());
        value.ok_or_else(|| format!("expected an integer, found `{}`", shown(word)))
    }

    fn skip(&mut self, _: Type, n: u64) -> Result<(), String> {
        (0..n).try_for_each(|_| self.word().map(|_| ()))
    }

    #[inline]
    fn end(&mut self) -> Result<(), String> {
        if self.blanks() { Err("the line has more values than the header announces".into()) } else { Ok(()) }
    }

    fn line(&self) -> Option<u64> {
        Some(self.number)
    }

    fn goes_on(&mut self) -> Result<bool, String> {
        blanks_then_more(self.input)
    }
}

/// A word of the file for a message, cut where it is long.
fn shown(word: &[u8]) -> String {
    let text = String::from_utf8_lossy(word);
    let mut short: String = text.chars().take(24).map(|c| if c.is_control() { '?' } else { c }).collect();
    if text.chars().count() > 24 {
        short.push('…');
    }
    short
}
