//! Rays in a spacetime: which way of following them belongs to which class.

use crate::general::course::{Depths, GeneralRay};
use crate::general::path::Surroundings;
use crate::graded_index::course::GradedSetup;
use crate::graded_index::medium::Refracted;
use crate::kerr::course::KerrSetup;
use crate::spherical::closed_form::ClosedForm;
use crate::spherical::course::{RungeKutta, SphericalSetup};
use crate::spherical::exact::ClosedForms;
use crate::straight::Straight;
use crate::tolerance::Tolerance;
use crate::tracing::driver::follow;
use crate::tracing::extent::{Extent, Precision};
use crate::tracing::places::Start;
use crate::tracing::surfaces::{BothSides, Surfaces};
use arrayvec::ArrayVec;
use bhs_core::lanes::{LANES, Lanes};
use bhs_core::ray::{Ray, RayEnd};
use bhs_core::real::{Real, Vector};
use bhs_core::spacetime::{Class, Spacetime};
use bhs_engine::integrator::Integrator;
use bhs_engine::way::Watch;
use bhs_engine::world::World;
use glam::DVec3;

/// How rays are followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Method {
    /// To a tolerance, by what suits the class of the spacetime best.
    Adaptive(Tolerance),
    /// By classic Runge-Kutta steps of this length, as seen from the nearest hole (rad).
    RungeKutta(f64),
    /// In closed form, to a tolerance of the chords.
    Exact(Tolerance),
    /// To a tolerance, by Hamilton's equations.
    General(Tolerance),
}

/// Follows rays.
#[derive(Clone, Copy, Debug)]
pub struct Tracer {
    /// How.
    pub method: Method,
    /// Steps after which a ray is given up.
    pub max_steps: u64,
    /// Whether light is followed to where it goes, not to where it comes from.
    pub forwards: bool,
}

/// What is told once of a world through which many rays are followed.
enum Setup<'w> {
    Straight,
    Spherical(SphericalSetup, Extent),
    Kerr(KerrSetup, Extent),
    Index(GradedSetup<'w>),
    General(Box<Surroundings<'w>>, Depths, Extent),
}

impl Method {
    fn setup<'w>(self, world: &World, spacetime: &'w dyn Spacetime) -> Setup<'w> {
        let extent = Extent::of(world);
        let general = || {
            let throat = match spacetime.class() {
                Class::Index(index) => index.throat(),
                _ => None,
            };
            let surroundings = Surroundings::new(spacetime, throat, true, extent.reach);
            Setup::General(Box::new(surroundings), Depths::new(world, spacetime), extent)
        };
        match (self, spacetime.class()) {
            (_, Class::Flat) => Setup::Straight,
            (Self::General(_), _) | (_, Class::General(_)) => general(),
            (_, Class::Spherical(hole)) => Setup::Spherical(SphericalSetup::new(&hole, extent.around(hole.center)), extent),
            (_, Class::Kerr(kerr)) => Setup::Kerr(KerrSetup::new(world, &kerr, &extent), extent),
            (_, Class::Index(index)) => Setup::Index(GradedSetup::new(world, spacetime, index)),
        }
    }
}

/// A world and its surfaces.
type Filled<'w> = (&'w World, &'w BothSides<'w>);

impl Tracer {
    /// Back to where light comes from.
    pub fn new(method: Method, max_steps: u64) -> Self {
        Self { method, max_steps, forwards: false }
    }

    /// The same to where it goes.
    pub fn forwards(self) -> Self {
        Self { forwards: true, ..self }
    }

    /// Follows each of `rays`.
    pub fn trace_all(&self, world: &World, rays: &[Ray], ends: &mut [RayEnd]) {
        self.with_setup(world, |setup| match setup {
            Setup::Straight => Straight.trace_all(world, rays, ends),
            _ => {
                let surfaces = Surfaces::of(world);
                for (rays, ends) in rays.chunks(LANES).zip(ends.chunks_mut(LANES)) {
                    self.follow(setup, (world, &surfaces), rays, None, ends);
                }
            }
        });
    }

    /// Follows `ray`, and shows its way to `watch`.
    pub fn watched(&self, world: &World, ray: &Ray, watch: &mut dyn Watch) -> RayEnd {
        self.with_setup(world, |setup| {
            if matches!(setup, Setup::Straight) {
                return Straight.watched(world, ray, watch);
            }
            let mut end = RayEnd::NONE;
            let (one, end_of_one) = (std::slice::from_ref(ray), std::slice::from_mut(&mut end));
            self.follow(setup, (world, &Surfaces::of(world)), one, Some(watch), end_of_one);
            end
        })
    }

    /// Does `work` with what is told of `world`.
    fn with_setup<R>(&self, world: &World, work: impl FnOnce(&Setup<'_>) -> R) -> R {
        let reversed = if self.forwards { world.spacetime().reversed() } else { None };
        work(&self.method.setup(world, reversed.as_deref().unwrap_or(world.spacetime())))
    }

    /// Follows up to [`LANES`] rays side by side.
    fn follow(&self, setup: &Setup<'_>, world: Filled<'_>, rays: &[Ray], watch: Option<&mut dyn Watch>, ends: &mut [RayEnd]) {
        match (setup, rays) {
            (Setup::General(surroundings, depths, extent), _) => {
                self.follow_general((surroundings, depths), extent, world, rays, (watch, ends));
            }
            (_, [_]) => self.follow_side_by_side::<f64>(setup, world, rays, watch, ends),
            _ => self.follow_side_by_side::<Lanes>(setup, world, rays, watch, ends),
        }
    }

    fn follow_side_by_side<F: Refracted>(
        &self,
        setup: &Setup<'_>,
        world: Filled<'_>,
        rays: &[Ray],
        watch: Option<&mut dyn Watch>,
        ends: &mut [RayEnd],
    ) {
        let (extent, center) = match setup {
            Setup::Spherical(setting, extent) => (extent, setting.center),
            Setup::Kerr(setting, extent) => (extent, setting.hole.kerr.round().center),
            Setup::Index(setting) => (&setting.extent, setting.medium.center),
            Setup::Straight | Setup::General(..) => return,
        };
        let (gap, error) = self.precisions::<F>(extent, rays, center);
        let start = Start::new(world.1, &rays, rays.len(), |i| &rays[i], (gap, F::splat(f64::INFINITY)));
        let (x, d) = (start.origin, Vector::from_fn(|i| rays[i.min(rays.len() - 1)].direction));
        let max_steps = self.max_steps;
        match (setup, self.method) {
            (Setup::Spherical(setting, _), Method::RungeKutta(step)) => {
                follow(world.0, &start, &mut setting.launch(x, d).by(RungeKutta(step)), max_steps, watch, ends);
            }
            (Setup::Spherical(setting, _), Method::Exact(_)) => {
                let launch = setting.launch(x, d);
                let form = |i: usize| ClosedForm::new(setting.hole.rs, launch.at.u.lane(i), launch.at.du.lane(i));
                let forms: ArrayVec<ClosedForm, LANES> = (0..rays.len()).map(form).collect();
                follow(world.0, &start, &mut launch.by(ClosedForms(&forms)), max_steps, watch, ends);
            }
            (Setup::Spherical(setting, _), _) => {
                follow(world.0, &start, &mut setting.launch(x, d).by_series(error), max_steps, watch, ends);
            }
            (Setup::Kerr(setting, _), Method::RungeKutta(step)) => {
                follow(world.0, &start, &mut setting.by_runge_kutta(x, d, step), max_steps, watch, ends);
            }
            (Setup::Kerr(setting, _), _) => {
                follow(world.0, &start, &mut setting.by_series(x, d, error), max_steps, watch, ends);
            }
            (Setup::Index(setting), method) => {
                let course = setting.rays(x, d, start.far, error);
                let mut course = if let Method::RungeKutta(step) = method { course.by_runge_kutta(step) } else { course };
                follow(world.0, &start, &mut course, max_steps, watch, ends);
            }
            _ => {}
        }
    }

    /// One after the other.
    fn follow_general(
        &self,
        told: (&Surroundings<'_>, &Depths),
        extent: &Extent,
        world: Filled<'_>,
        rays: &[Ray],
        (mut watch, ends): (Option<&mut dyn Watch>, &mut [RayEnd]),
    ) {
        for (ray, end) in rays.iter().zip(ends) {
            let one = std::slice::from_ref(ray);
            let (gap, error) = self.precisions::<f64>(extent, one, told.0.center());
            let start = Start::new(world.1, &one, 1, |_| ray, (gap, f64::INFINITY));
            let mut course = GeneralRay::new(told, ray.origin, ray.direction, ray.side, error);
            let end = std::slice::from_mut(end);
            follow(world.0, &start, &mut course, self.max_steps, watch.take(), end);
        }
    }

    /// How far the chords of `rays` may stray from them, and the errors that they are followed with, over their distance from what is at `center`.
    #[inline]
    fn precisions<F: Real>(&self, extent: &Extent, rays: &[Ray], center: DVec3) -> (F, F) {
        let of = |footprint: f64| self.precision(extent, footprint, center);
        let first = of(rays[0].footprint);
        // Neighbours mostly have the same footprint.
        if rays.iter().all(|ray| ray.footprint == rays[0].footprint) {
            return (F::splat(first.gap), F::splat(first.error));
        }
        let mut all = [first; LANES];
        for (ray, precision) in rays.iter().zip(&mut all) {
            *precision = of(ray.footprint);
        }
        let last = rays.len() - 1;
        (F::from_fn(|i| all[i.min(last)].gap), F::from_fn(|i| all[i.min(last)].error))
    }

    fn precision(&self, extent: &Extent, footprint: f64, center: DVec3) -> Precision {
        match self.method {
            Method::Adaptive(tolerance) | Method::General(tolerance) => extent.precision(tolerance, footprint, center),
            Method::Exact(tolerance) => Precision { error: 0.0, gap: extent.distance(tolerance, footprint) },
            // One chord a step.
            Method::RungeKutta(_) => Precision { error: RUNGE_KUTTA_ERROR, gap: f64::INFINITY },
        }
    }
}

/// What a course is told of the error that is asked for, if its steps do not depend on it.
const RUNGE_KUTTA_ERROR: f64 = 1e-6;
