//! EXR files that are developed: those of bhs, and those of other programs.

use super::channels::{self, Found, Known};
use super::{Content, Texts};
use crate::image::{Frame, Picture, word};
use crate::look::Look;
use anyhow::{Context, Result, anyhow};
use bhs_textures::decode::exr_parts::{self, Channel};
use exr::meta::MetaData;
use exr::meta::attribute::Chromaticities;
use std::borrow::Cow;
use std::cell::RefCell;
use std::collections::BTreeMap;
use std::io::{Cursor, Read};
use std::path::{Path, PathBuf};
use std::rc::Rc;

/// An EXR file.
pub struct Input {
    path: PathBuf,
    bytes: Vec<u8>,
    channels: Vec<Channel>,
    known: Vec<Known>,
    /// What its header says, as words.
    header: BTreeMap<String, String>,
    /// The parts that have been asked for, by their number: each is decoded once, however many layers are shown.
    decoded: RefCell<BTreeMap<usize, Rc<Part>>>,
}

/// A part of a file.
struct Part {
    picture: Picture,
    chromaticities: Option<Chromaticities>,
}

impl Input {
    /// Reads a file that has been opened.
    ///
    /// # Errors
    /// If it is no EXR file that can be read.
    pub fn read(path: &Path, mut from: impl Read) -> Result<Self> {
        let mut bytes = Vec::new();
        from.read_to_end(&mut bytes).with_context(|| format!("cannot read `{}`", path.display()))?;
        let channels = exr_parts::channels(&bytes).map_err(|why| cannot_read(path, &bytes, &why))?;
        let header = header(&bytes);
        Ok(Self { path: path.to_owned(), bytes, channels, known: channels::known(), header, decoded: RefCell::default() })
    }

    /// How its header says that it is shown; a picture of another program as it is.
    pub fn look(&self) -> Look {
        Look::of_words(|name| self.header.get(&format!("bhs:{name}")).cloned())
    }

    /// What PNG files of it say.
    pub fn texts(&self) -> Texts {
        Texts::of(|name| self.header.get(name).cloned())
    }

    /// Its picture, and notes about it.
    ///
    /// # Errors
    /// If it cannot be read, or there is none.
    pub fn picture(&self) -> Result<(Content<'static>, Vec<String>)> {
        let (part, shown, note) = exr_parts::picture_of(&self.bytes).map_err(|why| {
            let layers = self.layers().join(", ");
            anyhow!("cannot develop `{}`: {why}; --layer NAME shows one of {layers}", self.path.display())
        })?;
        let part = self.part(part)?;
        let (picture, notes) = super::colours(&part.picture, shown, part.chromaticities);
        let note = note.map(|note| {
            note.replace("to read another one, save it as R, G and B without a layer's name", "--layer NAME shows another one")
        });
        Ok((Content::Colours(Cow::Owned(picture)), note.into_iter().chain(notes).collect()))
    }

    /// A layer, and notes about it.
    ///
    /// # Errors
    /// If it cannot be read, or there is none.
    pub fn layer(&self, name: &str, false_color: bool) -> Result<(Content<'static>, Vec<String>)> {
        let found = self.find(name)?;
        let (part, channels) = self.place(&found)?;
        let part = self.part(part)?;
        Ok(Content::of(&part.picture, &Found { channels, ..found }, part.chromaticities, false_color))
    }

    /// A part, which is decoded once.
    fn part(&self, number: usize) -> Result<Rc<Part>> {
        if let Some(part) = self.decoded.borrow().get(&number) {
            return Ok(part.clone());
        }
        let read = exr_parts::read_part(&self.bytes, number).map_err(|why| cannot_read(&self.path, &self.bytes, &why))?;
        let exr_parts::Part { channels, chromaticities } = read;
        let frame = Frame { offset: channels.offset.map(|o| o.max(0) as usize), size: channels.frame };
        let picture = Picture { size: channels.size, frame, channels: channels.names, data: channels.values };
        let part = Rc::new(Part { picture, chromaticities });
        self.decoded.borrow_mut().insert(number, part.clone());
        Ok(part)
    }

    /// The names of its layers.
    pub fn layers(&self) -> Vec<String> {
        channels::layers(&self.names(), &self.known)
    }

    /// The layers that bhs has recorded in it.
    pub fn recorded(&self) -> impl Iterator<Item = &'static str> {
        let names = self.names();
        let whole = move |(_, format): &&Known| format.channels.iter().all(|c| names.contains(c));
        self.known.iter().filter(whole).map(|(name, _)| *name)
    }

    fn names(&self) -> Vec<&str> {
        self.channels.iter().map(|c| c.name.as_str()).collect()
    }

    fn find(&self, name: &str) -> Result<Found> {
        channels::find(&self.names(), name, &self.known).map_err(|why| anyhow!("cannot develop `{}`: {why}", self.path.display()))
    }

    /// The part that has the channels, and their numbers there.
    fn place(&self, found: &Found) -> Result<(usize, Vec<usize>)> {
        let places: Vec<[usize; 2]> = found.channels.iter().map(|c| self.channels[*c].place).collect();
        let part = places[0][0];
        if places.iter().any(|place| place[0] != part) {
            return Err(anyhow!(
                "cannot develop `{}`: the channels of the layer lie in several parts of the file",
                self.path.display()
            ));
        }
        Ok((part, places.into_iter().map(|[_, channel]| channel).collect()))
    }
}

/// What is wrong with a file, with what it is if it is of another kind.
fn cannot_read(path: &Path, bytes: &[u8], why: &str) -> anyhow::Error {
    const MAGIC: [u8; 4] = [0x76, 0x2f, 0x31, 0x01];
    let shown = path.display();
    let kinds: [(&[u8], &str); 5] = [
        (b"\x89PNG", "a PNG picture, which has been developed: develop the EXR file beside it"),
        (b"\xff\xd8\xff", "a JPEG picture, which has been developed"),
        (b"#?", "a Radiance HDR picture: save it as EXR"),
        (b"bhs-checkpoint", "a checkpoint: `bhs render SCENE --resume` makes a picture of it"),
        (b"II*\0", "a TIFF picture: save it as EXR"),
    ];
    match kinds.iter().find(|(magic, _)| bytes.starts_with(magic)) {
        _ if bytes.starts_with(&MAGIC) => anyhow!("cannot read `{shown}`: {why}"),
        Some((_, what)) => anyhow!("cannot read `{shown}` as an EXR picture: it is {what}"),
        None if bytes.is_empty() => anyhow!("cannot read `{shown}` as an EXR picture: it is empty"),
        None => anyhow!("cannot read `{shown}` as an EXR picture: it does not begin as one"),
    }
}

/// What the header of the first part says, as words.
fn header(bytes: &[u8]) -> BTreeMap<String, String> {
    let Ok(meta) = MetaData::read_from_buffered(Cursor::new(bytes), false) else { return BTreeMap::new() };
    let Some(first) = meta.headers.first() else { return BTreeMap::new() };
    first.own_attributes.other.iter().filter_map(|(name, value)| Some((name.to_string(), word(value)?))).collect()
}
