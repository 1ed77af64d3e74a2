//! What stands between the quotes and brackets of a scene: typed, named values that no plugin has read yet.

use crate::diagnostics::{Span, Spanned};

/// The type word of a parameter, as in `"float step" 0.1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ParamType {
    /// Real numbers.
    Float,
    /// Whole numbers.
    Integer,
    /// `true` or `false`.
    Bool,
    /// Text in quotes.
    String,
    /// Pairs of numbers: a place.
    Point2,
    /// Pairs of numbers: a direction.
    Vector2,
    /// Triples of numbers: a place.
    Point3,
    /// Triples of numbers: a direction.
    Vector3,
    /// Triples of numbers: a surface normal.
    Normal,
    /// A spectrum: a number, wavelength-value pairs, a built-in name or a file name.
    Spectrum,
    /// A colour as three linear sRGB numbers.
    Rgb,
    /// A temperature in kelvin.
    Blackbody,
    /// A temperature in kelvin, far from the hole.
    Tolman,
    /// The name of a texture.
    Texture,
}

impl ParamType {
    /// All types, in the order of the language reference.
    pub const ALL: [ParamType; 14] = [
        Self::Float,
        Self::Integer,
        Self::Bool,
        Self::String,
        Self::Point2,
        Self::Vector2,
        Self::Point3,
        Self::Vector3,
        Self::Normal,
        Self::Spectrum,
        Self::Rgb,
        Self::Blackbody,
        Self::Tolman,
        Self::Texture,
    ];

    /// The word that the language uses.
    pub fn word(self) -> &'static str {
        match self {
            Self::Float => "float",
            Self::Integer => "integer",
            Self::Bool => "bool",
            Self::String => "string",
            Self::Point2 => "point2",
            Self::Vector2 => "vector2",
            Self::Point3 => "point3",
            Self::Vector3 => "vector3",
            Self::Normal => "normal",
            Self::Spectrum => "spectrum",
            Self::Rgb => "rgb",
            Self::Blackbody => "blackbody",
            Self::Tolman => "tolman",
            Self::Texture => "texture",
        }
    }

    /// The type that `word` names; `point`, `vector` and `normal3` are accepted as pbrt does.
    pub fn from_word(word: &str) -> Option<Self> {
        match word {
            "point" => Some(Self::Point3),
            "vector" => Some(Self::Vector3),
            "normal3" => Some(Self::Normal),
            _ => Self::ALL.into_iter().find(|t| t.word() == word),
        }
    }
}

/// The values of one parameter, all of one kind. All numbers are finite.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Numbers; `whole` says that all of them were written without a point or an exponent.
    Numbers {
        /// The numbers in order.
        values: Vec<f64>,
        /// Whether all of them are integers.
        whole: bool,
    },
    /// Quoted texts, each with its own place.
    Strings(Vec<Spanned<String>>),
    /// `true` and `false`.
    Bools(Vec<bool>),
}

impl Values {
    /// What the values are, in words for a message: `a number`, `3 numbers`, `a string`, ...
    pub fn describe(&self) -> String {
        let (count, one, many) = match self {
            Self::Numbers { values, whole: true } => (values.len(), "an integer", "integers"),
            Self::Numbers { values, whole: false } => (values.len(), "a number", "numbers"),
            Self::Strings(s) => (s.len(), "a string", "strings"),
            Self::Bools(b) => (b.len(), "a bool", "bools"),
        };
        match count {
            0 => "an empty list".to_owned(),
            1 => one.to_owned(),
            n => format!("{n} {many}"),
        }
    }
}

/// One `"type name" values` of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Param {
    /// The type word and its place.
    pub ty: Spanned<ParamType>,
    /// The name and its place.
    pub name: Spanned<String>,
    /// The values.
    pub values: Values,
    /// The place of the values, brackets included.
    pub span: Span,
}
