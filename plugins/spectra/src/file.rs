//! `file`: a measured spectrum from a text file with two columns, wavelength and value.
//!
//! One pair a line, separated by blanks, tabs or a comma; `#` starts a comment. Wavelengths increase. Values between are
//! joined by straight lines; outside the data the end value is kept, or zero with the word `zero-outside`. A relative path
//! starts at the folder of the scene file. A text is a path if it ends in `.spd` or contains `/` or `.`.
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
use crate::{Built, SpectrumPlugin, check_role};
use bhs_core::diagnostics::Diagnostic;
use bhs_core::params::Context;
use bhs_core::spectrum::SpectrumRole;
use bhs_core::value::Param;
use std::sync::Arc;

/// The entry in the list of plugins.
pub const PLUGIN: SpectrumPlugin =
    SpectrumPlugin { name: "file", summary: "a text file (.spd) with two columns, wavelength [nm] and value", build };

/// More faults of one file than this are not listed: it is the wrong file.
const MOST_FAULTS: usize = 4;

/// Whether `text` names a file rather than a built-in spectrum.
pub fn is_path(text: &str) -> bool {
    text.contains(['/', '.'])
}

fn build(param: &Param, role: SpectrumRole, context: &Context) -> Built {
    let (path, outside) = name_and_outside(param)?;
    let bytes = context.files.read(&path.value, path.span).map_err(|why| {
        vec![Diagnostic::error("unreadable-file", format!("cannot read `{}`: {why}", path.value)).at(path.span, "")]
    })?;
    let points = parse(&bytes).map_err(|faults| {
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

/// Line number, wavelength (nm) and value of each line, or what is wrong with the lines.
fn parse(bytes: &[u8]) -> Result<Vec<(usize, f64, f64)>, Vec<String>> {
    let text = std::str::from_utf8(bytes).map_err(|_| vec!["it is not text in UTF-8".to_owned()])?;
    let mut points: Vec<(usize, f64, f64)> = Vec::new();
    let mut faults = Vec::new();
    for (i, line) in text.trim_start_matches('\u{feff}').lines().enumerate() {
        let number = i + 1;
        let data = line.split('#').next().unwrap_or_default();
        let words: Vec<&str> = data.split(|c: char| c == ',' || c.is_whitespace()).filter(|w| !w.is_empty()).collect();
        if words.is_empty() {
            continue;
        }
        match point(&words) {
            Err(fault) => faults.push(format!("line {number}: {fault}")),
            Ok((l, _)) if points.last().is_some_and(|p| l <= p.1) => {
                faults.push(format!(
                    "line {number}: {l} nm does not follow {} nm; wavelengths must increase",
                    points[points.len() - 1].1
                ));
            }
            Ok((l, v)) => points.push((number, l, v)),
        }
    }
    if points.is_empty() && faults.is_empty() {
        faults.push("it has no values".to_owned());
    }
    if faults.is_empty() { Ok(points) } else { Err(faults) }
}

/// Wavelength (nm) and value of one line.
fn point(words: &[&str]) -> Result<(f64, f64), String> {
    let [l, v] = words else {
        let found = if words.len() == 1 { "1 word".to_owned() } else { format!("{} words", words.len()) };
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
