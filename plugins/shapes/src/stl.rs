//! STL files: triangles without anything else, binary or ASCII.
//!
//! A file is binary if its length is what its header says, or if it holds what no text does: the headers of many binary files begin with `solid`,
//! which is how text begins. The count of triangles in the header is not trusted: what the file holds counts, and a note says where the two
//! differ. Stated normals are not read, nor the two bytes behind each triangle.
//!
//! Own code: `stl_io` asks for as much memory as a header says, takes binary files that begin with `solid` for text, and does not say where a text
//! is at fault.

use crate::file_kind::looks_like;
use crate::mesh::can_be_numbered;
use crate::obj_lines::{BYTE_ORDER_MARK, number, refuse_utf16, take_line};
use bhs_core::geometry::WorldMesh;
use glam::DVec3;
use std::collections::HashMap;

/// What a file holds.
#[derive(Clone, Debug, Default)]
pub struct Stl {
    /// In the file's own coordinates.
    pub mesh: WorldMesh,
    /// Where the header and the file disagree, in words that can follow "`file`: ".
    pub note: Option<String>,
}

/// Bytes before the triangles of a binary file: a header without meaning, and their number.
const HEADER: usize = 84;
/// Bytes of a triangle: a normal, three corners, two bytes more.
const TRIANGLE: usize = 50;

/// Reads a whole file.
///
/// # Errors
/// What is wrong with it, in a sentence, with the line or the byte where it is known.
pub fn read(file: &[u8]) -> Result<Stl, String> {
    refuse_utf16(file)?;
    let text = file.strip_prefix(BYTE_ORDER_MARK).unwrap_or(file).trim_ascii_start();
    let begins_as_text = text.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"));
    // Bytes that no text has: also where a name is in another encoding, its lines are.
    let holds_others = |bytes: &[u8]| bytes.contains(&0);
    let is_binary = file.len() >= HEADER && (stated(file) == held(file) || holds_others(file) || !begins_as_text);
    match (is_binary, begins_as_text) {
        (true, false) if stated(file) != held(file) && !holds_others(file) => Err(no_stl(file)),
        (true, _) => binary(file),
        (false, true) => ascii(file),
        (false, false) => Err(no_stl(file)),
    }
}

fn no_stl(file: &[u8]) -> String {
    format!("it is no STL file{}", looks_like(file))
}

/// How many triangles the header of a binary file states; 0 of a shorter file.
fn stated(file: &[u8]) -> usize {
    file.get(HEADER - 4..HEADER).and_then(|b| b.try_into().ok()).map_or(0, u32::from_le_bytes) as usize
}

/// How many triangles a binary file has room for, if it ends with one.
fn held(file: &[u8]) -> usize {
    let triangles = file.len().saturating_sub(HEADER);
    if triangles.is_multiple_of(TRIANGLE) { triangles / TRIANGLE } else { usize::MAX }
}

fn binary(file: &[u8]) -> Result<Stl, String> {
    let (stated, body) = (stated(file), &file[HEADER..]);
    let (whole, rest) = (body.len() / TRIANGLE, body.len() % TRIANGLE);
    if stated > whole && rest > 0 {
        return Err(format!(
            "it ends within triangle {} of the {stated} that its header states, after {} bytes: it is cut off",
            whole + 1,
            file.len()
        ));
    }
    let count = if rest > 0 { stated } else { whole };
    let note = if stated != whole {
        Some(format!("its header states {stated} triangles, and it holds {whole}: {count} are read"))
    } else {
        None
    };
    let mut triangles = Triangles::default();
    for (i, triangle) in body.chunks_exact(TRIANGLE).take(count).enumerate() {
        let float = |at: usize| {
            let mut bytes = [0; 4];
            bytes.copy_from_slice(&triangle[at..at + 4]);
            f32::from_le_bytes(bytes)
        };
        let corner = |c: usize| [float(12 + 12 * c), float(16 + 12 * c), float(20 + 12 * c)];
        let corners = [corner(0), corner(1), corner(2)];
        if !corners.as_flattened().iter().all(|x| x.is_finite()) {
            let at = HEADER + TRIANGLE * i;
            return Err(format!("triangle {} (byte {at}) has a coordinate that is not a finite number", i + 1));
        }
        triangles.add(corners);
    }
    Ok(Stl { mesh: triangles.finish()?, note })
}

fn ascii(file: &[u8]) -> Result<Stl, String> {
    let mut triangles = Triangles::default();
    let mut corners: Vec<[f32; 3]> = Vec::new();
    let mut is_open = false;
    let (mut rest, mut line_number) = (file, 0);
    while let Some(line) = take_line(&mut rest) {
        line_number += 1;
        let line = if line_number == 1 { line.strip_prefix(BYTE_ORDER_MARK).unwrap_or(line) } else { line };
        let at = |fault: &str| Err(format!("line {line_number}: {fault}"));
        let mut words = line.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty());
        let is = |word: &[u8], keyword: &str| word.eq_ignore_ascii_case(keyword.as_bytes());
        while let Some(word) = words.next() {
            match word {
                // A name, which may be anything, takes the rest of the line.
                w if is(w, "solid") || is(w, "endsolid") || is(w, "color") => break,
                w if is(w, "facet") => {
                    if is_open {
                        return at("`facet` stands within a facet: the one before it has no `endfacet`");
                    }
                    (is_open, corners) = (true, Vec::new());
                }
                w if is(w, "vertex") => {
                    let mut corner = [0.0f32; 3];
                    for x in &mut corner {
                        let Some(value) = words.next().and_then(number) else { return at("`vertex` needs three numbers") };
                        *x = value as f32;
                        if !x.is_finite() {
                            return at("a coordinate is not a finite number of single precision");
                        }
                    }
                    if !is_open || corners.len() == 3 {
                        return at(if is_open {
                            "a facet has more than three vertices"
                        } else {
                            "`vertex` stands outside of a facet"
                        });
                    }
                    corners.push(corner);
                }
                w if is(w, "endfacet") => {
                    let Ok(corners) = <[_; 3]>::try_from(std::mem::take(&mut corners)) else {
                        return at("a facet ends that does not have three vertices");
                    };
                    is_open = false;
                    triangles.add(corners);
                }
                w if is(w, "outer") || is(w, "loop") || is(w, "endloop") => {}
                // Not used, and often no numbers.
                w if is(w, "normal") => drop(words.by_ref().take(3).count()),
                // A part of a word, after which nothing comes.
                w if is_open && rest.is_empty() && file.ends_with(w) => break,
                _ => return at(&format!("`{}` is no word of STL", shown(word))),
            }
        }
    }
    if is_open {
        return Err("it ends within a facet: it is cut off".into());
    }
    Ok(Stl { mesh: triangles.finish()?, note: None })
}

/// The beginning of a word, for a message.
fn shown(word: &[u8]) -> String {
    String::from_utf8_lossy(word).chars().filter(|c| !c.is_control()).take(20).collect()
}

/// Triangles whose corners are numbered by their places.
#[derive(Default)]
struct Triangles {
    numbers: HashMap<[u32; 3], u32>,
    mesh: WorldMesh,
}

impl Triangles {
    fn add(&mut self, corners: [[f32; 3]; 3]) {
        let triangle = corners.map(|corner| {
            // Zero has two signs, and is one place.
            let key = corner.map(|x| (x + 0.0).to_bits());
            *self.numbers.entry(key).or_insert_with(|| {
                self.mesh.positions.push(DVec3::from_array(corner.map(f64::from)));
                // More than can be numbered are found in the end.
                (self.mesh.positions.len() - 1) as u32
            })
        });
        self.mesh.triangles.push(triangle);
    }

    fn finish(self) -> Result<WorldMesh, String> {
        can_be_numbered(self.mesh.positions.len() as u64, "vertices")?;
        can_be_numbered(self.mesh.triangles.len() as u64, "triangles")?;
        if self.mesh.triangles.is_empty() { Err("it holds no triangle".into()) } else { Ok(self.mesh) }
    }
}
