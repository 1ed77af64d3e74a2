//! Orbits against the table of `tests/reference`, which has 30 digits.

use anyhow::{Context, Result};
use bhs::bench::rays::Summary;
use bhs::bench::table::Table;
use bhs::plot::{Chart, Series};
use bhs_integrators::closed_form::ClosedForm;
use bhs_integrators::orbit::{Dense, Fate, Rk4Orbit, State, Stepper};
use bhs_integrators::taylor::TaylorOrbit;

/// One row of the table: an orbit, and its u and u' at an angle.
struct Reference {
    regime: String,
    rs: f64,
    start: State,
    truth: State,
}

/// Steps of `rk4` (rad).
const STEPS: [f64; 9] = [0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001];

/// What is asked of `adaptive`, relative to the distance from the hole.
const TOLERANCES: [f64; 8] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-10, 1e-12];

/// Angle after which a stepped orbit is given up (rad).
const FARTHEST: f64 = 200.0;

fn references() -> Result<Vec<Reference>> {
    let path = crate::root().join("tests/reference/orbits.csv");
    let text = std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let row = |line: &str| {
        let (regime, rest) = line.split_once(',').context("a row has several columns")?;
        let x = rest.split(',').map(str::parse).collect::<Result<Vec<f64>, _>>()?;
        let [rs, u, du, phi, end_u, end_du] = x[..] else { anyhow::bail!("a row has seven columns: {line}") };
        let (start, truth) = (State { phi: 0.0, u, du }, State { phi, u: end_u, du: end_du });
        Ok(Reference { regime: regime.to_owned(), rs, start, truth })
    };
    text.lines().skip(1).map(row).collect()
}

/// Where a stepped orbit is at the angle `phi`; `None` if it has ended before.
fn follow(mut orbit: impl Stepper, phi: f64) -> Option<State> {
    loop {
        let (step, fate) = orbit.advance();
        if step.end().phi >= phi {
            return Some(step.at(phi));
        }
        if fate != Fate::Underway || step.end().phi > FARTHEST {
            return None;
        }
    }
}

/// Distance across the orbit, relative to the distance from the hole; infinite for an orbit that has ended too early.
fn error(r: &Reference, found: Option<State>) -> f64 {
    found.map_or(f64::INFINITY, |s| (s.u - r.truth.u).abs() / r.truth.u.hypot(r.truth.du))
}

/// Regimes in which an orbit magnifies every error, without bound as it gets closer to the photon sphere.
fn is_critical(regime: &str) -> bool {
    regime.starts_with("critical") || regime.starts_with("photon")
}

pub fn measure() -> Result<()> {
    let references = references()?;
    let mut table = Table::new(&["integrator", "step or tolerance", "orbits", "median", "99 %", "worst", "ended too early"]);
    let rk4 = |step: f64, r: &Reference| error(r, follow(Rk4Orbit { hole: r.rs.into(), step, state: r.start }, r.truth.phi));
    let adaptive = |tolerance: f64, r: &Reference| error(r, follow(TaylorOrbit::new(r.rs, r.start, tolerance), r.truth.phi));
    let exact = |_: f64, r: &Reference| {
        let (u, du) = ClosedForm::new(r.rs, r.start.u, r.start.du).at(r.truth.phi);
        error(r, Some(State { u, du, ..r.truth }))
    };
    /// Error of an orbit at a setting.
    type Measure<'m> = &'m dyn Fn(f64, &Reference) -> f64;
    let integrators: [(&str, &[f64], Measure); 3] =
        [("rk4", &STEPS, &rk4), ("adaptive", &TOLERANCES, &adaptive), ("exact", &[1.0], &exact)];
    for (name, settings, measure) in integrators {
        let mut lines: Vec<Series> = Vec::new();
        for critical in [false, true] {
            let of =
                |setting: f64| references.iter().filter(|r| is_critical(&r.regime) == critical).map(move |r| measure(setting, r));
            let group = if critical { "near critical" } else { "all others" };
            let mut curves: [Vec<[f64; 2]>; 3] = Default::default();
            for &setting in settings {
                let errors: Vec<f64> = of(setting).collect();
                let early = errors.iter().filter(|e| e.is_infinite()).count();
                let s = Summary::of(errors);
                for (curve, value) in curves.iter_mut().zip([s.median, s.p99, s.worst]) {
                    curve.push([setting, value]);
                }
                let [median, p99, worst] = s.cells();
                let shown = if name == "exact" { String::new() } else { format!("{setting:.0e}") };
                table.row(&[name.to_owned(), shown, group.to_owned(), median, p99, worst, early.to_string()]);
            }
            let names = ["median", "99 %", "worst"].map(|n| format!("{n}, {group}"));
            lines.extend(names.into_iter().zip(curves).map(|(name, points)| Series { name, points, dashed: false }));
        }
        let (x, slope) = match name {
            "rk4" => ("step (rad)", Series { name: "slope 4".into(), points: slope(settings, 4), dashed: true }),
            "adaptive" => {
                ("tolerance / r", Series { name: "error = tolerance".into(), points: slope(settings, 1), dashed: true })
            }
            _ => continue,
        };
        lines.push(slope);
        let title = format!("Orbits of {name} against 30 digits");
        let chart = Chart { title, x: x.into(), y: "distance across the orbit / r".into(), series: lines };
        crate::write(&format!("orbits_{name}.svg"), &chart.to_svg())?;
    }
    crate::finish(&table, "orbits")
}

/// The line `setting^order`.
fn slope(settings: &[f64], order: i32) -> Vec<[f64; 2]> {
    settings.iter().map(|s| [*s, s.powi(order)]).collect()
}
