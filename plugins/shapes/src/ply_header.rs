//! The header of a PLY file: which elements follow, in which order, and what their properties are.
//!
//! Source: G. Turk, "The PLY Polygon File Format", 1994; type words with sizes (`float32`) as in later files.

use crate::file_kind::looks_like;
use crate::obj_lines::{BYTE_ORDER_MARK, refuse_utf16};
use crate::ply_input::Input;

/// How the values after the header are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Format {
    Ascii,
    Little,
    Big,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Type {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Type {
    fn from_word(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes in a binary file.
    pub(crate) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn is_integer(self) -> bool {
        !matches!(self, Self::F32 | Self::F64)
    }
}

/// One property of an element.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Property {
    pub(crate) name: String,
    /// Of the value, or of the values of a list.
    pub(crate) ty: Type,
    /// For a list: the type of the number of values, which stands first.
    pub(crate) count: Option<Type>,
}

/// One kind of element.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Element {
    pub(crate) name: String,
    /// How many there are, says the header.
    pub(crate) count: u64,
    pub(crate) properties: Vec<Property>,
}

impl Element {
    /// The index of a property.
    pub(crate) fn find(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|p| p.name == name)
    }

    /// The fewest bytes that one element can have in the file.
    pub(crate) fn least_bytes(&self, format: Format) -> usize {
        let of = |p: &Property| match (format, p.count) {
            // A digit and a separator.
            (Format::Ascii, _) => 2,
            (_, Some(count)) => count.size(),
            (_, None) => p.ty.size(),
        };
        self.properties.iter().map(of).sum::<usize>().max(1)
    }
}

/// What the header says.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Header {
    pub(crate) format: Format,
    pub(crate) elements: Vec<Element>,
    /// The byte that ends a line.
    pub(crate) eol: u8,
    /// Lines of the header.
    pub(crate) lines: u64,
}

impl Header {
    /// The element `name`.
    pub(crate) fn element(&self, name: &str) -> Option<&Element> {
        self.elements.iter().find(|e| e.name == name)
    }
}

/// Reads up to and with the line `end_header`.
pub(crate) fn read(input: &mut Input) -> Result<Header, String> {
    if !input.fill(1)? {
        return Err("the file is empty".into());
    }
    input.fill(7)?;
    refuse_utf16(input.rest())?;
    if input.rest().starts_with(BYTE_ORDER_MARK) {
        input.consume(BYTE_ORDER_MARK.len());
    }
    let eol = match input.rest() {
        [b'p', b'l', b'y', b'\n', ..] => b'\n',
        // Lines end with \r\n, or with \r alone as on old Macintoshes: what follows the first decides.
        [b'p', b'l', b'y', b'\r', ..] => match input.fill(5)? && input.rest()[4] != b'\n' {
            true => b'\r',
            false => b'\n',
        },
        [b'p', b'l', b'y', b' ' | b'\t', ..] => b'\n',
        _ => {
            input.fill(512)?;
            return Err(format!("not a PLY file: its first line is not `ply`{}", looks_like(input.rest())));
        }
    };
    let mut header = Header { format: Format::Ascii, elements: Vec::new(), eol, lines: 0 };
    let mut format = None;
    loop {
        let Some(line) = input.line(eol)? else {
            return Err("the header has no end: there is no line `end_header`".into());
        };
        header.lines += 1;
        let text = String::from_utf8_lossy(input.bytes(line)).into_owned();
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        let done = header_line(&mut header, &mut format, &words).map_err(|e| format!("header line {}: {e}", header.lines))?;
        if done {
            break;
        }
    }
    header.format = format.ok_or("the header has no line `format`")?;
    Ok(header)
}

/// Takes in one line of the header; `true` for the last.
fn header_line(header: &mut Header, format: &mut Option<Format>, words: &[&str]) -> Result<bool, String> {
    match words {
        [] | ["comment" | "obj_info", ..] => {}
        ["ply"] if header.lines == 1 => {}
        ["end_header"] => return Ok(true),
        ["format", name, version] => {
            if format.is_some() {
                return Err("a second line `format`".into());
            }
            if *version != "1.0" {
                return Err(format!("version `{version}` of the format is unknown, only 1.0 is"));
            }
            *format = Some(match *name {
                "ascii" => Format::Ascii,
                "binary_little_endian" => Format::Little,
                "binary_big_endian" => Format::Big,
                _ => {
                    return Err(format!("format `{name}` is none of `ascii`, `binary_little_endian`, `binary_big_endian`"));
                }
            });
        }
        ["element", name, count] => {
            if header.element(name).is_some() {
                return Err(format!("element `{name}` is declared twice"));
            }
            let count = count.parse().map_err(|_| format!("expected the number of elements `{name}`, found `{count}`"))?;
            header.elements.push(Element { name: (*name).into(), count, properties: Vec::new() });
        }
        ["property", "list", count, ty, name] => {
            let (count, ty) = (type_of(count)?, type_of(ty)?);
            if !count.is_integer() {
                return Err(format!("the length of list `{name}` must have an integer type"));
            }
            add_property(header, Property { name: (*name).into(), ty, count: Some(count) })?;
        }
        ["property", ty, name] => {
            let ty = type_of(ty)?;
            add_property(header, Property { name: (*name).into(), ty, count: None })?;
        }
        [word @ ("format" | "element" | "property"), ..] => {
            return Err(format!("expected {}, found `{}`", usage(word), words.join(" ")));
        }
        [word, ..] => return Err(format!("unknown keyword `{word}`")),
    }
    Ok(false)
}

fn usage(word: &str) -> &'static str {
    match word {
        "format" => "`format NAME 1.0`",
        "element" => "`element NAME COUNT`",
        _ => "`property TYPE NAME` or `property list TYPE TYPE NAME`",
    }
}

fn type_of(word: &str) -> Result<Type, String> {
    Type::from_word(word).ok_or_else(|| format!("unknown type `{word}`"))
}

fn add_property(header: &mut Header, property: Property) -> Result<(), String> {
    let Some(element) = header.elements.last_mut() else {
        return Err(format!("property `{}` stands before any element", property.name));
    };
    if element.find(&property.name).is_some() {
        return Err(format!("element `{}` declares property `{}` twice", element.name, property.name));
    }
    element.properties.push(property);
    Ok(())
}

/// What the reader needs of the vertices: the place among the properties of each number, in the order
/// x y z, nx ny nz, u v.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct VertexLayout {
    /// For each property, which of the eight numbers it is.
    pub(crate) slots: Vec<Option<u8>>,
    pub(crate) has_normals: bool,
    pub(crate) has_uvs: bool,
}

/// The pairs of names that texture coordinates go by, as in pbrt-v4.
const UV_NAMES: [[&str; 2]; 4] = [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]];

impl VertexLayout {
    pub(crate) fn of(vertex: &Element) -> Result<Self, String> {
        let mut layout = Self { slots: vec![None; vertex.properties.len()], ..Self::default() };
        let scalar = |name: &str| vertex.find(name).filter(|i| vertex.properties[*i].count.is_none());
        for (slot, name) in (0u8..).zip(["x", "y", "z"]) {
            let i = scalar(name).ok_or_else(|| format!("the vertices have no property `{name}`"))?;
            layout.slots[i] = Some(slot);
        }
        let normal = ["nx", "ny", "nz"].map(scalar);
        if let [Some(x), Some(y), Some(z)] = normal {
            layout.has_normals = true;
            (layout.slots[x], layout.slots[y], layout.slots[z]) = (Some(3), Some(4), Some(5));
        } else if normal.iter().any(Option::is_some) {
            return Err("the vertices have some but not all of `nx`, `ny`, `nz`".into());
        }
        for [u, v] in UV_NAMES {
            if let (Some(u), Some(v)) = (scalar(u), scalar(v)) {
                layout.has_uvs = true;
                (layout.slots[u], layout.slots[v]) = (Some(6), Some(7));
                break;
            }
        }
        Ok(layout)
    }
}

/// The place among the properties of a face of its list of vertices.
pub(crate) fn index_property(face: &Element) -> Result<usize, String> {
    let i = face.find("vertex_indices").or_else(|| face.find("vertex_index"));
    let i = i.ok_or("the faces have no property `vertex_indices` (or `vertex_index`)")?;
    let property = &face.properties[i];
    if property.count.is_none() || !property.ty.is_integer() {
        return Err(format!("`{}` of the faces must be a list of integers", property.name));
    }
    Ok(i)
}
