//! `triangle`: falls off in a straight line from the middle to the radius.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `xradius` | float | 2 | pixels | half width |
//! | `yradius` | float | 2 | pixels | half height |
//!
//! ```bhs
//! PixelFilter "triangle" "float xradius" 1 "float yradius" 1
//! WorldBegin
//! ```

use crate::radii;
use bhs_core::Plugin;
use bhs_core::camera::Filter;
use bhs_core::params::Params;
use glam::{DVec2, Vec2};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Filter> =
    Plugin { name: "triangle", summary: "falls off in a straight line from the middle to the radius", build };

struct Triangle {
    radius: Vec2,
}

fn build(p: &Params) -> Option<Box<dyn Filter>> {
    let [x, y] = radii(p, 2.0);
    Some(Box::new(Triangle { radius: Vec2::new(x as f32, y as f32) }))
}

/// A number between -1 and 1 with the density 1 - |x|, from one in [0,1).
fn tent(u: f32) -> f32 {
    if u < 0.5 { (2.0 * u).sqrt() - 1.0 } else { 1.0 - (2.0 * (1.0 - u)).sqrt() }
}

impl Filter for Triangle {
    fn radius(&self) -> DVec2 {
        self.radius.as_dvec2()
    }

    fn value(&self, offset: DVec2) -> f64 {
        let fall = (1.0 - offset.abs() / Filter::radius(self)).max(DVec2::ZERO);
        fall.x * fall.y
    }

    fn sample(&self, u: Vec2) -> (Vec2, f32) {
        (Vec2::new(tent(u.x), tent(u.y)) * self.radius, 1.0)
    }
}
