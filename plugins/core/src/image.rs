//! Pictures that a scene reads: for textures, and for light from far away.

/// The colours of a picture's texels, row after row from the top.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// Red, green and blue in eight bits, encoded (mostly as sRGB).
    Bytes(Vec<[u8; 3]>),
    /// Red, green and blue in 16 bits, encoded like the bytes.
    Words(Vec<[u16; 3]>),
    /// Red, green and blue, linear.
    Floats(Vec<[f32; 3]>),
}

/// A picture; a grey one has three equal channels. There is at least one texel.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Texels in a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The colours.
    pub texels: Texels,
    /// How opaque texels are, 255 being wholly so; `None`: all are, or the picture does not say.
    pub alpha: Option<Vec<u8>>,
    /// What whoever reads the picture should be told of it, such as which of several layers it is; in words that can follow
    /// "`file`: ".
    pub notes: Vec<String>,
    /// That the file says its encoded values are not sRGB, which is not followed; of no interest where the scene says how they are
    /// encoded.
    pub encoding_note: Option<String>,
}

impl Image {
    /// A picture of one texel.
    pub fn of_one_texel(rgb: [f32; 3]) -> Self {
        Self::new([1, 1], Texels::Floats(vec![rgb]))
    }

    /// A picture of the given width and height of which there is nothing to be told.
    pub fn new(size: [u32; 2], texels: Texels) -> Self {
        Self { width: size[0], height: size[1], texels, alpha: None, notes: Vec::new(), encoding_note: None }
    }

    /// The same with how opaque its texels are.
    #[must_use]
    pub fn with_alpha(self, alpha: Vec<u8>) -> Self {
        let says_something = alpha.iter().any(|a| *a < u8::MAX);
        Self { alpha: says_something.then_some(alpha), ..self }
    }
}
