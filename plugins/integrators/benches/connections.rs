//! Time of one connection, and of the pair of images that light sampling asks for: two points 3 to 60 Schwarzschild radii from
//! the hole (a room around it), in random directions. For comparison, a full Embree ray is about 120 ns.
//!
//! `cargo bench -p bhs-integrators --bench connections`

use bhs_core::spacetime::Spherical;
use bhs_elementary::Elementary;
use bhs_integrators::spherical::connect::{connect, connect_pair, connect_pairs, spread_of};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use std::hint::black_box;

/// Pairs of one measurement: too many for the processor to learn their branches.
const PAIRS: usize = 4096;

fn points() -> (Spherical, Vec<(DVec3, DVec3)>) {
    let center = DVec3::new(0.1, 0.2, 0.3);
    // Halton points: bases 2, 3, 5 for the one end, 7, 11, 13 for the other.
    let halton = |mut i: usize, base: usize| {
        let (mut x, mut digit) = (0.0, 1.0);
        while i > 0 {
            digit /= base as f64;
            x += digit * (i % base) as f64;
            i /= base;
        }
        x
    };
    let point = |i: usize, [a, b, c]: [usize; 3]| {
        let (z, phi) = (2.0 * halton(i, a) - 1.0, std::f64::consts::TAU * halton(i, b));
        let s = (1.0 - z * z).sqrt();
        center + DVec3::new(s * phi.cosine(), s * phi.sine(), z) * (0.3 * 20f64.power(halton(i, c)))
    };
    let hole = Spherical { center, rs: 0.1, charge_squared: 0.0 };
    (hole, (1..=PAIRS).map(|i| (point(i, [2, 3, 5]), point(i, [7, 11, 13]))).collect())
}

fn connections(criterion: &mut Criterion) {
    let (hole, pairs) = points();
    let mut group = criterion.benchmark_group("connections");
    group.throughput(Throughput::Elements(PAIRS as u64));
    for image in 0..4 {
        group.bench_function(format!("image {image}"), |b| {
            b.iter(|| pairs.iter().filter_map(|&(x, y)| black_box(connect(&hole, x, y, image))).count());
        });
    }
    group.bench_function("pair of images 0 and 1", |b| {
        b.iter(|| pairs.iter().map(|&(x, y)| black_box(connect_pair(&hole, x, y, 0)).iter().flatten().count()).sum::<usize>());
    });
    group.bench_function("pairs of images 0 and 1, side by side", |b| {
        let ends: Vec<_> = pairs.iter().map(|&(x, y)| [x, y].map(bhs_core::spacetime::Place::near)).collect();
        let mut found = vec![[None; 2]; PAIRS];
        b.iter(|| {
            connect_pairs(&hole, black_box(&ends), 0, &mut found);
            found.iter().flatten().flatten().count()
        });
    });
    group.bench_function("spread of a traced ray", |b| {
        b.iter(|| pairs.iter().filter_map(|&(x, y)| black_box(spread_of(&hole, x, DVec3::X, y, 1.0, 2))).count());
    });
    group.finish();
}

criterion_group!(benches, connections);
criterion_main!(benches);
