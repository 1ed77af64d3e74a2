//! Bumps: any material but a `mix`, about a normal that a picture or a texture tilts.
//!
//! `normalmap` and `displacement` are parameters of the directives of all materials, with pbrt-v4's meaning. A normal map's red, green and
//! blue, each from -1 to 1, are the normal's share of dp/du, of the vector that makes a right-handed frame with it, and of the surface's own
//! normal. That is pbrt's way for the file of a picture. Where `normalmap` names a texture, which may be placed and repeated as any other, green
//! lies along dp/dv, as other programs have it (glTF 2.0, section 3.9.3): where the texture coordinates run the other way round, as those of the
//! second half of a mirrored model do, what stands out still does. `normalmapscale` multiplies red and green. A displacement is how far the surface lies off along its normal (scene units); its slopes tilt the normal, and no point is
//! moved (Blinn 1978, "Simulation of Wrinkled Surfaces"):
//!
//! `dp'/du = dp/du + dD/du n + D dn/du`, likewise by v, and `n' = dp'/du x dp'/dv`.
//!
//! Where pbrt-v4 takes a vector across dp/du in place of dp/dv, on meshes with vertex normals, dp/dv itself counts here.
//!
//! A tilted normal may look away from the viewer, or mirror the viewer's direction into the surface: such a facet would be black. Of a matt
//! surface it is turned until it faces the viewer, of others until its mirror direction leaves the surface (Keller et al. 2017, "The Iray
//! Light Transport Simulation and Rendering System", appendix A.3). And what the tilted normal takes for reflected must lie on the viewer's side of the surface's own
//! normal too, what it takes for transmitted on the other: no light leaks.

use bhs_core::diagnostics::{Diagnostic, Spanned};
use bhs_core::image::{Image, Texels};
use bhs_core::material::{BsdfSample, Material, Shading};
use bhs_core::params::Params;
use bhs_core::spectrum::SampledSpectrum;
use bhs_core::texture::{FloatParameter, Texture, TripleParameter};
use glam::{Vec2, Vec3};
use std::sync::Arc;

/// The step by u and by v over which a displacement's slopes are found, as in pbrt-v4 where it knows no better.
const STEP: f32 = 5e-4;

/// Cosine that the viewer has at least to a matt surface's tilted normal, and the mirror direction of the viewer to the surface's own.
const LEAST_COSINE: f32 = 0.01;

/// The colour that tilts nothing.
const FLAT: Vec3 = Vec3::new(0.5, 0.5, 1.0);

/// What tilts the normals.
enum Tilt {
    /// A file as pbrt reads it, and the factor of red and green.
    NormalMap(Arc<Image>, f32),
    /// A texture, and the same.
    Texture(Arc<dyn Texture>, f32),
    Displacement(FloatParameter),
}

/// Bumps, as the directive of a material states them.
pub struct Bumps(Tilt);

impl Bumps {
    /// Reads `normalmap` and `displacement`; `None`: neither is given, or what is given is at fault and has been reported. A `mix` has the
    /// bumps of its two materials, and none of its own, as in pbrt-v4.
    pub fn read(p: &Params) -> Option<Self> {
        if p.owner().value == "mix" {
            return None;
        }
        let about =
            "bumps: a picture of normals, in the frame of dp/du and the surface's normal; of a texture, green is along dp/dv";
        let normal_map = p.triple_parameter("normalmap", about);
        let about = "bumps: what red and green of `normalmap` are multiplied with";
        let scale = p.get_in("normalmapscale", 1.0, -1e6..=1e6, "", about) as f32;
        if p.is_given("normalmapscale") && !p.is_given("normalmap") {
            p.reject("normalmapscale", "`normalmapscale` needs a `normalmap`", "there is none to be multiplied");
        }
        let range = f64::from(f32::MIN)..=f64::from(f32::MAX);
        let about = "bumps: how far the surface seems to lie off along its normal; its slopes tilt the normal";
        let displacement = p.optional_float_parameter("displacement", range, "scene", about);
        let Some(normal_map) = normal_map else { return displacement.map(|d| Self(Tilt::Displacement(d))) };
        if displacement.is_some() {
            p.report(
                Diagnostic::error("conflicting-parameters", "`normalmap` and `displacement` exclude each other")
                    .at(p.span_of("displacement"), "given here")
                    .and(p.span_of("normalmap"), "and this tilts the normals too")
                    .help("remove one of the two: pbrt-v4 follows the normal map"),
            );
        }
        let path = match normal_map {
            TripleParameter::Texture(texture) => return Some(Self(Tilt::Texture(texture, scale))),
            TripleParameter::File(path) => Spanned::new(path, p.span_of("normalmap")),
        };
        match p.context().named.image(&path, p.context()) {
            Ok(image) => Some(Self(Tilt::NormalMap(image, scale))),
            Err(why) => {
                p.report(Diagnostic::error("unreadable", format!("cannot read `{}`: {why}", path.value)).at(path.span, ""));
                None
            }
        }
    }

    /// `material` with these bumps.
    pub fn over(self, material: Box<dyn Material>) -> Box<dyn Material> {
        Box::new(Bumped { material, tilt: self.0 })
    }
}

/// A material with bumps.
struct Bumped {
    material: Box<dyn Material>,
    tilt: Tilt,
}

/// The normal that a texel's colour stands for, up to its length; colours are read as numbers, not as light.
fn texel(image: &Image, i: usize) -> Vec3 {
    let share = match &image.texels {
        Texels::Bytes(t) => Vec3::from_array(t[i].map(f32::from)) / f32::from(u8::MAX),
        Texels::Words(t) => Vec3::from_array(t[i].map(f32::from)) / f32::from(u16::MAX),
        Texels::Floats(t) => Vec3::from_array(t[i]),
    };
    share * 2.0 - 1.0
}

/// The normal of a map at texture coordinates, between texels; the picture repeats.
fn mapped(image: &Image, uv: Vec2) -> Vec3 {
    let size = Vec2::new(image.width as f32, image.height as f32);
    // Rows are counted from the top, and a texel's value is that of its middle.
    let p = Vec2::new(uv.x, 1.0 - uv.y) * size - 0.5;
    let (corner, f) = (p.floor(), p - p.floor());
    let at = |dx: i64, dy: i64| {
        let x = (corner.x as i64 + dx).rem_euclid(i64::from(image.width));
        let y = (corner.y as i64 + dy).rem_euclid(i64::from(image.height));
        texel(image, (y * i64::from(image.width) + x) as usize)
    };
    at(0, 0).lerp(at(1, 0), f.x).lerp(at(0, 1).lerp(at(1, 1), f.x), f.y)
}

/// The normal of a displaced surface, up to its length.
fn displaced(displacement: &FloatParameter, at: &Shading) -> Vec3 {
    let here = displacement.at(at);
    let [along_u, along_v] = [Vec2::X, Vec2::Y].map(|way| {
        let i = usize::from(way == Vec2::Y);
        let moved = at.point + (at.tangents.world[i] * STEP).as_dvec3();
        let beside = Shading { uv: at.uv + way * STEP, point: moved, ..*at };
        let slope = (displacement.at(&beside) - here) / STEP;
        at.tangents.point[i] + Vec3::Z * slope + at.tangents.normal[i] * here
    });
    along_u.cross(along_v)
}

/// The unit normal `n` (z above 0) of a matt surface, turned towards the viewer at `wo` (z above 0) where it has to be.
fn facing(n: Vec3, wo: Vec3) -> Vec3 {
    let cos = n.dot(wo);
    if cos >= LEAST_COSINE { n } else { (n + wo * (LEAST_COSINE - cos)).normalize() }
}

/// The same of a surface that mirrors.
fn mirroring(n: Vec3, wo: Vec3) -> Vec3 {
    let mirrored = n * (2.0 * wo.dot(n)) - wo;
    if mirrored.z >= LEAST_COSINE {
        return n;
    }
    let lifted = Vec3::new(mirrored.x, mirrored.y, LEAST_COSINE).normalize();
    (lifted + wo).try_normalize().unwrap_or(Vec3::Z)
}

/// A frame whose z is the tilted normal and whose x lies along u, in the shading frame.
#[derive(Clone, Copy)]
struct Frame([Vec3; 3]);

impl Frame {
    fn to_own(self, w: Vec3) -> Vec3 {
        Vec3::from_array(self.0.map(|a| a.dot(w)))
    }

    fn to_shading(self, w: Vec3) -> Vec3 {
        self.0[0] * w.x + self.0[1] * w.y + self.0[2] * w.z
    }
}

impl Bumped {
    /// The unit normal on the surface's own side.
    fn tilted(&self, at: &Shading) -> Vec3 {
        let n = match &self.tilt {
            Tilt::NormalMap(image, scale) => mapped(image, at.uv) * Vec3::new(*scale, *scale, 1.0),
            Tilt::Texture(texture, scale) => {
                let n = texture.triple(at).unwrap_or(FLAT) * 2.0 - 1.0;
                // In the shading frame y is the side to which dp/dv leans, or the other one.
                n * Vec3::new(*scale, scale.copysign(*scale * at.tangents.point[1].y), 1.0)
            }
            Tilt::Displacement(displacement) => displaced(displacement, at),
        };
        // Flips no sides.
        let n = if n.z < 0.0 { -n } else { n };
        n.try_normalize().unwrap_or(Vec3::Z)
    }

    fn frame(&self, at: &Shading, wo: Vec3) -> Frame {
        let z = self.normal(at, wo);
        let x = (Vec3::X - z * z.x).try_normalize().unwrap_or_else(|| z.any_orthonormal_vector());
        Frame([x, z.cross(x), z])
    }

    /// The same point in a frame of its own.
    fn inner(at: &Shading, frame: Frame) -> Shading {
        let mut at = *at;
        at.tangents.point = at.tangents.point.map(|v| frame.to_own(v));
        at.tangents.normal = at.tangents.normal.map(|v| frame.to_own(v));
        at
    }

    /// Both directions and the point about the tilted normal; `None` where the two normals do not agree on which sides they lie.
    fn turned(&self, at: &Shading, wo: Vec3, wi: Vec3) -> Option<(Shading, Vec3, Vec3)> {
        let frame = self.frame(at, wo);
        let (o, i) = (frame.to_own(wo), frame.to_own(wi));
        agree([wo, wi], [o, i]).then(|| (Self::inner(at, frame), o, i))
    }
}

/// Whether two directions lie on the same side of one normal as of another, or on two sides of both.
fn agree([wo, wi]: [Vec3; 2], [o, i]: [Vec3; 2]) -> bool {
    (wo.z * wi.z > 0.0) == (o.z * i.z > 0.0)
}

impl Material for Bumped {
    fn evaluate(&self, at: &Shading, wo: Vec3, wi: Vec3) -> SampledSpectrum {
        self.turned(at, wo, wi).map_or(SampledSpectrum::ZERO, |(at, o, i)| self.material.evaluate(&at, o, i))
    }

    fn pdf(&self, at: &Shading, wo: Vec3, wi: Vec3) -> f32 {
        self.turned(at, wo, wi).map_or(0.0, |(at, o, i)| self.material.pdf(&at, o, i))
    }

    fn sample(&self, at: &Shading, wo: Vec3, choice: f32, u: Vec2) -> Option<BsdfSample> {
        let frame = self.frame(at, wo);
        let o = frame.to_own(wo);
        let sample = self.material.sample(&Self::inner(at, frame), o, choice, u)?;
        let wi = frame.to_shading(sample.wi);
        agree([wo, wi], [o, sample.wi]).then_some(BsdfSample { wi, ..sample })
    }

    fn reflectance(&self, at: &Shading, wo: Vec3) -> SampledSpectrum {
        let frame = self.frame(at, wo);
        self.material.reflectance(&Self::inner(at, frame), frame.to_own(wo))
    }

    fn is_oriented(&self) -> bool {
        true
    }

    fn normal(&self, at: &Shading, wo: Vec3) -> Vec3 {
        // Seen from inside, what is turned towards the viewer is the other side of it.
        let turned = if self.material.is_matt() { facing } else { mirroring };
        turned(self.tilted(at), wo * wo.z.signum())
    }

    fn evaluations(&self) -> u64 {
        self.material.evaluations()
    }

    fn refractive_index(&self) -> Option<f32> {
        self.material.refractive_index()
    }

    fn is_specular(&self) -> bool {
        self.material.is_specular()
    }

    fn chooses_directions(&self) -> bool {
        self.material.chooses_directions()
    }
}
