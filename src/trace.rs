//! `bhs trace`: single rays, or pairs of points to connect, in; one JSON object a line out. For people and for checks from outside.

use anyhow::{Context, Result, bail};
use bhs_core::integrator::{Arrival, Connections, Ray, Sight};
use bhs_core::scene::Scene;
use bhs_core::stats::TraceLog;
use glam::DVec3;
use rayon::prelude::*;
use std::fmt::Write as _;
use std::io::{BufRead, Write};

/// Rays that are read, traced in parallel and written together.
const BATCH: usize = 4096;

/// Reads rays `ox,oy,oz,dx,dy,dz` (world coordinates, chart directions of any length) from `rays`, one a line, follows each
/// through `scene` and writes what becomes of it, in input order. Empty lines and lines that begin with `#` are passed over.
///
/// # Errors
/// If a line cannot be read as a ray (the ones before it are answered), or `out` cannot be written.
pub fn trace(scene: &Scene, rays: impl BufRead, with_path: bool, out: &mut impl Write) -> Result<()> {
    answer_lines(rays, parse_ray, |ray| answer(scene, ray, with_path), out)
}

/// Reads pairs of points `x1,y1,z1,x2,y2,z2` (world coordinates) from `pairs`, one a line, and writes the geodesics that lead from the first
/// to the second, one line of JSON a pair, in input order: those that the scene's integrator samples lights along.
///
/// # Errors
/// As [`trace`]; and if the integrator cannot connect points.
pub fn connect(scene: &Scene, pairs: impl BufRead, out: &mut impl Write) -> Result<()> {
    let Some(connections) = scene.integrator.connections() else { bail!("the integrator cannot connect points") };
    answer_lines(pairs, parse_pair, |pair| connection_answer(scene, connections, pair), out)
}

/// Reads `lines`, answers them in parallel and writes the answers in their order.
fn answer_lines<T: Sync + Send>(
    lines: impl BufRead,
    parse: impl Fn(&str) -> Result<Option<T>>,
    answer: impl Fn(&T) -> String + Sync,
    out: &mut impl Write,
) -> Result<()> {
    let mut lines = lines.lines().enumerate();
    loop {
        let mut batch = Vec::with_capacity(BATCH);
        let mut fault = None;
        for (number, line) in lines.by_ref() {
            let ray = line.context("it is not text").and_then(|l| parse(&l)).with_context(|| format!("line {}", number + 1));
            match ray {
                Ok(Some(ray)) => batch.push(ray),
                Ok(None) => {}
                Err(error) => fault = Some(error),
            }
            if fault.is_some() || batch.len() == BATCH {
                break;
            }
        }
        let answers: Vec<String> = batch.par_iter().map(&answer).collect();
        for answer in &answers {
            out.write_all(answer.as_bytes())?;
        }
        match fault {
            Some(error) => return Err(error),
            None if answers.len() < BATCH => return Ok(out.flush()?),
            None => {}
        }
    }
}

fn parse_ray(line: &str) -> Result<Option<Ray>> {
    let Some([origin, direction]) = parse_vectors(line, "ox,oy,oz,dx,dy,dz")? else { return Ok(None) };
    match direction.try_normalize() {
        Some(direction) => Ok(Some(Ray::new(origin, direction))),
        None => bail!("the direction is zero"),
    }
}

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
        for (side, c) in connections.connect(&scene.world, x, y, turn).into_iter().enumerate() {
            let Some(c) = c else { continue };
            if !json.ends_with('[') {
                json.push(',');
            }
            // From the very points: if they lie on surfaces, those do not block.
            let sight = Sight { start: Ray::new(x, c.launch), from: x, to: y, connection: c };
            let visible = connections.visible(&scene.world, &sight, &mut TraceLog::default());
            let _ = write!(json, "{{\"image\":{},\"phi\":{:.16e},\"launch\":", 2 * turn as usize + side, c.phi);
            push_vector(&mut json, c.launch);
            json += ",\"arrival\":";
            push_vector(&mut json, c.arrival);
            let _ = write!(json, ",\"spread\":{:.16e},\"blocked\":{}}}", c.spread, !visible);
        }
    }
    json += "]}\n";
    json
}

/// One JSON object and a line end. Numbers have 17 significant digits: enough to read the same bits back.
fn answer(scene: &Scene, ray: &Ray, with_path: bool) -> String {
    let mut log = TraceLog { polyline: with_path.then(Vec::new), ..Default::default() };
    let world_ray = Ray { origin: ray.origin - scene.world.origin, ..*ray };
    let arrival = scene.integrator.trace(&scene.world, &world_ray, &mut log);
    let to_world = |p: DVec3| p + scene.world.origin;
    let mut json = String::from("{\"outcome\":");
    json += match arrival {
        Arrival::Surface(_) => "\"hit\"",
        Arrival::Sky(_) => "\"escaped\"",
        Arrival::Hole => "\"captured\"",
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
        Arrival::Sky(direction) => {
            json += ",\"direction\":";
            push_vector(&mut json, direction);
        }
        Arrival::Hole | Arrival::OutOfSteps => {}
    }
    let _ = write!(json, ",\"phi\":{:.16e}", log.phi);
    let _ = write!(json, ",\"steps\":{},\"queries\":{}", log.counters.steps, log.counters.queries);
    if let Some(points) = log.polyline {
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
