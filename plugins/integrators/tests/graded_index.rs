//! Rays of refractive indices against elliptic integrals and quadratures.

#[path = "common/random.rs"]
mod random;

use bhs_core::lanes::{LANES, Lanes};
use bhs_core::real::{Mask, Vector};
use bhs_core::spacetime::{Ball, Class, GradedIndex, Spacetime};
use bhs_integrators::arithmetic::root::root;
use bhs_integrators::graded_index::medium::{Medium, Refracted};
use bhs_integrators::graded_index::path::Paths;
use bhs_integrators::tracing::arc::Arc;
use bhs_spacetimes::{Dneg, Ellis, Hole, MajumdarPapapetrou};
use glam::DVec3;
use random::Random;
use std::f64::consts::{PI, TAU};

const REACH: Ball = Ball { center: DVec3::ZERO, radius: 12.0 };

fn medium(spacetime: &dyn Spacetime) -> Medium<'_> {
    Medium::new(index_of(spacetime), spacetime.captures())
}

fn index_of(spacetime: &dyn Spacetime) -> &dyn GradedIndex {
    match spacetime.class() {
        Class::Index(index) => index,
        other => panic!("{other:?}"),
    }
}

fn two_holes() -> MajumdarPapapetrou {
    MajumdarPapapetrou::new(&[1.0, -1.0].map(|z| Hole { center: DVec3::Z * z, mass: 0.5 }))
}

/// How a ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
enum End {
    Sky(DVec3),
    Hole,
    Lost,
}

/// Ends of rays, the bits of those that end on the far side, and how many steps each took.
fn ends<F: Refracted>(paths: &mut Paths<F>, each: impl Fn(&Paths<F>, usize)) -> (Vec<End>, u32, Vec<u32>) {
    let mut ends = vec![End::Lost; F::COUNT];
    let mut steps = vec![0; F::COUNT];
    let mut going = F::Mask::ALL;
    for _ in 0..5000 {
        let advance = paths.advance(going);
        let stopped = advance.escaped | advance.captured | advance.lost;
        if advance.escaped.any() {
            let (directions, right) = paths.directions(advance.escaped);
            for i in (0..F::COUNT).filter(|i| advance.escaped.bits() >> i & 1 == 1) {
                ends[i] = if right.bits() >> i & 1 == 1 { End::Sky(directions.lane(i)) } else { End::Lost };
            }
        }
        for i in 0..F::COUNT {
            if advance.captured.bits() >> i & 1 == 1 {
                ends[i] = End::Hole;
            }
            if (going & !stopped).bits() >> i & 1 == 1 {
                steps[i] += 1;
                each(paths, i);
            }
        }
        going = going & !stopped;
        if !going.any() {
            break;
        }
    }
    (ends, paths.far_side, steps)
}

fn end_of(medium: &Medium, x: DVec3, d: DVec3, tolerance: f64) -> (End, bool) {
    let (ends, far, _) = ends(&mut Paths::<f64>::new(medium, x.into(), d.into(), 0, tolerance, REACH), |_, _| {});
    (ends[0], far == 1)
}

/// The angle that the ray through (9, 0, 0) of impact parameter `h` around the origin sweeps altogether, on its way inwards; and whether it ends on
/// the far side.
fn swept(spacetime: &dyn Spacetime, h: f64, tolerance: f64) -> (f64, bool) {
    let medium = medium(spacetime);
    let x = DVec3::X * 9.0;
    let n = index_of(spacetime).index(x).0.sqrt();
    let sin = h / (n * x.x);
    let d = DVec3::new(-(1.0 - sin * sin).sqrt(), sin, 0.0);
    let (End::Sky(came), false) = end_of(&medium, x, -d, tolerance) else { panic!("{h} does not come from the sky") };
    let (End::Sky(goes), far) = end_of(&medium, x, d, tolerance) else { panic!("{h} does not go to the sky") };
    ((goes.y.atan2(goes.x) - came.y.atan2(came.x)).rem_euclid(TAU), far)
}

#[test]
fn light_is_deflected_by_an_extremal_hole_as_by_quadrature() {
    let hole = MajumdarPapapetrou::new(&[Hole { center: DVec3::ZERO, mass: 1.0 }]);
    for (b, right) in [(6.0, 1.197403706675174), (10.0, 0.5332426590717215)] {
        for (tolerance, within) in [(1e-6, 3e-6), (1e-9, 3e-9), (1e-12, 1e-11)] {
            let off = swept(&hole, b, tolerance).0 - PI - right;
            assert!(off.abs() < within, "b = {b}: {off:e} at {tolerance:e}");
        }
    }
    assert_eq!(end_of(&medium(&hole), DVec3::X * 4.0, DVec3::new(-0.9, 0.2, 0.0), 1e-9).0, End::Hole);
}

#[test]
fn wormholes_turn_light_as_by_elliptic_integrals() {
    let ellis = Ellis { center: DVec3::ZERO, throat: 1.0 };
    let dneg = Dneg::new(DVec3::ZERO, 1.0, 1.0, 0.1).unwrap();
    let cases: [(&dyn Spacetime, f64, f64, bool); 5] = [
        (&ellis, 0.5, 1.685750354812596, true),
        (&ellis, 0.9, 4.104988449160986, true),
        (&ellis, 2.0, PI + 0.2299080560353988, false),
        (&ellis, 1.1, PI + 1.50225541996245, false),
        (&dneg, 0.5, 1.8391092507240994, true),
    ];
    for (spacetime, h, right, through) in cases {
        for (tolerance, within) in [(1e-6, 1e-5), (1e-9, 1e-8), (1e-12, 3e-11)] {
            let (angle, far) = swept(spacetime, h, tolerance);
            assert!((angle - right).abs() < within && far == through, "h = {h}: {:e} at {tolerance:e}", angle - right);
        }
    }
    // Straight through: out on the other side, where it points the same way.
    let (end, far) = end_of(&medium(&ellis), DVec3::X * 4.0, -DVec3::X, 1e-9);
    assert!(end == End::Sky(DVec3::X) && far, "{end:?}");
}

#[test]
fn light_passes_between_two_holes_as_it_should() {
    let holes = two_holes();
    let medium = medium(&holes);
    let x = Vector { x: 10.0, y: 0.0, z: 0.5 };
    let mut paths = Paths::<f64>::new(&medium, x, Vector { x: -1.0, y: 0.6, z: 0.3 }, 0, 1e-12, REACH);
    let met = loop {
        let arc = paths.advance(true).arc;
        if arc.point(arc.end()).x < -6.0 {
            break arc.point(root(|s| arc.point(s).x + 6.0, arc.start(), arc.end(), false));
        }
    };
    assert!(f64::hypot(met.y - 4.203864795141, met.z - 2.345072621592) < 1e-11, "{met:?}");
    let mut paths = Paths::<f64>::new(&medium, x, Vector { x: -1.0, y: 0.0, z: 0.02 }, 0, 1e-9, REACH);
    assert_eq!(ends(&mut paths, |_, _| {}).0, [End::Hole]);
    assert!(paths.state.x.z > 0.5, "the upper one");
}

#[test]
fn far_away_the_deflection_is_that_of_the_masses() {
    // 4 M / b, and for extremal holes (3 pi / 4) of (2 M / b)^2 - that of charge: RN with q = M has 15 pi/16 - 3 pi/16.
    let holes = two_holes();
    let medium = medium(&holes);
    for b in [1e3, 1e4] {
        let (End::Sky(out), false) = end_of(&medium, DVec3::new(b, 0.0, 0.0), DVec3::Y, 1e-12) else { panic!() };
        let half = -out.x.atan2(out.y);
        let m = 2.0 / b;
        // The holes' distance, half of which is 1, changes it in the third order.
        let expected = m + 0.75 * PI / 2.0 * m * m;
        // b is the chart's nearest distance, less than the impact parameter by 2 M.
        let expected = expected - m * (2.0 / b);
        assert!((half - expected).abs() < 30.0 / (b * b * b), "{b}: {half} {expected} {:e}", half - expected);
    }
}

#[test]
fn first_integrals_are_kept() {
    let holes = two_holes();
    let medium = medium(&holes);
    let mut random = Random(7);
    for _ in 0..300 {
        let (x, d) = random.ray(6.0, &holes);
        let mut paths = Paths::<f64>::new(&medium, x.into(), d.into(), 0, 1e-10, REACH);
        let (start, scale) = (DVec3::from(paths.state.x).cross(paths.state.v.into()).z, x.length());
        ends(&mut paths, |paths, _| {
            let (x, v) = (DVec3::from(paths.state.x), DVec3::from(paths.state.v));
            let n = medium.at(paths.state.x).0.sqrt();
            assert!((v.length() / n - 1.0).abs() < 3e-9, "{x} {:e}", v.length() / n - 1.0);
            assert!((x.cross(v).z - start).abs() < 3e-9 * scale * n, "{x} {:e}", x.cross(v).z - start);
        });
    }
}

#[test]
fn eight_rays_are_as_one_to_the_bit() {
    let (holes, ellis, dneg) =
        (two_holes(), Ellis { center: DVec3::X * 0.3, throat: 1.0 }, Dneg::new(DVec3::ZERO, 1.0, 1.0, 0.1).unwrap());
    let mut random = Random(1);
    for spacetime in [&holes as &dyn Spacetime, &ellis, &dneg] {
        let medium = medium(spacetime);
        for _ in 0..30 {
            let rays: [_; LANES] = std::array::from_fn(|_| random.ray(6.0, spacetime));
            let (x, d) = (Vector::of(rays.map(|r| r.0)), Vector::of(rays.map(|r| r.1)));
            let (together, far, steps) =
                ends(&mut Paths::<Lanes>::new(&medium, x, d, 0b1010_0000, Lanes::splat(1e-8), REACH), |_, _| {});
            for (i, (x, d)) in rays.into_iter().enumerate() {
                let side = u32::from(i == 5 || i == 7);
                let mut alone = Paths::<f64>::new(&medium, x.into(), d.into(), side, 1e-8, REACH);
                let (end, one_far, one_steps) = ends(&mut alone, |_, _| {});
                assert_eq!((end[0], one_far, one_steps[0]), (together[i], far >> i & 1, steps[i]), "{x} {d}");
            }
        }
    }
}

#[test]
fn random_rays_come_to_an_end() {
    let count = std::env::var("BHS_GEODESICS").map_or(2_000, |n| n.parse().expect("BHS_GEODESICS is a number"));
    let three = [(0.0, 0.5, 0.2, 0.5), (1.2, -0.3, 0.0, 0.8), (-0.7, 0.1, -1.0, 0.3)];
    let three = MajumdarPapapetrou::new(&three.map(|(x, y, z, mass)| Hole { center: DVec3::new(x, y, z), mass }));
    let (holes, ellis, dneg) =
        (two_holes(), Ellis { center: DVec3::ZERO, throat: 1.0 }, Dneg::new(DVec3::ZERO, 1.0, 2.0, 0.3).unwrap());
    let mut random = Random(3);
    for (name, spacetime) in
        [("two holes", &holes as &dyn Spacetime), ("three holes", &three), ("ellis", &ellis), ("dneg", &dneg)]
    {
        let medium = medium(spacetime);
        let mut lost = 0;
        let mut most = 0;
        for _ in 0..count / LANES {
            let rays: [_; LANES] = std::array::from_fn(|_| random.ray(8.0, spacetime));
            let (x, d) = (Vector::of(rays.map(|r| r.0)), Vector::of(rays.map(|r| r.1)));
            let (ends, _, steps) = ends(&mut Paths::<Lanes>::new(&medium, x, d, 0, Lanes::splat(1e-7), REACH), |_, _| {});
            for end in ends {
                match end {
                    End::Sky(d) => assert!((d.length() - 1.0).abs() < 1e-12, "{name}: {d}"),
                    End::Hole => {}
                    End::Lost => lost += 1,
                }
            }
            most = most.max(*steps.iter().max().unwrap());
        }
        assert!(lost == 0 && most < 300, "{name}: {lost} lost, {most} steps");
    }
}

#[test]
fn tolerances_are_kept() {
    let (holes, ellis) = (two_holes(), Ellis { center: DVec3::ZERO, throat: 1.0 });
    let mut random = Random(11);
    for spacetime in [&holes as &dyn Spacetime, &ellis] {
        let medium = medium(spacetime);
        for tolerance in [1e-5, 1e-7, 1e-9] {
            let mut errors = Vec::new();
            while errors.len() < 400 {
                let (x, d) = random.ray(8.0, spacetime);
                let of = |d, tolerance| end_of(&medium, x, d, tolerance);
                let aside = (d + 1e-9 * d.any_orthonormal_vector()).normalize();
                let exact = 1e-3 * tolerance;
                if let ((End::Sky(a), far), (End::Sky(b), right), (End::Sky(c), other)) =
                    (of(d, tolerance), of(d, exact), of(aside, exact))
                    && right == other
                {
                    // What an error where the ray begins would grow to.
                    let growth = 1.0 + (c - b).length() / 1e-9;
                    errors.push(if far == right { (a - b).length() / growth } else { 2.0 });
                }
            }
            errors.sort_by(f64::total_cmp);
            let [median, most] = [0.5, 0.95].map(|share| errors[(share * errors.len() as f64) as usize] / tolerance);
            assert!(median < 0.3 && most < 5.0, "{tolerance:e}: {median} {most}");
        }
    }
}

#[test]
fn runge_kutta_is_of_order_four() {
    let (holes, ellis) = (two_holes(), Ellis { center: DVec3::ZERO, throat: 1.0 });
    for spacetime in [&holes as &dyn Spacetime, &ellis] {
        let medium = medium(spacetime);
        for d in [DVec3::new(-1.0, 0.6, 0.3), DVec3::new(-0.2, 0.9, -0.3)] {
            let x = DVec3::new(5.0, 0.0, 0.5);
            let exact = end_of(&medium, x, d, 1e-12);
            let off = |share: f64| {
                let mut paths = Paths::<f64>::new(&medium, x.into(), d.into(), 0, 1e-9, REACH).by_runge_kutta(share);
                let (ends, far, _) = ends(&mut paths, |_, _| {});
                let (End::Sky(a), End::Sky(b)) = (ends[0], exact.0) else { panic!("{ends:?} {exact:?}") };
                assert_eq!(far == 1, exact.1);
                (a - b).length()
            };
            let order = (off(0.05) / off(0.025)).log2();
            assert!((order - 4.0).abs() < 0.7 && off(0.05) < 1e-4, "{d}: {order}, {:e}", off(0.05));
        }
    }
}
