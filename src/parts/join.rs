//! Which parts belong together, and what is wrong with some: whatever can be said before any sum is added up.

use super::Cover;
use super::file::{PartHead, PartReader, film_of};
use crate::checkpoint::format::ReadError;
use bhs_core::camera::Film;
use bhs_engine::layer::NamedLayer;
use std::collections::BTreeMap;
use std::fs::File;
use std::path::{Path, PathBuf};

/// A part that has been read, and is whole.
#[derive(Clone, Debug)]
pub struct Part {
    /// Its file.
    pub path: PathBuf,
    /// What it is of.
    pub head: PartHead,
}

/// Which picture of several a part is of: the number of the frame and the name of the camera.
pub type PictureKey = (Option<u32>, Option<String>);

/// The parts of one picture.
#[derive(Clone, Debug)]
pub struct PictureParts {
    /// Which one.
    pub key: PictureKey,
    /// They have nothing in common; at least one.
    pub parts: Vec<Part>,
    /// What no part has.
    pub missing: Vec<Cover>,
}

impl PictureParts {
    /// All that the picture is to have.
    pub fn whole(&self) -> Option<Cover> {
        whole(&self.parts.first()?.head)
    }
}

/// All that the picture of a part is to have.
fn whole(head: &PartHead) -> Option<Cover> {
    let identity = head.identity.value();
    let mut whole = identity.clone();
    whole["samples"] = serde_json::json!([0, identity["samples"]]);
    Cover::from_json(&whole)
}

/// What has been found out about some files.
#[derive(Clone, Debug, Default)]
pub struct Sorted {
    /// By frame and camera.
    pub pictures: Vec<PictureParts>,
    /// What is wrong with the files that are in none of them.
    pub refused: Vec<String>,
}

/// Reads all files to their ends, one after the other, and puts together what belongs together. `open` opens a file, or says why not.
pub fn sort(paths: &[PathBuf], open: impl Fn(&Path) -> Result<File, String>) -> Sorted {
    let mut sorted = Sorted::default();
    let mut parts = Vec::new();
    let mut films = Films::default();
    for path in paths {
        match examine(path, &open, &mut films) {
            Ok(head) => parts.push(Part { path: path.clone(), head }),
            Err(why) => sorted.refused.push(why),
        }
    }
    // What most files are of is what all are to be of.
    let common = |of: &Part, other: &Part| {
        let texts = of.head.texts == other.head.texts && of.head.frame.is_some() == other.head.frame.is_some();
        let ignored: &[&str] = if texts { &["scene", "seed", "camera"] } else { &["seed", "camera"] };
        let difference = of.head.identity.first_difference(&other.head.identity, ignored);
        difference.or_else(|| (!texts).then(|| "it is of another scene, or of a frame where the others are of none".to_owned()))
    };
    let parts = keep_most(parts, common, &mut sorted.refused);
    let mut by_key: BTreeMap<PictureKey, Vec<Part>> = BTreeMap::new();
    for part in parts {
        by_key.entry((part.head.frame, part.head.camera().map(str::to_owned))).or_default().push(part);
    }
    for (key, parts) in by_key {
        let parts = keep_most(parts, |a, b| a.head.identity.first_difference(&b.head.identity, &[]), &mut sorted.refused);
        let parts = keep_single(parts, &mut sorted.refused);
        let Some(whole) = parts.first().and_then(|p| whole(&p.head)) else { continue };
        let missing = whole.missing(parts.iter().map(|p| &p.head.cover));
        sorted.pictures.push(PictureParts { key, parts, missing });
    }
    sorted
}

/// The last film that has been made, by its directive: most parts have the same.
#[derive(Default)]
struct Films(Option<(String, Option<Made>)>);

type Made = (Box<dyn Film>, Vec<NamedLayer>);

impl Films {
    fn of(&mut self, head: &PartHead) -> Option<&Made> {
        if self.0.as_ref().is_none_or(|(directive, _)| *directive != head.film) {
            self.0 = Some((head.film.clone(), film_of(head)));
        }
        self.0.as_ref()?.1.as_ref()
    }
}

/// The head of a part that is whole.
fn examine(path: &Path, open: &impl Fn(&Path) -> Result<File, String>, films: &mut Films) -> Result<PartHead, String> {
    let shown = path.display();
    let file = open(path).map_err(|why| format!("cannot read `{shown}`: {why}"))?;
    let words = |error: ReadError| match error {
        ReadError::CutShort => format!("`{shown}` is cut short: it ends early"),
        ReadError::Io(error) => format!("cannot read `{shown}`: {error}"),
        ReadError::Version(_) => format!("`{shown}` is of another version of bhs: {error}"),
        ReadError::Damaged(why) => format!("`{shown}` is damaged: {why}"),
    };
    let part = PartReader::new(file).map_err(words)?;
    let head = part.head.clone();
    let inside = whole(&head).is_some_and(|whole| whole.common(&head.cover) == Some(head.cover));
    let own = env!("CARGO_PKG_VERSION");
    match head.identity.value()["version"].as_str() {
        Some(version) if version == own => {}
        other => {
            let other = other.unwrap_or("none");
            return Err(format!("`{shown}` is of another version of bhs: {other}, not {own}; the one that made it can join it"));
        }
    }
    let (Some((film, layers)), true) = (films.of(&head), inside) else {
        return Err(format!("`{shown}` is damaged: what it is of makes no film"));
    };
    part.check(&**film, layers).map_err(words)?;
    Ok(head)
}

/// Of parts that `difference` tells apart, those that most are like; the first ones of as many. Says what the others differ in.
fn keep_most(parts: Vec<Part>, difference: impl Fn(&Part, &Part) -> Option<String>, refused: &mut Vec<String>) -> Vec<Part> {
    // The first of each kind, and how many there are.
    let mut kinds: Vec<(usize, usize)> = Vec::new();
    for (i, part) in parts.iter().enumerate() {
        match kinds.iter_mut().find(|(first, _)| difference(&parts[*first], part).is_none()) {
            Some((_, count)) => *count += 1,
            None => kinds.push((i, 1)),
        }
    }
    let most = kinds.iter().map(|(_, count)| *count).max();
    let Some(reference) = kinds.iter().find(|(_, count)| Some(*count) == most).map(|(first, _)| parts[*first].clone()) else {
        return parts;
    };
    let mut kept = Vec::with_capacity(parts.len());
    for part in parts {
        match difference(&reference, &part) {
            None => kept.push(part),
            Some(why) => {
                let (own, other) = (part.path.display(), reference.path.display());
                refused.push(format!("`{own}` does not belong to `{other}`: {why}"));
            }
        }
    }
    kept
}

/// Parts without those that have samples of one before them.
fn keep_single(parts: Vec<Part>, refused: &mut Vec<String>) -> Vec<Part> {
    let mut kept: Vec<Part> = Vec::with_capacity(parts.len());
    for part in parts {
        let other = kept.iter().find_map(|other| Some((other, other.head.cover.common(&part.head.cover)?)));
        match other {
            None => kept.push(part),
            Some((other, common)) => {
                let same = other.path.canonicalize().ok() == part.path.canonicalize().ok();
                refused.push(match same {
                    true => format!("`{}` is given twice: its samples would be doubled", part.path.display()),
                    false => format!("`{}` is doubled: {common}, are in `{}` too", part.path.display(), other.path.display()),
                });
            }
        }
    }
    kept
}
