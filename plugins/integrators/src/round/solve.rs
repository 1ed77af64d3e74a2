//! The ray of a given swept angle between two radii.
//!
//! The optical metric of the plane has no curvature above 0: of each swept angle, whole turns included, there is exactly one ray, and the
//! angle grows with the parameter of each of three families. A ray passes the minimum of the optical radius, leads outwards all the way, or turns
//! before the minimum. Newton's method within bounds, first with few nodes.

use crate::round::profile::{Profile, Radii};
use crate::round::swept::{Accuracy, Start, Swept, Varied, Way};
use bhs_elementary::Elementary;

/// One end of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct End {
    /// |x|; infinite for the sky.
    pub x: f64,
    /// Whether it is on the other side of the minimum: of a wormhole the far side, within the photon sphere of a hole.
    pub is_beyond: bool,
    /// Optical radius (scene units); infinite for the sky.
    pub radius: f64,
}

impl End {
    /// At the coordinate `x`, beyond the minimum if that is below 0.
    pub fn new(profile: &Profile, x: f64) -> Self {
        let is_beyond = x < 0.0;
        let radius = profile.at(x.abs(), is_beyond && !profile.is_throat()).square.sqrt();
        Self { x: x.abs(), is_beyond, radius }
    }

    /// The sky of one side.
    pub fn sky(is_beyond: bool) -> Self {
        Self { x: f64::INFINITY, is_beyond, radius: f64::INFINITY }
    }
}

/// A ray in its plane from one end to the other.
#[derive(Clone, Copy, Debug)]
pub struct Orbit {
    /// Impact parameter (scene units).
    pub h: f64,
    /// Cosines at both ends of the angle between the ray and the direction away from the minimum.
    pub cos: [f64; 2],
    /// Derivative of the swept angle by h, times both cosines (1/scene unit): it does not become infinite.
    pub spread: f64,
    /// The parameter sigma of a ray of a refractive index at its end (scene units).
    pub sigma: f64,
}

/// Between two ends.
#[derive(Clone, Copy, Debug)]
pub struct Pair<'a> {
    profile: &'a Profile,
    ends: [End; 2],
    /// Numbers of the inner and the outer one.
    order: [usize; 2],
    /// `R dR/dx` and all that of the inner one.
    inner: Radii<f64>,
    is_inner: bool,
}

/// The kinds of rays.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Family {
    /// Past the minimum: `h = least tanh(p)`.
    Through,
    /// Away from the minimum, starting at the inner end at the angle `alpha`: `tan(alpha/2) = reach tanh(p)`.
    Outward,
    /// First towards the minimum: it turns at `x - edge = (x1 - edge) exp(-q)` with `q = p^2 / (1 + p)`.
    Turning,
}

/// The largest arguments of areas and exponents: beyond, rays are the critical one to rounding.
const MOST: f64 = 18.0;

/// How near the minimum rays turn at most, in x.
const NEAREST: f64 = 1e-8;

/// Iterations, and the error of the swept angle (rad) at which the first few nodes have done their part.
const COARSE_ITERATIONS: u32 = 40;
const FINE_ITERATIONS: u32 = 20;
const GUESSED: f64 = 2e-3;

/// Error of the swept angle (rad) from which one step of Newton's method leads to the end.
const LAST: f64 = 2e-7;

/// Error of the swept angle (rad) that will do where rounding makes none less.
const ROUNDED: f64 = 1e-5;

/// The smallest angle (rad): less is to rounding radial.
const LEAST_ANGLE: f64 = 1e-11;

/// Margin of the swept angle (rad) within which few nodes do not tell families apart.
const MARGIN: f64 = 0.05;

/// A member of a family.
#[derive(Clone, Copy, Debug)]
struct Member {
    h: Varied,
    swept: Swept,
    /// For rays outwards: cosine of the angle at the inner end, and that angle's derivative.
    inner: Option<Varied>,
}

impl<'a> Pair<'a> {
    /// Between `ends`, of which at most the second one is the sky.
    pub fn new(profile: &'a Profile, ends: [End; 2]) -> Self {
        let order = if ends[0].x <= ends[1].x { [0, 1] } else { [1, 0] };
        let End { x, is_beyond, .. } = ends[order[0]];
        let is_inner = is_beyond && !profile.is_throat();
        Self { profile, ends, order, inner: profile.at(x, is_inner), is_inner }
    }

    /// The spacetime.
    pub fn profile(&self) -> &'a Profile {
        self.profile
    }

    fn is_through(&self) -> bool {
        self.ends[0].is_beyond != self.ends[1].is_beyond
    }

    /// `tan(alpha/2)` of the critical ray at the inner end, if it is outside of the minimum: at least 1.
    fn reach(&self) -> f64 {
        let ratio = self.profile.least / self.ends[self.order[0]].radius;
        let cos = ((1.0 - ratio) * (1.0 + ratio)).max(0.0).sqrt();
        (1.0 + cos) / ratio
    }

    fn member(&self, family: Family, p: f64, accuracy: Accuracy) -> Member {
        let Self { profile, ends, order, .. } = self;
        let [inner, outer] = order.map(|i| ends[i]);
        match family {
            Family::Through => {
                let (tanh, cosh) = (p.hyperbolic_tangent(), p.hyperbolic_cosine());
                let least = profile.least;
                let h = Varied { at: least * tanh, by: least / (cosh * cosh) };
                let root = Varied { at: least / cosh, by: -least * tanh / cosh };
                let start = Start { x: Varied::fixed(0.0), slope: Varied::fixed(0.0), root };
                let leg = |end: End| {
                    let is_inner = end.is_beyond && !profile.is_throat();
                    Way { profile, h, is_inner }.swept(start, end.x, accuracy)
                };
                Member { h, swept: leg(inner).and(leg(outer)), inner: None }
            }
            Family::Outward => {
                let reach = self.reach();
                let tan = reach * p.hyperbolic_tangent();
                let over = 1.0 / (1.0 + tan * tan);
                let (sin, cos) = (2.0 * tan * over, (1.0 - tan) * (1.0 + tan) * over);
                let turned = 2.0 * over * (reach - tan * tan / reach);
                let radius = inner.radius;
                let h = Varied { at: radius * sin, by: radius * cos * turned };
                let root = Varied { at: radius * cos, by: -radius * sin * turned };
                let slope = if inner.x <= profile.edge { 0.0 } else { self.inner.slope };
                let start = Start { x: Varied::fixed(inner.x), slope: Varied::fixed(slope), root };
                let swept = Way { profile, h, is_inner: self.is_inner }.swept(start, outer.x, accuracy);
                Member { h, swept, inner: Some(Varied { at: cos, by: turned }) }
            }
            Family::Turning => {
                let over = 1.0 / (1.0 + p);
                let fallen = (inner.x - profile.edge) * (-p * p * over).exponential();
                let x = Varied { at: profile.edge + fallen, by: -fallen * p * (2.0 + p) * over * over };
                let Radii { square, slope, .. } = profile.at(x.at, self.is_inner);
                let radius = square.sqrt();
                let h = Varied { at: radius, by: slope / radius * x.by };
                let slope = Varied { at: slope, by: profile.bend(x.at, self.is_inner) * x.by };
                let start = Start { x, slope, root: Varied::fixed(0.0) };
                let way = Way { profile, h, is_inner: self.is_inner };
                let legs = way.swept(start, inner.x, accuracy).and(way.swept(start, outer.x, accuracy));
                Member { h, swept: legs, inner: None }
            }
        }
    }

    /// The largest parameter of a family.
    fn most(&self, family: Family) -> f64 {
        match family {
            Family::Through => MOST,
            Family::Outward => (1.0 / self.reach()).inverse_hyperbolic_tangent().min(MOST),
            Family::Turning => {
                let q = ((self.ends[self.order[0]].x - self.profile.edge) / NEAREST).logarithm().max(0.0);
                0.5 * (q + (q * (q + 4.0)).sqrt())
            }
        }
    }

    /// The family of the ray that sweeps `psi`.
    fn family(&self, psi: f64) -> Family {
        if self.is_through() {
            return Family::Through;
        }
        if self.ends[self.order[0]].x <= self.profile.edge {
            return Family::Outward;
        }
        let grazing = |accuracy| self.member(Family::Turning, 0.0, accuracy).swept.angle.at;
        let mut limit = grazing(Accuracy::Coarse);
        if (limit - psi).abs() < MARGIN {
            limit = grazing(Accuracy::Fine);
        }
        if psi <= limit { Family::Outward } else { Family::Turning }
    }

    /// A parameter to begin with: that of a straight line in the isotropic chart, if there is one.
    fn guess(&self, family: Family, psi: f64, most: f64) -> f64 {
        let [inner, outer] = self.order.map(|i| self.ends[i].x);
        let ratio = if outer.is_finite() { self.profile.at(outer, self.is_inner).rho / self.inner.rho } else { f64::INFINITY };
        let guess = match family {
            Family::Through => 0.3 * psi,
            Family::Outward => {
                let alpha = if ratio.is_finite() { (ratio * psi.sine()).arctangent2(ratio * psi.cosine() - 1.0) } else { psi };
                let tan = (0.5 * alpha.clamp(0.0, 0.45 * std::f64::consts::PI)).tangent();
                (tan / self.reach()).inverse_hyperbolic_tangent()
            }
            Family::Turning => {
                let sin = if ratio.is_finite() {
                    let (x, y) = (ratio * psi.cosine() - 1.0, ratio * psi.sine());
                    y / x.hypotenuse(y)
                } else {
                    psi.sine()
                };
                let q = if psi < 3.0 && sin > 0.0 { -sin.logarithm() } else { 0.5 * psi };
                let limit = (inner - self.profile.edge).logarithm().max(0.0) + 1.0;
                let q = q.min(limit);
                0.5 * (q + (q * (q + 4.0)).sqrt())
            }
        };
        if guess > 0.0 && guess < most { guess } else { 0.5 * most }
    }

    /// The parameter at which the family sweeps `psi`, as near as quadratures of the given accuracy tell, the member there, and by how much the parameter
    /// is still to change.
    fn newton(&self, family: Family, psi: f64, (guess, most): (f64, f64), accuracy: Accuracy) -> Option<(f64, Member, f64)> {
        let (iterations, enough) = match accuracy {
            Accuracy::Coarse => (COARSE_ITERATIONS, GUESSED),
            Accuracy::Fine => (FINE_ITERATIONS, LAST),
        };
        let (mut low, mut high, mut p) = (0.0, most, guess);
        for _ in 0..iterations {
            let member = self.member(family, p, accuracy);
            let off = member.swept.angle.at - psi;
            let step = -off / member.swept.angle.by;
            if off.abs() <= enough * psi.min(1.0) {
                return Some((p, member, step));
            }
            if off > 0.0 {
                high = p
            } else {
                low = p
            }
            let next = p + step;
            p = if next > low && next < high { next } else { 0.5 * (low + high) };
            if high - low <= 1e-15 * high {
                break;
            }
        }
        // Beside the photon sphere, the angles of rays that wind have larger errors of rounding.
        let member = self.member(family, p, accuracy);
        let is_found = (member.swept.angle.at - psi).abs() <= ROUNDED;
        (accuracy == Accuracy::Coarse || is_found).then_some((p, member, 0.0))
    }

    /// The ray that sweeps `psi` >= 0 (rad); `None` if it cannot be told from one that winds for ever.
    pub fn orbit(&self, psi: f64) -> Option<Orbit> {
        let psi = psi.max(LEAST_ANGLE);
        let family = self.family(psi);
        let most = self.most(family);
        let (guess, _, step) = self.newton(family, psi, (self.guess(family, psi, most), most), Accuracy::Coarse)?;
        let guess = if guess + step > 0.0 && guess + step < most { guess + step } else { guess };
        let (_, member, step) = self.newton(family, psi, (guess, most), Accuracy::Fine)?;
        // Cosines against the direction away from the minimum.
        let cosine = |end: &End, h: f64| {
            let sin = (h / end.radius).min(1.0);
            ((1.0 - sin) * (1.0 + sin)).sqrt()
        };
        let [inner, outer] = self.order;
        let by = member.swept.angle.by;
        // Where the last step begins: it changes spreads by no more than rounding, but each of their factors may change by more.
        let before = self.ends.map(|end| cosine(&end, member.h.at));
        let spread = match member.inner {
            Some(Varied { by: turned, .. }) => by / (turned * self.ends[inner].radius) * before[outer],
            None => by / member.h.by * before[0] * before[1],
        };
        let h = (member.h.at + member.h.by * step).max(0.0);
        let mut cos = self.ends.map(|end| cosine(&end, h));
        if let Some(Varied { at, by: turned }) = member.inner {
            cos[inner] = (at - (1.0 - at * at).max(0.0).sqrt() * turned * step).clamp(0.0, 1.0);
        }
        let (sigma, spread) = (member.swept.sigma, spread.abs());
        match family {
            // The first end is left towards the minimum, the second one is reached away from it.
            Family::Through | Family::Turning => cos[0] = -cos[0],
            Family::Outward if inner == 1 => cos = cos.map(|c| -c),
            Family::Outward => {}
        }
        spread.is_finite().then_some(Orbit { h, cos, spread, sigma })
    }

    /// The same to some digits, without its spread.
    pub fn rough(&self, psi: f64) -> Option<Orbit> {
        let psi = psi.max(LEAST_ANGLE);
        let family = self.family(psi);
        let most = self.most(family);
        let (_, member, step) = self.newton(family, psi, (self.guess(family, psi, most), most), Accuracy::Coarse)?;
        let h = (member.h.at + member.h.by * step).max(0.0);
        let cos = self.ends.map(|end| (1.0 - (h / end.radius).min(1.0).powi(2)).sqrt());
        let falls = family != Family::Outward || self.order[0] == 1;
        Some(Orbit { h, cos: [if falls { -cos[0] } else { cos[0] }, cos[1]], spread: 0.0, sigma: member.swept.sigma })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bhs_core::spacetime::Spherical;
    use bhs_spacetimes::{Dneg, Ellis};
    use glam::DVec3;

    /// Angles between infinities against elliptic integrals and quadratures with many digits.
    #[test]
    fn swept_angles_are_those_of_long_quadratures() {
        let ellis = Profile::of_index(&Ellis { center: DVec3::X, throat: 1.0 }).unwrap();
        let dneg = Profile::of_index(&Dneg::new(DVec3::ZERO, 1.0, 1.0, 0.1).unwrap()).unwrap();
        let charged = |q: f64| Profile::of_spherical(&Spherical { center: DVec3::ZERO, rs: 2.0, charge_squared: q * q });
        let pi = std::f64::consts::PI;
        let cases = [
            (&ellis, true, 0.5, 1.685750354812596),
            (&ellis, true, 0.9, 4.104988449160986),
            (&dneg, true, 0.5, 1.8391092507240994),
            (&ellis, false, 2.0, pi + 0.2299080560353988),
            (&ellis, false, 1.1, pi + 1.50225541996245),
            (&charged(0.5), false, 6.0, pi + 1.551187254247158),
            (&charged(0.5), false, 10.0, pi + 0.5756100502520441),
            (&charged(0.9), false, 6.0, pi + 1.272240846265183),
            (&charged(0.9), false, 10.0, pi + 0.5437063921910459),
            (&charged(1.0), false, 6.0, pi + 1.197403706675174),
            (&charged(1.0), false, 10.0, pi + 0.5332426590717215),
        ];
        for (profile, through, h, right) in cases {
            let pair = Pair { ends: [End::sky(false), End::sky(through)], ..Pair::new(profile, [End::new(profile, 9.0); 2]) };
            let swept = if through {
                let p = (h / profile.least).inverse_hyperbolic_tangent();
                pair.member(Family::Through, p, Accuracy::Fine).swept
            } else {
                // Where R = h.
                let (mut a, mut b) = (0.0, 1e3);
                for _ in 0..200 {
                    let middle = 0.5 * (a + b);
                    if profile.at(middle, false).square.sqrt() < h { a = middle } else { b = middle }
                }
                let pair = Pair { ends: [End { x: a, ..End::sky(false) }, End::sky(false)], ..pair };
                let pair = Pair { ends: [pair.ends[0], End::sky(false)], order: [0, 1], ..pair };
                let leg = pair.member(Family::Turning, 0.0, Accuracy::Fine).swept;
                Swept { angle: Varied { at: 2.0 * leg.angle.at, by: 0.0 }, sigma: 0.0 }
            };
            let off = swept.angle.at - right;
            assert!(off.abs() < 1e-10, "{h}: {off:e}");
        }
    }
}
