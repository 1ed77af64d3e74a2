//! `box`: every point within the radius counts the same.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `xradius` | float | 0.5 | pixels | half width |
//! | `yradius` | float | 0.5 | pixels | half height |
//!
//! ```bhs
//! PixelFilter "box"
//! WorldBegin
//! ```

use crate::radii;
use bhs_core::Plugin;
use bhs_core::camera::Filter;
use bhs_core::params::Params;
use glam::{DVec2, Vec2};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Filter> = Plugin { name: "box", summary: "every point within the radius counts the same", build };

struct BoxFilter {
    radius: Vec2,
}

fn build(p: &Params) -> Option<Box<dyn Filter>> {
    let [x, y] = radii(p, 0.5);
    Some(Box::new(BoxFilter { radius: Vec2::new(x as f32, y as f32) }))
}

impl Filter for BoxFilter {
    fn radius(&self) -> DVec2 {
        self.radius.as_dvec2()
    }

    fn value(&self, offset: DVec2) -> f64 {
        // Each point between two pixels belongs to one of them.
        let radius = Filter::radius(self);
        if offset.cmpge(-radius).all() && offset.cmplt(radius).all() { 1.0 } else { 0.0 }
    }

    fn sample(&self, u: Vec2) -> (Vec2, f32) {
        ((2.0 * u - 1.0) * self.radius, 1.0)
    }
}
