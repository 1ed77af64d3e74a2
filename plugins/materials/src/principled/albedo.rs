//! How much light facets send back in all, tabulated once for all materials.
//!
//! With Schlick's reflectance `f0 + (f90 - f0) k`, k = (1 - cos)^5, the share of the light that facets send back is `f0 A + f90 B`, where A and B depend on
//! the width of their distribution and the viewer alone (Karis 2013, "Real Shading in Unreal Engine 4"). Light that meets a second facet is lost.

use crate::fresnel;
use crate::microfacet::{Ggx, SMOOTH};
use glam::{Vec2, Vec3};
use std::sync::OnceLock;

/// Intervals in the cosine.
const COSINES: usize = 64;
/// Intervals in the root of alpha, in which shares change evenly.
const WIDTHS: usize = 16;
/// Facets that an entry is made of; a power of two.
const FACETS: u32 = 256;

/// The two shares of the light that comes back: what counts `f0` and what counts `f90`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shares {
    /// The mean of 1 - k over what is reflected.
    pub a: f32,
    /// The mean of k.
    pub b: f32,
}

impl Shares {
    fn lerp(self, other: Self, t: f32) -> Self {
        Self { a: self.a + (other.a - self.a) * t, b: self.b + (other.b - self.b) * t }
    }

    /// The share of all light, of facets with these reflectances at normal incidence and at grazing.
    pub fn of(self, f0: f32, f90: f32) -> f32 {
        f0 * self.a + f90 * self.b
    }
}

/// `(1 - cos)^5`.
pub fn schlick(cos: f32) -> f32 {
    let x = (1.0 - cos).clamp(0.0, 1.0);
    let x2 = x * x;
    x2 * x2 * x
}

/// The table: for each width the shares by cosine, and their mean over even light.
struct Table(Vec<([Shares; COSINES + 1], Shares)>);

fn table() -> &'static Table {
    static TABLE: OnceLock<Table> = OnceLock::new();
    TABLE.get_or_init(|| {
        let row = |i: usize| {
            let root = i as f32 / WIDTHS as f32;
            let shares = std::array::from_fn(|j| entry(root * root, j as f32 / COSINES as f32));
            (shares, mean(&shares))
        };
        Table((0..=WIDTHS).map(row).collect())
    })
}

fn entry(alpha: f32, cos: f32) -> Shares {
    if alpha < SMOOTH {
        let k = schlick(cos);
        return Shares { a: 1.0 - k, b: k };
    }
    let facets = Ggx { alpha: Vec2::splat(alpha) };
    let cos = cos.max(1e-4);
    let wo = Vec3::new((1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos);
    let (mut a, mut b) = (0.0, 0.0);
    for i in 0..FACETS {
        let radical_inverse = (i.reverse_bits() >> (32 - FACETS.ilog2())) as f32;
        let u = Vec2::new(i as f32 + 0.5, radical_inverse + 0.5) / FACETS as f32;
        let m = facets.sample_visible(wo, u);
        let wi = fresnel::reflect(wo, m);
        if wi.z > 0.0 {
            let (seen, k) = (facets.shadowing(wo, wi), schlick(wo.dot(m)));
            a += seen * (1.0 - k);
            b += seen * k;
        }
    }
    Shares { a: a / FACETS as f32, b: b / FACETS as f32 }
}

/// The mean over even light: 2 times the integral over the cosine, of lines between the entries.
fn mean(shares: &[Shares; COSINES + 1]) -> Shares {
    let h = 1.0 / COSINES as f32;
    let part = |of: fn(&Shares) -> f32| {
        let piece = |i: usize| {
            let (x, l, r) = (i as f32 * h, of(&shares[i]), of(&shares[i + 1]));
            // Of a line from l to r, times the cosine.
            h * (x * 0.5 * (l + r) + h * (l / 6.0 + r / 3.0))
        };
        2.0 * (0..COSINES).map(piece).sum::<f32>()
    };
    Shares { a: part(|s| s.a), b: part(|s| s.b) }
}

/// Place of an alpha among the widths.
fn width(alpha: f32) -> (usize, f32) {
    let x = alpha.clamp(0.0, 1.0).sqrt() * WIDTHS as f32;
    let i = (x as usize).min(WIDTHS - 1);
    (i, x - i as f32)
}

/// The shares of facets of the given width (0: smooth) at a cosine.
pub fn shares(alpha: f32, cos: f32) -> Shares {
    let rows = &table().0;
    let (i, t) = width(alpha);
    let x = cos.clamp(0.0, 1.0) * COSINES as f32;
    let j = (x as usize).min(COSINES - 1);
    let at = |row: usize| rows[row].0[j].lerp(rows[row].0[j + 1], x - j as f32);
    at(i).lerp(at(i + 1), t)
}

/// The mean of the shares over even light.
pub fn mean_shares(alpha: f32) -> Shares {
    let rows = &table().0;
    let (i, t) = width(alpha);
    rows[i].1.lerp(rows[i + 1].1, t)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smooth_surfaces_have_closed_forms_and_all_light_is_one_share_or_the_other() {
        for cos in [0.0, 0.25, 0.5, 1.0] {
            let s = shares(0.0, cos);
            assert!((s.b - schlick(cos)).abs() < 1e-6 && (s.a + s.b - 1.0).abs() < 1e-6);
        }
        // 2 int (1 - c)^5 c dc = 2 / (6 * 7); the table's lines lie above the curve by h^2/12 of the change of its slope.
        assert!((mean_shares(0.0).b - 1.0 / 21.0).abs() < 3e-4, "{:?}", mean_shares(0.0));
        for alpha in [0.01, 0.1, 0.5, 1.0] {
            for cos in [0.05, 0.3, 1.0] {
                let s = shares(alpha, cos);
                assert!(s.a >= 0.0 && s.b >= 0.0 && s.of(1.0, 1.0) <= 1.0 + 1e-5, "{alpha} {cos}: {s:?}");
            }
        }
    }
}
