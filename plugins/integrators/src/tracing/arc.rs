//! All that intersection sees of a ray.

use bhs_core::real::{Real, Vector};

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

    /// The second derivative of [`Arc::point`], at least to some digits: it speeds up the search for where curve and surface meet.
    fn curvature(&self, s: F) -> Vector<F>;

    /// [`Arc::point`] and [`Arc::tangent`], which together may cost little more than one of them.
    #[inline(always)]
    fn point_and_tangent(&self, s: F) -> (Vector<F>, Vector<F>) {
        (self.point(s), self.tangent(s))
    }

    /// The largest distance from the chord between the points at `a` and `b` > `a` to the curve there, measured across the chord; rather too
    /// large than too small.
    fn gap(&self, a: F, b: F) -> F;

    /// A length of parameter from `from` on after which [`Arc::gap`] is about `gap` > 0, and no more; may go beyond the end, and is above 0.
    fn stride(&self, from: F, gap: F) -> F;

    /// About the parameter of the point of the curve that lies beside the point at the share `share` of the chord from `a` to `b`.
    #[inline(always)]
    fn beside(&self, a: F, b: F, share: F) -> F {
        share.fma(b - a, a)
    }

    /// The same curve, cut short at the parameter `end`.
    fn until(self, end: F) -> Self;

    /// The curve of ray number `i`.
    fn lane(&self, i: usize) -> Self::One;
}

/// Holds every implementation to what [`Arc`] promises.
#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use bhs_core::real::Mask;
    use glam::DVec3;

    /// Fails unless `arc` is as [`Arc`] says, in `chords` pieces: derivatives are those of the points to the share `precision`, no gap is exceeded,
    /// strides keep their gap and are no shorter than `waste` times what they could be, and a lane is as all of them.
    pub(crate) fn check<F: Real, A: Arc<F>>(arc: &A, chords: usize, precision: f64, waste: f64) {
        let c = F::splat;
        let (start, end) = (arc.start(), arc.end());
        assert!(start.le(end).all());
        let at = |share: f64| c(share).fma(end - start, start);
        for k in 0..chords {
            let (a, b) = (at(k as f64 / chords as f64), at((k + 1) as f64 / chords as f64));
            let middle = (a + b) * c(0.5);
            derivatives(arc, middle, (b - a) * c(1e-3), precision);
            let gap = arc.gap(a, b);
            let largest = largest_gap(arc, a, b);
            assert!(largest.le(gap.fma(c(1.0 + 1e-9), arc.point(a).largest() * c(1e-13))).all(), "{largest:?} exceeds {gap:?}");
            // A stride with an eighth of the gap is within the piece.
            let stride = arc.stride(a, gap * c(0.125));
            assert!(stride.gt(c(0.0)).all());
            let stride = stride.min(end - a);
            let found = arc.gap(a, a + stride);
            assert!(found.le((gap * c(0.125)).fma(c(1.01), c(1e-13))).all(), "{found:?} of {gap:?}");
            assert!(stride.ge((b - a) * c(waste)).all(), "{stride:?} of {:?}", b - a);
        }
        let half = arc.until(at(0.5));
        assert_eq!(half.end().lane(0), at(0.5).lane(0));
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
        let ([p0, p1], [t0, t1]) = ([s - h, s + h].map(|s| arc.point(s)), [s - h, s + h].map(|s| arc.tangent(s)));
        let per = F::splat(0.5) / h;
        let (slope, bend) = ((p1 - p0) * per, (t1 - t0) * per);
        for i in 0..F::COUNT {
            let t = arc.tangent(s).lane(i);
            assert!((slope.lane(i) - t).length() < precision * t.length(), "tangent {t} is {}", slope.lane(i));
            let second = arc.curvature(s).lane(i);
            let scale = second.length().max(precision * t.length() / h.lane(i));
            assert!((bend.lane(i) - second).length() < 1e3 * precision * scale, "curvature {second} is {}", bend.lane(i));
        }
    }

    fn largest_gap<F: Real, A: Arc<F>>(arc: &A, a: F, b: F) -> F {
        let (from, chord) = (arc.point(a), arc.point(b) - arc.point(a));
        let along = chord.normalize();
        let mut largest = F::splat(0.0);
        for k in 1..16 {
            let off = arc.point(F::splat(f64::from(k) / 16.0).fma(b - a, a)) - from;
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

        fn curvature(&self, _: F) -> Vector<F> {
            Vector::all(DVec3::new(0.0, 2.0, 0.0))
        }

        fn gap(&self, a: F, b: F) -> F {
            (b - a) * (b - a) * F::splat(0.25)
        }

        fn stride(&self, _: F, gap: F) -> F {
            (F::splat(4.0) * gap).sqrt()
        }

        fn until(self, end: F) -> Self {
            Self(end)
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
            fn curvature(&self, s: f64) -> Vector<f64> {
                self.0.curvature(s)
            }
            fn gap(&self, a: f64, b: f64) -> f64 {
                0.1 * self.0.gap(a, b)
            }
            fn stride(&self, from: f64, gap: f64) -> f64 {
                self.0.stride(from, gap)
            }
            fn until(self, end: f64) -> Self {
                Self(self.0.until(end))
            }
            fn lane(&self, _: usize) -> Self {
                *self
            }
        }
        check(&Wrong(Thrown(2.0)), 4, 1e-6, 0.3);
    }
}
