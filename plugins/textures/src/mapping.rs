//! Where on a texture a point of a surface lies.

use bhs_core::diagnostics::{Diagnostic, did_you_mean};
use bhs_core::material::Shading;
use bhs_core::params::Params;
use glam::Vec2;

/// `(s, t) = (uscale u + udelta, vscale v + vdelta)`, as pbrt-v4's mapping "uv", turned by `rotate` in between.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvMapping {
    scale: Vec2,
    /// Sine and cosine of an angle.
    turn: Vec2,
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
        let scale = Vec2::new(number("uscale", 1.0, "factor of u"), number("vscale", 1.0, "factor of v"));
        let about = "by which texture coordinates are turned around (0, 0), once they are scaled";
        let angle = p.get_in("rotate", 0.0, -LARGEST..=LARGEST, "deg", about);
        let (sin, cos) = angle.to_radians().sin_cos();
        Self {
            scale,
            turn: if angle == 0.0 { Vec2::Y } else { Vec2::new(sin as f32, cos as f32) },
            delta: Vec2::new(number("udelta", 0.0, "added to u"), number("vdelta", 0.0, "added to v")),
        }
    }

    /// How many units of s go once around, if they are a whole number: what repeats after them has no seam.
    pub fn turns(&self) -> Option<i64> {
        let turns = self.scale.x;
        (self.turn == Vec2::Y && (1.0..=1e6).contains(&turns) && turns.fract() == 0.0).then_some(turns as i64)
    }

    /// The place of a point.
    #[inline]
    pub fn place(&self, at: &Shading) -> Vec2 {
        let Vec2 { x: sin, y: cos } = self.turn;
        let p = at.uv * self.scale;
        Vec2::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y) + self.delta
    }
}
