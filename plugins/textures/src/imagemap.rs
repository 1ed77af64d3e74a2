//! `imagemap`: a picture.
//!
//! The picture's lower left corner is (s, t) = (0, 0), its upper right one (1, 1); (s, t) are the texture coordinates by the mapping.
//! A texture of spectra raises each colour to a smooth spectrum, as `rgb` does; a texture of floats is the mean of the channels.
//! Eight and sixteen bits a channel are decoded as `encoding` says, HDR and EXR pictures are linear.
//!
//! Names, defaults and conventions of pbrt-v4. `trilinear` and `ewa` are means over the patch of the picture that a pixel sees, which is found along
//! the bent light (`plugins/engine/src/patch.rs`): fewer samples do for a picture whose texels are smaller than pixels. They count for what the camera sees
//! itself; what is seen in mirrors, through glass and by scattered light, and at edges, is `bilinear`, and the samples of the pixel are the mean.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `filename` | string | required | | a PNG, JPEG, HDR or EXR picture, or a glTF file that holds some |
//! | `image` | integer | none | | of a glTF file: the number of the picture in it, from 0 |
//! | `wrap` | string | "repeat" | | outside of the picture: it repeats, keeps its edge (`clamp`), repeats mirrored (`mirror`), is `black`, or goes on as on a sphere (`octahedralsphere`) |
//! | `wrapv` | string | `wrap` | | the same along v alone: `repeat`, `clamp`, `mirror`, `black` |
//! | `filter` | string | "bilinear" | | between texels: `bilinear` or the nearest one (`point`); over what a pixel sees: as if that were round (`trilinear`), or as it is (`ewa`) |
//! | `maxanisotropy` | float | 8 | | of the filter `ewa`: most that what a pixel sees is longer than wide, at most 64; beyond, it is blurred |
//! | `encoding` | string | "sRGB" | | of 8 and 16 bits: `sRGB`, `linear`, or `gamma` and an exponent; of a normal map `linear` by default |
//! | `channel` | string | "mean" | | of a texture of floats: the mean of the colours, one of them (`red`, `green`, `blue`), or how opaque the picture is: `alpha` is the mean where it does not say, `opacity` 1 |
//! | `scale` | float | 1 | | factor |
//! | `invert` | bool | false | | whether it is one minus the picture |
//! | `mapping` | string | "uv" | | how a point is placed: `uv`, `spherical`, `cylindrical`, `planar` |
//! | `uvset` | integer | 0 | | which texture coordinates of the mesh: 0 the first, 1 the second |
//! | `uscale`, `vscale` | float | 1 | | factors of u and v |
//! | `rotate` | float | 0 | deg | by which texture coordinates are turned around (0, 0), once they are scaled |
//! | `udelta`, `vdelta` | float | 0 | | what is added to them |
//! | `v1`, `v2` | vector3 | x, y | | of `planar`: s and t are a point's products with them |
//!
//! ```text
//! Texture "wood" "spectrum" "imagemap" "string filename" "wood.png" "float uscale" 4
//! ```

use crate::decode::decode;
use crate::mapping::Mapping;
use crate::pyramid::{Blur, MOST_LONGER, Pyramid, bilinear, size_of};
use crate::wrap::{self, WRAPS, Wrap};
use bhs_colour::srgb_decode;
use bhs_core::Plugin;
use bhs_core::diagnostics::{Diagnostic, Spanned, did_you_mean};
use bhs_core::image::{Image, Texels};
use bhs_core::material::Shading;
use bhs_core::params::Params;
use bhs_core::spectrum::{SampledSpectrum, SpectrumRole};
use bhs_core::texture::{Texture, TextureKind};
use bhs_elementary::Elementary;
use bhs_models::{Model, beside, picture};
use bhs_spectra::{SmoothSpectra, d65};
use glam::{Vec2, Vec3};
use std::sync::Arc;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Texture> = Plugin { name: "imagemap", summary: "a picture: PNG, JPEG, HDR or EXR", build };

/// How the numbers of 8 and 16 bits mean light.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Encoding {
    Srgb,
    Linear,
    Gamma(f32),
}

impl Encoding {
    /// The light of a value between 0 and 1 (sRGB: IEC 61966-2-1).
    fn decode(self, v: f32) -> f32 {
        match self {
            Self::Linear => v,
            Self::Gamma(gamma) => v.power(gamma),
            Self::Srgb => srgb_decode(v),
        }
    }
}

/// How texels become the picture at a point.
enum Filter {
    /// The nearest one.
    Point,
    /// Four around the point.
    Bilinear,
    /// A mean over the patch that a pixel sees.
    Patch(Pyramid, Blur),
}

/// What a float is of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Channel {
    Mean,
    /// Red, green or blue.
    Colour(usize),
    /// How opaque it is, if it says so; else the mean.
    Alpha,
    /// How opaque it is, if it says so; else 1.
    Opacity,
}

/// The largest value of a picture: what spectra are made of it stays within single precision.
const LARGEST: f32 = 1e37;

struct ImageMap {
    image: Arc<Image>,
    /// The light of each value of a byte.
    byte: Box<[f32; 256]>,
    encoding: Encoding,
    /// Along u, along v.
    wrap: [Wrap; 2],
    filter: Filter,
    /// Whether it is how opaque the picture is, and not its light.
    is_opacity: bool,
    channel: Channel,
    scale: f32,
    invert: bool,
    mapping: Mapping,
    /// For what its spectra are.
    role: SpectrumRole,
    spectra: &'static SmoothSpectra,
}

fn build(p: &Params) -> Option<Box<dyn Texture>> {
    let filename = p.require::<String>("filename", "", "a PNG, JPEG, HDR or EXR picture, or a glTF file that holds some");
    let number = p.optional::<i64>("image", "", "of a glTF file: the number of the picture in it, from 0");
    let about = "outside: the picture repeats, keeps its edge, repeats mirrored, is black, or goes on as on a sphere";
    let wrap = choice(p, "wrap", &WRAPS, about);
    let about = "outside of the picture along v, where that is not as `wrap` says: `repeat`, `clamp`, `mirror`, `black`";
    let wrap_v = match p.optional::<String>("wrapv", "", about) {
        Some(given) => known_word(p, "wrapv", &given, &WRAPS[..4]),
        None => wrap,
    };
    if wrap != wrap_v && wrap == WRAPS[4] {
        p.reject("wrapv", "a picture that goes on as on a sphere does so along u and v", "remove `wrapv`");
    }
    let about = "between texels: `bilinear` or the nearest one (`point`); over what a pixel sees: as if that were round (`trilinear`), or as it is (`ewa`)";
    let filter = choice(p, "filter", &["bilinear", "point", "trilinear", "ewa", "EWA"], about);
    let about = "of the filter `ewa`: most that what a pixel sees is longer than wide, at most 64; beyond, it is blurred";
    let anisotropy = p.get_in("maxanisotropy", 8.0, 0.0..=f64::from(f32::MAX), "", about) as f32;
    let encoding = encoding(p);
    let about = "of a texture of floats: the mean of the colours, one of them, or how opaque the picture is; where it does not say, `alpha` is the mean and `opacity` 1";
    let channel = match choice(p, "channel", &["mean", "red", "green", "blue", "alpha", "opacity"], about) {
        "red" => Channel::Colour(0),
        "green" => Channel::Colour(1),
        "blue" => Channel::Colour(2),
        "alpha" => Channel::Alpha,
        "opacity" => Channel::Opacity,
        _ => Channel::Mean,
    };
    let scale = p.get_in("scale", 1.0, 0.0..=f64::from(f32::MAX), "", "factor") as f32;
    let invert = p.get("invert", false, "", "whether it is one minus the picture");
    let mapping = Mapping::read(p);
    let path = Spanned::new(filename?, p.span_of("filename"));
    let read = match number {
        Some(number) => within_model(p, &path, number),
        None => p.context().named.image(&path, p.context()),
    };
    let image = match read {
        Ok(image) => image,
        Err(why) => {
            p.report(Diagnostic::error("unreadable", format!("cannot read `{}`: {why}", path.value)).at(path.span, ""));
            Arc::new(Image::of_one_texel([0.0; 3]))
        }
    };
    let about = image.notes.iter().map(|note| (note, None));
    // Who says how the numbers mean light knows better than the file.
    let encoding_note =
        image.encoding_note.iter().filter(|_| !p.is_given("encoding") && p.context().named.kind() != TextureKind::Triple);
    let help = "its numbers are read as sRGB; give `encoding`: \"linear\", \"gamma 2.2\", or \"sRGB\" if that is right";
    for (note, help) in about.chain(encoding_note.map(|note| (note, Some(help)))) {
        let warning = Diagnostic::warning("picture-note", format!("`{}`: {note}", path.value)).at(path.span, "");
        p.report(if let Some(help) = help { warning.help(help) } else { warning });
    }
    let role = match p.context().named.kind() {
        TextureKind::Spectrum(role) => role,
        TextureKind::Float | TextureKind::Triple => SpectrumRole::Unbounded,
    };
    let is_opacity = p.context().named.kind() == TextureKind::Float
        && (channel == Channel::Opacity || channel == Channel::Alpha && image.alpha.is_some());
    let mut map = ImageMap {
        image,
        byte: Box::new(std::array::from_fn(|i| encoding.decode(i as f32 / 255.0))),
        encoding,
        wrap: [wrap, wrap_v].map(Wrap::of),
        filter: if filter == "point" { Filter::Point } else { Filter::Bilinear },
        is_opacity,
        channel,
        scale,
        invert,
        mapping,
        role,
        spectra: SmoothSpectra::get(),
    };
    let blur = match filter {
        "trilinear" => Some(Blur::Round),
        "ewa" | "EWA" => Some(Blur::Ellipse { most_longer: anisotropy.clamp(1.0, MOST_LONGER) }),
        _ => None,
    };
    // What lights emit is asked for where no pixel looks.
    if let Some(blur) = blur.filter(|_| role != SpectrumRole::Emission) {
        p.context().named.wants_patches();
        map.filter = Filter::Patch(Pyramid::new([map.image.width, map.image.height], &|i| map.value(i)), blur);
    }
    Some(Box::new(map))
}

/// The picture of a number in a glTF file.
fn within_model(p: &Params, path: &Spanned<String>, number: i64) -> Result<Arc<Image>, String> {
    let model = p.context().share(&path.value, path.span, Model::parse)?;
    let read = |name: &str| p.context().share(&beside(&path.value, name), path.span, |bytes| Ok(bytes.to_vec()));
    let number = usize::try_from(number).map_err(|_| "pictures are counted from 0".to_owned())?;
    picture::decoded(&model, number, &read, decode)
}

/// One of several words, the first by default.
fn choice(p: &Params, name: &'static str, words: &'static [&'static str], about: &'static str) -> &'static str {
    let given = p.get(name, words[0].to_owned(), "", about);
    known_word(p, name, &given, words)
}

/// The one of `words` that is given; the first, after a report, if none is.
fn known_word(p: &Params, name: &'static str, given: &str, words: &'static [&'static str]) -> &'static str {
    if let Some(word) = words.iter().find(|w| **w == given) {
        return word;
    }
    let help = match did_you_mean(given, words.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("there is {}", words.join(", ")),
    };
    let message = format!("unknown `{name}`: `{given}`");
    p.report(Diagnostic::error("bad-value", message).at(p.span_of(name), "").help(help));
    words[0]
}

fn encoding(p: &Params) -> Encoding {
    // The numbers of a normal map are no light.
    let usual = if p.context().named.kind() == TextureKind::Triple { "linear" } else { "sRGB" };
    let given = p.get("encoding", usual.to_owned(), "", "of 8 and 16 bits: `sRGB`, `linear`, or `gamma` and an exponent");
    let mut words = given.split_whitespace();
    let gamma = |word: Option<&str>| word.and_then(|w| w.parse().ok()).filter(|g: &f32| *g > 0.0 && g.is_finite());
    match (words.next(), words.next()) {
        (Some("sRGB"), None) => Encoding::Srgb,
        (Some("linear"), None) => Encoding::Linear,
        (Some("gamma"), exponent) if words.next().is_none() && gamma(exponent).is_some() => {
            gamma(exponent).map_or(Encoding::Srgb, Encoding::Gamma)
        }
        _ => {
            let message = format!("unknown `encoding`: `{given}`");
            let help = "there is \"sRGB\", \"linear\" and \"gamma 2.2\"";
            p.report(Diagnostic::error("bad-value", message).at(p.span_of("encoding"), "").help(help));
            Encoding::Srgb
        }
    }
}

impl ImageMap {
    /// The light of the texel of a number.
    #[inline]
    fn texel(&self, i: usize) -> Vec3 {
        match &self.image.texels {
            Texels::Bytes(t) => Vec3::from_array(t[i].map(|c| self.byte[usize::from(c)])),
            Texels::Words(t) => Vec3::from_array(t[i].map(|c| self.encoding.decode(f32::from(c) / 65535.0))),
            Texels::Floats(t) => Vec3::from_array(t[i]),
        }
    }

    /// How opaque the texel of a number is.
    #[inline]
    fn opacity(&self, i: usize) -> f32 {
        self.image.alpha.as_ref().map_or(1.0, |alpha| f32::from(alpha[i]) / 255.0)
    }

    /// What a texel is to this texture: its light, or how opaque it is.
    #[inline]
    fn value(&self, i: usize) -> Vec3 {
        if self.is_opacity { Vec3::splat(self.opacity(i)) } else { self.texel(i) }
    }

    /// The picture at a point.
    #[inline]
    fn look_up(&self, at: &Shading) -> Vec3 {
        let st = self.mapping.place(at);
        let size = [self.image.width, self.image.height].map(i64::from);
        let texel = |x: i64, y: i64| wrap::index(self.wrap, size, x, y).map_or(Vec3::ZERO, |i| self.value(i));
        // Rows are counted from the top.
        let place = Vec2::new(st.x, 1.0 - st.y);
        let found = match &self.filter {
            Filter::Point => {
                let p = place * size_of(size);
                texel(p.x.floor() as i64, p.y.floor() as i64)
            }
            Filter::Patch(pyramid, blur) if at.beside != [Vec3::ZERO; 2] => {
                let axes = self.mapping.moved(at).map(|d| Vec2::new(d.x, -d.y));
                pyramid.mean(&|i| self.value(i), *blur, self.wrap, place, axes).unwrap_or_else(|| bilinear(size, place, texel))
            }
            Filter::Bilinear | Filter::Patch(..) => bilinear(size, place, texel),
        } * self.scale;
        (if self.invert { 1.0 - found } else { found }).clamp(Vec3::ZERO, Vec3::splat(LARGEST))
    }
}

impl Texture for ImageMap {
    fn spectrum(&self, at: &Shading) -> SampledSpectrum {
        let rgb = self.look_up(at);
        if self.role == SpectrumRole::Reflectance {
            let smooth = self.spectra.of(rgb.min(Vec3::ONE).to_array());
            return SampledSpectrum(at.lambda_nm.map(|l| smooth.at(l)));
        }
        // As `rgb` does it.
        let scale = 2.0 * rgb.max_element();
        if scale == 0.0 {
            return SampledSpectrum::ZERO;
        }
        let smooth = self.spectra.of((rgb / scale).to_array());
        let values = SampledSpectrum(at.lambda_nm.map(|l| scale * smooth.at(l)));
        if self.role == SpectrumRole::Emission { values * d65().sample(at.lambda_nm) } else { values }
    }

    fn float(&self, at: &Shading) -> f32 {
        let found = self.look_up(at);
        match self.channel {
            Channel::Colour(i) => found[i],
            _ if self.is_opacity => found.x,
            _ => found.element_sum() / 3.0,
        }
    }

    fn triple(&self, at: &Shading) -> Option<Vec3> {
        Some(self.look_up(at))
    }
}
