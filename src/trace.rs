//! `bhs trace`: single rays in, one JSON object a line out, for people and for checks from outside.

use anyhow::{Context, Result, bail};
use bhs_core::integrator::{Arrival, Ray};
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
    let mut lines = rays.lines().enumerate();
    loop {
        let mut batch = Vec::with_capacity(BATCH);
        let mut fault = None;
        for (number, line) in lines.by_ref() {
            let ray = line.context("it is not text").and_then(|l| parse_ray(&l)).with_context(|| format!("line {}", number + 1));
            match ray {
                Ok(Some(ray)) => batch.push(ray),
                Ok(None) => {}
                Err(error) => fault = Some(error),
            }
            if fault.is_some() || batch.len() == BATCH {
                break;
            }
        }
        let answers: Vec<String> = batch.par_iter().map(|ray| answer(scene, ray, with_path)).collect();
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
    let line = line.trim();
    if line.is_empty() || line.starts_with('#') {
        return Ok(None);
    }
    let numbers: Vec<f64> = line
        .split(',')
        .map(|n| n.trim().parse::<f64>().with_context(|| format!("`{}` is not a number", n.trim())))
        .collect::<Result<_>>()?;
    if numbers.len() != 6 {
        bail!("expected 6 numbers ox,oy,oz,dx,dy,dz, found {}", numbers.len());
    }
    if let Some(bad) = numbers.iter().find(|n| !n.is_finite()) {
        bail!("`{bad}` is not finite");
    }
    match DVec3::from_slice(&numbers[3..]).try_normalize() {
        Some(direction) => Ok(Some(Ray::new(DVec3::from_slice(&numbers), direction))),
        None => bail!("the direction is zero"),
    }
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
