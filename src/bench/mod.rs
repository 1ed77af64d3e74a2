//! `bhs bench`: what each integrator and each light transport costs on a scene, and how wrong it is.

pub mod clock;
pub mod equal_error;
pub mod integrators;
pub mod rays;
pub mod table;
pub mod transports;

use crate::plot::{Chart, Series};
use table::Table;

/// A measurement: its table, and charts by file name.
pub struct Measured {
    /// What was measured, as part of file names.
    pub name: &'static str,
    /// The numbers.
    pub table: Table,
    /// A chart of time against error.
    pub chart: Chart,
    /// What comes of it.
    pub summary: Option<Summary>,
}

/// What comes of a measurement.
pub struct Summary {
    /// What it says.
    pub title: String,
    /// The numbers.
    pub table: Table,
}

impl Measured {
    /// The tables with their names, as part of file names.
    pub fn tables(&self) -> impl Iterator<Item = (String, &Table)> {
        let summary = self.summary.iter().map(|s| (format!("{}_{}", self.name, s.title.replace(' ', "_")), &s.table));
        std::iter::once((self.name.to_owned(), &self.table)).chain(summary)
    }
}

/// A point of time against error.
#[derive(Clone, Debug, PartialEq)]
pub struct Tradeoff {
    /// The line that it belongs to.
    pub line: String,
    /// What it costs.
    pub cost: f64,
    /// How wrong it is.
    pub error: f64,
}

/// Which of `points` are on the Pareto front: no other one costs no more and is no more wrong (and differs in one of the two).
pub fn pareto_front(points: &[Tradeoff]) -> Vec<bool> {
    let beats = |a: &Tradeoff, b: &Tradeoff| a.cost <= b.cost && a.error <= b.error && (a.cost < b.cost || a.error < b.error);
    points.iter().map(|p| p.error.is_finite() && !points.iter().any(|other| beats(other, p))).collect()
}

/// The lines of a chart, error against cost: one for each name, and a dashed one along the Pareto front.
fn series(points: &[Tradeoff]) -> Vec<Series> {
    let mut lines: Vec<Series> = Vec::new();
    for p in points {
        let at = [p.cost, p.error];
        match lines.iter_mut().find(|l| l.name == p.line) {
            Some(line) => line.points.push(at),
            None => lines.push(Series { name: p.line.clone(), points: vec![at], dashed: false }),
        }
    }
    let front = pareto_front(points);
    let mut best: Vec<[f64; 2]> = points.iter().zip(front).filter(|(_, f)| *f).map(|(p, _)| [p.cost, p.error]).collect();
    best.sort_by(|a, b| a[0].total_cmp(&b[0]));
    lines.push(Series { name: "Pareto front".into(), points: best, dashed: true });
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_front_is_what_nothing_beats() {
        let point = |cost, error| Tradeoff { line: "x".into(), cost, error };
        let points = [point(1.0, 4.0), point(2.0, 2.0), point(3.0, 2.0), point(4.0, 1.0), point(5.0, f64::NAN), point(1.0, 5.0)];
        assert_eq!(pareto_front(&points), [true, true, false, true, false, false]);
        let lines = series(&points);
        assert_eq!(lines.len(), 2);
        assert_eq!(lines[1].points, [[1.0, 4.0], [2.0, 2.0], [4.0, 1.0]]);
    }
}
