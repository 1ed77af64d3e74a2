//! `table`: pairs of wavelength and value, joined by straight lines.
//!
//! Wavelengths do not decrease. Outside the data the table keeps its end value. Two pairs at the same wavelength make a step,
//! so a table that ends with a step to zero is zero outside: `[400 0  400 0.5  700 0.5  700 0]`.
//!
//! | values | type | unit | meaning |
//! |---|---|---|---|
//! | pairs of numbers | `spectrum` | nm, and that of the parameter | wavelength and value, in turn |
//!
//! ```bhs
//! Material "diffuse" "spectrum reflectance" [400 0.1  500 0.8  700 0.9]
//! ```

use crate::file::unit_fault;
use crate::tabulated::{Outside, Tabulated};
use crate::{Built, Maker, check_role, numbers, wrong_value};
use bhs_core::Plugin;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::params::{Context, SpectrumMaker};
use bhs_core::spectrum::SpectrumRole;
use bhs_core::value::Param;
use std::sync::Arc;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn SpectrumMaker> = Plugin {
    name: "table",
    summary: "pairs of wavelength [nm] and value, joined by straight lines",
    build: |_| Some(Box::new(Maker(make))),
};

fn make(param: &Param, role: SpectrumRole, context: &Context) -> Built {
    let (pairs, rest) = numbers(param).as_chunks::<2>();
    if pairs.is_empty() || !rest.is_empty() {
        return Err(vec![wrong_value(param, "one number, or pairs of wavelength [nm] and value")]);
    }
    let points: Vec<(f64, f64)> = pairs.iter().map(|[l, v]| (*l, *v)).collect();
    let bad = |message: String, cause: &str| Err(vec![Diagnostic::error("bad-value", message).at(param.span, cause)]);
    let name = &param.name.value;
    if let Some((l, _)) = points.iter().find(|p| p.0 <= 0.0) {
        return bad(format!("`{name}` has a value at {l} nm"), "a wavelength is greater than 0");
    }
    if let Some(w) = points.windows(2).find(|w| w[1].0 < w[0].0) {
        return bad(format!("`{name}` has {} nm after {} nm", w[1].0, w[0].0), "wavelengths must increase");
    }
    if let Some(w) = points.windows(3).find(|w| w[2].0 == w[0].0) {
        return bad(format!("`{name}` has three values at {} nm", w[0].0), "two make a step, a third has no meaning");
    }
    let [lo, hi] = context.lambda_range;
    if let Some(fault) = unit_fault([points[0].0, points[points.len() - 1].0], [lo, hi].map(f64::from)) {
        let help = "wavelengths are in nm: green light has 550";
        return Err(vec![Diagnostic::error("other-unit", format!("`{name}`: its {fault}")).at(param.span, "").help(help)]);
    }
    check_role(param, param.span, role, points.iter().map(|p| (p.1, format!(" at {} nm", p.0))))?;
    Ok(Arc::new(Tabulated::new(&points, Outside::EndValue)))
}
