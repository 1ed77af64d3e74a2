//! Which channels of an OpenEXR file are the picture.
//!
//! The name of a channel is that of its layer, a dot, and that of the channel itself; a file can have several parts with names of their
//! own. Channels without a layer come first, as in all programs; then a layer called as the finished picture is (`Combined`, `beauty`);
//! then any other, and if there are several, the note says which one is read.

use std::collections::BTreeMap;

/// A part of a file: its name, and those of its channels.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Part {
    /// Number in the file.
    pub(super) index: usize,
    pub(super) name: String,
    pub(super) channels: Vec<String>,
}

/// Which channels are the picture, as numbers of their part's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Colours {
    Rgb([usize; 3]),
    Grey(usize),
    /// Y, RY, BY: luminance, and red and blue as differences from it over it.
    Chroma([usize; 3]),
}

/// What is read of a file.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Choice {
    /// Number of the part.
    pub(super) part: usize,
    pub(super) colours: Colours,
    pub(super) note: Option<String>,
}

/// Last words of the names that programs give to the finished picture, in lower case.
const FINISHED: &[&str] =
    &["combined", "beauty", "rgba", "rgb", "color", "colour", "main", "final", "composite", "image", "c", "ci"];

/// A set of channels that is a picture.
struct Layer {
    part: usize,
    /// The part's name and the layer's, as far as there are any.
    name: String,
    rank: u32,
    colours: Colours,
}

/// Finds the picture.
///
/// # Errors
/// That there is none, with the channels that there are.
pub(super) fn choose(parts: &[Part]) -> Result<Choice, String> {
    let mut layers: Vec<Layer> = parts.iter().flat_map(|p| layers_of(p, parts.len() > 1)).collect();
    // A stable sort: of equal rank, the first in the file.
    layers.sort_by_key(|l| l.rank);
    if let Some(best) = layers.first() {
        let rivals: Vec<&str> = layers.iter().map(|l| l.name.as_str()).collect();
        // The picture without a name, or the only finished one, is what everybody means.
        let is_plain = layers.len() == 1 || best.rank == 0 || (best.rank == 1 && layers[1].rank > 1);
        let note = (!is_plain).then(|| {
            let advice = "to read another one, save it as R, G and B without a layer's name";
            format!("it holds several layers, of which `{}` is read ({}); {advice}", best.name, shown(&rivals))
        });
        return Ok(Choice { part: best.part, colours: best.colours, note });
    }
    if let [Part { index, channels, .. }] = parts
        && let [only] = channels.as_slice()
    {
        let note = Some(format!("its only channel, `{only}`, is read as grey"));
        return Ok(Choice { part: *index, colours: Colours::Grey(0), note });
    }
    let all: Vec<&str> = parts.iter().flat_map(|p| p.channels.iter().map(String::as_str)).collect();
    Err(format!("it has no channels R, G and B, and no Y, but {}", shown(&all)))
}

/// Names in a row, the first dozen of them.
fn shown(names: &[&str]) -> String {
    const MOST: usize = 12;
    let mut text = names.iter().take(MOST).copied().collect::<Vec<_>>().join(", ");
    if names.len() > MOST {
        text += &format!(" and {} more", names.len() - MOST);
    }
    text
}

fn layers_of(part: &Part, is_one_of_several: bool) -> Vec<Layer> {
    // By layer, channels with their numbers; unnamed ones may stand among those of layers.
    let mut by_prefix: BTreeMap<&str, Vec<(String, usize)>> = BTreeMap::new();
    for (i, name) in part.channels.iter().enumerate() {
        let (prefix, channel) = name.rsplit_once('.').unwrap_or(("", name));
        by_prefix.entry(prefix).or_default().push((channel.to_lowercase(), i));
    }
    let mut layers: Vec<_> = by_prefix.into_iter().collect();
    layers.sort_by_key(|(_, channels)| channels[0].1);
    let layers = layers.into_iter().filter_map(|(prefix, channels)| {
        let name = match (is_one_of_several, part.name.as_str(), prefix) {
            (true, part, "") => part.to_owned(),
            (true, part, prefix) if !part.is_empty() && !prefix.starts_with(part) => format!("{part}.{prefix}"),
            (_, _, prefix) => prefix.to_owned(),
        };
        let is_finished = FINISHED.contains(&name.rsplit('.').next().unwrap_or_default().to_lowercase().as_str());
        let rank = match prefix {
            "" if name.is_empty() || is_finished => 0,
            _ if is_finished => 1,
            "" => 2,
            _ => 3,
        };
        let colours = colours_of(&channels)?;
        // Colours come before grey, which may be anything.
        let rank = if matches!(colours, Colours::Grey(_)) { rank + 4 } else { rank };
        Some(Layer { part: part.index, name, rank, colours })
    });
    layers.collect()
}

/// The picture that channels of one layer are, if any.
fn colours_of(channels: &[(String, usize)]) -> Option<Colours> {
    let find = |words: &[&str]| {
        let number = |word: &str| channels.iter().find(|(name, _)| name == word).map(|(_, i)| *i);
        words.iter().find_map(|w| number(w))
    };
    if let (Some(r), Some(g), Some(b)) = (find(&["r", "red"]), find(&["g", "green"]), find(&["b", "blue"])) {
        return Some(Colours::Rgb([r, g, b]));
    }
    let y = find(&["y"])?;
    if let (Some(ry), Some(by)) = (find(&["ry"]), find(&["by"])) {
        return Some(Colours::Chroma([y, ry, by]));
    }
    // X, Y and Z are a position, a normal or CIE XYZ.
    let is_vector = find(&["x"]).is_some() && find(&["z"]).is_some();
    (!is_vector).then_some(Colours::Grey(y))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn part(index: usize, name: &str, channels: &str) -> Part {
        Part { index, name: name.into(), channels: channels.split(' ').map(str::to_owned).collect() }
    }

    /// Parts with their channels; the part that is read, its channels, and what the note says.
    type Case<'a> = (&'a [(&'a str, &'a str)], usize, Colours, &'a str);

    #[test]
    fn the_picture_is_found_among_layers_and_parts() {
        // What programs write.
        let table: &[Case] = &[
            (&[("", "B G R")], 0, Colours::Rgb([2, 1, 0]), ""),
            (&[("", "A Albedo.B Albedo.G Albedo.R B G R Z")], 0, Colours::Rgb([6, 5, 4]), ""),
            // Blender, one part and several.
            (
                &[("", "View.AO.B View.AO.G View.AO.R View.Combined.B View.Combined.G View.Combined.R")],
                0,
                Colours::Rgb([5, 4, 3]),
                "",
            ),
            (
                &[("View.Depth", "View.Depth.Z"), ("View.Combined", "View.Combined.B View.Combined.G View.Combined.R")],
                1,
                Colours::Rgb([2, 1, 0]),
                "",
            ),
            // Houdini, RenderMan, Arnold, lower case.
            (&[("", "C.b C.g C.r N.x N.y N.z")], 0, Colours::Rgb([2, 1, 0]), ""),
            (&[("", "blue green red")], 0, Colours::Rgb([2, 1, 0]), ""),
            // Nuke and OpenImageIO: names of parts.
            (&[("albedo", "B G R"), ("rgba", "A B G R")], 1, Colours::Rgb([3, 2, 1]), ""),
            (&[("depth", "Z"), ("", "B G R")], 1, Colours::Rgb([2, 1, 0]), ""),
            (&[("depth", "Z"), ("picture", "B G R")], 1, Colours::Rgb([2, 1, 0]), ""),
            // A channel without a layer goes before any with one, a colour before grey.
            (&[("", "B Combined.B Combined.G Combined.R G R")], 0, Colours::Rgb([5, 4, 0]), ""),
            (&[("", "Combined.B Combined.G Combined.R Y")], 0, Colours::Rgb([2, 1, 0]), ""),
            (&[("", "A Y")], 0, Colours::Grey(1), ""),
            (&[("", "BY RY Y")], 0, Colours::Chroma([2, 1, 0]), ""),
            (&[("", "Y Z")], 0, Colours::Grey(0), ""),
            (&[("", "Z")], 0, Colours::Grey(0), "`Z`"),
            // No telling which: the note names them.
            (&[("", "AO.B AO.G AO.R Diffuse.B Diffuse.G Diffuse.R")], 0, Colours::Rgb([2, 1, 0]), "(AO, Diffuse)"),
            (
                &[("", "Fog.Combined.B Fog.Combined.G Fog.Combined.R Sun.Combined.B Sun.Combined.G Sun.Combined.R")],
                0,
                Colours::Rgb([2, 1, 0]),
                "`Fog.Combined`",
            ),
            (&[("left", "B G R"), ("right", "B G R")], 0, Colours::Rgb([2, 1, 0]), "(left, right)"),
        ];
        for (parts, wanted, colours, told) in table {
            let parts: Vec<Part> = parts.iter().enumerate().map(|(i, (name, channels))| part(i, name, channels)).collect();
            let choice = choose(&parts).unwrap_or_else(|e| panic!("{parts:?}: {e}"));
            assert_eq!((choice.part, choice.colours), (*wanted, *colours), "{parts:?}");
            assert_eq!(choice.note.is_some(), !told.is_empty(), "{parts:?} {:?}", choice.note);
            assert!(choice.note.unwrap_or_default().contains(told), "{parts:?}");
        }
    }

    #[test]
    fn what_is_no_picture_names_its_channels() {
        let error = |channels| choose(&[part(0, "", channels)]).expect_err("no picture");
        assert_eq!(error("A Z"), "it has no channels R, G and B, and no Y, but A, Z");
        assert_eq!(error("N.X N.Y N.Z"), "it has no channels R, G and B, and no Y, but N.X, N.Y, N.Z");
    }
}
