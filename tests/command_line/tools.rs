//! The commands that do not render.

use super::{LIT, SMALL, bhs, files, folder, run, write};

#[test]
fn check_speaks_json() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    write(dir.path(), "inner.bhs", "Material \"diffuse\"\nShape \"spheer\"\n");
    write(dir.path(), "scene.bhs", "WorldBegin\nInclude \"inner.bhs\"\nTexture\nMaterial \"diffuse\" \"rgb reflectance\" [1 2\n");
    let (code, out, err) = run(dir.path(), &["check", "--json", "scene.bhs"]);
    assert_eq!((code, err.as_str()), (1, ""));
    let found: Vec<serde_json::Value> = out.lines().map(|l| serde_json::from_str(l).expect("an object a line")).collect();
    let shape = found.iter().find(|d| d["code"] == "unknown-plugin").expect("the shape is unknown");
    assert_eq!(shape["severity"], "error");
    assert_eq!(shape["file"], "inner.bhs");
    assert_eq!((&shape["line"], &shape["column"]), (&2.into(), &7.into()));
    assert_eq!(shape["end"], serde_json::json!({ "line": 2, "column": 15 }));
    assert_eq!(shape["help"], "did you mean `sphere`?");
    assert_eq!((&shape["included_from"][0]["line"], &shape["included_from"][0]["column"]), (&2.into(), &9.into()));
    assert!(found.iter().any(|d| d["code"] == "unclosed-list" && d["label"] == "opened here"));

    write(dir.path(), "scene.bhs", "WorldBegin\n");
    let (code, out, _) = run(dir.path(), &["check", "--json", "scene.bhs"]);
    assert_eq!(code, 0);
    let warning: serde_json::Value = serde_json::from_str(out.trim_end()).expect("one object");
    assert_eq!((&warning["severity"], &warning["code"]), (&"warning".into(), &"no-light".into()));
}

#[test]
fn format_prints_or_writes_or_leaves_alone() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    write(dir.path(), "scene.bhs", "WorldBegin   # so\nShape    \"sphere\"");
    let neat = "WorldBegin  # so\nShape \"sphere\"\n";
    let read = || std::fs::read_to_string(dir.path().join("scene.bhs")).expect("readable");
    assert_eq!(run(dir.path(), &["format", "scene.bhs"]), (0, neat.to_owned(), String::new()));
    assert_ne!(read(), neat);
    assert_eq!(run(dir.path(), &["format", "--write", "scene.bhs"]), (0, String::new(), String::new()));
    assert_eq!(read(), neat);
    write(dir.path(), "scene.bhs", "WorldBegin [");
    let (code, out, err) = run(dir.path(), &["format", "--write", "scene.bhs"]);
    assert!(code == 1 && out.is_empty() && err.contains("never closed"), "{err}");
    assert_eq!((read().as_str(), files(dir.path()).len()), ("WorldBegin [", 0));
    assert_eq!(run(dir.path(), &["format", "--write", "-"]).0, 2);
    let piped = bhs().args(["format", "-"]).write_stdin("WorldBegin").output().expect("bhs starts");
    assert_eq!(piped.stdout, b"WorldBegin\n");
}

#[test]
fn plugins_speak_json() {
    let dir = tempfile::tempdir().expect("a temporary folder");
    let (code, out, _) = run(dir.path(), &["plugins", "--json"]);
    let all: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    assert!(code == 0 && all.as_array().is_some_and(|a| a.len() > 20));
    let (_, out, _) = run(dir.path(), &["plugins", "shape", "sphere", "--json"]);
    let sphere: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    let radius = &sphere[0]["parameters"][0];
    assert_eq!((&sphere[0]["kind"], &sphere[0]["name"]), (&"shape".into(), &"sphere".into()));
    assert_eq!((&radius["name"], &radius["type"], &radius["default"]), (&"radius".into(), &"float".into(), &"1".into()));
    assert_eq!(run(dir.path(), &["plugins", "shape", "spheer", "--json"]).0, 2);
}

#[test]
fn trace_answers_in_order_with_17_digits() {
    let dir = folder("BlackHole \"schwarzschild\" \"float rs\" 0.1\nTranslate 0 0 3\nShape \"sphere\"");
    write(
        dir.path(),
        "scene.bhs",
        format!(
            "LookAt 0 0 -5 0 0 0 0 1 0 {SMALL}BlackHole \"schwarzschild\" \"float rs\" 0.1\nTranslate 0 0 3\nShape \"sphere\""
        ),
    );
    let rays = "# a comment\n0,1,-5, 0,0,2\n0,0,-5,0,0,1\n\n0,0,-5,0,0,-1\n";
    write(dir.path(), "rays.csv", rays);
    let (code, out, err) = run(dir.path(), &["trace", "scene.bhs", "--rays", "rays.csv", "--path"]);
    assert_eq!(code, 0, "{err}");
    let answers: Vec<serde_json::Value> = out.lines().map(|l| serde_json::from_str(l).expect("JSON")).collect();
    let outcomes: Vec<_> = answers.iter().map(|a| a["outcome"].as_str().expect("a word")).collect();
    assert_eq!(outcomes, ["hit", "captured", "escaped"]);
    let hit = &answers[0];
    let coordinate = |name: &str, i: usize| hit[name][i].as_f64().expect("a number");
    // On the sphere, bent towards the hole.
    let r2: f64 = (0..3).map(|i| (coordinate("point", i) - if i == 2 { 3.0 } else { 0.0 }).powi(2)).sum();
    assert!((r2 - 1.0).abs() < 1e-9 && coordinate("direction", 1) < -0.1, "{hit}");
    assert_eq!(hit["shape"], 0);
    assert!(hit["path"].as_array().is_some_and(|p| p.len() > 3));
    assert!(hit["phi"].as_f64().is_some_and(|p| p > 1.0));
    assert!(out.lines().next().is_some_and(|l| l.contains("\"phi\":2.") && l.contains("e0")), "{out}");
    // From standard input, and with a straight integrator.
    let run =
        |args: &[&str], input: &str| bhs().current_dir(dir.path()).args(args).write_stdin(input).output().expect("bhs starts");
    let straight = run(&["trace", "scene.bhs", "--rays", "-", "--integrator", "straight"], "0,0,-5,0,0,1\n");
    assert!(String::from_utf8_lossy(&straight.stdout).contains("\"hit\""));
    for (bad, word) in [("0,0,0,0,0,0", "direction"), ("1,2,3", "6 numbers"), ("a,0,0,0,0,1", "`a`"), ("inf,0,0,0,0,1", "finite")]
    {
        let out = run(&["trace", "scene.bhs", "--rays", "-"], &format!("0,0,-5,0,0,1\n{bad}\n"));
        let err = String::from_utf8_lossy(&out.stderr).into_owned();
        assert_eq!(out.status.code(), Some(1), "{bad}");
        assert!(err.contains("line 2") && err.contains(word), "{bad}: {err}");
    }
}

#[test]
fn compare_measures_pictures() {
    let dir = folder(LIT);
    assert_eq!(run(dir.path(), &["render", "scene.bhs", "--quiet", "-o", "a.exr"]).0, 0);
    assert_eq!(run(dir.path(), &["render", "scene.bhs", "--quiet", "--seed", "9", "-o", "b.exr"]).0, 0);
    let json = |a: &str, b: &str| -> serde_json::Value {
        let (code, out, err) = run(dir.path(), &["compare", a, b, "--json"]);
        assert_eq!(code, 0, "{err}");
        serde_json::from_str(&out).expect("JSON")
    };
    assert_eq!(json("a.exr", "a.exr")["mse"], 0.0);
    assert!(json("a.exr", "b.exr")["mse"].as_f64().is_some_and(|m| m > 0.0));
    assert!(run(dir.path(), &["compare", "a.exr", "b.exr"]).1.contains("PSNR"));
    assert_eq!(run(dir.path(), &["compare", "a.exr", "none.exr"]).0, 1);
    assert_eq!(run(dir.path(), &["compare", "a.exr", "scene.bhs"]).0, 1);
}

#[test]
fn plugins_are_listed_with_their_parameters() {
    let dir = folder(LIT);
    let (code, out, _) = run(dir.path(), &["plugins"]);
    assert_eq!(code, 0);
    for name in ["straight", "rk4", "hemisphere", "path", "conductor", "plymesh", "embree", "reference", "sobol"] {
        assert!(out.contains(name), "{name} is missing:\n{out}");
    }
    let (code, out, _) = run(dir.path(), &["plugins", "integrator", "schwarzschild-rk4"]);
    assert_eq!(code, 0);
    for word in ["step", "float", "0.1", "rad"] {
        assert!(out.contains(word), "{word} is missing:\n{out}");
    }
    assert_eq!(run(dir.path(), &["plugins", "integrator", "cheese"]).0, 2);
}

#[test]
fn check_builds_without_rendering() {
    let dir = folder(LIT);
    assert_eq!(run(dir.path(), &["check", "scene.bhs"]).0, 0);
    assert!(!dir.path().join("small.exr").exists());
    write(dir.path(), "scene.bhs", format!("{SMALL}Shape \"sphere\" \"float radios\" 1\nShpe \"sphere\""));
    let (code, _, err) = run(dir.path(), &["check", "scene.bhs"]);
    assert_eq!(code, 1);
    // Both faults at once, each with a suggestion.
    assert!(err.contains("`radius`") && err.contains("`Shape`"), "{err}");
}

#[test]
fn connected_points_are_where_their_rays_lead() {
    // A wall at z = 3 behind a hole, and a screen that hides one half of it from below.
    let dir = folder("");
    write(
        dir.path(),
        "scene.bhs",
        format!(
            "LookAt 0 0 -5 0 0 0 0 1 0 {SMALL}BlackHole \"schwarzschild\" \"float rs\" 0.1\n\
            Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-9 -9 3  9 -9 3  9 9 3  -9 9 3]\n\
            Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3] \"point3 P\" [-9 -9 2  9 -9 2  9 0.3 2  -9 0.3 2]"
        ),
    );
    let run =
        |args: &[&str], input: &str| bhs().current_dir(dir.path()).args(args).write_stdin(input).output().expect("bhs starts");
    let lines = |output: std::process::Output| -> Vec<serde_json::Value> {
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8_lossy(&output.stdout).lines().map(|l| serde_json::from_str(l).expect("JSON")).collect()
    };
    let vector = |v: &serde_json::Value| -> Vec<f64> {
        v.as_array().expect("a vector").iter().map(|x| x.as_f64().expect("a number")).collect()
    };

    let pairs = "# from the camera to the wall\n0.1,0.2,-5,0.3,0.4,3\n0,0,-5,0,-2,3\n";
    let answers = lines(run(&["trace", "scene.bhs", "--connect", "-"], pairs));
    assert_eq!(answers.len(), 2);
    let images = answers[0]["connections"].as_array().expect("a list");
    assert_eq!(images.len(), 2);
    for (image, c) in images.iter().enumerate() {
        assert_eq!((c["image"].as_u64(), c["blocked"].as_bool()), (Some(image as u64), Some(image == 1)), "{c}");
        let d = vector(&c["launch"]);
        // The light that goes round below does not: followed back from the wall, it ends at the screen.
        let back = vector(&c["arrival"]);
        let ray = if image == 0 {
            format!("0.1,0.2,-5,{},{},{}\n", d[0], d[1], d[2])
        } else {
            format!("0.3,0.4,2.9999,{},{},{}\n", -back[0], -back[1], -back[2])
        };
        let hit = &lines(run(&["trace", "scene.bhs", "--rays", "-", "--integrator", "schwarzschild-exact"], &ray))[0];
        let point = vector(&hit["point"]);
        if image == 0 {
            assert!((point[0] - 0.3).hypot(point[1] - 0.4) < 1e-9 && (point[2] - 3.0).abs() < 1e-9, "{hit}");
        } else {
            assert!((point[2] - 2.0).abs() < 1e-9 && point[1] < 0.3, "stopped by the screen: {hit}");
        }
    }
    // Behind the screen.
    assert_eq!(answers[1]["connections"][0]["blocked"], true);

    for (bad, word) in [("1,2,3,1,2,3", "the same"), ("1,2", "6 numbers")] {
        let out = run(&["trace", "scene.bhs", "--connect", "-"], bad);
        assert_eq!(out.status.code(), Some(1));
        assert!(String::from_utf8_lossy(&out.stderr).contains(word), "{}", String::from_utf8_lossy(&out.stderr));
    }
    assert_eq!(run(&["trace", "scene.bhs"], "").status.code(), Some(2));
    assert_eq!(run(&["trace", "scene.bhs", "--rays", "-", "--connect", "-"], "").status.code(), Some(2));
}

#[test]
fn bench_measures_integrators_and_transports() {
    let dir = folder("");
    let hole = "BlackHole \"schwarzschild\" \"float rs\" 0.1";
    let lamp = "AreaLightSource \"diffuse\" \"bool twosided\" true\nTranslate 0 1 3\nShape \"sphere\"";
    write(
        dir.path(),
        "scene.bhs",
        format!("LookAt 0 0 -5 0 0 0 0 1 0 {SMALL}{hole}\nShape \"sphere\" \"float radius\" 0.5\n{lamp}"),
    );
    let small = ["--rays", "200", "--rounds", "1", "--resolution", "6x4"];
    let (code, out, err) = run(dir.path(), &[&["bench", "scene.bhs", "--json", "-o", "out"], &small[..]].concat());
    assert_eq!(code, 0, "{err}");
    let measured: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    let rows = |name: &str| measured["tables"][name].as_array().map(Vec::len);
    assert_eq!((rows("camera_rays"), rows("transports")), (Some(30), Some(21)), "{out}");
    let camera = measured["tables"]["camera_rays"].as_array().expect("rows");
    let error = |integrator: &str, setting: &str| {
        let row = camera.iter().find(|r| r["integrator"] == integrator && r["setting"] == setting);
        row.and_then(|r| r["p99"].as_f64()).unwrap_or_else(|| panic!("{integrator} {setting}: {camera:?}"))
    };
    assert!(error("rk4", "0.2 rad") > 10.0 * error("rk4", "0.05 rad"));
    assert!(error("exact", "1e-4 diagonal") < 1e-12);
    // The method of the paper is of second order, ours of fourth.
    assert!(error("micro-steps (paper)", "0.05 rad") > 10.0 * error("rk4", "0.05 rad"));
    let equal = measured["tables"]["camera_rays_at_equal_error"].as_array().expect("rows");
    assert!(equal.len() == 3 && equal.iter().all(|row| row["micro-steps (paper) / adaptive"].as_f64() > Some(0.0)), "{out}");
    for file in [
        "camera_rays.csv",
        "camera_rays_at_equal_error.csv",
        "camera_rays.svg",
        "bounce_rays.csv",
        "transports.csv",
        "transports_at_equal_error.csv",
        "transports.svg",
    ] {
        assert!(dir.path().join("out").join(file).exists(), "{file}");
    }
    // Several scenes have folders of their own.
    std::fs::copy(dir.path().join("scene.bhs"), dir.path().join("other.bhs")).expect("copied");
    let several = ["bench", "scene.bhs", "other.bhs", "--only", "transports", "--json", "-o", "both"];
    let (code, out, err) = run(dir.path(), &[&several, &small[..]].concat());
    let all: serde_json::Value = serde_json::from_str(&out).expect("JSON");
    assert!(code == 0 && all.as_array().is_some_and(|all| all.len() == 2), "{out}{err}");
    assert!(["scene", "other"].iter().all(|name| dir.path().join("both").join(name).join("transports.csv").exists()));
    let (code, _, err) = run(dir.path(), &["bench", "-"]);
    assert_eq!((code, err.contains("needs a file")), (2, true), "{err}");
}
