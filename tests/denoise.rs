//! Pictures lose their noise and nothing else. What needs Open Image Denoise says that it is skipped where there is none; `./test` fetches it.

use crate::common::program::{Folder, SMALL};
use bhs::denoise::{Denoiser, NOISY};
use bhs::image::{Attribute, Frame, Picture};
use exr::math::Vec2;
use exr::meta::attribute::Chromaticities;
use std::path::Path;

/// The library, if there is one.
fn library() -> Option<Denoiser> {
    Denoiser::load(Some(2)).inspect_err(|missing| eprintln!("skipped: {missing}")).ok()
}

/// A picture of 48 x 40 pixels with the layers of the filter: `color` of column and row, with noise that has no mean.
fn picture(noise: f32, color: impl Fn(usize, usize) -> [f32; 3]) -> Picture {
    let size = [48, 40];
    let channels = ["R", "G", "B", "Albedo.R", "Albedo.G", "Albedo.B", "N.X", "N.Y", "N.Z", "depth"].map(str::to_owned).to_vec();
    let mut state = 1u32;
    let mut random = || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (state >> 8) as f32 / (1 << 24) as f32 - 0.5
    };
    let mut data = Vec::new();
    for i in 0..size[0] * size[1] {
        let (x, y) = (i % size[0], i / size[0]);
        let factor = 1.0 + noise * random();
        let albedo = if x < 24 { [0.8, 0.2, 0.1] } else { [0.3, 0.3, 0.7] };
        data.extend(color(x, y).map(|v| v * factor).into_iter().chain(albedo).chain([0.0, 0.0, 1.0]).chain([x as f32 + 1e-7]));
    }
    Picture { size, frame: Frame { offset: [3, 5], size: [64, 64] }, channels, data }
}

/// Two flat colours side by side.
fn halves(x: usize, _: usize) -> [f32; 3] {
    if x < 24 { [1.6, 0.4, 0.2] } else { [0.6, 0.6, 1.4] }
}

fn write(picture: &Picture, path: &Path) {
    let attributes =
        [("bhs:test".to_owned(), Attribute::Text("kept".into())), ("comments".to_owned(), Attribute::Text("mine".into()))];
    let file = std::fs::File::create(path).expect("writable");
    picture.write_exr(std::io::BufWriter::new(file), &attributes).expect("writable");
}

fn channel(picture: &Picture, name: &str) -> Vec<f32> {
    let [c] = picture.find([name]).unwrap_or_else(|| panic!("no channel {name}: {:?}", picture.channels));
    picture.pixels().map(|pixel| pixel[c]).collect()
}

/// Mean square of the difference to what `color` says.
fn error(picture: &Picture, color: impl Fn(usize, usize) -> [f32; 3]) -> f64 {
    let channels = picture.find(["R", "G", "B"]).expect("colours");
    let square = |(i, pixel): (usize, &[f32])| {
        let right = color(i % picture.size[0], i / picture.size[0]);
        (0..3).map(|c| f64::from(pixel[channels[c]] - right[c]).powi(2)).sum::<f64>()
    };
    picture.pixels().enumerate().map(square).sum::<f64>() / (picture.size[0] * picture.size[1]) as f64
}

#[test]
fn without_the_library_it_is_said_how_to_get_it() {
    let folder = Folder::new("");
    write(&picture(0.5, halves), &folder.at("in.exr"));
    let before = folder.contents();
    let run = folder.shell("BHS_OIDN_DIR=$PWD/nothing $BHS denoise in.exr -o out.exr");
    assert_eq!(run.code, 1, "{}", run.err);
    assert!(run.err.contains("nothing/libOpenImageDenoise") && run.err.contains("BHS_OIDN_DIR"), "{}", run.err);
    // Something else of that name.
    for name in ["libOpenImageDenoise.so.2", "libOpenImageDenoise.2.dylib"] {
        folder.write(&format!("other/{name}"), "no library");
    }
    let run = folder.shell("BHS_OIDN_DIR=$PWD/other $BHS denoise in.exr -o out.exr");
    assert_eq!(run.code, 1, "{}", run.err);
    std::fs::remove_dir_all(folder.at("other")).expect("it is there");
    assert!(folder.contents() == before, "{:?}", folder.files());
}

#[test]
fn what_cannot_be_denoised_is_refused_and_nothing_is_written() {
    let folder = Folder::new(SMALL);
    let full = picture(0.5, halves);
    write(&full, &folder.at("in.exr"));
    folder.write("there.png", "somebody's");
    folder.write("text.exr", "no picture");
    for layers in [&["--aov", "normal"][..], &["--aov", "albedo"], &[]] {
        let mut args = vec!["render", "scene.bhs", "--quiet", "-o", "part.exr"];
        args.extend(layers);
        assert_eq!(folder.run(&args).code, 0);
        let run = folder.run(&["denoise", "part.exr", "-o", "out.exr"]);
        assert_eq!(run.code, 1, "{}", run.err);
        for name in ["albedo", "normal"] {
            let is_missing = !layers.contains(&name);
            assert_eq!(run.err.contains(&format!("--aov {name}")), is_missing, "{layers:?}: {}", run.err);
            assert_eq!(run.err.contains(&format!("no layer `{name}`")), is_missing, "{layers:?}: {}", run.err);
        }
    }
    #[cfg(unix)]
    std::os::unix::fs::symlink("in.exr", folder.at("link.exr")).expect("links");
    let before = folder.contents();
    let refused = |args: &[&str], code: i32, word: &str| {
        let run = folder.run(&[&["denoise"], args].concat());
        assert_eq!(run.code, code, "{args:?}: {}", run.err);
        assert!(run.err.contains(word), "{args:?}: {}", run.err);
        assert!(folder.contents() == before, "{args:?}: {:?}", folder.files());
    };
    refused(&["in.exr"], 2, "--output");
    refused(&["in.exr", "-o", "in.exr"], 1, "which is the picture that is denoised");
    refused(&["in.exr", "-o", "././in.exr"], 1, "cannot write");
    #[cfg(unix)]
    refused(&["in.exr", "-o", "link.exr"], 1, "which is the picture that is denoised");
    refused(&["in.exr", "-o", "out.png"], 1, "ends in .exr");
    refused(&["in.exr", "-o", "there.exr", "--no-overwrite"], 1, "`there.png` is there already");
    refused(&["in.exr", "-o", "nowhere/out.exr"], 1, "nowhere");
    refused(&["gone.exr", "-o", "out.exr"], 1, "gone.exr");
    refused(&["text.exr", "-o", "out.exr"], 1, "text.exr");
    refused(&["scene.bhs", "-o", "out.exr"], 1, "scene.bhs");
}

#[test]
fn noise_goes_and_all_else_stays() {
    let Some(_) = library() else { return };
    let folder = Folder::new("");
    let noisy = picture(1.0, halves);
    write(&noisy, &folder.at("in.exr"));
    let run = folder.run(&["denoise", "in.exr", "-o", "out.exr", "--threads", "1"]);
    assert_eq!(run.code, 0, "{}", run.err);
    assert!(run.err.starts_with("out.exr and .png: denoised in ") && run.err.lines().count() == 1, "{}", run.err);
    assert_eq!(folder.files(), ["in.exr", "out.exr", "out.png", "scene.bhs"]);
    let result = Picture::read_exr(&folder.at("out.exr")).expect("a picture");
    assert_eq!((result.size, result.frame), (noisy.size, noisy.frame));
    let [before, after] = [&noisy, &result].map(|picture| error(picture, halves));
    assert!(after < before / 50.0, "{before} {after}");
    let others = noisy.channels[3..].iter().map(|name| (&**name, &**name));
    for (kept, of) in NOISY.into_iter().zip(["R", "G", "B"]).chain(others) {
        let bits = |picture, name| channel(picture, name).into_iter().map(f32::to_bits).collect::<Vec<_>>();
        assert_eq!(bits(&result, kept), bits(&noisy, of), "{kept}");
    }
    let header = String::from_utf8_lossy(&folder.read("out.exr")).into_owned();
    for word in ["bhs:test", "kept", "mine", "bhs:denoised", "Open Image Denoise 2."] {
        assert!(header.contains(word), "{word}");
    }
    // With other threads, and from what has been denoised: the same.
    for (args, from) in [(&["--threads", "3"][..], "in.exr"), (&[], "out.exr")] {
        let run = folder.run(&[&["denoise", from, "-o", "again.exr"], args].concat());
        assert_eq!(run.code, 0, "{}", run.err);
        assert_eq!(run.err.contains("denoised before"), from == "out.exr", "{}", run.err);
        let again = Picture::read_exr(&folder.at("again.exr")).expect("a picture");
        assert!(again.same_channels(&result), "{from} {args:?}");
        assert_eq!(folder.read("again.png"), folder.read("out.png"));
    }
}

/// The PNG is what `bhs develop` makes of the EXR file, whatever the primaries of its colours.
#[test]
fn the_png_of_a_denoised_picture_is_that_of_its_file() {
    let Some(_) = library() else { return };
    let folder = Folder::new("");
    let rec2020 = Chromaticities {
        red: Vec2(0.708, 0.292),
        green: Vec2(0.17, 0.797),
        blue: Vec2(0.131, 0.046),
        white: Vec2(0.3127, 0.329),
    };
    let noisy = picture(1.0, halves);
    let mut shown = Vec::new();
    for attributes in [vec![], vec![("chromaticities".to_owned(), Attribute::Chromaticities(rec2020))]] {
        let mut file = std::io::Cursor::new(Vec::new());
        noisy.write_exr(&mut file, &attributes).expect("in memory");
        folder.write("in.exr", file.into_inner());
        for args in [&["denoise", "in.exr", "-o", "out.exr"][..], &["develop", "out.exr", "-o", "developed.png"]] {
            let run = folder.run(args);
            assert_eq!(run.code, 0, "{args:?}: {}", run.err);
        }
        shown.push(folder.read("out.png"));
        assert!(shown.last() == Some(&folder.read("developed.png")), "{attributes:?}");
    }
    assert!(shown[0] != shown[1], "the primaries do not matter");
}

#[test]
fn numbers_that_are_none_harm_no_other() {
    let Some(denoiser) = library() else { return };
    let clean = picture(0.0, halves);
    let mut holes = clean.clone();
    let stride = holes.channels.len();
    for (pixel, value) in [(100, f32::NAN), (500, f32::INFINITY), (501, f32::NEG_INFINITY), (900, f32::MAX)] {
        holes.data[pixel * stride..][..9].fill(value);
    }
    let denoised = denoiser.denoise(&holes).expect("denoised");
    let wrong = error(&denoised, halves);
    assert!(wrong < 0.005, "{wrong}");
    let [c] = denoised.find(["noisy.R"]).expect("kept");
    assert!(denoised.data[100 * denoised.channels.len() + c].is_nan(), "the noisy picture is what it was");
    // Nothing but such numbers; and pictures of no size worth speaking of.
    holes.data.fill(f32::NAN);
    let nothing = denoiser.denoise(&holes).expect("denoised");
    assert!(["R", "G", "B"].iter().all(|name| channel(&nothing, name).iter().all(|v| *v == 0.0)));
    for size in [[1, 1], [1, 7], [16, 16], [17, 3]] {
        let mut data = clean.data[..size[0] * size[1] * stride].to_vec();
        data.iter_mut().for_each(|v| *v += 0.1);
        let frame = Frame { offset: [0, 0], size };
        let small = Picture { size, frame, channels: clean.channels.clone(), data };
        let result = denoiser.denoise(&small).expect("denoised");
        assert!(result.data.iter().all(|v| v.is_finite()), "{size:?}");
    }
}

#[test]
fn light_is_not_clamped() {
    let Some(denoiser) = library() else { return };
    // Very bright, and of a colour outside of sRGB, in the mean of samples of both signs.
    let color = |_: usize, _: usize| [3000.0, 900.0, -200.0];
    let noisy = picture(1.5, color);
    let denoised = denoiser.denoise(&noisy).expect("denoised");
    for name in ["R", "G", "B"] {
        let mean = |picture| channel(picture, name).iter().map(|v| f64::from(*v)).sum::<f64>();
        let ratio = mean(&denoised) / mean(&noisy);
        // The filter is no exact mean; clamped, nothing would be left.
        assert!((ratio - 1.0).abs() < 0.1, "{name}: {ratio}");
    }
}

/// In watts of whatever, or of a star far away: the same picture but for its brightness.
#[test]
fn the_unit_of_light_does_not_matter() {
    let Some(denoiser) = library() else { return };
    let denoised = |unit: f32| {
        let noisy = picture(1.0, |x, y| halves(x, y).map(|v| v * unit));
        let result = denoiser.denoise(&noisy).expect("denoised");
        error(&result, |x, y| halves(x, y).map(|v| v * unit)).sqrt() / f64::from(unit)
    };
    let usual = denoised(1.0);
    for unit in [1e-30, 1e-16, 1e-9, 1e-6, 1e6, 1e25] {
        let off = denoised(unit);
        assert!(off < 1.2 * usual + 1e-3, "{unit}: {off} {usual}");
    }
}

#[test]
fn lamps_as_bright_as_can_be_stay_so() {
    let Some(denoiser) = library() else { return };
    let mut noisy = picture(0.5, halves);
    let stride = noisy.channels.len();
    let lamp = |i: usize| (10..20).contains(&(i % 48)) && (10..18).contains(&(i / 48));
    for i in (0..48 * 40).filter(|i| lamp(*i)) {
        noisy.data[i * stride..][..3].fill(f32::MAX);
    }
    let denoised = denoiser.denoise(&noisy).expect("denoised");
    let green = channel(&denoised, "G");
    for (i, v) in green.iter().enumerate() {
        assert_eq!(*v == f32::MAX, lamp(i), "{i}: {v}");
    }
    assert!(green[5 * 48 + 40] < 2.0 && green[30 * 48 + 5] < 2.0);
}

#[test]
fn stars_stay_points() {
    let Some(denoiser) = library() else { return };
    let at = 20 * 48 + 20;
    let mut starry = picture(0.3, |_, _| [0.02; 3]);
    starry = starry.with_channels(&bhs::denoise::STARS, |_, into| into.extend([0.0; 3]));
    let stride = starry.channels.len();
    let star = &mut starry.data[at * stride..][..stride];
    (0..3).for_each(|c| star[c] += 5.0);
    star[stride - 3..].fill(5.0);
    let denoised = denoiser.denoise(&starry).expect("denoised");
    let [with, beside] = [at, at + 1].map(|pixel| channel(&denoised, "G")[pixel]);
    assert!((with - 5.02).abs() < 0.01 && (beside - 0.02).abs() < 0.01, "{with} {beside}");
}

/// A lit ball, a mirror and a hole, with noise.
const NOISY_SCENE: &str = r#"
Film "rgb" "integer xresolution" 40 "integer yresolution" 30 "string filename" "plain.exr"
Sampler "sobol" "integer pixelsamples" 4
LookAt 0 1 -4  0 0 0  0 1 0
Camera "perspective" "float fov" 50
WorldBegin
BlackHole "schwarzschild" "point3 center" [1 1 0] "float rs" 0.1
AttributeBegin
    AreaLightSource "diffuse" "float L" 8
    Translate -1 3 -1
    Shape "sphere" "float radius" 0.4
AttributeEnd
Shape "bilinearmesh" "point3 P" [-4 -1 -4  4 -1 -4  -4 -1 4  4 -1 4]
Shape "sphere" "float radius" 0.8
Translate 1.5 0 0.5
Material "mirror"
Shape "sphere" "float radius" 0.6
"#;

#[test]
fn a_render_without_the_library_ends_before_it_begins() {
    // It would take for ever.
    let folder = Folder::new(&NOISY_SCENE.replace("pixelsamples\" 4", "pixelsamples\" 100000000"));
    let run = folder.shell("BHS_OIDN_DIR=$PWD/nothing $BHS render scene.bhs --denoise");
    assert_eq!((run.code, folder.files()), (1, vec!["scene.bhs".to_owned()]), "{}", run.err);
    assert!(run.err.contains("Open Image Denoise") && run.err.contains("BHS_OIDN_DIR"), "{}", run.err);
    let run = folder.run(&["render", "scene.bhs", "--denoise", "--pixel", "1,1", "--sample", "0"]);
    assert_eq!(run.code, 2, "{}", run.err);
}

#[test]
fn a_denoised_render_keeps_the_picture_without_denoising() {
    let Some(_) = library() else { return };
    let folder = Folder::new(NOISY_SCENE);
    let run = |args: &[&str]| {
        let run = folder.run(args);
        assert_eq!(run.code, 0, "{args:?}: {}", run.err);
        run.err
    };
    let picture = |name: &str| Picture::read_exr(&folder.at(name)).unwrap_or_else(|e| panic!("{e:#}"));
    run(&["render", "scene.bhs", "--quiet"]);
    let said = run(&["render", "scene.bhs", "--denoise", "-o", "denoised.exr", "--stats", "stats.json"]);
    assert!(said.contains("4 spp in"), "{said}");
    let (plain, denoised) = (picture("plain.exr"), picture("denoised.exr"));
    let bits = |picture: &Picture, name: &str| channel(picture, name).into_iter().map(f32::to_bits).collect::<Vec<_>>();
    for (noisy, of) in NOISY.into_iter().zip(["R", "G", "B"]) {
        assert_eq!(bits(&denoised, noisy), bits(&plain, of), "{noisy}");
        assert_ne!(bits(&denoised, of), bits(&plain, of), "{of}");
    }
    assert_eq!(denoised.channels.len(), 12, "{:?}", denoised.channels);
    assert_ne!(folder.read("plain.png"), folder.read("denoised.png"));
    let stats: serde_json::Value = serde_json::from_slice(&folder.read("stats.json")).expect("JSON");
    assert!(stats["seconds"]["denoise"].is_number(), "{stats}");
    assert!(bhs::header::is_denoised(&folder.at("denoised.exr")) && !bhs::header::is_denoised(&folder.at("plain.exr")));

    // The layers that there are once it is denoised, as `bhs develop` shows them.
    for layer in ["noisy", "noisy.G", "albedo"] {
        for flags in [&["--layer", layer][..], &["--layer", layer, "--false-color"]] {
            run(&[&["render", "scene.bhs", "--denoise", "--quiet", "-o", "shown.exr"], flags].concat());
            run(&[&["develop", "denoised.exr", "-o", "developed.png"], flags].concat());
            assert!(folder.read("shown.png") == folder.read("developed.png"), "{flags:?}");
        }
    }
    // While it is under way there are the noisy colours only.
    run(&[
        "render",
        "scene.bhs",
        "--denoise",
        "--quiet",
        "--layer",
        "noisy",
        "--write-partial",
        "--checkpoint",
        "-o",
        "shown.exr",
    ]);
    let refused = folder.run(&["render", "scene.bhs", "--layer", "noisy"]);
    assert!(refused.code == 2 && refused.err.contains("noisy"), "{}", refused.err);

    // Afterwards, from a file: the same.
    run(&["render", "scene.bhs", "--quiet", "--aov", "albedo", "--aov", "normal", "-o", "layers.exr"]);
    run(&["denoise", "layers.exr", "-o", "later.exr", "--quiet"]);
    assert!(picture("later.exr").same_channels(&denoised));
    // By another number of threads; resumed from a checkpoint; resumed when it is finished.
    run(&["render", "scene.bhs", "--quiet", "--denoise", "--threads", "1", "-o", "one.exr"]);
    run(&["render", "scene.bhs", "--quiet", "--denoise", "--spp", "2", "--checkpoint", "-o", "go.exr"]);
    assert!(!picture("go.exr").same_channels(&denoised));
    run(&["render", "scene.bhs", "--quiet", "--denoise", "--resume", "-o", "go.exr"]);
    assert!(picture("one.exr").same_channels(&denoised) && picture("go.exr").same_channels(&denoised));
    std::fs::remove_file(folder.at("go.png")).expect("it is there");
    run(&["render", "scene.bhs", "--quiet", "--denoise", "--resume", "-o", "go.exr"]);
    assert!(picture("go.exr").same_channels(&denoised) && folder.read("go.png") == folder.read("denoised.png"));
}

#[test]
fn parts_cameras_frames_and_films_of_many_channels_are_denoised_too() {
    let Some(_) = library() else { return };
    let second = "Camera \"perspective\" \"string name\" \"left\" \"float fov\" 30\nWorldBegin";
    let folder = Folder::new(&NOISY_SCENE.replace("WorldBegin", second));
    let has_noisy = |name: &str| Picture::read_exr(&folder.at(name)).is_ok_and(|picture| picture.find(NOISY).is_some());
    let run = |args: &[&str]| {
        let run = folder.run(&[&["render", "scene.bhs", "--denoise"], args].concat());
        assert_eq!(run.code, 0, "{args:?}: {}", run.err);
    };
    run(&["--quiet"]);
    assert!(has_noisy("plain.exr") && has_noisy("plain.left.exr"), "{:?}", folder.files());
    run(&["--quiet", "--crop", "0.5,0.51,0.5,0.52", "--camera", "left", "-o", "crop.exr", "--false-color", "--aov", "variance"]);
    assert!(has_noisy("crop.exr") && folder.at("crop.albedo.png").exists(), "{:?}", folder.files());
    run(&["--quiet", "--camera", "left", "--frames", "1-2", "--preview", "film.gif", "-o", "f.exr"]);
    assert!(has_noisy("f.0001.exr") && has_noisy("f.0002.exr") && folder.at("film.gif").exists());
    // A frame that is there with its noise is not what is asked for.
    assert_eq!(folder.run(&["render", "scene.bhs", "--quiet", "--camera", "left", "--frames", "1", "-o", "f.exr"]).code, 0);
    assert!(!has_noisy("f.0001.exr"));
    run(&["--quiet", "--camera", "left", "--frames", "1-2", "--skip-existing", "-o", "f.exr"]);
    assert!(has_noisy("f.0001.exr"));
    folder.write("scene.bhs", NOISY_SCENE.replace("\"rgb\"", "\"spectral\" \"integer nbuckets\" 3"));
    run(&["--quiet", "-o", "spectral.exr"]);
    let picture = Picture::read_exr(&folder.at("spectral.exr")).expect("a picture");
    assert_eq!(picture.channels.len(), 3 + 3 + 6 + 3, "{:?}", picture.channels);
}
