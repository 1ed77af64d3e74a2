//! What chords meet: questions to the intersector, and plain hits on facets.

use super::Packet;
use crate::tracing::arc::Arc;
use crate::tracing::meeting::{CORRECTIONS_OF_PLAIN_HITS, SMALL};
use crate::tracing::places::CurvePoints;
use crate::tracing::resolve::{Chord, One};
use crate::tracing::surfaces::{OVERLAP, Surfaces};
use bhs_core::geometry::Segment;
use bhs_core::intersector::PrimitiveHit;
use bhs_core::lanes::{LANES, set_bits};
use bhs_core::ray::SurfaceHit;
use bhs_core::real::{Mask, Real, Vector};
use bhs_engine::world::World;
use glam::{DVec2, DVec3};

/// Chords that are asked about.
#[derive(Clone, Copy)]
pub(crate) struct Asked<F: Real> {
    /// Where they begin.
    pub from: CurvePoints<F>,
    /// Where they end.
    pub to: CurvePoints<F>,
    /// From the one to the other.
    pub way: Vector<F>,
    /// Their lengths.
    pub length: F,
    /// The chords before them, and which of them have one.
    pub before: Vector<F>,
    pub has_before: F::Mask,
    /// The parameters at which the piece ends for the rays.
    pub end: F,
}

impl<F: Real> Asked<F> {
    /// No chords.
    #[inline(always)]
    fn nothing() -> Self {
        let (zero, nowhere) = (F::splat(0.0), Vector::all(DVec3::ZERO));
        let place = CurvePoints { s: zero, points: nowhere };
        Self { from: place, to: place, way: nowhere, length: zero, before: nowhere, has_before: F::Mask::NONE, end: zero }
    }
}

/// What chords have met.
pub(crate) struct Hits<F: Real> {
    /// Bits of the chords that have met anything.
    touched: u32,
    /// Those chords.
    asked: Asked<F>,
    /// The parts of them that were asked about, the parameters where these begin, and what they met.
    chords: [(Segment, f64, PrimitiveHit); LANES],
    /// Parameters of the chords.
    t: [f64; LANES],
    /// Bits of those that met facets, and the corners of these, by coordinate.
    facets: u32,
    corners: [[[f64; LANES]; 3]; 3],
}

impl<F: Real> Hits<F> {
    /// None yet.
    #[inline(always)]
    pub fn new() -> Self {
        let segment = Segment { origin: DVec3::ZERO, direction: DVec3::ZERO, t_min: 0.0, t_max: 0.0 };
        let hit = PrimitiveHit { t: 0.0, geometry: 0, primitive: 0, is_crowded: false };
        Self {
            touched: 0,
            asked: Asked::nothing(),
            chords: [(segment, 0.0, hit); LANES],
            t: [0.0; LANES],
            facets: 0,
            corners: [[[0.0; LANES]; 3]; 3],
        }
    }

    /// Forgets them.
    #[inline]
    pub fn clear(&mut self) {
        (self.touched, self.facets) = (0, 0);
    }

    /// The chord of ray number `i` has met `hit`: the part `segment` of it, which begins at its parameter `enter`.
    #[inline(always)]
    fn note(&mut self, world: &World, i: usize, segment: Segment, enter: f64, hit: PrimitiveHit) {
        self.touched |= 1 << i;
        self.t[i] = enter + hit.t;
        if let Some(corners) = world.geometries[hit.geometry as usize].corners(hit.primitive) {
            self.facets |= 1 << i;
            for (lanes, corner) in self.corners.iter_mut().zip(corners) {
                for (lanes, coordinate) in lanes.iter_mut().zip(corner.to_array()) {
                    lanes[i] = coordinate;
                }
            }
        }
        self.chords[i] = (segment, enter, hit);
    }

    /// Keeps the chords `which` of those that were asked about.
    #[inline(always)]
    fn keep(&mut self, asked: &Asked<F>, which: F::Mask) {
        let old = self.asked;
        let (new_before, old_before) = (asked.has_before & which, old.has_before & !which);
        self.asked = Asked {
            from: asked.from.or(&old.from, which),
            to: asked.to.or(&old.to, which),
            way: asked.way.or(old.way, which),
            length: F::select(which, asked.length, old.length),
            before: asked.before.or(old.before, which),
            has_before: new_before | old_before,
            end: F::select(which, asked.end, old.end),
        };
    }
}

/// Which points lie within the box around `surfaces`.
#[inline(always)]
fn contains<F: Real>(surfaces: &Surfaces<'_>, p: &Vector<F>) -> F::Mask {
    let (min, max) = (Vector::all(surfaces.bounds.min), Vector::all(surfaces.bounds.max));
    let between = |p: F, min: F, max: F| p.ge(min) & p.le(max);
    between(p.x, min.x, max.x) & between(p.y, min.y, max.y) & between(p.z, min.z, max.z)
}

impl<F: Real> Packet<'_, F> {
    /// Bits of the chords that lie within the box around the surfaces of their side.
    #[inline(always)]
    fn within(&self, asked: &Asked<F>) -> u32 {
        let on = |surfaces: &Surfaces<'_>| (contains(surfaces, &asked.from.points) & contains(surfaces, &asked.to.points)).bits();
        let [near, far] = &self.surfaces;
        let near = near.map_or(0, on);
        if self.far == 0 {
            return near;
        }
        (near & !self.far) | (far.map_or(0, on) & self.far)
    }

    /// Asks what the chords of `rays` meet, and notes it in `hits`. Bits of those that meet something.
    #[inline(always)]
    pub(crate) fn ask<A: Arc<F>>(&mut self, piece: &A, asked: &Asked<F>, rays: F::Mask, hits: &mut Hits<F>) -> u32 {
        let c = F::splat;
        let overlap = |p: &Vector<F>| c(OVERLAP) * p.largest() / asked.length;
        let t_min = F::select(asked.has_before, -overlap(&asked.from.points), c(0.0)).to_array();
        let mut t_max = c(1.0) + overlap(&asked.to.points);
        if self.crossing.any() {
            // Nothing is behind the throat.
            t_max = F::select(self.crossing & asked.to.s.ge(piece.end()), c(1.0), t_max);
        }
        let t_max = t_max.to_array();
        let within = self.within(asked);
        let ([x, y, z], [dx, dy, dz]) = (asked.from.points.to_arrays(), asked.way.to_arrays());
        let mut meets = 0;
        for i in set_bits((rays & asked.length.gt(c(0.0))).bits()) {
            let Some(surfaces) = self.surfaces_of(i) else { continue };
            let (from, way) = (DVec3::new(x[i], y[i], z[i]), DVec3::new(dx[i], dy[i], dz[i]));
            let range = if within >> i & 1 == 1 {
                Some((t_min[i], t_max[i]))
            } else {
                surfaces.bounds.clip(from, way, t_min[i], t_max[i])
            };
            let cost = &mut self.ends[i].cost;
            let Some((enter, leave)) = range else {
                cost.chords_skipped += 1;
                continue;
            };
            cost.queries += 1;
            let segment = Segment { origin: from + way * enter, direction: way, t_min: 0.0, t_max: leave - enter };
            let hit = if self.departing >> i & 1 == 0 {
                surfaces.half.closest(&segment, None)
            } else {
                self.depart(i, surfaces, &segment, enter)
            };
            if let Some(hit) = hit {
                hits.note(self.world, i, segment, enter, hit);
                meets |= 1 << i;
            }
        }
        if meets != 0 {
            hits.keep(asked, F::Mask::of_bits(meets));
        }
        meets
    }

    /// What has become of what chords have met: which rays have arrived there.
    #[inline(always)]
    pub(crate) fn resolve_hits<A: Arc<F>>(&mut self, piece: &A, hits: &Hits<F>) -> F::Mask {
        let plain = self.plain_hits(piece, hits);
        let mut arrived = plain;
        for i in set_bits(hits.touched & !plain) {
            if let Some((hit, parameter)) = self.resolve_one(piece, hits, i) {
                self.arrive(i, hit, parameter);
                arrived |= 1 << i;
            }
        }
        F::Mask::of_bits(arrived)
    }

    /// What has become of the hit of ray number `i`, which is not as most are, and the parameter there.
    #[cold]
    fn resolve_one<A: Arc<F>>(&mut self, piece: &A, hits: &Hits<F>, i: usize) -> Option<(SurfaceHit, f64)> {
        let asked = &hits.asked;
        let (from, to) = (asked.from.lane(i), asked.to.lane(i));
        let before = (asked.has_before.bits() >> i & 1 == 1).then(|| asked.before.lane(i));
        let surfaces = self.surfaces_of(i)?;
        let piece = &piece.lane(i);
        let ends_at_throat = (self.crossing.bits() >> i & 1 == 1).then(|| piece.end());
        let rays = self.start.rays;
        let departure = self.departures[i].as_ref();
        let one = One { world: self.world, surfaces, piece, ray: rays.ray(i), target: rays.target(i), departure, ends_at_throat };
        let (segment, enter, hit) = &hits.chords[i];
        one.resolve_hit(&Chord { from, to, before }, (segment, *enter, hit), &mut self.ends[i].cost)
    }

    /// Resolves those hits on facets that are as most are: ahead of where the chord begins, near to where the curve meets the facet itself. Bits of
    /// the rays that had such.
    #[inline(always)]
    fn plain_hits<A: Arc<F>>(&mut self, piece: &A, hits: &Hits<F>) -> u32 {
        let c = F::splat;
        let Asked { from, to, way, length, .. } = &hits.asked;
        let t = F::from_fn(|i| hits.t[i]);
        let touched = from.points.plus(*way, t);
        let rounding = c(OVERLAP) * touched.largest();
        let mut plain = F::Mask::of_bits(hits.facets) & (t * *length).gt(rounding);

        let corner = |k: usize| {
            let [x, y, z] = &hits.corners[k];
            Vector { x: F::from_fn(|i| x[i]), y: F::from_fn(|i| y[i]), z: F::from_fn(|i| z[i]) }
        };
        let (a, ab, ac) = (corner(0), corner(1) - corner(0), corner(2) - corner(0));
        let n = ab.cross(ac);
        let plane = piece.plane(n, a);

        // Halley's method, from where the chord has it. If the ends of the chord lie on both sides of the plane, so does the curve between them.
        let side = |p: &CurvePoints<F>| n.dot(p.points - a).lt(c(0.0));
        let bracketed = side(from) ^ side(to);
        let swept = to.s - from.s;
        let mut s = piece.beside([from.s, to.s], [from.points, to.points], t);
        let (beyond, small) = (F::select(bracketed, c(0.0), c(0.5) * swept), c(SMALL) * swept);
        // A ray that has converged stays where it is, whatever those beside it need.
        let mut open = plain;
        for _ in 0..CORRECTIONS_OF_PLAIN_HITS {
            let [value, slope, curvature] = piece.height(&plane, s);
            let change = -(value * slope) / (slope * slope - c(0.5) * value * curvature);
            let better = s + change;
            let inside = better.gt(from.s - beyond) & better.lt(to.s + beyond);
            plain = plain & (inside | !open);
            s = F::select(open, better, s);
            open = open & inside & change.abs().gt(small);
            if !open.any() {
                break;
            }
        }
        plain = plain & !open;

        // The point of the facet, its weights, and how far beside the curve it is.
        let (met, tangent) = piece.point_and_tangent(s);
        let per_nn = c(1.0) / n.length_squared();
        let p = met - a;
        let v = (n.dot(p.cross(ac)) * per_nn).max(c(0.0)).min(c(1.0));
        let w = (n.dot(ab.cross(p)) * per_nn).max(c(0.0)).min(c(1.0) - v);
        let point = a.plus(ab, v).plus(ac, w);
        let near = c(4.0) * piece.gap(from.s, to.s) + rounding;
        plain =
            plain & (point - met).length_squared().le(rounding * rounding) & (point - touched).length_squared().le(near * near);
        let bits = plain.bits();
        if bits == 0 {
            return 0;
        }

        // A tangent that would arrive from the other side than the chord does so at grazing incidence: it is turned to this side.
        let tangent = tangent.normalize();
        let along = tangent.dot(n);
        let same_side = (along * way.dot(n)).gt(c(0.0));
        let direction = tangent.plus(n, F::select(same_side, c(0.0), c(-2.0) * along * per_nn));
        let ([x, y, z], [dx, dy, dz]) = (point.to_arrays(), direction.to_arrays());
        let (v, w, s) = (v.to_array(), w.to_array(), s.to_array());
        for i in set_bits(bits) {
            let PrimitiveHit { geometry, primitive, .. } = hits.chords[i].2;
            let (point, direction) = (DVec3::new(x[i], y[i], z[i]), DVec3::new(dx[i], dy[i], dz[i]));
            let barycentric = DVec2::new(v[i], w[i]);
            let is_crowded = self.surfaces_of(i).is_some_and(|surfaces| surfaces.half.is_crowded(point));
            self.arrive(i, SurfaceHit { point, direction, geometry, primitive, barycentric, is_crowded }, s[i]);
        }
        bits
    }
}
