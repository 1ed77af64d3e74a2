//! A reader of PLY files: text, binary of both byte orders, and either of them compressed with gzip.
//!
//! Elements, properties, types and their order are free; `vertex` and `face` are used, the rest is stepped over. Of the
//! vertices: `x y z`, `nx ny nz`, and the first complete pair of `u v`, `s t`, `texture_u texture_v`, `texture_s texture_t`.
//! Of the faces: the list `vertex_indices` (or `vertex_index`); polygons of more than three corners are filled with triangles (`polygon`);
//! those of fewer than three are left out and counted. A normal that is no number counts as none; a place that is none is an error where a
//! face uses it.
//!
//! Own code because of speed: the 871,414 triangles of the Stanford dragon as gzip'd text (8.3 MB, 34 MB unpacked) take
//! 0.25 s and 31 MB of memory in all, 0.08 s of it to unpack; with `ply-rs-bw` 4.0.1 they take 0.65 s and 69 MB into structs of
//! ours, 2.6 s and 579 MB into its own (one of two cores, Rust 1.95, November 2026). And for errors that name their place.

use crate::mesh::{Fan, can_be_numbered, fill_normals, fill_polygons};
use crate::ply_body::{Ascii, Binary, Values};
use crate::ply_header::{self, Element, Format, Header, Property, Type, VertexLayout};
use crate::ply_input::Input;
use bhs_core::geometry::WorldMesh;
use glam::DVec3;

/// What a PLY file holds.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ply {
    /// The triangles, in the file's own coordinates, normals as in the file.
    pub mesh: WorldMesh,
    /// Faces that had fewer than three corners.
    pub dropped_faces: u64,
    /// Faces whose outline crosses itself.
    pub crossing_faces: u64,
    /// What of the file could be seen, and is not read.
    pub unread: Vec<&'static str>,
    /// Whether something follows the last element that the header announces.
    pub goes_on: bool,
}

/// Reads the content of a PLY file.
///
/// Memory is reserved only as far as the size of the file can justify, whatever its header says.
///
/// # Errors
/// What is wrong and where: the line of the header or of the text, or the number of the element, counted from 0.
pub fn read(file: &[u8]) -> Result<Ply, String> {
    let mut input = Input::new(file);
    let header = ply_header::read(&mut input)?;
    let (eol, lines, size) = (header.eol, header.lines, input.size());
    match header.format {
        Format::Ascii => Reader::new(&header, Ascii::new(&mut input, eol, lines), size).read(),
        Format::Little => Reader::new(&header, Binary::<false>(&mut input), size).read(),
        Format::Big => Reader::new(&header, Binary::<true>(&mut input), size).read(),
    }
}

struct Reader<'h, V> {
    header: &'h Header,
    values: V,
    /// Bytes of the (decompressed) file.
    size: usize,
    ply: Ply,
    /// Polygons that are to be filled once all vertices are known.
    fans: Vec<Fan>,
    /// The first vertices without a place, and what is wrong with them, should a face use them.
    odd: Vec<(u32, String)>,
}

/// So many vertices without a place are told with where they stand: files of scanners have thousands.
const MOST_ODD: usize = 100;

impl<'h, V: Values> Reader<'h, V> {
    fn new(header: &'h Header, values: V, size: usize) -> Self {
        Self { header, values, size, ply: Ply::default(), fans: Vec::new(), odd: Vec::new() }
    }

    fn read(mut self) -> Result<Ply, String> {
        // What the header leaves out is told before anything is read.
        let vertex = self.header.element("vertex").ok_or("the file has no element `vertex`")?;
        let has_strips = self.header.element("tristrips").is_some();
        let face = self.header.element("face").ok_or(match has_strips {
            true => "its surface is triangle strips (element `tristrips`), which are not read: save it with faces",
            false => "the file has no element `face`: no surface, points only",
        })?;
        let layout = VertexLayout::of(vertex)?;
        let index = ply_header::index_property(face)?;
        can_be_numbered(vertex.count, "vertices")?;
        for element in &self.header.elements {
            match element.name.as_str() {
                "vertex" => self.vertices(element, &layout)?,
                "face" => self.faces(element, index, vertex.count as i64)?,
                _ => self.others(element)?,
            }
        }
        self.ply.goes_on = self.values.goes_on()?;
        if has_strips {
            self.ply.unread.push("triangle strips (element `tristrips`)");
        }
        if !layout.has_uvs && face.find("texcoord").is_some() {
            self.ply.unread.push("texture coordinates of the corners of faces (`texcoord`)");
        }
        self.places()?;
        self.ply.crossing_faces = fill_polygons(&mut self.ply.mesh, &self.fans);
        fill_normals(&mut self.ply.mesh);
        Ok(self.ply)
    }

    /// Refuses a vertex without a place that a face uses; one that none uses, as scanners write, gets some place that is used.
    fn places(&mut self) -> Result<(), String> {
        let mesh = &mut self.ply.mesh;
        if mesh.positions.iter().all(|p| p.is_finite()) {
            return Ok(());
        }
        let used = mesh.triangles.iter().flatten();
        if let Some(v) = used.copied().find(|v| !mesh.positions[*v as usize].is_finite()) {
            let told = self.odd.iter().find(|(i, _)| *i == v).map(|(_, told)| told.clone());
            return Err(
                told.unwrap_or_else(|| format!("a face uses vertex {v}, which has a coordinate that is not a finite number"))
            );
        }
        let somewhere = mesh.triangles.first().map_or(DVec3::ZERO, |t| mesh.positions[t[0] as usize]);
        mesh.positions.iter_mut().filter(|p| !p.is_finite()).for_each(|p| *p = somewhere);
        Ok(())
    }

    /// As many elements as the header announces, but no more than the file can hold.
    fn plausible(&self, element: &Element) -> usize {
        let most = self.size / element.least_bytes(self.header.format);
        usize::try_from(element.count).map_or(most, |count| count.min(most))
    }

    /// The place of a fault.
    fn place(&self, element: &Element, i: u64, fault: &str) -> String {
        let (name, count) = (&element.name, element.count);
        match self.values.line() {
            Some(line) => format!("line {line}, {name} {i} of {count}: {fault}"),
            None => format!("{name} {i} of {count}: {fault}"),
        }
    }

    fn vertices(&mut self, element: &Element, layout: &VertexLayout) -> Result<(), String> {
        let plausible = self.plausible(element);
        self.ply.mesh.positions.reserve_exact(plausible);
        self.ply.mesh.normals.reserve_exact(if layout.has_normals { plausible } else { 0 });
        self.ply.mesh.uvs.reserve_exact(if layout.has_uvs { plausible } else { 0 });
        for i in 0..element.count {
            let odd = self.vertex(element, layout).map_err(|e| self.place(element, i, &e))?;
            if let (Some(fault), true) = (odd, self.odd.len() < MOST_ODD) {
                let told = self.place(element, i, &format!("{fault}, and a face uses it"));
                self.odd.push((i as u32, told));
            }
        }
        Ok(())
    }

    /// Reads a vertex; what is wrong with it if it has no place, which matters only if a face uses it.
    #[inline]
    fn vertex(&mut self, element: &Element, layout: &VertexLayout) -> Result<Option<String>, String> {
        let mut numbers = [0.0; 8];
        let mut odd = None;
        self.values.begin()?;
        for (property, slot) in element.properties.iter().zip(&layout.slots) {
            match slot {
                Some(slot) => {
                    let x = self.values.number(property.ty)?;
                    // Texture coordinates are kept in single precision; normals that are none are made later.
                    if !(x as f32).is_finite() && (*slot > 5 || (*slot < 3 && !x.is_finite())) {
                        let fault = format!("`{}` is not a finite number ({x})", property.name);
                        if *slot > 5 {
                            return Err(fault);
                        }
                        odd = Some(fault);
                    }
                    numbers[usize::from(*slot)] = x;
                }
                None => self.step_over(property)?,
            }
        }
        self.values.end()?;
        let [x, y, z, nx, ny, nz, u, v] = numbers;
        self.ply.mesh.positions.push(DVec3::new(x, y, z));
        if layout.has_normals {
            let normal = [nx, ny, nz].map(|c| c as f32);
            self.ply.mesh.normals.push(if normal.iter().all(|c| c.is_finite()) { normal } else { [0.0; 3] });
        }
        if layout.has_uvs {
            self.ply.mesh.uvs.push([u, v].map(|c| c as f32));
        }
        Ok(odd)
    }

    fn faces(&mut self, element: &Element, index: usize, vertices: i64) -> Result<(), String> {
        // A triangle has at least three indices besides what every face has.
        let triangle = element.least_bytes(self.header.format) + 3 * element.properties[index].ty.size().min(2);
        let plausible = self.plausible(element).min(self.size / triangle);
        self.ply.mesh.triangles.reserve_exact(plausible);
        for i in 0..element.count {
            self.face(element, index, vertices).map_err(|e| self.place(element, i, &e))?;
        }
        Ok(())
    }

    #[inline]
    fn face(&mut self, element: &Element, index: usize, vertices: i64) -> Result<(), String> {
        self.values.begin()?;
        for (i, property) in element.properties.iter().enumerate() {
            match property.count {
                Some(count) if i == index => self.polygon(count, property.ty, vertices)?,
                _ => self.step_over(property)?,
            }
        }
        self.values.end()
    }

    #[inline]
    fn polygon(&mut self, count: Type, ty: Type, vertices: i64) -> Result<(), String> {
        let corners = self.length(count)?;
        self.ply.dropped_faces += u64::from(corners < 3);
        let start = self.ply.mesh.triangles.len();
        let (mut first, mut last) = (0, 0);
        for k in 0..corners {
            let v = self.values.integer(ty)?;
            if v < 0 || v >= vertices {
                return Err(bad_index(v, vertices));
            }
            let v = v as u32;
            match k {
                0 => first = v,
                1 => {}
                _ => self.ply.mesh.triangles.push([first, last, v]),
            }
            last = v;
        }
        if corners > 3 {
            self.fans.push(Fan { start, triangles: self.ply.mesh.triangles.len() - start });
        }
        Ok(())
    }

    #[inline]
    fn length(&mut self, count: Type) -> Result<u64, String> {
        let n = self.values.integer(count)?;
        u64::try_from(n).map_err(|_| format!("a list of {n} values"))
    }

    fn step_over(&mut self, property: &Property) -> Result<(), String> {
        let n = match property.count {
            Some(count) => self.length(count)?,
            None => 1,
        };
        self.values.skip(property.ty, n)
    }

    fn others(&mut self, element: &Element) -> Result<(), String> {
        // Elements without properties take no room in a binary file, and blank lines in text.
        let count = if element.properties.is_empty() { 0 } else { element.count };
        for i in 0..count {
            let read = |r: &mut Self| {
                r.values.begin()?;
                element.properties.iter().try_for_each(|p| r.step_over(p))?;
                r.values.end()
            };
            read(self).map_err(|e: String| self.place(element, i, &e))?;
        }
        Ok(())
    }
}

#[cold]
fn bad_index(v: i64, vertices: i64) -> String {
    if v < 0 {
        format!("vertex index {v} is negative")
    } else {
        format!("vertex index {v} is out of range: there are {vertices} vertices, counted from 0")
    }
}
