//! What chords meet, side by side: questions to the intersector, and plain hits on facets ([`crate::refine`] and `Chords::plain_hit` in lanes).

use crate::chords::{OVERLAP, SPLITS, Span};
use crate::packet::{Packet, Places};
use crate::refine::SMALL;
use crate::spherical::packet_orbit::{Polars, Steps};
use bhs_core::geometry::Segment;
use bhs_core::integrator::SurfaceHit;
use bhs_core::intersector::PrimitiveHit;
use bhs_core::lanes::{LANES, Lanes, Vectors, none, of_bits, pick, set_bits};
use crate::log::TraceLog;
use bhs_core::world::World;
use glam::{DVec2, DVec3};

/// Corrections of where an orbit meets a facet; one that needs more is not as most are.
const CORRECTIONS: u32 = 4;

/// Chords that are asked about.
#[derive(Clone, Copy)]
pub(crate) struct Asked {
    /// Where they begin.
    pub from: Places,
    /// Where they end.
    pub to: Places,
    /// From the one to the other.
    pub way: Vectors,
    /// Their lengths.
    pub length: Lanes,
    /// The angles that they sweep (rad).
    pub swept: Lanes,
    /// The chords before them, and which of them have one.
    pub before: Vectors,
    pub has_before: Lanes,
}

impl Asked {
    /// No chords.
    fn nothing() -> Self {
        let (zero, nowhere) = (none(), Vectors::all(DVec3::ZERO));
        let place = Places { phi: zero, u: zero, points: nowhere };
        Self { from: place, to: place, way: nowhere, length: zero, swept: zero, before: nowhere, has_before: zero }
    }
}

/// What chords have met.
pub(crate) struct Hits {
    /// Bits of the chords that have met anything.
    pub touched: u32,
    /// Those chords.
    pub asked: Asked,
    /// The parts of them that were asked about, the parameters where these begin, and what they met.
    chords: [(Segment, f64, PrimitiveHit); LANES],
    /// Parameters of the chords.
    t: [f64; LANES],
    /// Bits of those that met facets, and the corners of these, by coordinate.
    facets: u32,
    corners: [[[f64; LANES]; 3]; 3],
}

impl Default for Hits {
    #[inline(always)]
    fn default() -> Self {
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
}

impl Hits {
    /// Forgets them.
    #[inline]
    pub fn clear(&mut self) {
        (self.touched, self.facets) = (0, 0);
    }

    /// The chord of ray number `i` has met `hit`: the part `segment` of it, which begins at its parameter `enter`.
    #[inline]
    pub fn note(&mut self, world: &World, i: usize, segment: Segment, enter: f64, hit: PrimitiveHit) {
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
    pub fn keep(&mut self, asked: &Asked, which: Lanes) {
        let old = self.asked;
        self.asked = Asked {
            from: asked.from.or(&old.from, which),
            to: asked.to.or(&old.to, which),
            way: asked.way.or(old.way, which),
            length: pick(which, asked.length, old.length),
            swept: pick(which, asked.swept, old.swept),
            before: asked.before.or(old.before, which),
            has_before: pick(which, asked.has_before, old.has_before),
        };
    }

    /// What the chord of ray number `i` has met: see [`Hits::note`].
    pub fn chord(&self, i: usize) -> (&Segment, f64, &PrimitiveHit) {
        let (segment, enter, hit) = &self.chords[i];
        (segment, *enter, hit)
    }
}

impl Packet<'_> {
    /// Asks what the chords of `rays` meet, and notes it in `hits`. Bits of those that meet something.
    #[inline(always)]
    pub(crate) fn ask(&self, asked: &Asked, rays: Lanes, hits: &mut Hits, log: &mut TraceLog) -> u32 {
        let c = Lanes::splat;
        let overlap = |p: &Vectors| c(OVERLAP) * p.largest() / asked.length;
        let t_min = pick(asked.has_before, -overlap(&asked.from.points), c(0.0)).to_array();
        let t_max = (c(1.0) + overlap(&asked.to.points)).to_array();
        let within = (self.contains(&asked.from.points) & self.contains(&asked.to.points)).to_bitmask();
        let ([x, y, z], [dx, dy, dz]) = (asked.from.points.to_arrays(), asked.way.to_arrays());
        let mut meets = 0;
        for i in set_bits((rays & asked.length.simd_gt(c(0.0))).to_bitmask()) {
            let (from, way) = (DVec3::new(x[i], y[i], z[i]), DVec3::new(dx[i], dy[i], dz[i]));
            let range =
                if within >> i & 1 == 1 { Some((t_min[i], t_max[i])) } else { self.bounds.clip(from, way, t_min[i], t_max[i]) };
            let Some((enter, leave)) = range else {
                log.counters.chords_skipped += 1;
                continue;
            };
            log.counters.queries += 1;
            let segment = Segment { origin: from + way * enter, direction: way, t_min: 0.0, t_max: leave - enter };
            if let Some(hit) = self.world.intersector.closest(&segment) {
                hits.note(self.world, i, segment, enter, hit);
                meets |= 1 << i;
            }
        }
        hits.keep(asked, of_bits(meets));
        meets
    }

    /// What has become of what chords have met: which rays have arrived there.
    pub(crate) fn settle(&mut self, steps: &Steps, hits: &Hits, log: &mut TraceLog) -> Lanes {
        let plain = self.plain_hits(steps, hits, log);
        let mut arrived = plain;
        for i in set_bits(hits.touched & !plain) {
            if let Some(hit) = self.settle_alone(steps, hits, i, log) {
                self.arrive(i, hit, log.phi, log);
                arrived |= 1 << i;
            }
        }
        of_bits(arrived)
    }

    /// What has become of the hit of ray number `i`, which is not as most are.
    #[cold]
    fn settle_alone(&self, steps: &Steps, hits: &Hits, i: usize, log: &mut TraceLog) -> Option<SurfaceHit> {
        let asked = &hits.asked;
        let (from, to) = (asked.from.lane(i), asked.to.lane(i));
        let before = (asked.has_before.to_bitmask() >> i & 1 == 1).then(|| asked.before.lane(i));
        self.alone(i, from, before).settle(&steps.lane(i), &Span { from, to, before }, hits.chord(i), SPLITS, log)
    }

    /// Which points lie within the box around all surfaces.
    #[inline(always)]
    fn contains(&self, p: &Vectors) -> Lanes {
        let (min, max) = (Vectors::all(self.bounds.min), Vectors::all(self.bounds.max));
        let between = |p: Lanes, min: Lanes, max: Lanes| p.simd_ge(min) & p.simd_le(max);
        between(p.x, min.x, max.x) & between(p.y, min.y, max.y) & between(p.z, min.z, max.z)
    }

    /// Settles those hits on facets that are as most are: ahead of where the chord begins, near to where the orbit meets the facet itself. Bits
    /// of the rays that had such.
    #[inline]
    fn plain_hits(&mut self, steps: &Steps, hits: &Hits, log: &mut TraceLog) -> u32 {
        let c = Lanes::splat;
        let Asked { from, to, way, length, swept, .. } = &hits.asked;
        let t = Lanes::from(hits.t);
        let touched = from.points.plus(*way, t);
        let rounding = c(OVERLAP) * touched.largest();
        let mut plain = of_bits(hits.facets) & (t * *length).simd_gt(rounding);

        // The facet, and its distance from the orbit times u: n.e_r(phi) - u(phi) n.(a - center).
        let corner = |k: usize| {
            let [x, y, z]: [[f64; LANES]; 3] = hits.corners[k];
            Vectors { x: Lanes::from(x), y: Lanes::from(y), z: Lanes::from(z) }
        };
        let center = Vectors::all(self.planes.center);
        let (a, ab, ac) = (corner(0), corner(1) - corner(0), corner(2) - corner(0));
        let n = ab.cross(ac);
        let (n1, n2, d) = (n.dot(self.planes.e1), n.dot(self.planes.e2), n.dot(a - center));
        let correction = |orbit: &Polars| {
            let value = n1 * orbit.cos + n2 * orbit.sin - d * orbit.u;
            let slope = n2 * orbit.cos - n1 * orbit.sin - d * orbit.du;
            let curvature = -(value + c(1.5 * self.rs) * d * orbit.u * orbit.u);
            -(value * slope) / (slope * slope - c(0.5) * value * curvature)
        };

        // Halley's method, from where the chord has it. If the ends of the chord lie on both sides of the plane, so does the orbit between them.
        let side = |p: &Places| n.dot(p.points - a).simd_lt(c(0.0));
        let bracketed = side(from) ^ side(to);
        let mut orbit = steps.polar(from.phi + self.planes.angles(from.points, touched));
        let (beyond, small) = (pick(bracketed, c(0.0), c(0.5) * *swept), c(SMALL) * *swept);
        for attempt in 0..CORRECTIONS {
            let change = correction(&orbit);
            let better = orbit.phi + change;
            plain = plain & better.simd_gt(from.phi - beyond) & better.simd_lt(to.phi + beyond);
            let last = change.abs().simd_le(small);
            if attempt + 1 == CORRECTIONS || (plain & !last).none() {
                plain &= last;
                orbit = orbit.moved(self.rs, change);
                break;
            }
            orbit = steps.polar(better);
        }

        // The point of the facet, its weights, and how far beside the orbit it is.
        let met = self.planes.points(orbit.u, orbit.cos, orbit.sin);
        let per_nn = c(1.0) / n.length_squared();
        let p = met - a;
        let v = (n.dot(p.cross(ac)) * per_nn).fast_clamp(c(0.0), c(1.0));
        let w = (n.dot(ab.cross(p)) * per_nn).fast_max(c(0.0)).fast_min(c(1.0) - v);
        let point = a.plus(ab, v).plus(ac, w);
        let near = c(0.75 * self.rs) * *swept * *swept + rounding;
        plain = plain
            & (point - met).length_squared().simd_le(rounding * rounding)
            & (point - touched).length_squared().simd_le(near * near);
        let bits = plain.to_bitmask();
        if bits == 0 {
            return 0;
        }

        // A tangent that would arrive from the other side than the chord does so at grazing incidence: it is turned to this side.
        let tangent = self.planes.directions(&orbit);
        let along = tangent.dot(n);
        let same_side = (along * way.dot(n)).simd_gt(c(0.0));
        let direction = tangent.plus(n, pick(same_side, c(0.0), c(-2.0) * along * per_nn));
        let ([x, y, z], [dx, dy, dz]) = (point.to_arrays(), direction.to_arrays());
        let (v, w, phi) = (v.to_array(), w.to_array(), orbit.phi.to_array());
        for i in set_bits(bits) {
            let PrimitiveHit { geometry, primitive, .. } = hits.chords[i].2;
            let (point, direction) = (DVec3::new(x[i], y[i], z[i]), DVec3::new(dx[i], dy[i], dz[i]));
            let barycentric = DVec2::new(v[i], w[i]);
            let is_crowded = self.world.intersector.is_crowded(point);
            self.arrive(i, SurfaceHit { point, direction, geometry, primitive, barycentric, is_crowded }, phi[i], log);
        }
        bits
    }
}
