//! Where on a texture a point of a surface lies.

use bhs_core::diagnostics::{Diagnostic, did_you_mean};
use bhs_core::material::Shading;
use bhs_core::params::Params;
use glam::Vec2;

/// `(s, t) = (uscale u + udelta, vscale v + vdelta)`, as pbrt-v4's mapping "uv".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvMapping {
    scale: Vec2,
    delta: Vec2,
}

/// The largest factor and offset: numbers of texels stay whole numbers of 64 bits.
const LARGEST: f64 = 1e9;

impl UvMapping {
    /// Reads the parameters of the mapping.
    pub fn read(p: &Params) -> Self {
        let name = p.get("mapping", "uv".to_owned(), "", "how a point is placed: `uv`, by texture coordinates");
        if name != "uv" {
            let message = format!("unknown mapping `{name}`");
            let help = match name.as_str() {
                "spherical" | "cylindrical" | "planar" => "this mapping is not supported yet; there is \"uv\"",
                _ if did_you_mean(&name, ["uv"]).is_some() => "did you mean `uv`?",
                _ => "there is \"uv\"",
            };
            p.report(Diagnostic::error("bad-value", message).at(p.span_of("mapping"), "").help(help));
        }
        let number = |name, default, about| p.get_in(name, default, -LARGEST..=LARGEST, "", about) as f32;
        Self {
            scale: Vec2::new(number("uscale", 1.0, "factor of u"), number("vscale", 1.0, "factor of v")),
            delta: Vec2::new(number("udelta", 0.0, "added to u"), number("vdelta", 0.0, "added to v")),
        }
    }

    /// How many units of s go once around, if they are a whole number: what repeats after them has no seam.
    pub fn turns(&self) -> Option<i64> {
        let turns = self.scale.x;
        ((1.0..=1e6).contains(&turns) && turns.fract() == 0.0).then_some(turns as i64)
    }

    /// The place of a point.
    #[inline]
    pub fn place(&self, at: &Shading) -> Vec2 {
        at.uv * self.scale + self.delta
    }
}
