//! Several scenes in one call, and what the program says of itself.

use crate::common::program::{Folder, Outcome, SMALL};
use serde_json::Value;

/// A folder with the scenes `a.bhs`, `b.bhs` and `faulty.bhs`, whose pictures are called after them.
fn folder() -> Folder {
    let folder = Folder::new(SMALL);
    let unnamed = SMALL.replace("\"string filename\" \"small.exr\"", "");
    folder.write("a.bhs", &unnamed);
    folder.write(
        "b.bhs",
        unnamed.replace("Camera \"perspective\"", "Camera \"perspective\"\nCamera \"perspective\" \"string name\" \"left\""),
    );
    folder.write("faulty.bhs", format!("{unnamed}Shape \"spheer\"\n"));
    folder
}

/// The names of the pictures.
fn pictures(folder: &Folder) -> Vec<String> {
    folder.files().into_iter().filter(|name| name.ends_with(".exr")).collect()
}

#[test]
fn scenes_are_rendered_one_after_the_other() {
    let folder = folder();
    let run = folder.run(&["render", "a.bhs", "faulty.bhs", "b.bhs", "nothing.bhs", "scene.bhs"]);
    assert_eq!((run.code, run.out.as_str()), (1, ""), "{}", run.err);
    assert_eq!(pictures(&folder), ["a.exr", "b.exr", "b.left.exr", "small.exr"]);
    assert!(
        run.err.contains("spheer") && run.err.contains("nothing.bhs") && run.err.matches("2 spp in").count() == 4,
        "{}",
        run.err
    );
    let alone = folder.read("a.png");
    assert_eq!(
        folder.run(&["render", "a.bhs", "scene.bhs", "--quiet"]),
        Outcome { code: 0, out: String::new(), err: String::new() }
    );
    assert_eq!(folder.read("a.png"), alone);

    let run = folder.run(&["render", "a.bhs", "faulty.bhs", "b.bhs", "--progress", "json", "--quiet"]);
    let events: Vec<Value> = run.err.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    let named = |name: &str| events.iter().filter(|e| e["event"] == name).count();
    assert_eq!(["start", "scene", "picture", "end"].map(named), [1, 3, 3, 1], "{}", run.err);
    let end = &events[events.len() - 1];
    assert!(end["event"] == "end" && end["status"] == "failed" && end["exit_code"] == 1, "{end}");
    let percent: Vec<f64> = events.iter().filter_map(|e| e["percent"].as_f64()).collect();
    assert!(percent.is_sorted() && percent.last() == Some(&100.0), "{percent:?}");
}

#[test]
fn what_several_scenes_cannot_share_is_refused() {
    let folder = folder();
    for (flags, word) in [
        (&["-o", "x.exr"][..], "-o names one file"),
        (&["--stats", "x.json"], "--stats names one file"),
        (&["--checkpoint=x"], "--checkpoint=FILE names one file"),
        (&["--frames", "1-2", "--preview", "x.gif"], "--preview names one file"),
        (&["--pixel", "1,1", "--sample", "0"], "--pixel replays"),
        (&["-", "-"], "standard input"),
    ] {
        let run = folder.run(&[&["render", "a.bhs", "scene.bhs"], flags].concat());
        assert!(run.code == 2 && run.err.contains(word), "{flags:?}: {}", run.err);
    }
    // Pictures that would be one file, by whatever names.
    folder.write("again.bhs", SMALL.replace("small.exr", "./small.exr"));
    folder.write("left.bhs", SMALL.replace("small.exr", "b.left.exr"));
    for scenes in [["scene.bhs", "scene.bhs"], ["scene.bhs", "again.bhs"], ["b.bhs", "left.bhs"]] {
        for flags in [&[][..], &["--quick"], &["--frames", "1-2"]] {
            let run = folder.run(&[&["render", "a.bhs"], &scenes[..], flags].concat());
            assert!(
                run.code == 1 && run.err.contains("one file") && run.err.contains("nothing has been rendered"),
                "{}",
                run.err
            );
        }
    }
    assert_eq!(pictures(&folder), [""; 0]);
    // Another camera, another file.
    assert_eq!(folder.run(&["render", "b.bhs", "scene.bhs", "--camera", "left", "--quiet"]).code, 1);
    assert_eq!(pictures(&folder), ["b.left.exr"]);
}

#[test]
fn no_scene_writes_what_another_one_reads_or_writes() {
    let folder = folder();
    let film = |name: &str, more: &str| {
        SMALL.replace("\"string filename\" \"small.exr\"", &format!("\"string filename\" \"{name}\" {more}"))
    };
    let layers = "\"string layers\" \"normal\"";
    folder.write("layers.bhs", film("x.exr", layers));
    folder.write("of_layer.bhs", film("./x.normal.exr", layers));
    let reads = |file: &str| {
        let texture = format!("Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"{file}\"");
        let shape = "Material \"diffuse\" \"texture reflectance\" \"t\"\nShape \"sphere\"";
        film("reader.exr", "").replace("Shape \"sphere\"", &format!("{texture}\n{shape}"))
    };
    folder.write("reads_picture.bhs", reads("small.png"));
    folder.write("reads_frame.bhs", reads("small.0002.png"));
    folder.write("reads_text.bhs", film("reader.exr", "").replace("Shape", "Include \"small.exr\"\nShape"));
    folder.write("small.exr", "# A text.\n");
    for name in ["small.png", "small.0002.png"] {
        image::RgbImage::from_pixel(2, 2, image::Rgb([9; 3])).save(folder.at(name)).expect("a PNG");
    }
    std::fs::hard_link(folder.at("small.png"), folder.at("hard.png")).expect("links can be made");
    folder.write("reads_link.bhs", reads("hard.png"));
    let before = folder.contents();
    for (scenes, flags) in [
        (["layers.bhs", "of_layer.bhs"], &["--false-color"][..]),
        (["scene.bhs", "reads_picture.bhs"], &[]),
        (["reads_picture.bhs", "scene.bhs"], &[]),
        (["scene.bhs", "reads_link.bhs"], &[]),
        (["scene.bhs", "reads_text.bhs"], &[]),
        (["scene.bhs", "reads_frame.bhs"], &["--frames", "1-2"]),
    ] {
        let run = folder.run(&[&["render", "a.bhs"], &scenes[..], flags].concat());
        let said = run.err.contains("one file") || run.err.contains("reads it as");
        assert!(run.code == 1 && said && run.err.contains("nothing has been rendered"), "{scenes:?}: {}", run.err);
        assert!(folder.contents() == before, "{scenes:?}");
    }
    // What is read from standard input is looked at when it has its turn, and harms nothing.
    let run = folder.shell("\"$BHS\" render layers.bhs - --quiet < layers.bhs");
    assert!(run.code == 1 && run.err.contains("one file") && run.err.contains("`layers.bhs` of this call"), "{}", run.err);
    // Scenes that share nothing, by the same names or others.
    assert_eq!(folder.run(&["render", "layers.bhs", "of_layer.bhs", "reads_picture.bhs", "--quiet"]).code, 0);
}

#[test]
fn several_scenes_are_checked() {
    let folder = folder();
    let run = folder.run(&["check", "a.bhs", "b.bhs"]);
    assert_eq!((run.code, run.err.matches("no errors").count()), (0, 2), "{}", run.err);
    let run = folder.run(&["check", "faulty.bhs", "a.bhs", "--json"]);
    let found: Vec<Value> = run.out.lines().map(|line| serde_json::from_str(line).expect("JSON")).collect();
    assert!(run.code == 1 && found.iter().any(|f| f["file"] == "faulty.bhs" && f["severity"] == "error"), "{}", run.out);
    assert_eq!(folder.run(&["check", "-", "-"]).code, 2);
}

#[test]
fn stats_are_printed_line_by_line() {
    let folder = folder();
    let run = folder.run(&["render", "b.bhs", "scene.bhs", "--stats", "-", "--quiet"]);
    assert_eq!((run.code, run.err.as_str()), (0, ""));
    let all: Vec<Value> = run.out.lines().map(|line| serde_json::from_str(line).expect("an object a line")).collect();
    assert_eq!(all.iter().map(|stats| &stats["camera"]).collect::<Vec<_>>(), [&Value::Null, &"left".into(), &Value::Null]);
    assert!(all.iter().all(|stats| stats["counts"]["paths"] == 128 && stats["seconds"]["write"].is_number()));
    assert!(!folder.files().iter().any(|name| name == "-"), "{:?}", folder.files());
    // Of a picture that is finished already, too.
    for _ in 0..2 {
        let run = folder.run(&["render", "scene.bhs", "--resume", "--stats", "-", "--quiet"]);
        assert_eq!((run.code, run.out.lines().count()), (0, 1));
    }
}

#[test]
#[cfg(unix)]
fn who_does_not_read_the_stats_keeps_no_picture_from_being_made() {
    let folder = folder();
    let (reader, writer) = std::io::pipe().expect("a pipe");
    drop(reader);
    let run = folder.command(&["render", "a.bhs", "b.bhs", "--stats", "-"]).stdout(writer).output().expect("it starts");
    assert_eq!(run.status.code(), Some(0));
    assert_eq!(pictures(&folder), ["a.exr", "b.exr", "b.left.exr"]);
}

#[test]
#[cfg(target_os = "linux")]
fn stats_that_cannot_be_printed_are_an_error_and_the_pictures_are_made() {
    let folder = folder();
    let full = std::fs::File::options().write(true).open("/dev/full").expect("Linux has it");
    let run = folder.command(&["render", "a.bhs", "b.bhs", "--stats", "-"]).stdout(full).output().expect("it starts");
    assert!(run.status.code() == Some(1) && String::from_utf8_lossy(&run.stderr).contains("No space left"));
    assert_eq!(pictures(&folder), ["a.exr", "b.exr", "b.left.exr"]);
}

#[test]
fn the_program_says_what_it_is() {
    let folder = Folder::new(SMALL);
    let version = folder.run(&["--version"]);
    assert_eq!((version.code, version.out.as_str()), (0, concat!("bhs ", env!("CARGO_PKG_VERSION"), "\n")));
    for args in [["--version", "--verbose"], ["--verbose", "--version"]] {
        let run = folder.run(&args);
        let mut lines = run.out.lines();
        assert_eq!((run.code, lines.next()), (0, version.out.lines().next()), "{}", run.err);
        let rest: Vec<(&str, &str)> = lines.map(|line| line.split_once(": ").expect("a name and what it is")).collect();
        let names: Vec<&str> = rest.iter().map(|(name, _)| *name).collect();
        assert_eq!(names, ["commit", "date", "Embree", "vector code", "denoiser"]);
        let commit = rest[0].1;
        assert!(commit == "unknown" || commit.len() == 40 && commit.chars().all(|c| c.is_ascii_hexdigit()), "{commit}");
        assert_eq!(rest[1].1 == "unknown", commit == "unknown");
        assert!(rest[2].1.starts_with("4."), "{}", rest[2].1);
    }
    // Built for one kind of processor: there is nothing else to hand over to.
    let own = bhs::vectors::own();
    let told = |asked: &str| {
        let output = folder.command(&["--version", "--verbose"]).env("BHS_VECTORS", asked).output().expect("it starts");
        (output.status.code(), String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr))
    };
    let (code, text) = told("");
    assert!(code == Some(0) && text.contains(&format!("({own}): all that this program was built for\n")), "{text}");
    let (code, text) = told(own);
    assert!(code == Some(0) && text.contains(&format!("({own}): BHS_VECTORS asks for it\n")), "{text}");
    assert_eq!(told("mmx"), (Some(1), format!("error: BHS_VECTORS is `mmx`; this bhs has code for {own}\n")));
    assert_eq!(folder.run(&["--verbose"]).code, 2);
    assert_eq!(folder.run(&["--verbose", "check", "scene.bhs"]).code, 2);
}

#[test]
fn every_help_names_the_exit_codes() {
    let folder = Folder::new(SMALL);
    let all = bhs::cli::full_command();
    let commands = all.get_subcommands().map(|command| vec![command.get_name(), "--help"]);
    let of_all: Vec<Vec<&str>> = std::iter::once(vec!["--help"]).chain(commands).collect();
    assert!(of_all.len() > 14, "{of_all:?}");
    for args in of_all {
        let run = folder.run(&args);
        assert!(run.code == 0 && run.out.contains("Exit codes: 0 done") && run.out.contains("130"), "{args:?}: {}", run.out);
    }
}

#[test]
fn completions_and_manual_pages_are_printed() {
    let folder = Folder::new(SMALL);
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let run = folder.run(&["completions", shell]);
        assert!(run.code == 0 && run.out.contains("display-server") && run.out.contains("watch"), "{shell}: {}", run.err);
    }
    assert_eq!(folder.run(&["completions", "cmd"]).code, 2);
    let run = folder.run(&["man"]);
    assert!(run.code == 0 && run.out.contains(".TH bhs 1") && run.out.contains("bhs\\-render"), "{}", run.out);
    let run = folder.run(&["man", "render"]);
    assert!(run.code == 0 && run.out.contains(".TH bhs-render 1") && run.out.contains("display\\-server"), "{}", run.out);
    assert!(run.out.contains("Exit codes"), "{}", run.out);
    let run = folder.run(&["man", "cheese"]);
    assert!(run.code == 2 && run.err.contains("render"), "{}", run.err);
}
