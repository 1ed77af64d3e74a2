//! What whole rays do, against quadratures and elliptic integrals (`docs/physics.md`).

use crate::common::mesh;
use crate::rooms::trace;
use crate::{STEPS, adaptive, rk4};
use bhs_core::geometry::Geometry;
use bhs_core::intersector::IntersectorBuilder;
use bhs_core::observer::Conventions;
use bhs_core::ray::{Arrival, Ray};
use bhs_core::spacetime::{Class, Side, Spacetime, Spherical};
use bhs_engine::integrator::Integrator;
use bhs_engine::world::World;
use bhs_integrators::General;
use bhs_integrators::Tolerance;
use bhs_intersectors::reference::Reference;
use bhs_spacetimes::{Dneg, Ellis, Hole, MajumdarPapapetrou};
use glam::DVec3;
use std::f64::consts::{PI, TAU};
use std::sync::Arc;

fn world(geometries: Vec<Geometry>, spacetime: &Arc<dyn Spacetime>) -> World {
    let intersector = Reference.build(&geometries).expect("the meshes are sound");
    World::new(geometries, intersector, DVec3::ZERO).in_spacetime(spacetime.clone(), Conventions::NATURE)
}

/// What is tested, and to what its errors are held.
fn methods(spacetime: &Arc<dyn Spacetime>) -> Vec<(Box<dyn Integrator>, f64)> {
    vec![
        (adaptive(2e-11, spacetime), 1e-9),
        (rk4(0.01, spacetime), 1e-6),
        (Box::new(General::new(Tolerance::Absolute(1e-11), STEPS)), 1e-9),
    ]
}

/// The angle that a ray through (9, 0, 0) in the direction `d` sweeps altogether, and the side of the sky that it goes to.
fn swept(integrator: &dyn Integrator, world: &World, d: DVec3) -> (f64, Side) {
    let x = DVec3::X * 9.0;
    let (Arrival::Sky(came, Side::Near), _) = trace(integrator, world, &Ray::new(x, -d)) else {
        panic!("{d} does not come from the sky")
    };
    let (Arrival::Sky(goes, side), _) = trace(integrator, world, &Ray::new(x, d)) else { panic!("{d} does not go to the sky") };
    ((goes.y.atan2(goes.x) - came.y.atan2(came.x)).rem_euclid(TAU), side)
}

#[test]
fn charged_holes_deflect_light_as_by_quadrature() {
    let cases = [
        (6.0, 0.5, 1.551187254247158),
        (10.0, 0.5, 0.5756100502520441),
        (6.0, 0.9, 1.272240846265183),
        (10.0, 0.9, 0.5437063921910459),
        (6.0, 1.0, 1.197403706675174),
        (10.0, 1.0, 0.5332426590717215),
    ];
    for (b, q, right) in cases {
        let hole = Spherical { center: DVec3::ZERO, rs: 2.0, charge_squared: q * q };
        let spacetime: Arc<dyn Spacetime> = Arc::new(hole);
        let world = world(Vec::new(), &spacetime);
        // u'^2 = 1/b^2 - u^2 N^2, and u' = -u / tan(alpha)
        let u: f64 = 1.0 / 9.0;
        let cot = (1.0 / (b * b * u * u) - hole.lapse_squared(9.0)).sqrt();
        if cot.is_nan() {
            continue;
        }
        let sin = 1.0 / (1.0 + cot * cot).sqrt();
        let d = DVec3::new(-cot * sin, sin, 0.0);
        for (k, (method, within)) in methods(&spacetime).into_iter().enumerate() {
            let off = swept(&*method, &world, d).0 - PI - right;
            assert!(off.abs() < within, "b = {b}, q = {q}: {off:e} by method {k}");
        }
    }
}

#[test]
fn wormholes_turn_light_as_by_elliptic_integrals() {
    let ellis: Arc<dyn Spacetime> = Arc::new(Ellis { center: DVec3::ZERO, throat: 1.0 });
    let dneg: Arc<dyn Spacetime> = Arc::new(Dneg::new(DVec3::ZERO, 1.0, 1.0, 0.1).expect("it has a profile"));
    let cases = [
        (&ellis, 0.5, 1.685750354812596, Side::Far),
        (&ellis, 0.9, 4.104988449160986, Side::Far),
        (&ellis, 2.0, PI + 0.2299080560353988, Side::Near),
        (&ellis, 1.1, PI + 1.50225541996245, Side::Near),
        (&dneg, 0.5, 1.8391092507240994, Side::Far),
    ];
    for (spacetime, h, right, to) in cases {
        let world = world(Vec::new(), spacetime);
        let Class::Index(index) = spacetime.class() else { panic!("{spacetime:?}") };
        let sin = h / (index.index(DVec3::X * 9.0).0.sqrt() * 9.0);
        let d = DVec3::new(-(1.0 - sin * sin).sqrt(), sin, 0.0);
        for (k, (method, within)) in methods(spacetime).into_iter().enumerate() {
            let (angle, side) = swept(&*method, &world, d);
            assert!((angle - right).abs() < within && side == to, "h = {h}: {:e} by method {k}", angle - right);
        }
    }
}

#[test]
fn two_holes_send_light_where_quadratures_do() {
    let holes = [1.0, -1.0].map(|z| Hole { center: DVec3::Z * z, mass: 0.5 });
    let spacetime: Arc<dyn Spacetime> = Arc::new(MajumdarPapapetrou::new(&holes));
    let far = 20.0;
    let wall = mesh(&[[DVec3::new(-6.0, -far, -far), DVec3::new(-6.0, 3.0 * far, -far), DVec3::new(-6.0, -far, 3.0 * far)]]);
    let world = world(vec![wall], &spacetime);
    let x = DVec3::new(10.0, 0.0, 0.5);
    let methods = [
        (adaptive(1e-10, &spacetime), 1e-9),
        (rk4(0.01, &spacetime), 1e-6),
        (Box::new(General::new(Tolerance::Absolute(1e-10), STEPS)) as Box<dyn Integrator>, 1e-9),
    ];
    for (k, (method, within)) in methods.into_iter().enumerate() {
        let (found, sigma) = trace(&*method, &world, &Ray::new(x, DVec3::new(-1.0, 0.6, 0.3).normalize()));
        let Arrival::Surface(hit) = found else { panic!("{found:?}") };
        let off = hit.point - DVec3::new(-6.0, 4.203864795141, 2.345072621592);
        assert!(off.length() < within && sigma > 5.0, "{off:?} by method {k}");
        let (found, _) = trace(&*method, &world, &Ray::new(x, DVec3::new(-1.0, 0.0, 0.02).normalize()));
        assert_eq!(found, Arrival::Captured, "method {k}");
    }
}
