//! OpenEXR files for who looks at more than the picture: the channels of all parts, and colours of any of them.

use super::exr::{Channels, Odd, flat_parts, luminance_weights, open, primaries, read_channels, rgb_of_chroma};
use super::exr_layer::{Choice, Colours, choose};
use super::primaries::srgb_from;
use exr::meta::attribute::Chromaticities;
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
    /// Two numbers, which are shown as red and green are.
    Pair([usize; 2]),
    /// One number, which is shown as grey.
    Grey(usize),
}

/// A part of a file, decoded.
#[derive(Clone, Debug)]
pub struct Part {
    /// Its channels.
    pub channels: Channels,
    /// The primaries and the white of its colours, if the file names them.
    pub chromaticities: Option<Chromaticities>,
}

/// Some channels as colours.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownColours {
    /// Red, green and blue in linear sRGB, row by row from the top; all of them finite.
    pub values: Vec<f32>,
    /// What was odd about them.
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
pub fn read_part(bytes: &[u8], part: usize) -> Result<Part, String> {
    let reader = open(bytes)?;
    let chromaticities = reader.headers()[part].shared_attributes.chromaticities;
    Ok(Part { channels: read_channels(reader, part)?, chromaticities })
}

/// Some of the `count` channels of each pixel as colours: those of other primaries become sRGB, a number that is none becomes 0, and an infinite one
/// large.
pub fn colours(values: &[f32], count: usize, shown: Shown, chromaticities: Option<Chromaticities>) -> ShownColours {
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
    let mut rgb = Vec::with_capacity(values.len() / count.max(1) * 3);
    for texel in values.chunks_exact(count.max(1)) {
        let colour = match shown {
            Shown::Rgb(of) | Shown::Numbers(of) => of.map(|c| odd.number(texel[c])),
            Shown::Pair(of) => {
                let [a, b] = of.map(|c| odd.number(texel[c]));
                [a, b, 0.0]
            }
            Shown::Chroma(of) => rgb_of_chroma(of.map(|c| odd.number(texel[c])), weights),
            Shown::Grey(c) => [odd.number(texel[c]); 3],
        };
        rgb.extend(matrix.map_or(colour, |m| (m * Vec3::from_array(colour)).to_array()));
    }
    notes.extend(odd.notes());
    ShownColours { values: rgb, notes }
}
