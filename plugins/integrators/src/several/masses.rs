//! Several extremal holes in closed form, with the neighbours of rays: `n = U^2`, `U = 1 + sum M_i / |x - x_i|` (`docs/physics.md`, section 6).

use crate::graded_index::nystroem::{State, step};
use bhs_core::lanes::{LANES, Lanes};
use bhs_core::real::{Real, Vector};
use bhs_core::spacetime::{Class, Spacetime};
use glam::DVec3;

/// A hole.
#[derive(Clone, Copy, Debug)]
pub struct Mass {
    /// Its place (scene units).
    pub center: DVec3,
    /// Its mass (scene units).
    pub mass: f64,
    /// Radius of its ball of no return (scene units).
    pub radius: f64,
}

/// Several holes.
#[derive(Clone, Debug)]
pub struct Masses {
    /// Each of them.
    pub holes: Vec<Mass>,
    /// The middle of their masses.
    pub center: DVec3,
    /// Mass of all of them (scene units).
    pub mass: f64,
    /// How far they reach from the middle (scene units).
    pub extent: f64,
}

/// Where the mass of a hole is read off the index, over the radius of its ball of no return.
const PROBE: f64 = 0.1;

/// Relative difference of indices that are the same one.
const SAME_INDEX: f64 = 1e-9;

impl Masses {
    /// Those of `spacetime`, if its index is that of extremal holes in its balls of no return.
    pub fn of(spacetime: &dyn Spacetime) -> Option<Self> {
        let Class::Index(index) = spacetime.class() else { return None };
        let balls = spacetime.captures();
        if index.throat().is_some() || balls.is_empty() {
            return None;
        }
        let potential = |x: DVec3| index.index(x).0.sqrt().sqrt();
        // As many equations as masses, each for the most part of one of them.
        let places: Vec<DVec3> = balls.iter().map(|ball| ball.center + DVec3::X * (PROBE * ball.radius)).collect();
        let row = |x: &DVec3| -> Vec<f64> {
            let excess = potential(*x) - 1.0;
            balls.iter().map(|ball| 1.0 / (*x - ball.center).length()).chain([excess]).collect()
        };
        let masses = solve(places.iter().map(row).collect())?;
        let holes: Vec<Mass> = balls
            .iter()
            .zip(&masses)
            .map(|(ball, mass)| Mass { center: ball.center, mass: *mass, radius: ball.radius })
            .collect();
        let mass: f64 = masses.iter().sum();
        let center: DVec3 = holes.iter().map(|hole| hole.center * (hole.mass / mass)).sum();
        let extent = holes.iter().map(|hole| hole.center.distance(center) + hole.mass).fold(0.0, f64::max);
        let all = Self { holes, center, mass, extent };
        let is_right = |ball: &bhs_core::spacetime::Ball| {
            [DVec3::new(0.3, 0.5, -0.4), DVec3::new(-1.3, 0.2, 2.0)].iter().all(|aside| {
                let x = ball.center + *aside * ball.radius;
                (all.potential(x) / potential(x) - 1.0).abs() < SAME_INDEX
            })
        };
        (all.mass > 0.0 && all.holes.iter().all(|hole| hole.mass > 0.0) && balls.iter().all(is_right)).then_some(all)
    }

    /// The same holes, moved.
    pub fn moved(&self, by: DVec3) -> Self {
        let holes = self.holes.iter().map(|hole| Mass { center: hole.center + by, ..*hole }).collect();
        Self { holes, center: self.center + by, ..*self }
    }

    /// U
    pub fn potential(&self, x: DVec3) -> f64 {
        1.0 + self.holes.iter().map(|hole| hole.mass / (x - hole.center).length()).sum::<f64>()
    }

    /// The index at a place.
    pub fn index(&self, x: DVec3) -> f64 {
        self.potential(x).powi(2)
    }

    /// Acceleration of rays at a place, and of two neighbours of theirs.
    #[inline(always)]
    fn force(&self, [x, a, b]: [Vector<Lanes>; 3]) -> [Vector<Lanes>; 3] {
        let c = Lanes::splat;
        let zero = Vector::all(DVec3::ZERO);
        let (mut u, mut gradient, mut of_a, mut of_b) = (Lanes::ONE, zero, zero, zero);
        for hole in &self.holes {
            let r = x - Vector::all(hole.center);
            let over = Lanes::ONE / r.length_squared();
            let share = c(hole.mass) * Real::sqrt(over);
            u += share;
            let pull = share * over;
            gradient = gradient.plus(r, -pull);
            let tide = c(3.0) * pull * over;
            of_a = of_a.plus(r, tide * r.dot(a)).plus(a, -pull);
            of_b = of_b.plus(r, tide * r.dot(b)).plus(b, -pull);
        }
        let square = u * u;
        let cube = c(2.0) * square * u;
        let along = |j: Vector<Lanes>, tide: Vector<Lanes>| (tide * cube).plus(gradient, c(6.0) * square * gradient.dot(j));
        [gradient * cube, along(a, of_a), along(b, of_b)]
    }

    /// Square of the distance from the nearest hole.
    #[inline(always)]
    fn nearest(&self, x: Vector<Lanes>) -> Lanes {
        let mut nearest = Lanes::splat(f64::INFINITY);
        for hole in &self.holes {
            nearest = nearest.fast_min((x - Vector::all(hole.center)).length_squared());
        }
        nearest
    }

    /// Follows the rays from `from` to the parameters `sigma`, in steps of about the length `share` as seen from the nearest hole; where they come nearer
    /// to a hole than `limit`, they are given up: those are not finite.
    pub fn follow(&self, from: &Launch, sigma: Lanes, limit: Lanes, share: f64) -> Ended {
        let c = Lanes::splat;
        let x = from.x;
        let mut u = Lanes::ONE;
        for hole in &self.holes {
            u += c(hole.mass) / (x - Vector::all(hole.center)).length();
        }
        let n = u * u;
        let zero = x * Lanes::ZERO;
        let start = [x, zero, zero];
        let v = [from.launch * n, from.axes[0] * n, from.axes[1] * n];
        let mut state = State { x: start, v, a: self.force(start) };
        let mut left = sigma;
        let (limit, per_mass) = (limit * limit, c(0.25 / (self.mass * self.mass)));
        let mut lost = Lanes::ZERO;
        for _ in 0..MOST_STEPS {
            let nearest = self.nearest(state.x[0]);
            lost |= nearest.simd_lt(limit);
            let moving = left.simd_gt(Lanes::ZERO) & !lost;
            if moving.none() {
                break;
            }
            // What bends is 2 M / rho, and errors are of order 9: (rho / 2M)^(1/8), about.
            let far = Real::sqrt(Real::sqrt(Real::sqrt(Real::sqrt((nearest * per_mass).fast_max(Lanes::ONE)))));
            let stride = c(share) * far * Real::sqrt(nearest) / state.v[0].length();
            // Two equal steps instead of a long one and a short one.
            let h = left.simd_lt(stride * c(2.0)).select(c(0.5) * left, stride);
            let h = left.simd_le(stride).select(left, h);
            let next = step(|s| self.force(s), &state, h).end;
            state = next.or(&state, moving);
            left = moving.select(left - h, left);
        }
        lost |= left.simd_gt(Lanes::ZERO);
        let [x, a, b] = state.x;
        Ended { x, tangent: state.v[0], aside: [a, b], lost: lost.to_bitmask() }
    }
}

/// Steps after which rays are given up.
const MOST_STEPS: u32 = 120;

/// Rays that begin.
#[derive(Clone, Copy, Debug)]
pub struct Launch {
    /// Where.
    pub x: Vector<Lanes>,
    /// Unit directions.
    pub launch: Vector<Lanes>,
    /// Two directions at right angles to each.
    pub axes: [Vector<Lanes>; 2],
}

/// Where rays end.
#[derive(Clone, Copy, Debug)]
pub struct Ended {
    /// Places.
    pub x: Vector<Lanes>,
    /// Tangents of the length n.
    pub tangent: Vector<Lanes>,
    /// Derivatives of the places by the angles of launches towards both axes.
    pub aside: [Vector<Lanes>; 2],
    /// Bits of those that were given up.
    pub lost: u32,
}

/// How many rays are followed side by side.
pub const ABREAST: usize = LANES;

/// The solution of linear equations, each a row with its right side at the end.
fn solve(mut rows: Vec<Vec<f64>>) -> Option<Vec<f64>> {
    let n = rows.len();
    for i in 0..n {
        let pivot = (i..n).max_by(|a, b| rows[*a][i].abs().total_cmp(&rows[*b][i].abs()))?;
        rows.swap(i, pivot);
        let row = rows[i].clone();
        for other in rows.iter_mut().skip(i + 1) {
            let share = other[i] / row[i];
            other.iter_mut().zip(&row).skip(i).for_each(|(x, r)| *x -= share * r);
        }
    }
    let mut found = vec![0.0; n];
    for i in (0..n).rev() {
        let rest: f64 = (i + 1..n).map(|k| rows[i][k] * found[k]).sum();
        found[i] = (rows[i][n] - rest) / rows[i][i];
    }
    found.iter().all(|x| x.is_finite()).then_some(found)
}
