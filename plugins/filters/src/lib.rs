//! Pixel reconstruction filters. One file, one plugin.
//!
//! Samples go where a filter is large, by importance, so that each sample touches its own pixel only (Ernst, Stamminger and Greiner 2006).

#[path = "box.rs"]
mod box_filter;
mod gaussian;
mod mitchell;
mod separable;
mod sinc;
mod triangle;

use bhs_core::Plugin;
use bhs_core::camera::Filter;
use bhs_core::params::Params;

/// All filters, by name.
pub const ALL: &[Plugin<dyn Filter>] = &[box_filter::PLUGIN, gaussian::PLUGIN, mitchell::PLUGIN, sinc::PLUGIN, triangle::PLUGIN];

/// What all filters take: half width and half height (pixels).
fn radii(p: &Params, default: f64) -> [f64; 2] {
    let x = p.get_in("xradius", default, 1e-3..=64.0, "pixels", "half width");
    let y = p.get_in("yradius", default, 1e-3..=64.0, "pixels", "half height");
    [x, y]
}

#[cfg(test)]
mod tests {
    bhs_core::every_file_is_listed!([super::ALL], helpers: ["separable"]);
}
