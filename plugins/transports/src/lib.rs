//! Light transport. One file, one plugin.

mod bounce;
mod caustics;
mod guide;
mod hemisphere;
mod normals;
mod path;
mod path_state;
mod shadow_rays;
mod warp;

use bhs_core::Plugin;
use bhs_engine::transport::LightTransport;

/// All methods of light transport, by name.
pub const ALL: &[Plugin<dyn LightTransport>] = &[hemisphere::PLUGIN, normals::PLUGIN, path::PLUGIN];

#[cfg(test)]
mod tests {
    bhs_core::every_file_is_listed!([super::ALL], helpers: ["bounce", "caustics", "guide", "path_state", "shadow_rays", "warp"]);
}
