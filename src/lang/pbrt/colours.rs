//! Spectra and colours of pbrt's: their names, what is outside of tables, and colour spaces.

use crate::lang::ast::Directive;
use crate::lang::params;
use bhs_colour::bradford;
use bhs_core::value::{Param, ParamType, Values};
use glam::{DMat3, DVec3};

/// The primaries that `rgb` means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Space {
    Srgb,
    DciP3,
    Rec2020,
    Aces,
}

/// What the light of a colour is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// A share of the light, the same colour under the space's own white.
    Share,
    /// Light.
    Light,
    /// Neither.
    Number,
}

impl Space {
    /// The space of a name, as pbrt-v4 has them.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "srgb" => Some(Self::Srgb),
            "dci-p3" => Some(Self::DciP3),
            "rec2020" => Some(Self::Rec2020),
            "aces2065-1" => Some(Self::Aces),
            _ => None,
        }
    }

    /// Chromaticities of red, green, blue and white.
    fn primaries(self) -> [[f64; 2]; 4] {
        const D65: [f64; 2] = [0.3127, 0.3290];
        match self {
            Self::Srgb => [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06], D65],
            Self::DciP3 => [[0.680, 0.320], [0.265, 0.690], [0.150, 0.060], D65],
            Self::Rec2020 => [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046], D65],
            Self::Aces => [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077], [0.32168, 0.33767]],
        }
    }

    fn xyz_from_rgb(self) -> DMat3 {
        let xyz = |[x, y]: [f64; 2]| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
        let [r, g, b, w] = self.primaries();
        // Blue of ACES lies below y = 0: its column is scaled by y.
        let column = |[x, y]: [f64; 2]| DVec3::new(x, y, 1.0 - x - y);
        let m = DMat3::from_cols(column(r), column(g), column(b));
        m * DMat3::from_diagonal(m.inverse() * xyz(w))
    }

    /// A colour of this space in linear sRGB.
    fn to_srgb(self, rgb: [f64; 3], meaning: Meaning) -> [f64; 3] {
        let white = |s: Self| (s.xyz_from_rgb() * DVec3::ONE).to_array();
        let adapt = match meaning {
            Meaning::Share => DMat3::from_cols_array_2d(&bradford(white(self), white(Self::Srgb))).transpose(),
            _ => DMat3::IDENTITY,
        };
        (Self::Srgb.xyz_from_rgb().inverse() * adapt * self.xyz_from_rgb() * DVec3::from_array(rgb)).to_array()
    }
}

/// Built-in spectra of pbrt-v4 whose names mean other tables here, or that have other names.
const NAMES: &[(&str, &str)] = &[
    ("metal-Ag-eta", "metal-Ag-pbrt-eta"),
    ("metal-Ag-k", "metal-Ag-pbrt-k"),
    ("metal-Al-eta", "metal-Al-pbrt-eta"),
    ("metal-Al-k", "metal-Al-pbrt-k"),
    ("metal-Au-eta", "metal-Au-pbrt-eta"),
    ("metal-Au-k", "metal-Au-pbrt-k"),
    ("metal-Cu-eta", "metal-Cu-pbrt-eta"),
    ("metal-Cu-k", "metal-Cu-pbrt-k"),
    ("glass-F10", "glass-SF10"),
    ("glass-F11", "glass-SF11"),
];

/// Translates the spectra and colours of a directive, of which `meaning` says what they are.
pub(super) fn translate(d: &mut Directive, space: Space, meaning: impl Fn(&str) -> Meaning) {
    for param in &mut d.params {
        match param.ty.value {
            ParamType::Spectrum => spectrum(param),
            ParamType::Rgb if space != Space::Srgb => colour(param, space, meaning(&param.name.value)),
            _ => {}
        }
    }
}

fn spectrum(param: &mut Param) {
    match &mut param.values {
        Values::Strings(texts) if texts.len() == 1 => {
            let Some(text) = texts.first_mut() else { return };
            if let Some((_, ours)) = NAMES.iter().find(|(theirs, _)| *theirs == text.value) {
                (*ours).clone_into(&mut text.value);
            } else if text.value.contains(['/', '.']) {
                let word = text.clone();
                texts.push(bhs_core::diagnostics::Spanned::new("zero-outside".to_owned(), word.span));
            }
        }
        Values::Numbers { values, .. } if values.len() >= 4 && values.len() % 2 == 0 => {
            // A table ends with steps to 0.
            let (first, last) = (values[0], values[values.len() - 2]);
            let [at_first, at_last] = [values[1], values[values.len() - 1]];
            if at_first != 0.0 && values[2] != first {
                values.splice(0..0, [first, 0.0]);
            }
            if at_last != 0.0 && values[values.len() - 4] != last {
                values.extend([last, 0.0]);
            }
        }
        _ => {}
    }
}

fn colour(param: &mut Param, space: Space, meaning: Meaning) {
    let Values::Numbers { values, whole } = &mut param.values else { return };
    if meaning == Meaning::Number {
        return;
    }
    for rgb in values.chunks_exact_mut(3) {
        let new = space.to_srgb([rgb[0], rgb[1], rgb[2]], meaning);
        // Colours beyond sRGB's own become the nearest of its edge.
        let most = if meaning == Meaning::Share { 1.0 } else { f64::INFINITY };
        rgb.copy_from_slice(&new.map(|c| c.clamp(0.0, most)));
    }
    *whole = false;
}

/// The luminance of a colour in linear sRGB, of which white has 1.
pub(super) fn luminance(p: &Param) -> Option<f64> {
    match &p.values {
        Values::Numbers { values, .. } if values.len() == 3 => {
            Some(Space::Srgb.xyz_from_rgb().row(1).dot(DVec3::new(values[0], values[1], values[2])))
        }
        _ => None,
    }
}

/// Whether light is given by anything but a colour, whose strength pbrt makes 1.
pub(super) fn is_spectral(d: &Directive, name: &str) -> bool {
    params::find(d, name).is_some_and(|p| matches!(p.ty.value, ParamType::Spectrum | ParamType::Blackbody))
}
