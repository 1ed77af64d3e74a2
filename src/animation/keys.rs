//! What moves: numbers of variables at some frames, and in between.
//!
//! A table (CSV) whose first column is the frame. Its first line names the columns; if it begins with the word `smooth`, what lies between
//! keys is a monotone cubic (Steffen 1990, "A simple method for monotonic interpolation in one dimension", Astronomy and Astrophysics 239,
//! 443), else a straight line. Before the first key and after the last one the number is held.

use crate::lang::parse::{is_variable_name, read_number};
use bhs_core::diagnostics::{Diagnostic, Span, shorten};

/// The numbers of variables over the frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Keys {
    columns: Vec<Column>,
    is_smooth: bool,
}

/// The keys of one variable.
#[derive(Clone, Debug, PartialEq)]
struct Column {
    name: String,
    /// Frame and number, by frame.
    keys: Vec<[f64; 2]>,
}

/// A word of a line: the text, and where it begins in the file.
type Cell<'t> = (&'t str, usize);

impl Keys {
    /// Reads the text of file number `file`.
    ///
    /// # Errors
    /// The first thing that is wrong with it. (In a box: a diagnostic is large.)
    pub fn parse(text: &str, file: u16) -> Result<Self, Box<Diagnostic>> {
        let fault = |(word, start): Cell, message: String| {
            let span = Span { file, start: start as u32, end: (start + word.len()) as u32 };
            Box::new(Diagnostic::error("bad-keys", message).at(span, ""))
        };
        let mut lines = lines(text);
        let Some(mut header) = lines.next() else {
            return Err(fault(("", 0), "the file of keys is empty".to_owned()));
        };
        let is_smooth = take_smooth(&mut header);
        match header.first() {
            Some(("frame", _)) if header.len() > 1 => {}
            Some(("frame", at)) => {
                return Err(fault(("frame", *at), "a column of a variable is missing behind `frame`".to_owned()));
            }
            first => {
                let cell = first.copied().unwrap_or_default();
                return Err(fault(cell, format!("the first column is `frame`, not `{}`", shorten(cell.0))));
            }
        }
        let mut columns: Vec<Column> = Vec::new();
        for cell in &header[1..] {
            let name = cell.0;
            if !is_variable_name(name) {
                return Err(fault(*cell, format!("a column is called as a variable is, without `$`, not `{}`", shorten(name))));
            }
            if crate::lang::variables::ALWAYS.contains(&name) {
                return Err(fault(*cell, format!("`{name}` follows from the number of the frame and has no keys")));
            }
            if columns.iter().any(|c| c.name == name) {
                return Err(fault(*cell, format!("the column `{name}` stands there twice")));
            }
            columns.push(Column { name: name.to_owned(), keys: Vec::new() });
        }
        let mut last = f64::NEG_INFINITY;
        for cells in lines {
            if cells.len() != header.len() {
                let cell = cells.get(header.len()).or(cells.last()).copied().unwrap_or_default();
                return Err(fault(cell, format!("this line has {} columns, the first one has {}", cells.len(), header.len())));
            }
            let number = |cell: Cell| match read_number(cell.0) {
                Some((value, _)) if value.is_finite() => Ok(value),
                _ => Err(fault(cell, format!("`{}` is not a number", shorten(cell.0)))),
            };
            let frame = number(cells[0])?;
            if frame <= last {
                return Err(fault(cells[0], format!("frames increase from line to line, and {frame} follows {last}")));
            }
            last = frame;
            for (column, cell) in columns.iter_mut().zip(&cells[1..]) {
                // An empty one is no key of this variable.
                if !cell.0.is_empty() {
                    column.keys.push([frame, number(*cell)?]);
                }
            }
        }
        match header[1..].iter().zip(&columns).find(|(_, column)| column.keys.is_empty()) {
            Some((cell, column)) => Err(fault(*cell, format!("the column `{}` has no number", column.name))),
            None => Ok(Self { columns, is_smooth }),
        }
    }

    /// The numbers of all variables at a frame.
    pub fn at(&self, frame: f64) -> Vec<(String, f64)> {
        self.columns.iter().map(|c| (c.name.clone(), c.at(frame, self.is_smooth))).collect()
    }
}

/// The cells of all lines that are neither empty nor comments.
fn lines(text: &str) -> impl Iterator<Item = Vec<Cell<'_>>> {
    let mut start = 0;
    text.split_inclusive('\n').filter_map(move |line| {
        let from = start;
        start += line.len();
        let is_empty = line.trim().is_empty() || line.trim_start().starts_with('#');
        (!is_empty).then(|| {
            let mut at = from;
            let cells = line.split(',').map(|cell| {
                let begin = at + (cell.len() - cell.trim_start().len());
                at += cell.len() + 1;
                (cell.trim(), begin)
            });
            cells.collect()
        })
    })
}

/// Takes the word `smooth` away that a header begins with, as a column of its own or before the first one.
fn take_smooth(header: &mut Vec<Cell>) -> bool {
    let Some((first, at)) = header.first_mut() else { return false };
    if *first == "smooth" {
        header.remove(0);
        return true;
    }
    match first.strip_prefix("smooth").filter(|rest| rest.starts_with([' ', '\t'])) {
        Some(rest) => {
            let rest = rest.trim_start();
            (*at, *first) = (*at + (first.len() - rest.len()), rest);
            true
        }
        None => false,
    }
}

impl Column {
    fn at(&self, frame: f64, is_smooth: bool) -> f64 {
        let keys = &self.keys;
        let after = keys.partition_point(|[f, _]| *f <= frame);
        let Some(before) = after.checked_sub(1) else { return keys.first().map_or(0.0, |[_, value]| *value) };
        let ([from, a], Some([to, b])) = (keys[before], keys.get(after).copied()) else { return keys[before][1] };
        let t = (frame - from) / (to - from);
        if t == 0.0 || a == b {
            return a;
        }
        if !is_smooth {
            return a + (b - a) * t;
        }
        // The cubic with these ends and slopes.
        let width = to - from;
        let [left, right] = [slope(keys, before) * width, slope(keys, after) * width];
        let rest = b - a;
        a + t * (left + t * ((3.0 * rest - 2.0 * left - right) + t * (left + right - 2.0 * rest)))
    }
}

/// The slope at a key by which the cubics are monotone between keys (Steffen's equations 11, 26 and 27).
fn slope(keys: &[[f64; 2]], i: usize) -> f64 {
    let width = |i: usize| keys[i + 1][0] - keys[i][0];
    let secant = |i: usize| (keys[i + 1][1] - keys[i][1]) / width(i);
    let last = keys.len() - 1;
    // At an end: that of the parabola through three keys, as far as that is monotone.
    let at_end = |own: f64, next: f64, share: f64| {
        let slope = own * (1.0 + share) - next * share;
        if slope * own <= 0.0 {
            0.0
        } else if slope.abs() > 2.0 * own.abs() {
            2.0 * own
        } else {
            slope
        }
    };
    match i {
        _ if last == 1 => secant(0),
        0 => at_end(secant(0), secant(1), width(0) / (width(0) + width(1))),
        _ if i == last => at_end(secant(i - 1), secant(i - 2), width(i - 1) / (width(i - 1) + width(i - 2))),
        _ => {
            let (s, t) = (secant(i - 1), secant(i));
            if s * t <= 0.0 {
                return 0.0;
            }
            let mean = (s * width(i) + t * width(i - 1)) / (width(i - 1) + width(i));
            2.0 * s.signum() * s.abs().min(t.abs()).min(0.5 * mean.abs())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn keys(text: &str) -> Keys {
        Keys::parse(text, 0).unwrap_or_else(|d| panic!("{d:?}"))
    }

    fn one(keys: &Keys, frame: f64) -> f64 {
        keys.at(frame)[0].1
    }

    #[test]
    fn lines_are_straight_between_keys_and_held_outside() {
        let table = keys("# a comment\nframe, x ,y\r\n10,1,5\n\n20,2,\n30,-2,6\n");
        assert_eq!(table.at(0.0), [("x".to_owned(), 1.0), ("y".to_owned(), 5.0)]);
        assert_eq!(table.at(15.0), [("x".to_owned(), 1.5), ("y".to_owned(), 5.25)]);
        assert_eq!(table.at(20.0), [("x".to_owned(), 2.0), ("y".to_owned(), 5.5)]);
        assert_eq!(table.at(29.0), [("x".to_owned(), -1.6), ("y".to_owned(), 5.95)]);
        assert_eq!(table.at(1e6), [("x".to_owned(), -2.0), ("y".to_owned(), 6.0)]);
    }

    #[test]
    fn smooth_keys_are_met_and_nothing_goes_beyond_them() {
        for header in ["smooth,frame,x", "smooth frame,x", " smooth\t frame , x"] {
            let values = [0.0, 1.0, 1.0, 5.0, 4.9, -3.0, -3.0, 7.0];
            let rows: String = values.iter().enumerate().map(|(i, v)| format!("\n{},{v}", i * i)).collect();
            let table = keys(&format!("{header}{rows}"));
            for (i, v) in values.iter().enumerate() {
                assert_eq!(one(&table, (i * i) as f64), *v, "{header}");
            }
            let mut slopes = Vec::new();
            for n in 0..4899 {
                let frame = f64::from(n) * 0.01;
                let i = frame.sqrt().floor() as usize;
                let (lo, hi) = (values[i].min(values[i + 1]), values[i].max(values[i + 1]));
                let value = one(&table, frame);
                assert!((lo - 1e-12..=hi + 1e-12).contains(&value), "{frame}: {value}");
                slopes.push((one(&table, frame + 0.01) - value) / 0.01);
            }
            // No corners: slopes of neighbours differ by the second derivative, at most 6 times the change over the square of the width.
            assert!(slopes.windows(2).all(|s| (s[1] - s[0]).abs() < 0.01 * 6.0 * 4.0), "{header}");
        }
    }

    #[test]
    fn smooth_keys_of_a_line_and_of_a_parabola_are_these() {
        let line = keys("smooth frame,x\n0,1\n1,3\n4,9\n9,19");
        let parabola = keys("smooth frame,x\n0,0\n2,4\n4,16");
        for n in 0..=40 {
            let t = f64::from(n) * 0.1;
            assert!((one(&line, t) - (1.0 + 2.0 * t)).abs() < 1e-12);
            // The middle slope is that of the parabola, half the mean at most: 4; so is the one at the right end, 8.
            if t >= 2.0 {
                assert!((one(&parabola, t) - t * t).abs() < 1e-12, "{t}: {}", one(&parabola, t));
            }
        }
    }

    #[test]
    fn what_is_wrong_is_said_at_its_place() {
        for (text, said, at) in [
            ("", "empty", ""),
            ("x,frame\n", "the first column is `frame`", "x"),
            ("frame\n1\n", "missing behind `frame`", "frame"),
            ("frame,2x\n", "called as a variable", "2x"),
            ("frame,$x\n", "without `$`", "$x"),
            ("frame,time\n", "follows from the number", "time"),
            ("frame,x,x\n", "twice", "x"),
            ("frame,x\n1,a\n", "not a number", "a"),
            ("frame,x\n1,nan\n", "not a number", "nan"),
            ("frame,x\n1,2,3\n", "3 columns", "3"),
            ("frame,x\n1\n", "1 columns", "1"),
            ("frame,x\n2,1\n2,1\n", "frames increase", "2"),
            ("frame,x\n1,\n", "has no number", "x"),
            ("frame,x\n", "has no number", "x"),
        ] {
            let found = *Keys::parse(text, 0).expect_err(text);
            assert!(found.message.contains(said), "{text:?}: {}", found.message);
            let span = found.primary.expect("a place").span;
            assert_eq!(&text[span.start as usize..span.end as usize], at, "{text:?}");
        }
    }
}
