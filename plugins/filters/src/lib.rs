//! Pixel reconstruction filters. One file, one plugin.

#[path = "box.rs"]
mod box_filter;

use bhs_core::Plugin;
use bhs_core::camera::Filter;

/// All filters, by name.
pub const ALL: &[Plugin<dyn Filter>] = &[box_filter::PLUGIN];

#[cfg(test)]
mod tests {
    bhs_core::every_file_is_listed!([super::ALL], helpers: []);
}
