//! `bhs trace`: single rays, or pairs of points to connect, in; one line of JSON or CSV each out. For people and for checks from outside.

use crate::job::Job;
use anyhow::{Context, Result, bail};
use bhs_core::spacetime::Side;
use bhs_engine::connections::Connections;
use bhs_engine::scene::Scene;
use columns::{Columns, Fault, Field, numbers, optional};
use glam::DVec3;
use rayon::prelude::*;
use std::fmt::Write as _;
use std::io::{BufRead, Read, Write};

mod answer;
mod columns;
pub mod followed;

use answer::{COLUMNS, PATH_COLUMNS, push_vector};
use followed::{Asked, Joined, joined};

/// Rays that are read, traced in parallel and written together.
const BATCH: usize = 4096;

/// The same where answers have the points of the way, of which a ray may have very many.
const BATCH_OF_PATHS: usize = 64;

/// Parts of a batch that threads take one after the other: the rays of one are followed together.
const PARTS: usize = 128;

/// The longest line that is read (bytes).
const LONGEST_LINE: u64 = 1 << 16;

/// How answers are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Format {
    /// One JSON object a line.
    #[default]
    Json,
    /// Comma-separated values under a line that names the columns; with the points of ways, one line a point.
    Csv,
}

/// What is said of rays.
#[derive(Clone, Copy)]
pub struct Answers<'a> {
    /// Through which they are followed.
    pub scene: &'a Scene,
    /// What shapes are called, by number of the `Shape` directive; those that are not there have no name.
    pub shape_names: &'a [String],
    /// Where they stand in the text, likewise: file, line and column.
    pub shape_places: &'a [String],
    /// Whether the points of their ways are told.
    pub with_path: bool,
    /// How it is written.
    pub format: Format,
}

impl<'a> Answers<'a> {
    /// Their ends, as JSON.
    pub fn new(scene: &'a Scene) -> Self {
        Self { scene, shape_names: &[], shape_places: &[], with_path: false, format: Format::Json }
    }

    fn header(&self) -> &'static str {
        match (self.format, self.with_path) {
            (Format::Json, _) => "",
            (Format::Csv, false) => COLUMNS,
            (Format::Csv, true) => PATH_COLUMNS,
        }
    }
}

/// Reads rays (world coordinates, chart directions of any length) from `rays`, one a line, follows each through the scene and writes what becomes of it,
/// in input order. Columns are `ox,oy,oz,dx,dy,dz`; a line that names them may have them in another order, and `side` and `footprint` (scene units)
/// beside them. Empty lines and lines that begin with `#` are passed over. What is said of a camera ray is what its picture sees, if origin, direction
/// and footprint are those of the ray to the bit.
///
/// # Errors
/// If a line cannot be read as a ray (the ones before it are answered), or `out` cannot be written.
pub fn trace(answers: &Answers, rays: impl BufRead, out: &mut impl Write) -> Result<()> {
    let batch = if answers.with_path { BATCH_OF_PATHS } else { BATCH };
    let mut columns = Columns::new(&["ox", "oy", "oz", "dx", "dy", "dz"], &["side", "footprint"]);
    let parse = |line: &str| columns.read(line)?.map(|fields| parse_ray(&fields)).transpose();
    out.write_all(answers.header().as_bytes())?;
    answer_lines(rays, batch, parse, |rays, first| answers.answer(rays, first), out)
}

/// Follows the rays through the centres of `pixels` of the camera of `job` and writes what becomes of each, in their order. Their light is measured by
/// that camera, moving or not.
///
/// # Errors
/// If `out` cannot be written.
pub fn trace_pixels(answers: &Answers, job: &Job, pixels: &[[u32; 2]], out: &mut impl Write) -> Result<()> {
    out.write_all(answers.header().as_bytes())?;
    for (number, pixel) in (0..).zip(pixels) {
        for answer in answers.answer(&[Asked::pixel(job, *pixel)], number) {
            out.write_all(answer.as_bytes())?;
        }
    }
    Ok(out.flush()?)
}

/// Reads pairs of points `x1,y1,z1,x2,y2,z2` (world coordinates; a line may name these columns in another order) from `pairs`, one a line, and writes the
/// geodesics that lead from the first to the second, one line of JSON a pair, in input order: those that the scene's integrator samples lights along.
///
/// # Errors
/// As [`trace`]; and if the integrator cannot connect points.
pub fn connect(scene: &Scene, pairs: impl BufRead, out: &mut impl Write) -> Result<()> {
    let Some(connections) = scene.integrator.connections() else { bail!("the integrator cannot connect points") };
    let mut columns = Columns::new(&["x1", "y1", "z1", "x2", "y2", "z2"], &[]);
    let parse = |line: &str| columns.read(line)?.map(|fields| parse_pair(&fields)).transpose();
    let answer = |pairs: &[[DVec3; 2]], _| pairs.iter().map(|pair| connection_answer(scene, connections, pair)).collect();
    answer_lines(pairs, BATCH, parse, answer, out)
}

/// The next line, without its end; `None` behind the last one.
fn next_line(from: &mut impl BufRead) -> Result<Option<String>> {
    let mut line = Vec::new();
    from.take(LONGEST_LINE).read_until(b'\n', &mut line).context("it cannot be read")?;
    if line.is_empty() {
        return Ok(None);
    }
    if line.last() != Some(&b'\n') && line.len() as u64 == LONGEST_LINE {
        bail!("it is longer than {LONGEST_LINE} bytes");
    }
    Ok(Some(String::from_utf8(line).context("it is not text")?))
}

/// Reads `lines`, answers `batch` of them at a time in parallel and writes the answers in their order. `answer` is given some that follow one another, and
/// told which one the first of them is.
fn answer_lines<T: Sync + Send>(
    mut lines: impl BufRead,
    batch: usize,
    mut parse: impl FnMut(&str) -> Result<Option<T>, Fault>,
    answer: impl Fn(&[T], u64) -> Vec<String> + Sync,
    out: &mut impl Write,
) -> Result<()> {
    let (mut number, mut answered) = (0_u64, 0_u64);
    loop {
        let mut asked = Vec::with_capacity(batch);
        let mut fault = None;
        while fault.is_none() && asked.len() < batch {
            number += 1;
            match next_line(&mut lines) {
                Ok(Some(line)) => match parse(&line) {
                    Ok(found) => asked.extend(found),
                    Err(found) => {
                        let column = found.column.map(|column| format!(", column {column}")).unwrap_or_default();
                        fault = Some(anyhow::anyhow!("{found}").context(format!("line {number}{column}")));
                    }
                },
                Ok(None) => break,
                Err(error) => fault = Some(error.context(format!("line {number}"))),
            }
        }
        let together = batch.div_ceil(PARTS);
        let answer = |(i, asked): (usize, &[T])| answer(asked, answered + (i * together) as u64);
        let answers: Vec<String> = asked.par_chunks(together).enumerate().flat_map_iter(answer).collect();
        answered += answers.len() as u64;
        for answer in &answers {
            out.write_all(answer.as_bytes())?;
        }
        match fault {
            Some(error) => return Err(error),
            None if answers.len() < batch => return Ok(out.flush()?),
            None => {}
        }
    }
}

fn parse_ray(fields: &[Field]) -> Result<Asked, Fault> {
    let origin = DVec3::from(numbers(fields, ["ox", "oy", "oz"])?);
    let direction = DVec3::from(numbers(fields, ["dx", "dy", "dz"])?);
    let side = match optional(fields, "side") {
        None => Side::Near,
        Some(field) => match field.text {
            "near" => Side::Near,
            "far" => Side::Far,
            other => return Err(field.fault(format!("`{other}` is no side: near or far"))),
        },
    };
    let footprint = match optional(fields, "footprint") {
        None => 0.0,
        Some(field) => field
            .number()
            .ok()
            .filter(|width| *width >= 0.0)
            .ok_or_else(|| field.fault(format!("`{}` is no footprint: a length, or 0 if it is unknown", field.text)))?,
    };
    Asked::ray(origin, direction, side, footprint).map_err(Fault::whole)
}

fn parse_pair(fields: &[Field]) -> Result<[DVec3; 2], Fault> {
    let x = DVec3::from(numbers(fields, ["x1", "y1", "z1"])?);
    let y = DVec3::from(numbers(fields, ["x2", "y2", "z2"])?);
    if x == y { Err(Fault::whole("the two points are the same")) } else { Ok([x, y]) }
}

/// All connections of a pair, as one JSON object and a line end.
fn connection_answer(scene: &Scene, connections: &dyn Connections, pair: &[DVec3; 2]) -> String {
    let mut json = String::from("{\"connections\":[");
    for Joined { image, connection, is_blocked } in joined(scene, connections, *pair) {
        if !json.ends_with('[') {
            json.push(',');
        }
        let _ = write!(json, "{{\"image\":{image},\"phi\":{:.16e},\"launch\":", connection.phi);
        push_vector(&mut json, connection.launch);
        json += ",\"arrival\":";
        push_vector(&mut json, connection.arrival);
        let _ = write!(json, ",\"spread\":{:.16e},\"blocked\":{is_blocked}}}", connection.spread);
    }
    json += "]}\n";
    json
}
