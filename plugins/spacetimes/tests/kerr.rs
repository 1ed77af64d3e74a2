//! The spinning hole against its textbook form, and against rays computed elsewhere.

mod common;

use bhs_core::dual::Dual;
use bhs_core::spacetime::{Inverse, Metric, Place, Side, Spacetime, Spherical, Stationary};
use bhs_spacetimes::Kerr;
use common::{Random, build};
use glam::{DMat3, DVec3};

const AXES: [DVec3; 3] = [DVec3::X, DVec3::Y, DVec3::Z];

/// A hole of mass 1 that spins about +z.
fn hole(spin: f64, charge: f64) -> Kerr {
    Kerr::new(Spherical { center: DVec3::ZERO, rs: 2.0, charge_squared: charge * charge }, DVec3::Z, spin)
}

fn matrix([xx, yy, zz, yz, xz, xy]: [Dual; 6]) -> DMat3 {
    DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz].map(|g| g.value))
}

/// The chart's point of Boyer and Lindquist's r, theta, phi, and the derivatives by them.
fn chart(a: f64, r: f64, theta: f64, phi: f64) -> (DVec3, DMat3) {
    let root = r.hypot(a);
    let ((st, ct), (sp, cp)) = (theta.sin_cos(), phi.sin_cos());
    let by_r = DVec3::new(r / root * st * cp, r / root * st * sp, ct);
    let by_theta = DVec3::new(root * ct * cp, root * ct * sp, -r * st);
    let by_phi = DVec3::new(-root * st * sp, root * st * cp, 0.0);
    (DVec3::new(root * st * cp, root * st * sp, r * ct), DMat3::from_cols(by_r, by_theta, by_phi))
}

#[test]
fn the_metric_is_the_textbooks() {
    let mut random = Random(5);
    for (spin, charge) in [(0.5, 0.0), (-0.9, 0.0), (0.998, 0.0), (0.8, 0.3)] {
        let kerr = hole(spin, charge);
        let a = spin;
        for i in 0..200 {
            let r = kerr.horizon() + 1e-2 + 20.0 * random.next().powi(3);
            let (theta, phi) = (0.01 + 3.12 * random.next(), 6.0 * random.next());
            let (x, jacobian) = chart(a, r, theta, phi);
            assert!((kerr.radius(x) / r - 1.0).abs() < 1e-12);
            // Boyer and Lindquist 1967.
            let (s2, sigma, m, square) =
                (theta.sin().powi(2), r * r + (a * theta.cos()).powi(2), 2.0 * r - charge * charge, r * r + a * a);
            let delta = square - m;
            let (g_tt, g_tp) = (m / sigma - 1.0, -a * m * s2 / sigma);
            let g = [sigma / delta, sigma, (square * square - delta * a * a * s2) * s2 / sigma];

            let Inverse { tt, t, space } = kerr.inverse(Dual::variables(x));
            // Contravariant components, in r, theta, phi.
            let back = jacobian.inverse();
            let (up, up_t) = (back * matrix(space) * back.transpose(), back * DVec3::from_array(t.map(|t| t.value)));
            let det = g_tt * g[2] - g_tp * g_tp;
            let near = |found: f64, right: f64, size: f64| {
                assert!((found - right).abs() < 1e-11 * size.abs(), "{spin} {i}: {found} {right}")
            };
            near(tt.value, g[2] / det, g[2] / det);
            near(up_t.z, -g_tp / det, g_tp / det);
            near(up.z_axis.z, g_tt / det, 1.0 / (s2 * delta) + (g_tt / det).abs());
            near(up.x_axis.x, 1.0 / g[0], 1.0);
            near(up.y_axis.y, 1.0 / g[1], 1.0);
            for off in [up.x_axis.y, up.x_axis.z, up.y_axis.z, up_t.x, up_t.y] {
                near(off, 0.0, 1.0 / (s2 * delta) + 1.0);
            }

            let here = kerr.at(Place::near(x));
            assert_eq!(here.is_some(), m < sigma, "{spin} {i}: the ergosphere is no place to stand");
            let Some(here) = here else { continue };
            near(here.lapse * here.lapse, -g_tt, 1.0);
            near(here.root.volume_factor() * here.lapse, 1.0, 1.0);
            // gamma_ij = g_ij - g_ti g_tj / g_tt, beta_i = g_ti / g_tt
            let gamma = [g[0], g[1], g[2] - g_tp * g_tp / g_tt];
            for (v, right) in AXES.into_iter().map(|unit| jacobian * unit).zip(gamma) {
                near(here.root.apply(v).length_squared(), right, right);
            }
            near(here.beta.dot(jacobian.z_axis), g_tp / g_tt, g_tp / g_tt);
            near(here.beta.dot(jacobian.x_axis) + here.beta.dot(jacobian.y_axis), 0.0, 1.0);
            assert!(kerr.at(Place { x, side: Side::Far }).is_none());
        }
    }
}

#[test]
fn on_the_axis_and_on_the_equator() {
    let kerr = hole(0.9, 0.0);
    // N^2 = 1 - 2 M r / (r^2 + a^2) on the axis, 1 - 2 M / r on the equator.
    let on_axis = kerr.at(Place::near(DVec3::Z * 3.0)).unwrap();
    assert!((on_axis.lapse.powi(2) - (1.0 - 6.0 / 9.81)).abs() < 1e-15 && on_axis.beta == DVec3::ZERO);
    let radial = (9.81_f64 / (9.81 - 6.0)).sqrt();
    assert!((on_axis.root.apply(DVec3::new(1.0, 2.0, 1.0)) - DVec3::new(1.0, 2.0, radial)).length() < 1e-14);
    let equator = kerr.at(Place::near(DVec3::X * 3.0_f64.hypot(0.9))).unwrap();
    assert!((equator.lapse.powi(2) - (1.0 - 2.0 / 3.0)).abs() < 1e-14);
    // What moves with the flow moves along axis x x.
    assert!(equator.beta.y > 0.0 && equator.beta.x == 0.0);
    // Inside r = 2 nothing stands on the equator, down to the horizon something stands on the axis.
    assert!(kerr.at(Place::near(DVec3::Y * 1.99_f64.hypot(0.9))).is_none());
    assert!(kerr.at(Place::near(DVec3::Z * (kerr.horizon() + 1e-6))).is_some());
    for x in [DVec3::ZERO, DVec3::X * 0.9, DVec3::X * 0.3, DVec3::Z * kerr.horizon(), DVec3::Z * 0.1] {
        assert!(kerr.at(Place::near(x)).is_none(), "{x}");
    }
}

#[test]
fn without_spin_it_is_the_round_hole_and_without_mass_flat() {
    let mut random = Random(9);
    let round = Spherical { center: DVec3::new(0.1, -0.4, 0.3), rs: 1.1, charge_squared: 0.2 };
    let still = Kerr::new(round, DVec3::new(0.6, 0.0, 0.8), 0.0);
    // A mass of nearly 0, but a spin of 0.7.
    let massless = Kerr::new(Spherical { rs: 2e-14, charge_squared: 0.0, ..round }, DVec3::Y, 0.7e14);
    let same = |a: Stationary, b: Stationary| {
        assert!((a.lapse - b.lapse).abs() < 1e-13 && (a.beta - b.beta).length() < 1e-12);
        for v in AXES {
            assert!((a.root.apply(v) - b.root.apply(v)).length() < 1e-12);
        }
    };
    for _ in 0..100 {
        let x = random.direction() * (2.0 + 9.0 * random.next());
        same(still.at(Place::near(x)).unwrap(), round.at(x).unwrap());
        same(massless.at(Place::near(x)).unwrap(), Stationary::FLAT);
    }
    assert!((still.horizon() - round.horizon()).abs() < 1e-15);
}

/// The derivatives of place and momentum of light of energy 1, followed along the flow of time or (`sense` -1) against it.
fn hamilton(kerr: &Kerr, sense: f64, (x, p): (DVec3, DVec3)) -> (DVec3, DVec3) {
    let mut inverse = kerr.inverse(Dual::variables(x));
    inverse.t = inverse.t.map(|t| sense * t);
    (inverse.velocity(p), -0.5 * inverse.norm(p).gradient)
}

/// One step of Runge and Kutta's fourth order, and Richardson's extrapolation from two halves: order five.
fn step(kerr: &Kerr, sense: f64, from: (DVec3, DVec3), h: f64) -> (DVec3, DVec3) {
    let plus = |(x, p): (DVec3, DVec3), (dx, dp): (DVec3, DVec3), h: f64| (x + dx * h, p + dp * h);
    let rk4 = |y: (DVec3, DVec3), h: f64| {
        let k1 = hamilton(kerr, sense, y);
        let k2 = hamilton(kerr, sense, plus(y, k1, 0.5 * h));
        let k3 = hamilton(kerr, sense, plus(y, k2, 0.5 * h));
        let k4 = hamilton(kerr, sense, plus(y, k3, h));
        let mean = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| (a + 2.0 * (b + c) + d) / 6.0;
        plus(y, (mean(k1.0, k2.0, k3.0, k4.0), mean(k1.1, k2.1, k3.1, k4.1)), h)
    };
    let (whole, halves) = (rk4(from, h), rk4(rk4(from, 0.5 * h), 0.5 * h));
    (halves.0 + (halves.0 - whole.0) / 15.0, halves.1 + (halves.1 - whole.1) / 15.0)
}

/// Where light from `x` in the static observer's direction `local` meets the plane x = -8; `None` if it falls into the hole. And its angular
/// momentum about the axis.
fn meets(kerr: &Kerr, sense: f64, x: DVec3, local: DVec3) -> (Option<DVec3>, f64) {
    let mut here = kerr.at(Place::near(x)).unwrap();
    here.beta *= sense;
    let mut now = (x, here.momentum(here.root.chart_direction(local)));
    let l = DVec3::Z.dot(x.cross(now.1));
    for _ in 0..1_000_000 {
        let (v, _) = hamilton(kerr, sense, now);
        if kerr.swallows(now.0, v) {
            return (None, l);
        }
        let h = 2e-3 * (kerr.radius(now.0) - kerr.horizon()) / v.length();
        let next = step(kerr, sense, now, h);
        assert!((DVec3::Z.dot(next.0.cross(next.1)) - l).abs() < 1e-9, "the angular momentum is conserved");
        if next.0.x <= -8.0 && now.0.x > -8.0 {
            // Newton's iteration for the step that ends on the plane.
            let mut h = h * (now.0.x + 8.0) / (now.0.x - next.0.x);
            for _ in 0..5 {
                let y = step(kerr, sense, now, h);
                h -= (y.0.x + 8.0) / hamilton(kerr, sense, y).0.x;
            }
            return (Some(step(kerr, sense, now, h).0), l);
        }
        now = next;
    }
    panic!("the ray does not end");
}

#[test]
fn rays_move_as_in_other_coordinates() {
    // Computed with separated equations and in Kerr and Schild's coordinates, which agree to 1e-12. Light that is looked at comes against
    // the flow of time; its own angular momentum is the opposite of that of the ray which is followed.
    let kerr = hole(0.9, 0.0);
    let eye = DVec3::X * 12.0;
    for (local, y, z, l) in [
        (DVec3::new(-1.0, -0.45, 0.2), -0.554651707083637, 0.900612072638014, 5.130726638629703),
        (DVec3::new(-1.0, -0.1, 0.6), 0.740415174196968, 3.38187527252831, 0.943423103976243),
        (DVec3::new(-1.0, 0.62, 0.1), -5.58176101421623, -1.27569237989897, -7.088375348045848),
    ] {
        let (met, found_l) = meets(&kerr, -1.0, eye, local);
        let met = met.unwrap();
        assert!((met.y - y).abs() < 1e-9 && (met.z - z).abs() < 1e-9, "{local}: {met}");
        assert!((found_l + l).abs() < 1e-11, "{local}: {found_l}");
    }
    // The same direction with time and against it.
    let local = DVec3::new(-1.0, -0.5, 0.0);
    let met = meets(&kerr, -1.0, eye, local).0.unwrap();
    assert!((met.y + 1.385403296393).abs() < 1e-9, "{met}");
    assert!(meets(&kerr, 1.0, eye, local).0.is_none());
    // Light against time around a hole that spins one way is light with time around one that spins the other way.
    let met_by_other = meets(&hole(-0.9, 0.0), 1.0, eye, local).0.unwrap();
    assert!((met - met_by_other).length() < 1e-12);
}

#[test]
fn light_that_is_swallowed_never_turns() {
    let mut random = Random(17);
    let mut inside = 0;
    for (spin, charge) in [(0.3, 0.0), (0.9, 0.0), (-0.998, 0.0), (0.6, 0.5), (0.3, 0.95)] {
        let kerr = hole(spin, charge);
        let (a, axis, horizon) = (spin, DVec3::Z, kerr.horizon());
        for _ in 0..20_000 {
            let (x, _) = chart(a, horizon * (1.0 + random.next().powi(2)), (2.0 * random.next() - 1.0).acos(), 1.0);
            let inverse = kerr.inverse(Dual::variables(x));
            // Momenta of light of energy 1 along a random covector: the roots of a quadratic equation.
            let p = random.direction();
            let (space, t) = (p.dot(matrix(inverse.space) * p), p.dot(DVec3::from_array(inverse.t.map(|t| t.value))));
            let root = t * t - space * inverse.tt.value;
            for sign in [-1.0, 1.0] {
                let p = p * ((t + sign * root.sqrt()) / space);
                let v = inverse.velocity(p);
                // Light moves into the future: dt/dlambda = g^tt p_t + g^ti p_i, p_t = -1.
                let future = DVec3::from_array(inverse.t.map(|t| t.value)).dot(p) - inverse.tt.value > 0.0;
                if !(root > 0.0 && p.is_finite() && future && kerr.swallows(x, v)) {
                    continue;
                }
                inside += 1;
                let (r, l) = (kerr.radius(x), axis.dot(x.cross(p)));
                let delta = |r: f64| r * r + a * a - 2.0 * r + charge * charge;
                let potential = |r: f64| (r * r + a * a - a * l).powi(2);
                // (S dr/dlambda)^2 = (r^2 + a^2 - a L)^2 - D kappa: kappa from here, then its sign down to the horizon.
                let h = 1e-6 * r;
                let slope = (kerr.radius(x + v * h / v.length()) - kerr.radius(x - v * h / v.length())) / (2.0 * h) * v.length();
                let sigma = r * r + (a * x.z / r).powi(2);
                let kappa = (potential(r) - (sigma * slope).powi(2)) / delta(r);
                for i in 1..100 {
                    let s = horizon + (r - horizon) * f64::from(i) / 100.0;
                    assert!(potential(s) - delta(s) * kappa > 0.0, "{spin} {charge}: {x} {p} at {s}");
                }
            }
        }
    }
    assert!(inside > 5_000, "{inside}");
    // Photon orbits with the spin: Bardeen, Press and Teukolsky 1972, in a table of 16 digits. Their ball of no return ends there.
    for (spin, r) in [(0.5, 2.34729635533386), (0.9, 1.55785462742338), (0.998, 1.07390925767995)] {
        let kerr = hole(spin, 0.0);
        let swallows = |r: f64| kerr.swallows(DVec3::X * r.hypot(spin), -DVec3::X);
        assert!(swallows(r - 1e-12) && !swallows(r + 1e-12), "{spin}");
        assert!(!kerr.swallows(DVec3::X * r.hypot(spin), DVec3::X));
    }
}

#[test]
fn scenes_give_spin_as_a_share_and_its_axis_under_the_transform() {
    use common::build_under;
    use glam::{DAffine3, DQuat};
    let given: common::Given = &[("float rs", &[2.0]), ("float spin", &[0.9]), ("vector3 axis", &[0.0, 0.0, 5.0])];
    let x = DVec3::new(3.0, 1.0, 1.2);
    let kerr = build("kerr", given).at(Place::near(x)).unwrap();
    // N = 0.6291214887366124 at (3, 1, 1.2).
    assert!((kerr.lapse - 0.6291214887366124).abs() < 1e-14);
    assert_eq!(kerr, hole(0.9, 0.0).at(Place::near(x)).unwrap());
    // The default axis is +y.
    let upright = build("kerr", &given[..2]).at(Place::near(DVec3::new(3.0, 0.0, 0.0))).unwrap();
    assert!(upright.beta.z < 0.0 && upright.beta.x == 0.0, "{}", upright.beta);
    // Scaled, turned and moved, covectors go with the inverse scale times the time's.
    let turn = DQuat::from_rotation_x(0.8);
    let transform = DAffine3::from_scale_rotation_translation(DVec3::splat(2.0), turn, DVec3::new(1.0, 2.0, 3.0));
    let moved = build_under(transform, "kerr", given).0.unwrap().at(Place::near(transform.transform_point3(x))).unwrap();
    assert!((moved.lapse - kerr.lapse).abs() < 1e-14 && (moved.beta - turn * kerr.beta).length() < 1e-14);
    // A mirrored scene is the mirror image: the flow too.
    let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let mirrored = build_under(mirror, "kerr", given).0.unwrap().at(Place::near(mirror.transform_point3(x))).unwrap();
    assert!((mirrored.beta - mirror.transform_vector3(kerr.beta)).length() < 1e-15);

    let wrong = |params: common::Given| {
        build_under(DAffine3::IDENTITY, "kerr", params).1.into_iter().map(|d| d.message).collect::<Vec<_>>()
    };
    assert_eq!(wrong(&[("float rs", &[2.0]), ("float spin", &[1.0])]), ["`spin` is out of range"]);
    assert_eq!(wrong(&[("float rs", &[2.0]), ("float spin", &[f64::NAN])]), ["`spin` is out of range"]);
    assert_eq!(
        wrong(&[("float rs", &[2.0]), ("float spin", &[0.9]), ("float charge", &[0.5])]),
        ["spin and charge are too large for the mass"]
    );
    assert_eq!(wrong(&[("float rs", &[2.0]), ("float spin", &[0.9]), ("vector3 axis", &[0.0; 3])]), ["`axis` has no direction"]);
    // Without spin and without mass.
    use bhs_core::spacetime::Class;
    let still = build("kerr", &[("float rs", &[2.0]), ("float spin", &[0.0]), ("float charge", &[1.0])]);
    assert!(matches!(still.class(), Class::Spherical(s) if s.rs == 2.0 && s.charge_squared == 1.0));
    assert!(matches!(build("kerr", &[("float rs", &[0.0]), ("float spin", &[0.9])]).class(), Class::Flat));
}
