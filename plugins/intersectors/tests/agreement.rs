//! Embree finds what the oracles find, but for what single precision cannot tell.

mod common;

use bhs_core::geometry::instance::Object;
use bhs_core::geometry::{Geometry, Segment};
use bhs_core::intersector::{Intersector, PrimitiveHit};
use common::*;
use glam::DVec3;
use proptest::prelude::*;
use std::sync::Arc;

/// What single precision cannot tell, in units of the scenes here, whose coordinates are about one.
const ROUNDING: f64 = 16.0 * f32::EPSILON as f64;

/// Disagreements that rounding explains may be this share of all segments.
const SHARE: f64 = 2e-3;

fn same(segment: &Segment, a: Option<PrimitiveHit>, b: Option<PrimitiveHit>) -> bool {
    match (a, b) {
        (None, None) => true,
        // Where two surfaces cross, either may be named.
        (Some(a), Some(b)) => (a.t - b.t).abs() * segment.direction.length() < ROUNDING,
        _ => false,
    }
}

/// Whether the oracle would have said the same of a segment that rounding cannot tell from this one.
fn explained(oracle: &dyn Intersector, segment: &Segment, hit: Option<PrimitiveHit>) -> bool {
    let mut random = Random::new(1);
    (0..2000).any(|_| {
        let (start, end) = (random.point() * ROUNDING, random.point() * ROUNDING);
        // Both ends move, an infinite one as if it were where the scene ends.
        let length = if segment.t_max.is_finite() { segment.t_max } else { 4.0 / segment.direction.length() };
        let stretch = ROUNDING / segment.direction.length();
        let moved = Segment {
            origin: segment.origin + start,
            direction: segment.direction + (end - start) / length,
            t_min: segment.t_min - stretch * random.unit(),
            t_max: segment.t_max + stretch * (2.0 * random.unit() - 1.0),
        };
        let other = oracle.closest(&moved);
        match (hit, other) {
            (None, None) => true,
            // At grazing incidence the parameter of the hit moves much farther than the segment.
            (Some(a), Some(b)) => (a.geometry, a.primitive) == (b.geometry, b.primitive) || same(segment, hit, other),
            _ => false,
        }
    })
}

/// Segments of all kinds: rays, chords of all lengths, with direction vectors of all sizes, from inside and from afar.
fn segment(random: &mut Random) -> Segment {
    let origin = random.point() * if random.unit() < 0.1 { 30.0 } else { 1.2 };
    let direction = match random.unit() {
        x if x < 0.5 => random.direction(),
        x if x < 0.7 => random.point() * 1.5 - origin,
        x if x < 0.9 => random.direction() * 10f64.powf(-3.0 * random.unit()),
        _ => random.direction() * 10f64.powf(60.0 * random.unit() - 30.0),
    };
    let size = direction.length();
    let (t_min, t_max) = match random.unit() {
        x if x < 0.5 => (0.0, f64::INFINITY),
        x if x < 0.8 => (0.0, 1.0f64.max(1e-3 / size).min(60.0 / size)),
        _ => (0.2 * random.unit() / size, (0.2 + random.unit()) / size),
    };
    Segment { origin, direction, t_min, t_max }
}

/// An object of one or two meshes that stands in several places, mirrored or not.
fn instances(random: &mut Random) -> Vec<Geometry> {
    let mut meshes = vec![defined(&icosphere(2), 0.5, DVec3::ZERO)];
    if random.unit() < 0.5 {
        meshes.push(defined(&soup(random, 100), 1.0, random.point()));
    }
    let object = Arc::new(Object::new(meshes, 0.3));
    (0..1 + (4.0 * random.unit()) as usize).flat_map(|_| place(&object, similarity(random, 0.3))).collect()
}

/// A scene of several meshes, instances and balls.
fn scene(random: &mut Random) -> Vec<Geometry> {
    let mut geometries = Vec::new();
    if random.unit() < 0.5 {
        geometries.extend(instances(random));
    }
    for _ in 0..1 + (4.0 * random.unit()) as usize {
        let triangles = 1 + (300.0 * random.unit()) as u32;
        geometries.push(match random.unit() {
            x if x < 0.4 => shared(soup(random, triangles)),
            x if x < 0.5 => shared(icosphere(3)),
            x if x < 0.6 => shared(cube(5)),
            _ => ball(random.point(), 10f64.powf(-3.0 * random.unit())),
        });
    }
    geometries
}

/// Compares over `count` segments and gives the number of disagreements; those that rounding does not explain fail.
fn disagreements(geometries: &[Geometry], random: &mut Random, count: usize) -> usize {
    let (fast, oracle) = (embree(geometries), reference(geometries));
    let mut found = 0;
    for _ in 0..count {
        let segment = segment(random);
        let (a, b) = (fast.closest(&segment), oracle.closest(&segment));
        assert_eq!(fast.blocked(&segment), a.is_some(), "blocked and closest differ on {segment:?}: {a:?}");
        assert_eq!(oracle.blocked(&segment), b.is_some(), "the oracle's blocked and closest differ on {segment:?}: {b:?}");
        if !same(&segment, a, b) {
            found += 1;
            assert!(explained(&*oracle, &segment, a), "{segment:?}: Embree says {a:?}, the oracle {b:?}");
        }
    }
    found
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(100) })]

    #[test]
    fn embree_agrees_with_the_reference(seed: u64) {
        let mut random = Random::new(seed);
        let geometries = scene(&mut random);
        prop_assert!(disagreements(&geometries, &mut random, 500) <= 5);
    }
}

#[test]
fn disagreements_are_rare() {
    let mut random = Random::new(7);
    let (scenes, segments) = (40, 5000);
    let found: usize = (0..scenes)
        .map(|_| {
            let geometries = scene(&mut random);
            disagreements(&geometries, &mut random, segments)
        })
        .sum();
    let share = found as f64 / (scenes * segments) as f64;
    eprintln!("{found} disagreements, {share:e} of all segments");
    assert!(share < SHARE, "{share}");
}

#[test]
fn embree_agrees_with_embree4_rs() {
    let mut random = Random::new(3);
    for mesh in [soup(&mut random, 500), icosphere(5), cube(20)] {
        let (peer, geometries) = (Peer::new(&mesh), [shared(mesh)]);
        let (fast, oracle) = (embree(&geometries), reference(&geometries));
        let (mut hits, mut exact) = (0, 0);
        for i in 0..20_000 {
            let chord = random.direction() * 0.2;
            let t_max = if i % 2 == 0 { f64::INFINITY } else { 1.0 };
            let segment = Segment { origin: random.point(), direction: chord, t_min: 0.0, t_max };
            let (a, b) = (fast.closest(&segment), peer.closest(&segment));
            // Where surfaces are close together the answer is not Embree's but exact.
            if a.map(|a| (a.t as f32, a.primitive)) != b {
                assert_eq!(a, oracle.closest(&segment), "{segment:?}: {b:?}");
                exact += 1;
            }
            hits += usize::from(b.is_some());
        }
        assert!(hits > 1000, "only {hits} hits: the test sees nothing");
        assert!(exact * 100 < hits, "{exact} of {hits} hits are not Embree's");
    }
}

#[test]
fn analytic_surfaces_see_the_segment_in_double_precision() {
    // Single precision would lose the ball's radius beside its distance.
    let (center, radius) = (DVec3::new(1.0, -2.0, 100.0), 0.25);
    let geometries = [shared(icosphere(2)), ball(center, radius)];
    let fast = embree(&geometries);
    let mut random = Random::new(11);
    for size in [1.0, 1e-4, 1e4, 1e-25, 1e25] {
        for _ in 0..1000 {
            let origin = DVec3::new(0.0, 0.0, 2.0) + random.point() * 0.5;
            let target = center + random.point() * 0.1;
            let segment = ray(origin, (target - origin).normalize() * size);
            let hit = fast.closest(&segment).unwrap();
            assert_eq!((hit.geometry, hit.primitive), (1, 0));
            let error = (segment.at(hit.t) - center).length() - radius;
            assert!(error.abs() < 1e-13, "{segment:?} misses by {error:e}");
        }
    }
}

#[test]
fn the_nearer_of_mesh_and_surface_is_found() {
    // A ball just inside the facets of a sphere, or just outside: seen from within and from without.
    for (radius, inner) in [(0.999, false), (1.001, true)] {
        let geometries = [shared(icosphere(6)), ball(DVec3::ZERO, radius)];
        let fast = embree(&geometries);
        let mut random = Random::new(5);
        for _ in 0..2000 {
            let direction = random.direction();
            let outward = fast.closest(&ray(DVec3::ZERO, direction)).unwrap();
            let inward = fast.closest(&ray(direction * 3.0, -direction)).unwrap();
            assert_eq!((outward.geometry, inward.geometry), (u32::from(!inner), u32::from(inner)), "{direction}");
        }
    }
}

#[test]
fn instances_are_found_where_copies_are() {
    let mut random = Random::new(17);
    let (ball, box_) = (icosphere(3), cube(4));
    let object = Arc::new(Object::new(vec![defined(&ball, 1.0, DVec3::ZERO), defined(&box_, 0.3, DVec3::Y)], 0.1));
    let (mut instances, mut copies) = (Vec::new(), Vec::new());
    for _ in 0..20 {
        let t = similarity(&mut random, 0.1);
        instances.extend(place(&object, t));
        for (source, size, at) in [(&ball, 1.0, DVec3::ZERO), (&box_, 0.3, DVec3::Y)] {
            let positions = (0..source.positions.len()).map(|i| {
                let p = DVec3::from_array(source.positions[i].map(f64::from));
                t.transform_point3(p * size + at)
            });
            copies.push(shared(mesh(&positions.collect::<Vec<_>>(), source.triangles.clone())));
        }
    }
    // Something else before, so that numbers do not begin with 0, and a surface given by a formula between.
    let with = |others: Vec<Geometry>| {
        let mut all = vec![shared(soup(&mut Random::new(1), 20)), common::ball(DVec3::splat(0.2), 0.1)];
        all.extend(others);
        embree(&all)
    };
    let (fast, oracle) = (with(instances), with(copies));
    let (mut hits, mut others) = (0, 0);
    for _ in 0..40_000 {
        let segment = ray(random.point(), random.direction());
        let (a, b) = (fast.closest(&segment), oracle.closest(&segment));
        assert_eq!(fast.blocked(&segment), a.is_some());
        hits += usize::from(b.is_some_and(|b| b.geometry > 1));
        others += usize::from(a.map(|a| (a.geometry, a.primitive)) != b.map(|b| (b.geometry, b.primitive)));
        if let (Some(a), Some(b)) = (a, b)
            && a.geometry == b.geometry
            && a.primitive == b.primitive
        {
            assert!((a.t - b.t).abs() < 1e-3, "{segment:?}: {a:?} {b:?}");
        }
    }
    // At edges either of two triangles may be named.
    assert!(hits > 2_000 && others < 20, "{hits} hits, {others} differ");
}
