use bhs::bench::rays::*;
use bhs::lang::{self, Overrides, SourceMap};
use bhs::registry::Registry;
use bhs_core::integrator::Integrator;
use bhs_core::stats::TraceLog;
use bhs_integrators::flight::Tolerance;
use bhs_integrators::{Adaptive, Exact, Rk4, Straight};
fn cpu() -> f64 {
    use std::sync::OnceLock;
    static T: OnceLock<std::time::Instant> = OnceLock::new();
    T.get_or_init(std::time::Instant::now).elapsed().as_nanos() as f64
}
fn main() {
    let args: Vec<String> = std::env::args().collect();
    let scene = &args[1];
    let only = args.get(2).cloned().unwrap_or_default();
    let mut sources = SourceMap::new();
    let built = lang::load(scene, &Registry::builtin(), &Overrides::default(), &mut sources).ok().unwrap();

    let world = &built.scene.world;
    let d = diagonal(world);
    let camera = camera_rays(&built, 20000);
    let bounce = bounce_rays(&built, &camera);
    let mut cands: Vec<(String, Box<dyn Integrator>)> = vec![("straight".into(), Box::new(Straight))];
    for t in [1e-2, 3e-3, 1e-3, 1e-4, 1e-5, 1e-6] {
        cands.push((format!("adaptive {t:e}"), Box::new(Adaptive::new(Tolerance::Absolute(t * d), 100000))));
    }
    cands.push(("one 1e-2".into(), Box::new(Adaptive::new(Tolerance::Absolute(1e-2 * d), 100000))));
    cands.push(("one default".into(), Box::new(Adaptive::new(Tolerance::DEFAULT, 100000))));
    cands.push(("default".into(), Box::new(Adaptive::new(Tolerance::DEFAULT, 100000))));
    cands.push(("exact 1e-4".into(), Box::new(Exact::new(Tolerance::Absolute(1e-4 * d), 100000))));
    for s in [0.2, 0.05] {
        cands.push((format!("rk4 {s}"), Box::new(Rk4::new(s, 100000))));
    }
    if !only.is_empty() {
        cands.retain(|c| std::env::var("NOSTRAIGHT").is_err() && c.0 == "straight" || only.split(',').any(|o| o == c.0) );
    }
    for (name, rays) in [("camera", &camera), ("bounce", &bounce)] {
        let (te, _) = arrivals(world, &truth(world), rays);
        let rounds = std::env::var("ROUNDS").ok().and_then(|r| r.parse().ok()).unwrap_or(if only.is_empty() { 15 } else { 41 });
        let mut times = vec![vec![]; cands.len()];
        for _ in 0..rounds {
            for (i, c) in cands.iter().enumerate() {
                let s = cpu();
                let mut log = TraceLog::default();
                let mut out = [bhs_core::integrator::Traced { arrival: bhs_core::integrator::Arrival::Hole, phi: 0.0 }; 64];
                if c.0.starts_with("one ") {
                    for r in rays.iter() {
                        std::hint::black_box(c.1.trace(world, r, &mut log));
                    }
                } else {
                    for r in rays.chunks(64) {
                        c.1.trace_all(world, r, &mut out[..r.len()], &mut log);
                        std::hint::black_box(&mut out);
                    }
                }
                times[i].push((cpu() - s) / rays.len() as f64);
            }
        }
        let mut s0 = 0.0;
        for (i, c) in cands.iter().enumerate() {
            let (mut e, mut k) = arrivals(world, &*c.1, rays);
            if !c.0.starts_with("one ") {
                let mut log = TraceLog::default();
                let mut out = [bhs_core::integrator::Traced { arrival: bhs_core::integrator::Arrival::Hole, phi: 0.0 }; 64];
                let single = e.clone();
                e.clear();
                let mut phis = 0.0f64;
                let mut one = TraceLog::default();
                for r in rays.chunks(64) {
                    c.1.trace_all(world, r, &mut out[..r.len()], &mut log);
                    e.extend(out[..r.len()].iter().map(|t| t.arrival));
                    for (t, r) in out.iter().zip(r) {
                        c.1.trace(world, r, &mut one);
                        if (one.phi - t.phi).abs() > phis {
                            phis = (one.phi - t.phi).abs();
                        }
                    }
                }
                k = log.counters;
                let d = differences(world, &e, &single); print!("per packet: "); for k in &bhs_integrators::packet::CNT { print!("{:.3} ", k.swap(0, std::sync::atomic::Ordering::Relaxed) as f64 / rays.len() as f64 / (rounds as f64 + 1.0) * 8.0); } println!();
                println!(
                    "    batch vs one: p99 {:.1e} worst {:.1e} other {:.4}% phi {phis:.1e}",
                    d.distance.p99,
                    d.distance.worst,
                    100.0 * d.other_triangle
                );
            }
            let df = differences(world, &e, &te);
            times[i].sort_by(f64::total_cmp);
            let m = times[i][rounds / 2];
            let lo = times[i][0];
            if i == 0 {
                s0 = m;
            }
            let n = rays.len() as f64;
            println!(
                "{name} {:16} {m:7.0} ns (min {lo:5.0}) x{:5.2}  steps {:.2} queries {:.2} leaps {:.2}  med {:.1e} p99 {:.1e} worst {:.1e} other {:.3}%",
                c.0,
                m / s0,
                k.steps as f64 / n,
                k.queries as f64 / n,
                k.leaps as f64 / n,
                df.distance.median,
                df.distance.p99,
                df.distance.worst,
                100.0 * df.other_triangle
            );
        }
    }
}
