//! Radiance pictures (RGBE and XYZE), as the program Radiance defines them and other programs write them.
//!
//! Source: G. Ward, "Real Pixels", Graphics Gems II, 1991; Radiance's `color.c`, `header.c` and `resolu.c` for what the text of a file
//! means. The first line is `#?` and any word. Radiance is the numbers of the file over all of its `EXPOSURE` and `COLORCORR`.
//! `PRIMARIES` are followed. XYZE has the white of equal energy, as Radiance writes it, and with an `EXPOSURE` 179 lumen a watt.
//! Own code: the crate `image` reads neither `#?RGBE`, nor other orders of rows, nor what exposures say.

use super::exr::convert;
use super::primaries::{EQUAL_ENERGY, Primaries, srgb_from, srgb_from_xyz_of};
use super::{check_size, reserve};
use bhs_core::image::{Image, Texels};
use glam::{DVec2, Mat3, Vec3};

/// Radiance's luminous efficacy of white light (lumen a watt).
const EFFICACY: f64 = 179.0;
/// Longest header that is searched for its end (bytes).
const LONGEST_HEADER: usize = 1 << 20;

/// What the text before the pixels says.
struct Header {
    width: usize,
    height: usize,
    /// Whether lines are columns.
    by_columns: bool,
    /// Whether the picture is stored from the right, and from below.
    mirrored: [bool; 2],
    /// What the numbers are to be multiplied with.
    scale: Vec3,
    matrix: Option<Mat3>,
    notes: Vec<String>,
}

/// The picture as linear sRGB.
pub(super) fn decode(bytes: &[u8]) -> Result<Image, String> {
    let mut rest = bytes;
    let header = read_header(&mut rest)?;
    let (width, height) = (header.width, header.height);
    let [length, lines] = if header.by_columns { [height, width] } else { [width, height] };
    check_size([width, height], usize::MAX, 1)?;
    // A line takes four bytes at least.
    if lines > rest.len() / 4 {
        return Err(format!("it is damaged: {} bytes cannot hold {width} x {height} texels", bytes.len()));
    }
    let mut texels: Vec<[f32; 3]> = Vec::new();
    // Runs of 127 take two bytes in each of four channels; only the old kind of runs, which nobody writes, does with less.
    if width * height <= 16 * rest.len() {
        reserve(&mut texels, [width, height])?;
    }
    let mut line = Vec::new();
    for i in 0..lines {
        read_line(&mut rest, length, &mut line).map_err(|why| format!("it is damaged: line {} of {lines} {why}", i + 1))?;
        texels.extend(line.iter().map(|rgbe| (light(*rgbe) * header.scale).to_array()));
    }
    if header.by_columns {
        texels = rows_of_columns(&texels, [width, height])?;
    }
    if header.mirrored[0] {
        texels.chunks_exact_mut(width).for_each(<[_]>::reverse);
    }
    if header.mirrored[1] {
        for y in 0..height / 2 {
            let (above, below) = texels.split_at_mut((height - 1 - y) * width);
            above[y * width..][..width].swap_with_slice(&mut below[..width]);
        }
    }
    if let Some(matrix) = header.matrix {
        convert(&mut texels, matrix);
    }
    let mut image = Image::new([width as u32, height as u32], Texels::Floats(texels));
    image.notes = header.notes;
    Ok(image)
}

fn rows_of_columns(columns: &[[f32; 3]], [width, height]: [usize; 2]) -> Result<Vec<[f32; 3]>, String> {
    let mut rows = Vec::new();
    reserve(&mut rows, [width, height])?;
    for y in 0..height {
        rows.extend((0..width).map(|x| columns[x * height + y]));
    }
    Ok(rows)
}

/// The light of a texel: mantissas of eight bits and a common exponent.
#[inline]
fn light([r, g, b, e]: [u8; 4]) -> Vec3 {
    // 2^(e - 136), exactly: below the normal numbers its product with a byte is rounded to what single precision has.
    let unit = if e == 0 { 0.0 } else { f64::from_bits((u64::from(e) + 1023 - 136) << 52) as f32 };
    Vec3::new(f32::from(r), f32::from(g), f32::from(b)) * unit
}

/// Steps over a line of text and hands it out without its end.
fn text_line<'a>(rest: &mut &'a [u8]) -> Option<&'a [u8]> {
    let end = rest.iter().take(LONGEST_HEADER).position(|b| *b == b'\n')?;
    let line = &rest[..end];
    *rest = &rest[end + 1..];
    Some(line.strip_suffix(b"\r").unwrap_or(line))
}

fn read_header(rest: &mut &[u8]) -> Result<Header, String> {
    const NO_END: &str = "it is no HDR picture: its header has no end (a blank line)";
    let mut scale = [1.0f64; 3];
    let (mut is_exposed, mut is_xyz) = (false, false);
    let mut primaries = None;
    let mut notes = Vec::new();
    let whole = rest.len();
    loop {
        let line = text_line(rest).filter(|_| whole - rest.len() <= LONGEST_HEADER).ok_or(NO_END)?;
        if line.trim_ascii().is_empty() {
            break;
        }
        let text = String::from_utf8_lossy(line);
        let Some((name, value)) = text.split_once('=') else { continue };
        let numbers: Vec<f64> = value.split_whitespace().map_while(|w| w.parse().ok()).collect();
        // As Radiance reads them, nothing stands before the name.
        match (name.trim_end(), numbers.as_slice()) {
            ("FORMAT", _) => match value.trim() {
                "32-bit_rle_rgbe" => is_xyz = false,
                "32-bit_rle_xyze" => is_xyz = true,
                other => return Err(format!("its FORMAT is `{other}`; 32-bit_rle_rgbe and 32-bit_rle_xyze are read")),
            },
            ("EXPOSURE", [e]) if e.is_finite() && *e > 0.0 => {
                scale.iter_mut().for_each(|s| *s /= e);
                is_exposed = true;
            }
            ("COLORCORR", c @ [_, _, _]) if c.iter().all(|c| c.is_finite() && *c > 0.0) => {
                scale.iter_mut().zip(c).for_each(|(s, c)| *s /= c);
            }
            ("EXPOSURE" | "COLORCORR", _) => notes.push(format!("its line `{}` means nothing and is left out", text.trim())),
            ("PRIMARIES", p @ [_, _, _, _, _, _, _, _]) => {
                primaries = Some(Primaries(std::array::from_fn(|i| DVec2::new(p[2 * i], p[2 * i + 1]))));
            }
            ("GAMMA", [g]) if (g - 1.0).abs() > 1e-3 => {
                notes.push(format!("its line `{}` is not taken into account: numbers count as linear", text.trim()));
            }
            _ => {}
        }
    }
    let mut matrix = None;
    if is_xyz {
        matrix = Some(srgb_from_xyz_of(EQUAL_ENERGY));
        if is_exposed {
            scale.iter_mut().for_each(|s| *s /= EFFICACY);
        }
        notes.push("its colours are CIE XYZ, taken to have the white of equal energy, as Radiance writes them".into());
    } else if let Some(primaries) = primaries {
        match srgb_from(primaries) {
            Ok(m) => matrix = m,
            Err(why) => notes.push(why.into()),
        }
    }
    let scale = Vec3::from_array(scale.map(|s| s as f32));
    let size = text_line(rest).ok_or("it ends where its size should stand")?;
    let (width, height, by_columns, mirrored) = resolution(size).ok_or_else(|| {
        let line: String = String::from_utf8_lossy(size).chars().take(40).filter(|c| !c.is_control()).collect();
        format!("expected its size, as `-Y 512 +X 1024`, found `{line}`")
    })?;
    Ok(Header { width, height, by_columns, mirrored, scale, matrix, notes })
}

/// Width, height, whether lines are columns, and whether they go to the left and upwards; of a line such as `-Y 512 +X 1024`.
fn resolution(line: &[u8]) -> Option<(usize, usize, bool, [bool; 2])> {
    let text = std::str::from_utf8(line).ok()?;
    let words: Vec<&str> = text.split_whitespace().collect();
    let [first, n, second, m] = words.as_slice() else { return None };
    let (n, m) = (n.parse().ok()?, m.parse().ok()?);
    match (*first, *second) {
        ("-Y" | "+Y", "+X" | "-X") => Some((m, n, false, [*second == "-X", *first == "+Y"])),
        ("-X" | "+X", "-Y" | "+Y") => Some((n, m, true, [*first == "-X", *second == "+Y"])),
        _ => None,
    }
}

/// Reads a line of `length` texels.
fn read_line(rest: &mut &[u8], length: usize, line: &mut Vec<[u8; 4]>) -> Result<(), &'static str> {
    const ENDS: &str = "is not there in full";
    line.clear();
    if let [2, 2, high, low, after @ ..] = *rest
        && *high < 128
        && (8..1 << 15).contains(&length)
    {
        if usize::from(*high) << 8 | usize::from(*low) != length {
            return Err("has another length than the picture");
        }
        *rest = after;
        line.resize(length, [0; 4]);
        for channel in 0..4 {
            let mut x = 0;
            while x < length {
                let (count, after) = rest.split_first().ok_or(ENDS)?;
                let (run, n) = if *count > 128 { (true, usize::from(count - 128)) } else { (false, usize::from(*count)) };
                if n == 0 || n > length - x {
                    return Err("has a run that is too long");
                }
                let taken = if run { 1 } else { n };
                let bytes = after.get(..taken).ok_or(ENDS)?;
                for (i, texel) in line[x..x + n].iter_mut().enumerate() {
                    texel[channel] = bytes[if run { 0 } else { i }];
                }
                *rest = &after[taken..];
                x += n;
            }
        }
        return Ok(());
    }
    // Single texels; three ones and a count repeat the last, counts of several in a row are digits to the base 256.
    let mut shift = 0;
    while line.len() < length {
        let (texel, after) = rest.split_first_chunk::<4>().ok_or(ENDS)?;
        *rest = after;
        if let [1, 1, 1, count] = *texel {
            let n = usize::from(count).checked_shl(shift).filter(|n| shift < 32 && *n <= length - line.len());
            let (Some(n), Some(last)) = (n, line.last().copied()) else { return Err("has a run that is too long") };
            line.resize(line.len() + n, last);
            shift += 8;
        } else {
            line.push(*texel);
            shift = 0;
        }
    }
    Ok(())
}
