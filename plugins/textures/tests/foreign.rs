//! Pictures as other programs write them: `data/make.py` makes them with OpenEXR's and Pillow's libraries. Radiance files are written here.

use bhs_core::image::{Image, Texels};
use bhs_textures::decode::{decode, exr};

fn file(name: &str) -> Vec<u8> {
    let path = format!("{}/tests/data/{name}", env!("CARGO_MANIFEST_DIR"));
    std::fs::read(&path).unwrap_or_else(|e| panic!("{path}: {e}"))
}

fn read(name: &str) -> Image {
    decode(&file(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

fn error(name: &str) -> String {
    decode(&file(name)).expect_err(name)
}

/// A texel in light, or in parts of the largest byte or word.
fn texel(image: &Image, x: usize, y: usize) -> [f32; 3] {
    let i = y * image.width as usize + x;
    match &image.texels {
        Texels::Bytes(t) => t[i].map(|v| f32::from(v) / 255.0),
        Texels::Words(t) => t[i].map(|v| f32::from(v) / 65535.0),
        Texels::Floats(t) => t[i],
    }
}

/// The picture in all files: red grows to the right, green downwards, blue is 1/4.
fn ramp(x: usize, y: usize) -> [f32; 3] {
    [x as f32 / 8.0, y as f32 / 4.0, 0.25]
}

/// Whether a picture is `wanted`, a function of column and row.
fn check(name: &str, image: &Image, size: [u32; 2], tolerance: f32, wanted: impl Fn(usize, usize) -> [f32; 3]) {
    assert_eq!([image.width, image.height], size, "{name}");
    for (x, y) in (0..size[0] as usize).flat_map(|x| (0..size[1] as usize).map(move |y| (x, y))) {
        let (found, wanted) = (texel(image, x, y), wanted(x, y));
        let off = found.iter().zip(wanted).map(|(a, b)| (a - b).abs());
        assert!(off.fold(0.0, f32::max) <= tolerance, "{name} at ({x}, {y}): {found:?}, not {wanted:?}");
    }
}

#[test]
fn the_picture_of_an_exr_file_is_found() {
    for name in ["layers.exr", "passes.exr", "parts.exr", "half.exr", "tiled.exr"] {
        let image = read(name);
        check(name, &image, [8, 4], 0.0, ramp);
        assert!(image.notes.is_empty(), "{name}: {:?}", image.notes);
    }
    check("uint.exr", &read("uint.exr"), [8, 4], 0.0, |x, y| [x as f32, 2.0 * y as f32, 2.0]);
    let image = read("ambiguous.exr");
    check("ambiguous.exr", &image, [8, 4], 0.0, ramp);
    assert!(
        image.notes[0].starts_with("it holds several layers, of which `Diffuse` is read (Diffuse, Specular);"),
        "{:?}",
        image.notes
    );
    check("grey.exr", &read("grey.exr"), [8, 4], 0.0, |x, _| [x as f32 / 8.0; 3]);
    let image = read("depth.exr");
    check("depth.exr", &image, [8, 4], 0.0, |x, _| [x as f32 / 8.0; 3]);
    assert_eq!(image.notes, ["its only channel, `Z`, is read as grey"]);
    check("chroma.exr", &read("chroma.exr"), [8, 4], 1e-6, |_, _| [0.5; 3]);
}

#[test]
fn all_compressions_but_one_are_read() {
    check("no", &read("compression_no.exr"), [8, 4], 0.0, ramp);
    for (name, tolerance) in [
        ("rle", 0.0),
        ("zips", 0.0),
        ("zip", 0.0),
        ("piz", 0.0),
        ("pxr24", 0.0),
        ("b44", 0.01),
        ("b44a", 0.01),
        ("dwaa", 0.02),
        ("dwab", 0.02),
    ] {
        check(name, &read(&format!("compression_{name}.exr")), [64, 32], tolerance, |x, y| ramp(x / 8, y / 8));
    }
    let wanted = "its compression (HTJ2K, or newer than that) is not read: save it with ZIP, PIZ or DWAA";
    assert_eq!(error("compression_htj2k32.exr"), wanted);
}

#[test]
fn primaries_become_srgb() {
    // (0.5, 0.2, 0.1) by hand: ITU-R BT.2087 for Rec. 2020; the matrix of ACEScg to sRGB with Bradford's adaptation.
    for (name, wanted) in [("rec2020.exr", [0.7054, 0.1635, 0.0826]), ("acescg.exr", [0.7198, 0.1620, 0.0775])] {
        let image = read(name);
        check(name, &image, [8, 4], 5e-4, |_, _| wanted);
        assert!(image.notes.is_empty(), "{name}");
    }
}

#[test]
fn the_display_window_is_the_picture() {
    let image = read("cropped.exr");
    check("cropped.exr", &image, [16, 8], 0.0, |x, y| if x >= 8 && y >= 4 { ramp(x - 8, y - 4) } else { [0.0; 3] });
    assert_eq!(image.notes, ["its data, 8 x 4 at (8, 4), fill a part of its 16 x 8 only: the rest is black"]);
    let image = read("overscan.exr");
    check("overscan.exr", &image, [4, 2], 0.0, |x, y| ramp(x + 2, y + 1));
    assert!(image.notes.is_empty(), "{:?}", image.notes);
    assert_eq!(error("outside.exr"), "its data window lies outside of its display window: nothing of it is seen");
}

#[test]
fn numbers_that_are_none_are_told() {
    let image = read("odd.exr");
    check("odd.exr", &image, [8, 4], 0.0, |x, y| {
        [if x == 4 { 65504.0 } else { x as f32 / 8.0 }, if y == 2 { 0.0 } else { y as f32 / 4.0 }, -0.25]
    });
    let wanted = ["8 of its values are not numbers and count as 0", "4 of its values are infinite and count as 65504"];
    assert_eq!(image.notes, wanted);
}

#[test]
fn what_an_exr_file_does_not_hold_is_told() {
    assert_eq!(error("alpha_z.exr"), "it has no channels R, G and B, and no Y, but A, Z");
    assert_eq!(error("deep.exr"), "it holds deep data, which are not read: save it flat");
    // Luminance and chroma with a quarter of the samples: the number of columns a sample stands behind a channel's type and flags.
    let mut subsampled = file("chroma.exr");
    for name in [&b"BY\0"[..], b"RY\0"] {
        let at = subsampled.windows(3).position(|w| w == name).expect("the channel") + 3 + 8;
        subsampled[at..at + 8].copy_from_slice([2u32, 2].map(u32::to_le_bytes).as_flattened());
    }
    let said = decode(&subsampled).expect_err("subsampled");
    assert!(
        said.starts_with("channels of it are subsampled, as with luminance and chroma (Y, RY, BY): save it as R, G and B"),
        "{said}"
    );
}

#[test]
fn all_channels_are_read_as_they_are() {
    let all = exr::read_all(&file("layers.exr")).expect("it is read");
    assert_eq!((all.size, all.offset, all.frame), ([8, 4], [0, 0], [8, 4]));
    assert_eq!(all.names, ["Albedo.B", "Albedo.G", "Albedo.R", "B", "G", "R"]);
    assert_eq!(all.values[(8 + 3) * 6..][..6], [0.9, 0.9, 0.9, 0.25, 0.25, 0.375]);
    let all = exr::read_all(&file("parts.exr")).expect("it is read");
    assert_eq!(all.names, ["B", "G", "R"]);
    let all = exr::read_all(&file("alpha_z.exr")).expect("it is read");
    assert_eq!(all.names, ["A", "Z"]);
    let all = exr::read_all(&file("cropped.exr")).expect("it is read");
    assert_eq!((all.size, all.offset, all.frame), ([8, 4], [8, 4], [16, 8]));
    // A number that is none stays one: a comparison must see it.
    assert!(exr::read_all(&file("odd.exr")).expect("it is read").values.iter().any(|v| v.is_nan()));
}

#[test]
fn damaged_exr_files_ask_for_no_more_than_they_justify() {
    let whole = file("layers.exr");
    let window = b"dataWindow\0box2i\0";
    let at = whole.windows(window.len()).position(|w| w == window).expect("it has one") + window.len() + 4;
    for size in [20_000, 60_000, 2_000_000_000] {
        let mut damaged = whole.clone();
        damaged[at..at + 16].copy_from_slice([0i32, 0, size, size].map(i32::to_le_bytes).as_flattened());
        for said in [decode(&damaged).map(|_| ()), exr::read_all(&damaged).map(|_| ())] {
            let said = said.expect_err("too large");
            assert!(said.contains("damaged") || said.contains("too large"), "{said}");
        }
    }
    let window = b"displayWindow\0box2i\0";
    let at = whole.windows(window.len()).position(|w| w == window).expect("it has one") + window.len() + 4;
    let mut damaged = whole.clone();
    damaged[at..at + 16].copy_from_slice([0i32, 0, 9_999, 9_999].map(i32::to_le_bytes).as_flattened());
    let said = decode(&damaged).expect_err("too large");
    assert_eq!(said, "its display window, 10000 x 10000, is too large for the 8 x 4 texels that it holds");
    for end in 0..whole.len() {
        assert!(decode(&whole[..end]).is_err() && exr::read_all(&whole[..end]).is_err(), "{end}");
    }
}

/// A Radiance file of the ramp: its first lines, the line of its size, and the texels in the order in which they are stored.
fn radiance(header: &str, size: &str, places: impl Iterator<Item = (usize, usize)>) -> Vec<u8> {
    let mut bytes = format!("{header}\n{size}\n").into_bytes();
    for (x, y) in places {
        // Exponent 128: a mantissa of 128 is 1/2.
        bytes.extend(ramp(x, y).map(|v| (v * 256.0) as u8).into_iter().chain([128]));
    }
    bytes
}

fn rows() -> impl Iterator<Item = (usize, usize)> {
    (0..4).flat_map(|y| (0..8).map(move |x| (x, y)))
}

#[test]
fn radiance_files_are_read_in_every_order() {
    let header = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n";
    let across = |mirrored: bool, x: usize| if mirrored { 7 - x } else { x };
    let down = |mirrored: bool, y: usize| if mirrored { 3 - y } else { y };
    for (left, up) in [(false, false), (true, false), (false, true), (true, true)] {
        let (x_axis, y_axis) = (if left { "-X" } else { "+X" }, if up { "+Y" } else { "-Y" });
        let by_rows = radiance(header, &format!("{y_axis} 4 {x_axis} 8"), rows().map(|(x, y)| (across(left, x), down(up, y))));
        let columns = (0..8).flat_map(|x| (0..4).map(move |y| (x, y)));
        let by_columns =
            radiance(header, &format!("{x_axis} 8 {y_axis} 4"), columns.map(|(x, y)| (across(left, x), down(up, y))));
        for bytes in [by_rows, by_columns] {
            check("hdr", &decode(&bytes).expect("it is read"), [8, 4], 0.0, ramp);
        }
    }
}

#[test]
fn radiance_headers_say_what_numbers_mean() {
    let srgb = |scale: f32| move |x: usize, y: usize| ramp(x, y).map(|v| v * scale);
    let table: &[(&str, f32, &str)] = &[
        ("#?RADIANCE\n", 1.0, ""),
        ("#?RGBE\nFORMAT=32-bit_rle_rgbe\n", 1.0, ""),
        ("#?AUTOPANO\n# Made by hand\nFORMAT=32-bit_rle_rgbe\n", 1.0, ""),
        ("#?RADIANCE\r\nFORMAT=32-bit_rle_rgbe\r\n", 1.0, ""),
        ("#?RADIANCE\nEXPOSURE=4\nFORMAT=32-bit_rle_rgbe\n", 0.25, ""),
        ("#?RADIANCE\nEXPOSURE=4\nEXPOSURE= 5.000000e-01\n", 0.5, ""),
        ("#?RADIANCE\nCOLORCORR= 2 2 2\nCOLORCORR=0.5 0.5 0.5\nEXPOSURE=2\n", 0.5, ""),
        ("#?RADIANCE\nEXPOSURE=0\n", 1.0, "its line `EXPOSURE=0` means nothing and is left out"),
        ("#?RADIANCE\nGAMMA=1\nPIXASPECT=1\nVIEW= -vtv -vh 45\n", 1.0, ""),
        ("#?RADIANCE\nGAMMA=2.2\n", 1.0, "its line `GAMMA=2.2` is not taken into account: numbers count as linear"),
        ("#?RADIANCE\nPRIMARIES= 0.64 0.33 0.30 0.60 0.15 0.06 0.3127 0.3290\n", 1.0, ""),
    ];
    for (header, scale, note) in table {
        let image = decode(&radiance(header, "-Y 4 +X 8", rows())).unwrap_or_else(|e| panic!("{header}: {e}"));
        check(header, &image, [8, 4], 1e-6, srgb(*scale));
        assert_eq!(image.notes.concat(), *note, "{header}");
    }
    // Rec. 2020, as in the EXR file; and CIE XYZ, in which (1, 1, 1) is white.
    let one = |header: &str, rgbe: [u8; 4]| {
        let bytes = [format!("{header}\n-Y 1 +X 1\n").as_bytes(), &rgbe].concat();
        texel(&decode(&bytes).unwrap_or_else(|e| panic!("{header}: {e}")), 0, 0)
    };
    let found = one("#?RADIANCE\nPRIMARIES=0.708 0.292 0.170 0.797 0.131 0.046 0.3127 0.329\n", [128, 51, 26, 128]);
    assert!(found.iter().zip([0.7054, 0.1635, 0.0826]).all(|(a, b)| (a - b).abs() < 2e-3), "{found:?}");
    let found = one("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n", [64; 4].map(|v| if v == 64 { 64 } else { v }));
    let grey = 64.0 * 2f32.powi(64 - 136);
    assert!(found.iter().all(|v| (v / grey - 1.0).abs() < 1e-5), "{found:?}");
    let found = one("#?RADIANCE\nEXPOSURE=5.586592e-03\nFORMAT=32-bit_rle_xyze\n", [128, 128, 128, 128]);
    assert!(found.iter().all(|v| (v / 0.5 - 1.0).abs() < 1e-5), "{found:?}");
}

#[test]
fn radiance_runs_of_both_kinds_are_read() {
    let header = b"#?RADIANCE\n\n-Y 1 +X 9\n";
    // New: a run of 8 and a single one in red, singles in green, runs in blue and of exponents.
    let new = [2, 2, 0, 9, 136, 128, 1, 64, 9, 1, 2, 3, 4, 5, 6, 7, 8, 9, 137, 32, 137, 128];
    let image = decode(&[&header[..], &new].concat()).expect("it is read");
    for x in 0..9 {
        let wanted = [if x < 8 { 0.5 } else { 0.25 }, (x + 1) as f32 / 256.0, 0.125];
        assert_eq!(texel(&image, x, 0), wanted, "{x}");
    }
    let image = decode(&[&header[..], &[128, 64, 32, 128, 1, 1, 1, 7, 64, 64, 64, 128]].concat()).expect("it is read");
    assert_eq!((texel(&image, 7, 0), texel(&image, 8, 0)), ([0.5, 0.25, 0.125], [0.25; 3]));
    let image = decode(&[b"#?RADIANCE\n\n-Y 1 +X 257\n".as_slice(), &[128, 64, 32, 128, 1, 1, 1, 0, 1, 1, 1, 1]].concat())
        .expect("it is read");
    assert_eq!(texel(&image, 256, 0), [0.5, 0.25, 0.125]);
}

#[test]
fn faults_of_radiance_files_are_told() {
    let table: &[(&str, &str)] = &[
        (
            "#?RADIANCE\nFORMAT=Radiance_spectra\n\n-Y 1 +X 1\n0000",
            "its FORMAT is `Radiance_spectra`; 32-bit_rle_rgbe and 32-bit_rle_xyze are read",
        ),
        ("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n", "it is no HDR picture: its header has no end (a blank line)"),
        ("#?RADIANCE\n\n-Y 1 +Y 1\n0000", "expected its size, as `-Y 512 +X 1024`, found `-Y 1 +Y 1`"),
        ("#?RADIANCE\n\n-Y 0 +X 1\n0000", "it has no texels"),
        ("#?RADIANCE\n\n-Y 1 +X 2\n0000", "it is damaged: line 1 of 1 is not there in full"),
        ("#?RADIANCE\n\n-Y 2 +X 1\n0000", "it is damaged: 26 bytes cannot hold 1 x 2 texels"),
        ("#?RADIANCE\n\n-Y 1 +X 1\n\u{1}\u{1}\u{1}\u{1}", "it is damaged: line 1 of 1 has a run that is too long"),
        ("#?RADIANCE\n\n-Y 1 +X 9\n\u{2}\u{2}\u{0}\u{8}0000", "it is damaged: line 1 of 1 has another length than the picture"),
    ];
    for (text, wanted) in table {
        assert_eq!(decode(text.as_bytes()).expect_err(text), *wanted);
    }
}

#[test]
fn png_pictures_of_every_kind_are_read() {
    for name in ["plain.png", "palette.png", "alpha.png", "gama_srgb.png", "srgb.png", "icc_srgb.png", "animated.png"] {
        let image = read(name);
        check(name, &image, [8, 4], 0.6 / 255.0, ramp);
        assert_eq!((image.notes.len(), &image.encoding_note), (0, &None), "{name}");
    }
    check("grey16.png", &read("grey16.png"), [8, 4], 1e-4, |x, _| [x as f32 / 8.0; 3]);
    let luma = |x: usize, y: usize| 0.299 * x as f32 / 8.0 + 0.587 * y as f32 / 4.0 + 0.114 * 0.25;
    check("grey.png", &read("grey.png"), [8, 4], 1.5 / 255.0, |x, y| [luma(x, y); 3]);
    let image = read("one_bit.png");
    assert!((0..32).all(|i| [[0.0; 3], [1.0; 3]].contains(&texel(&image, i % 8, i / 8))));
}

/// A chunk of a PNG.
fn chunk(kind: &[u8; 4], data: &[u8]) -> Vec<u8> {
    let named = [kind.as_slice(), data].concat();
    let crc = !named.iter().fold(u32::MAX, |mut c, b| {
        c ^= u32::from(*b);
        (0..8).for_each(|_| c = if c & 1 == 1 { (c >> 1) ^ 0xedb8_8320 } else { c >> 1 });
        c
    });
    [&(data.len() as u32).to_be_bytes(), named.as_slice(), &crc.to_be_bytes()].concat()
}

#[test]
fn interlaced_png_pictures_are_read() {
    // Adam7 of 2 x 2 texels, uncompressed: pass 1 has the first, pass 6 the second of its row, pass 7 the row below.
    let raw = [0u8, 10, 0, 20, 0, 30, 40];
    let (a, b) = raw.iter().fold((1u32, 0u32), |(a, b), v| (a + u32::from(*v), b + a + u32::from(*v)));
    let mut data = vec![0x78, 1, 1, 7, 0, 248, 255];
    data.extend(raw);
    data.extend((b << 16 | a).to_be_bytes());
    let header = chunk(b"IHDR", &[0, 0, 0, 2, 0, 0, 0, 2, 8, 0, 0, 0, 1]);
    let png = [b"\x89PNG\r\n\x1a\n".to_vec(), header, chunk(b"IDAT", &data), chunk(b"IEND", &[])].concat();
    let image = decode(&png).expect("it is read");
    assert_eq!(image.texels, Texels::Bytes(vec![[10; 3], [20; 3], [30; 3], [40; 3]]));
}

#[test]
fn colours_that_are_not_srgb_are_told() {
    let table = [
        ("gama_linear.png", "its chunk gAMA says that numbers are light to the power 1.000, sRGB being near 0.455"),
        ("cicp_p3.png", "its chunk cICP says primaries 12 and curve 13 of ITU-T H.273"),
        ("chrm.png", "its chunk cHRM says primaries that are not those of sRGB"),
        ("icc_p3.png", "it has the colour profile `Display P3`"),
        ("icc_p3.jpg", "it has the colour profile `Display P3`"),
    ];
    for (name, wanted) in table {
        assert_eq!(read(name).encoding_note.as_deref(), Some(wanted), "{name}");
    }
}

#[test]
fn jpeg_pictures_of_every_kind_are_read() {
    let enlarged = |x: usize, y: usize| ramp(x / 4, y / 4);
    for (name, tolerance) in [("plain.jpg", 0.06), ("progressive.jpg", 0.06), ("turned.jpg", 0.06), ("cmyk.jpg", 0.06)] {
        check(name, &read(name), [32, 16], tolerance, enlarged);
    }
    let luma = |[r, g, b]: [f32; 3]| 0.299 * r + 0.587 * g + 0.114 * b;
    check("grey.jpg", &read("grey.jpg"), [32, 16], 0.06, |x, y| [luma(enlarged(x, y)); 3]);
}

#[test]
fn small_files_that_claim_to_be_large_are_refused() {
    // A PNG and a JPEG by their headers.
    let mut png = file("plain.png");
    let mut header = png[16..29].to_vec();
    header[..8].copy_from_slice([16384u32, 16384].map(u32::to_be_bytes).as_flattened());
    png.splice(8..33, chunk(b"IHDR", &header));
    let said = decode(&png).expect_err("too large");
    assert_eq!(said, format!("it is damaged: {} bytes cannot hold 16384 x 16384 texels", png.len()));
    for name in ["plain.jpg", "progressive.jpg"] {
        let mut jpeg = file(name);
        let frame = jpeg.windows(4).position(|w| w[0] == 0xff && [0xc0, 0xc2].contains(&w[1]) && w[2] == 0).expect("a frame");
        jpeg[frame + 5..frame + 9].copy_from_slice([16000u16, 16000].map(u16::to_be_bytes).as_flattened());
        let said = decode(&jpeg).expect_err("too large");
        assert_eq!(said, format!("it is damaged: {} bytes cannot hold 16000 x 16000 texels", jpeg.len()));
    }
}
