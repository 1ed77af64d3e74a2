//! OpenEXR files, read block by block with the crate `exr`.
//!
//! The picture is the display window: what the data window has beside it is cut off, and what it lacks is black. Scan lines, tiles,
//! the largest of several resolutions, every compression but HTJ2K; no deep data, no subsampled channels. Colours of other primaries
//! (`chromaticities`) become linear sRGB. A number that is none (NaN) is 0, an infinite one the largest of a half, 65504; both are
//! told.

use super::exr_layer::{Choice, Colours, Part, choose};
use super::primaries::{Primaries, srgb_from};
use super::{BRIGHTEST, check_size, texels};
use bhs_colour::LUMINANCE;
use bhs_core::image::{Image, Texels};
use exr::block::chunk::CompressedBlock;
use exr::block::reader::Reader;
use exr::block::{self, UncompressedBlock};
use exr::compression::Compression;
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::{Chromaticities, IntegerBounds, SampleType};
use exr::meta::header::Header;
use exr::prelude::f16;
use glam::{DVec2, DVec3, Mat3, Vec3};
use std::io::Cursor;

/// Most values (texels times channels) of [`read_all`].
const MAX_VALUES: usize = 1 << 30;

/// A display window may be so many times as large as the data window,
const DISPLAY_OVER_DATA: usize = 16;
/// or have so many texels a byte of the file, or so many in all: what a small crop leaves black costs memory that the file does not pay for.
const DISPLAY_A_BYTE: usize = 16;
const DISPLAY_IN_ALL: usize = 1 << 18;

/// All channels of the part of a file that is the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Channels {
    /// Width and height of the data window (texels).
    pub size: [usize; 2],
    /// First column and row of the data window within the display window.
    pub offset: [i64; 2],
    /// Width and height of the display window.
    pub frame: [usize; 2],
    /// Names, as in the file.
    pub names: Vec<String>,
    /// Values as they are in the file, row by row from the top, those of a texel together.
    pub values: Vec<f32>,
}

/// Reads all channels of the part that holds the picture, of the first flat part if there are no colours.
///
/// # Errors
/// What is wrong with the file, in words that can follow "cannot read `file`: ".
pub fn read_all(bytes: &[u8]) -> Result<Channels, String> {
    let reader = open(bytes)?;
    let parts = flat_parts(reader.headers())?;
    let part = choose(&parts).map_or(parts[0].index, |choice| choice.part);
    read_channels(reader, part)
}

/// Reads all channels of a part.
pub(super) fn read_channels(reader: Reader<Cursor<&[u8]>>, part: usize) -> Result<Channels, String> {
    let header = &reader.headers()[part];
    let size = [header.layer_size.width(), header.layer_size.height()];
    let names: Vec<String> = header.channels.list.iter().map(|c| c.name.to_string()).collect();
    let count = names.len();
    if count == 0 || size[0] * size[1] > MAX_VALUES / count {
        return Err(format!("it is too large: {} x {} texels of {count} channels", size[0], size[1]));
    }
    let (data, display) = (header.data_window(), header.shared_attributes.display_window);
    let mut values = texels([size[0] * count, size[1]])?;
    let channels: Vec<usize> = (0..count).collect();
    read_blocks(reader, part, &channels, |c, [x, y], line| {
        for (i, v) in line.iter().enumerate() {
            values[(y * size[0] + x + i) * count + c] = *v;
        }
    })?;
    Ok(Channels { size, offset: offset(data, display), frame: [display.size.0, display.size.1], names, values })
}

/// The picture as linear sRGB.
pub(super) fn decode(bytes: &[u8]) -> Result<Image, String> {
    let reader = open(bytes)?;
    let Choice { part, colours, note } = choose(&flat_parts(reader.headers())?)?;
    let header = &reader.headers()[part];
    let data_size = [header.layer_size.width(), header.layer_size.height()];
    let display = header.shared_attributes.display_window;
    let [width, height] = [display.size.0, display.size.1];
    check_size([width, height], usize::MAX, 1)?;
    let justified = (DISPLAY_OVER_DATA * data_size[0] * data_size[1]).max(DISPLAY_A_BYTE * bytes.len()).max(DISPLAY_IN_ALL);
    if width * height > justified {
        let [w, h] = data_size;
        return Err(format!("its display window, {width} x {height}, is too large for the {w} x {h} texels that it holds"));
    }
    let mut notes: Vec<String> = note.into_iter().collect();
    let data = header.data_window();
    let [left, top] = offset(data, display);
    let [right, bottom] = [left + data.size.0 as i64, top + data.size.1 as i64];
    if right <= 0 || bottom <= 0 || left >= width as i64 || top >= height as i64 {
        return Err("its data window lies outside of its display window: nothing of it is seen".into());
    }
    if left > 0 || top > 0 || right < width as i64 || bottom < height as i64 {
        let [w, h] = [data.size.0, data.size.1];
        notes.push(format!(
            "its data, {w} x {h} at ({left}, {top}), fill a part of its {width} x {height} only: the rest is black"
        ));
    }
    let chromaticities = header.shared_attributes.chromaticities;
    let channels = match colours {
        Colours::Rgb(rgb) => rgb.to_vec(),
        Colours::Grey(y) => vec![y],
        Colours::Chroma(chroma) => chroma.to_vec(),
    };
    let mut texels: Vec<[f32; 3]> = texels([width, height])?;
    let mut odd = Odd::default();
    let is_grey = matches!(colours, Colours::Grey(_));
    read_blocks(reader, part, &channels, |c, [x, y], line| {
        let row = top + y as i64;
        if !(0..height as i64).contains(&row) {
            return;
        }
        let first = left + x as i64;
        // The part of the line that is in the picture.
        let skipped = (-first).clamp(0, line.len() as i64);
        let taken = (width as i64 - first).clamp(skipped, line.len() as i64);
        let start = row * width as i64 + first + skipped;
        let line = &line[skipped as usize..taken as usize];
        for (texel, v) in texels.iter_mut().skip(start as usize).zip(line) {
            let v = odd.number(*v);
            if is_grey { *texel = [v; 3] } else { texel[c] = v }
        }
    })?;
    if let Colours::Chroma(_) = colours {
        texels.iter_mut().for_each(|t| *t = rgb_of_chroma(*t, luminance_weights(chromaticities)));
    }
    notes.extend(odd.notes());
    if let (Some(c), false) = (chromaticities, is_grey) {
        match srgb_from(primaries(c)) {
            Ok(None) => {}
            Ok(Some(matrix)) => convert(&mut texels, matrix),
            Err(why) => notes.push(why.into()),
        }
    }
    let mut image = Image::new([width as u32, height as u32], Texels::Floats(texels));
    image.notes = notes;
    Ok(image)
}

/// Applies a matrix to each colour; colours out of sRGB's gamut get negative parts.
pub(super) fn convert(texels: &mut [[f32; 3]], matrix: Mat3) {
    for texel in texels {
        *texel = (matrix * Vec3::from_array(*texel)).to_array();
    }
}

/// Counts numbers that are no light.
#[derive(Default)]
pub(super) struct Odd {
    nan: u64,
    infinite: u64,
}

impl Odd {
    #[inline]
    pub(super) fn number(&mut self, v: f32) -> f32 {
        if v.is_finite() {
            v
        } else if v == f32::INFINITY {
            self.infinite += 1;
            BRIGHTEST
        } else {
            self.nan += 1;
            0.0
        }
    }

    pub(super) fn notes(&self) -> impl Iterator<Item = String> {
        let nan = (self.nan > 0).then(|| format!("{} of its values are not numbers and count as 0", self.nan));
        let infinite =
            (self.infinite > 0).then(|| format!("{} of its values are infinite and count as {BRIGHTEST}", self.infinite));
        nan.into_iter().chain(infinite)
    }
}

/// Reads the headers, once it is known that the file can hold what they say.
pub(super) fn open(bytes: &[u8]) -> Result<Reader<Cursor<&[u8]>>, String> {
    let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(|e| explain(&e))?;
    for header in meta.headers.iter().filter(|h| !h.deep) {
        check_header(header, bytes.len())?;
    }
    block::read(Cursor::new(bytes), false).map_err(|e| explain(&e))
}

/// The crate's errors, and what can be done about those that are no damage.
fn explain(error: &exr::error::Error) -> String {
    let said = error.to_string();
    if said.contains("sampling") {
        return format!(
            "channels of it are subsampled, as with luminance and chroma (Y, RY, BY): save it as R, G and B ({said})"
        );
    }
    if said.contains("deep") {
        return "it holds deep data, which are not read: save it flat".into();
    }
    if said.contains("compression method") || said.contains("ht j2k") {
        return "its compression (HTJ2K, or newer than that) is not read: save it with ZIP, PIZ or DWAA".into();
    }
    format!("it is damaged: {said}")
}

/// The parts that are not deep.
pub(super) fn flat_parts(headers: &[Header]) -> Result<Vec<Part>, String> {
    let flat = headers.iter().enumerate().filter(|(_, h)| !h.deep);
    let parts: Vec<Part> = flat
        .map(|(index, h)| Part {
            index,
            name: h.own_attributes.layer_name.as_ref().map(ToString::to_string).unwrap_or_default(),
            channels: h.channels.list.iter().map(|c| c.name.to_string()).collect(),
        })
        .collect();
    if parts.is_empty() { Err("it holds deep data, which are not read: save it flat".into()) } else { Ok(parts) }
}

/// Whether the file is large enough for what a header says.
fn check_header(header: &Header, bytes: usize) -> Result<(), String> {
    let size = [header.layer_size.width(), header.layer_size.height()];
    // Bytes that one can stand for at most. Deflate: 1032 (zlib's technical details), PXR24 4/3 of that. Runs: 64. PIZ: about 500, by its
    // runs of 255 and more. B44A: 32/3. DWA: one byte of a run for 64 texels of a block, and that through deflate or PIZ's Huffman code.
    let ratio = match header.compression {
        Compression::Uncompressed => 1,
        Compression::RLE => 64,
        Compression::B44 | Compression::B44A => 16,
        Compression::DWAA(_) | Compression::DWAB(_) => 70_000,
        _ => 1400,
    };
    let texel = header.channels.bytes_per_pixel.max(1);
    check_size(size, bytes.saturating_mul(ratio) / texel, 1).map_err(|why| {
        // In bytes of the file, not of what they stand for.
        let cannot = format!("it is damaged: {bytes} bytes cannot hold {} x {} texels", size[0], size[1]);
        if why.contains("damaged") { cannot } else { why }
    })
}

/// Hands over the lines of some channels of a part: number in `channels`, column and row in the data window, values. All of them, else
/// it is an error.
fn read_blocks(
    reader: Reader<Cursor<&[u8]>>,
    part: usize,
    channels: &[usize],
    mut line: impl FnMut(usize, [usize; 2], &[f32]),
) -> Result<(), String> {
    let meta = reader.meta_data().clone();
    let header = &meta.headers[part];
    let list = &header.channels.list;
    let mut missing = header.layer_size.area();
    // The wanted channels by their number in the file.
    let mut place = vec![None; list.len()];
    for (k, c) in channels.iter().enumerate() {
        place[*c] = Some(k);
    }
    let mut floats = Vec::new();
    let chunks = reader.all_chunks(false).map_err(|e| explain(&e))?;
    for chunk in chunks {
        let chunk = match chunk {
            Ok(chunk) => chunk,
            // Damage behind the picture does not matter.
            Err(_) if missing == 0 => break,
            Err(e) => return Err(explain(&e)),
        };
        let is_wanted = match &chunk.compressed_block {
            CompressedBlock::ScanLine(_) => true,
            CompressedBlock::Tile(tile) => tile.coordinates.level_index == Vec2(0, 0),
            _ => false,
        };
        if chunk.layer_index != part || !is_wanted {
            continue;
        }
        check_dwa(header, &chunk.compressed_block)?;
        let block = UncompressedBlock::decompress_chunk(chunk, &meta, false).map_err(|e| explain(&e))?;
        let (Vec2(x, y), Vec2(w, h)) = (block.index.pixel_position, block.index.pixel_size);
        missing = missing.saturating_sub(w * h);
        let mut at = 0;
        for row in 0..h {
            for (c, channel) in list.iter().enumerate() {
                let length = w * channel.sample_type.bytes_per_sample();
                let bytes = block.data.get(at..at + length).ok_or("it is damaged: a block is too short")?;
                at += length;
                if let Some(k) = place[c] {
                    to_floats(bytes, channel.sample_type, &mut floats);
                    line(k, [x, y + row], &floats);
                }
            }
        }
    }
    if missing > 0 { Err(format!("it is damaged: {missing} of its texels are not there")) } else { Ok(()) }
}

/// Refuses a block compressed with DWA that announces more than it can unpack to: the crate takes its word and asks for the memory.
fn check_dwa(header: &Header, block: &CompressedBlock) -> Result<(), String> {
    let (Compression::DWAA(_) | Compression::DWAB(_)) = header.compression else { return Ok(()) };
    let data = match block {
        CompressedBlock::ScanLine(b) => &b.compressed_pixels_le,
        CompressedBlock::Tile(b) => &b.compressed_pixels_le,
        _ => return Ok(()),
    };
    let place = header.get_block_data_indices(block).and_then(|i| header.get_absolute_block_pixel_coordinates(i));
    let Vec2(w, h) = place.map_err(|e| explain(&e))?.size;
    // What would not get smaller is stored as it is.
    if data.len() == w * h * header.channels.bytes_per_pixel {
        return Ok(());
    }
    // Whole blocks of 8 x 8, and what runs of bytes may add.
    let most = 2 * (w + 8) * (h + 8) * header.channels.bytes_per_pixel + 1024;
    // Eleven numbers stand first: version, then sizes and counts (OpenEXR, `internal_dwa_compressor.h`), counts of two bytes each.
    let number = |i: usize| data.get(8 * i..).and_then(|d| d.first_chunk()).map_or(0, |b| u64::from_le_bytes(*b));
    let sizes = [number(1), number(6), number(7), number(8).saturating_mul(2), number(9).saturating_mul(2)];
    if sizes.iter().any(|size| *size > most as u64) {
        return Err("it is damaged: a block announces more than it can hold".into());
    }
    Ok(())
}

/// The numbers of a line, in the byte order of the machine.
fn to_floats(bytes: &[u8], kind: SampleType, floats: &mut Vec<f32>) {
    floats.clear();
    match kind {
        SampleType::F16 => floats.extend(bytes.as_chunks().0.iter().map(|b| f16::from_ne_bytes(*b).to_f32())),
        SampleType::F32 => floats.extend(bytes.as_chunks().0.iter().map(|b| f32::from_ne_bytes(*b))),
        SampleType::U32 => floats.extend(bytes.as_chunks().0.iter().map(|b| u32::from_ne_bytes(*b) as f32)),
    }
}

/// Where the data begin in the display window.
fn offset(data: IntegerBounds, display: IntegerBounds) -> [i64; 2] {
    let (d, w) = (data.position, display.position);
    [i64::from(d.0) - i64::from(w.0), i64::from(d.1) - i64::from(w.1)]
}

pub(super) fn primaries(c: Chromaticities) -> Primaries {
    Primaries([c.red, c.green, c.blue, c.white].map(|v| DVec2::new(f64::from(v.0), f64::from(v.1))))
}

/// Shares of red, green and blue in Y. Without an attribute those of Rec. 709.
pub(super) fn luminance_weights(chromaticities: Option<Chromaticities>) -> Vec3 {
    chromaticities
        .and_then(|c| super::primaries::luminance_weights(primaries(c)))
        .unwrap_or(DVec3::from_array(LUMINANCE).as_vec3())
}

/// Red, green and blue of Y, RY = (R - Y) / Y and BY = (B - Y) / Y (OpenEXR, "Luminance/Chroma Images").
pub(super) fn rgb_of_chroma([y, ry, by]: [f32; 3], weights: Vec3) -> [f32; 3] {
    let (r, b) = ((ry + 1.0) * y, (by + 1.0) * y);
    [r, (y - r * weights.x - b * weights.z) / weights.y, b]
}
