//! What is looked for around a hole that spins, and what that begins with: the rays of a hole without spin. Lengths are multiples of the mass.

use crate::spherical::connect::sky::connect_sky;
use crate::spherical::connect::{connect_pair, connect_pairs};
use bhs_core::spacetime::{Place, Spherical};
use bhs_elementary::{Elementary, rotation, unit_vector};
use bhs_engine::connections::{Connection, ConnectionPair};
use glam::DVec3;

/// Where a ray is to end, from the centre, in coordinates whose z is the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// A point.
    Point(DVec3),
    /// The sky in this unit direction.
    Sky(DVec3),
}

impl Target {
    /// The point, or the direction.
    pub fn vector(self) -> DVec3 {
        match self {
            Self::Point(v) | Self::Sky(v) => v,
        }
    }

    /// How far away it is.
    fn distance(self) -> f64 {
        match self {
            Self::Point(y) => y.length(),
            Self::Sky(_) => f64::INFINITY,
        }
    }

    /// The same, turned about the axis by the angle `by` (rad).
    fn turned(self, by: f64) -> Self {
        let turn = unit_vector(by);
        let about = |v: DVec3| turn.rotate(v.truncate()).extend(v.z);
        match self {
            Self::Point(y) => Self::Point(about(y)),
            Self::Sky(sky) => Self::Sky(about(sky)),
        }
    }
}

/// A ray to begin with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guess {
    /// Unit chart direction in which it leaves.
    pub launch: DVec3,
    /// Mino's time at its end.
    pub tau: f64,
}

/// The image that is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Image {
    /// The shorter way: no neighbours have met again.
    Direct,
    /// Round the other side of the hole: neighbours have met once.
    Round,
}

/// A ray that is looked for.
#[derive(Clone, Copy, Debug)]
pub struct Search {
    /// Where it begins.
    pub x: DVec3,
    /// Where it is to end.
    pub target: Target,
    /// Which of those that do so.
    pub image: Image,
    /// The one around the hole without spin.
    pub guess: Guess,
    /// A better one, where the hole stands nearly in the way: that around the hole without spin where one that spins seems to be.
    pub displaced: Option<Guess>,
    /// Unit vector from where it begins to the centre.
    pub inward: DVec3,
    /// Angle of the edge of capture from there, without spin (rad).
    pub edge: f64,
    /// Whether the guess arrives outwards after it has been nearer to the hole.
    pub turns: bool,
}

/// Of the smaller distance of the ends, what Schwarzschild's radius of the hole without spin is at most: a hole that spins is smaller.
const CLOSEST: f64 = 0.9;

/// Sine of the angle between a ray and the radius below which it is radial, as far as its duration goes.
const RADIAL: f64 = 1e-6;

/// Cosine of the largest angle between what lies behind the hole and the target at which the hole stands in the way.
const IN_THE_WAY: f64 = 0.85;

/// How far aside a hole that spins seems to be, over the length a, for light that it bends as much as that of an Einstein ring; 1 for light far from it.
/// Measured: with 1 and 1.5 fewer rays are found.
const DISPLACED: f64 = 1.25;

/// Square of `rs` over the critical impact parameter, and `rs` over the radius of the circular orbits of light, without spin.
const CRITICAL: f64 = 4.0 / 27.0;
const CIRCULAR: f64 = 2.0 / 3.0;

/// A hole's `rs`, and both rays around it.
pub type Plain = (f64, ConnectionPair);

/// Both rays of each of `ends` around the hole without spin.
pub fn all_without_spin(ends: &[(DVec3, Target)]) -> Vec<Plain> {
    let mut found = vec![(2.0, [None; 2]); ends.len()];
    let (mut places, mut pairs) = (Vec::with_capacity(ends.len()), Vec::with_capacity(ends.len()));
    for (k, (x, target)) in ends.iter().enumerate() {
        match target {
            Target::Point(y) if schwarzschild_radius(*x, *target) == 2.0 => {
                places.push(k);
                pairs.push([Place::near(*x), Place::near(*y)]);
            }
            _ => found[k] = without_spin(*x, *target, 0),
        }
    }
    let mut joined = vec![[None; 2]; pairs.len()];
    connect_pairs(&Spherical { center: DVec3::ZERO, rs: 2.0, charge_squared: 0.0 }, &pairs, 0, &mut joined);
    for (k, pair) in places.into_iter().zip(joined) {
        found[k].1 = pair;
    }
    found
}

/// That of the hole without spin: as large as the one that spins, if the ends are outside.
fn schwarzschild_radius(x: DVec3, target: Target) -> f64 {
    2.0f64.min(CLOSEST * x.length().min(target.distance()))
}

/// Both rays around the hole without spin that make `turn` whole turns, and its `rs`.
fn without_spin(x: DVec3, target: Target, turn: u32) -> Plain {
    let rs = schwarzschild_radius(x, target);
    let hole = Spherical { center: DVec3::ZERO, rs, charge_squared: 0.0 };
    let pair = match target {
        Target::Point(y) => connect_pair(&hole, x, y, turn),
        Target::Sky(sky) => connect_sky(&hole, x, sky, turn),
    };
    (rs, pair)
}

/// Mino's time of the ray `c` around the hole without spin of Schwarzschild's radius `rs`.
fn duration(x: DVec3, target: Target, rs: f64, c: &Connection) -> f64 {
    let r = x.length();
    let cos = c.launch.dot(x) / r;
    let sin = c.launch.cross(x).length() / r;
    if sin < RADIAL {
        return (1.0 / r - 1.0 / target.distance()).abs();
    }
    // phi over the impact parameter.
    let lapse_squared = 1.0 - rs / r;
    c.phi * (cos * cos + lapse_squared * sin * sin).sqrt() / (r * sin)
}

impl Search {
    /// Those of both images between `x` and `target`, and the rays around the hole without spin.
    ///
    /// `a`: angular momentum over mass of the hole; `plain`: what [`all_without_spin`] says of the ends.
    pub fn both(a: f64, (x, target): (DVec3, Target), plain: Plain) -> ([Option<Self>; 2], ConnectionPair) {
        let (rs, pair) = plain;
        let displaced = (-x.dot(target.vector()) > IN_THE_WAY * x.length() * target.vector().length()).then(|| {
            // Light that moves along with the spin is bent less: so it is by a hole farther away from it.
            let way = match target {
                Target::Point(y) => (y - x).normalize(),
                Target::Sky(sky) => sky,
            };
            let aside = DVec3::Z.cross(way) * (DISPLACED * a);
            let seen = match target {
                Target::Point(y) => Target::Point(y - aside),
                sky @ Target::Sky(_) => sky,
            };
            let (rs, pair) = without_spin(x - aside, seen, 0);
            let round = pair[1].map(|c| duration(x - aside, seen, rs, &c));
            (pair, round)
        });
        let r = x.length();
        let u = rs / r;
        // Beyond the circular orbits of light the edge is inwards, within them outwards.
        let slope = (CRITICAL - u * u + u * u * u).max(0.0).sqrt();
        let edge = u.arctangent2(if u < CIRCULAR { slope } else { -slope });
        let inward = -x / r;
        let searches = std::array::from_fn(|i| {
            let c = pair[i]?;
            let turns = c.launch.dot(inward) > 0.0 && c.arrival.dot(target.vector()) > 0.0;
            let guess = Guess { launch: c.launch, tau: duration(x, target, rs, &c) };
            // The shorter way takes the time that it takes around the hole where it is.
            let displaced = displaced.and_then(|(pair, round)| {
                let tau = if i == 0 { Some(guess.tau) } else { round };
                Some(Guess { launch: pair[i]?.launch, tau: tau? })
            });
            let image = [Image::Direct, Image::Round][i];
            Some(Self { x, target, image, guess, displaced, inward, edge, turns })
        });
        (searches, displaced.map_or(pair, |(pair, _)| pair))
    }

    /// The search for the longer way round that begins on the other side, a turn later: for targets on the near side of the hole. Where neighbours meet
    /// for the second time is dragged along too, and what is on the one side of the line through the hole may be beyond that.
    pub fn other_way(&self) -> Option<Self> {
        if self.image == Image::Direct || self.x.dot(self.target.vector()) <= 0.0 {
            return None;
        }
        let (rs, pair) = without_spin(self.x, self.target, 1);
        let c = pair[0]?;
        let guess = Guess { launch: c.launch, tau: duration(self.x, self.target, rs, &c) };
        let turns = c.launch.dot(self.inward) > 0.0 && c.arrival.dot(self.target.vector()) > 0.0;
        Some(Self { guess, turns, displaced: None, ..*self })
    }

    /// The same search for the longer way round that begins with the launch turned about the inward direction by the angle `by` (rad).
    pub fn from_aside(&self, by: f64) -> Option<Self> {
        let Guess { launch, tau } = self.guess;
        let launch = rotation(self.inward, by) * launch;
        (self.image == Image::Round).then_some(Self { displaced: Some(Guess { launch, tau }), ..*self })
    }

    /// The ray around the hole without spin that leads to where a twist of so much (rad) would bring it to the target: the longer way round.
    pub fn twisted(&self, twist: f64) -> Option<Guess> {
        let target = self.target.turned(-twist);
        let to = target.vector();
        let same_way = self.x.cross(to).dot(self.x.cross(self.guess.launch)) > 0.0;
        // The longer way becomes the shorter one past the opposite point, and one of the next turn past the point itself.
        let (turn, way) = match (same_way, self.x.dot(to) < 0.0) {
            (false, _) => (0, 1),
            (true, true) => (0, 0),
            (true, false) => (1, 0),
        };
        let (rs, pair) = without_spin(self.x, target, turn);
        let c = pair[way]?;
        Some(Guess { launch: c.launch, tau: duration(self.x, target, rs, &c) })
    }

    /// The unit vector across the inward direction in the plane of that and `launch`.
    pub fn across(&self, launch: DVec3) -> DVec3 {
        let across = launch - self.inward * launch.dot(self.inward);
        across.try_normalize().unwrap_or_else(|| self.inward.any_orthonormal_vector())
    }
}
