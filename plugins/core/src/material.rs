//! What surfaces do with light.
//!
//! Directions are unit vectors in the local shading frame: z is the shading normal, measured by the observer at the surface;
//! both point away from it. `wo` is where light goes (towards the camera), `wi` where it comes from. Scattered radiance
//! is that of the radiance transported towards the camera: refraction includes the factor `1/eta^2`.

use crate::spectrum::{N_LAMBDA, SampledSpectrum};
use glam::{DVec3, Vec2, Vec3, Vec4};

/// What a material may know of the point that it shades.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shading {
    /// Texture coordinates.
    pub uv: Vec2,
    /// Those of the second set; those of the first where there is no other.
    pub second_uv: Vec2,
    /// Colour and opacity that the vertices of a mesh give it (linear sRGB); 1 where they give none.
    pub colour: Vec4,
    /// Wavelengths of the path as they are at this point (nm).
    pub lambda_nm: [f32; N_LAMBDA],
    /// The point itself, world space.
    pub point: DVec3,
    /// Outer unit normal of the surface itself, world space.
    pub normal: Vec3,
    /// How the surface lies in the shading frame: for materials that say [`Material::is_oriented`], and for others as if its texture coordinates
    /// were lengths along the axes.
    pub tangents: Tangents,
    /// By what the point moves along the surface, world space, as the pixel that sees it is left by half its width, and by half its height: pictures
    /// are blurred by it ([`crate::texture`]). Zero where that is not known; where it is, the tangents in world space are those of the surface.
    pub beside: [Vec3; 2],
}

impl Shading {
    /// A point of which nothing is known but its texture coordinates and wavelengths.
    pub const fn at_uv(uv: Vec2, lambda_nm: [f32; N_LAMBDA]) -> Self {
        Self {
            uv,
            second_uv: uv,
            colour: Vec4::ONE,
            lambda_nm,
            point: DVec3::ZERO,
            normal: Vec3::Z,
            tangents: Tangents::OF_AXES,
            beside: [Vec3::ZERO; 2],
        }
    }
}

/// How a point of a surface and its shading normal move with the texture coordinates (u, v).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tangents {
    /// Derivatives of the point by u and by v, in the shading frame, made perpendicular to the shading normal; the first is along x.
    pub point: [Vec3; 2],
    /// Derivatives of the shading normal by u and by v, in the shading frame.
    pub normal: [Vec3; 2],
    /// Derivatives of the point by u and by v, world space.
    pub world: [Vec3; 2],
}

impl Tangents {
    /// Of a plane whose texture coordinates are lengths along the axes of the shading frame.
    pub const OF_AXES: Self = Self { point: [Vec3::X, Vec3::Y], normal: [Vec3::ZERO; 2], world: [Vec3::X, Vec3::Y] };
}

/// A direction that a material chose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// The direction.
    pub wi: Vec3,
    /// BSDF times |cos(theta_i)| over density: what the path's throughput is multiplied with.
    pub weight: SampledSpectrum,
    /// Density with respect to solid angle (1/sr); of a specular direction the probability with which it is chosen among several, as far as
    /// that depends on the wavelengths.
    pub pdf: f32,
    /// Whether the direction was one of few possible ones (a mirror, smooth glass), so that `pdf` is no density.
    pub specular: bool,
    /// Whether the direction is that of the first wavelength alone, so that the path drops the others (dispersion).
    pub drops_wavelengths: bool,
    /// Refractive index beyond the surface over that before it, of a direction in which light is refracted; 1 of all others. `weight` has
    /// `1/eta^2` in it, which is of radiance: power that goes the other way does not.
    pub eta: f32,
}

/// A bidirectional scattering distribution over a surface.
pub trait Material: Send + Sync {
    /// BSDF times |cos(theta_i)|: the cosine is included. Zero for specular materials.
    fn evaluate(&self, at: &Shading, wo: Vec3, wi: Vec3) -> SampledSpectrum;

    /// The density with which [`Material::sample`] chooses `wi` (1/sr). Zero for specular materials.
    fn pdf(&self, at: &Shading, wo: Vec3, wi: Vec3) -> f32;

    /// Chooses a direction with three numbers in [0,1): `choice` between lobes, `u` within one. `None`: absorbed.
    fn sample(&self, at: &Shading, wo: Vec3, choice: f32, u: Vec2) -> Option<BsdfSample>;

    /// Share of the light, by wavelength, that is sent towards `wo` when as much comes in from everywhere
    /// (hemispherical-directional reflectance, as pbrt-v4's `rho`): what a picture records as albedo. As everywhere here, what
    /// is refracted is radiance, with its factor `1/eta^2`.
    ///
    /// The default is [`estimated_reflectance`].
    fn reflectance(&self, at: &Shading, wo: Vec3) -> SampledSpectrum {
        estimated_reflectance(self, at, wo)
    }

    /// Whether it looks the same at every point and all around the normal: then [`Material::reflectance`] depends on the wavelengths and on `wo.z`
    /// alone, but for what an estimate varies by, and steadily on the latter on each side.
    fn is_uniform(&self) -> bool {
        false
    }

    /// Whether it asks for [`Shading::tangents`]: it scatters otherwise along the texture coordinates than across them, or has bumps.
    fn is_oriented(&self) -> bool {
        false
    }

    /// The unit normal, in the shading frame, about which it scatters what is seen from `wo`: z but for bumps.
    fn normal(&self, _at: &Shading, _wo: Vec3) -> Vec3 {
        Vec3::Z
    }

    /// The two materials that it is made of and their shares at a point, if it is nothing but a mix of two.
    fn parts(&self, _at: &Shading) -> Option<[(&dyn Material, f32); 2]> {
        None
    }

    /// Evaluations of materials that are no mixes which one of this makes if each mix asks its own two parts.
    fn evaluations(&self) -> u64 {
        1
    }

    /// Refractive index of the inside over that of the outside, of a material that light enters and leaves through: that of one wavelength, for who
    /// wants to know roughly. `None` of all others.
    fn refractive_index(&self) -> Option<f32> {
        None
    }

    /// Whether every direction it chooses is specular, so that light cannot be sampled for it.
    fn is_specular(&self) -> bool;

    /// Whether it scatters as Lambert's law says: only to the side of `wo`, the same from all sides, and [`Material::pdf`] is
    /// |cos(theta_i)|/pi there. Then transports may choose directions by what they know of the light.
    fn is_matt(&self) -> bool {
        false
    }

    /// Whether directions must be chosen by [`Material::sample`], because some of them are specular or lie behind the surface: drawn
    /// uniformly above it, they would miss part of what is scattered.
    fn chooses_directions(&self) -> bool {
        self.is_specular()
    }
}

/// The mean weight of [`Material::sample`] over fixed numbers: the reflectance where the weight is the same everywhere, as it is for Lambert's
/// law, an estimate of it elsewhere.
pub fn estimated_reflectance<M: Material + ?Sized>(material: &M, at: &Shading, wo: Vec3) -> SampledSpectrum {
    const N: u32 = 16;
    let mut sum = SampledSpectrum::ZERO;
    for i in 0..N {
        // The points of Hammersley in the middle of their cells; golden-ratio steps between the lobes.
        let radical_inverse = (i.reverse_bits() >> (32 - N.ilog2())) as f32;
        let u = Vec2::new(i as f32 + 0.5, radical_inverse + 0.5) / N as f32;
        let choice = (i as f32 * 0.618_034 + 0.5).fract();
        if let Some(sample) = material.sample(at, wo, choice, u) {
            sum += sample.weight;
        }
    }
    sum / N as f32
}

/// Cosine of the angle to the shading normal.
#[inline]
pub fn cos_theta(w: Vec3) -> f32 {
    w.z
}

/// Whether both directions lie on the same side of the surface.
#[inline]
pub fn same_hemisphere(a: Vec3, b: Vec3) -> bool {
    a.z * b.z > 0.0
}
