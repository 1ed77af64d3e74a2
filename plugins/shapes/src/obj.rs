//! Wavefront OBJ files: what of them is geometry.
//!
//! Read are `v`, `vt`, `vn` and `f`, and which material (`usemtl`) each face has: all faces make one mesh, or those of one material do. Groups,
//! lines, points, curves and vertex colours are stepped over. What materials are: `mtl`.
//! A `\` at the end of a line of geometry continues it, `#` starts a comment anywhere, lines end as on any system, comments may be in any
//! encoding. A corner without a normal, or with one that is no number, takes that of its face; a vertex that no face uses may be anything.
//!
//! Own code: `tobj`, which read these files before, gives up at comments within lines, at `vt` with one number and at normals that
//! Microsoft's programs write as `-nan(ind)`, does not know lines that end as on old Macintoshes, nor in which line a face names a vertex
//! that is not there, and gives what some corners lack to the wrong ones.

use crate::file_kind::looks_like;
use crate::mesh::{Fan, can_be_numbered, fill_normals, fill_polygons, unit};
use crate::obj_lines::{Line, Lines, numbers};
use bhs_core::geometry::WorldMesh;
use glam::DVec3;
use std::collections::HashMap;

/// A mesh of a file.
#[derive(Clone, Debug, Default)]
pub struct Obj {
    /// In the file's own coordinates.
    pub mesh: WorldMesh,
    /// What was left out for being there at some corners only.
    pub partial: Vec<&'static str>,
    /// Faces whose outline crosses itself.
    pub crossing_faces: u64,
}

/// Numbers of a corner's vertex, texture coordinates and normal, from 0; [`NONE`] for what it has not.
type Corner = [u32; 3];

const NONE: u32 = u32::MAX;

/// What a line `f` looks like.
const CORNER: &str = "a corner of a face is a number of a vertex, as in 3, 3/1, 3//2 or 3/1/2";

/// What a file holds.
#[derive(Debug, Default)]
pub struct ObjFile {
    positions: Vec<DVec3>,
    uvs: Vec<[f32; 2]>,
    normals: Vec<[f32; 3]>,
    corners: Vec<Corner>,
    faces: Vec<Face>,
    /// Number of each name that follows `usemtl`.
    numbers: HashMap<Box<[u8]>, u32>,
    /// These names, in the order of the file.
    names: Vec<String>,
    /// Number of the one that is in force; [`NONE`] before the first.
    current: u32,
    /// What stands after `mtllib`: a name of a file, or several, in each line.
    pub libraries: Vec<String>,
}

/// A face of a file.
#[derive(Clone, Copy, Debug)]
struct Face {
    line: u64,
    /// Corners up to and including its own.
    end: usize,
    /// Number of its material, or [`NONE`].
    material: u32,
}

/// Reads a whole file; all of its faces are one mesh.
///
/// # Errors
/// What is wrong with it, in a sentence, with the line where it is known.
pub fn read(file: &[u8]) -> Result<Obj, String> {
    parse(file)?.mesh(None)
}

/// Reads a whole file.
///
/// # Errors
/// As [`read`].
pub fn parse(file: &[u8]) -> Result<ObjFile, String> {
    let mut reader = ObjFile { current: NONE, ..ObjFile::default() };
    let mut lines = Lines::new(file)?;
    while let Some(line) = lines.next_line() {
        let read = match line {
            Line::Geometry(b"v", rest) => reader.vertex(&rest),
            Line::Geometry(b"vt", rest) => reader.texture_coordinates(&rest),
            Line::Geometry(b"vn", rest) => reader.normal(&rest),
            Line::Geometry(_, rest) => reader.face(&rest, lines.number()),
            Line::Material(name) => {
                reader.material(name);
                Ok(())
            }
            Line::Library(names) => {
                reader.libraries.push(String::from_utf8_lossy(names).into_owned());
                Ok(())
            }
        };
        read.map_err(|fault| format!("line {}: {fault}", lines.number()))?;
    }
    let is_mesh = !(reader.positions.is_empty() && reader.faces.is_empty());
    let checked = if reader.faces.is_empty() { Err("it holds no triangle".into()) } else { reader.check() };
    checked.map_err(|fault: String| if is_mesh { fault } else { fault + looks_like(file) })?;
    Ok(reader)
}

impl ObjFile {
    /// The names of the materials that faces have, in the order in which the file names them first; empty for those before the first `usemtl`.
    pub fn groups(&self) -> Vec<&str> {
        let mut has_faces = vec![false; self.names.len()];
        let mut without = false;
        for face in &self.faces {
            match has_faces.get_mut(face.material as usize) {
                Some(has) => *has = true,
                None => without = true,
            }
        }
        let named = self.names.iter().zip(has_faces).filter(|(_, has)| *has).map(|(name, _)| name.as_str());
        without.then_some("").into_iter().chain(named).collect()
    }

    fn material(&mut self, name: &[u8]) {
        let new = self.names.len() as u32;
        self.current = *self.numbers.entry(name.into()).or_insert(new);
        if self.current == new {
            self.names.push(String::from_utf8_lossy(name).into_owned());
        }
    }

    fn vertex(&mut self, rest: &[u8]) -> Result<(), String> {
        // Three numbers, a weight, a colour with or without opacity, or both.
        let (v, n) = numbers::<8>(rest).filter(|(_, n)| *n >= 3).ok_or("`v` needs three numbers, and takes one or three more")?;
        let place = DVec3::new(v[0], v[1], v[2]);
        let place = match n {
            4 | 8 if v[3] == 0.0 => return Err("the fourth number of `v` is 0".into()),
            4 | 8 => place / v[3],
            5 => return Err("`v` takes one more number, or three".into()),
            _ => place,
        };
        self.positions.push(place);
        can_be_numbered(self.positions.len() as u64, "vertices")
    }

    fn texture_coordinates(&mut self, rest: &[u8]) -> Result<(), String> {
        let (v, _) = numbers::<3>(rest).filter(|(_, n)| *n >= 1).ok_or("`vt` needs one to three numbers")?;
        self.uvs.push([v[0] as f32, v[1] as f32]);
        can_be_numbered(self.uvs.len() as u64, "texture coordinates")
    }

    fn normal(&mut self, rest: &[u8]) -> Result<(), String> {
        let (v, _) = numbers::<3>(rest).filter(|(_, n)| *n == 3).ok_or("`vn` needs three numbers")?;
        self.normals.push(unit(DVec3::from_array(v)));
        can_be_numbered(self.normals.len() as u64, "normals")
    }

    fn face(&mut self, rest: &[u8], line: u64) -> Result<(), String> {
        let counts = [self.positions.len(), self.uvs.len(), self.normals.len()];
        let start = self.corners.len();
        for word in rest.split(u8::is_ascii_whitespace).filter(|w| !w.is_empty()) {
            let mut corner = [NONE; 3];
            let mut parts = word.split(|b| *b == b'/');
            for (k, part) in parts.by_ref().take(3).enumerate() {
                // `3//2` has no texture coordinates, and some programs write `3/` and `3//`.
                if part.is_empty() && k > 0 {
                    continue;
                }
                let text = std::str::from_utf8(part).map_err(|_| CORNER)?;
                let digits = text.strip_prefix(['-', '+']).unwrap_or(text);
                if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit()) {
                    return Err(CORNER.into());
                }
                let number: i64 = text.parse().map_err(|_| "a number of a vertex is too large")?;
                // From 1, or backwards from the last one so far.
                let index = if number < 0 { counts[k] as i64 + number } else { number - 1 };
                corner[k] = u32::try_from(index).ok().filter(|i| *i != NONE).ok_or_else(|| missing(k, number))?;
            }
            if parts.next().is_some() {
                return Err(CORNER.into());
            }
            self.corners.push(corner);
        }
        match self.corners.len() - start {
            0 => return Err("a face has no corners".into()),
            // A point or a line.
            1 | 2 => self.corners.truncate(start),
            _ => self.faces.push(Face { line, end: self.corners.len(), material: self.current }),
        }
        Ok(())
    }

    /// The mesh of all faces, or of those that have the material called `group`.
    ///
    /// # Errors
    /// That there are none, in words that can follow "cannot read `file`: ".
    pub fn mesh(&self, group: Option<&str>) -> Result<Obj, String> {
        let is_in =
            |face: &Face| group.is_none_or(|group| self.names.get(face.material as usize).map_or("", String::as_str) == group);
        let mut obj = Obj::default();
        let (mut has_normals, mut lacks_uvs, mut has_uvs) = (false, false, false);
        let (mut start, mut corners_in, mut faces_in) = (0, 0, 0);
        for face in &self.faces {
            if is_in(face) {
                for corner in &self.corners[start..face.end] {
                    has_normals |= corner[2] != NONE;
                    has_uvs |= corner[1] != NONE;
                    lacks_uvs |= corner[1] == NONE;
                }
                (corners_in, faces_in) = (corners_in + face.end - start, faces_in + 1);
            }
            start = face.end;
        }
        if let (Some(group), 0) = (group, faces_in) {
            let names: Vec<String> = self.groups().iter().take(20).map(|name| format!("`{name}`")).collect();
            return Err(format!("no face has the material `{group}` (`usemtl`); there is {}", names.join(", ")));
        }
        if has_uvs && lacks_uvs {
            // What it would be given is the place of some other part of a picture.
            obj.partial.push("texture coordinates");
        }
        let has_uvs = has_uvs && !lacks_uvs;
        // Vertices of the mesh: corners that have the same of everything.
        let mut table = Corners { first: vec![NONE; self.positions.len()], next: Vec::new(), corners: Vec::new() };
        let mut fans: Vec<Fan> = Vec::new();
        let triangles = &mut obj.mesh.triangles;
        triangles.reserve_exact(corners_in - 2 * faces_in);
        let mut start = 0;
        for face in &self.faces {
            let corners = &self.corners[start..face.end];
            start = face.end;
            if !is_in(face) {
                continue;
            }
            let mut number = |corner: &Corner| {
                let [v, uv, n] = *corner;
                table.number([v, if has_uvs { uv } else { NONE }, n])
            };
            let first = number(&corners[0]);
            let mut last = number(&corners[1]);
            if corners.len() > 3 {
                fans.push(Fan { start: triangles.len(), triangles: corners.len() - 2 });
            }
            for corner in &corners[2..] {
                let v = number(corner);
                triangles.push([first, last, v]);
                last = v;
            }
        }
        can_be_numbered(table.corners.len() as u64, "vertices")?;
        can_be_numbered(triangles.len() as u64, "triangles")?;
        let mesh = &mut obj.mesh;
        mesh.positions = table.corners.iter().map(|c| self.positions[c[0] as usize]).collect();
        if has_uvs {
            mesh.uvs = table.corners.iter().map(|c| self.uvs[c[1] as usize]).collect();
        }
        if has_normals {
            let normal = |c: &Corner| self.normals.get(c[2] as usize).copied().unwrap_or_default();
            mesh.normals = table.corners.iter().map(normal).collect();
        }
        obj.crossing_faces = fill_polygons(mesh, &fans);
        fill_normals(mesh);
        if obj.mesh.triangles.is_empty() { Err("it holds no triangle".into()) } else { Ok(obj) }
    }

    /// Whether what the faces use is there, and is numbers.
    fn check(&self) -> Result<(), String> {
        let mut start = 0;
        for Face { line, end, .. } in &self.faces {
            for [v, uv, n] in &self.corners[start..*end] {
                let in_line = |fault: String| Err(format!("line {line}: {fault}"));
                match self.positions.get(*v as usize) {
                    None => return in_line(missing(0, i64::from(*v) + 1)),
                    Some(p) if !p.is_finite() => {
                        return in_line(format!(
                            "a face uses vertex {}, which has a coordinate that is not a finite number",
                            v + 1
                        ));
                    }
                    Some(_) => {}
                }
                match self.uvs.get(*uv as usize) {
                    None if *uv != NONE => return in_line(missing(1, i64::from(*uv) + 1)),
                    Some(c) if !c.iter().all(|x| x.is_finite()) => {
                        return in_line("a texture coordinate is not a finite number of single precision".into());
                    }
                    _ => {}
                }
                if *n != NONE && *n as usize >= self.normals.len() {
                    return in_line(missing(2, i64::from(*n) + 1));
                }
            }
            start = *end;
        }
        Ok(())
    }
}

/// That a face uses what is not there: a vertex, texture coordinates or a normal, by the number that the file has for it.
#[cold]
fn missing(kind: usize, number: i64) -> String {
    let what = ["a vertex that does", "texture coordinates that do", "a normal that does"][kind];
    format!("a face uses {what} not exist ({number})")
}

/// Numbers the different corners in the order in which they come.
struct Corners {
    /// For each vertex of the file, the last corner that has it.
    first: Vec<u32>,
    /// For each corner, another one with the same vertex.
    next: Vec<u32>,
    corners: Vec<Corner>,
}

impl Corners {
    fn number(&mut self, corner: Corner) -> u32 {
        let head = corner[0] as usize;
        let mut i = self.first[head];
        while i != NONE {
            if self.corners[i as usize] == corner {
                return i;
            }
            i = self.next[i as usize];
        }
        let new = self.corners.len() as u32;
        self.corners.push(corner);
        self.next.push(self.first[head]);
        self.first[head] = new;
        new
    }
}
