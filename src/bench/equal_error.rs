//! What integrators cost where they are equally wrong.

use super::Tradeoff;
use super::table::Table;
use bhs_elementary::Elementary;

/// The errors (p99, relative to the scene's diagonal) at which integrators are compared.
pub const ERRORS: [f64; 3] = [1e-4, 1e-5, 1e-6];

/// What the points of one line, each setting's error and cost, cost at the error `target`: between two settings along a straight line over logarithmic
/// axes. The least such cost, or that of a setting that is better, if that costs less. `None` if no setting is that good.
///
/// An error of 0 counts as far below all others.
pub fn cost_at(points: &[(f64, f64)], target: f64) -> Option<f64> {
    let better = points.iter().filter(|(error, _)| *error <= target).map(|(_, cost)| *cost);
    let between = points.windows(2).filter_map(|pair| {
        let [(e0, c0), (e1, c1)] = [pair[0], pair[1]];
        let crosses = (e0 > target) != (e1 > target) && e0 > 0.0 && e1 > 0.0;
        let share = (target / e0).logarithm() / (e1 / e0).logarithm();
        crosses.then(|| c0 * (c1 / c0).power(share))
    });
    better.chain(between).min_by(f64::total_cmp)
}

/// The table: for each error what every line costs there (ns), the first line's cost over it, and it over a straight ray's.
pub fn table(points: &[Tradeoff], straight: f64) -> Table {
    let mut lines: Vec<&str> = Vec::new();
    for p in points {
        if !lines.contains(&p.line.as_str()) {
            lines.push(&p.line);
        }
    }
    let (baseline, others) = lines.split_first().unwrap_or((&"", &[]));
    let mut columns = vec!["p99".to_owned()];
    columns.extend(lines.iter().map(|l| format!("{l} ns")));
    columns.extend(others.iter().map(|l| format!("{baseline} / {l}")));
    columns.extend(others.iter().map(|l| format!("{l} / straight")));
    let mut table = Table::new(&columns.iter().map(String::as_str).collect::<Vec<_>>());
    for target in ERRORS {
        let cost = |line: &str| {
            let of_line: Vec<_> = points.iter().filter(|p| p.line == line).map(|p| (p.error, p.cost)).collect();
            cost_at(&of_line, target).unwrap_or(f64::NAN)
        };
        let shown = |value: f64, digits: usize| if value.is_finite() { format!("{value:.digits$}") } else { String::new() };
        let mut row = vec![format!("{target:.0e}")];
        row.extend(lines.iter().map(|l| shown(cost(l), 0)));
        row.extend(others.iter().map(|l| shown(cost(baseline) / cost(l), 1)));
        row.extend(others.iter().map(|l| shown(cost(l) / straight, 2)));
        table.row(&row);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn costs_lie_on_straight_lines_over_logarithmic_axes() {
        // Second order: a hundredth of the error for ten times the cost.
        let line = [(1e-2, 10.0), (1e-4, 100.0), (1e-6, 1000.0)];
        for (target, cost) in [(1e-4, 100.0), (1e-3, 10.0 * 10f64.sqrt()), (1e-5, 100.0 * 10f64.sqrt())] {
            assert!((cost_at(&line, target).unwrap() / cost - 1.0).abs() < 1e-12);
        }
        assert_eq!(cost_at(&line, 1e-7), None);
        // All settings are better than asked: the cheapest one.
        assert_eq!(cost_at(&line, 1.0), Some(10.0));
        // A better setting that costs less than the line.
        assert_eq!(cost_at(&[(1e-2, 10.0), (1e-4, 100.0), (1e-5, 20.0)], 1e-3), Some(20.0));
        assert_eq!(cost_at(&[(1e-3, 10.0), (0.0, 30.0)], 1e-4), Some(30.0));
    }

    #[test]
    fn ratios_are_those_of_the_first_line() {
        let point = |line: &str, error, cost| Tradeoff { line: line.into(), cost, error };
        let points = [point("slow", 1e-3, 1000.0), point("slow", 1e-7, 100_000.0), point("fast", 1e-6, 100.0)];
        let json = table(&points, 50.0).to_json();
        assert_eq!(json[1]["slow ns"], 10000.0);
        assert_eq!((&json[1]["slow / fast"], &json[1]["fast / straight"]), (&100.0.into(), &2.0.into()));
    }
}
