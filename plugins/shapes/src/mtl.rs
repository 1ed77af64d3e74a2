//! MTL files: the materials of OBJ files, as plain data. What they become in a scene is not decided here.
//!
//! Read are the statements of Wavefront's Advanced Visualizer (1995) that programs write, and those of physically based rendering which Exocortex
//! proposed for Clara.io (2016) and Blender writes: `Pr`, `Pm`, `Pc`, `Pcr` and their pictures. A statement that cannot be read is left out with a note
//! that says in which line: a material lacks something then, and its scene is rendered all the same.
//!
//! Own code: `tobj` and `mtl` stop at the first line that they cannot read, keep options of pictures as text, and do not say where anything stands.

use crate::obj_lines::{BYTE_ORDER_MARK, number, refuse_utf16, take_line};
use std::collections::HashMap;

/// What a file holds.
#[derive(Clone, Debug, Default)]
pub struct Mtl {
    /// In the order of the file.
    pub materials: Vec<Material>,
    /// What cannot be read, in words that can follow "`file`: ".
    pub notes: Vec<String>,
}

/// A material; `None`: the file does not say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Material {
    /// The name after `newmtl`.
    pub name: String,
    /// Colours by their statements: `Kd`, `Ks`, `Ke`, `Tf`; linear sRGB.
    pub colours: HashMap<&'static str, [f64; 3]>,
    /// Numbers by their statements: `Ns`, `Ni`, `d`, `Pr`, `Pm`, `Pc`, `Pcr`, `illum`. `Tr` is in `d`.
    pub numbers: HashMap<&'static str, f64>,
    /// Pictures by their statements: `map_Kd`, `map_Ke`, `map_d`, `map_Pr`, `map_Pm`, `norm`, `map_Bump`, `disp`.
    pub maps: HashMap<&'static str, Map>,
    /// Statements of pictures that are not read, such as `refl`.
    pub unread: Vec<String>,
}

/// A picture and how it is placed.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// Its path, with `/` between folders.
    pub path: String,
    /// Factors of u and v.
    pub scale: [f64; 2],
    /// What is added to them.
    pub offset: [f64; 2],
    /// Whether the picture's edge goes on outside, in place of the picture anew.
    pub clamp: bool,
    /// The channel that a number is read from: `r`, `g`, `b`, `m` (how opaque it is) or `l`.
    pub channel: Option<char>,
    /// What values are multiplied with.
    pub gain: f64,
    /// What heights are multiplied with, and the slopes of normals.
    pub bump: f64,
}

const COLOURS: [&str; 4] = ["Kd", "Ks", "Ke", "Tf"];
const NUMBERS: [&str; 7] = ["Ns", "Ni", "Pr", "Pm", "Pc", "Pcr", "illum"];
const MAPS: [&str; 8] = ["map_Kd", "map_Ke", "map_d", "map_Pr", "map_Pm", "norm", "map_Bump", "disp"];
/// Statements that change nothing here: the ambient light of other methods, sharpness of reflections, anti-aliasing of textures, sheen, anisotropy.
const WITHOUT_EFFECT: [&str; 9] = ["Ka", "map_Ka", "sharpness", "map_aat", "Ps", "aniso", "anisor", "map_Ps", "Km"];
/// Other names of some statements.
const OTHER_NAMES: [(&str, &str); 8] = [
    ("map_Tr", "map_d"),
    ("map_opacity", "map_d"),
    ("map_emissive", "map_Ke"),
    ("Pe", "Ke"),
    ("bump", "map_Bump"),
    ("map_norm", "norm"),
    ("map_Kn", "norm"),
    ("map_disp", "disp"),
];
/// Notes of one file.
const MAX_NOTES: usize = 20;

/// Reads a whole file.
///
/// # Errors
/// That it is no text.
pub fn parse(file: &[u8]) -> Result<Mtl, String> {
    refuse_utf16(file)?;
    let mut mtl = Mtl::default();
    let mut rest = file.strip_prefix(BYTE_ORDER_MARK).unwrap_or(file);
    let (mut line_number, mut unnoted) = (0u64, 0u64);
    while let Some(line) = take_line(&mut rest) {
        line_number += 1;
        let first = line_number;
        let mut line = String::from_utf8_lossy(line).into_owned();
        while let Some(length) = line.trim_end().strip_suffix('\\').map(str::len) {
            line.truncate(length);
            let Some(next) = take_line(&mut rest) else { break };
            line_number += 1;
            line = line + " " + &String::from_utf8_lossy(next);
        }
        if let Err(fault) = mtl.statement(line.trim()) {
            match mtl.notes.len() < MAX_NOTES {
                true => mtl.notes.push(format!("line {first}: {fault}")),
                false => unnoted += 1,
            }
        }
    }
    if unnoted > 0 {
        mtl.notes.push(format!("{unnoted} more statements are not read"));
    }
    Ok(mtl)
}

impl Mtl {
    fn statement(&mut self, line: &str) -> Result<(), String> {
        let length = line.find(char::is_whitespace).unwrap_or(line.len());
        let (word, rest) = (&line[..length], line[length..].trim());
        if word.is_empty() || word.starts_with('#') {
            return Ok(());
        }
        if word.eq_ignore_ascii_case("newmtl") {
            self.materials.push(Material { name: rest.to_owned(), ..Material::default() });
            return Ok(());
        }
        let is = |name: &str| word.eq_ignore_ascii_case(name);
        let canonical = OTHER_NAMES.into_iter().find(|(other, _)| is(other)).map_or(word, |(_, name)| name);
        let known = |names: &[&'static str]| names.iter().copied().find(|n| canonical.eq_ignore_ascii_case(n));
        let Some(material) = self.materials.last_mut() else {
            return Err(format!("`{}` stands before the first `newmtl`, and is not read", shown(word)));
        };
        if let Some(name) = known(&COLOURS) {
            material.colours.insert(name, colour(name, rest)?);
        } else if let Some(name) = known(&NUMBERS) {
            material.numbers.insert(name, one_number(name, rest)?);
        } else if is("d") {
            // A halo makes the rim of a ball more opaque than its middle.
            material.numbers.insert("d", one_number("d", rest.trim_start_matches("-halo"))?);
        } else if is("Tr") {
            let opaque = 1.0 - one_number("Tr", rest)?;
            material.numbers.entry("d").or_insert(opaque);
        } else if let Some(name) = known(&MAPS) {
            material.maps.insert(name, map(name, rest)?);
        } else if known(&WITHOUT_EFFECT).is_some() {
            return Ok(());
        } else if ["decal", "refl"].iter().any(|name| is(name)) || word.starts_with("map_") {
            material.unread.push(shown(word));
        } else {
            return Err(format!("`{}` is not known, and not read", shown(word)));
        }
        Ok(())
    }
}

/// The beginning of a word, for a message.
fn shown(word: &str) -> String {
    word.chars().filter(|c| !c.is_control()).take(30).collect()
}

fn finite(word: &str) -> Option<f64> {
    number(word.as_bytes()).filter(|x| x.is_finite())
}

fn colour(name: &str, rest: &str) -> Result<[f64; 3], String> {
    let words: Vec<&str> = rest.split_whitespace().collect();
    if let Some(kind @ ("spectral" | "xyz")) = words.first().copied() {
        return Err(format!("`{name} {kind}` is not read: write three numbers"));
    }
    let values: Option<Vec<f64>> = words.iter().map(|w| finite(w)).collect();
    match values.as_deref() {
        Some([r, g, b]) => Ok([*r, *g, *b]),
        // Grey.
        Some([grey]) => Ok([*grey; 3]),
        _ => Err(format!("`{name}` needs three numbers, and is not read")),
    }
}

fn one_number(name: &str, rest: &str) -> Result<f64, String> {
    let first = rest.split_whitespace().next().and_then(finite);
    first.ok_or_else(|| format!("`{name}` needs a number, and is not read"))
}

/// Options of pictures, and how many values each takes at least and at most.
const OPTIONS: [(&str, usize, usize); 14] = [
    ("-blendu", 1, 1),
    ("-blendv", 1, 1),
    ("-boost", 1, 1),
    ("-bm", 1, 1),
    ("-cc", 1, 1),
    ("-clamp", 1, 1),
    ("-colorspace", 1, 1),
    ("-imfchan", 1, 1),
    ("-mm", 2, 2),
    ("-o", 1, 3),
    ("-s", 1, 3),
    ("-t", 1, 3),
    ("-texres", 1, 1),
    ("-type", 1, 1),
];

/// A picture with its options, which stand before its name; that takes the rest of the line, spaces and all.
fn map(name: &str, line: &str) -> Result<Map, String> {
    let (scale, offset) = ([1.0; 2], [0.0; 2]);
    let mut map = Map { path: String::new(), scale, offset, clamp: false, channel: None, gain: 1.0, bump: 1.0 };
    let mut rest = line;
    let next = |rest: &mut &str| {
        let text = rest.trim_start();
        let length = text.find(char::is_whitespace).unwrap_or(text.len());
        let (word, after) = text.split_at(length);
        *rest = after;
        word.to_owned()
    };
    while let Some((option, least, most)) = OPTIONS.into_iter().find(|(option, ..)| {
        let text = rest.trim_start();
        text.get(..option.len()).is_some_and(|t| t.eq_ignore_ascii_case(option))
            && text[option.len()..].starts_with(char::is_whitespace)
    }) {
        next(&mut rest);
        let mut values = Vec::new();
        while values.len() < most {
            let mut after = rest;
            let word = next(&mut after);
            // Of numbers there may be fewer: what is none belongs to the name.
            if word.is_empty() || (values.len() >= least && finite(&word).is_none()) {
                break;
            }
            rest = after;
            values.push(word);
        }
        let numbers: Vec<f64> = values.iter().filter_map(|v| finite(v)).collect();
        let pair =
            |default: [f64; 2]| [numbers.first().copied().unwrap_or(default[0]), numbers.get(1).copied().unwrap_or(default[1])];
        match option {
            "-s" => map.scale = pair([1.0; 2]),
            "-o" => map.offset = pair([0.0; 2]),
            "-bm" => map.bump = numbers.first().copied().unwrap_or(1.0),
            "-mm" => map.gain = pair([0.0, 1.0])[1],
            "-clamp" => map.clamp = values.first().is_some_and(|v| v.eq_ignore_ascii_case("on")),
            "-imfchan" => map.channel = values.first().and_then(|v| v.chars().next()).map(|c| c.to_ascii_lowercase()),
            // What is not about where the picture lies.
            _ => {}
        }
    }
    let path = rest.trim().trim_matches('"').trim();
    if path.is_empty() {
        return Err(format!("`{name}` names no file, and is not read"));
    }
    map.path = path.replace('\\', "/");
    Ok(map)
}
