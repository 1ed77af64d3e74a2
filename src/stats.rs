//! What a render took, as JSON.

use bhs_core::stats::Counters;
use serde_json::{Value, json};
use std::time::{Duration, Instant};

/// Seconds by phase, in the order of the phases.
#[derive(Debug)]
pub struct Phases {
    start: Instant,
    last: Instant,
    phases: Vec<(&'static str, Duration)>,
}

impl Default for Phases {
    fn default() -> Self {
        let now = Instant::now();
        Self { start: now, last: now, phases: Vec::new() }
    }
}

impl Phases {
    /// Ends the phase `name`, which began where the last one ended.
    pub fn end(&mut self, name: &'static str) {
        let now = Instant::now();
        self.phases.push((name, now - self.last));
        self.last = now;
    }

    /// Seconds since the first phase began.
    pub fn total(&self) -> f64 {
        self.start.elapsed().as_secs_f64()
    }

    /// Seconds of a phase that has ended.
    pub fn seconds(&self, name: &str) -> f64 {
        self.phases.iter().filter(|(n, _)| *n == name).map(|(_, d)| d.as_secs_f64()).sum()
    }

    /// As a JSON object.
    pub fn to_json(&self) -> Value {
        let mut object = serde_json::Map::new();
        for (name, duration) in &self.phases {
            object.insert((*name).to_owned(), json!(duration.as_secs_f64()));
        }
        object.insert("total".to_owned(), json!(self.total()));
        Value::Object(object)
    }
}

/// Counts as JSON.
pub fn counters_to_json(c: &Counters) -> Value {
    json!({
        "paths": c.paths,
        "geodesics": c.geodesics,
        "steps": c.steps,
        "queries": c.queries,
        "queries_per_geodesic": c.queries as f64 / c.geodesics.max(1) as f64,
        "connections": {
            "found": c.connections,
            "searched": c.connections_searched,
            "blocked": c.connections_blocked,
            "queries": c.connection_queries,
        },
        "fates": {
            "hit": c.hit,
            "escaped": c.escaped,
            "captured": c.captured,
            "out_of_steps": c.out_of_steps,
        },
        "skipped": { "chords_outside_bounds": c.chords_skipped, "leaps_through_free_space": c.leaps },
        "inside_horizon": c.inside_horizon,
        "samples_not_finite": c.not_finite,
    })
}

/// The largest amount of memory that the process has had so far (bytes); `None` where the system does not tell.
pub fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    let kib: u64 = line.split_whitespace().nth(1)?.parse().ok()?;
    Some(kib * 1024)
}
