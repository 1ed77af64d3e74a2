//! Where on a texture a point of a surface lies: the mappings of pbrt-v4, in the coordinates in which the texture was defined.

use bhs_core::diagnostics::{Diagnostic, did_you_mean};
use bhs_core::material::Shading;
use bhs_core::params::{Params, Vector3};
use bhs_core::spectrum::SpectrumRole;
use bhs_core::texture::TextureKind;
use bhs_elementary::Elementary;
use glam::{DAffine3, DVec2, DVec3, Vec2};
use std::f64::consts::{FRAC_1_PI, PI, TAU};

/// How a point of a surface is placed on a plane texture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mapping {
    /// `(s, t) = (uscale u + udelta, vscale v + vdelta)`, turned by `rotate` in between.
    Uv {
        /// Whether the texture coordinates are those of the second set.
        second: bool,
        /// Factors.
        scale: Vec2,
        /// Sine and cosine of an angle.
        turn: Vec2,
        /// What is added.
        delta: Vec2,
    },
    /// By the direction from the origin: s is the angle to the z axis over pi, t the one around it over 2 pi.
    Spherical(Space),
    /// s is the angle around the z axis over 2 pi, which is a half along x; t is z.
    Cylindrical(Space),
    /// `(s, t) = (p . v1 + udelta, p . v2 + vdelta)`.
    Planar {
        /// The texture's own coordinates.
        space: Space,
        /// `v1` and `v2`.
        axes: [DVec3; 2],
        /// What is added.
        delta: DVec2,
    },
}

/// The coordinates in which a texture was defined, for those that fill space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Space {
    own_from_world: DAffine3,
}

/// The largest factor and offset: numbers of texels stay whole numbers of 64 bits.
const LARGEST: f64 = 1e9;

/// The names of the mappings to a plane.
const PLANE: [&str; 4] = ["uv", "spherical", "cylindrical", "planar"];

impl Space {
    /// That of the current transform; that of the world after a report that the transform cannot be used.
    pub fn read(p: &Params) -> Self {
        let own_from_world = p.context().world_from_object.inverse();
        if own_from_world.is_finite() {
            return Self { own_from_world };
        }
        let message = format!("the current transform flattens the {}, or is out of range", p.owner().value);
        p.report(Diagnostic::error("bad-transform", message).at(p.owner().span, ""));
        Self { own_from_world: DAffine3::IDENTITY }
    }

    /// A point in these coordinates.
    #[inline]
    pub fn place(&self, at: &Shading) -> DVec3 {
        self.own_from_world.transform_point3(at.point)
    }
}

/// What the parameter `mapping` names.
pub enum Named {
    /// A place on a plane.
    Plane(Mapping),
    /// A place in space.
    Space(Space),
}

impl Mapping {
    /// Reads the parameters of the mapping.
    pub fn read(p: &Params) -> Self {
        match read(p, &PLANE, "how a point is placed: by texture coordinates (`uv`), `spherical`, `cylindrical`, `planar`") {
            Named::Plane(mapping) => mapping,
            Named::Space(_) => Self::Uv { second: false, scale: Vec2::ONE, turn: Vec2::Y, delta: Vec2::ZERO },
        }
    }

    /// How many units of s go once around, if they are a whole number: what repeats after them has no seam.
    pub fn turns(&self) -> Option<i64> {
        let Self::Uv { scale, turn, .. } = self else { return None };
        let turns = scale.x;
        (*turn == Vec2::Y && (1.0..=1e6).contains(&turns) && turns.fract() == 0.0).then_some(turns as i64)
    }

    /// The place of a point.
    #[inline]
    pub fn place(&self, at: &Shading) -> Vec2 {
        match self {
            Self::Uv { second, scale, turn: Vec2 { x: sin, y: cos }, delta } => {
                let p = if *second { at.second_uv } else { at.uv } * *scale;
                Vec2::new(cos * p.x - sin * p.y, sin * p.x + cos * p.y) + *delta
            }
            in_space => in_space.place_in_space(at).as_vec2(),
        }
    }

    /// By what the place moves as the point moves by each of [`Shading::beside`].
    pub fn moved(&self, at: &Shading) -> [Vec2; 2] {
        let here = self.place_in_space(at);
        let [along_u, along_v] = at.tangents.world;
        let (uu, uv, vv) = (along_u.dot(along_u), along_u.dot(along_v), along_v.dot(along_v));
        at.beside.map(|way| {
            // The u and v that bring the point there, or as near as they can.
            let (u, v) = (along_u.dot(way), along_v.dot(way));
            let duv = Vec2::new(vv * u - uv * v, uu * v - uv * u) / (uu * vv - uv * uv);
            // A second set of texture coordinates is taken to stretch as the first does: its tangents are not known.
            let moved = Shading { uv: at.uv + duv, second_uv: at.second_uv + duv, point: at.point + way.as_dvec3(), ..*at };
            let by = self.place_in_space(&moved) - here;
            // Around an axis, a whole turn is none.
            match self {
                Self::Spherical(_) => DVec2::new(by.x, by.y - by.y.round()),
                Self::Cylindrical(_) => DVec2::new(by.x - by.x.round(), by.y),
                Self::Uv { .. } | Self::Planar { .. } => by,
            }
            .as_vec2()
        })
    }

    fn place_in_space(&self, at: &Shading) -> DVec2 {
        match self {
            Self::Uv { .. } => self.place(at).as_dvec2(),
            Self::Spherical(space) => {
                let p = space.place(at);
                let around = p.y.arctangent2(p.x);
                let around = if around < 0.0 { around + TAU } else { around };
                DVec2::new(p.x.hypotenuse(p.y).arctangent2(p.z) * FRAC_1_PI, around / TAU)
            }
            Self::Cylindrical(space) => {
                let p = space.place(at);
                DVec2::new((PI + p.y.arctangent2(p.x)) / TAU, p.z)
            }
            Self::Planar { space, axes, delta } => {
                let p = space.place(at);
                DVec2::new(p.dot(axes[0]), p.dot(axes[1])) + *delta
            }
        }
    }
}

/// Reads the parameters of a mapping, which is one of `names`.
pub fn read(p: &Params, names: &[&'static str], about: &'static str) -> Named {
    let given = p.get("mapping", names[0].to_owned(), "", about);
    let name = names.iter().copied().find(|name| *name == given).unwrap_or_else(|| {
        let help = match did_you_mean(&given, names.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("there is {}", names.join(", ")),
        };
        p.report(Diagnostic::error("bad-value", format!("unknown mapping `{given}`")).at(p.span_of("mapping"), "").help(help));
        names[0]
    });
    if name != "uv" && p.context().named.kind() == TextureKind::Spectrum(SpectrumRole::Emission) {
        let message = format!("emission cannot be placed by the mapping `{name}`");
        let help = "what lights emit is placed by texture coordinates: use the mapping \"uv\"";
        p.report(Diagnostic::error("unsupported", message).at(p.span_of("mapping"), "").help(help));
    }
    let number = |parameter, default, mappings: &[&str], about| {
        let value = p.get_in(parameter, default, -LARGEST..=LARGEST, "", about);
        only_of(p, parameter, name, mappings);
        value
    };
    let (both, uv) = (["uv", "planar"], ["uv"]);
    let about = "which texture coordinates of the mesh: 0 the first, 1 the second, which glTF files may bring";
    let set = p.get_in("uvset", 0, 0..=1, "", about);
    only_of(p, "uvset", name, &uv);
    if set == 1 && p.context().named.kind() == TextureKind::Spectrum(SpectrumRole::Emission) {
        p.reject("uvset", "emission is placed by the first texture coordinates", "0 is their number");
    }
    let scale = [number("uscale", 1.0, &uv, "factor of u"), number("vscale", 1.0, &uv, "factor of v")];
    let delta = [number("udelta", 0.0, &both, "added to u, or to s"), number("vdelta", 0.0, &both, "added to v, or to t")];
    let about = "by which texture coordinates are turned around (0, 0), once they are scaled";
    let angle = p.get_in("rotate", 0.0, -LARGEST..=LARGEST, "deg", about);
    only_of(p, "rotate", name, &uv);
    let (sin, cos) = angle.to_radians().sine_cosine();
    let axis = |parameter, default, about| {
        let Vector3(axis) = p.get(parameter, Vector3(default), "", about);
        only_of(p, parameter, name, &["planar"]);
        axis
    };
    let axes = [
        axis("v1", DVec3::X, "of the mapping `planar`: s is a point's product with it"),
        axis("v2", DVec3::Y, "of the mapping `planar`: t is a point's product with it"),
    ];
    Named::Plane(match name {
        "spherical" => Mapping::Spherical(Space::read(p)),
        "cylindrical" => Mapping::Cylindrical(Space::read(p)),
        "planar" => Mapping::Planar { space: Space::read(p), axes, delta: DVec2::from_array(delta) },
        "space" => return Named::Space(Space::read(p)),
        _ => Mapping::Uv {
            second: set == 1,
            scale: DVec2::from_array(scale).as_vec2(),
            // Exactly nothing where nothing is turned.
            turn: if angle == 0.0 { Vec2::Y } else { Vec2::new(sin as f32, cos as f32) },
            delta: DVec2::from_array(delta).as_vec2(),
        },
    })
}

/// Reports a parameter that is given and means nothing for the mapping `name`.
fn only_of(p: &Params, parameter: &str, name: &str, mappings: &[&str]) {
    if p.is_given(parameter) && !mappings.contains(&name) {
        let message = format!("`{parameter}` means nothing for the mapping `{name}`");
        let help = format!("it belongs to the mapping {}", mappings.join(" and "));
        p.report(Diagnostic::error("conflicting-parameters", message).at(p.span_of(parameter), "").help(help));
    }
}
