//! `bhs trace`: single rays, or pairs of points to connect, in; one JSON object a line out. For people and for checks from outside.

use anyhow::{Context, Result, bail};
use bhs_core::ray::{Arrival, Ray};
use bhs_core::spacetime::{Place, Side};
use bhs_engine::connections::{Connections, ShadowRay};
use bhs_engine::scene::Scene;
use glam::DVec3;
use rayon::prelude::*;
use std::fmt::Write as _;
use std::io::{BufRead, Read, Write};

/// Rays that are read, traced in parallel and written together.
const BATCH: usize = 4096;

/// The same where answers have the points of the way, of which a ray may have very many.
const BATCH_OF_PATHS: usize = 64;

/// The longest line that is read (bytes).
const LONGEST_LINE: u64 = 1 << 16;

/// Reads rays `ox,oy,oz,dx,dy,dz` (world coordinates, chart directions of any length) from `rays`, one a line, follows each through `scene` and
/// writes what becomes of it, in input order. Where a first line names the columns, `side` and `footprint` (scene units) may follow these six.
/// Empty lines and lines that begin with `#` are passed over. What is said of a camera ray is what its picture sees, if origin, direction and
/// footprint are those of the ray to the bit.
///
/// # Errors
/// If a line cannot be read as a ray (the ones before it are answered), or `out` cannot be written.
pub fn trace(scene: &Scene, rays: impl BufRead, with_path: bool, out: &mut impl Write) -> Result<()> {
    let batch = if with_path { BATCH_OF_PATHS } else { BATCH };
    let mut columns = Vec::new();
    let parse = |line: &str| match line.trim().strip_prefix(RAY_HEADER) {
        Some(more) => {
            columns = parse_columns(more)?;
            Ok(None)
        }
        None => parse_ray(line, &columns),
    };
    answer_lines(rays, batch, parse, |ray| answer(scene, ray, with_path), out)
}

/// Reads pairs of points `x1,y1,z1,x2,y2,z2` (world coordinates) from `pairs`, one a line, and writes the geodesics that lead from the first
/// to the second, one line of JSON a pair, in input order: those that the scene's integrator samples lights along.
///
/// # Errors
/// As [`trace`]; and if the integrator cannot connect points.
pub fn connect(scene: &Scene, pairs: impl BufRead, out: &mut impl Write) -> Result<()> {
    let Some(connections) = scene.integrator.connections() else { bail!("the integrator cannot connect points") };
    answer_lines(pairs, BATCH, parse_pair, |pair| connection_answer(scene, connections, pair), out)
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

/// Reads `lines`, answers `batch` of them at a time in parallel and writes the answers in their order.
fn answer_lines<T: Sync + Send>(
    mut lines: impl BufRead,
    batch: usize,
    mut parse: impl FnMut(&str) -> Result<Option<T>>,
    answer: impl Fn(&T) -> String + Sync,
    out: &mut impl Write,
) -> Result<()> {
    let mut number = 0_u64;
    loop {
        let mut asked = Vec::with_capacity(batch);
        let mut fault = None;
        while fault.is_none() && asked.len() < batch {
            number += 1;
            let line = match next_line(&mut lines) {
                Ok(Some(line)) => parse(&line),
                Ok(None) => break,
                Err(error) => Err(error),
            };
            match line.with_context(|| format!("line {number}")) {
                Ok(ray) => asked.extend(ray),
                Err(error) => fault = Some(error),
            }
        }
        let answers: Vec<String> = asked.par_iter().map(&answer).collect();
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

/// The columns of a line that is a ray; a line that says so may come first, and name more.
const RAY_HEADER: &str = "ox,oy,oz,dx,dy,dz";

/// A further column.
#[derive(Clone, Copy, PartialEq)]
enum Column {
    Side,
    Footprint,
}

/// The columns that follow the six, each with a comma before it.
fn parse_columns(more: &str) -> Result<Vec<Column>> {
    let mut columns = Vec::new();
    for name in more.split(',').skip(1) {
        let column = match name.trim() {
            "side" => Column::Side,
            "footprint" => Column::Footprint,
            other => bail!("`{other}` is no column: side or footprint"),
        };
        if columns.contains(&column) {
            bail!("two columns are called `{}`", name.trim());
        }
        columns.push(column);
    }
    Ok(columns)
}

fn parse_ray(line: &str, columns: &[Column]) -> Result<Option<Ray>> {
    let (mut line, mut side, mut footprint) = (line.trim(), Side::Near, 0.0);
    for column in columns.iter().rev().filter(|_| !line.is_empty() && !line.starts_with('#')) {
        let Some((before, word)) = line.rsplit_once(',') else { break };
        match (column, word.trim()) {
            (Column::Side, "near" | "") => side = Side::Near,
            (Column::Side, "far") => side = Side::Far,
            (Column::Side, other) => bail!("`{other}` is no side: near or far"),
            (Column::Footprint, "") => footprint = 0.0,
            (Column::Footprint, word) => match word.parse::<f64>() {
                Ok(width) if width >= 0.0 && width.is_finite() => footprint = width,
                _ => bail!("`{word}` is no footprint: a length, or 0 if it is unknown"),
            },
        }
        line = before;
    }
    let Some([origin, direction]) = parse_vectors(line, RAY_HEADER)? else { return Ok(None) };
    let unit = if (direction.length_squared() - 1.0).abs() < UNIT { Some(direction) } else { direction.try_normalize() };
    match unit {
        Some(direction) => Ok(Some(Ray { side, footprint, ..Ray::new(origin, direction) })),
        None => bail!("the direction is zero"),
    }
}

/// A direction whose square is this close to 1 is of length 1 but for rounding, and is taken as it is.
const UNIT: f64 = 4.0 * f64::EPSILON;

fn parse_pair(line: &str) -> Result<Option<[DVec3; 2]>> {
    match parse_vectors(line, "x1,y1,z1,x2,y2,z2")? {
        Some([x, y]) if x == y => bail!("the two points are the same"),
        pair => Ok(pair),
    }
}

/// Two vectors, written as `form`; `None` in an empty line and in a comment.
fn parse_vectors(line: &str, form: &str) -> Result<Option<[DVec3; 2]>> {
    let line = line.trim();
    if line.is_empty() || line.starts_with('#') {
        return Ok(None);
    }
    let numbers: Vec<f64> = line
        .split(',')
        .map(|n| n.trim().parse::<f64>().with_context(|| format!("`{}` is not a number", n.trim())))
        .collect::<Result<_>>()?;
    if numbers.len() != 6 {
        bail!("expected 6 numbers {form}, found {}", numbers.len());
    }
    if let Some(bad) = numbers.iter().find(|n| !n.is_finite()) {
        bail!("`{bad}` is not finite");
    }
    Ok(Some([DVec3::from_slice(&numbers), DVec3::from_slice(&numbers[3..])]))
}

/// All connections of a pair, as one JSON object and a line end.
fn connection_answer(scene: &Scene, connections: &dyn Connections, pair: &[DVec3; 2]) -> String {
    let [x, y] = pair.map(|p| p - scene.world.origin);
    let mut json = String::from("{\"connections\":[");
    for turn in 0..connections.turns() {
        for (side, c) in connections.connect(&scene.world, Place::near(x), Place::near(y), turn).into_iter().enumerate() {
            let Some(c) = c else { continue };
            if !json.ends_with('[') {
                json.push(',');
            }
            // From the very points: if they lie on surfaces, those do not block.
            let ray = ShadowRay { start: Ray::new(x, c.launch), from: x, to: Place::near(y), target: None, connection: c };
            let mut occluded = [false];
            connections.occluded_all(&scene.world, &[ray], &mut occluded);
            let _ = write!(json, "{{\"image\":{},\"phi\":{:.16e},\"launch\":", 2 * turn as usize + side, c.phi);
            push_vector(&mut json, c.launch);
            json += ",\"arrival\":";
            push_vector(&mut json, c.arrival);
            let _ = write!(json, ",\"spread\":{:.16e},\"blocked\":{}}}", c.spread, occluded[0]);
        }
    }
    json += "]}\n";
    json
}

/// One JSON object and a line end. Numbers have 17 significant digits: enough to read the same bits back.
fn answer(scene: &Scene, ray: &Ray, with_path: bool) -> String {
    let world_ray = Ray { origin: ray.origin - scene.world.origin, ..*ray };
    let (end, polyline) = if with_path {
        let (end, polyline) = scene.integrator.polyline(&scene.world, &world_ray);
        (end, Some(polyline))
    } else {
        (scene.integrator.trace(&scene.world, &world_ray), None)
    };
    let arrival = end.arrival;
    let to_world = |p: DVec3| p + scene.world.origin;
    let mut json = String::from("{\"outcome\":");
    json += match arrival {
        Arrival::Surface(_) => "\"hit\"",
        Arrival::Sky(..) => "\"escaped\"",
        Arrival::Captured => "\"captured\"",
        Arrival::OutOfSteps => "\"out of steps\"",
    };
    match arrival {
        Arrival::Surface(hit) => {
            json += ",\"point\":";
            push_vector(&mut json, to_world(hit.point));
            json += ",\"direction\":";
            push_vector(&mut json, hit.direction);
            // Writing to a string cannot fail.
            let _ = write!(json, ",\"shape\":{}", scene.shapes[hit.geometry as usize].index);
        }
        Arrival::Sky(direction, _) => {
            json += ",\"direction\":";
            push_vector(&mut json, direction);
        }
        Arrival::Captured | Arrival::OutOfSteps => {}
    }
    let side = match arrival {
        Arrival::Surface(hit) => Some(scene.world.side_of(hit.geometry)),
        Arrival::Sky(_, side) => Some(side),
        Arrival::Captured | Arrival::OutOfSteps => None,
    };
    let has_far_side = scene.world.spacetime().has_far_side();
    if let Some(side) = side.filter(|_| has_far_side) {
        json += match side {
            Side::Near => ",\"side\":\"near\"",
            Side::Far => ",\"side\":\"far\"",
        };
    }
    let _ = write!(json, ",\"phi\":{:.16e}", end.swept);
    let _ = write!(json, ",\"steps\":{},\"queries\":{}", end.cost.steps, end.cost.queries);
    if let Some(points) = polyline {
        json += ",\"path\":[";
        for (i, p) in points.iter().enumerate() {
            if i > 0 {
                json.push(',');
            }
            push_vector(&mut json, to_world(*p));
        }
        json.push(']');
    }
    json += "}\n";
    json
}

fn push_vector(json: &mut String, v: DVec3) {
    let _ = write!(json, "[{:.16e},{:.16e},{:.16e}]", v.x, v.y, v.z);
}
