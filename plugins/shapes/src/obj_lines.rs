//! The lines of an OBJ file as words and numbers, whatever program wrote them.

use std::borrow::Cow;

/// The lines that are geometry, one after the other.
pub(crate) struct Lines<'a> {
    rest: &'a [u8],
    /// Number of the last line that was read, from 1.
    number: u64,
}

/// A line that matters.
pub(crate) enum Line<'a> {
    /// Its first word, and what follows: `v`, `vt`, `vn` or `f`.
    Geometry(&'a [u8], Cow<'a, [u8]>),
    /// The name after `usemtl`.
    Material(&'a [u8]),
    /// What stands after `mtllib`: the name of a file, or several.
    Library(&'a [u8]),
}

/// Bytes that start a file of text in UTF-8, where they are there.
pub(crate) const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// What can be said of a text whose characters take two bytes; by its byte order mark.
///
/// # Errors
/// That it is one.
pub(crate) fn refuse_utf16(file: &[u8]) -> Result<(), String> {
    match file {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => Err("it is text in UTF-16: save it as UTF-8 or ASCII".into()),
        _ => Ok(()),
    }
}

/// The first line of a text without its end, which is that of any system, taken off; `None` at the end of the text.
pub(crate) fn take_line<'a>(text: &mut &'a [u8]) -> Option<&'a [u8]> {
    if text.is_empty() {
        return None;
    }
    let end = text.iter().position(|b| matches!(b, b'\n' | b'\r')).unwrap_or(text.len());
    let (line, rest) = text.split_at(end);
    *text = rest.strip_prefix(b"\r\n").or_else(|| rest.get(1..)).unwrap_or_default();
    Some(line)
}

impl<'a> Lines<'a> {
    pub(crate) fn new(file: &'a [u8]) -> Result<Self, String> {
        refuse_utf16(file)?;
        Ok(Self { rest: file.strip_prefix(BYTE_ORDER_MARK).unwrap_or(file), number: 0 })
    }

    /// Number of the line that was handed out last; of its last part, if it has several.
    pub(crate) fn number(&self) -> u64 {
        self.number
    }

    /// The next line of the file without its end and its comment; `None` at the end of the file.
    fn next_part(&mut self) -> Option<&'a [u8]> {
        let line = take_line(&mut self.rest)?;
        self.number += 1;
        Some(without_comment(line))
    }

    /// The next line that matters.
    pub(crate) fn next_line(&mut self) -> Option<Line<'a>> {
        loop {
            let line = self.next_part()?.trim_ascii();
            let length = line.iter().position(u8::is_ascii_whitespace).unwrap_or(line.len());
            let (word, rest) = line.split_at(length);
            match word {
                b"v" | b"vt" | b"vn" | b"f" => {}
                b"usemtl" => return Some(Line::Material(rest.trim_ascii())),
                b"mtllib" => return Some(Line::Library(rest.trim_ascii())),
                // A line of geometry cannot be broken before anything stands in it, nor a name: `\` may end a folder.
                _ => continue,
            }
            let mut rest = Cow::Borrowed(rest);
            while let Some(length) = rest.trim_ascii_end().strip_suffix(b"\\").map(<[u8]>::len) {
                let whole = rest.to_mut();
                whole.truncate(length);
                whole.push(b' ');
                match self.next_part() {
                    Some(next) => whole.extend_from_slice(next),
                    None => break,
                }
            }
            return Some(Line::Geometry(word, rest));
        }
    }
}

/// The line up to `#`; but not that of `1.#QNAN` or `1.#INF`, which Microsoft's older libraries write for what is no number.
fn without_comment(line: &[u8]) -> &[u8] {
    let mut from = 0;
    while let Some(at) = line[from..].iter().position(|b| *b == b'#').map(|i| from + i) {
        let is_number = at >= 2 && line[at - 1] == b'.' && line[at - 2].is_ascii_digit() && is_no_number(&line[at + 1..]);
        if !is_number {
            return &line[..at];
        }
        from = at + 1;
    }
    line
}

/// Whether a text begins as what follows `1.#`.
fn is_no_number(text: &[u8]) -> bool {
    [&b"QNAN"[..], b"SNAN", b"IND", b"INF"].iter().any(|w| text.len() >= w.len() && text[..w.len()].eq_ignore_ascii_case(w))
}

/// A number of a text; one that is none is NaN, in all the ways in which programs write it. `None` for other words.
pub(crate) fn number(word: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(word).ok()?;
    if let Ok(x) = text.parse() {
        return Some(x);
    }
    // `1.#QNAN0`, `-1.#IND`, `-nan(ind)`, `nan(0x8000)`, `-nan(snan)`; exponents of Fortran, `1.5D+01`.
    let unsigned = text.strip_prefix(['-', '+']).unwrap_or(text);
    let lower = unsigned.to_ascii_lowercase();
    let without_number = unsigned
        .split_once(".#")
        .is_some_and(|(digit, rest)| digit.len() == 1 && digit.as_bytes()[0].is_ascii_digit() && is_no_number(rest.as_bytes()));
    if without_number {
        let is_infinite = lower.contains("#inf");
        return Some(if is_infinite { f64::INFINITY } else { f64::NAN });
    }
    if lower == "nanq" || lower == "nans" || (lower.starts_with("nan(") && lower.ends_with(')')) {
        return Some(f64::NAN);
    }
    let exponent = lower.split_once('d').filter(|(mantissa, _)| mantissa.as_bytes().iter().any(u8::is_ascii_digit));
    exponent.and_then(|_| text.replace(['d', 'D'], "e").parse().ok())
}

/// The numbers of a line, at most `N`, and how many there are; `None` if there are more, or other words.
pub(crate) fn numbers<const N: usize>(text: &[u8]) -> Option<([f64; N], usize)> {
    let (mut values, mut n) = ([0.0; N], 0);
    for word in text.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()) {
        *values.get_mut(n)? = number(word)?;
        n += 1;
    }
    Some((values, n))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_number_is_known_in_all_spellings() {
        let none = [
            "nan",
            "NaN",
            "-nan",
            "+NAN",
            "-nan(ind)",
            "nan(snan)",
            "nan(0x8000000000000)",
            "1.#QNAN",
            "-1.#IND",
            "1.#IND00",
            "1.#SNAN0",
            "NaNQ",
        ];
        for word in none {
            assert!(number(word.as_bytes()).is_some_and(f64::is_nan), "{word}");
        }
        for word in ["inf", "-Infinity", "1.#INF", "-1.#INF000"] {
            assert!(number(word.as_bytes()).is_some_and(f64::is_infinite), "{word}");
        }
        assert_eq!(number(b"1.5D+01"), Some(15.0));
        for word in ["", "x", "1,5", "0x10", "nano", "1.#", "d", "1f"] {
            assert_eq!(number(word.as_bytes()), None, "{word}");
        }
    }

    #[test]
    fn comments_end_a_line_but_not_a_number() {
        let table = [
            ("v 1 2#3", "v 1 2"),
            ("# all", ""),
            ("vn 1.#QNAN 0 0 # x", "vn 1.#QNAN 0 0 "),
            ("v 1.# x", "v 1."),
            ("v 1.#inf#", "v 1.#inf"),
        ];
        for (line, kept) in table {
            assert_eq!(without_comment(line.as_bytes()), kept.as_bytes(), "{line}");
        }
    }
}
