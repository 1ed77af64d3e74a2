//! What a file says of its surfaces, extensions put in their places.

use crate::model::Model;
use gltf::texture::{Info, MagFilter, WrappingMode};
use serde_json::Value;

pub use gltf::material::AlphaMode;

/// Where a picture lies on a surface, and which.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Its number in the file.
    pub image: usize,
    /// The set of texture coordinates.
    pub set: u32,
    /// Of KHR_texture_transform: offset, rotation (radians), scale.
    pub offset: [f64; 2],
    /// See `offset`.
    pub rotation: f64,
    /// See `offset`.
    pub scale: [f64; 2],
    /// What lies outside of it, along u and v.
    pub wrap: [WrappingMode; 2],
    /// Whether texels are squares, not means of their neighbours.
    pub nearest: bool,
}

/// A number, and the picture that multiplies it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Number {
    /// The factor.
    pub factor: f32,
    /// The picture.
    pub picture: Option<Picture>,
}

/// A material. Colours are linear sRGB.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Base colour and how opaque it is.
    pub base: [f32; 4],
    /// The picture that multiplies both.
    pub base_picture: Option<Picture>,
    /// In the picture's blue channel.
    pub metallic: Number,
    /// In the green one.
    pub roughness: Number,
    /// With KHR_materials_emissive_strength in it.
    pub emissive: [f32; 3],
    /// The picture that multiplies it.
    pub emissive_picture: Option<Picture>,
    /// Normals, and the factor of their red and green.
    pub normal: Number,
    /// How opaque it is.
    pub alpha_mode: AlphaMode,
    /// Of `AlphaMode::Mask`: from where on it is there.
    pub cutoff: f32,
    /// Whether its inner side is there.
    pub double_sided: bool,
    /// KHR_materials_unlit: it shows its base colour whatever light falls on it.
    pub unlit: bool,
    /// KHR_materials_ior.
    pub ior: f32,
    /// KHR_materials_specular, in the picture's alpha channel.
    pub specular: Number,
    /// KHR_materials_transmission, in the red one.
    pub transmission: Number,
    /// KHR_materials_volume: whether it is a body, not a sheet.
    pub is_solid: bool,
    /// KHR_materials_clearcoat, in the red one.
    pub clearcoat: Number,
    /// In the green one.
    pub clearcoat_roughness: Number,
    /// What is left out of it, in words.
    pub left_out: Vec<&'static str>,
}

/// Extensions that are not read, and what the picture lacks for it.
const LEFT_OUT: [(&str, &str); 7] = [
    ("KHR_materials_sheen", "sheen"),
    ("KHR_materials_iridescence", "iridescence"),
    ("KHR_materials_anisotropy", "stretched highlights (anisotropy)"),
    ("KHR_materials_dispersion", "dispersion"),
    ("KHR_materials_diffuse_transmission", "light that shines through evenly (diffuse transmission)"),
    ("KHR_materials_volume_scatter", "scattering within bodies"),
    ("KHR_materials_subsurface", "scattering within bodies"),
];

/// Material number `index`; `None`: that of what has none.
///
/// # Errors
/// What is wrong with it.
pub fn surface(model: &Model, index: Option<usize>) -> Result<Surface, String> {
    let material = index.and_then(|index| model.document.materials().nth(index));
    let Some(m) = material else { return Ok(default()) };
    let pbr = m.pbr_metallic_roughness();
    let number = |factor: f32, info: Option<Info>| Number { factor, picture: info.and_then(|info| picture(&info)) };
    let mut surface = Surface {
        base: pbr.base_color_factor(),
        base_picture: pbr.base_color_texture().and_then(|info| picture(&info)),
        metallic: number(pbr.metallic_factor(), pbr.metallic_roughness_texture()),
        roughness: number(pbr.roughness_factor(), pbr.metallic_roughness_texture()),
        emissive: m.emissive_factor().map(|e| e * m.emissive_strength().unwrap_or(1.0)),
        emissive_picture: m.emissive_texture().and_then(|info| picture(&info)),
        alpha_mode: m.alpha_mode(),
        cutoff: m.alpha_cutoff().unwrap_or(0.5),
        double_sided: m.double_sided(),
        unlit: m.unlit(),
        ior: m.ior().unwrap_or(1.5),
        ..default()
    };
    if let Some(normal) = m.normal_texture() {
        let transform = normal.extension_value("KHR_texture_transform");
        let place = transform_of(transform);
        let set = set_of(transform).unwrap_or(normal.tex_coord());
        surface.normal = Number { factor: normal.scale(), picture: placed(&normal.texture(), set, place) };
    }
    if let Some(s) = m.specular() {
        surface.specular = number(s.specular_factor(), s.specular_texture());
        if s.specular_color_factor() != [1.0; 3] || s.specular_color_texture().is_some() {
            surface.left_out.push("coloured reflections of what is no metal");
        }
    }
    if let Some(t) = m.transmission() {
        surface.transmission = number(t.transmission_factor(), t.transmission_texture());
    }
    if let Some(v) = m.volume() {
        surface.is_solid = v.thickness_factor() > 0.0;
        if surface.is_solid && v.attenuation_color() != [1.0; 3] && v.attenuation_distance().is_finite() {
            surface.left_out.push("colour that grows with the thickness of bodies");
        }
    }
    if let Some(coat) = m.extension_value("KHR_materials_clearcoat") {
        surface.clearcoat = raw_number(model, coat, "clearcoatFactor", "clearcoatTexture")?;
        surface.clearcoat_roughness = raw_number(model, coat, "clearcoatRoughnessFactor", "clearcoatRoughnessTexture")?;
        if coat.get("clearcoatNormalTexture").is_some() {
            surface.left_out.push("small relief of clear coats");
        }
    }
    if let Some(old) = m.pbr_specular_glossiness() {
        surface.base = old.diffuse_factor();
        surface.base_picture = old.diffuse_texture().and_then(|info| picture(&info));
        surface.metallic = Number::default();
        surface.roughness = Number { factor: 1.0 - old.glossiness_factor(), picture: None };
        surface.left_out.push("coloured and textured reflections (pbrSpecularGlossiness)");
    }
    surface.left_out.extend(LEFT_OUT.iter().filter(|(name, _)| m.extension_value(name).is_some()).map(|(_, what)| *what));
    let sets = surface.uv_sets();
    if surface.pictures().iter().any(|p| !sets.contains(&Some(p.set))) {
        surface.left_out.push("pictures by a third set of texture coordinates (they lie by the first)");
    }
    Ok(surface)
}

/// What has no material is white and rough (glTF 2.0, section 3.9.6).
fn default() -> Surface {
    let one = Number { factor: 1.0, picture: None };
    Surface {
        base: [1.0; 4],
        base_picture: None,
        metallic: one.clone(),
        roughness: one.clone(),
        emissive: [0.0; 3],
        emissive_picture: None,
        normal: one.clone(),
        alpha_mode: AlphaMode::Opaque,
        cutoff: 0.5,
        double_sided: false,
        unlit: false,
        ior: 1.5,
        specular: one,
        transmission: Number::default(),
        is_solid: false,
        clearcoat: Number::default(),
        clearcoat_roughness: Number::default(),
        left_out: Vec::new(),
    }
}

impl Surface {
    /// All of its pictures.
    pub fn pictures(&self) -> Vec<&Picture> {
        let numbers = [
            &self.normal,
            &self.metallic,
            &self.roughness,
            &self.specular,
            &self.transmission,
            &self.clearcoat,
            &self.clearcoat_roughness,
        ];
        let of_numbers = numbers.into_iter().filter_map(|n| n.picture.as_ref());
        self.base_picture.iter().chain(&self.emissive_picture).chain(of_numbers).collect()
    }

    /// The sets of texture coordinates that its pictures lie by: the first is that of what it emits, if it does; the second `None` where all lie by
    /// the first.
    pub fn uv_sets(&self) -> [Option<u32>; 2] {
        let pictures = self.pictures();
        let emitted = if self.unlit { &self.base_picture } else { &self.emissive_picture };
        let first = emitted.as_ref().map(|p| p.set).or_else(|| pictures.iter().map(|p| p.set).min());
        [first, pictures.iter().map(|p| p.set).filter(|set| Some(*set) != first).min()]
    }
}

/// The picture of a texture; `None`: it has none, or one of a kind that is not read.
fn picture(info: &Info) -> Option<Picture> {
    let transform = info.texture_transform();
    let (offset, rotation, scale) =
        transform.as_ref().map_or(([0.0; 2], 0.0, [1.0; 2]), |t| (t.offset(), t.rotation(), t.scale()));
    let set = transform.and_then(|t| t.tex_coord()).unwrap_or(info.tex_coord());
    placed(&info.texture(), set, (offset, rotation, scale))
}

fn placed(texture: &gltf::Texture, set: u32, (offset, rotation, scale): ([f32; 2], f32, [f32; 2])) -> Option<Picture> {
    // A picture in WebP stands in an extension, beside one that all programs read or alone.
    let webp = texture.extension_value("EXT_texture_webp").and_then(|e| e.get("source")?.as_u64()).map(|i| i as usize);
    let image = texture.source().map(|image| image.index()).or(webp)?;
    let sampler = texture.sampler();
    Some(Picture {
        image,
        set,
        offset: offset.map(f64::from),
        rotation: f64::from(rotation),
        scale: scale.map(f64::from),
        wrap: [sampler.wrap_s(), sampler.wrap_t()],
        nearest: sampler.mag_filter() == Some(MagFilter::Nearest),
    })
}

/// A factor and a texture of an extension that is kept as it was written.
fn raw_number(model: &Model, of: &Value, factor: &str, texture: &str) -> Result<Number, String> {
    let factor = of.get(factor).and_then(Value::as_f64).unwrap_or(0.0) as f32;
    let Some(info) = of.get(texture) else { return Ok(Number { factor, picture: None }) };
    let index = |name: &str| info.get(name).and_then(Value::as_u64);
    let found = index("index").and_then(|i| model.document.textures().nth(usize::try_from(i).ok()?));
    let Some(found) = found else { return Err(format!("its `{texture}` names a texture that it does not have")) };
    let transform = info.get("extensions").and_then(|e| e.get("KHR_texture_transform"));
    let set = set_of(transform).or(index("texCoord").and_then(|set| u32::try_from(set).ok())).unwrap_or(0);
    Ok(Number { factor, picture: placed(&found, set, transform_of(transform)) })
}

/// Offset, rotation and scale of a KHR_texture_transform that is kept as it was written.
fn transform_of(transform: Option<&Value>) -> ([f32; 2], f32, [f32; 2]) {
    let numbers = |name: &str, default: [f32; 2]| {
        let pair = transform.and_then(|t| t.get(name)?.as_array());
        pair.and_then(|p| Some([p.first()?.as_f64()? as f32, p.get(1)?.as_f64()? as f32])).unwrap_or(default)
    };
    let rotation = transform.and_then(|t| t.get("rotation")?.as_f64()).unwrap_or(0.0) as f32;
    (numbers("offset", [0.0; 2]), rotation, numbers("scale", [1.0; 2]))
}

/// The set of texture coordinates that it names.
fn set_of(transform: Option<&Value>) -> Option<u32> {
    transform?.get("texCoord")?.as_u64().and_then(|set| u32::try_from(set).ok())
}
