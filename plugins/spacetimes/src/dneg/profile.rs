//! The areal radius of the wormhole as a function of proper length, and the isotropic radius that belongs to it. Lengths are in units of the
//! throat's areal radius.

use bhs_elementary::Elementary;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

/// How small the throat may be drawn. Beyond it coordinates lose their digits.
const LEAST_DRAWN: f64 = 1e-5;

/// Least lensing width.
const LEAST_WIDTH: f64 = 1e-5;

/// The lensing width over `m`: where dr/dl is about 1/sqrt(2). It is defined by these digits (James et al. 2015), not by the slope.
const WIDTH_PER_M: f64 = 1.42953;

/// Panels of the integral below: each is as long as all before it.
const PANELS: usize = 70;

/// Half of the nodes of Gauss and Legendre's quadrature with 20 of them, and their weights: place, weight.
type Nodes = [(f64, f64); 10];

/// Beyond the cylinder, `|l| > half`: `r = 1 + m (x atan x - ln(1 + x^2) / 2)` with `x = 2 (|l| - half) / (pi m)`.
#[derive(Clone, Debug)]
pub struct Profile {
    half: f64,
    m: f64,
    nodes: Nodes,
    /// Length in x of the first panel.
    first: f64,
    /// Logarithm of the index where each panel begins: an integral over all that is beyond.
    from: [f64; PANELS + 1],
    /// The same integral from 0 to there.
    to: [f64; PANELS + 1],
}

impl Profile {
    /// Half the length of the cylinder and the lensing width: about `r - 1` where `dr/dl = 1/sqrt(2)`.
    ///
    /// # Errors
    /// Which length cannot be drawn, by the name of its parameter, and why.
    pub fn new(half: f64, width: f64) -> Result<Self, (&'static str, String)> {
        if width < LEAST_WIDTH {
            return Err(("lensingwidth", format!("expected at least {LEAST_WIDTH} of `throat`, found {width:e} of it")));
        }
        let m = width / WIDTH_PER_M;
        // Half of the distance from x = 0 to where 1/r or the arc tangent is singular.
        let first = 0.25 * (2.0 / m).sqrt().min(1.0);
        let mut profile = Self { half, m, nodes: gauss_legendre(), first, from: [0.0; PANELS + 1], to: [0.0; PANELS + 1] };
        profile.from[PANELS] = std::f64::consts::FRAC_2_PI / profile.edge(PANELS);
        for i in (0..PANELS).rev() {
            profile.from[i] = profile.from[i + 1] + profile.piece(profile.edge(i), profile.edge(i + 1));
        }
        for i in 0..PANELS {
            profile.to[i + 1] = profile.to[i] + profile.piece(profile.edge(i), profile.edge(i + 1));
        }
        let too_small = |what: f64| what < LEAST_DRAWN;
        if too_small(profile.cylinder_end()) {
            let drawn = profile.cylinder_end();
            let cause =
                format!("so wide that the throat would be drawn {drawn:.1e} times its size; choose less than 15 times `throat`");
            return Err(("lensingwidth", cause));
        }
        if too_small(profile.throat()) {
            let drawn = profile.throat();
            let cause =
                format!("so long that the throat would be drawn {drawn:.1e} times its size; choose less than 15 times `throat`");
            return Err(("length", cause));
        }
        Ok(profile)
    }

    /// Mass-like length `M` of the mouths.
    pub fn m(&self) -> f64 {
        self.m
    }

    /// Isotropic radius where the cylinder ends.
    pub fn cylinder_end(&self) -> f64 {
        (-self.from[0]).exponential()
    }

    /// Isotropic radius in the middle of the throat.
    pub fn throat(&self) -> f64 {
        (-self.from[0] - self.half).exponential()
    }

    /// Isotropic radius at the proper length `l` from the middle.
    pub fn chart_radius(&self, l: f64) -> f64 {
        if l < self.half {
            return self.throat() * l.exponential();
        }
        self.log_rho((l - self.half) / (FRAC_PI_2 * self.m)).exponential()
    }

    /// Areal radius.
    pub fn radius(&self, x: f64) -> f64 {
        1.0 + self.rise(x)
    }

    /// What the areal radius has beyond the throat's.
    fn rise(&self, x: f64) -> f64 {
        self.m * (x * x.arctangent() - 0.5 * (x * x).logarithm_1p())
    }

    /// Logarithm of the isotropic radius: `d ln rho = dl / r`, and `rho / r` tends to 1 far away.
    pub fn log_rho(&self, x: f64) -> f64 {
        self.radius(x).logarithm() - self.log_index(x)
    }

    /// The same less its value at 0, with no loss of digits near there.
    pub fn log_growth(&self, x: f64) -> f64 {
        let panel = self.panel(x);
        self.rise(x).logarithm_1p() + self.to[panel] + self.piece(self.edge(panel), x)
    }

    /// Logarithm of the index `r / rho`: the integral of `(1 - dr/dl) / r` over all lengths beyond.
    pub fn log_index(&self, x: f64) -> f64 {
        if x >= self.edge(PANELS) {
            return std::f64::consts::FRAC_2_PI / x;
        }
        let panel = self.panel(x);
        self.from[panel + 1] + self.piece(x, self.edge(panel + 1))
    }

    fn panel(&self, x: f64) -> usize {
        let panel = if x < self.first { 0 } else { 1 + (x / self.first).logarithm2().floor() as usize };
        panel.min(PANELS - 1)
    }

    /// The same from `a` to `b`, at most one panel.
    fn piece(&self, a: f64, b: f64) -> f64 {
        let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
        let f = |x: f64| 1.0_f64.arctangent2(x) / self.radius(x);
        let sum: f64 = self.nodes.iter().map(|(t, weight)| weight * (f(middle - half * t) + f(middle + half * t))).sum();
        self.m * half * sum
    }

    /// Where panel `i` begins.
    fn edge(&self, i: usize) -> f64 {
        if i == 0 { 0.0 } else { self.first * f64::powi(2.0, i as i32 - 1) }
    }
}

/// Positive roots of the Legendre polynomial of degree 20, by Newton's iteration, and their weights.
fn gauss_legendre() -> Nodes {
    const DEGREE: usize = 20;
    std::array::from_fn(|i| {
        let mut t = ((4 * i + 3) as f64 * FRAC_PI_4 / (DEGREE as f64 + 0.5)).cosine();
        let mut slope = 1.0;
        for _ in 0..8 {
            let (mut last, mut p) = (1.0, t);
            for n in 2..=DEGREE {
                let n = n as f64;
                (last, p) = (p, ((2.0 * n - 1.0) * t * p - (n - 1.0) * last) / n);
            }
            slope = DEGREE as f64 * (t * p - last) / (t * t - 1.0);
            t -= p / slope;
        }
        (t, 2.0 / ((1.0 - t * t) * slope * slope))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radii_are_as_published() {
        let profile = Profile::new(0.5, 0.1).unwrap();
        // 30 digits by another quadrature.
        assert!((profile.throat() - 0.472_889_457_727_289_4).abs() < 1e-15, "{}", profile.throat());
        assert!((profile.chart_radius(3.0) - 3.132_858_478_417_709_6).abs() < 2e-15, "{}", profile.chart_radius(3.0));
        assert!((profile.chart_radius(0.5) / profile.cylinder_end() - 1.0).abs() < 1e-15);
        // The width is where the wall leans by 45 degrees: dr/dl by finite differences.
        let l = |x: f64| FRAC_PI_2 * profile.m() * x;
        let x = (FRAC_PI_2 * std::f64::consts::FRAC_1_SQRT_2).tan();
        assert!((profile.radius(x) - 1.1).abs() < 1e-6);
        let h = 1e-5;
        let slope = (profile.radius(x + h) - profile.radius(x - h)) / (l(x + h) - l(x - h));
        assert!((slope - std::f64::consts::FRAC_1_SQRT_2).abs() < 1e-9);
    }

    #[test]
    fn twenty_nodes_are_exact_to_degree_39() {
        let nodes = gauss_legendre();
        for k in [0, 2, 12, 38] {
            let sum: f64 = nodes.iter().map(|(t, w)| 2.0 * w * t.powi(k)).sum();
            assert!((sum - 2.0 / f64::from(k + 1)).abs() < 1e-14, "{k}: {sum}");
        }
    }

    #[test]
    fn the_isotropic_radius_grows_as_length_over_areal_radius() {
        for (half, width) in [(0.5, 0.1), (0.0, 1e-4), (2.0, 1.0), (0.1, 8.0)] {
            let profile = Profile::new(half, width).unwrap();
            for x in [0.01, 0.3, 1.0, 4.0, 100.0, 1e6] {
                let h = 1e-3 * x;
                let d = |h: f64| (profile.log_rho(x + h) - profile.log_rho(x - h)) / (2.0 * h);
                let slope = (4.0 * d(0.5 * h) - d(h)) / 3.0;
                let right = FRAC_PI_2 * profile.m() / profile.radius(x);
                assert!((slope - right).abs() < 1e-10 * right + 1e-13 / h, "{half} {width} {x}: {slope} {right}");
            }
            // Far away the index tends to 1 as 1 + M/l.
            let x = 1e12;
            assert!((profile.log_index(x) * x * FRAC_PI_2 - 1.0).abs() < 1e-7);
        }
    }

    #[test]
    fn what_cannot_be_drawn_is_told() {
        assert_eq!(Profile::new(0.5, 1e-9).unwrap_err().0, "lensingwidth");
        assert_eq!(Profile::new(0.5, 1e3).unwrap_err().0, "lensingwidth");
        assert_eq!(Profile::new(40.0, 0.1).unwrap_err().0, "length");
    }
}
