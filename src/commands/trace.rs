//! `bhs trace`: rays of a file, of a camera, and between points.

use super::replay::look_through;
use super::{Common, ExitStatus, load_labelled, overrides};
use crate::cli::{PictureArgs, TraceArgs};
use crate::lang::Overrides;
use crate::render::Job;
use crate::say;
use crate::trace::{Answers, Format, connect, trace as trace_rays, trace_pixels};
use anyhow::{Context, Result};
use std::io::{BufRead, BufReader, BufWriter};
use std::path::Path;

/// `bhs trace`
///
/// # Errors
/// If the rays cannot be read.
pub fn trace(args: &TraceArgs, common: &Common) -> Result<ExitStatus> {
    let input = args.rays.as_ref().or(args.connect.as_ref());
    if input.is_some_and(|input| input == Path::new("-")) && args.scene == Path::new("-") {
        let what = if args.rays.is_some() { "rays" } else { "pairs" };
        say!("error: the scene and its {what} cannot both come from standard input");
        return Ok(ExitStatus::CommandLine);
    }
    let overrides = Overrides {
        without_camera: args.pixel.is_empty(),
        camera: args.camera.clone(),
        resolution: args.resolution,
        ..overrides(&args.scene_args, &PictureArgs::default())
    };
    let Some((mut built, labels, _)) = load_labelled(&args.scene, &overrides, common) else { return Ok(ExitStatus::Fault) };
    let mut out = BufWriter::new(std::io::stdout().lock());
    if !args.pixel.is_empty()
        && let Err(why) = look_through(&mut built, &args.pixel)
    {
        say!("error: {why}");
        return Ok(ExitStatus::CommandLine);
    }
    let shape_names: Vec<String> = labels.shape_plugins().map(str::to_owned).collect();
    let shape_places = built.statements.shape_places();
    let format = if args.format == "csv" { Format::Csv } else { Format::Json };
    let answers =
        Answers { scene: &built.scene, shape_names: &shape_names, shape_places: &shape_places, with_path: args.path, format };
    // One of the three is given: the command line sees to it.
    let Some(input) = input else {
        trace_pixels(&answers, &Job::of(&built), &args.pixel, &mut out)?;
        return Ok(ExitStatus::Done);
    };
    let mut answer = |lines: &mut dyn BufRead| match args.connect {
        Some(_) => connect(&built.scene, lines, &mut out),
        None => trace_rays(&answers, lines, &mut out),
    };
    if input == Path::new("-") {
        answer(&mut std::io::stdin().lock()).context("standard input")?;
    } else {
        let name = input.display();
        answer(&mut BufReader::new(common.open(input)?)).with_context(|| format!("`{name}`"))?;
    }
    Ok(ExitStatus::Done)
}
