//! Random worlds in spacetimes other than the plain hole, on both sides of wormholes.

use crate::common::{Dice, ball, mesh, room};
use bhs_core::geometry::Geometry;
use bhs_core::intersector::IntersectorBuilder;
use bhs_core::observer::Conventions;
use bhs_core::ray::{Arrival, Ray};
use bhs_core::spacetime::{Place, Side, Spacetime, Spherical};
use bhs_engine::integrator::Integrator;
use bhs_engine::world::World;
use bhs_intersectors::reference::Reference;
use bhs_spacetimes::{Dneg, Ellis, Hole, Kerr, MajumdarPapapetrou};
use glam::DVec3;
use std::sync::Arc;

/// Half the side of the closed rooms.
pub const ROOM: f64 = 1.5;

/// Nothing stands nearer than this to what bends light.
const CLEAR: f64 = 0.3;

/// Light bends around here.
pub const CENTER: DVec3 = DVec3::new(0.1, -0.05, 0.2);

/// The spacetimes that the worlds are in, by name.
pub fn spacetimes() -> Vec<(&'static str, Arc<dyn Spacetime>)> {
    let hole = |x: f64, mass: f64| Hole { center: CENTER + DVec3::new(x, 0.3 * x, 0.0), mass };
    let kerr = |rs: f64, spin: f64, charge_squared: f64| -> Arc<dyn Spacetime> {
        let axis = DVec3::new(0.36, 0.8, -0.48);
        Arc::new(Kerr::new(Spherical { center: CENTER, rs, charge_squared }, axis, spin))
    };
    vec![
        ("two extremal holes", Arc::new(MajumdarPapapetrou::new(&[hole(0.25, 0.07), hole(-0.2, 0.04)]))),
        ("Ellis", Arc::new(Ellis { center: CENTER, throat: 0.4 })),
        ("DNEG", Arc::new(Dneg::new(CENTER, 0.4, 0.2, 0.05).expect("it has a profile"))),
        ("Reissner-Nordstroem", Arc::new(Spherical { center: CENTER, rs: 0.24, charge_squared: 0.01 })),
        ("Kerr", kerr(0.22, 0.9, 0.0)),
        ("nearly extremal Kerr", kerr(0.26, -0.998, 0.0)),
        ("Kerr-Newman", kerr(0.24, 0.6, 0.006)),
    ]
}

/// Whether the triangle keeps clear of what bends light.
fn is_clear(t: &[DVec3; 3]) -> bool {
    let n = 24;
    (0..=n).flat_map(|i| (0..=n - i).map(move |j| (f64::from(i) / f64::from(n), f64::from(j) / f64::from(n)))).all(|(v, w)| {
        let p = t[0] + (t[1] - t[0]) * v + (t[2] - t[0]) * w;
        (p - CENTER).length() > CLEAR
    })
}

fn surfaces(dice: &mut Dice) -> Vec<Geometry> {
    let mut triangles = Vec::new();
    while triangles.len() < 8 {
        let (middle, size) = (dice.point(1.0), 0.1 + 0.7 * dice.unit());
        let triangle: [DVec3; 3] =
            std::array::from_fn(|_| (middle + dice.point(size)).clamp(DVec3::splat(-1.4), DVec3::splat(1.4)));
        if is_clear(&triangle) {
            triangles.push(triangle);
        }
    }
    let mut all = vec![mesh(&triangles), room(DVec3::splat(-ROOM), DVec3::splat(ROOM))];
    for _ in 0..3 {
        let (middle, radius) = (dice.point(1.1), dice.within(0.05, 0.3));
        if (middle - CENTER).length() > CLEAR + radius {
            all.push(ball(middle, radius));
        }
    }
    all
}

/// A world of closed rooms, one on each side of `spacetime`.
pub fn world(dice: &mut Dice, spacetime: &Arc<dyn Spacetime>) -> World {
    let build = |geometries: &[Geometry]| Reference.build(geometries).expect("the meshes are sound");
    let near = surfaces(dice);
    let intersector = build(&near);
    let world = World::new(near, intersector, DVec3::ZERO).in_spacetime(spacetime.clone(), Conventions::NATURE);
    let mut world = if spacetime.has_far_side() {
        let far = surfaces(dice);
        let intersector = build(&far);
        world.with_far_side(far, intersector)
    } else {
        world
    };
    // Every other one has to do without knowing where free space is.
    if dice.unit() < 0.5 {
        world.clearance = None;
    }
    world
}

/// A ray from anywhere in `world`.
pub fn ray(dice: &mut Dice, world: &World) -> Ray {
    let spacetime = world.spacetime();
    let side = if spacetime.has_far_side() && dice.unit() < 0.5 { Side::Far } else { Side::Near };
    loop {
        let x = dice.point(0.99 * ROOM);
        if spacetime.at(Place { x, side }).is_some() && (x - CENTER).length() > CLEAR {
            let towards = (CENTER - x).normalize();
            let direction = if dice.unit() < 0.5 { dice.direction() } else { (towards + 0.6 * dice.point(1.0)).normalize() };
            return Ray { side, ..Ray::new(x, direction) };
        }
    }
}

/// Where a ray ends and its parameter there.
pub fn trace(integrator: &dyn Integrator, world: &World, ray: &Ray) -> (Arrival, f64) {
    let end = integrator.trace(world, ray);
    assert!(end.swept.is_finite());
    (end.arrival, end.swept)
}

/// What two ways of following a ray must agree about.
pub fn outcome(arrival: &Arrival) -> (u8, u32, u32) {
    match arrival {
        Arrival::Surface(hit) => (0, hit.geometry, hit.primitive),
        Arrival::Sky(_, Side::Near) => (1, 0, 0),
        Arrival::Sky(_, Side::Far) => (2, 0, 0),
        Arrival::Captured => (3, 0, 0),
        Arrival::OutOfSteps => (4, 0, 0),
    }
}
