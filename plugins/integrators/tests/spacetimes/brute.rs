//! Adaptive rays against steps so small that nothing can go wrong: formulas written down once more, chords of single steps, the reference
//! intersector.

use crate::common::Dice;
use crate::rooms::{outcome, ray, spacetimes, trace, world};
use crate::{adaptive, count};
use bhs_core::geometry::Segment;
use bhs_core::ray::{Arrival, Ray};
use bhs_core::spacetime::{Class, GradedIndex, Side, Spacetime};
use bhs_engine::world::World;
use glam::DVec3;
use std::sync::Arc;

/// Length of a step (scene units).
const STEP: f64 = 5e-4;

/// What may be where single precision ends.
const OVERLAP: f64 = 1e-6;

#[derive(Debug, PartialEq)]
enum End {
    Surface(u32, u32, DVec3),
    Fallen,
    Lost,
}

/// `x'' = grad(n^2)/2` by the classic Runge-Kutta method, one chord a step.
fn follow(world: &World, index: &dyn GradedIndex, captures: &[bhs_core::spacetime::Ball], ray: &Ray) -> End {
    let force = |x: DVec3| index.index(x).1;
    let n = |x: DVec3| index.index(x).0.sqrt();
    let (mut x, mut side) = (ray.origin, ray.side);
    let mut v = ray.direction * n(x);
    for _ in 0..200_000 {
        let h = STEP / v.length() / n(x).max(1.0);
        let k1 = (v, force(x));
        let k2 = (v + k1.1 * (0.5 * h), force(x + k1.0 * (0.5 * h)));
        let k3 = (v + k2.1 * (0.5 * h), force(x + k2.0 * (0.5 * h)));
        let k4 = (v + k3.1 * h, force(x + k3.0 * h));
        let to = x + (k1.0 + 2.0 * (k2.0 + k3.0) + k4.0) * (h / 6.0);
        let w = v + (k1.1 + 2.0 * (k2.1 + k3.1) + k4.1) * (h / 6.0);
        let way = to - x;
        let segment = Segment { origin: x, direction: way, t_min: -OVERLAP / way.length(), t_max: 1.0 + OVERLAP / way.length() };
        if let Some(hit) = world.half(side).and_then(|half| half.closest(&segment, None)) {
            return End::Surface(hit.geometry, hit.primitive, world.locate(&segment, &hit).point);
        }
        if captures.iter().any(|b| (to - b.center).length() < b.radius && (to - b.center).dot(w) < 0.0) {
            return End::Fallen;
        }
        (x, v) = (to, w);
        if let Some(throat) = index.throat().filter(|t| (to - t.center).length() < t.radius) {
            // The inversion and its derivative.
            let from_center = to - throat.center;
            let scale = throat.radius * throat.radius / from_center.length_squared();
            x = throat.center + from_center * scale;
            v = (w - from_center * (2.0 * from_center.dot(w) / from_center.length_squared())) * scale;
            v = v.normalize() * n(x);
            side = side.other();
        }
    }
    End::Lost
}

fn compared(spacetime: &Arc<dyn Spacetime>, rays: u64) -> (u64, Vec<String>) {
    let Class::Index(index) = spacetime.class() else { return (0, Vec::new()) };
    let captures = spacetime.captures();
    let (mut seen, mut different) = (0, Vec::new());
    for number in 0..rays.div_ceil(10) {
        let mut dice = Dice(77_000 + number);
        let world = world(&mut dice, spacetime);
        let integrator = adaptive(1e-6, spacetime);
        for _ in 0..10 {
            let ray = ray(&mut dice, &world);
            let (found, _) = trace(&*integrator, &world, &ray);
            let right = follow(&world, index, &captures, &ray);
            assert_ne!(right, End::Lost);
            seen += 1;
            match (found, right) {
                (Arrival::Captured, End::Fallen) => {}
                (Arrival::Surface(hit), End::Surface(geometry, primitive, point))
                    if outcome(&found) == (0, geometry, primitive) && (hit.point - point).length() < 1e-5 => {}
                (found, right) => different.push(format!("{ray:?}: {found:?}, {right:?}")),
            }
        }
    }
    (seen, different)
}

#[test]
fn adaptive_sees_what_tiny_steps_see() {
    for (name, spacetime) in spacetimes() {
        let (seen, different) = compared(&spacetime, count(60).min(10_000));
        assert!(different.len() as u64 * 50 <= seen, "{name}: of {seen} {different:#?}");
        assert!(seen > 0 || !matches!(spacetime.class(), Class::Index(_)), "{name}");
    }
}

#[test]
fn sides_are_those_of_what_is_met() {
    for (name, spacetime) in spacetimes().into_iter().filter(|(_, s)| s.has_far_side()) {
        let mut dice = Dice(21);
        let world = world(&mut dice, &spacetime);
        let mut met = [0, 0];
        for _ in 0..100 {
            if let (Arrival::Surface(hit), _) = trace(&*adaptive(1e-3, &spacetime), &world, &ray(&mut dice, &world)) {
                met[usize::from(world.side_of(hit.geometry) == Side::Far)] += 1;
            }
        }
        assert!(met.iter().all(|n| *n > 20), "{name}: {met:?}");
    }
}
