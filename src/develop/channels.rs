//! Which channels a name of a layer means.

use crate::image::Picture;
use crate::layers::LayerPicture;
use crate::registry::{Kind, Registry};
use bhs_core::diagnostics::did_you_mean;
use bhs_engine::layer::{Layer, LayerFormat, Value};
use bhs_textures::decode::exr_parts::Shown;

/// A layer that bhs records: its name, and what its numbers are.
pub type Known = (&'static str, LayerFormat);

/// The layers that bhs records.
pub fn known() -> Vec<Known> {
    let all = Registry::builtin().describe();
    let layers = all.into_iter().filter(|plugin| plugin.kind == <dyn Layer>::WORD);
    layers.filter_map(|plugin| Some((plugin.name, plugin.format?))).collect()
}

/// Channels of a layer, by their numbers among those of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// From one to three.
    pub channels: Vec<usize>,
    /// Whether they are red, green and blue.
    pub are_colours: bool,
    /// The layer of bhs that they are.
    pub known: Option<Known>,
}

/// The channels of the layer `name`: those that bhs gives to the layer of this name; those called `NAME.R` or the like; the channel of this name.
///
/// # Errors
/// What there is instead.
pub fn find(names: &[&str], name: &str, known: &[Known]) -> Result<Found, String> {
    let position = |wanted: &str| names.iter().position(|n| *n == wanted);
    if let Some(layer) = known.iter().find(|(own, _)| *own == name)
        && let Some(channels) = layer.1.channels.iter().map(|c| position(c)).collect::<Option<Vec<_>>>()
    {
        return Ok(Found { channels, are_colours: last_words_are_colours(layer.1.channels), known: Some(*layer) });
    }
    let prefix = format!("{name}.");
    let mut own: Vec<(usize, &str)> = names.iter().enumerate().filter_map(|(i, n)| Some((i, n.strip_prefix(&prefix)?))).collect();
    own.retain(|(_, last)| !last.contains('.') && !matches!(last.to_lowercase().as_str(), "a" | "alpha"));
    let rank = |last: &str| ["r", "g", "b", "x", "y", "z", "u", "v"].iter().position(|w| last.to_lowercase().starts_with(w));
    // Files have their channels in the order of their names, pictures that are rendered in that of their film.
    own.sort_by_key(|(_, last)| (rank(last).unwrap_or(usize::MAX), *last));
    match own.len() {
        1..=3 => {
            let last: Vec<&str> = own.iter().map(|(_, last)| *last).collect();
            let are_colours = last_words_are_colours(&last);
            return Ok(Found { channels: own.into_iter().map(|(i, _)| i).collect(), are_colours, known: None });
        }
        4.. => {
            let all: Vec<&str> = own.iter().map(|(i, _)| names[*i]).collect();
            return Err(format!(
                "`{name}` has {} channels, of which three can be shown: name one of {}",
                all.len(),
                all.join(", ")
            ));
        }
        0 => {}
    }
    if let Some(i) = position(name) {
        return Ok(Found { channels: vec![i], are_colours: false, known: None });
    }
    let all = layers(names, known);
    Err(match did_you_mean(name, all.iter().map(String::as_str)) {
        Some(near) => format!("there is no layer `{name}`; did you mean `{near}`? There is {}", all.join(", ")),
        None if all.is_empty() => format!("there is no layer `{name}`, nor any other: `render --aov NAME` records one"),
        None => format!("there is no layer `{name}`; there is {}", all.join(", ")),
    })
}

/// The names of all layers that channels of these names make.
pub fn layers(names: &[&str], known: &[Known]) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    let mut taken: Vec<&str> = vec!["R", "G", "B", "A"];
    for (name, format) in known {
        if format.channels.iter().all(|c| names.contains(c)) {
            all.push((*name).to_owned());
            taken.extend(format.channels);
        }
    }
    for name in names.iter().filter(|name| !taken.contains(name)) {
        let layer = name.rsplit_once('.').map_or(*name, |(layer, _)| layer);
        if !all.iter().any(|known| known == layer) {
            all.push(layer.to_owned());
        }
    }
    all
}

/// Whether the last words of three names are red, green and blue.
fn last_words_are_colours(names: &[&str]) -> bool {
    let last = |name: &&str| name.rsplit('.').next().unwrap_or_default().to_lowercase();
    let words: Vec<String> = names.iter().map(last).collect();
    [["r", "g", "b"], ["red", "green", "blue"]].iter().any(|rgb| words.iter().map(String::as_str).eq(rgb.iter().copied()))
}

impl Found {
    /// How they are shown where they are not in false colours: one alone as grey, the third of two as 0.
    pub fn shown(&self) -> Shown {
        match *self.channels {
            [r, g, b, ..] if self.are_colours => Shown::Rgb([r, g, b]),
            [a, b, c, ..] => Shown::Numbers([a, b, c]),
            [a, b] => Shown::Pair([a, b]),
            [grey] => Shown::Grey(grey),
            [] => Shown::Grey(0),
        }
    }
}

impl Picture {
    /// Some channels as a layer; a pixel without a value has -0 in all of them ([`Picture::with_layers`]), or what is no number.
    pub fn layer(&self, found: &Found) -> LayerPicture {
        let channels = &found.channels;
        let (name, format) = found.known.unwrap_or_else(|| unknown(channels.len()));
        let value = |pixel: &[f32]| -> Option<Value> {
            let none = channels.iter().all(|c| pixel[*c] == 0.0 && pixel[*c].is_sign_negative());
            let odd = channels.iter().any(|c| !pixel[*c].is_finite());
            (!none && !odd).then(|| std::array::from_fn(|c| channels.get(c).map_or(0.0, |c| f64::from(pixel[*c]))))
        };
        LayerPicture { name, format, values: self.data.chunks_exact(self.channels.len()).map(value).collect() }
    }
}

/// What the numbers of a layer are that bhs does not know.
fn unknown(count: usize) -> Known {
    const CHANNELS: [&str; 3] = ["1", "2", "3"];
    ("the layer", LayerFormat::new(&CHANNELS[..count.clamp(1, 3)], ""))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_layers_mean_their_channels() {
        let known = known();
        let names = [
            "A",
            "B",
            "Diffuse.A",
            "Diffuse.B",
            "Diffuse.G",
            "Diffuse.R",
            "G",
            "Ns.X",
            "Ns.Y",
            "Ns.Z",
            "R",
            "depth",
            "many.a1",
            "many.b",
            "many.c",
            "many.d",
        ];
        let find = |name: &str| find(&names, name, &known);
        let channels = |name: &str| find(name).map(|found| (found.channels, found.are_colours));
        assert_eq!(channels("Diffuse"), Ok((vec![5, 4, 3], true)));
        assert_eq!(channels("Diffuse.G"), Ok((vec![4], false)));
        assert_eq!(channels("shadingnormal"), channels("Ns"));
        assert_eq!(channels("R"), Ok((vec![10], false)));
        // Whatever the order of the channels.
        for names in [["S.q", "S.p", "x"], ["x", "S.p", "S.q"]] {
            let found = super::find(&names, "S", &known).expect("a layer");
            assert_eq!(found.channels.iter().map(|c| names[*c]).collect::<Vec<_>>(), ["S.p", "S.q"]);
        }
        let said = find("dept").expect_err("no such layer");
        assert!(said.contains("did you mean `depth`?") && said.contains("shadingnormal, depth, Diffuse"), "{said}");
        assert!(find("many").expect_err("too many").contains("4 channels"));
        assert!(super::find(&["R", "G", "B"], "depth", &known).expect_err("none").contains("--aov"));
    }
}
