//! OpenEXR files for who looks at more than the picture: the channels of all parts, and colours of any of them.

use super::exr::{Channels, Odd, flat_parts, luminance_weights, open, primaries, read_channels, rgb_of_chroma};
use super::exr_layer::{Choice, Colours, choose};
use super::primaries::srgb_from;
use glam::Vec3;

/// A channel of a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Channel {
    /// The part that has it, as a number in the file, and its number there.
    pub place: [usize; 2],
    /// Its name, after that of its part, where there are several.
    pub name: String,
}

/// Which channels are colours.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shown {
    /// Red, green, blue.
    Rgb([usize; 3]),
    /// Luminance, and red and blue as differences from it over it.
    Chroma([usize; 3]),
    /// Numbers, which are shown as red, green and blue are.
    Numbers([usize; 3]),
    /// One number, which is shown as grey.
    Grey(usize),
}

/// Colours of a file, in linear sRGB.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Width and height of the data window (texels).
    pub size: [usize; 2],
    /// First column and row of the data window within the display window.
    pub offset: [i64; 2],
    /// Width and height of the display window.
    pub frame: [usize; 2],
    /// Red, green and blue, row by row from the top; all of them finite.
    pub values: Vec<f32>,
    /// What was odd about the file.
    pub notes: Vec<String>,
}

/// The channels of all parts that can be read.
///
/// # Errors
/// What is wrong with the file, in words that can follow "cannot read `file`: ".
pub fn channels(bytes: &[u8]) -> Result<Vec<Channel>, String> {
    let parts = flat_parts(open(bytes)?.headers())?;
    let several = parts.len() > 1;
    let named = |part: &str, channel: &String| match several && !part.is_empty() && !channel.starts_with(&format!("{part}.")) {
        true => format!("{part}.{channel}"),
        false => channel.clone(),
    };
    let all = parts.iter().flat_map(|part| {
        part.channels
            .iter()
            .enumerate()
            .map(move |(i, channel)| Channel { place: [part.index, i], name: named(&part.name, channel) })
    });
    Ok(all.collect())
}

/// The part and the channels that are the picture, and a note if others might be.
///
/// # Errors
/// That there is none.
pub fn picture_of(bytes: &[u8]) -> Result<(usize, Shown, Option<String>), String> {
    let Choice { part, colours, note } = choose(&flat_parts(open(bytes)?.headers())?)?;
    let shown = match colours {
        Colours::Rgb(rgb) => Shown::Rgb(rgb),
        Colours::Grey(y) => Shown::Grey(y),
        Colours::Chroma(chroma) => Shown::Chroma(chroma),
    };
    Ok((part, shown, note))
}

/// All channels of a part.
///
/// # Errors
/// What is wrong with the file.
pub fn read_part(bytes: &[u8], part: usize) -> Result<Channels, String> {
    read_channels(open(bytes)?, part)
}

/// Channels of a part as colours: those of other primaries become sRGB, and what is no number is told.
///
/// # Errors
/// What is wrong with the file.
pub fn read_colours(bytes: &[u8], part: usize, shown: Shown) -> Result<Picture, String> {
    let reader = open(bytes)?;
    let chromaticities = reader.headers()[part].shared_attributes.chromaticities;
    let all = read_channels(reader, part)?;
    let (mut odd, mut notes) = (Odd::default(), Vec::new());
    let weights = luminance_weights(chromaticities);
    let matrix = match (shown, chromaticities.map(|c| srgb_from(primaries(c)))) {
        (Shown::Rgb(_) | Shown::Chroma(_), Some(Ok(matrix))) => matrix,
        (Shown::Rgb(_) | Shown::Chroma(_), Some(Err(why))) => {
            notes.push(why.to_owned());
            None
        }
        _ => None,
    };
    let mut values = Vec::with_capacity(3 * all.size[0] * all.size[1]);
    for texel in all.values.chunks_exact(all.names.len()) {
        let colour = match shown {
            Shown::Rgb(of) | Shown::Numbers(of) => of.map(|c| odd.number(texel[c])),
            Shown::Chroma(of) => rgb_of_chroma(of.map(|c| odd.number(texel[c])), weights),
            Shown::Grey(c) => [odd.number(texel[c]); 3],
        };
        values.extend(matrix.map_or(colour, |m| (m * Vec3::from_array(colour)).to_array()));
    }
    notes.extend(odd.notes());
    Ok(Picture { size: all.size, offset: all.offset, frame: all.frame, values, notes })
}
