//! The file of a part: exact sums of some samples of a window, and what has to be known to join them with others.
//!
//! It has the sections of a checkpoint's file ([`crate::checkpoint::format`]), these:
//!
//! | kind | content |
//! |---|---|
//! | `PART` | JSON: what the whole picture is ([`Identity`]), what the part covers, the film's directive, what the header of the picture says |
//! | `STAT` | JSON: seconds of rendering, counts, samples that were not finite |
//! | `STAR` | what points of the sky add to pixels: column, row (4 bytes each) and channels (8 each) of those that have some; in parts with sample 0 |
//! | `TILE` | for each tile of the window, row by row: its number (4 bytes), its progress and its exact sums ([`Tile::to_bytes`]) |
//! | `END ` | the number of the tiles before (4 bytes) |

use super::Cover;
use crate::checkpoint::format::{ReadError, Reader, SectionKind, Writer};
use crate::checkpoint::{Identity, from_statistics, statistics};
use crate::film::Tile;
use crate::header::Facts;
use crate::lang::{BuiltScene, SourceMap, film_alone};
use crate::point_picture::PointPicture;
use crate::registry::Registry;
use crate::render::{Rendered, Snapshot};
use bhs_core::camera::Film;
use bhs_engine::layer::NamedLayer;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::{BufReader, Write};
use std::path::Path;
use std::sync::PoisonError;

const PART: SectionKind = *b"PART";
const STATISTICS: SectionKind = *b"STAT";
const STARS: SectionKind = *b"STAR";
const TILE: SectionKind = *b"TILE";
const END: SectionKind = *b"END ";

/// What a part is of.
#[derive(Clone, Debug, PartialEq)]
pub struct PartHead {
    /// What the whole picture is.
    pub identity: Identity,
    /// A hash of the scene's texts alone: frames of a film have that in common.
    pub texts: String,
    /// What the part covers.
    pub cover: Cover,
    /// The number of the frame, if it is one of several.
    pub frame: Option<u32>,
    /// The directive of the film.
    pub film: String,
    /// What the header of the picture says.
    pub facts: Facts,
}

impl PartHead {
    /// That of a part of the current picture of a scene.
    pub fn of(built: &BuiltScene, cover: Cover, frame: Option<u32>) -> Self {
        Self {
            identity: Identity::of(built),
            texts: built.texts_hash.clone(),
            cover,
            frame,
            film: built.film_directive.clone(),
            facts: Facts::of(built),
        }
    }

    /// The name of the camera, if it has one.
    pub fn camera(&self) -> Option<&str> {
        self.facts.camera.as_deref()
    }

    fn to_json(&self) -> Value {
        json!({
            "identity": self.identity.value(),
            "texts": self.texts,
            "cover": self.cover.to_json(),
            "frame": self.frame,
            "film": self.film,
            "facts": self.facts.to_json(),
        })
    }

    fn from_json(text: &[u8]) -> Option<Self> {
        let value: Value = serde_json::from_slice(text).ok()?;
        let text = |name: &str| value[name].as_str().map(str::to_owned);
        Some(Self {
            identity: Identity::from_json(value["identity"].to_string().as_bytes())?,
            texts: text("texts")?,
            cover: Cover::from_json(&value["cover"])?,
            frame: match &value["frame"] {
                Value::Null => None,
                number => Some(number.as_u64()?.try_into().ok()?),
            },
            film: text("film")?,
            facts: Facts::from_json(&value["facts"])?,
        })
    }
}

/// Writes a part that has been rendered.
///
/// # Errors
/// If it cannot be written.
pub fn write(to: impl Write, head: &PartHead, rendered: &Rendered) -> std::io::Result<()> {
    let mut writer = Writer::new(to)?;
    writer.section(PART, &[head.to_json().to_string().as_bytes()])?;
    let snapshot = Snapshot {
        counters: rendered.counters,
        not_finite: rendered.not_finite.clone(),
        seconds: rendered.seconds,
        ..Snapshot::default()
    };
    writer.section(STATISTICS, &[statistics(&snapshot).to_string().as_bytes()])?;
    if let Some(points) = rendered.frame.points().filter(|_| head.cover.samples[0] == 0) {
        writer.section(STARS, &[&points.to_bytes()])?;
    }
    for (number, tile) in (0u32..).zip(&rendered.frame.tiles) {
        let bytes = tile.lock().unwrap_or_else(PoisonError::into_inner).to_bytes();
        writer.section(TILE, &[&number.to_le_bytes(), &bytes])?;
    }
    writer.section(END, &[&(rendered.frame.tiles.len() as u32).to_le_bytes()])
}

/// A part that is being read: one tile after the other.
pub struct PartReader {
    reader: Reader<BufReader<File>>,
    /// What it is of.
    pub head: PartHead,
    /// What was counted.
    pub statistics: Snapshot,
}

/// What a part has besides its head.
pub enum Piece {
    /// What points of the sky add: [`crate::point_picture::PointPicture::add_bytes`].
    Stars(Vec<u8>),
    /// A tile of its window, by number: [`Tile::restore`].
    Tile(u32, Vec<u8>),
}

impl PartReader {
    /// Begins with a file.
    ///
    /// # Errors
    /// If it cannot be read or is no part.
    pub fn open(path: &Path) -> Result<Self, ReadError> {
        let (file, _) = crate::files::open(path).map_err(ReadError::Damaged)?;
        Self::new(file)
    }

    /// Begins with a file that has been opened.
    ///
    /// # Errors
    /// If it is no part.
    pub fn new(file: File) -> Result<Self, ReadError> {
        let mut reader = Reader::of("part of a picture", BufReader::with_capacity(1 << 16, file))?;
        let mut section = |expected: SectionKind| match reader.section()? {
            (kind, content) if kind == expected => Ok(content),
            _ => Err(ReadError::Damaged("it is no part of a picture".to_owned())),
        };
        let damaged = |what: &str| ReadError::Damaged(what.to_owned());
        let head = PartHead::from_json(&section(PART)?).ok_or_else(|| damaged("its head is none"))?;
        let statistics = from_statistics(&section(STATISTICS)?).ok_or_else(|| damaged("its counts are none"))?;
        Ok(Self { reader, head, statistics })
    }

    /// Calls `each` with all of its pieces. Tiles come in their order, all of them.
    ///
    /// # Errors
    /// If it is not whole, or `each` fails.
    pub fn pieces(mut self, mut each: impl FnMut(Piece) -> Result<(), ReadError>) -> Result<(), ReadError> {
        let damaged = |what: &str| ReadError::Damaged(what.to_owned());
        let mut tiles = 0;
        loop {
            let (kind, content) = self.reader.section()?;
            if kind == STARS {
                each(Piece::Stars(content))?;
                continue;
            }
            let (number, rest) = content.split_first_chunk().ok_or_else(|| damaged("a section has no number"))?;
            let number = u32::from_le_bytes(*number);
            match kind {
                TILE if number == tiles => each(Piece::Tile(number, rest.to_vec()))?,
                END if number == tiles => break,
                _ => return Err(damaged("a tile is missing")),
            }
            tiles += 1;
        }
        let (_, [across, down]) = tile_counts(self.head.cover.window);
        if u64::from(tiles) != across * down {
            return Err(damaged("tiles are missing"));
        }
        self.reader.end()
    }

    /// Reads it to its end.
    ///
    /// # Errors
    /// If it is not whole, or one of its tiles is not what its head says.
    pub fn check(self, film: &dyn Film, layers: &[NamedLayer]) -> Result<(), ReadError> {
        let head = self.head.clone();
        let unfit = |what: &str| ReadError::Damaged(what.to_owned());
        self.pieces(|piece| match piece {
            Piece::Stars(bytes) => {
                PointPicture::new(film.channels().len()).add_bytes(&bytes).ok_or_else(|| unfit("its stars do not fit its film"))
            }
            Piece::Tile(number, bytes) => {
                let mut tile = empty_tile(&head, film, layers, number).ok_or_else(|| unfit("it has too many tiles"))?;
                restore(&mut tile, &bytes, &head)
            }
        })
    }
}

/// Side of the tiles of a window (pixels), and how many there are across and down.
fn tile_counts([x0, x1, y0, y1]: [u32; 4]) -> (u32, [u64; 2]) {
    let size = [x1 - x0, y1 - y0];
    let side = crate::film::tile_side(size);
    (side, size.map(|n| u64::from(n.div_ceil(side))))
}

/// An empty tile of a part, by its number.
pub fn empty_tile(head: &PartHead, film: &dyn Film, layers: &[NamedLayer], number: u32) -> Option<Tile> {
    let [x0, x1, y0, y1] = head.cover.window;
    let (size, [across, down]) = tile_counts(head.cover.window);
    let (column, row) = (u64::from(number) % across, u64::from(number) / across);
    if row >= down {
        return None;
    }
    let origin = [x0 + column as u32 * size, y0 + row as u32 * size];
    let size = [size.min(x1 - origin[0]), size.min(y1 - origin[1])];
    Tile::empty(origin, size, [film.channels().len(), crate::film::layer_numbers(layers)], head.cover.samples[0]).ok()
}

/// Takes over what a file holds of a tile, all of whose samples are there.
///
/// # Errors
/// If it is not that.
pub fn restore(tile: &mut Tile, bytes: &[u8], head: &PartHead) -> Result<(), ReadError> {
    let whole = tile.restore(bytes).is_some() && tile.progress.done == head.cover.samples[1] && tile.progress.position == 0;
    if whole { Ok(()) } else { Err(ReadError::Damaged("a tile does not fit its film".to_owned())) }
}

/// The film of a part and its layers; nothing if its directive makes none.
pub fn film_of(head: &PartHead) -> Option<(Box<dyn Film>, Vec<NamedLayer>)> {
    // Whoever has made the part has written that: it reads no file.
    film_alone(&head.film, &Registry::builtin(), &mut SourceMap::in_memory(BTreeMap::new()))
}

/// Whether a file holds the part of the given head, whole, as `merge` asks; of a film with these layers.
pub fn holds(path: &Path, head: &PartHead, (film, layers): (&dyn Film, &[NamedLayer])) -> bool {
    PartReader::open(path).is_ok_and(|part| {
        let same = part.head.identity == head.identity && part.head.cover == head.cover && part.head.frame == head.frame;
        same && part.check(film, layers).is_ok()
    })
}
