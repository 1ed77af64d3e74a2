//! `file`: a measured spectrum from a text file with two columns, wavelength and value.
//!
//! One pair a line, separated by blanks, tabs, a comma or a semicolon; `#` starts a comment, a first line of names is left out.
//! Wavelengths increase, or all decrease; two values at one are a step. Values between are joined by straight lines; outside the
//! data the end value is kept, or zero with the word `zero-outside`. A relative path starts at the folder of the scene file. A
//! text is a path if it ends in `.spd` or contains `/` or `.`.
//!
//! | values | type | unit | meaning |
//! |---|---|---|---|
//! | path | `spectrum` | nm, and that of the parameter | the file |
//! | `zero-outside` | | | the spectrum is zero outside the data of the file |
//!
//! ```bhs
//! AreaLightSource "diffuse" "spectrum L" ["lamps/sodium.spd" "zero-outside"]
//! ```

use crate::tabulated::{Tabulated, name_and_outside};
use crate::{Built, Maker, check_role};
use bhs_core::Plugin;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::params::{Context, SpectrumMaker};
use bhs_core::spectrum::SpectrumRole;
use bhs_core::value::Param;
use std::sync::Arc;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn SpectrumMaker> = Plugin {
    name: "file",
    summary: "a text file (.spd) with two columns, wavelength [nm] and value",
    build: |_| Some(Box::new(Maker(make))),
};

/// More faults of one file than this are not listed: it is the wrong file.
const MOST_FAULTS: usize = 4;

/// Whether `text` names a file rather than a built-in spectrum.
pub fn is_path(text: &str) -> bool {
    text.contains(['/', '.'])
}

fn make(param: &Param, role: SpectrumRole, context: &Context) -> Built {
    let (path, outside) = name_and_outside(param)?;
    let bytes = context.files.read(&path.value, path.span).map_err(|why| {
        vec![Diagnostic::error("unreadable-file", format!("cannot read `{}`: {why}", path.value)).at(path.span, "")]
    })?;
    let film = context.lambda_range.map(f64::from);
    let points = parse(&bytes, film).map_err(|faults| {
        let told = faults.iter().take(MOST_FAULTS).map(|fault| {
            let more = if faults.len() > MOST_FAULTS { format!(" ({} faults in all)", faults.len()) } else { String::new() };
            let message = format!("`{}` is no spectrum: {fault}{more}", path.value);
            Diagnostic::error("bad-file", message)
                .at(path.span, "")
                .help("a spectrum has two numbers a line, wavelength [nm] and value")
        });
        told.collect::<Vec<_>>()
    })?;
    check_role(param, path.span, role, points.iter().map(|(line, l, v)| (*v, format!(" at {l} nm (line {line})"))))?;
    let points: Vec<(f64, f64)> = points.into_iter().map(|(_, l, v)| (l, v)).collect();
    Ok(Arc::new(Tabulated::new(&points, outside)))
}

/// A line's number, wavelength (nm) and value.
type Point = (usize, f64, f64);

/// Wavelengths that all lie below are in other units than nm: no lamp and no sensor works there.
const SHORTEST_NM: f64 = 10.0;
/// Wavelengths that all lie above are in other units, or say nothing of what is seen.
const LONGEST_NM: f64 = 3000.0;

/// The points of a file by increasing wavelength, for a film that records `film` (nm), or what is wrong with its lines.
fn parse(bytes: &[u8], film: [f64; 2]) -> Result<Vec<Point>, Vec<String>> {
    let fault = |text: &str| Err(vec![text.to_owned()]);
    match bytes {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => return fault("it is not text in UTF-8 or ASCII, but in UTF-16"),
        _ if bytes.contains(&0) => return fault("it is not text"),
        _ => {}
    }
    // Comments and names may be in any encoding: numbers are the same in all of them.
    let text = String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes));
    let mut points: Vec<Point> = Vec::new();
    let mut faults = Vec::new();
    let mut has_names = false;
    for (i, line) in text.replace("\r\n", "\n").split(['\n', '\r']).enumerate() {
        let number = i + 1;
        let data = line.split('#').next().unwrap_or_default();
        let words: Vec<&str> = words(data).collect();
        if words.is_empty() {
            continue;
        }
        // Names of columns, of two or more; where numbers have been, another table begins with them.
        let are_names = words.len() > 1 && words.iter().all(|w| is_name(w));
        if are_names && points.is_empty() && faults.is_empty() && !has_names {
            has_names = true;
            continue;
        }
        if are_names && !points.is_empty() && faults.is_empty() {
            return Err(vec![format!("line {number}: another table begins here (`{}`): keep one of them", data.trim())]);
        }
        match point(data, &words) {
            Err(fault) => faults.push(format!("line {number}: {fault}")),
            Ok((l, v)) => points.push((number, l, v)),
        }
    }
    if points.is_empty() && faults.is_empty() {
        faults.push("it has no values".to_owned());
    }
    if let (Some(first), Some(last)) = (points.first(), points.last()) {
        let decreases = last.1 < first.1;
        faults.extend(order_faults(&points, decreases));
        if decreases {
            points.reverse();
        }
    }
    if faults.is_empty() {
        let ends = [points.first(), points.last()].map(|p| p.map_or(0.0, |p| p.1));
        faults.extend(unit_fault(ends, film).map(|fault| format!("its {fault}")));
    }
    if faults.is_empty() { Ok(points) } else { Err(faults) }
}

/// The words of a line.
fn words(data: &str) -> impl Iterator<Item = &str> {
    data.split(|c: char| matches!(c, ',' | ';') || c.is_whitespace()).filter(|w| !w.is_empty())
}

/// Whether a word is text rather than a number, or what was to be one: no digit comes before its letters.
fn is_name(word: &str) -> bool {
    word.parse::<f64>().is_err() && word.chars().find(|c| c.is_alphanumeric()).is_none_or(char::is_alphabetic)
}

/// What is wrong with the order of wavelengths.
fn order_faults(points: &[Point], decreases: bool) -> Vec<String> {
    let mut faults = Vec::new();
    for w in points.windows(2) {
        let ([(_, a, _), (line, b, _)], way) = ([w[0], w[1]], if decreases { "decrease" } else { "increase" });
        if (b > a) == decreases && b != a {
            faults.push(format!(
                "line {line}: {b} nm does not follow {a} nm; wavelengths must {way}, as they do from first to last"
            ));
        }
    }
    for w in points.windows(3) {
        if w[0].1 == w[2].1 {
            faults.push(format!("line {}: a third value at {} nm; two make a step", w[2].0, w[2].1));
        }
    }
    faults
}

/// What is wrong with the unit of wavelengths that reach from the one of `range` to the other, as far as numbers tell; nothing where the film
/// records such wavelengths, from one of `film` to the other.
pub fn unit_fault([shortest, longest]: [f64; 2], film: [f64; 2]) -> Option<String> {
    if longest < SHORTEST_NM && longest < film[0] {
        if longest < 1e-4 {
            return Some(format!("wavelengths end at {longest:e} nm: are they in metres? they must be in nm, 1e9 times as much"));
        }
        return Some(format!("wavelengths end at {longest} nm: are they in micrometres? they must be in nm, 1000 times as much"));
    }
    (shortest >= LONGEST_NM && shortest > film[1]).then(|| {
        format!("wavelengths begin at {shortest} nm: are they in \u{e5}ngstr\u{f6}m? they must be in nm, a tenth of that")
    })
}

/// Wavelength (nm) and value of one line.
fn point(data: &str, words: &[&str]) -> Result<(f64, f64), String> {
    let [l, v] = words else {
        if has_decimal_comma(data) {
            return Err("a comma within a number: write a point (400.5, not 400,5)".into());
        }
        let found = match words.len() {
            1 => "1 word".to_owned(),
            n => format!("{n} words: keep the wavelength and one column"),
        };
        return Err(format!("expected two numbers, found {found}"));
    };
    let number = |word: &str| match word.parse::<f64>() {
        Ok(x) if x.is_finite() => Ok(x),
        Ok(_) => Err(format!("`{word}` is not finite")),
        Err(_) => Err(format!("`{word}` is not a number")),
    };
    let (l, v) = (number(l)?, number(v)?);
    if l <= 0.0 {
        return Err(format!("a wavelength is greater than 0, found {l}"));
    }
    Ok((l, v))
}

/// Whether a line has a comma between digits although something else parts its columns.
fn has_decimal_comma(data: &str) -> bool {
    let is_number = |field: &str| {
        let digits = |part: &str| part.bytes().next().is_some_and(|b| b.is_ascii_digit()) || part.starts_with(['-', '+']);
        field.split_once(',').is_some_and(|(whole, rest)| digits(whole) && digits(rest) && !rest.contains(','))
    };
    let mut fields = data.split(|c: char| c == ';' || c.is_whitespace()).filter(|f| !f.is_empty());
    let is_comma = fields.clone().count() == 2 && fields.any(is_number);
    // 400,5,0,12: nothing but commas.
    is_comma || (data.split(',').count() == 4 && data.trim().split(',').all(|w| w.trim().parse::<f64>().is_ok()))
}
