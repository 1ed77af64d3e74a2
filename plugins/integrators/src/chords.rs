//! From steps of an orbit to hits on surfaces: chords and their intersection. Knows no differential equation.
//!
//! The chord between two points of an orbit `dphi` apart strays from it by at most about `(3/16) rs dphi^2`, whatever r and b
//! are: equal steps in phi make equal errors.

use crate::orbit::{OrbitPlane, State, Step};
use bhs_core::blackhole::BlackHole;
use bhs_core::geometry::{Aabb, Segment};
use bhs_core::integrator::SurfaceHit;
use bhs_core::stats::TraceLog;
use bhs_core::world::World;
use glam::DVec3;

/// How far a chord reaches beyond its ends, relative to the coordinates there: neighbouring chords overlap by more than
/// single precision can tear them apart.
const OVERLAP: f64 = 16.0 * f32::EPSILON as f64;

/// The chords of one orbit through one world.
pub struct Chords<'w> {
    world: &'w World,
    plane: OrbitPlane,
    bounds: Aabb,
    /// 1/r of the sphere around the hole that holds all geometry; infinite where there is none.
    u_bound: f64,
    /// Where the next chord begins, if it continues a previous one.
    last: Option<DVec3>,
    origin: DVec3,
}

impl<'w> Chords<'w> {
    /// The chords of the orbit in `plane` that begins at `origin`.
    pub fn new(world: &'w World, hole: &BlackHole, plane: OrbitPlane, origin: DVec3) -> Self {
        let reach = world.bounds.corners().into_iter().map(|c| (c - hole.center).length()).fold(0.0, f64::max);
        let margin = OVERLAP * (world.bounds.min.abs().max(world.bounds.max.abs())).max_element();
        let empty = world.bounds.is_empty();
        Self {
            world,
            plane,
            bounds: world.bounds.grown(margin),
            u_bound: if empty { f64::INFINITY } else { 1.0 / (reach + margin) },
            last: None,
            origin,
        }
    }

    /// The first surface that the chord of `step` meets. A step that leaves the bounds is cut where it does; one that ends
    /// at infinity has no chord beyond them.
    pub fn meet(&mut self, step: &Step, log: &mut TraceLog) -> Option<SurfaceHit> {
        if self.u_bound == f64::INFINITY || (step.start.u < self.u_bound && step.end.u <= 0.0) {
            return None;
        }
        let leaves = step.start.u > self.u_bound && step.end.u < self.u_bound;
        let end = if leaves { step.crossing(self.u_bound) } else { step.end };
        let from = self.last.unwrap_or(self.origin);
        let to = self.plane.point(&end);
        let way = to - from;
        // Overlap with the chord before: but the first one begins where the ray does, off the surface that it leaves.
        let length = way.length();
        if length == 0.0 {
            return None;
        }
        let overlap = |p: DVec3| OVERLAP * p.abs().max_element() / length;
        let t_min = if self.last.is_some() { -overlap(from) } else { 0.0 };
        self.last = Some(to);
        log.point(to);

        let Some((enter, leave)) = self.bounds.clip(from, way, t_min, 1.0 + overlap(to)) else {
            log.counters.chords_skipped += 1;
            return None;
        };
        log.counters.queries += 1;
        let segment = Segment { origin: from + way * enter, direction: way, t_min: 0.0, t_max: leave - enter };
        let hit = self.world.intersector.closest(&segment)?;
        let located = self.world.locate(&segment, &hit);
        let mut surface = SurfaceHit {
            point: located.point,
            direction: way / length,
            geometry: hit.geometry,
            primitive: hit.primitive,
            barycentric: located.barycentric,
        };
        let state = self.state_at(&step.until(end), located.point);
        log.phi = state.phi;
        let tangent = self.plane.direction(&state);
        // The orbit's own tangent, unless it would arrive from the other side of the surface than the chord did.
        let normal = self.world.surface(&surface).normal;
        if tangent.dot(normal) * surface.direction.dot(normal) > 0.0 {
            surface.direction = tangent;
        }
        Some(surface)
    }

    /// The orbit's state at the angle of a point near the chord of `step`.
    fn state_at(&self, step: &Step, point: DVec3) -> State {
        let ahead = point - self.plane.center;
        let (sin, cos) = step.start.phi.sin_cos();
        let e_r = self.plane.e1 * cos + self.plane.e2 * sin;
        let e_phi = self.plane.e2 * cos - self.plane.e1 * sin;
        let swept = ahead.dot(e_phi).atan2(ahead.dot(e_r));
        step.at((step.start.phi + swept).clamp(step.start.phi, step.end.phi))
    }
}
