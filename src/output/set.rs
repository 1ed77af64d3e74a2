//! Files that belong together: all of them appear, or none; and if they cannot, they are kept in another place.

use super::temporary::publish;
use super::{OutputFile, Staged, Writer};
use crate::files::Root;
use crate::say;
use anyhow::Result;
use std::ffi::OsString;
use std::fmt::Write;
use std::path::{Path, PathBuf};

type Content<'a> = Box<dyn Fn(&mut Writer) -> Result<()> + 'a>;

/// Files that belong together, such as the EXR and the PNG of a picture.
#[derive(Default)]
pub struct OutputSet<'a> {
    files: Vec<(OutputFile, Content<'a>)>,
}

/// Where the files of a set are in the end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[must_use]
pub enum Kept {
    /// All where they were to be.
    InPlace,
    /// Elsewhere, as has been said on standard error, or lost if no place took them.
    Elsewhere,
}

/// Where files are kept that cannot be written to their place.
#[derive(Clone, Debug, Default)]
pub struct Rescue {
    folders: Vec<PathBuf>,
}

impl Rescue {
    /// Beside the scene, and in the folder for temporary files, as far as they lie in `root`.
    pub fn beside(scene: &Path, root: Option<&Root>) -> Self {
        let beside = scene.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let mut folders = vec![beside.to_owned(), std::env::temp_dir()];
        folders.retain(|folder| root.is_none_or(|root| root.admit(&folder.join("x")).is_ok()));
        Self { folders }
    }
}

impl<'a> OutputSet<'a> {
    /// A set without files.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a file. `write` may be called several times, should one place not take the file.
    pub fn add(&mut self, file: OutputFile, write: impl Fn(&mut Writer) -> Result<()> + 'a) {
        self.files.push((file, Box::new(write)));
    }

    /// Writes all files and puts them into their places together.
    ///
    /// # Errors
    /// If one cannot be written; none of them is in its place then.
    pub fn write_in_place(&self) -> Result<()> {
        together(&self.files.iter().collect::<Vec<_>>(), |file| Ok(file.clone())).map(drop)
    }

    /// Writes all files and puts them into their places together. If that fails, they are written to another place, and standard error
    /// says where, and with which commands they come to their places.
    pub fn write(self, rescue: &Rescue) -> Kept {
        let all: Vec<&(OutputFile, Content)> = self.files.iter().collect();
        let Err(error) = together(&all, |file| Ok(file.clone())) else { return Kept::InPlace };
        say!("error: {error:#}");
        for folder in &rescue.folders {
            let kept = together(&all, |file| Ok(file.moved_to(folder, &rescued_name(file))?));
            if let Ok(kept) = kept {
                report(&kept, &[]);
                return Kept::Elsewhere;
            }
        }
        // No place takes all of them; some place may take some.
        let (mut kept, mut lost) = (Vec::new(), Vec::new());
        for one in &all {
            let file = &one.0;
            let place = rescue
                .folders
                .iter()
                .find_map(|folder| together(&[one], |file| Ok(file.moved_to(folder, &rescued_name(file))?)).ok());
            match place {
                Some(places) => kept.extend(places),
                None => lost.push(file),
            }
        }
        report(&kept, &lost);
        Kept::Elsewhere
    }
}

/// Writes files to the places that `place` says, all or none. Yields them, and where they stand.
fn together<'f>(
    files: &[&'f (OutputFile, Content)],
    place: impl Fn(&OutputFile) -> Result<OutputFile>,
) -> Result<Vec<(&'f OutputFile, PathBuf)>> {
    let staged = files.iter().map(|(file, write)| place(file)?.stage(write)).collect::<Result<Vec<Staged>>>()?;
    let places = files.iter().zip(&staged).map(|((file, _), staged)| (file, staged.file.real_path())).collect();
    publish(staged)?;
    Ok(places)
}

/// A new name for a file that goes elsewhere: `x.rescued-1a2b3c4d5e6f7a8b.exr` for `x.exr`.
fn rescued_name(file: &OutputFile) -> OsString {
    use std::hash::{BuildHasher, RandomState};
    let name = Path::new(&file.name);
    let mut rescued = name.file_stem().unwrap_or_default().to_owned();
    // Long names are cut, for the addition needs room.
    if rescued.len() > 200 {
        rescued = rescued.to_string_lossy().chars().take(50).collect::<String>().into();
    }
    let random = RandomState::new().hash_one(&file.name);
    rescued.push(format!(".rescued-{random:016x}"));
    if let Some(ending) = name.extension() {
        rescued.push(".");
        rescued.push(ending);
    }
    rescued
}

/// Says where files are kept, how they come to their places, and which are lost.
fn report(kept: &[(&OutputFile, PathBuf)], lost: &[&OutputFile]) {
    if !kept.is_empty() {
        let mut commands = String::new();
        for (file, place) in kept {
            let to = file.real_path();
            let folder = if file.folder.is_dir() { String::new() } else { format!("mkdir -p {} && ", quoted(&file.folder)) };
            let _ = write!(commands, "\n    {folder}mv -- {} {}", quoted(place), quoted(&to));
        }
        say!("nothing is lost of what is kept elsewhere; once there is room, this puts it into its place:{commands}");
    }
    for file in lost {
        say!("error: `{}` is lost: no other place takes it either", file.path.display());
    }
}

/// A path as a shell reads it.
fn quoted(path: &Path) -> String {
    match path.to_str() {
        Some(text) if !text.contains(char::is_control) => format!("'{}'", text.replace('\'', r"'\''")),
        // Bytes that are no text, as bash, ksh and zsh read them.
        _ => {
            path.as_os_str().as_encoded_bytes().iter().fold("$'".to_owned(), |mut out, byte| {
                match byte {
                    b'\'' | b'\\' => out += &format!("\\{}", char::from(*byte)),
                    b' '..=b'~' => out.push(char::from(*byte)),
                    _ => out += &format!("\\x{byte:02x}"),
                }
                out
            }) + "'"
        }
    }
}
