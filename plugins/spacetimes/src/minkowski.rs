//! `minkowski`: flat space, where light moves along straight lines.

use bhs_core::Plugin;
use bhs_core::params::Params;
use bhs_core::spacetime::{Minkowski, Spacetime};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Spacetime> =
    Plugin { name: "minkowski", summary: "flat space, where light moves along straight lines", build };

fn build(_: &Params) -> Option<Box<dyn Spacetime>> {
    Some(Box::new(Minkowski::default()))
}
