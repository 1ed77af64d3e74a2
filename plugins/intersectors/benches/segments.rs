//! Time of one query: rays and chords in the box of a mesh of 800,000 triangles, by Embree as bhs calls it, by embree4-rs, and
//! by the reference; and what an analytic surface in the scene costs all the others.
//!
//! `cargo bench -p bhs-intersectors`

#[path = "../tests/common/mod.rs"]
mod common;

use bhs_core::geometry::{Segment, TriangleMesh};
use bhs_elementary::Elementary;
use common::*;
use criterion::{BatchSize, Criterion, criterion_group, criterion_main};
use glam::DVec3;
use std::hint::black_box;

/// Queries of one measurement: enough that a query does not find its own nodes in the cache.
const BATCH: usize = 1 << 18;

/// A torus with bumps, cut into `2 * 896 * 448` triangles.
fn bumpy_torus() -> TriangleMesh {
    let (around, across) = (896, 448);
    let angle = |i: u32, n: u32| std::f64::consts::TAU * f64::from(i) / f64::from(n);
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for (i, j) in (0..around).flat_map(|i| (0..across).map(move |j| (i, j))) {
        let (u, v) = (angle(i, around), angle(j, across));
        let r = 0.3 + 0.03 * (23.0 * u).sine() * (17.0 * v).cosine();
        let out = 0.6 + r * v.cosine();
        positions.push(DVec3::new(out * u.cosine(), r * v.sine(), out * u.sine()));
        let at = |i: u32, j: u32| (i % around) * across + j % across;
        triangles.extend([[at(i, j), at(i + 1, j), at(i + 1, j + 1)], [at(i, j), at(i + 1, j + 1), at(i, j + 1)]]);
    }
    mesh(&positions, triangles)
}

fn queries(bencher: &mut criterion::Bencher, segments: &[Segment], query: impl Fn(&Segment) -> bool) {
    let mut next = 0;
    bencher.iter_batched(
        || {
            next = (next + 1024) % segments.len();
            &segments[next..(next + 1024).min(segments.len())]
        },
        |some| some.iter().filter(|segment| query(black_box(segment))).count(),
        BatchSize::SmallInput,
    );
}

fn benchmark(criterion: &mut Criterion) {
    let torus = bumpy_torus();
    let bounds = torus.bounds();
    let size = bounds.max - bounds.min;
    let mut random = Random::new(1);
    let mut make = |length: f64| -> Vec<Segment> {
        let t_max = if length.is_finite() { 1.0 } else { f64::INFINITY };
        let scale = if length.is_finite() { length } else { 1.0 };
        let one = |_| {
            let origin = bounds.center() + random.point() * size * 0.5;
            Segment { origin, direction: random.direction() * scale, t_min: 0.0, t_max }
        };
        (0..BATCH).map(one).collect()
    };
    let kinds = [("ray", make(f64::INFINITY)), ("chord", make(size.length() / 16.0))];
    let (peer, mesh) = (Peer::new(&torus), shared(torus));
    let fast = embree(std::slice::from_ref(&mesh));
    let mixed = embree(&[mesh.clone(), ball(DVec3::ZERO, 0.1)]);
    let oracle = reference(&[mesh]);
    for (kind, segments) in kinds {
        let mut group = criterion.benchmark_group(format!("1024 {kind}s"));
        group.throughput(criterion::Throughput::Elements(1024));
        group.bench_function("embree closest", |b| queries(b, &segments, |s| fast.closest(s).is_some()));
        group.bench_function("embree4-rs closest", |b| queries(b, &segments, |s| peer.closest(s).is_some()));
        group.bench_function("embree blocked", |b| queries(b, &segments, |s| fast.blocked(s)));
        group.bench_function("embree closest, with a ball", |b| queries(b, &segments, |s| mixed.closest(s).is_some()));
        group.bench_function("reference closest", |b| queries(b, &segments, |s| oracle.closest(s).is_some()));
        group.bench_function("reference blocked", |b| queries(b, &segments, |s| oracle.blocked(s)));
    }
}

criterion_group!(benches, benchmark);
criterion_main!(benches);
