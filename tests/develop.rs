//! `bhs develop`: what it writes is what `render` writes, and what the screen is meant to show.

use crate::common::program::Folder;
use bhs::image::{Frame, Picture};
use std::io::Cursor;

/// A picture with dark, bright and saturated places, lit by a lamp, a spectral line and a sky.
const SCENE: &str = r#"
Film "rgb" "integer xresolution" 48 "integer yresolution" 32 "string filename" "scene.exr"
Sampler "sobol" "integer pixelsamples" 4
LookAt 0 1 -6  0 0.5 0  0 1 0
Camera "perspective" "float fov" 45
WorldBegin
LightSource "infinite" "blackbody L" 3500 "float scale" 0.05
AttributeBegin
  Translate -1.6 0.8 0
  AreaLightSource "diffuse" "spectrum L" [519 0  520 60  521 0]
  Shape "sphere" "float radius" 0.6
AttributeEnd
AttributeBegin
  Translate 0 0.8 0
  AreaLightSource "diffuse" "rgb L" [9 5 1]
  Shape "sphere" "float radius" 0.5
AttributeEnd
Translate 1.6 0.8 0
Shape "sphere" "float radius" 0.7
"#;

/// The folder with the scene, rendered with these flags and a few layers as `NAME.exr`.
fn rendered(folder: &Folder, name: &str, flags: &[&str]) {
    let run = folder.run(
        &[&["render", "scene.bhs", "--quiet", "--aov", "depth", "--aov", "normal", "--aov", "winding", "-o", name], flags]
            .concat(),
    );
    assert_eq!(run.code, 0, "{}", run.err);
}

fn developed(folder: &Folder, from: &str, to: &str, flags: &[&str]) -> String {
    let run = folder.run(&[&["develop", from, "-o", to], flags].concat());
    assert_eq!(run.code, 0, "{flags:?}: {}", run.err);
    run.err
}

fn bytes(folder: &Folder, name: &str) -> Vec<u8> {
    std::fs::read(folder.at(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// What a PNG file holds: 16-bit numbers, and its chunks by name and content.
fn png(bytes: &[u8]) -> (Vec<u16>, Vec<(String, Vec<u8>)>) {
    let colors = image::load_from_memory(bytes).expect("a PNG file").into_rgb16();
    let (mut chunks, mut rest) = (Vec::new(), &bytes[8..]);
    while let Some((length, more)) = rest.split_first_chunk::<4>() {
        let length = u32::from_be_bytes(*length) as usize;
        chunks.push((String::from_utf8_lossy(&more[..4]).into_owned(), more[4..][..length].to_vec()));
        rest = &more[length + 8..];
    }
    (colors.into_raw(), chunks)
}

/// The texts of a PNG file, by keyword.
fn texts(bytes: &[u8]) -> Vec<(String, String)> {
    let text = |content: &[u8]| {
        let end = content.iter().position(|b| *b == 0).expect("a keyword");
        [&content[..end], &content[end + 1..]].map(|part| String::from_utf8_lossy(part).into_owned())
    };
    let of = |(name, content): (String, Vec<u8>)| (name == "tEXt").then(|| text(&content)).map(|[k, v]| (k, v));
    png(bytes).1.into_iter().filter_map(of).collect()
}

/// The same flags give the same bytes; and none give those that the picture was rendered with.
#[test]
fn developing_is_what_rendering_does() {
    let folder = Folder::new(SCENE);
    rendered(&folder, "plain.exr", &[]);
    for flags in [
        &[][..],
        &["--exposure", "-2"],
        &["--exposure=1.5", "--tonecurve", "agx"],
        &["--exposure", "auto", "--tonecurve", "aces", "--white", "auto"],
        &["--white", "3200", "--tonecurve", "reinhard", "--bits", "16"],
        &["--bloom", "1.5", "--bits", "16", "--exposure", "1"],
        &["--layer", "depth", "--exposure", "-3"],
        &["--layer", "normal", "--false-color"],
    ] {
        rendered(&folder, "flags.exr", flags);
        developed(&folder, "plain.exr", "developed.png", flags);
        assert!(bytes(&folder, "flags.png") == bytes(&folder, "developed.png"), "{flags:?}");
        if !flags.contains(&"--layer") {
            developed(&folder, "flags.exr", "again.png", &[]);
            assert!(bytes(&folder, "flags.png") == bytes(&folder, "again.png"), "{flags:?}, from the header");
        }
        let picture = |name: &str| Picture::read_exr(&folder.at(name)).expect("a picture");
        assert!(picture("plain.exr").same_channels(&picture("flags.exr")), "{flags:?} change the EXR file");
    }
    // With all layers besides.
    rendered(&folder, "layers.exr", &["--false-color"]);
    developed(&folder, "plain.exr", "again.png", &["--false-color"]);
    for name in ["depth", "normal", "winding"] {
        let (one, other) = (bytes(&folder, &format!("layers.{name}.png")), bytes(&folder, &format!("again.{name}.png")));
        assert!(one == other, "{name}");
        assert!(texts(&one).iter().any(|(keyword, text)| keyword == "Description" && text.starts_with(name)));
    }
    assert!(bytes(&folder, "again.png") == bytes(&folder, "layers.png"));
}

/// Every layer and every channel, as light and in false colours; and channels that stand in another order in the file than in the film.
#[test]
fn developing_a_layer_is_what_rendering_it_does() {
    let hole = "BlackHole \"schwarzschild\" \"point3 center\" [0 2 1] \"float rs\" 0.2\n";
    let scene = SCENE.replace("WorldBegin\n", &format!("WorldBegin\n{hole}"));
    let folder = Folder::new(&scene);
    let all: Vec<&str> = bhs::develop::channels::known().into_iter().map(|(name, _)| name).collect();
    let aov: Vec<&str> = all.iter().flat_map(|name| ["--aov", name]).collect();
    assert!(all.len() > 15, "{all:?}");
    let same = |layer: &str| {
        for flags in [&["--layer", layer, "--exposure", "auto"][..], &["--layer", layer, "--false-color"]] {
            let before = folder.files();
            let run = folder.run(&[&["render", "scene.bhs", "--quiet", "-o", "flags.exr"], &aov[..], flags].concat());
            assert_eq!(run.code, 0, "{flags:?}: {}", run.err);
            let others: Vec<_> = folder.files().into_iter().filter(|name| !before.contains(name)).collect();
            assert!(others.iter().all(|name| name == "flags.exr" || name == "flags.png"), "{flags:?}: {others:?}");
            developed(&folder, "plain.exr", "developed.png", flags);
            assert!(bytes(&folder, "flags.png") == bytes(&folder, "developed.png"), "{flags:?}");
        }
    };
    let plain = || {
        let run = folder.run(&[&["render", "scene.bhs", "--quiet", "-o", "plain.exr"], &aov[..]].concat());
        assert_eq!(run.code, 0, "{}", run.err);
    };
    plain();
    all.iter().copied().chain(["R", "N.X", "N", "Variance"]).for_each(same);
    // Two numbers, of which the file has the second one first, and three.
    for (buckets, channel) in [(2, "S0.1025,000nm"), (3, "S0.850,000nm")] {
        let spectral = format!("\"spectral\" \"integer nbuckets\" {buckets} \"float lambdamin\" 800 \"float lambdamax\" 1100");
        folder.write("scene.bhs", scene.replace("\"rgb\" \"integer x", &format!("{spectral} \"integer x")));
        plain();
        ["S0", channel, "depth"].into_iter().for_each(same);
        let (shown, _) = png(&bytes(&folder, "flags.png"));
        assert!(shown.iter().any(|v| *v > 0), "nothing is seen");
    }
    // A channel of the picture needs no layer.
    let run = folder.run(&["render", "scene.bhs", "--quiet", "--layer", "R", "--false-color", "-o", "red.exr"]);
    assert_eq!(run.code, 0, "{}", run.err);
    developed(&folder, "red.exr", "developed.png", &["--layer", "R", "--false-color"]);
    assert!(bytes(&folder, "red.png") == bytes(&folder, "developed.png"));
}

/// EXR files have one byte a character, PNG files have all of Unicode.
#[test]
fn cameras_have_names_in_any_language() {
    for name in ["left", "\u{e9}t\u{e9}", "\u{41a}\u{430}\u{43c}\u{435}\u{440}\u{430} \u{1f600} \u{f6}", r"u{41}"] {
        let folder = Folder::new(&SCENE.replace("\"perspective\"", &format!("\"perspective\" \"string name\" \"{name}\"")));
        let run = folder.run(&["render", "scene.bhs", "--quiet", "--spp", "1", "-o", "a.exr"]);
        assert_eq!(run.code, 0, "{}", run.err);
        developed(&folder, "a.exr", "b.png", &[]);
        assert!(bytes(&folder, "a.png") == bytes(&folder, "b.png"), "{name}");
        let (_, chunks) = png(&bytes(&folder, "a.png"));
        let said = chunks.iter().any(|(kind, content)| {
            let text = String::from_utf8_lossy(content);
            matches!(kind.as_str(), "tEXt" | "iTXt") && text.starts_with("camera\0") && text.ends_with(&format!("\0{name}"))
        });
        assert!(said, "{name}: {chunks:?}");
    }
}

/// A picture by another program, as bhs would not write it.
fn write(folder: &Folder, name: &str, channels: &[&str], pixels: &[&[f32]]) {
    let size = [pixels.len(), 1];
    let channels = channels.iter().map(|c| (*c).to_owned()).collect();
    let picture = Picture { size, frame: Frame { offset: [0, 0], size }, channels, data: pixels.concat() };
    let mut bytes = Cursor::new(Vec::new());
    picture.write_exr(&mut bytes, &[]).expect("in memory");
    folder.write(name, bytes.into_inner());
}

#[test]
fn clip_is_srgb_of_the_numbers() {
    let folder = Folder::new(SCENE);
    let pixels: Vec<[f32; 3]> =
        (0..64).map(|i| [i as f32 / 64.0, (63 - i) as f32 / 200.0, [0.0, 0.18, 0.5, 3.0][i % 4]]).collect();
    let grey: Vec<[f32; 3]> = (0..64).map(|i| [i as f32 / 32.0; 3]).collect();
    write(&folder, "in.exr", &["R", "G", "B"], &pixels.iter().chain(&grey).map(|p| &p[..]).collect::<Vec<_>>());
    for stops in [-2.0f64, 0.0, 0.75] {
        developed(&folder, "in.exr", "out.png", &["--exposure", &stops.to_string(), "--bits", "16"]);
        developed(&folder, "in.exr", "white.png", &["--exposure", &stops.to_string(), "--bits", "16", "--white", "6504"]);
        assert!(bytes(&folder, "out.png") == bytes(&folder, "white.png"), "6504 K changes something");
        let (shown, chunks) = png(&bytes(&folder, "out.png"));
        for (shown, linear) in shown.iter().zip(pixels.iter().chain(&grey).flatten()) {
            let x = (f64::from(*linear) * stops.exp2()).clamp(0.0, 1.0);
            let encoded = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
            assert!((f64::from(*shown) - 65_535.0 * encoded).abs() < 1.5, "{stops} {linear}: {shown} {encoded}");
        }
        assert!(chunks.iter().any(|(name, content)| name == "sRGB" && content.len() == 1), "{chunks:?}");
    }
}

#[test]
fn pngs_say_what_they_are() {
    let folder = Folder::new(SCENE);
    rendered(&folder, "a.exr", &["--seed", "9007199254740993", "--exposure", "auto", "--white", "auto"]);
    let said = texts(&bytes(&folder, "a.png"));
    let get = |keyword: &str| said.iter().find(|(k, _)| k == keyword).map(|(_, text)| text.as_str()).unwrap_or_default();
    assert_eq!((get("seed"), get("spp"), get("tonecurve"), get("white")), ("9007199254740993", "4", "clip", "auto"));
    assert!(get("Software").starts_with("bhs ") && get("exposure").ends_with(" stops"), "{said:?}");
    let folder_name = folder.at("").to_string_lossy().into_owned();
    assert!(said.iter().all(|(_, text)| !text.contains(folder_name.trim_end_matches('/'))), "{said:?}");
}

/// Of light that no screen shows, and that is brighter than any number of it.
#[test]
fn bright_light_of_one_wavelength_is_not_black() {
    let folder = Folder::new(SCENE);
    let laser = [-0.3f32, 0.6, -0.05];
    let pixels = [1.0, 1e8, 1e37].map(|unit| laser.map(|v| v * unit));
    write(&folder, "in.exr", &["R", "G", "B"], &pixels.iter().map(|p| &p[..]).collect::<Vec<_>>());
    for flags in [&["--exposure", "0"][..], &["--exposure", "40"], &["--exposure", "40", "--white", "5000"]] {
        for curve in ["clip", "reinhard", "aces", "agx"] {
            developed(&folder, "in.exr", "out.png", &[flags, &["--tonecurve", curve]].concat());
            let (shown, _) = png(&bytes(&folder, "out.png"));
            let [dim, bright @ ..] = [shown[1], shown[4], shown[7]];
            assert!(bright.iter().all(|g| *g >= dim && *g > 40_000), "{flags:?} {curve}: {shown:?}");
        }
    }
}

/// Colours out of the gamut keep hue and lightness: a laser is not what is left when its negative red is cut off.
#[test]
fn lasers_are_mapped() {
    let folder = Folder::new(SCENE);
    write(&folder, "in.exr", &["R", "G", "B"], &[&[-0.3, 0.6, -0.05], &[0.5, 0.5, 0.5], &[-1.0, -1.0, -1.0]]);
    developed(&folder, "in.exr", "out.png", &["--bits", "16"]);
    let (shown, _) = png(&bytes(&folder, "out.png"));
    assert!(shown[0] < 40 && shown[1] > 40_000 && shown[1] < 51_000 && shown[2] > 10_000, "{:?}", &shown[..3]);
    assert!(shown[3] == shown[4] && shown[4] == shown[5] && shown[6..9] == [0, 0, 0], "{shown:?}");
}

#[test]
fn pictures_of_other_programs_are_read_and_what_is_odd_is_told() {
    let folder = Folder::new(SCENE);
    write(
        &folder,
        "odd.exr",
        &["R", "G", "B", "Diffuse.R", "Diffuse.G", "Diffuse.B", "mist"],
        &[&[f32::NAN, 0.2, 0.2, 0.1, 0.2, 0.3, 0.5], &[f32::INFINITY, 0.2, 0.2, 0.4, 0.5, 0.6, 0.25]],
    );
    let said = developed(&folder, "odd.exr", "out.png", &[]);
    assert!(said.contains("note:") && said.contains("not numbers") && said.contains("infinite"), "{said}");
    assert_eq!(png(&bytes(&folder, "out.png")).0[..4].iter().map(|v| v / 257).collect::<Vec<_>>(), [0, 124, 124, 255]);
    let layer = |flags: &[&str]| {
        developed(&folder, "odd.exr", "layer.png", flags);
        png(&bytes(&folder, "layer.png")).0.iter().map(|v| v / 257).collect::<Vec<_>>()
    };
    assert_eq!(layer(&["--layer", "Diffuse"])[..3], [89, 124, 149]);
    assert_eq!(layer(&["--layer", "mist", "--exposure", "1"]), [255, 255, 255, 188, 188, 188]);
    assert_eq!(layer(&["--layer", "mist", "--false-color"]), [0xfd, 0xe7, 0x25, 0x44, 0x01, 0x54]);
    let said = folder.run(&["develop", "odd.exr", "-o", "x.png", "--layer", "dephts"]);
    assert!(said.code == 1 && said.err.contains("Diffuse, mist"), "{}", said.err);
}

#[test]
fn what_cannot_be_developed_is_refused_and_nothing_is_harmed() {
    let folder = Folder::new(SCENE);
    rendered(&folder, "a.exr", &[]);
    folder.write("text.exr", "no picture");
    std::fs::copy(folder.at("a.png"), folder.at("png.exr")).expect("copied");
    std::fs::hard_link(folder.at("a.exr"), folder.at("hard.png")).expect("linked");
    #[cfg(unix)]
    std::os::unix::fs::symlink("a.exr", folder.at("soft.png")).expect("linked");
    let mut cases = vec![
        (vec!["missing.exr", "-o", "x.png"], 1, "missing.exr"),
        (vec!["text.exr", "-o", "x.png"], 1, "does not begin as one"),
        (vec!["png.exr", "-o", "x.png"], 1, "PNG"),
        (vec!["scene.bhs", "-o", "x.png"], 1, "cannot read"),
        (vec!["a.exr", "-o", "a.exr"], 1, "ends in .png"),
        (vec!["a.exr", "-o", "hard.png"], 1, "the picture that is developed"),
        (vec!["a.exr", "-o", "nowhere/x.png"], 1, "nowhere"),
        (vec!["a.exr", "-o", "x.png", "--layer", "depht"], 1, "did you mean `depth`?"),
        (vec!["a.exr", "-o", "x.png", "--exposure", "bright"], 2, "-1.5, or `auto`"),
        (vec!["a.exr", "-o", "x.png", "--tonecurve", "filmic"], 2, "agx"),
        (vec!["a.exr", "-o", "x.png", "--white", "20"], 2, "3200"),
        (vec!["a.exr", "-o", "x.png", "--bits", "12"], 2, "8 or 16"),
        (vec!["a.exr"], 2, "--output"),
    ];
    if cfg!(unix) {
        cases.push((vec!["a.exr", "-o", "soft.png"], 1, "the picture that is developed"));
    }
    let before = folder.contents();
    for (args, code, words) in cases {
        let run = folder.run(&[&["develop"], &args[..]].concat());
        assert!(run.code == code && run.err.contains(words), "{args:?}: {} {}", run.code, run.err);
        assert!(folder.contents() == before, "{args:?} changed files");
    }
    let run = folder.run(&["render", "scene.bhs", "--layer", "depht"]);
    assert!(run.code == 2 && run.err.contains("depht"), "{}", run.err);
    assert!(folder.contents() == before);
}

#[test]
fn differences_are_numbers_and_pictures() {
    let folder = Folder::new(SCENE);
    rendered(&folder, "a.exr", &["--spp", "1"]);
    rendered(&folder, "b.exr", &[]);
    let run = folder.run(&["compare", "a.exr", "b.exr", "--diff", "diff.png", "--json"]);
    assert_eq!(run.code, 0, "{}", run.err);
    let flip = |out: &str| serde_json::from_str::<serde_json::Value>(out).expect("JSON")["flip"].as_f64().expect("a number");
    let mean = flip(&run.out);
    assert!(mean > 0.01 && mean < 1.0, "{mean}");
    for name in ["diff.png", "diff.relative.png"] {
        let shown = image::load_from_memory(&folder.read(name)).expect("a PNG file").into_rgb8();
        assert_eq!(shown.dimensions(), (48, 32));
        assert!(shown.pixels().any(|p| p.0 != [0, 0, 4]), "{name} is black");
        assert!(texts(&folder.read(name)).iter().any(|(_, text)| text.contains("of a.exr against b.exr")), "{name}");
    }
    let same = folder.run(&["compare", "b.exr", "b.exr", "--json"]);
    assert_eq!(flip(&same.out), 0.0, "{}", same.out);
    // FLIP takes time, and is left out of what does not ask for it.
    let plain = folder.run(&["compare", "a.exr", "b.exr"]);
    assert!(plain.code == 0 && plain.out.contains("relative MSE") && !plain.out.contains("FLIP"), "{}", plain.out);
    // What the pictures cannot be compared for is found out after whether the result can be written.
    let missing = folder.run(&["compare", "missing.exr", "b.exr", "--diff", "a.exr"]);
    assert!(missing.code == 1 && missing.err.contains("missing.exr"), "{}", missing.err);
    folder.write("text.exr", "no picture");
    let text = folder.run(&["compare", "text.exr", "b.exr", "--diff", "a.exr"]);
    assert!(text.code == 1 && text.err.contains("ends in .png"), "{}", text.err);
    // Nothing is written in place of what is compared.
    std::fs::hard_link(folder.at("a.exr"), folder.at("hard.png")).expect("linked");
    std::fs::hard_link(folder.at("b.exr"), folder.at("c.relative.png")).expect("linked");
    let before = folder.contents();
    for (out, words) in
        [("hard.png", "a picture that is compared"), ("c.png", "a picture that is compared"), ("a.exr", "ends in .png")]
    {
        let run = folder.run(&["compare", "a.exr", "b.exr", "--diff", out]);
        assert!(run.code == 1 && run.err.contains(words) && folder.contents() == before, "{out}: {}", run.err);
    }
}
