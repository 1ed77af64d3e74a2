//! Variables of scenes on the command line: what they change, and what is wrong with them.

use crate::common::program::Folder;

/// A sphere whose size is a variable.
const SCENE: &str = r#"
Define "radius" 0.5
Film "rgb" "integer xresolution" $columns "integer yresolution" 8 "string filename" "small.exr"
Sampler "sobol" "integer pixelsamples" 2
Camera "perspective"
WorldBegin
LightSource "infinite"
Translate 0 0 3
Include "more.bhs"
"#;

fn folder() -> Folder {
    let folder = Folder::new(SCENE);
    folder.write(
        "more.bhs",
        "Material \"diffuse\" \"rgb reflectance\" [0.2 $radius 0.5] Shape \"sphere\" \"float radius\" $radius\n",
    );
    folder
}

#[test]
fn definitions_win_over_the_scene_and_a_picture_is_that_of_the_numbers_written_in() {
    let folder = folder();
    let done = folder.run(&[
        "render",
        "scene.bhs",
        "-D",
        "columns=8",
        "-D",
        "radius=0.1",
        "-Dradius=0.75",
        "-o",
        "given.exr",
        "--quiet",
    ]);
    assert_eq!((done.code, done.err.as_str()), (0, ""));
    folder.write("written.bhs", SCENE.replace("$columns", "8").replace("0.5", "0.75"));
    assert_eq!(folder.run(&["render", "written.bhs", "-o", "written.exr", "--quiet"]).code, 0);
    assert_eq!(folder.read("given.png"), folder.read("written.png"));
    let same = folder.run(&["compare", "given.exr", "written.exr", "--json"]);
    assert!(same.out.contains("\"mse\": 0.0"), "{}", same.out);
    // A smaller sphere is another picture.
    assert_eq!(folder.run(&["render", "scene.bhs", "-D", "columns=8", "-o", "small.exr", "--quiet"]).code, 0);
    assert_ne!(folder.read("given.png"), folder.read("small.png"));
}

#[test]
fn what_is_wrong_with_a_definition_is_said_at_its_place() {
    let folder = folder();
    let check = |words: &[&str]| folder.run(&[&["check", "scene.bhs"], words].concat());
    let missing = check(&[]);
    assert_eq!(missing.code, 1);
    assert!(missing.err.contains("unknown variable `$columns`") && missing.err.contains("scene.bhs:3:34"), "{}", missing.err);
    let typo = check(&["-D", "columns=8", "-D", "radus=2"]);
    assert_eq!(typo.code, 1);
    assert!(typo.err.contains("nothing in the scene reads `$radus`"), "{}", typo.err);
    assert!(typo.err.contains("did you mean `radius`?") && typo.err.contains("<command line>"), "{}", typo.err);
    for (word, said) in [("columns", "such as radius=2.5"), ("columns=x", "`x` is not a number"), ("$columns=8", "without `$`")] {
        let wrong = check(&["-D", word]);
        assert!(wrong.code == 2 && wrong.err.contains(said), "{word}: {}", wrong.err);
    }
    // What is wrong with the value is said where the variable stands.
    let half = check(&["-D", "columns=8.5"]);
    assert!(half.code == 1 && half.err.contains("scene.bhs:3:34") && half.err.contains("$columns"), "{}", half.err);
    // Also in a file that is included.
    let negative = check(&["-D", "columns=8", "-D", "radius=-1"]);
    assert!(negative.code == 1 && negative.err.contains("more.bhs:1:86"), "{}", negative.err);
    assert_eq!(check(&["-D", "columns=8.0"]).code, 0);
    let traced = folder.run(&["trace", "scene.bhs", "--rays", "more.bhs", "-D", "columns=8"]);
    assert!(traced.code == 1 && traced.err.contains("more.bhs"), "{}", traced.err);
}

#[test]
fn format_leaves_variables_alone() {
    let folder = folder();
    let neat = folder.run(&["format", "scene.bhs"]);
    assert_eq!(neat.code, 0, "{}", neat.err);
    for kept in ["Define \"radius\" 0.5", "\"integer xresolution\" $columns"] {
        assert!(neat.out.contains(kept), "{}", neat.out);
    }
    let more = folder.run(&["format", "more.bhs"]);
    assert!(more.out.contains("[0.2 $radius 0.5]"), "{}", more.out);
}
