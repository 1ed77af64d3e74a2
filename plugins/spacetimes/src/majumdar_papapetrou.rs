//! `majumdar-papapetrou`: any number of holes that keep each other at rest, each with the largest charge that its mass allows. World space
//! is the isotropic chart, in which the horizon of a hole is its centre.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `centers` | point3 | required | scene | centres of the holes, under the current transform |
//! | `masses` | float | required | scene | `G M / c^2` of each, under the current transform |

use crate::Minkowski;
use crate::graded::{from_index_of, variables_of};
use crate::placement::{Placement, in_range, is_length};
use bhs_core::Plugin;
use bhs_core::dual::Dual;
use bhs_core::params::{Params, Point3};
use bhs_core::real::{Real, Vector};
use bhs_core::spacetime::{Ball, Class, Fields, GradedIndex, Metric, Place, Side, Spacetime, Stationary, Stretch};
use glam::DVec3;
use std::sync::Arc;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Spacetime> = Plugin {
    name: "majumdar-papapetrou",
    summary: "several black holes at rest, each with the largest charge that its mass allows",
    build,
};

fn build(p: &Params) -> Option<Box<dyn Spacetime>> {
    let centers = p.require::<Vec<Point3>>("centers", "scene", "centres of the holes, under the current transform");
    let masses = p.require::<Vec<f64>>("masses", "scene", "G M / c^2 of each hole, under the current transform");
    let placement = Placement::of(p);
    let (centers, masses, placement) = (centers?, masses?, placement?);
    let counted = centers.len() == masses.len();
    if !counted {
        let (n, m) = (centers.len(), masses.len());
        p.reject("masses", "`masses` and `centers` differ in number", format!("{m} for {n} centres: expected one mass a centre"));
    }
    if !masses.iter().all(|mass| is_length(p, "masses", *mass)) || !counted {
        return None;
    }
    let centers: Vec<DVec3> = centers.iter().map(|c| placement.point(c.0)).collect();
    let masses: Vec<f64> = masses.iter().map(|mass| placement.length(*mass)).collect();
    if !in_range(p, &centers, &masses) {
        return None;
    }
    for (i, a) in centers.iter().enumerate() {
        if let Some(j) = centers[..i].iter().position(|b| (*a - *b).length() <= 1e-12 * a.length().max(b.length())) {
            let which =
                format!("numbers {} and {} are at the same place: write one hole with the sum of their masses", j + 1, i + 1);
            p.reject("centers", "two holes coincide", which);
            return None;
        }
    }
    let holes: Vec<Hole> = centers.into_iter().zip(masses).map(|(center, mass)| Hole { center, mass }).collect();
    let spacetime = MajumdarPapapetrou::new(&holes);
    Some(if spacetime.holes.is_empty() { Box::new(Minkowski::default()) } else { Box::new(spacetime) })
}

/// One of the holes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hole {
    /// Where it is (scene units).
    pub center: DVec3,
    /// `G M / c^2` (scene units), not negative.
    pub mass: f64,
}

/// Holes at rest, each as charged as it can be: `N = 1/U`, `gamma = U^2`, `U = 1 + sum M_i / |x - x_i|` (`docs/physics.md`, section 6).
#[derive(Clone, Debug)]
pub struct MajumdarPapapetrou {
    /// Those that have mass.
    holes: Arc<[Hole]>,
    /// Of each, the radius of its ball of no return.
    radii: Arc<[f64]>,
}

impl MajumdarPapapetrou {
    /// The spacetime of these holes, at different places. Those without mass are left out.
    pub fn new(holes: &[Hole]) -> Self {
        let holes: Arc<[Hole]> = holes.iter().copied().filter(|hole| hole.mass > 0.0).collect();
        let radii = (0..holes.len()).map(|i| capture_radius(&holes, i)).collect();
        Self { holes, radii }
    }

    /// The holes that have mass.
    pub fn holes(&self) -> &[Hole] {
        &self.holes
    }

    /// `U` and its gradient.
    #[inline(always)]
    fn potential<F: Real>(&self, x: Vector<F>) -> (F, Vector<F>) {
        let mut u = F::splat(1.0);
        let mut gradient = Vector::all(DVec3::ZERO);
        for hole in self.holes.iter() {
            let x = x - Vector::all(hole.center);
            let over = F::splat(1.0) / x.length_squared();
            let share = F::splat(hole.mass) * over.sqrt();
            u += share;
            gradient = gradient.plus(x, -share * over);
        }
        (u, gradient)
    }

    /// `n^2 = U^4` and half its gradient, `2 U^3 grad U`.
    #[inline(always)]
    fn index_of<F: Real>(&self, x: Vector<F>) -> (F, Vector<F>) {
        let (u, gradient) = self.potential(x);
        let square = u * u;
        (square * square, gradient * ((u + u) * square))
    }
}

/// The largest radius around hole `i` within which light that moves towards it never turns (`docs/physics.md`, section 6): where
/// `M_i / rho = 1 + sum M_j (D_j + rho) / (D_j - rho)^2` over the others, at distances `D_j`. Alone it is `M_i`, the photon sphere.
fn capture_radius(holes: &[Hole], i: usize) -> f64 {
    let here = holes[i];
    let others = || holes.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, o)| (o.mass, (o.center - here.center).length()));
    let nearest = others().map(|(_, distance)| distance).fold(f64::INFINITY, f64::min);
    let (mut low, mut high) = (0.0, here.mass.min(nearest));
    // Until the two are neighbours: the lower one has the property.
    loop {
        let rho = 0.5 * (low + high);
        if rho <= low || rho >= high {
            return low;
        }
        let needed: f64 = others().map(|(mass, d)| mass * (d + rho) / ((d - rho) * (d - rho))).sum();
        if rho * (1.0 + needed) <= here.mass {
            low = rho;
        } else {
            high = rho;
        }
    }
}

impl Spacetime for MajumdarPapapetrou {
    fn at(&self, place: Place) -> Option<Stationary> {
        let (u, _) = self.potential::<f64>(place.x.into());
        let lapse = 1.0 / u;
        (place.side == Side::Near && u.is_finite() && lapse > 0.0).then_some(Stationary {
            lapse,
            root: Stretch::isotropic(u),
            beta: DVec3::ZERO,
        })
    }

    fn captures(&self) -> Vec<Ball> {
        self.holes.iter().zip(self.radii.iter()).map(|(hole, radius)| Ball { center: hole.center, radius: *radius }).collect()
    }

    fn class(&self) -> Class<'_> {
        if self.holes.is_empty() { Class::Flat } else { Class::Index(self) }
    }

    fn metric(&self) -> &dyn Metric {
        self
    }

    fn moved(&self, origin: DVec3) -> Arc<dyn Spacetime> {
        let holes = self.holes.iter().map(|hole| Hole { center: hole.center - origin, ..*hole }).collect();
        Arc::new(Self { holes, radii: self.radii.clone() })
    }
}

impl GradedIndex for MajumdarPapapetrou {
    from_index_of!();
}

impl Metric for MajumdarPapapetrou {
    fn fields(&self, x: [Dual; 3]) -> Fields {
        let (u, _) = self.potential(variables_of(x));
        let square = u * u;
        Fields::isotropic(square.recip(), square)
    }
}
