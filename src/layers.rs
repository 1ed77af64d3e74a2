//! The values of a picture's layers: of what the light transport has seen of each camera ray ([`PathSample::first`]); no ray is followed for
//! them.
//!
//! Where nothing bends light (no hole, or an
//! integrator of straight rays) the lengths and angles of the orbit are 0, and `g` is 1.

mod albedo;
mod picture;

pub use picture::LayerPicture;

use albedo::AlbedoColor;
use bhs_core::camera::Film;
use bhs_core::geometry::SurfaceGeometry;
use bhs_core::layer::Layer;
use bhs_core::observer::Observer;
use bhs_core::ray::{Arrival, Ray, RayEnd, SurfaceHit};
use bhs_core::spacetime::{Class, Spherical};
use bhs_engine::scene::Scene;
use bhs_engine::transport::PathSample;
use glam::DVec3;
use std::f64::consts::TAU;

/// A layer's value for one ray; a layer of one channel uses the first number.
pub type Value = [f64; 3];

/// Computes the layers that a film asks for.
pub struct LayerCollector<'a> {
    scene: &'a Scene,
    layers: &'a [Layer],
    albedo: Option<AlbedoColor>,
    bending: Bending,
    /// What of a surface any of the layers asks for.
    needs_surface: bool,
    needs_observer: bool,
}

/// What bends light.
#[derive(Clone, Copy)]
enum Bending {
    Nothing,
    /// A hole around which all orbits are plane.
    Hole(Spherical),
    /// Another spacetime.
    Otherwise,
}

impl Bending {
    fn of(scene: &Scene) -> Self {
        match scene.world.spacetime().class() {
            Class::Flat => Self::Nothing,
            Class::Spherical(hole) => Self::Hole(hole),
            _ => Self::Otherwise,
        }
    }
}

impl<'a> LayerCollector<'a> {
    /// A collector of the film's layers; `None` if it asks for none.
    pub fn new(scene: &'a Scene, film: &'a dyn Film) -> Option<Self> {
        let layers = film.layers();
        let wants = |some: &[Layer]| layers.iter().any(|layer| some.contains(layer));
        layers.iter().any(|l| *l != Layer::Variance).then(|| Self {
            scene,
            layers,
            albedo: wants(&[Layer::Albedo]).then(|| AlbedoColor::new(scene, film)),
            bending: Bending::of(scene),
            needs_surface: wants(&[Layer::Albedo, Layer::Normal, Layer::ShadingNormal]),
            needs_observer: wants(&[Layer::Albedo, Layer::Redshift]),
        })
    }

    /// The values of all layers, in the film's order, for the camera ray of a path that has been followed; `None` for what this ray has no
    /// value of. `camera_ratio`: wavelength where the ray starts over that at E = 1, as the camera measures it.
    pub fn values(&self, path: &PathSample, camera_ratio: f64) -> impl Iterator<Item = Option<Value>> {
        let world = &self.scene.world;
        let hit = match path.first.arrival {
            Arrival::Surface(hit) => Some(hit),
            _ => None,
        };
        let seen = VisibleSurface {
            scene: self.scene,
            bending: self.bending,
            ray: path.ray,
            camera_ratio,
            end: path.first,
            hit,
            surface: hit.filter(|_| self.needs_surface).map(|hit| world.surface(&hit)),
            observer: hit.filter(|_| self.needs_observer).and_then(|hit| self.scene.observer(world.place_of(&hit))),
        };
        self.layers.iter().map(move |layer| seen.value(*layer, self.albedo.as_ref()))
    }
}

/// What a camera ray sees.
struct VisibleSurface<'s> {
    scene: &'s Scene,
    bending: Bending,
    ray: Ray,
    camera_ratio: f64,
    end: RayEnd,
    hit: Option<SurfaceHit>,
    /// There, if any layer asks for it.
    surface: Option<SurfaceGeometry>,
    /// Likewise.
    observer: Option<Observer>,
}

impl VisibleSurface<'_> {
    #[inline]
    fn value(&self, layer: Layer, albedo: Option<&AlbedoColor>) -> Option<Value> {
        match layer {
            Layer::ImpactParameter => match self.bending {
                Bending::Nothing => Some(scalar(0.0)),
                Bending::Hole(hole) => Some(scalar(self.impact_parameter(&hole))),
                Bending::Otherwise => None,
            },
            Layer::SweptAngle => self.swept_angle().map(scalar),
            Layer::Winding => self.swept_angle().map(|phi| scalar(phi / TAU)),
            Layer::ClosestApproach => self.closest_approach().map(scalar),
            Layer::Redshift => self.redshift().map(scalar),
            Layer::Queries => Some(scalar(f64::from(self.end.cost.queries))),
            Layer::Outcome => match self.end.arrival {
                Arrival::Surface(_) => Some([1.0, 0.0, 0.0]),
                Arrival::Sky(..) => Some([0.0, 1.0, 0.0]),
                Arrival::Captured => Some([0.0, 0.0, 1.0]),
                Arrival::OutOfSteps => None,
            },
            Layer::Albedo => {
                let (hit, surface, observer) = (self.hit.as_ref()?, self.surface.as_ref()?, self.observer.as_ref()?);
                let shift = observer.ratio(hit.direction) / self.camera_ratio;
                Some(albedo?.of(self.scene, (hit, surface, observer), shift))
            }
            Layer::Position => self.hit.map(|h| (h.point + self.scene.world.origin).to_array()),
            Layer::Normal => self.surface.map(|s| s.normal.to_array()),
            Layer::ShadingNormal => self.surface.map(|s| s.shading_normal.to_array()),
            // No straight line of a chart leads to the other side.
            Layer::Depth => self
                .hit
                .filter(|h| self.scene.world.side_of(h.geometry) == self.ray.side)
                .map(|h| scalar((h.point - self.ray.origin).length())),
            Layer::Side => match self.end.arrival {
                Arrival::Surface(hit) => Some(scalar(f64::from(self.scene.world.side_of(hit.geometry) as u8))),
                Arrival::Sky(_, side) => Some(scalar(f64::from(side as u8))),
                Arrival::Captured | Arrival::OutOfSteps => None,
            },
            // What samples find is no matter of the ray.
            Layer::Variance => None,
        }
    }

    /// Angle swept around the hole (rad).
    fn swept_angle(&self) -> Option<f64> {
        match (self.bending, self.end.arrival) {
            (Bending::Nothing, _) => Some(0.0),
            (Bending::Otherwise, _) | (_, Arrival::OutOfSteps) => None,
            (Bending::Hole(_), _) => Some(self.end.swept),
        }
    }

    /// `b = r sin(alpha) / sqrt(1 - (1 - f(r)) sin^2(alpha))` with the chart angle alpha to the radial direction (scene units) and the square f
    /// of the lapse: the orbit's first integral `u'^2 = 1/b^2 - u^2 f` with `u' = -cot(alpha)/r`.
    fn impact_parameter(&self, hole: &Spherical) -> f64 {
        let from_center = self.ray.origin - hole.center;
        let r = from_center.length();
        let sin = from_center.cross(self.ray.direction).length() / r;
        r * sin / (1.0 - (1.0 - hole.lapse_squared(r)) * sin * sin).sqrt()
    }

    /// Smallest distance from the hole's centre on the way (scene units): the periapsis if the ray has passed it, else the
    /// nearer end; the horizon for a ray that falls in.
    fn closest_approach(&self) -> Option<f64> {
        let hole = match self.bending {
            Bending::Nothing => return Some(0.0),
            Bending::Hole(hole) => hole,
            Bending::Otherwise => return None,
        };
        let outward = |point: DVec3, direction: DVec3| (point - hole.center).dot(direction) > 0.0;
        let start = (self.ray.origin - hole.center).length();
        let (end, leaves) = match self.end.arrival {
            Arrival::Surface(h) => ((h.point - hole.center).length(), outward(h.point, h.direction)),
            Arrival::Sky(..) => (f64::INFINITY, true),
            Arrival::Captured => return Some(hole.horizon()),
            Arrival::OutOfSteps => return None,
        };
        if leaves && !outward(self.ray.origin, self.ray.direction) {
            return Some(periapsis(&hole, self.impact_parameter(&hole)));
        }
        Some(start.min(end))
    }

    /// `g = nu_observed / nu_emitted`: the clock rate where the light comes from over that at the camera.
    fn redshift(&self) -> Option<f64> {
        let emitted = match self.end.arrival {
            Arrival::Surface(hit) => self.observer?.ratio(hit.direction),
            Arrival::Sky(..) => 1.0,
            Arrival::Captured | Arrival::OutOfSteps => return None,
        };
        Some(emitted / self.camera_ratio)
    }
}

/// Corrections of a periapsis at most.
const CORRECTIONS: u32 = 100;

/// The smallest distance from the centre of light around `hole` with the impact parameter `b` that comes from far away and turns: the largest root of
/// `r^2 = b^2 f(r)`, or, where there is none for rounding near the critical one, where light goes round.
fn periapsis(hole: &Spherical, b: f64) -> f64 {
    let Spherical { rs, charge_squared, .. } = *hole;
    if charge_squared == 0.0 {
        // That of r^3 - b^2 r + b^2 rs (Viete).
        let critical = 1.5 * 3f64.sqrt() * rs;
        return 2.0 * b / 3f64.sqrt() * ((-critical / b).max(-1.0).acos() / 3.0).cos();
    }
    // Newton's method from outside comes down to it.
    let mut r = b;
    for _ in 0..CORRECTIONS {
        let value = r * r * r * r - b * b * (r * (r - rs) + charge_squared);
        let change = value / (4.0 * r * r * r - b * b * (2.0 * r - rs));
        if change.is_nan() || change <= 1e-15 * r {
            break;
        }
        r -= change;
    }
    r.max(0.75 * rs + (0.5625 * rs * rs - 2.0 * charge_squared).max(0.0).sqrt())
}

fn scalar(x: f64) -> Value {
    [x, 0.0, 0.0]
}
