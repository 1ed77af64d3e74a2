//! What is known of rays that have been followed, and of geodesics between points: as numbers, for whoever writes them.

use crate::job::Job;
use bhs_core::ray::{Arrival, Ray, RayEnd};
use bhs_core::spacetime::{Place, Side};
use bhs_engine::connections::{Connection, Connections, ShadowRay};
use bhs_engine::layer::VisibleSurface;
use bhs_engine::scene::Scene;
use bhs_layers::orbit::{Constants, impact_parameter, swept_angle};
use bhs_layers::redshift;
use glam::{DVec2, DVec3, Vec2};
use std::f64::consts::TAU;

/// A direction whose square is this close to 1 is of length 1 but for rounding, and is taken as it is.
const UNIT: f64 = 4.0 * f64::EPSILON;

/// A ray that is asked about.
#[derive(Clone, Copy, Debug)]
pub struct Asked {
    /// In world space.
    pub ray: Ray,
    /// Wavelength over that at E = 1 as a camera there measures it; `None` if it is no camera's ray: then the static observer's.
    pub ratio: Option<f64>,
}

impl Asked {
    /// A ray from `origin` in the chart direction `direction`, of any length but 0 (world space), measured by the static observer there.
    ///
    /// # Errors
    /// If the direction is zero.
    pub fn ray(origin: DVec3, direction: DVec3, side: Side, footprint: f64) -> Result<Self, &'static str> {
        let unit = if (direction.length_squared() - 1.0).abs() < UNIT { Some(direction) } else { direction.try_normalize() };
        let direction = unit.ok_or("the direction is zero")?;
        Ok(Self { ray: Ray { side, footprint, ..Ray::new(origin, direction) }, ratio: None })
    }

    /// The ray through the centre of a pixel of the camera of `job`, moving or not, which measures its light.
    pub fn pixel(job: &Job, [x, y]: [u32; 2]) -> Self {
        let raster = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let (ray, ratio) = job.camera_ray(raster, Vec2::splat(0.5));
        Self { ray: Ray { origin: ray.origin + job.scene.world.origin, ..ray }, ratio: ratio.or(Some(f64::NAN)) }
    }

    /// The ray in render space, and the ratio of who measures its light where it starts; that is `None` where nothing can stand still.
    fn in_scene(&self, scene: &Scene) -> (Ray, Option<f64>) {
        let ray = Ray { origin: self.ray.origin - scene.world.origin, ..self.ray };
        let start = Place { x: ray.origin, side: ray.side };
        (ray, self.ratio.or_else(|| static_ratio(scene, start, ray.direction)))
    }
}

/// The static observer's wavelength over that at E = 1 at `place`; `None` where nothing can stand still.
fn static_ratio(scene: &Scene, place: Place, direction: DVec3) -> Option<f64> {
    scene.observer(place).map(|observer| observer.ratio(direction))
}

/// The side in words.
pub fn word(side: Side) -> &'static str {
    match side {
        Side::Near => "near",
        Side::Far => "far",
    }
}

/// What became of a ray; `None` of what it does not have.
#[derive(Clone, Copy, Debug)]
pub struct Followed {
    /// `hit`, `escaped`, `captured` or `out of steps`.
    pub outcome: &'static str,
    /// Where it meets a surface (world space).
    pub point: Option<DVec3>,
    /// The unit chart direction that it has there, or far away.
    pub direction: Option<DVec3>,
    /// The number of the `Shape` directive that it ends on.
    pub shape: Option<u32>,
    /// The side on which it ends.
    pub side: Option<Side>,
    /// Angle that it sweeps around the hole (rad).
    pub phi: f64,
    /// Steps of the integrator.
    pub steps: u32,
    /// Questions to the intersector.
    pub queries: u32,
    /// The light that arrives along it.
    pub light: Light,
}

/// What is known of the light that arrives along a ray; `None` of what it does not have.
#[derive(Clone, Copy, Debug)]
pub struct Light {
    /// Coordinate time from the surface to where the ray starts (scene units).
    time: Option<f64>,
    /// `nu_observed / nu_emitted`
    redshift: Option<f64>,
    /// Impact parameter (scene units).
    b: Option<f64>,
    constants: Option<Constants>,
    /// Turns around the hole.
    winding: Option<f64>,
}

impl Light {
    /// What its numbers are called.
    pub const NAMES: [&str; 6] = ["time", "redshift", "b", "L", "Q", "winding"];

    /// Those numbers, in the order of the names; `None` of what it does not have, or is not finite.
    pub fn numbers(&self) -> [Option<f64>; 6] {
        let Self { time, redshift, b, constants, winding } = *self;
        let (l, q) = constants.map_or((None, None), |c| (Some(c.angular_momentum), Some(c.carter)));
        [time, redshift, b, l, q, winding].map(|number| number.filter(|x| x.is_finite()))
    }
}

impl Followed {
    /// Follows rays together, which takes less than one after the other; what becomes of each does not depend on the others.
    pub fn all(scene: &Scene, asked: &[Asked]) -> Vec<Self> {
        let (rays, ratios): (Vec<Ray>, Vec<Option<f64>>) = asked.iter().map(|asked| asked.in_scene(scene)).unzip();
        let mut ends = vec![RayEnd::NONE; rays.len()];
        scene.integrator.trace_all(&scene.world, &rays, &mut ends);
        rays.iter().zip(ends).zip(ratios).map(|((ray, end), ratio)| Self::of(scene, ray, end, ratio)).collect()
    }

    /// Follows a ray, and tells the points of its way, those between which it was put to the intersector.
    pub fn with_way(scene: &Scene, asked: &Asked) -> (Self, Vec<WayPoint>) {
        let (ray, ratio) = asked.in_scene(scene);
        let (end, points) = scene.integrator.way(&scene.world, &ray);
        let points = points.into_iter().map(|p| WayPoint {
            point: p.place.x + scene.world.origin,
            side: p.place.side,
            phi: p.swept,
            time: p.time,
            redshift: static_ratio(scene, p.place, p.tangent).zip(ratio).map(|(there, here)| there / here),
            direction: p.tangent,
        });
        (Self::of(scene, &ray, end, ratio), points.collect())
    }

    /// What is known of `ray` (render space), which has come to `end`. `ratio`: see [`Asked::in_scene`].
    fn of(scene: &Scene, ray: &Ray, end: RayEnd, ratio: Option<f64>) -> Self {
        let seen = VisibleSurface::of_ray(scene, *ray, end, ratio.unwrap_or(f64::NAN));
        // Time is of light from a surface, and the ray is followed once more for it.
        let is_hit = matches!(end.arrival, Arrival::Surface(_));
        let light = Light {
            time: is_hit.then(|| scene.integrator.travel_time(&scene.world, ray)).flatten(),
            redshift: redshift(&seen),
            b: impact_parameter(&seen),
            constants: Constants::of(&seen),
            winding: swept_angle(&seen).map(|angle| angle / TAU),
        };
        let (outcome, point, direction, shape, side) = match end.arrival {
            Arrival::Surface(hit) => {
                let shape = scene.shapes[hit.geometry as usize].index;
                let side = scene.world.side_of(hit.geometry);
                ("hit", Some(hit.point + scene.world.origin), Some(hit.direction), Some(shape), Some(side))
            }
            Arrival::Sky(direction, side) => ("escaped", None, Some(direction), None, Some(side)),
            Arrival::Captured => ("captured", None, None, None, None),
            Arrival::OutOfSteps => ("out of steps", None, None, None, None),
        };
        let (steps, queries) = (end.cost.steps, end.cost.queries);
        Self { outcome, point, direction, shape, side, phi: end.swept, steps, queries, light }
    }
}

/// A point of the way of a ray.
#[derive(Clone, Copy, Debug)]
pub struct WayPoint {
    /// World space.
    pub point: DVec3,
    /// Its side.
    pub side: Side,
    /// Angle swept around the hole so far (rad).
    pub phi: f64,
    /// Coordinate time that light takes from here to the start of the ray (scene units).
    pub time: Option<f64>,
    /// Wavelength that the static observer here has over that of who looks along the ray: how much bluer the light is here.
    pub redshift: Option<f64>,
    /// Unit chart direction.
    pub direction: DVec3,
}

/// A geodesic that joins two points.
#[derive(Clone, Copy, Debug)]
pub struct Joined {
    /// Its number among those that may join two points: two for each number of turns around the hole.
    pub image: usize,
    /// Itself.
    pub connection: Connection,
    /// Whether a surface stands in its way.
    pub is_blocked: bool,
}

/// The geodesics from the first of two points to the second (world space).
pub fn joined(scene: &Scene, connections: &dyn Connections, pair: [DVec3; 2]) -> Vec<Joined> {
    let [x, y] = pair.map(|p| p - scene.world.origin);
    let turns = (0..connections.turns() as usize).flat_map(|turn| {
        let found = connections.connect(&scene.world, Place::near(x), Place::near(y), turn as u32);
        found.into_iter().enumerate().filter_map(move |(side, connection)| Some((2 * turn + side, connection?)))
    });
    let judged = turns.map(|(image, connection)| {
        // From the very points: if they lie on surfaces, those do not block.
        let start = Ray::new(x, connection.launch);
        let ray = ShadowRay { start, from: x, to: Place::near(y), target: None, connection };
        let mut occluded = [false];
        connections.occluded_all(&scene.world, &[ray], &mut occluded);
        Joined { image, connection, is_blocked: occluded[0] }
    });
    judged.collect()
}
