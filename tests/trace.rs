//! `bhs trace`: columns in any order, faults with their place, and what is said of light.

use crate::common;
use assert_cmd::Command;
use bhs::lang::{BuiltScene, Overrides};
use bhs::render::Job;
use bhs::trace::{Answers, Format, connect, trace, trace_pixels};
use serde_json::Value;
use std::f64::consts::TAU;

/// A hole of rs = 1 in a shell of radius 9.
const SHELL: &str = "Integrator \"exact\" \"float tolerance\" 1e-8 WorldBegin BlackHole \"schwarzschild\" \"float rs\" 1
    LightSource \"infinite\" Shape \"sphere\" \"float radius\" 9";

fn scene(text: &str) -> BuiltScene {
    common::build_with(text, &Overrides { without_camera: true, ..Overrides::default() })
}

fn said(answers: &Answers, lines: &str) -> Result<String, String> {
    let mut out = Vec::new();
    trace(answers, lines.as_bytes(), &mut out).map_err(|error| format!("{error:#}"))?;
    Ok(String::from_utf8(out).expect("text"))
}

fn json(text: &str) -> Vec<Value> {
    text.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect()
}

/// The rows of a table, by the names of its columns.
fn rows(text: &str) -> Vec<Vec<(String, String)>> {
    let mut lines = text.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
    let names = lines.next().expect("a header");
    lines
        .map(|row| {
            assert_eq!(row.len(), names.len(), "{row:?}");
            names.iter().cloned().zip(row).collect()
        })
        .collect()
}

#[test]
fn columns_may_stand_in_any_order() {
    let built = scene(SHELL);
    let answers = Answers::new(&built.scene);
    let right = said(&answers, "4,0,0,-0.6,0.8,0\n").expect("a ray");
    assert!(right.contains("\"shape\":0") && right.contains("\"outcome\":\"hit\""), "{right}");
    for lines in [
        "ox,oy,oz,dx,dy,dz\n4,0,0,-0.6,0.8,0",
        "dx, dy, dz, ox, oy, oz\n-0.6, 0.8, 0, 4, 0, 0\n",
        "\u{feff}\"dz\",\"footprint\",\"oz\",\"dy\",\"oy\",\"dx\",\"ox\",\"side\"\r\n0,,0,0.8,0,-0.6,4,near\r\n",
        "# rays\n\nfootprint,ox,oy,oz,dx,dy,dz\n0,4,0,0,-0.6,0.8,0\n",
    ] {
        assert_eq!(said(&answers, lines).expect("a ray"), right, "{lines}");
    }
}

#[test]
fn faults_have_a_line_and_a_column() {
    let built = scene(SHELL);
    let answers = Answers::new(&built.scene);
    for (lines, right) in [
        ("0,0,5,0,0,1\n0,0,5, zero,0,1\n", "line 2, column 8: `zero` in the column `dx` is not a number"),
        ("dx,dy,dz,ox,oy,oz\n1,0,0,0,0,inf\n", "line 2, column 11: `inf` in the column `oz` is not finite"),
        ("ox,oy,oz,dx,dy\n", "line 1: the column `dz` is missing"),
        (
            "ox,oy,oz,dx,dy,dz,wavelength\n",
            "line 1, column 19: `wavelength` is no column: there are ox, oy, oz, dx, dy, dz, side, footprint",
        ),
        ("ox,oy,oz,dx,dy,dz,ox\n", "line 1, column 19: two columns are called `ox`"),
        ("ox,oy,oz,dx,dy,dz\n1,2,3\n", "line 2: expected 6 numbers ox,oy,oz,dx,dy,dz, found 3"),
        ("0,0,5,0,0,0\n", "line 1: the direction is zero"),
        ("side,ox,oy,oz,dx,dy,dz\nleft,0,0,5,0,0,1", "line 2, column 1: `left` is no side: near or far"),
    ] {
        assert_eq!(said(&answers, lines).expect_err(lines), right);
    }
}

#[test]
fn light_past_a_hole_is_told_with_its_delay_redshift_and_constants() {
    let built = scene(SHELL);
    let names = ["sphere".to_owned()];
    let answers = Answers { shape_names: &names, ..Answers::new(&built.scene) };
    // Inwards from r = 6 at the chart angle acos(-0.8), in the plane across +z: b from the first integral, and the time to r = 9 beyond.
    let ray = "6,0,0,-0.8,0.6,0\n";
    let end = &json(&said(&answers, ray).expect("a ray"))[0];
    let number = |key: &str| end[key].as_f64().unwrap_or_else(|| panic!("{key} in {end}"));
    let b = 3.6 / (1.0 - 0.36f64 / 6.0).sqrt();
    let close = |key: &str, right: f64| {
        assert!((number(key) - right).abs() < 1e-9 * right.abs().max(1.0), "{key}: {} is {right}", number(key))
    };
    close("b", b);
    // All of it across +y.
    close("L", 0.0);
    close("Q", b * b);
    close("redshift", ((1.0 - 1.0 / 9.0) / (1.0 - 1.0 / 6.0f64)).sqrt());
    close("winding", number("phi") / TAU);
    // Twice the integral of dr / (f sqrt(1 - b^2 f / r^2)) from the turning point, r = r0 + s^2, by the midpoint rule.
    let f = |r: f64| 1.0 - 1.0 / r;
    let turn = (0..100).fold([1.6, 6.0], |[lo, hi], _| {
        let r = 0.5 * (lo + hi);
        if r * r > b * b * f(r) { [lo, r] } else { [r, hi] }
    })[1];
    let leg = |to: f64| {
        let n = 400_000;
        let h = (to - turn).sqrt() / f64::from(n);
        // (r^3 - b^2 r + b^2) / (r - r0)
        let rest = |r: f64| r * r + turn * r + turn * turn - b * b;
        let rate = |s: f64| {
            let r = turn + s * s;
            2.0 * r.powf(1.5) / (f(r) * rest(r).sqrt())
        };
        (0..n).map(|k| rate((f64::from(k) + 0.5) * h)).sum::<f64>() * h
    };
    let time = leg(6.0) + leg(9.0);
    close("time", time);
    assert_eq!(end["shape_name"], "sphere");

    // Along the way: the same at its end, and nothing at its start.
    let with_path = Answers { with_path: true, ..answers };
    let way = &json(&said(&with_path, ray).expect("a ray"))[0];
    let list = |key: &str| way[key].as_array().expect(key).iter().map(|x| x.as_f64()).collect::<Vec<_>>();
    let (times, angles, shifts) = (list("path_time"), list("path_phi"), list("path_redshift"));
    assert!(times.len() == way["path"].as_array().expect("points").len() && times.len() == shifts.len() && times.len() > 10);
    assert_eq!((times[0], angles[0]), (Some(0.0), Some(0.0)));
    let last = |list: &[Option<f64>]| list.last().copied().flatten().expect("a number");
    assert!((last(&times) / time - 1.0).abs() < 1e-9 && last(&angles) == number("phi"));
    assert!((shifts[0].expect("g") - 1.0).abs() < 1e-12 && (last(&shifts) - number("redshift")).abs() < 1e-9);
    assert!(times.windows(2).all(|pair| pair[0] <= pair[1]));

    // The same as a table.
    let table = rows(&said(&Answers { format: Format::Csv, ..answers }, ray).expect("a ray"));
    for (name, text) in &table[0] {
        if ["time", "redshift", "b", "L", "Q", "winding", "phi", "steps", "queries", "shape"].contains(&name.as_str()) {
            // JSON is read to a digit less.
            let (found, right) = (text.parse::<f64>().expect("a number"), end[name].as_f64().expect("a number"));
            assert!((found - right).abs() <= 4e-16 * right.abs(), "{name}: {found} {right}");
        }
    }
    let points = rows(&said(&Answers { format: Format::Csv, ..with_path }, &format!("{ray}{ray}")).expect("two rays"));
    assert_eq!(points.len(), 2 * times.len());
    assert_eq!((points[times.len()][0].1.as_str(), points[times.len()][1].1.as_str()), ("1", "0"));
}

#[test]
fn light_without_an_end_says_so() {
    let built = scene("WorldBegin BlackHole \"schwarzschild\" \"float rs\" 1 LightSource \"infinite\"");
    let table =
        said(&Answers { format: Format::Csv, ..Answers::new(&built.scene) }, "5,0,0,1,0,0\n5,0,0,-1,0,0\n").expect("two rays");
    let of = |row: &[(String, String)], wanted: &str| row.iter().find(|(name, _)| name == wanted).expect("a column").1.clone();
    let table = rows(&table);
    assert_eq!([0, 1].map(|i| of(&table[i], "outcome")), ["escaped", "captured"]);
    assert!(table.iter().all(|row| of(row, "time").is_empty() && of(row, "x").is_empty() && of(row, "shape").is_empty()));
    assert!(of(&table[1], "redshift").is_empty());
    let g: f64 = of(&table[0], "redshift").parse().expect("g");
    assert!((g - 0.8f64.powf(-0.5)).abs() < 1e-12);
    let end = &json(&said(&Answers::new(&built.scene), "5,0,0,-1,0,0\n").expect("a ray"))[0];
    assert!(end["time"].is_null() && end["redshift"].is_null() && end["shape"].is_null());
}

/// One sample in the middle of each pixel.
const MIDDLE: &str = "Sampler \"stratified\" \"integer xsamples\" 1 \"integer ysamples\" 1 \"bool jitter\" false PixelFilter \"box\" \"float xradius\" 0.5 \"float yradius\" 0.5
    LightTransport \"normals\" Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 6
    \"string layers\" [\"position\" \"traveltime\" \"redshift\" \"impactparameter\" \"angularmomentum\" \"carter\" \"winding\"]
    LookAt 4 3 -8  0 0 0  0 1 0  Camera \"perspective\" \"float fov\" 50";

#[test]
fn a_pixel_is_told_as_its_picture_has_it() {
    for (hole, motion) in [
        ("BlackHole \"schwarzschild\" \"float rs\" 1", ""),
        ("BlackHole \"kerr\" \"float rs\" 1 \"float spin\" 0.9", ""),
        ("BlackHole \"schwarzschild\" \"float rs\" 1", "\"string motion\" \"velocity\" \"vector3 velocity\" [0.3 0 0.2]"),
    ] {
        let text = format!("{MIDDLE} {motion} WorldBegin {hole} LightSource \"infinite\" Shape \"sphere\" \"float radius\" 15");
        let built = common::build(&text);
        let rendered = common::render(&built);
        let layers = rendered.frame.layers();
        let value = |name: &str, i: usize| layers.iter().find(|layer| layer.name == name).expect("it is recorded").values[i];
        let pixels: Vec<[u32; 2]> = (0..48).map(|i| [i % 8, i / 8]).collect();
        let mut out = Vec::new();
        trace_pixels(&Answers::new(&built.scene), &Job::of(&built), &pixels, &mut out).expect("all are answered");
        let ends = json(&String::from_utf8(out).expect("text"));
        let mut hits = 0;
        for (i, end) in ends.iter().enumerate() {
            for (layer, key) in [
                ("traveltime", "time"),
                ("redshift", "redshift"),
                ("impactparameter", "b"),
                ("angularmomentum", "L"),
                ("carter", "Q"),
                ("winding", "winding"),
            ] {
                let (found, right) = (end[key].as_f64(), value(layer, i).map(|v| v[0]));
                assert!(
                    found.zip(right).is_some_and(|(a, b)| (a - b).abs() <= 1e-12 * b.abs()) || found == right,
                    "{hole}: {layer} {found:?} {right:?}"
                );
            }
            let Some(position) = value("position", i) else { continue };
            hits += 1;
            assert!((0..3).all(|c| (end["point"][c].as_f64().expect("a number") - position[c]).abs() < 1e-12), "{end}");
            // And the ray that is told is that of the picture.
            let vector = |key: &str| (0..3).map(|c| end["ray"][key][c].to_string()).collect::<Vec<_>>().join(",");
            let line = format!("{},{},{}", vector("origin"), vector("direction"), end["ray"]["footprint"]);
            let again =
                json(&said(&Answers::new(&built.scene), &format!("ox,oy,oz,dx,dy,dz,footprint\n{line}\n")).expect("a ray"));
            assert!((again[0]["phi"].as_f64().expect("a number") - end["phi"].as_f64().expect("a number")).abs() < 1e-9);
        }
        assert!(hits > 20, "{hole}: {hits}");
    }
}

#[test]
fn the_command_line_takes_pixels_and_formats() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let world =
        "WorldBegin BlackHole \"schwarzschild\" \"float rs\" 1 LightSource \"infinite\" Shape \"sphere\" \"float radius\" 15\n";
    let two = "Camera \"perspective\" \"string name\" \"left\" Camera \"perspective\" \"string name\" \"right\"\n";
    std::fs::write(dir.path().join("one.bhs"), format!("{MIDDLE}\n{world}")).expect("a file");
    std::fs::write(dir.path().join("two.bhs"), format!("LookAt 0 0 -8 0 0 0 0 1 0\n{two}{world}")).expect("a file");
    std::fs::write(dir.path().join("rays.csv"), "dx,dy,dz,ox,oy,oz\n0,0,1,0,3,-8\n0,0,1,0,3,oops\n").expect("a file");
    let run = |args: &str| {
        let out = Command::new(assert_cmd::cargo::cargo_bin!("bhs"))
            .current_dir(dir.path())
            .args(args.split_whitespace())
            .output()
            .expect("bhs starts");
        let text = |b: &[u8]| String::from_utf8_lossy(b).into_owned();
        (out.status.code().unwrap_or(-1), text(&out.stdout), text(&out.stderr))
    };
    let (code, out, err) = run("trace one.bhs --pixel 3,2 --pixel 0,0 --format csv");
    assert_eq!((code, rows(&out).len()), (0, 2), "{err}");
    assert!(out.contains(",sphere,"), "{out}");
    let (code, out, err) = run("trace two.bhs --pixel 3,2 --camera right --resolution 8x6 --path");
    assert!(code == 0 && json(&out)[0]["path_time"].is_array(), "{err}");
    for (args, word) in [
        ("trace two.bhs --pixel 3,2", "left, right"),
        ("trace one.bhs --pixel 8,2", "8 columns"),
        ("trace one.bhs", "--rays"),
        ("trace one.bhs --pixel 1,1 --rays rays.csv", "--rays"),
        ("trace one.bhs --rays rays.csv --format xml", "xml"),
    ] {
        let (code, out, err) = run(args);
        assert!(code == 2 && out.is_empty() && err.contains(word), "{args}: {code} {err}");
    }
    let (code, out, err) = run("trace one.bhs --rays rays.csv");
    assert_eq!((code, json(&out).len()), (1, 1), "what comes before is answered");
    assert!(err.contains("`rays.csv`: line 3, column 11: `oops` in the column `oz` is not a number"), "{err}");
}

#[test]
fn shapes_have_a_place_and_every_field_is_in_the_reference() {
    let built = scene(SHELL);
    let (names, places) = (["sphere".to_owned()], built.statements.shape_places());
    let answers = Answers { shape_names: &names, shape_places: &places, with_path: true, ..Answers::new(&built.scene) };
    let ray = "4,0,0,-0.6,0.8,0\n";
    let line = &json(&said(&answers, ray).expect("a ray"))[0];
    assert_eq!(line["shape_place"], "test.bhs:2:34");
    let table = said(&Answers { format: Format::Csv, with_path: false, ..answers }, ray).expect("a ray");
    assert!(table.contains(",0,sphere,test.bhs:2:34,near,"), "{table}");

    let mut fields: Vec<String> = line.as_object().expect("an object").keys().cloned().collect();
    for with_path in [false, true] {
        let table = said(&Answers { format: Format::Csv, with_path, ..answers }, ray).expect("a ray");
        fields.extend(table.lines().next().expect("a header").split(',').map(str::to_owned));
    }
    let mut out = Vec::new();
    let film =
        "Film \"rgb\" \"integer xresolution\" 4 \"integer yresolution\" 4 LookAt 0 0 -5 0 0 0 0 1 0 Camera \"perspective\"";
    let seen = common::build(&format!("{film} {SHELL}"));
    trace_pixels(&Answers::new(&seen.scene), &Job::of(&seen), &[[1, 1]], &mut out).expect("a ray");
    let of_pixel: Value = serde_json::from_slice(&out).expect("JSON");
    fields.extend(of_pixel.as_object().expect("an object").keys().cloned());
    fields.extend(of_pixel["ray"].as_object().expect("an object").keys().cloned());
    let mut out = Vec::new();
    connect(&built.scene, "4,0,0,0,4,0\n".as_bytes(), &mut out).expect("a pair");
    let joined: Value = serde_json::from_slice(&out).expect("JSON");
    fields.extend(joined["connections"][0].as_object().expect("an object").keys().cloned());

    let text = common::read("grammar/README.md");
    let section = text.split("\n## ").find(|section| section.starts_with("Single rays")).expect("a section");
    for field in fields {
        assert!(section.contains(&format!("`{field}`")), "`{field}` is not in the reference");
    }
}
