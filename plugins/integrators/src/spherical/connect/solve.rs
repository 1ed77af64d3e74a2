//! The orbit that joins two radii across a given angle, in units of the Schwarzschild radius.
//!
//! With U = rs/r, V = dU/dphi and C = (rs/b)^2 every orbit is `V^2 = C - U^2 + U^3` (`docs/physics.md`, section 3), an elliptic curve,
//! and going on by an angle is adding a point to (U, V) on it (Weierstrass; Biermann 1865; Silverman, "The Arithmetic of
//! Elliptic Curves", III.2). The point to add is (1/y, -y'/y^2), where y(phi) = r/rs of the orbit that starts at r = 0:
//!
//! `y'' = 1/2 - y + 2 C y^3`,  `y'^2 = y - y^2 + C y^4`,  `y(0) = y'(0) = 0`          (C = 0: y = sin^2(phi/2))
//!
//! y is a power series near 0, and doubling the point takes it from phi to 2 phi. No root of the cubic, no square root, no
//! case for captured, escaping or turning orbits.
//!
//! The orbit is described by its middle: the state (u, v) half way between the ends in angle. With y at half the swept angle,
//! D = 1 - u y and P' = 3 u^2 - 2 u, the ends of the orbit, one addition forwards and one backwards, lie at
//!
//! `(U2 + U1)/2 = u + P' y/D + 2 v^2 y^2/D^2`,   `(U2 - U1)/2 = 2 v y'/D^2`,   `C = v^2 + u^2 - u^3`
//!
//! The second gives v; what is left are two equations in (u, C), which Newton's method solves. D is positive on every orbit
//! that reaches both ends. U(Phi) grows with the launch slope from 0 (the orbit escapes there) to 1 (it is captured there), so
//! there is exactly one orbit for every swept angle, and which solution of the equations it is shows in the slopes at its ends.
//! The spread comes with it: dU2/dV1 at fixed U1 is `4 J y'/D^2`, J the determinant of Newton's matrix. Only the square of
//! U2 - U1 enters, so going back is the same arithmetic: reciprocity holds by construction.

use crate::spherical::connect::lanes::Lanes;
use bhs_elementary::Elementary;
use std::f64::consts::PI;

/// What is wanted, of several orbits: all in units of the Schwarzschild radius.
#[derive(Clone, Copy, Debug)]
pub struct Ends<const N: usize> {
    /// rs/r where the orbit starts, in (0, 1).
    pub u1: Lanes<N>,
    /// rs/r where it ends, in (0, 1).
    pub u2: Lanes<N>,
    /// (u2 - u1)/2, which the caller may know better than as a difference.
    pub half_rise: Lanes<N>,
}

/// The orbit that was found.
#[derive(Clone, Copy, Debug)]
pub struct Solved {
    /// dU/dphi at the start.
    pub v1: f64,
    /// dU/dphi at the end.
    pub v2: f64,
    /// dU2/dV1 at fixed U1 and swept angle: how the end moves with the slope at the start.
    pub stretch: f64,
    /// Newton steps that it took.
    pub steps: u32,
}

/// C of the orbit that winds for ever on the photon sphere, U = 2/3.
const C_CRITICAL: f64 = 4.0 / 27.0;
const U_CRITICAL: f64 = 2.0 / 3.0;

/// The power series of y in x = phi^2: `y = x/4 sum_m (C x^3)^m sum_i SERIES[m][i] x^i`, by the recurrence that
/// y'' = 1/2 - y + 2 C y^3 gives. To 1e-16 of y for phi <= pi/4 and C <= C_CRITICAL; the orbits that get
/// anywhere with a greater C sweep so much less that C x^3 is smaller still.
const SERIES: [[f64; 8]; 4] = [
    [
        1.0,
        -1.0 / 12.0,
        1.0 / 360.0,
        -1.0 / 20160.0,
        1.0 / 1814400.0,
        -1.0 / 239500800.0,
        1.0 / 43589145600.0,
        -1.0 / 10461394944000.0,
    ],
    [
        1.0 / 448.0,
        -1.0 / 2688.0,
        3.0 / 98560.0,
        -157.0 / 96864768.0,
        4861.0 / 77491814400.0,
        -2957.0 / 1580833013760.0,
        9413.0 / 211189410432000.0,
        -4027.0 / 4625517398261760.0,
    ],
    [
        3.0 / 652288.0,
        -37.0 / 31309824.0,
        8861.0 / 58549370880.0,
        -57097.0 / 4449752186880.0,
        2334439.0 / 2890948373913600.0,
        -4551929.0 / 113479360170688512.0,
        0.0,
        0.0,
    ],
    [
        15.0 / 1586364416.0,
        -73.0 / 22209101824.0,
        982435.0 / 1719384245010432.0,
        -4923341.0 / 74506650617118720.0,
        0.0,
        0.0,
        0.0,
        0.0,
    ],
];

/// y at one angle, as a function of C.
struct Swing<const N: usize> {
    doublings: u32,
    x3: Lanes<N>,
    /// The polynomials of the series, evaluated.
    terms: [Lanes<N>; 4],
}

impl<const N: usize> Swing<N> {
    fn new(angle: Lanes<N>) -> Self {
        let largest = angle.0.into_iter().fold(0.0, f64::max);
        let mut doublings = 2;
        let mut shrink = 0.25;
        while largest * shrink > 0.2501 * PI {
            shrink *= 0.5;
            doublings += 1;
        }
        let z = angle * shrink;
        let x = z * z;
        let x2 = x * x;
        let quarter = 0.25 * x;
        let polynomial = |a: &[f64; 8]| {
            let even = a[0] + x2 * (a[2] + x2 * (a[4] + x2 * a[6]));
            let odd = a[1] + x2 * (a[3] + x2 * (a[5] + x2 * a[7]));
            quarter * (even + x * odd)
        };
        Self { doublings, x3: x * x2, terms: [0, 1, 2, 3].map(|m| polynomial(&SERIES[m])) }
    }

    /// y and dy/dC.
    #[inline(always)]
    fn at(&self, c: Lanes<N>) -> (Lanes<N>, Lanes<N>) {
        let t = c * self.x3;
        let [a0, a1, a2, a3] = self.terms;
        let mut y = a0 + t * (a1 + t * (a2 + t * a3));
        let mut y_c = self.x3 * (a1 + t * (2.0 * a2 + 3.0 * t * a3));
        for _ in 0..self.doublings {
            let y2 = y * y;
            let y3 = y2 * y;
            let q = c * y3;
            let over = (1.0 - 8.0 * q + 4.0 * q * y).recip();
            let doubled = 4.0 * y * (1.0 - y + q) * over;
            let by_y = (4.0 * (1.0 - 2.0 * y + 4.0 * q) + 8.0 * c * y2 * doubled * (3.0 - 2.0 * y)) * over;
            let by_c = 4.0 * y3 * (y + doubled * (2.0 - y)) * over;
            y_c = by_y * y_c + by_c;
            y = doubled;
        }
        (y, y_c)
    }
}

/// Newton stops after a step smaller than this, relative: the error of the orbit then is its square, times a factor of order 10;
/// that of the spread is the step times such a factor.
const SMALL: f64 = 1e-10;
/// The same beyond two half turns, where that factor is larger.
const SMALL_WINDING: f64 = 1e-12;
/// More steps than ever needed (random search: 5).
const MOST_STEPS: u32 = 16;

/// A first guess of (u, C) in the middle.
///
/// Near the photon sphere an orbit is the sum of two on the critical orbit, one coming from each end (C and the depth
/// `w = U - 2/3` are then known in closed form: U = -1/3 + tanh^2, coth^2). Its C gives y; y gives u from the first equation
/// with its cubic term expanded to second order around the same depth. Within 6e-3 for all swept angles up to 2 pi, and far
/// better for most; beyond 2 pi the sum alone is as good.
#[inline(always)]
fn guess<const N: usize>(swing: &Swing<N>, half_angle: Lanes<N>, ends: &Ends<N>) -> (Lanes<N>, Lanes<N>) {
    let decay = half_angle.map(|h| (-h).exponential());
    // One end's part of w in the middle.
    let depth = |u: Lanes<N>| {
        let root = (u + 1.0 / 3.0).sqrt();
        let a = (1.0 + root) + decay * (1.0 - root);
        decay * (4.0 * (u - U_CRITICAL)) * (a * a).recip()
    };
    let (w1, w2) = (depth(ends.u1), depth(ends.u2));
    let (w, c) = (w1 + w2, C_CRITICAL - 4.0 * w1 * w2);
    if half_angle.0.into_iter().any(|h| h > PI) {
        return (U_CRITICAL + w, c);
    }
    let c = c.map(|c| c.max(0.0));
    let y = swing.at(c).0;
    let a = ends.half_rise * ends.half_rise * (4.0 * y * (1.0 - y + c * y * y * y)).recip();
    let k = 2.0 * a * y * y;
    let d = (1.0 - y * (U_CRITICAL + w)).map(|d| d.clamp(0.0, 1.0));
    let sum = 0.5 * (ends.u1 + ends.u2);
    // p2 u^2 + p1 u - p0 = 0
    let p0 = sum - k * d * (3.0 - 3.0 * d + d * d);
    let p1 = 1.0 - 2.0 * y + sum * y - 3.0 * k * y * d * (2.0 - d);
    let p2 = 2.0 * y + 3.0 * k * d * y * y;
    let u = Lanes(std::array::from_fn(|i| positive_root(p2.0[i], p1.0[i], p0.0[i])));
    let d2 = (1.0 - u * y).map(|d| d.max(0.0) * d.max(0.0));
    (u, a * d2 * d2 + u * u * (1.0 - u))
}

/// The positive root of `p2 u^2 + p1 u = p0`, without cancellation.
#[inline(always)]
fn positive_root(p2: f64, p1: f64, p0: f64) -> f64 {
    let root = (p1 * p1 + 4.0 * p2 * p0).max(0.0).sqrt();
    if p1 > 0.0 { 2.0 * p0 / (p1 + root) } else { (root - p1) / (2.0 * p2) }
}

/// The orbits from `ends.u1` to `ends.u2` that sweep the angles `swept` (positive); `None` where none was found.
#[inline(always)]
pub fn solve<const N: usize>(ends: &Ends<N>, swept: Lanes<N>) -> [Option<Solved>; N] {
    let half_angle = 0.5 * swept;
    let swing = Swing::new(half_angle);
    let sum = 0.5 * (ends.u1 + ends.u2);
    let rise2 = 0.25 * ends.half_rise * ends.half_rise;
    let small = if half_angle.0.into_iter().any(|h| h > PI) { SMALL_WINDING } else { SMALL };
    let (mut u, mut c) = guess(&swing, half_angle, ends);
    let mut steps = 0;
    let mut found = [None; N];
    loop {
        steps += 1;
        let (y, y_c) = swing.at(c);
        let y2 = y * y;
        let q = c * y2 * y;
        // y'^2 and its derivative by C; a = v^2/D^4.
        let dy2 = y * (1.0 - y + q);
        let dy2_c = (1.0 - 2.0 * y + 4.0 * q) * y_c + y2 * y2;
        let over = dy2.recip();
        let a = rise2 * over;
        let a_c = -a * dy2_c * over;
        let d = 1.0 - u * y;
        let (d2, i) = (d * d, d.recip());
        let yi = y * i;
        let slope = u * (3.0 * u - 2.0);
        let ay4 = 4.0 * a * y;
        // The two equations, and their derivatives by u and C.
        let e = u + slope * yi + 2.0 * a * y2 * d2 - sum;
        let f = c - u * u * (1.0 - u) - a * d2 * d2;
        let e_u = 1.0 + yi * (6.0 * u - 2.0 + slope * yi) - ay4 * y2 * d;
        let e_c = y_c * (slope * i * i + ay4 * d2 - ay4 * yi * d2 * u) + 2.0 * y2 * d2 * a_c;
        let f_u = slope + ay4 * d2 * d;
        let f_c = 1.0 - a_c * d2 * d2 + 4.0 * a * d2 * d * u * y_c;
        let det = e_u * f_c - e_c * f_u;
        let over = det.recip();
        let du = (f * e_c - e * f_c) * over;
        let dc = (e * f_u - f * e_u) * over;
        let scale = c + u * u * u;
        let size = (du * du).zip(scale, |s, m| s - small * small * m).zip(dc.zip(scale, |s, m| s.abs() - small * m), f64::max);
        u = u + du;
        c = c + dc;
        let y = y + y_c * dc;
        // Each orbit keeps what it has when it is found, whatever the others still need.
        let mut all = true;
        for i in 0..N {
            if found[i].is_none() && size.0[i] <= 0.0 {
                found[i] = Some(Middle { u: u.0[i], c: c.0[i], y: y.0[i], determinant: det.0[i], steps });
            }
            all &= found[i].is_some();
        }
        if all || steps == MOST_STEPS {
            return std::array::from_fn(|i| {
                let (u1, u2, half_rise) = (ends.u1.0[i], ends.u2.0[i], ends.half_rise.0[i]);
                found[i].and_then(|m| m.solved(&End { u1, u2, half_rise }, swept.0[i]))
            });
        }
    }
}

/// [`Ends`] of one orbit.
struct End {
    u1: f64,
    u2: f64,
    half_rise: f64,
}

/// An orbit by its middle.
#[derive(Clone, Copy)]
struct Middle {
    u: f64,
    c: f64,
    /// y at half the swept angle.
    y: f64,
    determinant: f64,
    steps: u32,
}

impl Middle {
    /// The ends; `None` if this is not an orbit outside the hole from one to the other.
    #[inline(always)]
    fn solved(&self, ends: &End, swept: f64) -> Option<Solved> {
        let Self { u, c, y, .. } = *self;
        let q = c * y * y * y;
        let dy2 = y * (1.0 - y + q);
        let d = 1.0 - u * y;
        if !(dy2 > 0.0 && d > 0.0 && u > 0.0 && u < 1.0) {
            return None;
        }
        let dy = dy2.sqrt();
        let i = 1.0 / d;
        let middle = ends.half_rise * i / dy;
        // v1, v2 = mean -+ half; v = half_rise D^2/(2 y'), y'' = 1/2 - y + 2 C y^3.
        let mean = middle * ((0.5 - y + 2.0 * q) * d + 2.0 * u * dy2);
        let half = dy * (u * (3.0 * u - 2.0) * i * i + y * middle * middle * d * d * d);
        let (mut v1, mut v2) = (mean - half, mean + half);
        if swept > 2.0 * PI {
            // After windings y'^2 is a small difference, known to some 1e-16. So is v^2 by C: take what is known better.
            let sharp = |u: f64, v: f64| {
                let v_squared = c - u * u * (1.0 - u);
                if v_squared > dy2 * dy2 { v_squared.sqrt().copysign(v) } else { v }
            };
            (v1, v2) = (sharp(ends.u1, v1), sharp(ends.u2, v2));
        }
        let stretch = 4.0 * self.determinant * dy * i * i;
        (stretch > 0.0 && self.is_whole(ends, v1, v2)).then_some(Solved { v1, v2, stretch, steps: self.steps })
    }

    /// Whether the way from one end to the other leads neither through infinity nor through the centre. The equations
    /// have such solutions too: U(phi) is periodic.
    fn is_whole(&self, ends: &End, v1: f64, v2: f64) -> bool {
        let (up1, down1) = (v1 > -SIGN_NOISE * ends.u1, v1 < SIGN_NOISE * ends.u1);
        let (up2, down2) = (v2 > -SIGN_NOISE * ends.u2, v2 < SIGN_NOISE * ends.u2);
        let one_way = if ends.half_rise >= 0.0 { up1 && up2 } else { down1 && down2 };
        // Outside the photon sphere an orbit turns from in to out, inside from out to in; an orbit that crosses it does not turn.
        let turns = if ends.u1 < U_CRITICAL { up1 && down2 } else { down1 && up2 };
        one_way || (turns && self.c < C_CRITICAL + C_NOISE)
    }
}

/// Rounding of slopes, relative to U, and of C: far above what it is, far below what wrong solutions show.
const SIGN_NOISE: f64 = 1e-9;
const C_NOISE: f64 = 1e-12;
