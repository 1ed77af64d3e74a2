//! How much light a clear coat lets through, and how much it sends back: what a coated surface needs to know of its coat.
//!
//! For a smooth coat the shares are those of Fresnel; for a rough one they are integrals over the facets, tabulated once.

use crate::fresnel;
use crate::microfacet::Ggx;
use crate::rough_interface::Interface;
use bhs_core::sampling::cosine_hemisphere;
use bhs_elementary::Elementary;
use glam::{Vec2, Vec3};

/// Intervals of the tables, in the cosine.
const INTERVALS: usize = 64;
/// Facets that an entry of the tables is made of.
const FACETS: u32 = 1024;
/// Directions that an integral over all of them is made of.
const DIRECTIONS: u32 = 8192;

/// A coat of refractive index `eta` over a surface without one.
pub struct Coat {
    eta: f32,
    thickness: f32,
    /// Shares that are reflected, and that get through, by cosine outside; of a rough coat.
    rough: Option<Vec<[f32; 2]>>,
    /// Of the light that a matt ground sends up evenly, the share that comes back to it.
    pub back: f32,
    /// Mean of [`Coat::through`] over directions of even light from outside.
    pub mean_through: f32,
}

impl Coat {
    /// A coat with index `eta` over the outside, of a thickness of which light that crosses it straight keeps exp(-thickness), as in
    /// pbrt-v4; `facets`: of its surface, `None` for a smooth one.
    pub fn new(eta: f32, facets: Option<Ggx>, thickness: f32) -> Self {
        let mut coat = Self { eta, thickness, rough: None, back: 0.0, mean_through: 0.0 };
        if let Some(facets) = facets {
            let interface = Interface { eta, facets };
            let row = |i: usize| {
                let cos = (i as f32 / INTERVALS as f32).max(1e-4);
                let wo = Vec3::new((1.0 - cos * cos).sqrt(), 0.0, cos);
                let mut sums = [0.0; 2];
                for u in points(FACETS) {
                    let (reflected, through) = coat.facet(interface, wo, u);
                    sums[0] += reflected;
                    sums[1] += through;
                }
                sums.map(|s| (s / f64::from(FACETS)) as f32)
            };
            coat.rough = Some((0..=INTERVALS).map(row).collect());
        }
        let mut back = 0.0;
        for i in 0..DIRECTIONS {
            // Even light from below meets a facet: four numbers, by the additive sequence of Roberts 2018 (powers of 1/1.1673, the
            // root of x^5 = x + 1).
            let [a, b, c, d] = [0.856_674_883_854_503, 0.733_891_856_627_126, 0.628_706_721_038_09, 0.538_597_258_573_97]
                .map(|step: f64| (0.5 + f64::from(i) * step).fract() as f32);
            let wo = -cosine_hemisphere(Vec2::new(a, b));
            let on_the_way_up = f64::from(coat.crossing(-wo.z));
            back += on_the_way_up
                * match facets {
                    Some(facets) => coat.facet(Interface { eta, facets }, wo, Vec2::new(c, d)).0,
                    None => f64::from(fresnel::dielectric(-wo.z, 1.0 / eta).0 * coat.crossing(-wo.z)),
                };
        }
        coat.back = (back / f64::from(DIRECTIONS)) as f32;
        let even = points(DIRECTIONS).map(|u| f64::from(coat.through(cosine_hemisphere(u).z))).sum::<f64>();
        coat.mean_through = (even / f64::from(DIRECTIONS)) as f32;
        coat
    }

    /// What is left of light that crosses the coat at the cosine `cos` inside.
    fn crossing(&self, cos: f32) -> f32 {
        (-self.thickness / cos.max(1e-6)).exponential()
    }

    /// The shares of one facet in what is reflected and what gets through; light inside crosses the coat once more.
    fn facet(&self, interface: Interface, wo: Vec3, u: Vec2) -> (f64, f64) {
        let up = Vec3::new(wo.x, wo.y, wo.z.abs());
        let m = interface.facets.sample_visible(up, u);
        let (mirrored, refracted, share) = interface.facet(wo, m);
        let part = |wi: Option<Vec3>, share: f32| {
            wi.map_or(0.0, |wi| {
                let inside = if wi.z < 0.0 { self.crossing(-wi.z) } else { 1.0 };
                let wi = Vec3::new(wi.x, wi.y, wi.z.abs());
                f64::from(share * interface.facets.shadowing(up, wi) * inside)
            })
        };
        (part(mirrored, share), part(refracted, 1.0 - share))
    }

    fn look_up(table: &[[f32; 2]], cos: f32, column: usize) -> f32 {
        let x = cos.clamp(0.0, 1.0) * INTERVALS as f32;
        let i = (x as usize).min(INTERVALS - 1);
        let t = x - i as f32;
        table[i][column] * (1.0 - t) + table[i + 1][column] * t
    }

    /// The share of light from outside, at the cosine `cos`, that the coat's surface reflects.
    pub fn reflected(&self, cos: f32) -> f32 {
        match &self.rough {
            Some(table) => Self::look_up(table, cos, 0),
            None => fresnel::dielectric(cos.min(1.0), self.eta).0,
        }
    }

    /// The share of it that arrives at the ground.
    pub fn through(&self, cos: f32) -> f32 {
        match &self.rough {
            Some(table) => Self::look_up(table, cos, 1),
            None => {
                let (reflected, cos_t) = fresnel::dielectric(cos.min(1.0), self.eta);
                (1.0 - reflected) * self.crossing(cos_t)
            }
        }
    }
}

/// Points spread evenly over the unit square (Hammersley's); `n` is a power of two.
fn points(n: u32) -> impl Iterator<Item = Vec2> {
    (0..n).map(move |i| {
        let radical_inverse = (i.reverse_bits() >> (32 - n.ilog2())) as f32;
        Vec2::new(i as f32 + 0.5, radical_inverse + 0.5) / n as f32
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_much_light_gets_out_of_a_clear_coat_as_gets_in() {
        // Even light: what passes from outside, over the square of the index, is what the ground's light does not lose by reflection.
        for eta in [0.1, 0.2, 0.5, 0.9, 1.1, 1.5, 4.0, 10.0] {
            let coat = Coat::new(eta, None, 0.0);
            let (inwards, outwards) = (coat.mean_through / (eta * eta), 1.0 - coat.back);
            assert!((inwards / outwards - 1.0).abs() < 0.05, "{eta}: {inwards} {outwards}");
        }
    }
}
