//! Angles that light sweeps, from what static observers measure and a quadrature, against published and areal formulas.

mod common;

use bhs_core::spacetime::{Place, Side, Spacetime};
use bhs_spacetimes::{Hole, MajumdarPapapetrou};
use common::{Random, build, index_of, integral, integral_from};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Of a spacetime that is round about the origin, at chart radius `rho`: radial and tangential stretch, and what the impact parameter of
/// light is that moves across there.
fn measured(spacetime: &dyn Spacetime, rho: f64) -> (f64, f64, f64) {
    let here = spacetime.at(Place::near(DVec3::X * rho)).expect("a place");
    let (a, b) = (here.root.apply(DVec3::X).x, here.root.apply(DVec3::Y).y);
    (a, b, rho * b / here.lapse)
}

/// Derivative of that impact parameter by the chart radius.
fn slope(spacetime: &dyn Spacetime, rho: f64) -> f64 {
    let at = |h: f64| measured(spacetime, rho + h).2;
    let h = 2e-3 * rho;
    let d = |h: f64| (at(h) - at(-h)) / (2.0 * h);
    // Two extrapolations.
    let (d1, d2, d3) = (d(h), d(0.5 * h), d(0.25 * h));
    let (e1, e2) = ((4.0 * d2 - d1) / 3.0, (4.0 * d3 - d2) / 3.0);
    (16.0 * e2 - e1) / 15.0
}

/// The angle by which light of impact parameter `b` from far away is deflected; `inner` is a chart radius where it grows with the radius.
///
/// Turning points are no trouble if the angle is integrated over psi with impact parameter across = b / cos psi.
fn deflection(spacetime: &dyn Spacetime, inner: f64, b: f64) -> f64 {
    let excess = |_: f64, _: f64, from_end: f64| {
        let wanted = b / from_end.sin();
        if wanted > 1e9 * b {
            return 0.0;
        }
        let (mut low, mut high) = (inner, 2.0 * wanted + inner);
        for _ in 0..200 {
            let rho = 0.5 * (low + high);
            if measured(spacetime, rho).2 < wanted {
                low = rho;
            } else {
                high = rho;
            }
        }
        let rho = 0.5 * (low + high);
        let (radial, tangential, across) = measured(spacetime, rho);
        across * radial / (rho * tangential * slope(spacetime, rho)) - 1.0
    };
    2.0 * integral(0.0, FRAC_PI_2, excess)
}

/// The angle that light of impact parameter `h` sweeps from far away to far away on the other side.
fn through(spacetime: &dyn Spacetime, h: f64) -> f64 {
    let rho_t = index_of(spacetime).unwrap().throat().unwrap().radius;
    let breaks: Vec<f64> = index_of(spacetime).unwrap().breaks().iter().map(|b| (b / rho_t).ln()).filter(|s| *s > 0.0).collect();
    let swept = |s: f64| {
        let across = measured(spacetime, rho_t * s.exp() * (1.0 + 1e-15)).2;
        h / ((across - h) * (across + h)).sqrt()
    };
    let start = breaks.first().copied().unwrap_or(0.0);
    2.0 * (integral(0.0, start, |s, _, _| swept(s)) + integral_from(start, |s| if s > 300.0 { 0.0 } else { swept(s) }))
}

fn near(found: f64, right: f64, within: f64, what: &str) {
    assert!((found - right).abs() < within, "{what}: {found} instead of {right}: {:e}", found - right);
}

#[test]
fn holes_deflect_as_published() {
    let schwarzschild = build("schwarzschild", &[("float rs", &[1.0])]);
    for (b, right) in [(2.7, 2.919396339609558), (3.0, 1.719388310230169), (5.0, 0.590395787605827), (100.0, 0.020299966239543)] {
        near(deflection(schwarzschild.as_ref(), 1.5, b), right, 1e-9, "schwarzschild");
    }
    // Chandrasekhar 1983's integral of the areal chart, 16 digits.
    for (charge, of_six, of_ten) in [
        (0.5, 1.551187254247158, 0.5756100502520441),
        (0.9, 1.272240846265183, 0.5437063921910459),
        (1.0, 1.197403706675174, 0.5332426590717215),
    ] {
        let rn = build("reissner-nordstrom", &[("float rs", &[2.0]), ("float charge", &[charge])]);
        let photon_sphere = 0.5 * (3.0 + (9.0 - 8.0 * charge * charge).sqrt());
        near(deflection(rn.as_ref(), photon_sphere, 6.0), of_six, 1e-9, "reissner-nordstrom");
        near(deflection(rn.as_ref(), photon_sphere, 10.0), of_ten, 1e-9, "reissner-nordstrom");
    }
}

#[test]
fn one_extremal_hole_is_the_extremal_charged_hole() {
    let mp = build("majumdar-papapetrou", &[("point3 centers", &[0.0; 3]), ("float masses", &[1.0])]);
    let rn = build("reissner-nordstrom", &[("float rs", &[2.0]), ("float charge", &[1.0])]);
    near(deflection(mp.as_ref(), 1.0, 6.0), 1.197403706675174, 1e-9, "one hole");
    near(deflection(mp.as_ref(), 1.0, 10.0), 0.5332426590717215, 1e-9, "one hole");
    for rho in [0.01, 0.3, 1.0, 7.0, 1e4] {
        // The areal radius is rho + M. Impact parameter, lapse and proper radial length agree.
        let (a, _, across) = measured(mp.as_ref(), rho);
        let (b, _, areal) = measured(rn.as_ref(), rho + 1.0);
        // The areal N^2 is a difference of nearly equal numbers close to the horizon.
        let within = 1e-14 + 1e-15 / (rho * rho);
        assert!((across / areal - 1.0).abs() < within && (a / b - 1.0).abs() < within, "{rho}");
    }
    // The photon sphere, with the critical impact parameter 4 M.
    near(measured(mp.as_ref(), 1.0).2, 4.0, 1e-14, "photon sphere");
    near(slope(mp.as_ref(), 1.0), 0.0, 1e-10, "photon sphere");
}

#[test]
fn wormholes_sweep_as_published() {
    let ellis = build("ellis", &[("float throat", &[1.0])]);
    // 2 (h/b0) K(h/b0), and 2 K(b0/h) - pi.
    near(through(ellis.as_ref(), 0.5), 1.685750354812596, 1e-10, "ellis");
    near(through(ellis.as_ref(), 0.9), 4.104988449160986, 1e-10, "ellis");
    near(deflection(ellis.as_ref(), 0.5, 2.0), 0.2299080560353988, 1e-9, "ellis");
    near(deflection(ellis.as_ref(), 0.5, 1.1), 1.50225541996245, 1e-9, "ellis");
    // Weak field: (pi/4) (b0/h)^2.
    near(deflection(ellis.as_ref(), 0.5, 1e3) * 1e6, PI / 4.0, 1e-4, "ellis");
    // The isotropic radius is (l + r)/2 with r^2 = l^2 + b0^2.
    for l in [0.0, 0.1, 1.0, 50.0] {
        let r = f64::hypot(l, 1.0);
        let here = ellis.at(Place { x: DVec3::Y * (0.5 * (l + r) * (1.0 + 1e-15)), side: Side::Far }).unwrap();
        near(here.root.apply(DVec3::X).x * 0.5 * (l + r) / r, 1.0, 1e-13, "ellis");
    }
}

#[test]
fn long_wormholes_sweep_as_published() {
    // The areal quadratures, in units of the throat: 30 digits, then by the quadrature of these tests.
    for (throat, length, width, share, right) in
        [(1.0, 1.0, 0.1, 0.5, Some(1.8391092507240994)), (2.0, 0.0, 0.5, 0.7, None), (0.3, 0.9, 0.002, 0.95, None)]
    {
        let dneg = build("dneg", &[("float throat", &[throat]), ("float length", &[length]), ("float lensingwidth", &[width])]);
        let h = share * throat;
        let m = width / 1.42953;
        let areal = |x: f64| throat + m * (x * x.atan() - 0.5 * (x * x).ln_1p());
        let beyond = integral_from(0.0, |x| {
            let sine = h / areal(x);
            m * PI * sine / (areal(x) * (1.0 - sine * sine).sqrt())
        });
        let expected = length * share / (throat * (1.0 - share * share).sqrt()) + beyond;
        near(through(dneg.as_ref(), h), expected, 1e-10, "dneg, areal");
        if let Some(right) = right {
            near(expected, right, 1e-12, "areal");
            near(through(dneg.as_ref(), h), right, 1e-10, "dneg");
        }
    }
}

#[test]
fn light_that_turns_before_a_long_wormhole_sweeps_as_in_the_areal_radius() {
    let dneg = build("dneg", &[("float throat", &[1.0]), ("float length", &[1.0]), ("float lensingwidth", &[0.1])]);
    let m = 0.1 / 1.42953;
    let areal = |x: f64| 1.0 + m * (x * x.atan() - 0.5 * (x * x).ln_1p());
    for b in [1.02, 1.5, 6.0] {
        // r = b / cos psi: the angle is the integral of 1 / (dr/dl).
        let excess = |_: f64, _: f64, from_end: f64| {
            let wanted = b / from_end.sin();
            let (mut low, mut high) = (0.0, 2.0 * wanted / m);
            if wanted > 1e9 {
                return 0.0;
            }
            for _ in 0..200 {
                let x = 0.5 * (low + high);
                if areal(x) < wanted {
                    low = x;
                } else {
                    high = x;
                }
            }
            FRAC_PI_2 / (0.5 * (low + high)).atan() - 1.0
        };
        let expected = 2.0 * integral(0.0, FRAC_PI_2, excess);
        let found = deflection(dneg.as_ref(), index_of(dneg.as_ref()).unwrap().breaks()[1], b);
        near(found, expected, 1e-8, "dneg");
    }
}

/// Whether light at `x` with the direction `d` comes ever nearer to hole `i` until it is deep within: Runge and Kutta's fourth order, small steps.
fn falls(spacetime: &MajumdarPapapetrou, i: usize, x: DVec3, d: DVec3) -> bool {
    use bhs_core::spacetime::GradedIndex;
    let center = spacetime.holes()[i].center;
    let (mut x, start) = (x, (x - center).length());
    let mut v = d * spacetime.index(x).0.sqrt();
    let mut last = start * (1.0 + 1e-12);
    loop {
        let nearest = spacetime.holes().iter().map(|h| (h.center - x).length()).fold(f64::INFINITY, f64::min);
        let h = 0.02 * nearest / v.length();
        let a = |x: DVec3| spacetime.index(x).1;
        let k1 = a(x);
        let k2 = a(x + v * (0.5 * h));
        let k3 = a(x + v * (0.5 * h) + k1 * (0.25 * h * h));
        let k4 = a(x + v * h + k2 * (0.5 * h * h));
        x += v * h + (k1 + k2 + k3) * (h * h / 6.0);
        v += (k1 + 2.0 * (k2 + k3) + k4) * (h / 6.0);
        let now = (x - center).length();
        if now > last {
            return false;
        }
        if now < 1e-2 * start {
            return true;
        }
        last = now;
    }
}

#[test]
fn light_that_enters_a_capture_ball_falls() {
    let mut random = Random(11);
    for round in 0..40 {
        // Masses and distances of very different sizes too.
        let count = 1 + round % 4;
        let holes: Vec<Hole> = (0..count)
            .map(|_| Hole {
                center: random.direction() * 10.0_f64.powf(2.0 * random.next() - 1.5),
                mass: 10.0_f64.powf(3.0 * random.next() - 2.0),
            })
            .collect();
        let spacetime = MajumdarPapapetrou::new(&holes);
        for (i, ball) in spacetime.captures().into_iter().enumerate() {
            assert!(
                ball.radius > 0.0
                    && holes.iter().enumerate().all(|(j, h)| j == i || (h.center - ball.center).length() > ball.radius)
            );
            for _ in 0..20 {
                let out = random.direction();
                // Down to nearly along the surface.
                let inward = 10.0_f64.powf(-3.0 * random.next());
                let across = out.cross(random.direction()).normalize();
                let d = (across * (1.0 - inward * inward).sqrt() - out * inward).normalize();
                assert!(falls(&spacetime, i, ball.center + out * ball.radius, d), "{holes:?} {i} {out} {d}");
            }
        }
    }
    // Alone, the ball is the photon sphere.
    let alone = MajumdarPapapetrou::new(&[Hole { center: DVec3::ZERO, mass: 0.7 }]);
    assert!((alone.captures()[0].radius - 0.7).abs() < 1e-15);
}
