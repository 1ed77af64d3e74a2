//! Rough surfaces as many small mirrors.
//!
//! The distribution of Trowbridge and Reitz 1975 ("GGX", Walter et al. 2007), stretched along the two tangents of the shading frame (Heitz 2014,
//! "Understanding the Masking-Shadowing Function", eq. 85). Masking and shadowing are Smith's, correlated by height (eq. 99 there); facets
//! are drawn from those that the viewer sees (Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps"). Directions have z
//! along the macroscopic normal and z >= 0.

use bhs_elementary::Elementary;
use glam::{Vec2, Vec3};
use std::f32::consts::PI;

/// Below this alpha a surface counts as smooth (as in pbrt-v4).
pub const SMOOTH: f32 = 1e-3;

/// Width of the distribution of facets for a roughness between 0 and 1: its square root, as in pbrt-v4.
pub fn alpha_of_roughness(roughness: f32) -> f32 {
    roughness.sqrt()
}

/// The distribution of facets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ggx {
    /// Widths along x and y: the tangents of the angles at which the density of facet slopes has fallen to a quarter of its peak.
    pub alpha: Vec2,
}

impl Ggx {
    /// Facets as wide along both tangents.
    pub const fn isotropic(alpha: f32) -> Self {
        Self { alpha: Vec2::splat(alpha) }
    }

    /// The width of isotropic facets whose slopes spread over as large an area.
    pub fn mean_alpha(self) -> f32 {
        if self.is_isotropic() { self.alpha.x } else { (self.alpha.x * self.alpha.y).sqrt() }
    }

    /// Whether they are as wide along both tangents.
    pub fn is_isotropic(self) -> bool {
        self.alpha.x == self.alpha.y
    }

    /// Density of facets with unit normal `m` (1/sr), whose areas projected on the surface add up to its own.
    pub fn density(self, m: Vec3) -> f32 {
        let Vec2 { x: ax, y: ay } = self.alpha;
        // sin^2 from x and y, not from 1 - z^2, which cancels where the density peaks.
        let d = m.x * m.x * (ay / ax) + m.y * m.y * (ax / ay) + ax * ay * (m.z * m.z);
        ax * ay / (PI * d * d)
    }

    /// The length of a direction whose x and y are scaled by alpha: with it Smith's Lambda is `(r/z - 1)/2`. The forms below need no
    /// Lambda, so that grazing directions divide by nothing small.
    fn r(self, w: Vec3) -> f32 {
        let a2 = self.alpha * self.alpha;
        (w.z * w.z + a2.x * (w.x * w.x) + a2.y * (w.y * w.y)).sqrt()
    }

    /// Share of the facets facing `w` that `w` sees (Smith's G1 = 1/(1 + Lambda)), over the cosine of `w`.
    pub fn masking_per_cos(self, w: Vec3) -> f32 {
        2.0 / (w.z + self.r(w))
    }

    /// Share of the facets seen by `wo` that `wi` sees too (G2/G1, with G2 = 1/(1 + Lambda(wo) + Lambda(wi))).
    pub fn shadowing(self, wo: Vec3, wi: Vec3) -> f32 {
        let (ro, ri) = (self.r(wo), self.r(wi));
        wi.z * (wo.z + ro) / (wi.z * ro + wo.z * ri)
    }

    /// Density of the facet normals that [`Ggx::sample_visible`] draws (1/sr).
    pub fn visible_density(self, wo: Vec3, m: Vec3) -> f32 {
        self.masking_per_cos(wo) * self.density(m) * wo.dot(m).max(0.0)
    }

    /// Draws the normal of a facet that `wo` (z > 0) sees, with `u` from the unit square.
    pub fn sample_visible(self, wo: Vec3, u: Vec2) -> Vec3 {
        // Stretched, the facets are those of a hemisphere; the normals that reflect `wo` upwards form a spherical cap.
        let stretched = Vec3::new(self.alpha.x * wo.x, self.alpha.y * wo.y, wo.z).normalize();
        let z = (1.0 - u.y) * (1.0 + stretched.z) - stretched.z;
        let r = (1.0 - z * z).max(0.0).sqrt();
        let (sin, cos) = (2.0 * PI * u.x).sine_cosine();
        let h = Vec3::new(r * cos, r * sin, z) + stretched;
        Vec3::new(self.alpha.x * h.x, self.alpha.y * h.y, h.z.max(0.0)).try_normalize().unwrap_or(Vec3::Z)
    }

    /// Density of the directions in which the facets that `wo` sees mirror it (1/sr), where their normal is `m`: that of the normals
    /// times |d m / d wi| = 1 / (4 wo . m).
    pub fn mirrored_density(self, wo: Vec3, m: Vec3) -> f32 {
        self.masking_per_cos(wo) * self.density(m) / 4.0
    }
}
