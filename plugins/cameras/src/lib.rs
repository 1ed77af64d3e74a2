//! Cameras. One file, one plugin.

mod orthographic;
mod perspective;
mod screen;
mod spherical;

use bhs_core::Plugin;
use bhs_core::camera::Camera;

/// All cameras, by name.
pub const ALL: &[Plugin<dyn Camera>] = &[orthographic::PLUGIN, perspective::PLUGIN, spherical::PLUGIN];

#[cfg(test)]
mod tests {
    bhs_core::every_file_is_listed!([super::ALL], helpers: ["screen"]);
}
