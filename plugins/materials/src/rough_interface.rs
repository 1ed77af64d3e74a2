//! A rough boundary between two dielectrics: facets that reflect and refract.
//!
//! Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", eqs. (16), (17), (20) and (21), with facets drawn
//! from those that the viewer sees and masking correlated by height, as in pbrt-v4. Light that meets a second facet is lost.

use crate::fresnel;
use crate::microfacet::Ggx;
use glam::Vec3;

/// The boundary. Directions are in the shading frame; the outside is where z > 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// Refractive index of the inside over that of the outside.
    pub eta: f32,
    /// The distribution of facets.
    pub facets: Ggx,
}

impl Interface {
    /// The index beyond the surface over that on the side of `wo`.
    fn relative_index(self, wo: Vec3) -> f32 {
        if wo.z >= 0.0 { self.eta } else { 1.0 / self.eta }
    }

    /// The BSDF times |cos(theta_i)|, and the density with which [`Interface::sample`] chooses `wi` (1/sr).
    pub fn evaluate(self, wo: Vec3, wi: Vec3) -> (f32, f32) {
        let eta = self.relative_index(wo);
        // Seen from the side of `wo`.
        let side = Vec3::new(1.0, 1.0, wo.z.signum());
        let (wo, wi) = (wo * side, wi * side);
        if wo.z == 0.0 || wi.z == 0.0 {
            return (0.0, 0.0);
        }
        if wi.z > 0.0 {
            let Some(m) = (wo + wi).try_normalize() else { return (0.0, 0.0) };
            let (reflected, _) = fresnel::dielectric(wo.dot(m).clamp(0.0, 1.0), eta);
            let density = reflected * self.facets.mirrored_density(wo, m);
            return (density * self.facets.shadowing(wo, wi), density);
        }
        let Some(m) = (wo + wi * eta).try_normalize() else { return (0.0, 0.0) };
        let m = if m.z < 0.0 { -m } else { m };
        let (cos_o, cos_i) = (wo.dot(m), wi.dot(m));
        // A facet refracts from one of its sides to the other.
        if cos_o <= 0.0 || cos_i >= 0.0 {
            return (0.0, 0.0);
        }
        let (reflected, _) = fresnel::dielectric(cos_o.min(1.0), eta);
        let across = cos_i + cos_o / eta;
        let density = (1.0 - reflected) * self.facets.visible_density(wo, m) * -cos_i / (across * across);
        if !density.is_finite() {
            return (0.0, 0.0);
        }
        let beyond = Vec3::new(wi.x, wi.y, -wi.z);
        (density * self.facets.shadowing(wo, beyond) / (eta * eta), density)
    }

    /// Where the facet with normal `m` (seen from the side of `wo`, as `sample_visible` draws it) sends light: the mirrored and the
    /// refracted direction, each if it leads away from the surface on its side, and the reflected share.
    pub fn facet(self, wo: Vec3, m: Vec3) -> (Option<Vec3>, Option<Vec3>, f32) {
        let eta = self.relative_index(wo);
        let side = Vec3::new(1.0, 1.0, wo.z.signum());
        let up = wo * side;
        let cos_o = up.dot(m).clamp(0.0, 1.0);
        let (reflected, cos_t) = fresnel::dielectric(cos_o, eta);
        let mirrored = fresnel::reflect(up, m);
        let refracted = ((cos_o / eta - cos_t) * m - up / eta).normalize();
        (
            (mirrored.z > 0.0).then_some(mirrored * side),
            (refracted.z < 0.0 && reflected < 1.0).then_some(refracted * side),
            reflected,
        )
    }

    /// Chooses a direction.
    pub fn sample(self, wo: Vec3, choice: f32, u: glam::Vec2) -> Option<Vec3> {
        if wo.z == 0.0 {
            return None;
        }
        let m = self.facets.sample_visible(Vec3::new(wo.x, wo.y, wo.z.abs()), u);
        let (mirrored, refracted, share) = self.facet(wo, m);
        if choice < share { mirrored } else { refracted }
    }
}
