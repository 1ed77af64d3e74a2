//! The four ways in which light leaves the surface at a point: by the coat, by the facets, from the ground below, through the body.

use super::albedo::{self, Shares, schlick};
use crate::fresnel;
use crate::microfacet::Ggx;
use crate::rough_interface::Interface;
use bhs_core::material::BsdfSample;
use bhs_core::sampling::{ONE_MINUS_EPSILON, cosine_hemisphere};
use bhs_core::spectrum::SampledSpectrum;
use glam::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Reflectance of a clear coat at normal incidence, as glTF has it: that of an index of 1.5.
const COAT_F0: f32 = 0.04;

/// The parameters at a point.
pub struct Lobes {
    /// Base colour.
    pub base: SampledSpectrum,
    /// Shares of the metal, of the body that light passes through, and of the coat.
    pub metallic: f32,
    pub transmission: f32,
    pub coat: f32,
    /// Width of the facets, below and of the coat; `None`: smooth.
    pub facets: Option<Ggx>,
    pub coat_facets: Option<Ggx>,
    /// Reflectance of what is no metal, at normal incidence and at grazing.
    pub f0: f32,
    pub f90: f32,
    /// Refractive index of the inside over that of the outside.
    pub eta: f32,
    /// Whether the body is a sheet, through which light goes straight on.
    pub thin: bool,
}

/// What a viewer sees of the lobes: the shares that they take of the samples, and what the coat lets through.
struct View {
    /// Of the coat, the facets, the ground, the body; they add up to 1.
    chances: [f32; 4],
    through_coat: f32,
    facets: Shares,
}

fn alpha(facets: Option<Ggx>) -> f32 {
    facets.map_or(0.0, |f| f.alpha.x)
}

fn flipped(w: Vec3) -> Vec3 {
    Vec3::new(w.x, w.y, -w.z)
}

impl Lobes {
    /// Share of the ground and the facets of what is no metal and no clear body.
    fn opaque(&self) -> f32 {
        (1.0 - self.metallic) * (1.0 - self.transmission)
    }

    fn body(&self) -> f32 {
        (1.0 - self.metallic) * self.transmission
    }

    /// The share of light at a cosine that passes the coat.
    fn through_coat(&self, cos: f32) -> f32 {
        1.0 - self.coat * albedo::shares(alpha(self.coat_facets), cos).of(COAT_F0, 1.0)
    }

    /// Reflectance of a facet at a cosine.
    fn fresnel(&self, cos: f32) -> SampledSpectrum {
        let k = schlick(cos);
        let dielectric = self.opaque() * (self.f0 + (self.f90 - self.f0) * k);
        self.base.map(|base| dielectric + self.metallic * (base + (1.0 - base) * k))
    }

    /// What the facets reflect in all.
    fn reflected(&self, s: Shares) -> SampledSpectrum {
        let dielectric = self.opaque() * s.of(self.f0, self.f90);
        self.base.map(|base| dielectric + self.metallic * s.of(base, 1.0))
    }

    /// The share of light that passes the facets to the ground.
    fn to_ground(&self, s: Shares) -> f32 {
        (1.0 - s.of(self.f0, self.f90)).max(0.0)
    }

    fn view(&self, cos_o: f32) -> Option<View> {
        let facets = albedo::shares(alpha(self.facets), cos_o);
        let through_coat = self.through_coat(cos_o);
        let (by_facets, to_ground) = (self.reflected(facets).mean(), self.to_ground(facets));
        let colour = self.base.mean();
        let shares = [
            1.0 - through_coat,
            through_coat * by_facets,
            through_coat * self.opaque() * to_ground * colour,
            through_coat * self.body() * (1.0 - to_ground + to_ground * colour),
        ];
        let sum: f32 = shares.iter().sum();
        (sum > 0.0).then(|| View { chances: shares.map(|s| s / sum), through_coat, facets })
    }

    /// The share of light that is sent towards a viewer: exact of what is opaque and has no coat.
    pub fn whole(&self, cos_o: f32) -> Option<SampledSpectrum> {
        if self.coat > 0.0 || self.body() > 0.0 {
            return None;
        }
        let s = albedo::shares(alpha(self.facets), cos_o);
        Some(self.reflected(s) + self.base * (self.opaque() * self.to_ground(s)))
    }

    /// The BSDF times |cos(theta_i)| and the density of `wi`, but for what smooth surfaces do. `up`: both directions seen from the side of `wo`.
    pub fn evaluate(&self, wo: Vec3, wi: Vec3) -> (SampledSpectrum, f32) {
        let side = Vec3::new(1.0, 1.0, wo.z.signum());
        let (up, to) = (wo * side, wi * side);
        match self.view(up.z) {
            Some(view) if up.z > 0.0 && to.z != 0.0 => self.both(&view, (wo, wi), up, to),
            _ => (SampledSpectrum::ZERO, 0.0),
        }
    }

    fn both(&self, view: &View, (wo, wi): (Vec3, Vec3), up: Vec3, to: Vec3) -> (SampledSpectrum, f32) {
        let [by_coat, by_facets, by_ground, by_body] = view.chances;
        let (mut value, mut pdf) = (SampledSpectrum::ZERO, 0.0);
        let below_coat = view.through_coat * self.through_coat(to.z.abs());
        let half = (up + to).try_normalize().filter(|_| to.z > 0.0);
        if let (Some(m), Some(facets)) = (half, self.coat_facets.filter(|_| self.coat > 0.0)) {
            let density = facets.mirrored_density(up, m);
            let reflectance = self.coat * (COAT_F0 + (1.0 - COAT_F0) * schlick(up.dot(m)));
            value += SampledSpectrum::splat(reflectance * density * facets.shadowing(up, to));
            pdf += by_coat * density;
        }
        if let (Some(m), Some(facets)) = (half, self.facets) {
            let density = facets.mirrored_density(up, m);
            value += self.fresnel(up.dot(m)) * (below_coat * density * facets.shadowing(up, to));
            pdf += by_facets * density;
        }
        if to.z > 0.0 {
            let width = alpha(self.facets);
            let ways = self.to_ground(view.facets) * self.to_ground(albedo::shares(width, to.z));
            let even = self.to_ground(albedo::mean_shares(width)).max(f32::MIN_POSITIVE);
            value += self.base * (below_coat * self.opaque() * ways / even * to.z * FRAC_1_PI);
            pdf += by_ground * to.z * FRAC_1_PI;
        }
        if let (Some(facets), true) = (self.facets, by_body > 0.0) {
            let (through, density) = self.through_body(facets, (wo, wi), up, to);
            value += through * (below_coat * self.body());
            pdf += by_body * density;
        }
        (value, pdf)
    }

    /// What a rough clear body does, as [`Lobes::evaluate`].
    fn through_body(&self, facets: Ggx, (wo, wi): (Vec3, Vec3), up: Vec3, to: Vec3) -> (SampledSpectrum, f32) {
        if !self.thin {
            let (value, pdf) = Interface { eta: self.eta, facets }.evaluate(wo, wi);
            return (if to.z < 0.0 { self.tint() * value } else { SampledSpectrum::splat(value) }, pdf);
        }
        let beyond = if to.z < 0.0 { flipped(to) } else { to };
        let Some(m) = (up + beyond).try_normalize() else { return (SampledSpectrum::ZERO, 0.0) };
        let reflected = self.sheet_reflectance(up.dot(m));
        let density = facets.mirrored_density(up, m);
        let value = density * facets.shadowing(up, beyond);
        match to.z > 0.0 {
            true => (SampledSpectrum::splat(reflected * value), reflected * density),
            false => (self.base * ((1.0 - reflected) * value), (1.0 - reflected) * density),
        }
    }

    fn sheet_reflectance(&self, cos: f32) -> f32 {
        self.f0 + (self.f90 - self.f0) * schlick(cos)
    }

    /// What each of the two surfaces that light crosses takes of the colour.
    fn tint(&self) -> SampledSpectrum {
        self.base.map(f32::sqrt)
    }

    /// Chooses a direction.
    pub fn sample(&self, wo: Vec3, choice: f32, u: Vec2) -> Option<BsdfSample> {
        let side = Vec3::new(1.0, 1.0, wo.z.signum());
        let up = wo * side;
        let view = self.view(up.z).filter(|_| up.z > 0.0)?;
        let (mut lobe, mut choice) = (0, choice);
        while lobe < 3 && choice >= view.chances[lobe] {
            choice -= view.chances[lobe];
            lobe += 1;
        }
        let chance = view.chances[lobe];
        if chance <= 0.0 {
            return None;
        }
        let choice = (choice / chance).clamp(0.0, ONE_MINUS_EPSILON);
        let mirror = Vec3::new(-up.x, -up.y, up.z);
        let below_coat = view.through_coat * view.through_coat;
        let smooth = |to: Vec3, weight: SampledSpectrum, pdf: f32, eta: f32| {
            let wi = to * side;
            Some(BsdfSample { wi, weight: weight / pdf, pdf, specular: true, drops_wavelengths: false, eta })
        };
        let mut eta = 1.0;
        let wi = match (lobe, self.coat_facets, self.facets) {
            (0, None, _) => {
                let reflectance = self.coat * (COAT_F0 + (1.0 - COAT_F0) * schlick(up.z));
                return smooth(mirror, SampledSpectrum::splat(reflectance), chance, 1.0);
            }
            (1, _, None) => return smooth(mirror, self.fresnel(up.z) * below_coat, chance, 1.0),
            (0, Some(facets), _) | (1, _, Some(facets)) => fresnel::reflect(up, facets.sample_visible(up, u)) * side,
            (2, ..) => cosine_hemisphere(u) * side,
            (_, _, None) => {
                let whole = self.body() * below_coat;
                let (reflected, to, relative, tint) = self.smooth_body(wo, up);
                if choice < reflected {
                    return smooth(mirror, SampledSpectrum::splat(reflected * whole), chance * reflected, 1.0);
                }
                let through = whole * (1.0 - reflected) / (relative * relative);
                return smooth(to, tint * through, chance * (1.0 - reflected), relative);
            }
            (_, _, Some(facets)) if self.thin => {
                let m = facets.sample_visible(up, u);
                let to = fresnel::reflect(up, m);
                if to.z <= 0.0 {
                    return None;
                }
                (if choice < self.sheet_reflectance(up.dot(m)) { to } else { flipped(to) }) * side
            }
            (_, _, Some(facets)) => {
                let wi = Interface { eta: self.eta, facets }.sample(wo, choice, u)?;
                if wi.z * wo.z < 0.0 {
                    eta = self.relative_index(wo);
                }
                wi
            }
        };
        // The mirror image of a facet may lie inside: another one is in the way.
        if wi.z * wo.z <= 0.0 && lobe != 3 {
            return None;
        }
        let (value, pdf) = self.both(&view, (wo, wi), up, wi * side);
        let usable = pdf > 0.0 && pdf.is_finite() && value.is_finite();
        usable.then(|| BsdfSample { wi, weight: value / pdf, pdf, specular: false, drops_wavelengths: false, eta })
    }

    fn relative_index(&self, wo: Vec3) -> f32 {
        if wo.z >= 0.0 { self.eta } else { 1.0 / self.eta }
    }

    /// Of a smooth clear body: the share that is reflected, where the rest goes (seen from the side of `wo`), the index there over that before, and
    /// its colour.
    fn smooth_body(&self, wo: Vec3, up: Vec3) -> (f32, Vec3, f32, SampledSpectrum) {
        if self.thin {
            return (self.sheet_reflectance(up.z), -up, 1.0, self.base);
        }
        let eta = self.relative_index(wo);
        let (reflected, cos_t) = fresnel::dielectric(up.z.min(1.0), eta);
        (reflected, Vec3::new(-up.x / eta, -up.y / eta, -cos_t).normalize(), eta, self.tint())
    }
}
