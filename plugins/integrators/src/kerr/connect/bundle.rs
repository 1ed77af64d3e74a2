//! Rays around a hole that spins with their neighbours: the orbit, top and twist of `docs/physics.md`, section 5, differentiated by two angles of
//! the launch. Lengths are multiples of the mass, the axis is z.

use crate::kerr::connect::pencil::Pencil;
use bhs_core::real::{Real, Vector};

/// Holes of mass 1, one a ray.
#[derive(Clone, Copy, Debug)]
pub struct Spin<F> {
    /// Angular momentum over mass: that of the light's own sense of time.
    pub a: F,
    /// Square of the charge.
    pub charge_squared: F,
}

/// Rays at some point of their ways, with their neighbours.
#[derive(Clone, Copy, Debug)]
pub struct Bundle<F, const D: usize> {
    /// 1/r, and its derivative by Mino's time.
    pub u: [Pencil<F, D>; 2],
    /// The top, and its derivative.
    pub n: [[Pencil<F, D>; 3]; 2],
    /// The twist about the axis.
    pub chi: Pencil<F, D>,
    /// Constants of motion.
    pub k: Pencil<F, D>,
    /// Angular momentum about the axis.
    pub l: Pencil<F, D>,
}

/// The place of rays in oblate coordinates.
#[derive(Clone, Copy, Debug)]
pub struct Oblate<F> {
    /// Radius.
    pub r: F,
    /// `r^2 + a^2` and its root.
    pub square: F,
    /// The root of `square`.
    pub root: F,
    /// The unit vector with the angles of the place.
    pub n: Vector<F>,
    /// `r^2 + a^2 cos^2 theta`
    pub sigma: F,
}

impl<F: Real> Spin<F> {
    /// The oblate coordinates of the points `x`.
    #[inline(always)]
    pub fn oblate(&self, x: Vector<F>) -> Oblate<F> {
        let c = F::splat;
        let a2 = self.a * self.a;
        let from = x.length_squared() - a2;
        let az2 = a2 * x.z * x.z;
        let s = from.times_plus(from, c(4.0) * az2).sqrt();
        let r2 = F::select(from.gt(c(0.0)), c(0.5) * (from + s), c(2.0) * az2 / (s - from));
        let (r, square) = (r2.sqrt(), r2 + a2);
        let root = square.sqrt();
        let over = c(1.0) / root;
        let n = Vector { x: x.x * over, y: x.y * over, z: x.z / r };
        Oblate { r, square, root, n, sigma: (a2 * n.z).times_plus(n.z, r2) }
    }

    /// Rays from `x` in the chart directions `d`, and their neighbours, turned towards `aside`.
    #[inline(always)]
    pub fn launch<const D: usize>(&self, x: Vector<F>, d: Vector<F>, aside: [Vector<F>; D]) -> Bundle<F, D> {
        let c = F::splat;
        let Self { a, charge_squared } = *self;
        let Oblate { r, square, root, n, sigma } = self.oblate(x);
        let a2 = a * a;
        let m = c(2.0) * r - charge_squared;
        let static_part = sigma - m;
        let over_sigma = c(1.0) / sigma;
        let e = Vector { x: r * n.x, y: r * n.y, z: root * n.z } * over_sigma.sqrt();
        let w = Vector { x: -n.y, y: n.x, z: c(0.0) };
        let w2 = n.x.times_plus(n.x, n.y * n.y);
        // N^2 gamma
        let lapse_squared = static_part * over_sigma;
        let (radial, around) = (m / (square - m), m * a2 / square * over_sigma);
        let (ed, wd) = (e.dot(d), w.dot(d));
        let form = |o: Vector<F>| lapse_squared * (radial * ed).times_plus(e.dot(o), d.dot(o)) + around * wd * w.dot(o);
        let dd = form(d);
        let scale = sigma / dd.sqrt();
        let per = c(1.0) / dd;
        // Of the tangent in Mino's time `v`: r', n' as drawn, and w.v
        let u = c(1.0) / r;
        let rates = |v: Vector<F>| {
            let r1 = r.times_plus(x.x.times_plus(v.x, x.y * v.y), square * x.z * v.z * u) * over_sigma;
            let root1 = r * r1 / root;
            let over = c(1.0) / root;
            let n1 = Vector { x: (v.x - root1 * n.x) * over, y: (v.y - root1 * n.y) * over, z: (v.z - r1 * n.z) * u };
            (-r1 * u * u, n1, w.dot(v))
        };
        let (u1, drawn, about) = rates(d * scale);
        let beside = aside.map(|aside| rates((d * (-scale * per * form(aside))).plus(aside, scale)));
        let per_l = root * over_sigma * (m * a2 * w2 / (square * static_part) + c(1.0));
        let l = Pencil { v: per_l * about - m * a * w2 / static_part, d: beside.map(|(.., about)| per_l * about) };
        let den = u.times_plus(u.times_plus(a2 + charge_squared, c(-2.0)), c(1.0));
        let per_twist = -a2 * u * u / den;
        let twist = a * u * (c(2.0) - a.times_plus(l.v, charge_squared) * u) / den;
        let turning = |drawn: Vector<F>, twist: F| {
            let n1 = drawn.plus(w, -twist);
            n1.plus(n, -n1.dot(n))
        };
        let n1 = turning(drawn, twist);
        let n1_beside: [Vector<F>; D] = std::array::from_fn(|i| turning(beside[i].1, per_twist * l.d[i]));
        let k = Pencil { v: n1.length_squared() - a2 * n.z * n.z, d: n1_beside.map(|beside| c(2.0) * n1.dot(beside)) };
        let turn = |of: fn(&Vector<F>) -> F| Pencil { v: of(&n1), d: n1_beside.map(|n| of(&n)) };
        Bundle {
            u: [Pencil::constant(u), Pencil { v: u1, d: beside.map(|(u1, ..)| u1) }],
            n: [[n.x, n.y, n.z].map(Pencil::constant), [turn(|n| n.x), turn(|n| n.y), turn(|n| n.z)]],
            chi: Pencil::constant(c(0.0)),
            k,
            l,
        }
    }

    /// 1/r of the horizon.
    #[inline(always)]
    pub fn horizon(&self) -> F {
        let c = F::splat;
        c(1.0) / (c(1.0) + (c(1.0) - self.a * self.a - self.charge_squared).max(c(0.0)).sqrt())
    }
}

/// The factors of the equations of motion.
#[derive(Clone, Copy, Debug)]
pub struct Factors<F, const D: usize> {
    /// `K`
    pub(super) k: Pencil<F, D>,
    /// Of u, u^2 and u^3 in u''.
    pub(super) of_u: [Pencil<F, D>; 3],
    /// Of u and -u^2 in the numerator of chi'.
    pub(super) twist: [Pencil<F, D>; 2],
    /// Of u^2 in its denominator.
    pub(super) horizon: F,
    /// `a^2`
    pub(super) a2: F,
}

impl<F: Real, const D: usize> Factors<F, D> {
    /// Those of the rays `bundle`.
    #[inline(always)]
    pub fn new(spin: &Spin<F>, bundle: &Bundle<F, D>) -> Self {
        let c = F::splat;
        let Spin { a, charge_squared } = *spin;
        let (k, l, a2) = (bundle.k, bundle.l, a * a);
        let kap = k.plus_scaled(l, c(-2.0) * a) + Pencil::constant(a2);
        let quartic = (k - l * l) * a2 + kap * charge_squared;
        let of_u = [Pencil::constant(a2) - k, kap * c(3.0), quartic * c(-2.0)];
        let twist = [Pencil::constant(c(2.0) * a), (l * a + Pencil::constant(charge_squared)) * a];
        Self { k, of_u, twist, horizon: a2 + charge_squared, a2 }
    }

    /// `u'^2` and half its derivative at 1/r = `u`, each with the derivatives by the launch.
    #[inline(always)]
    pub fn quartic(&self, u: F) -> [Pencil<F, D>; 2] {
        let c = F::splat;
        let [p, q, s] = self.of_u;
        let square = u * u;
        let value = Pencil::constant(c(1.0))
            .plus_scaled(p, square)
            .plus_scaled(q, c(2.0 / 3.0) * square * u)
            .plus_scaled(s, c(0.5) * square * square);
        let slope = (p * u).plus_scaled(q, square).plus_scaled(s, square * u);
        [value, slope]
    }

    /// Derivative of half the derivative of `u'^2` by u.
    #[inline(always)]
    pub fn bend(&self, u: F) -> F {
        let c = F::splat;
        let [p, q, s] = self.of_u;
        u.times_plus(u.times_plus(c(3.0) * s.v, c(2.0) * q.v), p.v)
    }

    /// chi' at 1/r = `u`.
    #[inline(always)]
    pub fn twist(&self, u: F) -> F {
        let c = F::splat;
        u * (self.twist[0].v - self.twist[1].v * u) / u.times_plus(u.times_plus(self.horizon, c(-2.0)), c(1.0))
    }
}
