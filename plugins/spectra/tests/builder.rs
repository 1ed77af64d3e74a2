//! Spectra as scenes describe them: what comes out, and what is said about faults.

use bhs_core::diagnostics::{Diagnostic, Span, Spanned};
use bhs_core::params::{Context, Files, SpectrumSource};
use bhs_core::spectrum::{Spectrum, SpectrumRole};
use bhs_core::value::{Param, ParamType, Values};
use bhs_spectra::{ALL, Builder, Built, builtin_names};
use glam::DAffine3;
use std::sync::Arc;

use SpectrumRole::{Emission, Reflectance, Unbounded};

/// The folder `data/` of the crate, and a few files that exist only here.
struct TestFiles;

impl Files for TestFiles {
    fn read(&self, path: &str, _: Span) -> Result<Vec<u8>, String> {
        let text = match path {
            "commas.spd" => "\u{feff}# a comment\r\n400, 1\r\n\r\n500,\t2 # two\r\n  600 4\r\n",
            "empty.spd" => "# nothing\n\n",
            "words.spd" => "400 1\n500 many\n500 inf\n600\n",
            "order.spd" => "400 1\n400 2\n500 3\n450 4\n500 1\n500 2\n500 3\n",
            "negative.spd" => "400 1\n\n# x\n500 -0.5\n",
            "bytes.spd" => return Ok(vec![0xff, 0xfe, 0x00]),
            _ if path.starts_with("text:") => return Ok(path[5..path.len() - 1].chars().map(|c| c as u8).collect()),
            _ => {
                let file = format!("{}/{path}", env!("CARGO_MANIFEST_DIR"));
                return std::fs::read(file).map_err(|_| "there is no such file".to_owned());
            }
        };
        Ok(text.as_bytes().to_vec())
    }
}

const VALUES: Span = Span { file: 0, start: 30, end: 40 };

fn string_span(i: usize) -> Span {
    Span { file: 0, start: 31 + 4 * i as u32, end: 34 + 4 * i as u32 }
}

fn build_values(ty: ParamType, values: Values, role: SpectrumRole) -> Built {
    let span = |start, end| Span { file: 0, start, end };
    let param =
        Param { ty: Spanned::new(ty, span(10, 18)), name: Spanned::new("L".to_owned(), span(19, 20)), values, span: VALUES };
    let context = Context {
        files: &TestFiles,
        spectra: &Builder,
        named: &bhs_core::params::Nameless,
        world_from_object: DAffine3::IDENTITY,
        reverse_orientation: false,
        resolution: [1, 1],
        lambda_range: [360.0, 830.0],
        seed: 0,
    };
    Builder.build(&param, role, &context)
}

fn numbers(ty: ParamType, values: &[f64], role: SpectrumRole) -> Built {
    build_values(ty, Values::Numbers { values: values.to_vec(), whole: false }, role)
}

fn strings(values: &[&str], role: SpectrumRole) -> Built {
    let strings = values.iter().enumerate().map(|(i, s)| Spanned::new((*s).to_owned(), string_span(i)));
    build_values(ParamType::Spectrum, Values::Strings(strings.collect()), role)
}

fn good(built: Built) -> Arc<dyn Spectrum> {
    built.unwrap_or_else(|found| panic!("{found:?}"))
}

/// The findings about a faulty parameter, each of which has a place.
fn bad(built: Built) -> Vec<Diagnostic> {
    let found = built.expect_err("a fault");
    assert!(!found.is_empty() && found.iter().all(|d| d.primary.is_some()), "{found:?}");
    found
}

/// Where the only finding is, and what it says: message, text under it, help.
fn finding(built: Built) -> (Span, String) {
    let found = bad(built);
    let [d] = &found[..] else { panic!("{found:?}") };
    let label = d.primary.as_ref().expect("checked");
    (label.span, format!("{}; {}; {}", d.message, label.text, d.help.as_deref().unwrap_or_default()))
}

#[track_caller]
fn expect(built: Built, span: Span, parts: &[&str]) {
    let (at, text) = finding(built);
    assert_eq!(at, span, "{text}");
    for part in parts {
        assert!(text.contains(part), "`{part}` is not in: {text}");
    }
}

#[test]
fn numbers_are_constant() {
    for ty in [ParamType::Float, ParamType::Spectrum] {
        let s = good(numbers(ty, &[0.25], Reflectance));
        assert!(s.is_constant() && s.at(123.0) == 0.25 && s.max(1.0, 2.0) == 0.25);
    }
    expect(numbers(ParamType::Float, &[0.1, 0.2], Reflectance), VALUES, &["`L` expects one number", "found 2 numbers"]);
    expect(numbers(ParamType::Spectrum, &[], Reflectance), VALUES, &["expects one number", "an empty list"]);
    let bools = || build_values(ParamType::Spectrum, Values::Bools(vec![true]), Reflectance);
    expect(bools(), VALUES, &["a number, wavelength-value pairs or a name", "found a bool"]);
}

#[test]
fn pairs_are_a_table() {
    let s = good(numbers(ParamType::Spectrum, &[400.0, 1.0, 500.0, 3.0, 700.0, 4.0], Unbounded));
    assert_eq!((s.at(450.0), s.at(600.0), s.at(300.0), s.at(900.0)), (2.0, 3.5, 1.0, 4.0));
    let s = good(numbers(ParamType::Spectrum, &[400.0, 0.0, 400.0, 1.0, 700.0, 1.0, 700.0, 0.0], Emission));
    assert_eq!((s.at(399.0), s.at(500.0), s.at(701.0)), (0.0, 1.0, 0.0));
    let table = |v: &[f64]| numbers(ParamType::Spectrum, v, Emission);
    expect(table(&[400.0, 1.0, 500.0]), VALUES, &["pairs of wavelength [nm] and value", "3 numbers"]);
    expect(table(&[500.0, 1.0, 400.0, 1.0]), VALUES, &["400 nm after 500 nm", "must increase"]);
    expect(table(&[0.0, 1.0, 400.0, 1.0]), VALUES, &["a value at 0 nm"]);
    expect(table(&[400.0, 1.0, 400.0, 2.0, 400.0, 3.0]), VALUES, &["three values at 400 nm"]);
}

#[test]
fn roles_bound_the_values() {
    let one = |v, role| numbers(ParamType::Float, &[v], role);
    expect(one(1.5, Reflectance), VALUES, &["`L` is 1.5", "between 0 and 1"]);
    expect(one(-0.5, Reflectance), VALUES, &["between 0 and 1"]);
    expect(one(-1.0, Emission), VALUES, &["not negative"]);
    expect(one(-1.0, Unbounded), VALUES, &["negative value"]);
    expect(one(1e300, Emission), VALUES, &["too large"]);
    good(one(1.5, Emission));
    expect(numbers(ParamType::Spectrum, &[400.0, 0.5, 500.0, 1.25], Reflectance), VALUES, &["`L` is 1.25 at 500 nm"]);
    expect(strings(&["metal-Au-k"], Reflectance), string_span(0), &[" nm; a reflectance lies"]);
    expect(strings(&["glass-BK7"], Reflectance), string_span(0), &["a reflectance lies"]);
    expect(strings(&["negative.spd"], Emission), string_span(0), &["`L` is -0.5 at 500 nm (line 4)"]);
    expect(numbers(ParamType::Rgb, &[0.5, 1.5, 0.5], Reflectance), VALUES, &["1.5 in green"]);
    expect(numbers(ParamType::Rgb, &[0.5, 1.5, -0.5], Emission), VALUES, &["-0.5 in blue"]);
}

#[test]
fn files_are_read() {
    let s = good(strings(&["commas.spd"], Unbounded));
    assert_eq!((s.at(300.0), s.at(450.0), s.at(550.0), s.at(900.0)), (1.0, 1.5, 3.0, 4.0));
    let s = good(strings(&["commas.spd", "zero-outside"], Unbounded));
    assert_eq!((s.at(399.0), s.at(400.0), s.at(600.0), s.at(601.0)), (0.0, 1.0, 4.0, 0.0));
    let text = string_span(0);
    expect(strings(&["no/such.spd"], Emission), text, &["cannot read `no/such.spd`: there is no such file"]);
    expect(strings(&["empty.spd"], Emission), text, &["it has no values"]);
    expect(strings(&["bytes.spd"], Emission), text, &["not text"]);
    expect(strings(&["commas.spd", "zero"], Emission), string_span(1), &["`zero` cannot follow", "`zero-outside`"]);
    let messages = |file| bad(strings(&[file], Emission)).into_iter().map(|d| d.message).collect::<Vec<_>>().join("\n");
    let words = messages("words.spd");
    for part in ["line 2: `many` is not a number", "line 3: `inf` is not finite", "line 4: expected two numbers, found 1"] {
        assert!(words.contains(part), "{words}");
    }
    let order = messages("order.spd");
    for part in ["line 4: 450 nm does not follow 500 nm", "line 7: a third value at 500 nm"] {
        assert!(order.contains(part), "{order}");
    }
}

#[test]
fn every_program_s_way_of_writing_a_spectrum_is_read() {
    // Characters are the bytes of the file.
    let table = [
        "400 0.1\n550 5\n700 0.1\n",
        "700 0.1\n550 5\n400 0.1\n",
        "# caf\u{e9}, 5 \u{b5}m slit\n400 0.1\n550 5\n700 0.1",
        "wavelength,radiance\n400,0.1\n550,5\n700,0.1\n",
        "\u{ef}\u{bb}\u{bf}Wavelength (nm);Power (W/m2)\r\n400;0.1\r\n550;5\r\n700;0.1\r\n",
        "nm\tW\r400\t0.1\r550\t5\r700\t0.1\r",
        "400, 0.1,\n550 ,5,\n700 , 0.1 ,\n",
        "4e2 1.0E-1\n+550.0 5.\n700 .1\n",
        "\u{b5}m \u{e9}\n400 0.1\n550 5\n700 0.1\n",
    ];
    for text in table {
        let s = good(strings(&[&format!("text:{text}.")], Unbounded));
        let found = [350.0, 475.0, 550.0, 650.0, 800.0].map(|l| s.at(l));
        let wanted = [0.1, 2.55, 5.0, 1.733_333, 0.1];
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-5), "{text:?}: {found:?}");
    }
    for text in ["400 0.1\n550 0.1\n550 5\n700 5\n# ", "700 5\n550 5\n550 0.1\n400 0.1\n# "] {
        let s = good(strings(&[&format!("text:{text}.")], Unbounded));
        assert_eq!([450.0, 549.9, 550.1, 650.0].map(|l| s.at(l)), [0.1, 0.1, 5.0, 5.0], "{text}");
    }
}

#[test]
fn files_that_mean_something_else_are_refused_with_what_to_do() {
    let table = [
        ("0.40 0.1\n0.55 5\n0.70 0.1\n", "wavelengths end at 0.7 nm: are they in micrometres?"),
        ("4e-7 0.1\n7e-7 0.1\n", "are they in metres?"),
        ("4000 0.1\n5500 5\n7000 0.1\n", "wavelengths begin at 4000 nm: are they in \u{e5}ngstr\u{f6}m?"),
        ("400,0;0,1\n550,0;5,0\n", "line 1: a comma within a number: write a point"),
        ("400\t0,1\n550\t5,0\n", "line 1: a comma within a number"),
        ("400,5,0,12\n", "line 1: a comma within a number"),
        ("400,0.1,0.2\n550,5,6\n", "line 1: expected two numbers, found 3 words: keep the wavelength and one column"),
        ("wl,n\n400,1.5\n700,1.4\nwl,k\n400,0\n700,0\n", "line 4: another table begins here (`wl,k`): keep one of them"),
        ("a,b\nc,d\n400,1\n", "line 2: `c` is not a number"),
        ("400 1\n500 2\n450 3\n600 4\n", "line 3: 450 nm does not follow 500 nm; wavelengths must increase"),
        ("600 1\n500 2\n550 3\n400 4\n", "line 3: 550 nm does not follow 500 nm; wavelengths must decrease"),
        ("\u{ff}\u{fe}4\u{0}0\u{0}", "in UTF-16"),
        ("name,value\n", "it has no values"),
    ];
    for (text, wanted) in table {
        let said =
            bad(strings(&[&format!("text:{text}# .")], Unbounded)).into_iter().map(|d| d.message).collect::<Vec<_>>().join("\n");
        assert!(said.contains(wanted), "{text:?}: {said}");
    }
}

#[test]
fn built_in_tables_are_the_files() {
    for (name, file) in [("cornell-white", "cornell_white"), ("cornell-red", "cornell_red"), ("cornell-green", "cornell_green")] {
        let built_in = good(strings(&[name], Reflectance));
        let path = format!("data/{file}.spd");
        let read = good(strings(&[&path], Reflectance));
        let mut l = 350.0;
        while l < 850.0 {
            assert_eq!(built_in.at(l), read.at(l), "{name} at {l}");
            l += 0.5;
        }
    }
    // A few numbers from the sources.
    for (name, lambda, value) in [
        ("cornell-white", 400.0, 0.343),
        ("cornell-red", 404.0, 0.046),
        ("cornell-green", 412.0, 0.097),
        ("cornell-light", 600.0, 15.6),
        ("cornell-light", 450.0, 4.0),
        ("cornell-luminaire", 555.0, 0.78),
        ("metal-Au-eta", 187.9, 1.28),
        ("metal-Au-k", 187.9, 1.188),
        ("metal-Al-eta", 442.8, 0.6079),
        ("metal-Al-k", 442.8, 5.3676),
        ("metal-Au-pbrt-eta", 298.757_05, 1.795),
        ("stdillum-D65", 560.0, 100.0),
        ("stdillum-E", 560.0, 1.0),
        ("glass-BK7", 587.5618, 1.5168),
        ("glass-SF11", 587.5618, 1.78472),
    ] {
        let got = good(strings(&[name], Unbounded)).at(lambda);
        assert!((got - value).abs() < 2e-6 * value.max(1.0), "{name}: {got}, not {value}");
    }
}

#[test]
fn every_built_in_name_builds() {
    for name in builtin_names() {
        let s = good(strings(&[name], Unbounded));
        let mut l = 100.0;
        while l < 3000.0 {
            assert!(s.at(l).is_finite() && s.at(l) >= 0.0 && s.at(l) <= s.max(100.0, 3000.0), "{name} at {l}");
            l += 7.0;
        }
    }
    let zero = good(strings(&["cornell-light", "zero-outside"], Emission));
    assert_eq!((zero.at(700.0), zero.at(701.0)), (18.4, 0.0));
    assert_eq!(good(strings(&["cornell-light"], Emission)).at(701.0), 18.4);
    expect(strings(&["cornel-whit"], Reflectance), string_span(0), &["unknown spectrum", "did you mean `cornell-white`?"]);
    expect(strings(&["xyzzy"], Reflectance), string_span(0), &["built-in are", "metal-Au-eta"]);
    expect(strings(&["glass-BK7", "zero-outside"], Unbounded), VALUES, &["a formula"]);
    expect(strings(&["a", "b", "c"], Unbounded), VALUES, &["3 strings"]);
}

#[test]
fn blackbody_only_emits() {
    let s = good(numbers(ParamType::Blackbody, &[6500.0], Emission));
    assert!((s.at(500.0) / 46_097.18 - 1.0).abs() < 1e-6 && !s.is_constant());
    expect(numbers(ParamType::Blackbody, &[6500.0], Reflectance), Span { file: 0, start: 10, end: 18 }, &["only describes"]);
    expect(numbers(ParamType::Blackbody, &[0.0], Emission), VALUES, &["`L` is 0 K", "greater than 0 K"]);
    expect(numbers(ParamType::Blackbody, &[1e12], Emission), VALUES, &["1e9 K"]);
    expect(numbers(ParamType::Blackbody, &[6500.0, 1.0], Emission), VALUES, &["one temperature"]);
}

#[test]
fn tolman_only_emits_and_is_a_black_body_far_from_the_hole() {
    let (tolman, far) =
        (good(numbers(ParamType::Tolman, &[3000.0], Emission)), good(numbers(ParamType::Blackbody, &[3000.0], Emission)));
    let hot = good(numbers(ParamType::Blackbody, &[6000.0], Emission));
    let lambda = [300.0, 450.0, 600.0, 900.0];
    assert_eq!(tolman.sample(lambda), far.sample(lambda));
    assert_eq!(tolman.sample_at(lambda, 0.5), hot.sample(lambda));
    expect(numbers(ParamType::Tolman, &[3000.0], Reflectance), Span { file: 0, start: 10, end: 18 }, &["only describes"]);
    expect(numbers(ParamType::Tolman, &[0.0], Emission), VALUES, &["`L` is 0 K", "greater than 0 K"]);
}

/// Linear sRGB of a radiance as a film records it, by the CIE's table and the matrix that Lindbloom publishes for the D65 of ASTM E308.
fn film_rgb(radiance: &dyn Spectrum) -> [f64; 3] {
    let text =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../colour/data/cie1931_2deg_1nm.csv")).expect("data");
    let rows = text.lines().filter_map(|l| l.split(',').map(|w| w.parse::<f64>().ok()).collect::<Option<Vec<f64>>>());
    let (mut xyz, mut total) = ([0.0; 3], 0.0);
    for row in rows {
        total += row[2];
        for c in 0..3 {
            xyz[c] += row[c + 1] * f64::from(radiance.at(row[0] as f32));
        }
    }
    let [x, y, z] = xyz.map(|v| v / total);
    [
        3.240_454_2 * x - 1.537_138_5 * y - 0.498_531_4 * z,
        -0.969_266_0 * x + 1.876_010_8 * y + 0.041_556_0 * z,
        0.055_643_4 * x - 0.204_025_9 * y + 1.057_225_2 * z,
    ]
}

#[test]
fn emitted_rgb_comes_back_from_the_film() {
    let colours = [[1.0, 1.0, 1.0], [17.0, 12.0, 4.0], [0.0, 0.0, 3.0], [1.0, 0.0, 0.0], [0.2, 0.9, 0.3], [1e-3, 2e-3, 5e-4]];
    for rgb in colours {
        let s = good(numbers(ParamType::Rgb, &rgb, Emission));
        let back = film_rgb(&*s);
        let largest = rgb.into_iter().fold(0.0, f64::max);
        for c in 0..3 {
            assert!((back[c] - rgb[c]).abs() < 4e-5 * largest, "{rgb:?} comes back as {back:?}");
        }
        for l in 300..900 {
            assert!(s.at(l as f32) >= 0.0 && s.at(l as f32) <= s.max(300.0, 900.0));
        }
    }
    assert!(good(numbers(ParamType::Rgb, &[0.0; 3], Emission)).is_constant());
}

#[test]
fn other_rgb_are_smooth_or_constant() {
    let grey = good(numbers(ParamType::Rgb, &[0.3; 3], Reflectance));
    assert!(grey.is_constant() && grey.at(500.0) == 0.3);
    let index = good(numbers(ParamType::Rgb, &[1.5, 1.5, 1.5], Unbounded));
    assert!(index.is_constant() && index.at(500.0) == 1.5);
    // The gold of CS184: the red, green and blue ends of the spectrum keep their order.
    let gold = good(numbers(ParamType::Rgb, &[0.21646, 0.42833, 1.3284], Unbounded));
    assert!(gold.at(450.0) > gold.at(550.0) && gold.at(550.0) > gold.at(630.0));
    expect(numbers(ParamType::Rgb, &[0.3; 2], Reflectance), VALUES, &["three numbers"]);
    assert!(ALL.iter().all(|p| !p.summary.is_empty()));
}
