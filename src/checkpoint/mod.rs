//! Checkpoints: the whole state of a render in a file, so that it can go on after whatever ended it, to the same picture.
//!
//! The file ([`mod@format`]) has these sections, in this order:
//!
//! | kind | content |
//! |---|---|
//! | `HEAD` | JSON: what the render is of ([`Identity`]) |
//! | `STAT` | JSON: waves that have ended, seconds of rendering, counts |
//! | `TILE` | any number, in any order: the number of the tile (4 bytes), its progress and its exact sums ([`Tile::to_bytes`]); tiles without samples are left out |
//! | `END ` | the number of the tiles before (4 bytes) |
//!
//! So it holds sums of samples of a window of a film, from a first sample on, by tiles, and says of which.
//!
//! The checkpoint before the last one is kept under another name ([`previous`]), and used where the last one is damaged.
//!
//! [`Tile::to_bytes`]: crate::film::Tile::to_bytes

pub mod format;
mod identity;

pub use identity::Identity;

use crate::memory::OutOfMemory;
use crate::not_finite::{FirstSamples, SampleId};
use crate::output::OutputFile;
use crate::render::{RenderState, Snapshot, Wave};
use anyhow::{Context, Result, anyhow};
use bhs_engine::stats::Counters;
use format::{ReadError, Reader, SectionKind, Writer};
use serde_json::{Value, json};
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::PoisonError;

const HEAD: SectionKind = *b"HEAD";
const STATISTICS: SectionKind = *b"STAT";
const TILE: SectionKind = *b"TILE";
const END: SectionKind = *b"END ";

/// The checkpoint of one picture.
#[derive(Clone, Debug)]
pub struct CheckpointFile {
    path: PathBuf,
    identity: Identity,
    /// Whether the sampler needs the same number of samples a pixel.
    fixed_samples: bool,
}

/// Why a render cannot go on from a checkpoint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// There is none.
    Missing,
    /// It is not whole; perhaps the one before it is.
    Damaged(String),
    /// It is of something else.
    Other(String),
}

impl From<ReadError> for Refusal {
    fn from(error: ReadError) -> Self {
        match error {
            ReadError::Io(e) if e.kind() == ErrorKind::NotFound => Self::Missing,
            ReadError::Version(_) => Self::Other(error.to_string()),
            ReadError::Io(_) | ReadError::Damaged(_) | ReadError::CutShort => Self::Damaged(error.to_string()),
        }
    }
}

/// What came of looking for a checkpoint.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Found {
    /// There is none: the render starts.
    Nothing,
    /// This one was taken over, with a warning if it is not the last one.
    File(PathBuf, Option<String>),
}

impl CheckpointFile {
    /// The checkpoint at `path` of a render of the given identity; `fixed_samples` if it cannot go on to another number of samples.
    pub fn new(path: PathBuf, identity: Identity, fixed_samples: bool) -> Self {
        Self { path, identity, fixed_samples }
    }

    /// Where it stands.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Writes the state as it is now, while threads go on with it. The last checkpoint becomes the one before.
    ///
    /// # Errors
    /// If it cannot be written; the last checkpoint is untouched then.
    pub fn save(&self, state: &RenderState) -> Result<()> {
        let file = OutputFile::reserve(&self.path)?;
        // A link would lead to the new file.
        let replaced = file.real_path();
        file.finish(|to| {
            write(&mut *to, &self.identity, state)?;
            to.flush()?;
            keep(&replaced, &previous(&self.path))
        })
    }

    /// Takes over the last checkpoint into a state that `new` makes, or the one before it if the last one is damaged.
    ///
    /// # Errors
    /// If it belongs to another render, and which part does; if none of the two can be read; if there is not enough memory.
    pub fn resume<'a>(&self, new: impl Fn() -> Result<RenderState<'a>, OutOfMemory>) -> Result<(RenderState<'a>, Found)> {
        let refuse = |path: &Path, why: &str| anyhow!("cannot resume from `{}`: {why}", path.display());
        let damage = match self.take_over(&self.path, new()?) {
            Ok(state) => return Ok((state, Found::File(self.path.clone(), None))),
            Err(Refusal::Missing) => return Ok((new()?, Found::Nothing)),
            Err(Refusal::Other(why)) => return Err(refuse(&self.path, &why)),
            Err(Refusal::Damaged(why)) => why,
        };
        let previous = previous(&self.path);
        match self.take_over(&previous, new()?) {
            Ok(state) => {
                let warning = format!("`{}` is damaged ({damage}); the one before it is used", self.path.display());
                Ok((state, Found::File(previous, Some(warning))))
            }
            Err(Refusal::Other(why)) => Err(refuse(&previous, &why)),
            Err(Refusal::Missing) => {
                let why = format!("it is damaged ({damage}), and there is none before it; delete it to start anew");
                Err(refuse(&self.path, &why))
            }
            Err(Refusal::Damaged(also)) => {
                let shown = previous.display();
                let why = format!("it is damaged ({damage}), as is `{shown}` before it ({also}); delete it to start anew");
                Err(refuse(&self.path, &why))
            }
        }
    }

    /// Removes the last checkpoint and the one before it, as far as they are of this render: what else stands there stays.
    pub fn remove_own(&self) {
        for path in [previous(&self.path), self.path.clone()] {
            let is_own = head(&path).is_some_and(|head| self.identity.difference(&head, self.fixed_samples).is_none());
            if is_own {
                // One that stays does no harm: whoever goes on from it finds it finished.
                let _ = std::fs::remove_file(path);
            }
        }
    }

    /// The state with what the file at `path` holds.
    fn take_over<'a>(&self, path: &Path, mut state: RenderState<'a>) -> Result<RenderState<'a>, Refusal> {
        let file = File::open(path).map_err(ReadError::from)?;
        read(BufReader::with_capacity(1 << 16, file), &self.identity, self.fixed_samples, &mut state)?;
        Ok(state)
    }
}

/// What the checkpoint at `path` is of, if it is one.
fn head(path: &Path) -> Option<Identity> {
    let (file, _) = crate::files::open(path).ok()?;
    match Reader::new(BufReader::new(file)).ok()?.section().ok()? {
        (HEAD, content) => Identity::from_json(&content),
        _ => None,
    }
}

/// Where the checkpoint of a picture or of a part stands that nobody names: `NAME.checkpoint` of `NAME.exr`, `NAME.bhspart.checkpoint` of
/// `NAME.bhspart`, so that a picture and a part of it have each their own.
pub fn beside(output: &Path) -> PathBuf {
    if output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("exr")) {
        return output.with_extension("checkpoint");
    }
    let mut name = output.file_name().unwrap_or_default().to_owned();
    name.push(".checkpoint");
    output.with_file_name(name)
}

/// Where the checkpoint before the one at `path` is kept.
pub fn previous(path: &Path) -> PathBuf {
    let ending = path.extension().map_or_else(|| "previous".into(), |e| format!("previous.{}", e.to_string_lossy()));
    path.with_extension(ending)
}

/// Keeps the file at `path`, which is about to be replaced, under the name `kept` too. There is a file at `path` all the time.
fn keep(path: &Path, kept: &Path) -> Result<()> {
    let gone = |result: std::io::Result<()>| match result {
        Err(e) if e.kind() == ErrorKind::NotFound => Ok(()),
        other => other,
    };
    gone(std::fs::remove_file(kept)).with_context(|| format!("cannot remove `{}`", kept.display()))?;
    let linked = std::fs::hard_link(path, kept).or_else(|e| match e.kind() {
        ErrorKind::NotFound => Err(e),
        // Not all file systems have second names for a file.
        _ => std::fs::copy(path, kept).map(drop),
    });
    gone(linked).with_context(|| format!("cannot keep `{}` as `{}`", path.display(), kept.display()))
}

/// Writes the state as it is now, while threads go on with it.
///
/// # Errors
/// If it cannot be written.
pub fn write(to: impl Write, identity: &Identity, state: &RenderState) -> std::io::Result<()> {
    // Both parts of a snapshot write to it.
    let writer = std::cell::RefCell::new(Writer::new(to)?);
    let mut tiles = 0_u32;
    state.snapshot(
        |snapshot| {
            let mut writer = writer.borrow_mut();
            writer.section(HEAD, &[identity.to_json().as_bytes()])?;
            writer.section(STATISTICS, &[statistics(snapshot).to_string().as_bytes()])
        },
        |number, bytes| {
            if bytes.is_empty() {
                return Ok(());
            }
            tiles += 1;
            writer.borrow_mut().section(TILE, &[&(number as u32).to_le_bytes(), bytes])
        },
    )?;
    writer.into_inner().section(END, &[&tiles.to_le_bytes()])
}

/// Takes over into `state`, which is new, what [`write()`] has written for a render of the same identity; `fixed_samples` if that includes
/// the number of samples a pixel.
///
/// # Errors
/// If it is of another render, or damaged. The state is of no use then.
pub fn read(from: impl Read, identity: &Identity, fixed_samples: bool, state: &mut RenderState) -> Result<(), Refusal> {
    let damaged = |what: &str| Refusal::Damaged(what.to_owned());
    let mut reader = Reader::new(from)?;
    let mut section = |expected: SectionKind| match reader.section()? {
        (kind, content) if kind == expected => Ok(content),
        _ => Err(damaged("a part is missing")),
    };
    let head = Identity::from_json(&section(HEAD)?).ok_or_else(|| damaged("its head is no JSON"))?;
    if let Some(difference) = identity.difference(&head, fixed_samples) {
        return Err(Refusal::Other(difference));
    }
    let snapshot = from_statistics(&section(STATISTICS)?).ok_or_else(|| damaged("its counts are none"))?;
    let wave_start = Wave(snapshot.waves).samples().start;
    state.restore(snapshot);
    let mut tiles = 0_u32;
    loop {
        let (kind, content) = reader.section()?;
        let (number, content) = content.split_first_chunk().ok_or_else(|| damaged("a part has no number"))?;
        let number = u32::from_le_bytes(*number);
        match kind {
            TILE => {
                let tile = state.frame().tiles.get(number as usize);
                let mut tile =
                    tile.ok_or_else(|| damaged("it has too many tiles"))?.lock().unwrap_or_else(PoisonError::into_inner);
                if tile.progress.has_samples() || tile.restore(content).is_none() {
                    return Err(damaged("a tile does not fit the film"));
                }
                tiles += 1;
            }
            END if number == tiles => break,
            _ => return Err(damaged("a part is missing")),
        }
    }
    // All samples of the waves that have ended are there.
    if state.frame().sample_counts()[0] < wave_start {
        return Err(damaged("samples are missing"));
    }
    Ok(())
}

/// What a snapshot has counted, as JSON.
pub(crate) fn statistics(snapshot: &Snapshot) -> Value {
    let counts: serde_json::Map<_, _> = snapshot.counters.named().map(|(name, n)| (name.to_owned(), json!(n))).collect();
    let samples = snapshot.not_finite.iter().map(|s| json!([s.pixel[0], s.pixel[1], s.sample])).collect::<Vec<_>>();
    json!({ "waves": snapshot.waves, "seconds": snapshot.seconds, "counts": counts, "samples_not_finite": samples })
}

/// What [`statistics`] has made JSON of; `None` if it is not that.
pub(crate) fn from_statistics(text: &[u8]) -> Option<Snapshot> {
    let value: Value = serde_json::from_slice(text).ok()?;
    let mut counters = Counters::default();
    for (name, count) in value["counts"].as_object()? {
        *counters.by_name_mut(name)? = count.as_u64()?;
    }
    let mut not_finite = FirstSamples::default();
    for sample in value["samples_not_finite"].as_array()? {
        let number = |i: usize| u32::try_from(sample[i].as_u64()?).ok();
        not_finite.insert(SampleId { pixel: [number(0)?, number(1)?], sample: number(2)? });
    }
    let waves = value["waves"].as_u64()?.try_into().ok()?;
    let seconds = value["seconds"].as_f64().filter(|s| *s >= 0.0)?;
    Some(Snapshot { waves, counters, not_finite, seconds })
}
