//! Wavefront OBJ files: what of them is geometry, handed to the crate tobj line by line.
//!
//! Read are `v`, `vt`, `vn` and `f`: all faces make one mesh. Groups, materials, lines, points, curves and vertex colours are stepped over.
//! A `\` at the end of a line continues it.

use crate::mesh::can_be_numbered;
use bhs_core::geometry::WorldMesh;
use glam::DVec3;
use std::borrow::Cow;
use std::io::{self, BufRead, Read};
use tobj::{LoadError, LoadOptions};

/// What a file holds.
#[derive(Debug)]
pub struct Obj {
    /// In the file's own coordinates.
    pub mesh: WorldMesh,
    /// What was left out for being there at some corners only.
    pub partial: Vec<&'static str>,
}

/// Longest file: more could have more vertices than can be numbered.
const MOST_BYTES: usize = 1 << 34;

/// Digits of a number of a vertex: more overflow.
const MOST_DIGITS: usize = 18;

/// Reads a whole file.
///
/// # Errors
/// What is wrong with it, in a sentence, with the line where it is known.
pub fn read(file: &[u8]) -> Result<Obj, String> {
    if file.len() > MOST_BYTES {
        return Err(format!("{} bytes are more than the {MOST_BYTES} that a file can have", file.len()));
    }
    let mut lines = Lines { rest: file, line: Cow::Borrowed(&[]), at: 0, number: 0, fault: None };
    let options = LoadOptions { single_index: true, triangulate: true, ignore_points: true, ignore_lines: true };
    let no_material = |_: &std::path::Path| Ok(Default::default());
    let loaded = tobj::load_obj_buf(&mut lines, &options, no_material);
    if let Some(fault) = lines.fault {
        return Err(format!("line {}: {fault}", lines.number));
    }
    let meshes = match loaded {
        Ok((models, _)) => models.into_iter().map(|m| m.mesh),
        Err(error) => return Err(explain(error, lines.number)),
    };
    let mut obj = Obj { mesh: WorldMesh::default(), partial: Vec::new() };
    for mesh in meshes {
        append(&mut obj, &mesh)?;
    }
    if obj.mesh.triangles.is_empty() {
        return Err("it holds no triangle".into());
    }
    Ok(obj)
}

fn append(obj: &mut Obj, from: &tobj::Mesh) -> Result<(), String> {
    let triples = |v: &[f64]| v.chunks_exact(3).map(DVec3::from_slice).collect::<Vec<_>>();
    let mesh = &mut obj.mesh;
    mesh.positions = triples(&from.positions);
    if !mesh.positions.iter().all(|p| p.is_finite()) {
        return Err("a vertex has a coordinate that is not a finite number".into());
    }
    let count = mesh.positions.len();
    can_be_numbered(count as u64, "vertices")?;
    can_be_numbered(from.indices.len() as u64 / 3, "triangles")?;
    mesh.triangles = from.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    // What some corners have and others have not would be given to the wrong ones.
    let mut fits = |name, length, each| {
        let partial = length != 0 && length != each * count;
        obj.partial.extend(partial.then_some(name));
        !partial
    };
    if fits("shading normals", from.normals.len(), 3) {
        mesh.normals = triples(&from.normals).into_iter().map(crate::mesh::unit).collect();
    }
    if fits("texture coordinates", from.texcoords.len(), 2) {
        mesh.uvs = from.texcoords.chunks_exact(2).map(|uv| [uv[0] as f32, uv[1] as f32]).collect();
        if !mesh.uvs.iter().flatten().all(|x| x.is_finite()) {
            return Err("a texture coordinate is not a finite number of single precision".into());
        }
    }
    Ok(())
}

/// tobj's errors as sentences; `line` is the one that it stopped at.
fn explain(error: LoadError, line: u64) -> String {
    let in_line = |what: &str| format!("line {line}: {what}");
    match error {
        LoadError::PositionParseError => in_line("`v` needs three numbers, and takes one or three more"),
        LoadError::NormalParseError => in_line("`vn` needs three numbers"),
        LoadError::TexcoordParseError => in_line("`vt` needs two numbers"),
        LoadError::FaceParseError => in_line("a corner of a face is a number of a vertex, as in 3, 3/1, 3//2 or 3/1/2"),
        LoadError::ScalingByZeroError => in_line("the fourth number of `v` is 0"),
        LoadError::ColorParseError => in_line("`v` takes one more number, or three"),
        LoadError::ReadError => in_line("it is not text"),
        LoadError::FaceVertexOutOfBounds => "a face uses a vertex that does not exist".into(),
        LoadError::FaceTexCoordOutOfBounds => "a face uses texture coordinates that do not exist".into(),
        LoadError::FaceNormalOutOfBounds => "a face uses a normal that does not exist".into(),
        LoadError::FaceColorOutOfBounds => "some vertices have colours and others have not".into(),
        LoadError::InvalidPolygon => "a face has no corners".into(),
        other => in_line(&other.to_string()),
    }
}

/// The lines that are geometry.
struct Lines<'a> {
    rest: &'a [u8],
    /// What is handed over now, and how much of it has been.
    line: Cow<'a, [u8]>,
    at: usize,
    /// Number of its last line in the file, from 1.
    number: u64,
    /// What tobj cannot be asked to read.
    fault: Option<&'static str>,
}

impl<'a> Lines<'a> {
    /// The next line of the file, its end included; empty at the end of the file.
    fn next_line(&mut self) -> &'a [u8] {
        let end = self.rest.iter().position(|b| *b == b'\n').map_or(self.rest.len(), |i| i + 1);
        let (line, rest) = self.rest.split_at(end);
        self.rest = rest;
        self.number += u64::from(end > 0);
        line
    }

    /// Goes on to the next line of geometry.
    fn advance(&mut self) {
        self.at = 0;
        loop {
            let first = self.next_line();
            self.line = Cow::Borrowed(first);
            // A line that goes on.
            while let Some(length) = self.line.trim_ascii_end().strip_suffix(b"\\").map(<[u8]>::len) {
                let next = self.next_line();
                let line = self.line.to_mut();
                line.truncate(length);
                line.push(b' ');
                line.extend_from_slice(next);
                if next.is_empty() {
                    break;
                }
            }
            let word = self.line.trim_ascii_start().split(u8::is_ascii_whitespace).next().unwrap_or_default();
            match word {
                _ if self.line.is_empty() => return,
                b"v" | b"vt" | b"vn" => return,
                b"f" => {
                    if self.line.split(|b| !b.is_ascii_digit()).any(|digits| digits.len() > MOST_DIGITS) {
                        self.fault = Some("a number of a vertex is too large");
                        self.line = Cow::Borrowed(&[]);
                    }
                    return;
                }
                _ => {}
            }
        }
    }
}

impl BufRead for Lines<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.at == self.line.len() && self.fault.is_none() {
            self.advance();
        }
        Ok(&self.line[self.at..])
    }

    fn consume(&mut self, amount: usize) {
        self.at += amount;
    }
}

impl Read for Lines<'_> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let read = self.fill_buf()?.read(into)?;
        self.consume(read);
        Ok(read)
    }
}
