//! Angles swept by rays of round spacetimes, with their derivatives: `psi = integral of h ds / sqrt(R^2 - h^2)`.
//!
//! From a place x1 outwards, `R^2 - h^2 = c0 + 2 c1 v + ...` with `v = x - x1`, which is 0 at a turning point. The new variable is zeta, with
//! `2 v = zeta + e / zeta - 2 l` and `2 sqrt(q) = zeta - e / zeta` for the model `q = v^2 + 2 l v + r0^2` (`l = c1/c2`, `r0^2 = c0/c2`,
//! `e = l^2 - r0^2`, `c2` the limit of `R^2/x^2`): `dx = sqrt(q) dzeta / zeta` takes the root's singularity out. Far from the minimum
//! `2 / zeta` is a smooth variable up to infinity; near the critical ray, where angles grow as a logarithm, it is the area sine of that.
//!
//! Nodes stand side by side in lanes. Derivatives by a parameter of the ray are carried along (forward differentiation).

use crate::round::profile::{Profile, Radii};
use bhs_core::lanes::{LANES, Lanes, total};
use bhs_core::quadrature::gauss_legendre;
use bhs_core::real::Real;
use bhs_elementary::Elementary;
use std::sync::LazyLock;

/// A number and its derivative by the parameter of a ray.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Varied {
    /// The number.
    pub at: f64,
    /// Its derivative.
    pub by: f64,
}

impl Varied {
    /// A number that does not depend on the parameter.
    pub const fn fixed(at: f64) -> Self {
        Self { at, by: 0.0 }
    }
}

/// What a stretch of a ray adds up to.
#[derive(Clone, Copy, Debug, Default)]
pub struct Swept {
    /// Swept angle (rad), and its derivative by the parameter.
    pub angle: Varied,
    /// The parameter sigma of rays of a refractive index, `|dx/dsigma| = n` (scene units).
    pub sigma: f64,
}

impl Swept {
    /// Both together.
    #[must_use]
    pub fn and(self, o: Self) -> Self {
        let angle = Varied { at: self.angle.at + o.angle.at, by: self.angle.by + o.angle.by };
        Self { angle, sigma: self.sigma + o.sigma }
    }
}

/// Nodes and weights of Gauss and Legendre between 0 and 1, side by side.
type Rule<const BATCHES: usize> = [[Lanes; 2]; BATCHES];

fn rule<const BATCHES: usize>() -> Rule<BATCHES> {
    let node = |i: usize| gauss_legendre(i, BATCHES * LANES);
    std::array::from_fn(|b| [0, 1].map(|which| Lanes::from_fn(|i| node(b * LANES + i)[which])))
}

static COARSE: LazyLock<Rule<1>> = LazyLock::new(rule);
static FINE: LazyLock<Rule<4>> = LazyLock::new(rule);

/// How precise a quadrature is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Accuracy {
    /// To some digits, for first guesses.
    Coarse,
    /// To some ten digits.
    Fine,
}

/// Where a stretch of a ray begins: its place nearest to the minimum of the optical radius.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// |x|.
    pub x: Varied,
    /// Half the derivative of R^2 by |x|.
    pub slope: Varied,
    /// `sqrt(R^2 - h^2)`: 0 at a turning point.
    pub root: Varied,
}

/// A ray's impact parameter `h`, and whether the stretch lies within the photon sphere.
#[derive(Clone, Copy, Debug)]
pub struct Way<'a> {
    /// The spacetime.
    pub profile: &'a Profile,
    /// Impact parameter (scene units).
    pub h: Varied,
    /// Whether places are within the photon sphere of a hole.
    pub is_inner: bool,
}

/// Up to this 2/zeta that is the variable itself: with few nodes, and with many.
const ALGEBRAIC: [f64; 2] = [3.0, 1.0];

/// Length of a stretch, over 1 + |x|, up to which R^2 is a parabola to rounding.
const SHORT: f64 = 1e-4;

impl Way<'_> {
    /// From `start` outwards to |x| = `end`, which may be infinite.
    pub fn swept(&self, start: Start, end: f64, accuracy: Accuracy) -> Swept {
        let (profile, mut start, mut sum) = (self.profile, start, Swept::default());
        if start.x.at < profile.edge {
            // Along the cylinder R does not change.
            let to = profile.edge.min(end);
            let length = to.inverse_hyperbolic_sine() - start.x.at.inverse_hyperbolic_sine();
            let (h, root) = (self.h, start.root);
            let angle = h.at / root.at * length;
            let by = (h.by - h.at * root.by / root.at) / root.at * length;
            let [a, b] = [start.x.at, to].map(|x| profile.at(x, false).rho);
            sum = Swept { angle: Varied { at: angle, by }, sigma: 0.5 * (b - a) * (b + a) / root.at };
            start = Start { x: Varied::fixed(to), slope: Varied::fixed(0.0), root };
        }
        for &to in &profile.breaks {
            if to > start.x.at && to < end && !self.is_inner {
                sum = sum.and(self.smooth(start, to, accuracy));
                let Radii { square, slope, .. } = profile.at(to, false);
                let root = (square - self.h.at * self.h.at).max(f64::MIN_POSITIVE).sqrt();
                let root = Varied { at: root, by: -self.h.at * self.h.by / root };
                start = Start { x: Varied::fixed(to), slope: Varied::fixed(slope), root };
            }
        }
        if end > start.x.at { sum.and(self.smooth(start, end, accuracy)) } else { sum }
    }

    /// The same where nothing jumps.
    fn smooth(&self, start: Start, end: f64, accuracy: Accuracy) -> Swept {
        match accuracy {
            Accuracy::Coarse => self.piece(start, end, &COARSE),
            Accuracy::Fine => self.piece(start, end, &FINE),
        }
    }

    fn piece<const B: usize>(&self, start: Start, end: f64, rule: &Rule<B>) -> Swept {
        let Self { profile, h, is_inner } = *self;
        let c = Lanes::splat;
        // Coefficients of the model.
        let size = 2.0 * profile.middle;
        let scaled = |v: Varied, by: f64| Varied { at: v.at / by, by: v.by / by };
        let (l, r0) = (scaled(start.slope, size * size), scaled(start.root, size));
        let e = (l.at - r0.at) * (l.at + r0.at);
        let e_by = 2.0 * (l.at * l.by - r0.at * r0.by);
        let first = Varied { at: l.at + r0.at, by: l.by + r0.by };
        // 2/zeta at both ends.
        let near = Varied { at: 2.0 / first.at, by: -2.0 * first.by / (first.at * first.at) };
        let length = end - start.x.at;
        let far = if length.is_finite() {
            let root = (r0.at * r0.at + length * (2.0 * l.at + length)).sqrt();
            let last = l.at + length + root;
            let by = l.by - start.x.by + (r0.at * r0.by + l.by * length - (l.at + length) * start.x.by) / root;
            Varied { at: 2.0 / last, by: -2.0 * by / (last * last) }
        } else {
            Varied::fixed(0.0)
        };
        // A stretch so short that the difference of squares would be rounding is a parabola.
        let bend = (length <= SHORT * (1.0 + start.x.at)).then(|| profile.bend(start.x.at, is_inner));
        let is_algebraic = near.at <= ALGEBRAIC[usize::from(B > 1)];
        let area_sine = |v: Varied| Varied { at: v.at.inverse_hyperbolic_sine(), by: v.by / (1.0 + v.at * v.at).sqrt() };
        let [far, near] = if is_algebraic { [far, near] } else { [far, near].map(area_sine) };
        let range = Varied { at: near.at - far.at, by: near.by - far.by };
        let (mut angle, mut angle_by, mut sigma) = (Lanes::ZERO, Lanes::ZERO, Lanes::ZERO);
        for [node, weight] in rule {
            let t = c(range.at) * *node + c(far.at);
            let t_by = c(range.by) * *node + c(far.by);
            // zeta, its logarithmic derivative, and that of the variable, dzeta/zeta = -measure dt.
            let (tau, measure, measure_by) = if is_algebraic {
                let over = Lanes::ONE / t;
                (t, over, -t_by * over)
            } else {
                let e = Lanes::from_fn(|i| t.lane(i).exponential());
                let over = Lanes::ONE / e;
                let (sinh, cosh) = (c(0.5) * (e - over), c(0.5) * (e + over));
                (sinh, cosh / sinh, -t_by / (sinh * cosh))
            };
            let over = c(0.5) * tau;
            let zeta = Lanes::ONE / over;
            let zeta_by = -zeta * measure * t_by;
            let shift = c(e) * over;
            // v = 0 at the start, to rounding.
            let from_start =
                if is_algebraic { c(range.at * first.at * 0.5) * (Lanes::ONE - *node) * zeta } else { zeta - c(first.at) };
            let v = c(0.5) * from_start * (Lanes::ONE - c(l.at - r0.at) * over);
            let v_by = c(0.5) * (zeta_by * (Lanes::ONE - shift * over) + c(e_by) * over) - c(l.by);
            let model = c(0.5) * (zeta - shift);
            let model_by = c(0.5) * (zeta_by * (Lanes::ONE + shift * over) - c(e_by) * over);
            let x = c(start.x.at) + v;
            let x_by = c(start.x.by) + v_by;
            let Radii { square, slope, rho, pace } = profile.at(x, is_inner);
            // R^2 - h^2, and half its derivative.
            let (rest, rest_by) = match bend {
                None => (square - c(h.at * h.at), slope * x_by - c(h.at * h.by)),
                Some(bend) => {
                    let (c0, c1) = (start.root, start.slope);
                    let twice = c(2.0 * c1.at) + c(bend) * v;
                    let by = c(c0.at * c0.by) + c(c1.by) * v + (c(c1.at) + c(bend) * v) * v_by;
                    (c(c0.at * c0.at) + twice * v, by)
                }
            };
            let rest = rest.fast_max(c(f64::MIN_POSITIVE));
            // Without h.
            let share = *weight * model * pace * measure / rest.sqrt();
            let share_by = model_by / model - rest_by / rest - x * x_by * pace * pace + measure_by;
            angle += share;
            angle_by += share * share_by;
            sigma += rho * rho * share;
        }
        let sum = total(angle);
        let by = h.by * range.at * sum + h.at * (range.by * sum + range.at * total(angle_by));
        Swept { angle: Varied { at: h.at * range.at * sum, by }, sigma: range.at * total(sigma) }
    }
}
