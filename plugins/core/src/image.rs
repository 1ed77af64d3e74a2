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
}

impl Image {
    /// A picture of one texel.
    pub fn of_one_texel(rgb: [f32; 3]) -> Self {
        Self { width: 1, height: 1, texels: Texels::Floats(vec![rgb]) }
    }
}
