//! All that intersection sees of a ray.

use bhs_core::real::{Real, Vector};
use glam::DVec3;

/// A piece of the curve that a ray follows, or of those of several rays side by side, with dense output.
///
/// The parameter grows along the ray, and is whatever suits the curve: a swept angle, an affine parameter. All points between start and end
/// are finite: a ray that leaves for ever has a last piece that ends somewhere beyond all that it could meet. Points are in the chart in which
/// world space is drawn (scene units), distances and angles are Euclidean there.
pub trait Arc<F: Real>: Copy {
    /// The curve of one of the rays.
    type One: Arc<f64>;

    /// The parameter where it starts.
    fn start(&self) -> F;

    /// The parameter where it ends, not below that where it starts.
    fn end(&self) -> F;

    /// The point at the parameter `s`, which lies between start and end.
    fn point(&self, s: F) -> Vector<F>;

    /// The derivative of [`Arc::point`], of any length but 0.
    fn tangent(&self, s: F) -> Vector<F>;

    /// [`Arc::point`] and [`Arc::tangent`], which together may cost little more than one of them.
    #[inline(always)]
    fn point_and_tangent(&self, s: F) -> (Vector<F>, Vector<F>) {
        (self.point(s), self.tangent(s))
    }

    /// The largest distance from the chord between the points at `a` and `b` > `a` to the curve there, measured across the chord; rather too
    /// large than too small.
    fn gap(&self, a: F, b: F) -> F;

    /// Whether [`Arc::stride`] is the same wherever it starts.
    const HAS_EQUAL_STRIDES: bool = false;

    /// A length of parameter from `from` on after which [`Arc::gap`] is about `gap` > 0, and no more; may go beyond the end, and is above 0.
    fn stride(&self, from: F, gap: F) -> F;

    /// Chords of this length of parameter are so long that a single one to the end costs less than a look at the free space.
    const LONG: f64 = f64::INFINITY;

    /// The parameter of the farthest point, not beyond `end`, that one leap from `from` on may lead to: the gap of the stretch is not to be
    /// large beside free space.
    #[inline(always)]
    fn farthest_leap(&self, _from: F, end: F) -> F {
        end
    }

    /// How fast a curve may stray from the chord between its points `points` at the parameters `ends`, over the way along the chord; `gap` is at
    /// least [`Arc::gap`] of it, `per_length` one over the length of the chord.
    #[inline(always)]
    fn growth(&self, _ends: [F; 2], _points: [Vector<F>; 2], gap: F, per_length: F) -> F {
        // Four times the gap in the share of the parameter, which grows no faster than with twice the share of the way.
        F::splat(8.0) * gap * per_length
    }

    /// About the parameter of the point of the curve that lies beside the point at the share `share` of the chord between the points `points` at
    /// the parameters `ends`.
    #[inline(always)]
    fn beside(&self, ends: [F; 2], _points: [Vector<F>; 2], share: F) -> F {
        share.times_plus(ends[1] - ends[0], ends[0])
    }

    /// What [`Arc::height`] has to know of a plane.
    type Plane: Copy;

    /// The planes with the normals `normal`, of any length, through the points `point`.
    fn plane(&self, normal: Vector<F>, point: Vector<F>) -> Self::Plane;

    /// A function that vanishes where the curve meets the plane and has the sign of the side on which it is, at the parameter `s`, with its
    /// first derivative and, at least to some digits, its second.
    fn height(&self, plane: &Self::Plane, s: F) -> [F; 3];

    /// Whether no ray can be at `point`: chords of curves that end at a horizon may pass behind it.
    fn is_nowhere(&self, _point: DVec3) -> bool {
        false
    }

    /// The curve of ray number `i`.
    fn lane(&self, i: usize) -> Self::One;
}

/// Holds every implementation to what [`Arc`] promises.
#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use bhs_core::real::Mask;

    /// Fails unless `arc` is as [`Arc`] says, in `chords` pieces: derivatives are those of the points to the share `precision`, no gap is exceeded,
    /// strides keep their gap and are no shorter than `waste` times what they could be, and a lane is as all of them.
    pub(crate) fn check<F: Real, A: Arc<F>>(arc: &A, chords: usize, precision: f64, waste: f64) {
        let c = F::splat;
        let (start, end) = (arc.start(), arc.end());
        assert!(start.le(end).all());
        let at = |share: f64| c(share).times_plus(end - start, start);
        for k in 0..chords {
            let (a, b) = (at(k as f64 / chords as f64), at((k + 1) as f64 / chords as f64));
            let middle = (a + b) * c(0.5);
            derivatives(arc, middle, (b - a) * c(1e-3), precision);
            let gap = arc.gap(a, b);
            let largest = largest_gap(arc, a, b);
            assert!(
                largest.le(gap.times_plus(c(1.0 + 1e-9), arc.point(a).largest() * c(1e-13))).all(),
                "{largest:?} exceeds {gap:?}"
            );
            // A stride with an eighth of the gap is within the piece.
            let stride = arc.stride(a, gap * c(0.125));
            assert!(stride.gt(c(0.0)).all());
            let stride = stride.min(end - a);
            let found = arc.gap(a, a + stride);
            assert!(found.le((gap * c(0.125)).times_plus(c(1.01), c(1e-13))).all(), "{found:?} of {gap:?}");
            assert!(stride.ge((b - a) * c(waste)).all(), "{stride:?} of {:?}", b - a);
        }
        for i in 0..F::COUNT {
            let one = arc.lane(i);
            assert_eq!((one.start(), one.end()), (start.lane(i), end.lane(i)));
            for share in [0.0, 0.3, 1.0] {
                let s = at(share);
                let (p, t) = arc.point_and_tangent(s);
                let (q, v) = one.point_and_tangent(s.lane(i));
                let scale = p.lane(i).length().max(1.0);
                assert!((p.lane(i) - DVec3::from(q)).length() < 1e-13 * scale, "{:?} {q:?}", p.lane(i));
                assert!((t.lane(i) - DVec3::from(v)).length() < 1e-12 * t.lane(i).length(), "{:?} {v:?}", t.lane(i));
                assert!((arc.point(s).lane(i) - p.lane(i)).length() < 1e-13 * scale);
                assert!((arc.tangent(s).lane(i) - t.lane(i)).length() < 1e-12 * t.lane(i).length());
            }
        }
    }

    fn derivatives<F: Real, A: Arc<F>>(arc: &A, s: F, h: F, precision: f64) {
        let ends = [s - h, s + h];
        let [p0, p1] = ends.map(|s| arc.point(s));
        let slope = (p1 - p0) * (F::splat(0.5) / h);
        for i in 0..F::COUNT {
            let t = arc.tangent(s).lane(i);
            assert!((slope.lane(i) - t).length() < precision * t.length(), "tangent {t} is {}", slope.lane(i));
        }
        // A plane that the curve meets here, and one that it does not.
        for (share, tilt) in [(0.0, DVec3::new(0.3, -0.4, 0.2)), (0.7, DVec3::new(-0.1, 0.5, 0.6))] {
            let point = p0 + (p1 - p0) * F::splat(0.5 + share);
            let normal = arc.tangent(s).normalize() + Vector::all(tilt);
            let plane = arc.plane(normal, point);
            let [low, here, high] = [s - h, s, s + h].map(|s| arc.height(&plane, s));
            for i in 0..F::COUNT {
                let scale = high[0].lane(i).abs().max(low[0].lane(i).abs());
                let side = (arc.point(s) - point).dot(normal).lane(i);
                let is_far = side.abs() > 1e-3 * (p1 - p0).length().lane(i);
                assert!(!is_far || side * here[0].lane(i) > 0.0, "{side} {here:?}");
                for k in 0..2 {
                    let found = (high[k] - low[k]).lane(i) / (2.0 * h.lane(i));
                    let error = (found - here[k + 1].lane(i)).abs() * h.lane(i);
                    let whole = if k == 0 { scale } else { low[1].lane(i).abs().max(high[1].lane(i).abs()) };
                    assert!(error < [1.0, 10.0][k] * precision.max(1e-6) * whole, "{k}: {found} is {:?}", here[k + 1]);
                }
            }
        }
    }

    fn largest_gap<F: Real, A: Arc<F>>(arc: &A, a: F, b: F) -> F {
        let (from, chord) = (arc.point(a), arc.point(b) - arc.point(a));
        let along = chord.normalize();
        let mut largest = F::splat(0.0);
        for k in 1..16 {
            let off = arc.point(F::splat(f64::from(k) / 16.0).times_plus(b - a, a)) - from;
            largest = largest.max((off - along * off.dot(along)).length());
        }
        largest
    }

    /// A parabola.
    #[derive(Clone, Copy)]
    struct Thrown<F>(F);

    impl<F: Real> Arc<F> for Thrown<F> {
        type One = Thrown<f64>;

        fn start(&self) -> F {
            F::splat(0.0)
        }

        fn end(&self) -> F {
            self.0
        }

        fn point(&self, s: F) -> Vector<F> {
            Vector { x: F::splat(3.0) * s, y: s * s, z: F::splat(1.0) }
        }

        fn tangent(&self, s: F) -> Vector<F> {
            Vector { x: F::splat(3.0), y: s + s, z: F::splat(0.0) }
        }

        type Plane = [Vector<F>; 2];

        fn plane(&self, normal: Vector<F>, point: Vector<F>) -> [Vector<F>; 2] {
            [normal, point]
        }

        fn height(&self, [normal, point]: &[Vector<F>; 2], s: F) -> [F; 3] {
            [(self.point(s) - *point).dot(*normal), self.tangent(s).dot(*normal), F::splat(2.0) * normal.y]
        }

        fn gap(&self, a: F, b: F) -> F {
            (b - a) * (b - a) * F::splat(0.25)
        }

        fn stride(&self, _: F, gap: F) -> F {
            (F::splat(4.0) * gap).sqrt()
        }

        fn lane(&self, i: usize) -> Thrown<f64> {
            Thrown(self.0.lane(i))
        }
    }

    #[test]
    fn a_parabola_is_an_arc() {
        check(&Thrown(2.0), 4, 1e-6, 0.3);
        check(&Thrown(bhs_core::lanes::Lanes::splat(2.0)), 4, 1e-6, 0.3);
    }

    #[test]
    #[should_panic(expected = "exceeds")]
    fn arcs_that_stray_are_found_out() {
        #[derive(Clone, Copy)]
        struct Wrong(Thrown<f64>);
        impl Arc<f64> for Wrong {
            type One = Self;
            fn start(&self) -> f64 {
                self.0.start()
            }
            fn end(&self) -> f64 {
                self.0.end()
            }
            fn point(&self, s: f64) -> Vector<f64> {
                self.0.point(s)
            }
            fn tangent(&self, s: f64) -> Vector<f64> {
                self.0.tangent(s)
            }
            type Plane = [Vector<f64>; 2];
            fn plane(&self, normal: Vector<f64>, point: Vector<f64>) -> [Vector<f64>; 2] {
                self.0.plane(normal, point)
            }
            fn height(&self, plane: &[Vector<f64>; 2], s: f64) -> [f64; 3] {
                self.0.height(plane, s)
            }
            fn gap(&self, a: f64, b: f64) -> f64 {
                0.1 * self.0.gap(a, b)
            }
            fn stride(&self, from: f64, gap: f64) -> f64 {
                self.0.stride(from, gap)
            }
            fn lane(&self, _: usize) -> Self {
                *self
            }
        }
        check(&Wrong(Thrown(2.0)), 4, 1e-6, 0.3);
    }
}
