//! `bhs render SCENE --pixel X,Y --sample N`: one sample of a picture once more, as JSON.

use super::{Common, ExitStatus, load_labelled, print};
use crate::cli::RenderArgs;
use crate::lang::{BuiltScene, Overrides};
use crate::not_finite::SampleId;
use crate::render::Job;
use crate::replay::Replay;
use crate::say;
use anyhow::Result;
use std::borrow::Cow;

/// Which of the pictures of a command a sample is of.
#[derive(Clone, Copy, Default)]
pub(super) struct PictureId<'a> {
    /// Name of its camera.
    pub camera: Option<&'a str>,
    /// The variables of its scene that come from outside.
    pub variables: &'a [(String, f64)],
    /// Its seed, if it is not the scene's.
    pub seed: Option<u64>,
}

/// The command that replays a sample of one of the pictures that `args` describe.
pub(super) fn command(args: &RenderArgs, common: &Common, picture: PictureId, id: &SampleId) -> String {
    let mut words = vec!["bhs render".to_owned(), quoted(&args.scene.to_string_lossy()).into_owned()];
    let mut flag = |name: &str, value: Option<String>| {
        if let Some(value) = value {
            words.push(format!("--{name} {}", quoted(&value)));
        }
    };
    let SampleId { pixel: [x, y], sample } = id;
    flag("pixel", Some(format!("{x},{y}")));
    flag("sample", Some(sample.to_string()));
    // Whatever changes what a sample finds.
    for file in &common.include {
        flag("include", Some(file.to_string_lossy().into_owned()));
    }
    flag("camera", picture.camera.map(str::to_owned));
    flag("seed", picture.seed.map(|n| n.to_string()));
    for (name, value) in picture.variables {
        flag("define", Some(format!("{name}={value}")));
    }
    flag("integrator", args.scene_args.integrator.clone());
    flag("transport", args.picture.transport.clone());
    flag("spp", args.picture.spp.map(|n| n.to_string()));
    flag("resolution", args.picture.resolution.map(|[w, h]| format!("{w}x{h}")));
    flag("crop", args.picture.crop.map(|c| c.map(|f| f.to_string()).join(",")));
    let switches = [("--quick", args.quick), ("--pbrt", common.pbrt)];
    words.extend(switches.iter().filter(|(_, is_given)| *is_given).map(|(switch, _)| (*switch).to_owned()));
    words.join(" ")
}

/// A word as a shell reads it back.
fn quoted(word: &str) -> Cow<'_, str> {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,:=+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return Cow::Borrowed(word);
    }
    Cow::Owned(format!("'{}'", word.replace('\'', "'\\''")))
}

/// Follows the sample `id` and prints what becomes of it.
///
/// # Errors
/// If standard output cannot be written.
pub(super) fn replay(args: &RenderArgs, overrides: &Overrides, id: SampleId, common: &Common) -> Result<ExitStatus> {
    let Some((mut built, labels, sources)) = load_labelled(&args.scene, overrides, common) else { return Ok(ExitStatus::Fault) };
    if let Err(why) = look_through(&mut built, &[id.pixel]) {
        say!("error: {why}");
        return Ok(ExitStatus::CommandLine);
    }
    let replayed = Replay::new(Job::of(&built)).follow(id);
    print(&replayed.to_text(&built, &labels, &sources))?;
    Ok(ExitStatus::Done)
}

/// Looks through the only camera, or the one without a name, whose picture has these pixels.
///
/// # Errors
/// What is wrong with the command line, if there is no such camera or pixel.
pub(super) fn look_through(built: &mut BuiltScene, pixels: &[[u32; 2]]) -> Result<(), String> {
    let [width, height] = built.film.resolution();
    if let Some([x, y]) = pixels.iter().find(|[x, y]| *x >= width || *y >= height) {
        return Err(format!("--pixel {x},{y}: the picture has {width} columns and {height} rows"));
    }
    if choose_camera(built) {
        return Ok(());
    }
    let names: Vec<&str> = built.camera_names().flatten().collect();
    Err(format!("--pixel needs `--camera NAME`: the scene has {}", names.join(", ")))
}

/// Looks through the only camera, or through the one without a name; false if there is neither.
fn choose_camera(built: &mut BuiltScene) -> bool {
    if built.camera_names().count() == 1 {
        return true;
    }
    if built.camera_names().all(|name| name.is_some()) {
        return false;
    }
    while built.camera_name.is_some() {
        built.next_camera();
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cli::{Cli, Command};
    use clap::Parser;

    #[test]
    fn the_command_says_all_that_changes_a_sample_and_can_be_read_back() {
        let parse = |words: &[&str]| {
            let cli = Cli::try_parse_from(words).expect("a command line");
            let common = Common::of(&cli).expect("no root");
            match cli.command {
                Command::Render(args) => (args.each().next().expect("a scene"), common),
                other => panic!("{other:?}"),
            }
        };
        let words = "bhs render room.bhs --pbrt --include hole.bhs --seed 9 --integrator straight --transport path --spp 4 --resolution 8x6 --crop 0,0.5,0,1 --quick \
                     --quiet --threads 2 --aov depth -o x.exr";
        let (args, common) = parse(&words.split_whitespace().collect::<Vec<_>>());
        let id = SampleId { pixel: [3, 5], sample: 7 };
        let variables = [("x".to_owned(), -0.1)];
        let said =
            command(&args, &common, PictureId { camera: Some("left"), variables: &variables, seed: args.scene_args.seed }, &id);
        assert_eq!(
            said,
            "bhs render room.bhs --pixel 3,5 --sample 7 --include hole.bhs --camera left --seed 9 --define x=-0.1 --integrator straight \
             --transport path --spp 4 --resolution 8x6 --crop 0,0.5,0,1 --quick --pbrt"
        );
        let (again, common) = parse(&said.split_whitespace().collect::<Vec<_>>());
        assert_eq!((again.pixel, again.sample, again.camera.as_deref()), (Some([3, 5]), Some(7), Some("left")));
        assert_eq!(again.scene_args.definitions.define, variables);
        assert!(common.pbrt && common.include == [std::path::Path::new("hole.bhs")]);
        assert_eq!(quoted("it's a room.bhs"), r"'it'\''s a room.bhs'");
    }
}
