//! `builtin`: measured spectra by name.
//!
//! Tables are joined by straight lines; outside the data the end value is kept, or zero with the word `zero-outside`.
//! Nothing is renormalised: `stdillum-D65` is 100 at 560 nm, `cornell-light` has the values of its source (0 to 18.4).
//! A glass follows Sellmeier's formula, relative to air.
//!
//! | name | what | source |
//! |---|---|---|
//! | `cornell-white`, `cornell-red`, `cornell-green` | reflectance of the Cornell box's paints | Cornell University |
//! | `cornell-light`, `cornell-luminaire` | emission (relative) and reflectance of its lamp | Cornell University |
//! | `metal-Au-eta`, `metal-Au-k`, the same for `Ag`, `Cu` | complex refractive index n + i k | Johnson and Christy 1972 |
//! | `metal-Al-eta`, `metal-Al-k` | the same for aluminium | Rakic 1995 |
//! | `metal-Au-pbrt-eta`, ... for `Au`, `Ag`, `Cu`, `Al` | the tables of pbrt-v4, to compare pictures | pbrt-v4 |
//! | `glass-BK7` (N-BK7), `glass-SF10`, `glass-N-SF10`, `glass-SF11`, `glass-N-SF11` | refractive index | Schott 2017 |
//! | `stdillum-D65`, `stdillum-E` | daylight; equal energy (1 everywhere) | CIE |
//!
//! ```bhs
//! Material "conductor" "spectrum eta" "metal-Au-eta" "spectrum k" "metal-Au-k"
//! ```

use crate::sellmeier::Sellmeier;
use crate::tabulated::rows;
use crate::tabulated::{Outside, Tabulated, name_and_outside};
use crate::{Built, check_role, unknown};
use bhs_core::Plugin;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::params::{Constant, Context, SpectrumMaker};
use bhs_core::spectrum::SpectrumRole;
use bhs_core::value::Param;
use std::sync::Arc;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn SpectrumMaker> = Plugin {
    name: "builtin",
    summary: "measured paints, lamps, metals, glasses and illuminants by name",
    build: |_| Some(Box::new(Named)),
};

/// Where the numbers of a built-in spectrum are.
#[derive(Clone, Copy)]
enum Data {
    /// Two columns: wavelength and value.
    Pairs(&'static str),
    /// Three columns, of which wavelength and n.
    Eta(&'static str),
    /// Three columns, of which wavelength and k.
    K(&'static str),
    /// A row of the table of glasses.
    Glass(&'static str),
    /// The illuminant D65.
    D65,
    /// The number 1.
    One,
}

use Data::{D65, Eta, Glass, K, One, Pairs};

const AU: &str = include_str!("../data/Au_JohnsonChristy1972.csv");
const AG: &str = include_str!("../data/Ag_JohnsonChristy1972.csv");
const CU: &str = include_str!("../data/Cu_JohnsonChristy1972.csv");
const AL: &str = include_str!("../data/Al_Rakic1995.csv");
const AU_PBRT: &str = include_str!("../data/Au_pbrt_v4.csv");
const AG_PBRT: &str = include_str!("../data/Ag_pbrt_v4.csv");
const CU_PBRT: &str = include_str!("../data/Cu_pbrt_v4.csv");
const AL_PBRT: &str = include_str!("../data/Al_pbrt_v4.csv");
const GLASSES: &str = include_str!("../data/glass_sellmeier.csv");

const SPECTRA: &[(&str, Data)] = &[
    ("cornell-white", Pairs(include_str!("../data/cornell_white.spd"))),
    ("cornell-red", Pairs(include_str!("../data/cornell_red.spd"))),
    ("cornell-green", Pairs(include_str!("../data/cornell_green.spd"))),
    ("cornell-light", Pairs(include_str!("../data/cornell_light.spd"))),
    ("cornell-luminaire", Pairs(include_str!("../data/cornell_luminaire.spd"))),
    ("metal-Au-eta", Eta(AU)),
    ("metal-Au-k", K(AU)),
    ("metal-Ag-eta", Eta(AG)),
    ("metal-Ag-k", K(AG)),
    ("metal-Cu-eta", Eta(CU)),
    ("metal-Cu-k", K(CU)),
    ("metal-Al-eta", Eta(AL)),
    ("metal-Al-k", K(AL)),
    ("metal-Au-pbrt-eta", Eta(AU_PBRT)),
    ("metal-Au-pbrt-k", K(AU_PBRT)),
    ("metal-Ag-pbrt-eta", Eta(AG_PBRT)),
    ("metal-Ag-pbrt-k", K(AG_PBRT)),
    ("metal-Cu-pbrt-eta", Eta(CU_PBRT)),
    ("metal-Cu-pbrt-k", K(CU_PBRT)),
    ("metal-Al-pbrt-eta", Eta(AL_PBRT)),
    ("metal-Al-pbrt-k", K(AL_PBRT)),
    ("glass-BK7", Glass("N-BK7")),
    ("glass-SF10", Glass("SF10")),
    ("glass-N-SF10", Glass("N-SF10")),
    ("glass-SF11", Glass("SF11")),
    ("glass-N-SF11", Glass("N-SF11")),
    ("stdillum-D65", D65),
    ("stdillum-E", One),
];

/// The names, in the order of the reference.
pub fn names() -> impl Iterator<Item = &'static str> {
    SPECTRA.iter().map(|(name, _)| *name)
}

/// The built-in spectra.
struct Named;

impl SpectrumMaker for Named {
    fn names(&self) -> Vec<&'static str> {
        names().collect()
    }

    fn make(&self, param: &Param, role: SpectrumRole, _: &Context) -> Built {
        make(param, role)
    }
}

fn make(param: &Param, role: SpectrumRole) -> Built {
    let (name, outside) = name_and_outside(param)?;
    let Some((_, data)) = SPECTRA.iter().find(|(n, _)| *n == name.value) else {
        return Err(vec![unknown(name, names())]);
    };
    let points = match data {
        Pairs(text) => rows(text).into_iter().map(|[l, v]| (l, v)).collect(),
        Eta(text) => rows(text).into_iter().map(|[l, n, _]| (l, n)).collect(),
        K(text) => rows(text).into_iter().map(|[l, _, k]| (l, k)).collect(),
        D65 => bhs_colour::d65(),
        Glass(_) | One => Vec::new(),
    };
    if !points.is_empty() {
        check_role(param, name.span, role, points.iter().map(|p| (p.1, format!(" at {} nm", p.0))))?;
        return Ok(Arc::new(Tabulated::new(&points, outside)));
    }
    if outside == Outside::Zero {
        let message = format!("`{}` has no end", name.value);
        let cause = "a formula, not a table: it cannot be zero outside its data";
        return Err(vec![Diagnostic::error("bad-value", message).at(param.span, cause)]);
    }
    let Some(glass) = (match data {
        Glass(row) => sellmeier(row),
        _ => None,
    }) else {
        return Ok(Arc::new(Constant(1.0)));
    };
    check_role(param, name.span, role, [(glass.index(glass.valid_nm[0]), String::new())])?;
    Ok(Arc::new(glass))
}

/// The glass called `glass` in the table of glasses.
fn sellmeier(glass: &str) -> Option<Sellmeier> {
    let row = GLASSES.lines().find_map(|line| line.strip_prefix(glass)?.strip_prefix(','))?;
    let [b1, c1, b2, c2, b3, c3, from_um, to_um, ..] = *rows::<12>(row).first()?;
    Some(Sellmeier { terms: [[b1, c1], [b2, c2], [b3, c3]], valid_nm: [from_um * 1e3, to_um * 1e3] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use bhs_core::spectrum::Spectrum;

    #[test]
    fn every_table_is_whole() {
        for (name, data) in SPECTRA {
            let (text, columns) = match data {
                Pairs(text) => (*text, 2),
                Eta(text) | K(text) => (*text, 3),
                Glass(row) => {
                    assert!(sellmeier(row).is_some(), "{name}");
                    continue;
                }
                D65 | One => continue,
            };
            // Every line that is neither comment nor heading must have been read.
            let lines = text.lines().filter(|l| l.starts_with(|c: char| c.is_ascii_digit())).count();
            let read = if columns == 2 { rows::<2>(text).len() } else { rows::<3>(text).len() };
            assert!(lines >= 4 && read == lines, "{name}: {read} of {lines}");
            if columns == 3 {
                assert!(rows::<3>(text).windows(2).all(|w| w[0][0] < w[1][0]), "{name}");
            }
        }
    }

    #[test]
    fn glasses_have_the_catalogues_index_and_abbe_number() {
        for line in GLASSES.lines().filter(|l| !l.starts_with('#') && !l.starts_with("glass")) {
            let (name, row) = line.split_once(',').expect("a row");
            let [.., nd, abbe] = rows::<12>(row)[0];
            let glass = sellmeier(name).expect("in the table");
            // Fraunhofer's lines d (He), F and C (H).
            let [d, f, c] = [587.5618, 486.1327, 656.2725].map(|l| glass.index(l));
            assert!((d - nd).abs() < 6e-6, "{name}: nd {d}, not {nd}");
            assert!(((d - 1.0) / (f - c) - abbe).abs() < 6e-3, "{name}: Vd {}", (d - 1.0) / (f - c));
            assert!(glass.max(400.0, 700.0) >= glass.at(400.0) && !glass.is_constant());
            // Below the fitted range lies a pole; the index stays at its end value.
            assert_eq!(glass.at(240.0), glass.at(glass.valid_nm[0] as f32));
        }
    }
}
