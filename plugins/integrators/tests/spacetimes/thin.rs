//! Things that are thinner than chords may stray, and things that stand where light does not come back from.

use crate::common::{Dice, ball, mesh, on_all_processors, room};
use crate::rooms::{CENTER, spacetimes, trace};
use crate::{adaptive, general, rk4};
use bhs_core::geometry::Geometry;
use bhs_core::intersector::IntersectorBuilder;
use bhs_core::observer::Conventions;
use bhs_core::ray::{Arrival, Ray};
use bhs_core::spacetime::Spacetime;
use bhs_engine::integrator::Integrator;
use bhs_engine::world::World;
use bhs_intersectors::reference::Reference;
use bhs_spacetimes::{Hole, MajumdarPapapetrou};
use glam::DVec3;
use std::sync::Arc;

fn world(geometries: Vec<Geometry>, spacetime: &Arc<dyn Spacetime>) -> World {
    let intersector = Reference.build(&geometries).expect("the meshes are sound");
    World::new(geometries, intersector, DVec3::ZERO).in_spacetime(spacetime.clone(), Conventions::NATURE)
}

/// A ray past what bends light.
fn ray(y: f64, z: f64) -> Ray {
    let origin = CENTER + DVec3::new(-1.2, 0.0, 0.0);
    Ray::new(origin, (CENTER + DVec3::new(0.0, y, z) - origin).normalize())
}

/// How many of so many rays of a fan meet the ribbon behind that.
fn met(world: &World, integrator: &dyn Integrator, rays: u64) -> u64 {
    let mut dice = Dice(rays);
    (0..rays)
        .filter(|_| {
            let ray = ray(dice.within(0.85, 0.95), dice.within(-0.3, 0.3));
            matches!(trace(integrator, world, &ray).0, Arrival::Surface(hit) if hit.geometry == 0)
        })
        .count() as u64
}

#[test]
fn thin_things_keep_their_light() {
    for (name, spacetime) in spacetimes() {
        // In the middle of the fan.
        let wall = [DVec3::new(0.0, -9.0, -9.0), DVec3::new(0.0, 27.0, -9.0), DVec3::new(0.0, -9.0, 27.0)];
        let wall = world(vec![mesh(&[wall.map(|p| CENTER + DVec3::X * 0.9 + p)])], &spacetime);
        let Arrival::Surface(middle) = trace(&*adaptive(1e-5, &spacetime), &wall, &ray(0.9, 0.0)).0 else { panic!("{name}") };
        let (at, long, wide) = (middle.point, DVec3::Z * 2.0, DVec3::Y * 5e-3);
        let ribbon = mesh(&[[at - long, at + long, at + long + wide], [at - long, at + long + wide, at - long + wide]]);
        let world = world(vec![ribbon, room(DVec3::splat(-3.0), DVec3::splat(3.0))], &spacetime);
        let [fine, coarse, coarsest, fixed] =
            [adaptive(1e-5, &spacetime), adaptive(3e-3, &spacetime), adaptive(2e-2, &spacetime), rk4(0.1, &spacetime)].map(
                |integrator| {
                    let chunks = 8;
                    on_all_processors(chunks, |k| met(&world, &*integrator, 5000 + k))
                },
            );
        assert!(fine > 100, "{name}: {fine}");
        for found in [coarse, coarsest, fixed] {
            let spread = ((found + fine) as f64).sqrt();
            assert!((found as f64 - fine as f64).abs() < 3.0 * spread, "{name}: {fine}, but {found}");
        }
    }
}

#[test]
fn what_stands_deep_down_is_seen() {
    let spacetime: Arc<dyn Spacetime> = Arc::new(MajumdarPapapetrou::new(&[Hole { center: CENTER, mass: 0.3 }]));
    // Light that comes as near as 0.3 never comes back.
    let (inner, outer) = (ball(CENTER, 0.05), room(DVec3::splat(-3.0), DVec3::splat(3.0)));
    let small = ball(CENTER + DVec3::new(0.0, 0.1, 0.0), 0.03);
    let shells = world(vec![inner, outer.clone()], &spacetime);
    let beside = world(vec![small, outer], &spacetime);
    let mut dice = Dice(2);
    let mut seen = [0; 3];
    for _ in 0..200 {
        let origin = CENTER + dice.direction() * dice.within(0.5, 2.0);
        let ray = Ray::new(origin, (CENTER - origin + 0.8 * dice.point(1.0)).normalize());
        let [a, b] = [adaptive(1e-5, &spacetime), general(1e-5)(&spacetime)].map(|i| trace(&*i, &shells, &ray).0);
        let (Arrival::Surface(a), Arrival::Surface(b)) = (a, b) else { panic!("{a:?} {b:?}") };
        assert_eq!(a.geometry, b.geometry);
        seen[0] += u32::from(a.geometry == 0);
        let [a, b] = [adaptive(1e-5, &spacetime), general(1e-5)(&spacetime)].map(|i| trace(&*i, &beside, &ray).0);
        assert!(std::mem::discriminant(&a) == std::mem::discriminant(&b), "{a:?} {b:?}");
        seen[1] += u32::from(a == Arrival::Captured);
        seen[2] += u32::from(matches!(a, Arrival::Surface(hit) if hit.geometry == 0));
    }
    assert!(seen.iter().all(|n| *n > 3), "{seen:?}");
}
