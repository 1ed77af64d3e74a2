//! Rays around one centre from point to point, in their plane: wormholes, and one extremal hole (`docs/physics.md`, section 6).
//!
//! With `s = ln(rho / rho_0)`, where `rho_0` is the radius of the throat or of the photon sphere, the plane is conformally flat,
//! `r(s)^2 (ds^2 + dpsi^2)` with the areal radius `r = n rho`, which is even in s and grows with |s|. The far side of a wormhole has s < 0.
//! `r sin(alpha) = h` along a ray. As `ln r` is convex, the curvature of the plane is nowhere above 0: of each swept angle, whole turns
//! included, there is exactly one ray between two points.

use crate::arithmetic::root::root;
use crate::graded_index::medium::Medium;
use bhs_core::spacetime::GradedIndex;
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::LazyLock;

/// A round index: the areal radius as a function of s.
#[derive(Clone, Debug)]
pub struct Profile<'a> {
    index: &'a dyn GradedIndex,
    /// The centre (scene units).
    pub center: DVec3,
    /// The chart radius where s = 0 (scene units).
    scale: f64,
    /// Whether s < 0 is the far side of a wormhole; else it is what lies within the photon sphere.
    is_throat: bool,
    /// Where a derivative of the areal radius jumps, s > 0, from the inside outwards.
    breaks: Vec<f64>,
    /// Up to where the areal radius is that at 0.
    edge: f64,
    /// Error of a swept angle (rad) at which its search ends.
    enough: f64,
}

/// A ray in its plane.
#[derive(Clone, Copy, Debug)]
pub struct Orbit {
    /// Cosine of the angle between the launch and the direction in which s grows.
    pub cos: f64,
    /// Sine of it, not negative.
    pub sin: f64,
    /// The parameter at the end.
    pub sigma: f64,
}

/// Nodes and weights of Gauss and Legendre between 0 and 1.
const NODES: usize = 28;

static GAUSS: LazyLock<[[f64; 2]; NODES]> = LazyLock::new(|| {
    std::array::from_fn(|i| {
        let mut x = (PI * (i as f64 + 0.75) / (NODES as f64 + 0.5)).cos();
        let mut slope = 1.0;
        for _ in 0..20 {
            let (mut p, mut before) = (1.0, 0.0);
            for k in 0..NODES {
                let k = k as f64;
                (p, before) = (((2.0 * k + 1.0) * x * p - k * before) / (k + 1.0), p);
            }
            slope = NODES as f64 * (x * p - before) / (x * x - 1.0);
            x -= p / slope;
        }
        [0.5 * (1.0 + x), 1.0 / ((1.0 - x * x) * slope * slope)]
    })
});

/// The largest arguments of what impact parameters are found by: beyond, they are the critical one to rounding.
const MOST: f64 = 18.0;

impl<'a> Profile<'a> {
    /// That of `medium`, if it is round: a wormhole, or one extremal hole.
    pub fn of(medium: &Medium<'a>) -> Option<Self> {
        match (medium.throat, medium.captures.as_slice()) {
            (Some(throat), []) => {
                let mut profile = Self::new(medium.index, throat.center, throat.radius, true);
                profile.breaks = medium.index.breaks().iter().map(|b| (b / throat.radius).ln()).filter(|s| *s > 0.0).collect();
                let least = profile.at(0.0, false)[0] * (1.0 + 1e-12);
                profile.edge = profile.breaks.iter().copied().filter(|s| profile.at(*s, false)[0] <= least).fold(0.0, f64::max);
                Some(profile)
            }
            (None, [hole]) => {
                let profile = Self::new(medium.index, hole.center, hole.radius, false);
                // n^2 = (1 + M/rho)^4.
                let is_extremal = [0.3, 1.0, 2.5].iter().all(|over| {
                    let square = medium.index.index(hole.center + DVec3::X * (hole.radius * over)).0;
                    (square * (1.0 + 1.0 / over).powi(-4) - 1.0).abs() < 1e-9
                });
                is_extremal.then_some(profile)
            }
            _ => None,
        }
    }

    /// That of the index `(1 + mass/rho)^4` around `center`, whatever is in `index`, for rays that are only somewhere near right.
    pub fn of_hole(index: &'a dyn GradedIndex, center: DVec3, mass: f64) -> Self {
        Self { enough: 1e-5, ..Self::new(index, center, mass, false) }
    }

    fn new(index: &'a dyn GradedIndex, center: DVec3, scale: f64, is_throat: bool) -> Self {
        Self { index, center, scale, is_throat, breaks: Vec::new(), edge: 0.0, enough: 1e-11 }
    }

    /// s at the chart radius `rho` of the near side.
    pub fn s(&self, rho: f64) -> f64 {
        (rho / self.scale).ln()
    }

    /// At `s` > 0, or at `-s`: squared areal radius, half its derivative by |s|, squared chart radius (on its own side).
    #[inline]
    fn at(&self, s: f64, is_negative: bool) -> [f64; 3] {
        if self.is_throat {
            let rho = self.scale * s.exp();
            let (square, acceleration) = self.index.index(self.center + DVec3::X * rho);
            let rho_squared = rho * rho;
            [square * rho_squared, rho_squared * (square + acceleration.x * rho), rho_squared]
        } else {
            // r = M (1 + e^s)^2 / e^s.
            let e = s.exp();
            let over = 1.0 / e;
            let (r, rho) = (self.scale * (2.0 + e + over), self.scale * if is_negative { over } else { e });
            [r * r, r * self.scale * (e - over), rho * rho]
        }
    }

    /// Areal radius at |s|.
    fn radius(&self, s: f64) -> f64 {
        self.at(s.abs(), false)[0].sqrt()
    }

    /// Swept angle and parameter from |s| = `low` to `high`, both of one sign, at the impact parameter `h`.
    fn way(&self, low: f64, high: f64, h: f64, is_negative: bool) -> [f64; 2] {
        let mut sum = [0.0; 2];
        let mut from = low;
        for to in self.breaks.iter().copied().filter(|b| *b > low && *b < high).chain([high]) {
            let piece = self.piece(from, to, h, is_negative);
            sum = [sum[0] + piece[0], sum[1] + piece[1]];
            from = to;
        }
        sum
    }

    /// The same where the areal radius is smooth. With `r^2 - h^2 = c0 + 2 c1 v + c2 v^2` about the lower end, it is integrated over
    /// `ln(c1 + c2 v + sqrt(c2 (r^2 - h^2)))`, in which the root has no singularity.
    fn piece(&self, low: f64, high: f64, h: f64, is_negative: bool) -> [f64; 2] {
        let length = high - low;
        if length <= 0.0 {
            return [0.0; 2];
        }
        let [c2, c1, _] = self.at(low, is_negative);
        let c0 = (c2 - h * h).max(c2 * 1e-30);
        let e = c1 * c1 - c2 * c0;
        let root_of = |v: f64| (c2 * (c0 + v * (2.0 * c1 + v * c2))).sqrt();
        let (first, last) = (c1 + (c2 * c0).sqrt(), c1 + c2 * length + root_of(length));
        let range = (last / first).ln();
        let mut sum = [0.0; 2];
        for [node, weight] in *GAUSS {
            let z = first * (range * node).exp();
            let q = 0.5 * (z - e / z);
            let v = (0.5 * (z + e / z) - c1) / c2;
            let [square, _, rho_squared] = self.at(low + v, is_negative);
            let share = weight * q / (square - h * h).max(f64::MIN_POSITIVE).sqrt();
            sum = [share.mul_add(h, sum[0]), share.mul_add(rho_squared, sum[1])];
        }
        sum.map(|sum| sum * range / c2)
    }

    /// The ray from `a` to `b` (values of s) that sweeps the angle `psi` >= 0 (rad).
    pub fn orbit(&self, a: f64, b: f64, psi: f64) -> Option<Orbit> {
        let add = |[p, q]: [f64; 2], [r, s]: [f64; 2]| [p + r, q + s];
        let of = |low: f64, end: f64, h: f64| self.way(low, end.abs(), h, end < 0.0);
        if a * b < 0.0 {
            let ways = |h: f64| add(of(0.0, a, h), of(0.0, b, h));
            let most = self.radius(0.0);
            let h = most * solve(|q| ways(most * q.tanh())[0], psi, self.enough)?.tanh();
            return Some(self.launched(a, h, b < a, ways(h)[1]));
        }
        let (low, high) = (a.abs().min(b.abs()), a.abs().max(b.abs()));
        let is_negative = a < 0.0 || b < 0.0;
        let ways = |h: f64| self.way(low, high, h, is_negative);
        let most = self.radius(low);
        if low <= self.edge || ways(most)[0] >= psi {
            let h = most * solve(|q| ways(most * q.tanh())[0], psi, self.enough)?.tanh();
            return Some(self.launched(a, h, b < a, ways(h)[1]));
        }
        // It turns nearer to s = 0 than both ends.
        let turn = |q: f64| self.edge + (low - self.edge) * (-q).exp();
        let ways = |turn: f64| {
            let h = self.radius(turn);
            add(self.way(turn, a.abs(), h, is_negative), self.way(turn, b.abs(), h, is_negative))
        };
        let turn = turn(solve(|q| ways(turn(q))[0], psi, self.enough)?);
        Some(self.launched(a, self.radius(turn), a > 0.0, ways(turn)[1]))
    }

    fn launched(&self, a: f64, h: f64, falls: bool, sigma: f64) -> Orbit {
        let sin = (h / self.radius(a)).min(1.0);
        let cos = ((1.0 - sin) * (1.0 + sin)).sqrt();
        Orbit { cos: if falls { -cos } else { cos }, sin, sigma }
    }
}

/// Where the angle `swept`, which grows, is `psi`, to within `enough`.
fn solve(swept: impl Fn(f64) -> f64, psi: f64, enough: f64) -> Option<f64> {
    let off = |q: f64| {
        let off = swept(q) - psi;
        if off.abs() <= enough { 0.0 } else { off }
    };
    let (mut low, mut high) = (0.0, 1.0);
    while off(high) < 0.0 {
        if high >= MOST {
            return None;
        }
        (low, high) = (high, 2.0 * high);
    }
    Some(root(off, low, high.min(MOST), true))
}

#[cfg(test)]
mod tests {
    use super::*;
    use bhs_core::spacetime::{Class, Spacetime};
    use bhs_spacetimes::{Dneg, Ellis};

    /// Angles between infinities against elliptic integrals and a quadrature with many digits.
    #[test]
    fn swept_angles_are_those_of_long_quadratures() {
        let ellis = Ellis { center: DVec3::ZERO, throat: 1.0 };
        let dneg = Dneg::new(DVec3::ZERO, 1.0, 1.0, 0.1).unwrap();
        let cases: [(&dyn Spacetime, f64, f64, f64); 3] = [
            (&ellis, 0.5, 1.685750354812596, 1e-7),
            (&ellis, 0.9, 4.104988449160986, 1e-7),
            (&dneg, 0.5, 1.8391092507240994, 1e-4),
        ];
        for (spacetime, h, right, within) in cases {
            let Class::Index(index) = spacetime.class() else { panic!() };
            let profile = Profile::of(&Medium::new(index, Vec::new())).unwrap();
            let far = 16.0;
            // What is left is h / r.
            let beyond = h / profile.radius(far);
            let swept = 2.0 * (profile.way(0.0, far, h, false)[0] + beyond);
            assert!((swept - right).abs() < within, "{:e}", swept - right);
        }
    }
}
