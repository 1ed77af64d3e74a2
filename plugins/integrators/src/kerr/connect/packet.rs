//! Searches for rays around a hole that spins, eight side by side: how rays are launched, where they come, and how they are launched next.

use crate::kerr::connect::bundle::{Factors, Spin};
use crate::kerr::connect::edge::{Azimuth, Edge};
use crate::kerr::connect::newton::{EDGE_STEPS, MOST_LOG, MOST_LONGER, MOST_TAU, MOST_TURNED};
use crate::kerr::connect::search::{Guess, Image, Search, Target};
use crate::kerr::connect::series::{Followed, follow};
use bhs_core::lanes::{LANES, Lanes};
use bhs_core::real::{Mask, Real, Vector};
use bhs_elementary::Elementary;
use glam::DVec3;

/// A number of each search.
pub(super) type Numbers = Lanes;

/// A vector of each search.
pub(super) type Vectors = Vector<Lanes>;

/// The same number of all.
pub(super) fn number(x: f64) -> Numbers {
    <Lanes as Real>::splat(x)
}

/// A linear form of the changes of the launch and of the time: where the end goes, across and, along the unit vector there, in 1/r over that of the end.
#[derive(Clone, Copy)]
pub(super) struct Moves(pub(super) [Vectors; 3]);

impl Moves {
    /// The change that makes up for `off`.
    pub(super) fn change(&self, off: Vectors) -> [Numbers; 3] {
        let [a, b, c] = self.0;
        let bc = b.cross(c);
        let over = number(1.0) / a.dot(bc);
        [off.dot(bc) * over, off.dot(c.cross(a)) * over, off.dot(a.cross(b)) * over]
    }

    /// What the change does.
    pub(super) fn of(&self, change: [Numbers; 3]) -> Vectors {
        (self.0[0] * change[0]).plus(self.0[1], change[1]).plus(self.0[2], change[2])
    }
}

/// Where rays have come.
pub(super) struct Arrived<const D: usize> {
    /// Derivatives by the angles of the launch and by the time, as [`Moves`] has them.
    pub(super) by: [Vectors; D],
    pub(super) by_tau: Vectors,
    /// How far that is from their ends, in the same measure, and over the distance.
    pub(super) off: Vectors,
    pub(super) error: Numbers,
    /// Angle by which they were turned about the axis (rad), and for how long they were followed.
    pub(super) twist: Numbers,
    pub(super) tau: Numbers,
    /// Which of them were given up.
    pub(super) lost: Numbers,
}

/// How rays are launched.
#[derive(Clone, Copy)]
pub(super) struct Start {
    /// Unit chart directions, two at right angles to each, and Mino's time at the end.
    pub(super) d: Vectors,
    pub(super) aside: [Vectors; 2],
    pub(super) tau: Numbers,
    /// As seen from the edge of capture, if that is what launches are measured from: azimuth, angle of the edge, its slope, angle beyond it.
    pub(super) across: Vectors,
    pub(super) edge: Numbers,
    pub(super) slope: Numbers,
    pub(super) from: Numbers,
}

impl Start {
    /// Of the searches in `which` those of `self`, of the others those of `o`.
    pub(super) fn or(&self, o: &Self, which: Numbers) -> Self {
        let pick = |a, b| <Lanes as Real>::select(which, a, b);
        Self {
            d: self.d.or(o.d, which),
            aside: [0, 1].map(|i| self.aside[i].or(o.aside[i], which)),
            tau: pick(self.tau, o.tau),
            across: self.across.or(o.across, which),
            edge: pick(self.edge, o.edge),
            slope: pick(self.slope, o.slope),
            from: pick(self.from, o.from),
        }
    }
}

/// Searches for the same image side by side.
pub(super) struct Packet<'a> {
    /// At most eight of them.
    pub(super) searches: &'a [&'a Search],
    /// Whether they look for the rays round the other side.
    pub(super) is_round: bool,
    /// The hole, as often as there are lanes.
    pub(super) spin: Spin<Lanes>,
    /// Where the rays begin, and the unit vectors from there to the centre.
    pub(super) x: Vectors,
    pub(super) inward: Vectors,
    /// 1/r and the unit vector of the angles of the ends; what errors of 1/r and errors of all are multiplied by.
    pub(super) end: (Numbers, Vectors),
    pub(super) scale: (Numbers, Numbers),
    /// 1/r at which a ray ends on its way out, and how much longer than its time it may take.
    pub(super) exit: Numbers,
    pub(super) longer: Numbers,
}

impl<'a> Packet<'a> {
    /// The `searches`, all of them for the same `image`.
    pub(super) fn new(spin: Spin<f64>, image: Image, searches: &'a [&'a Search]) -> Self {
        let search = |i: usize| searches[i.min(searches.len() - 1)];
        let of = |f: &dyn Fn(&Search) -> f64| <Lanes as Real>::from_fn(|i| f(search(i)));
        let vector = |f: fn(&Search) -> DVec3| Vectors::from_fn(|i| f(search(i)));
        let spins = Spin { a: number(spin.a), charge_squared: number(spin.charge_squared) };
        let x = vector(|s| s.x);
        let target = vector(|s| s.target.vector());
        let oblate = spins.oblate(target);
        let is_sky = <Lanes as Mask>::of_bits(
            (0..LANES).filter(|i| matches!(search(*i).target, Target::Sky(_))).fold(0, |bits, i| bits | 1 << i),
        );
        let pick = |sky, point| <Lanes as Real>::select(is_sky, sky, point);
        let u = pick(number(0.0), number(1.0) / oblate.r);
        let scale = (pick(x.length(), oblate.r), pick(number(1.0), oblate.r / (target - x).length()));
        let is_round = image == Image::Round;
        let leaves = |s: &Search| s.turns && is_round;
        Self {
            searches,
            is_round,
            spin: spins,
            x,
            inward: vector(|s| s.inward),
            end: (u, target.or(oblate.n, is_sky)),
            scale,
            exit: <Lanes as Real>::from_fn(|i| if leaves(search(i)) { u.lane(i) } else { f64::NEG_INFINITY }),
            longer: of(&|s| if leaves(s) { MOST_TAU } else { 1.0 }),
        }
    }

    /// Search number `i`; lanes without one repeat the last.
    pub(super) fn search(&self, i: usize) -> &'a Search {
        self.searches[i.min(self.searches.len() - 1)]
    }

    /// How rays begin with these guesses.
    pub(super) fn guesses(&self, guess: impl Fn(usize) -> Guess) -> Start {
        let d = Vectors::from_fn(|i| guess(i).launch);
        let tau = <Lanes as Real>::from_fn(|i| guess(i).tau);
        let zero = number(0.0);
        let across = (d.plus(self.inward, -d.dot(self.inward))).normalize();
        let start = Start { d, aside: [d; 2], tau, across, edge: zero, slope: zero, from: zero };
        if self.is_round { start } else { Self::aside(start, d.cross(self.inward)) }
    }

    /// With directions beside it, the first of them about along `e`.
    pub(super) fn aside(start: Start, e: Vectors) -> Start {
        let e = e.plus(start.d, -e.dot(start.d)).normalize();
        Start { aside: [e, start.d.cross(e)], ..start }
    }

    /// Angles of the launches from inwards.
    pub(super) fn angle(&self, start: &Start) -> Numbers {
        let (across, inward) = (start.d.dot(start.across), start.d.dot(self.inward));
        Numbers::from_fn(|i| across.lane(i).arctangent2(inward.lane(i)))
    }

    /// Measures them from the edge of capture in their azimuths, from which they are as far as `from` says of that.
    pub(super) fn seen_from_edge(
        &self,
        start: Start,
        guess: (Numbers, Numbers),
        from: impl Fn(Numbers) -> Numbers,
    ) -> (Start, Numbers, Numbers) {
        let azimuth = Azimuth { inward: self.inward, across: start.across };
        let (Edge { angle, slope, u }, is_one) = azimuth.edge(&self.spin, self.x, guess, EDGE_STEPS);
        let start = Start { edge: angle, slope, from: from(angle), ..start };
        (self.launched(start), u, is_one)
    }

    /// With the launch that edge and azimuth ask for.
    pub(super) fn launched(&self, start: Start) -> Start {
        let azimuth = Azimuth { inward: self.inward, across: start.across };
        let (d, aside) = azimuth.direction(start.edge + start.from);
        Start { d, aside, ..start }
    }

    /// Follows rays by series of N terms, and D derivatives of M terms, to the times and radii `until`.
    pub(super) fn follow<const N: usize, const D: usize, const M: usize>(
        &self,
        start: &Start,
        until: (Numbers, Numbers),
        tolerance: f64,
    ) -> (Arrived<D>, Followed<Lanes, D>) {
        let aside = std::array::from_fn(|i| start.aside[i]);
        let bundle = self.spin.launch::<D>(self.x, start.d, aside);
        let followed = follow::<Lanes, N, D, M>(&self.spin, &bundle, until, tolerance);
        (self.arrived(&followed), followed)
    }

    pub(super) fn arrived<const D: usize>(&self, followed: &Followed<Lanes, D>) -> Arrived<D> {
        let end = &followed.end;
        let u = end.u[0].v;
        let rate = Factors::new(&self.spin, end).twist(u);
        let (sin, cos) = (Numbers::from_fn(|i| end.chi.v.lane(i).sine()), Numbers::from_fn(|i| end.chi.v.lane(i).cosine()));
        let about = |v: Vectors| Vectors { x: cos * v.x - sin * v.y, y: sin * v.x + cos * v.y, z: v.z };
        let vector = |i: usize, of: &dyn Fn(usize, usize) -> Numbers| Vectors { x: of(i, 0), y: of(i, 1), z: of(i, 2) };
        let top = vector(0, &|i, k| end.n[i][k].v).normalize();
        let n = about(top);
        let w = Vectors { x: -top.y, y: top.x, z: number(0.0) };
        let lifted = |u1: Numbers, n1: Vectors| about(n1).plus(n, u1 * self.scale.0);
        let by = std::array::from_fn(|j| lifted(end.u[0].d[j], vector(0, &|i, k| end.n[i][k].d[j]).plus(w, end.chi.d[j])));
        let by_tau = lifted(end.u[1].v, vector(1, &|i, k| end.n[i][k].v).plus(w, rate));
        let cos = n.dot(self.end.1);
        let across = self.end.1.plus(n, -cos);
        let (sine, chord) = (across.length(), (self.end.1 - n).length());
        let ratio = <Lanes as Real>::select(sine.gt(number(0.0)), chord / sine, number(1.0));
        let off = (across * ratio).plus(n, (self.end.0 - u) * self.scale.0);
        let error = off.length() * self.scale.1;
        let lost = followed.lost | !error.is_finite();
        let error = <Lanes as Real>::select(lost, number(f64::INFINITY), error);
        Arrived { by, by_tau, off, error, twist: end.chi.v, tau: followed.tau, lost }
    }

    /// The derivatives by what steps change: angles, or the logarithm of the one from the edge and the one across.
    pub(super) fn moves(&self, start: &Start, arrived: &Arrived<2>) -> Moves {
        let [a, b] = arrived.by;
        if self.is_round {
            Moves([a * start.from, b.plus(a, start.slope), arrived.by_tau])
        } else {
            Moves([a, b, arrived.by_tau])
        }
    }

    /// The change, if it is too large a part of it.
    pub(super) fn limited(&self, change: [Numbers; 3], tau: Numbers) -> [Numbers; 3] {
        let [a, b, c] = change;
        let turned = if self.is_round {
            (number(MOST_LOG) / a.abs()).min(number(MOST_TURNED) / b.abs())
        } else {
            number(MOST_TURNED) / (a * a + b * b).sqrt()
        };
        let share = turned.min(number(MOST_LONGER) * tau / c.abs()).min(number(1.0));
        [a * share, b * share, c * share]
    }

    /// The launches with these changes, from rays that took the times `tau`.
    pub(super) fn changed(&self, start: &Start, [a, b, c]: [Numbers; 3], tau: Numbers) -> Start {
        let start = Start { tau: tau + c, ..*start };
        if !self.is_round {
            let [e, f] = start.aside;
            let d = start.d.plus(e, a).plus(f, b).normalize();
            return Self::aside(Start { d, ..start }, e);
        }
        let sine = start.d.dot(start.across);
        let across = start.across.plus(self.inward.cross(start.across), b / sine).normalize();
        let (edge, from) = (start.edge + start.slope * b, start.from * Numbers::from_fn(|i| a.lane(i).exponential()));
        self.launched(Start { across, edge, from, ..start })
    }
}
