//! What a render took, as JSON.

use crate::bench::clock::processor_seconds;
use crate::point_picture::PointCounters;
use bhs_engine::connections::MOST_TURNS;
use bhs_engine::stats::Counters;
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// Seconds by phase, in the order of the phases: on the wall's clock, and of the processors.
#[derive(Clone, Debug)]
pub struct Phases {
    start: Instant,
    last: Instant,
    last_processor: f64,
    phases: Vec<Phase>,
}

/// What a phase took.
#[derive(Clone, Debug)]
struct Phase {
    name: &'static str,
    wall: Duration,
    /// Of all threads together (s).
    processor: f64,
}

impl Default for Phases {
    fn default() -> Self {
        let now = Instant::now();
        Self { start: now, last: now, last_processor: processor_seconds(), phases: Vec::new() }
    }
}

impl Phases {
    /// Ends the phase `name`, which began where the last one ended.
    pub fn end(&mut self, name: &'static str) {
        let (now, processor) = (Instant::now(), processor_seconds());
        self.phases.push(Phase { name, wall: now - self.last, processor: processor - self.last_processor });
        (self.last, self.last_processor) = (now, processor);
    }

    /// Seconds since the first phase began.
    pub fn total(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Seconds of a phase that has ended.
    pub fn seconds(&self, name: &str) -> f64 {
        self.phases.iter().filter(|p| p.name == name).map(|p| p.wall.as_secs_f64()).sum()
    }

    /// Seconds on the wall's clock as a JSON object.
    pub fn to_json(&self) -> Value {
        let phases = self.phases.iter().map(|p| (p.name.to_owned(), json!(p.wall.as_secs_f64())));
        Value::Object(phases.chain([("total".to_owned(), json!(self.total()))]).collect())
    }

    /// Seconds that the processors took, all threads together, as a JSON object.
    pub fn processor_to_json(&self) -> Value {
        Value::Object(self.phases.iter().map(|p| (p.name.to_owned(), json!(p.processor))).collect())
    }
}

/// Shares of the geodesics between pairs of points that were sought and not found, by their number; empty if all were found.
pub fn missed_connections(c: &Counters) -> Vec<f64> {
    let mut c = *c;
    let mut sought = [c.connections_sought; 2 * MOST_TURNS];
    for (sought, passed_over) in sought.iter_mut().zip(c.connections_passed_over()) {
        *sought = sought.saturating_sub(*passed_over);
    }
    let shares = c.connections_missed().into_iter().zip(sought).map(|(missed, sought)| *missed as f64 / sought.max(1) as f64);
    let mut shares: Vec<f64> = shares.collect();
    shares.truncate(shares.iter().rposition(|share| *share > 0.0).map_or(0, |last| last + 1));
    shares
}

/// Counts as JSON.
pub fn counters_to_json(c: &Counters) -> Value {
    let mut all = json!({
        "paths": c.paths,
        "geodesics": c.geodesics,
        "steps": c.steps,
        "queries": c.queries,
        "queries_per_geodesic": c.queries as f64 / c.geodesics.max(1) as f64,
        "connections": {
            "found": c.connections,
            "shadow_rays": c.shadow_rays,
            "occluded": c.shadow_rays_occluded,
            "queries": c.shadow_ray_queries,
        },
        "fates": {
            "hit": c.hit,
            "escaped": c.escaped,
            "captured": c.captured,
            "out_of_steps": c.out_of_steps,
        },
        "camera_fates": {
            "hit": c.camera_hit,
            "escaped": c.camera_escaped,
            "captured": c.camera_captured,
            "out_of_steps": c.camera_out_of_steps,
        },
        "skipped": {
            "chords_outside_bounds": c.chords_skipped,
            "leaps_through_free_space": c.leaps,
            "connections_without_light": c.connections_dark,
            "connections_ended_by_roulette": c.connections_ended,
        },
        "no_static_observer": c.no_static_observer,
        "samples_not_finite": c.not_finite,
    });
    let missed = missed_connections(c);
    if !missed.is_empty() {
        all["connections"]["sought"] = json!(c.connections_sought);
        all["connections"]["not_found"] = json!(missed);
    }
    all
}

/// Counts of the points of the sky as JSON.
pub fn points_to_json(c: &PointCounters) -> Value {
    json!({ "points": c.points, "images": c.images, "occluded": c.occluded })
}

/// The largest amount of memory that the process has had so far (bytes); `None` where the system does not tell.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib * 1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn connections_that_were_not_found_are_told_if_there_are_any() {
        let all_found = Counters { connections_sought: 8, ..Default::default() };
        assert!(missed_connections(&all_found).is_empty());
        assert!(counters_to_json(&all_found)["connections"].get("not_found").is_none());
        let missed = Counters { connections_missed_2: 2, ..all_found };
        assert_eq!(missed_connections(&missed), [0.0, 0.25]);
        let json = counters_to_json(&missed);
        assert_eq!((&json["connections"]["sought"], &json["connections"]["not_found"]), (&json!(8), &json!([0.0, 0.25])));
        let some_left_out = Counters { connections_passed_over_2: 4, ..missed };
        assert_eq!(missed_connections(&some_left_out), [0.0, 0.5]);
    }
}
