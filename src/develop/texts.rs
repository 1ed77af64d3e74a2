//! What PNG files say in words.

use super::Developer;
use crate::false_color::FalseColor;
use crate::image::Attribute;
use crate::look::{Look, White};

/// What the PNG files of a picture say about it: keywords, some of them those of the PNG specification, and texts. They follow from the header of its EXR
/// file, so that who develops that writes the same; neither from the time nor from the machine, nor from how the scene is called or written: the same picture
/// has the same bytes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Texts(Vec<(&'static str, String)>);

/// Keywords of PNG files, and the attributes of EXR files that they are taken from.
const KEYWORDS: [(&str, &str); 5] = [
    ("camera", "bhs:camera"),
    ("seed", "bhs:seed"),
    ("spp", "bhs:spp"),
    ("integrator", "bhs:integrator"),
    ("transport", "bhs:transport"),
];

impl Texts {
    /// Those of a picture whose header has the attributes that `get` knows.
    pub fn of(get: impl Fn(&str) -> Option<String>) -> Self {
        let version = get("bhs:version").unwrap_or_else(|| env!("CARGO_PKG_VERSION").to_owned());
        let mut all = vec![("Software", format!("bhs {version}"))];
        for (keyword, name) in KEYWORDS {
            let digits = if name == "bhs:seed" { get("bhs:seedDigits") } else { None };
            // Texts of PNG files hold all characters but that one.
            all.extend(digits.or_else(|| get(name)).map(|text| (keyword, text.replace('\0', "\\u{0}"))));
        }
        Self(all)
    }

    /// Those of a picture that has these attributes.
    pub fn of_attributes(attributes: &[(String, Attribute)]) -> Self {
        Self::of(|wanted| {
            attributes.iter().find(|(name, _)| name == wanted).and_then(|(_, value)| match value {
                Attribute::Text(text) => Some(text.clone()),
                Attribute::Number(x) => Some(x.to_string()),
                Attribute::Single(x) => Some(x.to_string()),
                Attribute::Matrix(_) | Attribute::Chromaticities(_) => None,
            })
        })
    }

    /// With how the picture is shown.
    pub fn with_look(&self, look: &Look, developer: &Developer) -> Self {
        let mut all = self.0.clone();
        all.push(("exposure", format!("{} stops", developer.stops)));
        all.push(("tonecurve", look.curve.name().to_owned()));
        match look.white {
            White::Auto => all.push(("white", "auto".to_owned())),
            White::Kelvin(kelvin) => all.push(("white", format!("{kelvin} K"))),
        }
        if look.bloom > 0.0 {
            all.push(("bloom", format!("{} pixels", look.bloom)));
        }
        Self(all)
    }

    /// With what false colours mean.
    pub fn with_layer(&self, colors: &FalseColor) -> Self {
        let mut all = self.0.clone();
        all.push(("Description", colors.to_string()));
        Self(all)
    }

    /// Keywords and texts.
    pub fn all(&self) -> &[(&'static str, String)] {
        &self.0
    }
}
