//! The way of a ray: what an integrator shows of it to whoever watches, and how long light takes along it.

use crate::world::World;
use bhs_core::quadrature::{integral, integral_at_once};
use bhs_core::spacetime::{Place, Side};
use glam::DVec3;

/// A part of the curve that a ray follows.
pub struct CurvePart<'a> {
    /// The parameters where it begins and where it ends.
    pub ends: [f64; 2],
    /// The side that it is on, in whose chart its points are.
    pub side: Side,
    /// Point (render space) and derivative by the parameter, at a parameter between the ends.
    pub curve: &'a dyn Fn(f64) -> [DVec3; 2],
}

/// Sees the way of a ray while it is followed. What becomes of the ray does not depend on it.
pub trait Watch {
    /// Whether it wants points of the way.
    fn wants_points(&self) -> bool {
        true
    }

    /// The next point of the way (render space), and the curve's parameter there: where the ray starts, where straight segments of it end that were put
    /// to the intersector, as many where free space was passed over, and where it arrives.
    fn point(&mut self, _parameter: f64, _point: DVec3) {}

    /// The next part of the curve, after the points of it. The parts of a ray that arrives somewhere are together its curve from start to end; of a ray
    /// that leaves for ever, up to somewhere beyond all surfaces.
    fn part(&mut self, _part: &CurvePart<'_>) {}
}

/// The points of the way.
impl Watch for Vec<DVec3> {
    fn point(&mut self, _: f64, point: DVec3) {
        self.push(point);
    }
}

/// Coordinate time that the light which a ray follows back takes along it (`docs/physics.md`, section 1).
pub(crate) struct TravelTime<'w> {
    world: &'w World,
    /// Whether it is wanted to rounding.
    is_precise: bool,
    /// Time along all parts so far (scene units); not finite if there is none.
    pub time: f64,
}

impl<'w> TravelTime<'w> {
    pub fn new(world: &'w World) -> Self {
        Self { world, is_precise: true, time: 0.0 }
    }

    /// The same as precise as pictures need it, to some 1e-6.
    pub fn rough(world: &'w World) -> Self {
        Self { is_precise: false, ..Self::new(world) }
    }

    /// Time along `part` from the parameter `a` to the parameter `b`.
    fn along(&self, part: &CurvePart<'_>, a: f64, b: f64) -> f64 {
        let spacetime = self.world.spacetime();
        let rate = |s: f64| {
            let [x, tangent] = (part.curve)(s);
            // The light moves against the ray.
            spacetime.light_step(Place { x, side: part.side }, -tangent).map_or(f64::NAN, |light| light.time)
        };
        if self.is_precise { integral(rate, a, b) } else { integral_at_once(rate, a, b) }
    }
}

impl Watch for TravelTime<'_> {
    fn wants_points(&self) -> bool {
        false
    }

    fn part(&mut self, part: &CurvePart<'_>) {
        let [a, b] = part.ends;
        self.time += self.along(part, a, b);
    }
}

/// Angle that a ray sweeps around a point of the chart (rad), whatever plane that is in.
pub(crate) struct SweptAngle {
    center: DVec3,
    pub angle: f64,
}

impl SweptAngle {
    /// Around `center` (render space).
    pub fn new(center: DVec3) -> Self {
        Self { center, angle: 0.0 }
    }
}

impl Watch for SweptAngle {
    fn wants_points(&self) -> bool {
        false
    }

    fn part(&mut self, part: &CurvePart<'_>) {
        let rate = |s: f64| {
            let [x, tangent] = (part.curve)(s);
            let from_center = x - self.center;
            from_center.cross(tangent).length() / from_center.length_squared()
        };
        self.angle += integral(rate, part.ends[0], part.ends[1]);
    }
}

/// A point of a ray's way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WayPoint {
    /// Where it is (render space).
    pub place: Place,
    /// The curve's parameter there: see [`bhs_core::ray::RayEnd::swept`].
    pub swept: f64,
    /// Unit chart tangent of the curve there, along the ray; 0 if it has none.
    pub tangent: DVec3,
    /// Time that light takes from there to the start of the ray (scene units); `None` if it is not finite.
    pub time: Option<f64>,
}

/// The points of a ray's way, with the time to each.
pub(crate) struct TimedWay<'w> {
    time: TravelTime<'w>,
    /// Points whose part has not been seen yet.
    ahead: Vec<(f64, DVec3)>,
    points: Vec<WayPoint>,
}

impl<'w> TimedWay<'w> {
    pub fn new(world: &'w World) -> Self {
        Self { time: TravelTime::new(world), ahead: Vec::new(), points: Vec::new() }
    }

    /// The points; of a ray that starts on `side`.
    pub fn points(mut self, side: Side) -> Vec<WayPoint> {
        // Those of no part: where a ray goes nowhere, or leaves for ever at once.
        for (swept, x) in self.ahead {
            let (side, time) = self.points.last().map_or((side, Some(0.0)), |last| (last.place.side, None));
            self.points.push(WayPoint { place: Place { x, side }, swept, tangent: DVec3::ZERO, time });
        }
        self.points
    }
}

impl Watch for TimedWay<'_> {
    fn point(&mut self, parameter: f64, point: DVec3) {
        self.ahead.push((parameter, point));
    }

    fn part(&mut self, part: &CurvePart<'_>) {
        let [mut here, end] = part.ends;
        for (swept, x) in std::mem::take(&mut self.ahead) {
            self.time.time += self.time.along(part, here, swept);
            here = swept;
            let tangent = (part.curve)(swept)[1].normalize_or_zero();
            let time = Some(self.time.time).filter(|time| time.is_finite());
            self.points.push(WayPoint { place: Place { x, side: part.side }, swept, tangent, time });
        }
        self.time.time += self.time.along(part, here, end);
    }
}
