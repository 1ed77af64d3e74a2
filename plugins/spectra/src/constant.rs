//! `constant`: the same value at all wavelengths.
//!
//! A reflectance lies between 0 and 1, emission and other values are not negative.
//!
//! | values | type | unit | meaning |
//! |---|---|---|---|
//! | one number | `float` or `spectrum` | that of the parameter | the value |
//!
//! ```bhs
//! Material "diffuse" "spectrum reflectance" 0.5
//! ```

use crate::{Built, Maker, check_role, numbers, wrong_value};
use bhs_core::Plugin;
use bhs_core::params::{Constant, Context, SpectrumMaker};
use bhs_core::spectrum::SpectrumRole;
use bhs_core::value::Param;
use std::sync::Arc;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn SpectrumMaker> =
    Plugin { name: "constant", summary: "the same value at all wavelengths", build: |_| Some(Box::new(Maker(make))) };

fn make(param: &Param, role: SpectrumRole, _: &Context) -> Built {
    let [value] = numbers(param) else {
        return Err(vec![wrong_value(param, "one number")]);
    };
    check_role(param, param.span, role, [(*value, String::new())])?;
    Ok(Arc::new(Constant(*value as f32)))
}
