//! Thin discs of matter on circular orbits around a hole, and the flux that they radiate (`docs/physics.md`, section 11).
//!
//! Lengths are in units of the hole's mass: M = 1. The disc turns along +phi; a hole with `a < 0` spins against it.
//! Sources: Bardeen, Press and Teukolsky 1972 (orbits); Novikov and Thorne 1973, Page and Thorne 1974, eqs. 11, 12 and 15n (flux); with charge,
//! orbits in the field `2 M r - q^2` in place of `2 M r`.

use bhs_elementary::Elementary;
use std::f64::consts::PI;

/// The disc around one hole.
#[derive(Clone, Debug)]
pub struct PageThorne {
    a: f64,
    charge_squared: f64,
    isco: f64,
    /// The greatest flux.
    greatest: f64,
    /// With charge: the integral of the conserved fluxes up to each of the radii `isco exp(k STEP)`.
    integrals: Vec<f64>,
}

/// Quotient of radii between which one rule of quadrature is exact to some 14 digits, as a logarithm.
const STEP: f64 = 0.25;

/// Steps of the table of integrals: beyond, the last piece is longer.
const STEPS: usize = 48;

/// A circular orbit, and what changes with its radius.
struct Orbit {
    d_omega: f64,
    /// `E - Omega L`, which is `1 / u^t`
    per_ut: f64,
    d_l: f64,
}

impl PageThorne {
    /// Around the hole of the given spin, at most 1 either way, and square of charge; `a^2 + q^2` is at most 1.
    pub fn new(a: f64, charge_squared: f64) -> Self {
        let isco = if charge_squared == 0.0 { isco(a) } else { charged_isco(a, charge_squared) };
        let mut disc = Self { a, charge_squared, isco, greatest: 0.0, integrals: Vec::new() };
        if charge_squared > 0.0 {
            let mut sum = 0.0;
            disc.integrals.push(sum);
            for k in 0..STEPS {
                sum += disc.integral(k as f64 * STEP, (k + 1) as f64 * STEP);
                disc.integrals.push(sum);
            }
        }
        disc.greatest = disc.hottest().1;
        disc
    }

    /// Radius of the innermost stable circular orbit.
    pub fn isco(&self) -> f64 {
        self.isco
    }

    /// The greatest flux, as [`PageThorne::flux`] has it.
    pub fn greatest_flux(&self) -> f64 {
        self.greatest
    }

    /// Angular velocity of the circular orbit at `r`, against coordinate time.
    pub fn omega(&self, r: f64) -> f64 {
        let s = (r - self.charge_squared).max(0.0).sqrt();
        s / (r * r + self.a * s)
    }

    /// `f(r)`: the flux of one face, in the frame of the disc, is `Mdot / (4 pi M^2) f`. 0 within the innermost stable orbit.
    pub fn flux(&self, r: f64) -> f64 {
        // Not so for what is not a number.
        if !(r > self.isco && r.is_finite()) {
            return 0.0;
        }
        let flux = if self.charge_squared == 0.0 { self.closed_form(r) } else { self.by_quadrature(r) };
        flux.max(0.0)
    }

    /// Page and Thorne 1974, eq. 15n.
    fn closed_form(&self, r: f64) -> f64 {
        let a = self.a;
        let (x, x0) = (r.sqrt(), self.isco.sqrt());
        let third = a.clamp(-1.0, 1.0).arccosine() / 3.0;
        let [x1, x2, x3] = [2.0 * (third - PI / 3.0).cosine(), 2.0 * (third + PI / 3.0).cosine(), -2.0 * third.cosine()];
        let term = |i: f64, j: f64, k: f64| {
            // Without spin one of the roots is 0, and its term too.
            if i == 0.0 { 0.0 } else { 3.0 * (i - a) * (i - a) / (i * (i - j) * (i - k)) * ((x - x0) / (x0 - i)).logarithm_1p() }
        };
        let bracket = x - x0 - 1.5 * a * (x / x0).logarithm() - term(x1, x2, x3) - term(x2, x3, x1) - term(x3, x1, x2);
        1.5 / (x.powi(4) * (x.powi(3) - 3.0 * x + 2.0 * a)) * bracket
    }

    /// Page and Thorne 1974, eq. 12 with the determinant `r` of the equatorial metric: of any such hole.
    fn by_quadrature(&self, r: f64) -> f64 {
        let along = (r / self.isco).logarithm();
        let whole = ((along / STEP) as usize).min(self.integrals.len().saturating_sub(1));
        let before = self.integrals.get(whole).copied().unwrap_or(0.0);
        let mut integral = before;
        // At most one step within the table.
        let mut from = whole as f64 * STEP;
        while from < along {
            let to = (from + STEP).min(along);
            integral += self.integral(from, to);
            from = to;
        }
        let orbit = self.orbit(r);
        -orbit.d_omega / (r * orbit.per_ut * orbit.per_ut) * integral
    }

    /// The integral of `(E - Omega L) L'` between the radii `isco exp(from)` and `isco exp(to)`: Gauss and Legendre's rule of 16 points.
    fn integral(&self, from: f64, to: f64) -> f64 {
        const POINTS: [(f64, f64); 8] = [
            (0.095_012_509_837_637_44, 0.189_450_610_455_068_5),
            (0.281_603_550_779_258_9, 0.182_603_415_044_923_6),
            (0.458_016_777_657_227_37, 0.169_156_519_395_002_54),
            (0.617_876_244_402_643_7, 0.149_595_988_816_576_73),
            (0.755_404_408_355_003, 0.124_628_971_255_533_87),
            (0.865_631_202_387_831_7, 0.095_158_511_682_492_78),
            (0.944_575_023_073_232_6, 0.062_253_523_938_647_89),
            (0.989_400_934_991_649_9, 0.027_152_459_411_754_095),
        ];
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let at = |y: f64| {
            let r = self.isco * y.exponential();
            let orbit = self.orbit(r);
            orbit.per_ut * orbit.d_l * r
        };
        let sum: f64 = POINTS.iter().map(|(x, weight)| weight * (at(middle - half * x) + at(middle + half * x))).sum();
        sum * half
    }

    fn orbit(&self, r: f64) -> Orbit {
        let (a, q2) = (self.a, self.charge_squared);
        let s = (r - q2).sqrt();
        let (ds, m) = (0.5 / s, 2.0 * r - q2);
        let nearly = r * r + a * s;
        let d_omega = (ds * r * r - 2.0 * r * s) / (nearly * nearly);
        let p = (r * r - 3.0 * r + 2.0 * q2 + 2.0 * a * s).max(0.0).sqrt();
        let dp = (2.0 * r - 3.0 + 2.0 * a * ds) / (2.0 * p);
        let per_ut = r * p / nearly;
        // L = n / (r p)
        let n = s * (r * r + a * a) - a * m;
        let dn = ds * (r * r + a * a) + 2.0 * r * s - 2.0 * a;
        let d_l = (dn * r * p - n * (p + r * dp)) / (r * r * p * p);
        Orbit { d_omega, per_ut, d_l }
    }

    /// Energy at infinity of unit mass on the circular orbit at `r`.
    #[cfg(test)]
    fn energy(&self, r: f64) -> f64 {
        let s = (r - self.charge_squared).sqrt();
        let p = (r * r - 3.0 * r + 2.0 * self.charge_squared + 2.0 * self.a * s).sqrt();
        (r * r + self.a * s - 2.0 * r + self.charge_squared) / (r * p)
    }

    /// Radius and value of the greatest flux, by golden section: it rises to it and falls after it.
    fn hottest(&self) -> (f64, f64) {
        const GOLDEN: f64 = 0.618_033_988_749_894_9;
        let (mut low, mut high) = (self.isco.logarithm(), (8.0 * self.isco).logarithm());
        let at = |y: f64| self.flux(y.exponential());
        let (mut c, mut d) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
        let (mut at_c, mut at_d) = (at(c), at(d));
        for _ in 0..60 {
            if at_c > at_d {
                (high, d, at_d) = (d, c, at_c);
                c = high - GOLDEN * (high - low);
                at_c = at(c);
            } else {
                (low, c, at_c) = (c, d, at_d);
                d = low + GOLDEN * (high - low);
                at_d = at(d);
            }
        }
        let r = (0.5 * (low + high)).exponential();
        (r, self.flux(r).max(at_c).max(at_d))
    }
}

/// Bardeen, Press and Teukolsky 1972, eq. 2.21.
fn isco(a: f64) -> f64 {
    let z1 = 1.0 + (1.0 - a * a).max(0.0).cube_root() * ((1.0 + a).cube_root() + (1.0 - a).cube_root());
    let z2 = (3.0 * a * a + z1 * z1).sqrt();
    let root = ((3.0 - z1) * (3.0 + z1 + 2.0 * z2)).max(0.0).sqrt();
    3.0 + z2 - if a < 0.0 { -root } else { root }
}

/// Where the angular momentum of circular orbits is least.
fn charged_isco(a: f64, charge_squared: f64) -> f64 {
    let disc = PageThorne { a, charge_squared, isco: 1.0, greatest: 0.0, integrals: Vec::new() };
    // Of the orbits that matter the innermost is that of light, of which `p` is 0.
    let stable = |r: f64| {
        let s = (r - charge_squared).max(0.0).sqrt();
        r * r - 3.0 * r + 2.0 * charge_squared + 2.0 * a * s > 0.0 && disc.orbit(r).d_l > 0.0
    };
    let (mut low, mut high) = (1.0 + (1.0 - a * a - charge_squared).max(0.0).sqrt(), 9.5);
    for _ in 0..100 {
        let r = 0.5 * (low + high);
        if stable(r) {
            high = r;
        } else {
            low = r;
        }
    }
    high
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Spin against the disc, ISCO, efficiency, radius and value of the greatest flux, flux at 10.
    const TABLE: [(f64, f64, f64, f64, f64, f64); 4] = [
        (0.0, 6.0, 0.057_190_958_417_936_6, 9.550_928_1, 1.718_842_098_7e-4, 1.705_099_995_57e-4),
        (0.5, 4.233_002_529_530_83, 0.082_117_993_339_224_3, 6.615_087_6, 5.358_939_9e-4, 3.439_068_053_38e-4),
        (0.9, 2.320_883_041_761_89, 0.155_752_991_994_464, 3.441_843_4, 4.262_872_624e-3, 6.037_096_399_01e-4),
        (0.998, 1.236_970_655_175_18, 0.320_994_165_616_199, 1.581_184_58, 6.008_724_036e-2, 7.628_535_071_88e-4),
    ];

    fn near(found: f64, wanted: f64, relative: f64) -> bool {
        (found / wanted - 1.0).abs() < relative
    }

    #[test]
    fn orbits_and_fluxes_are_those_of_the_table() {
        for (a, isco, efficiency, hottest, greatest, at_ten) in TABLE {
            let disc = PageThorne::new(a, 0.0);
            assert!(near(disc.isco(), isco, 1e-13), "{a}: {}", disc.isco());
            assert!(near(1.0 - disc.energy(disc.isco()), efficiency, 1e-12), "{a}: {}", disc.energy(disc.isco()));
            assert!(near(disc.hottest().0, hottest, 1e-7), "{a}: {}", disc.hottest().0);
            assert!(near(disc.greatest_flux(), greatest, 1e-7), "{a}: {}", disc.greatest_flux());
            assert!(near(disc.flux(10.0), at_ten, 2e-12), "{a}: {}", disc.flux(10.0));
            assert_eq!((disc.flux(disc.isco()), disc.flux(0.99 * isco), disc.flux(f64::NAN)), (0.0, 0.0, 0.0));
        }
        for (a, isco) in [(-0.5, 7.554_584_714_512_36), (-0.9, 8.717_352_279_606_49), (-0.998, 8.994_374_454_803_57)] {
            assert!(near(PageThorne::new(a, 0.0).isco(), isco, 1e-13));
        }
        assert!(near(PageThorne::new(0.3, 0.0).omega(10.0), 1.0 / (10f64.powf(1.5) + 0.3), 1e-14));
    }

    /// The same fluxes by another route: what is conserved, integrated, with derivatives by formulas of other orbits.
    #[test]
    fn the_closed_form_is_the_integral_of_conserved_fluxes() {
        for a in [-0.998, -0.5, 0.0, 1e-9, 0.5, 0.9, 0.998] {
            let disc = PageThorne::new(a, 0.0);
            for over in [1.1, 1.5, 3.0, 20.0, 1000.0] {
                let r = disc.isco() * over;
                let (closed, integral) = (disc.closed_form(r), disc.by_quadrature(r));
                assert!(near(closed, integral, 1e-12), "{a} {r}: {closed} {integral}");
            }
        }
    }

    /// All energy that is set free is radiated: twice the flux of a face, `2 pi r` a ring, `E` a unit of energy in its frame (the
    /// energy `1/u^t` and the angular momentum of the light, averaged over directions, add up to `E`).
    #[test]
    fn what_is_radiated_is_the_binding_energy_of_the_innermost_orbit() {
        for (a, q2) in
            [(0.0, 0.0), (0.5, 0.0), (0.9, 0.0), (0.998, 0.0), (-0.5, 0.0), (-0.998, 0.0), (0.0, 0.5), (0.6, 0.3), (-0.4, 0.6)]
        {
            let disc = PageThorne::new(a, q2);
            // In ln r by Gauss's rule again; from 1e11 on, f = 3/(2 r^3) and E = 1 up to terms of half an order more.
            let (isco, pieces) = (disc.isco(), 8000);
            let end = 1e11f64;
            let (mut sum, step) = (0.0, (end / isco).ln() / f64::from(pieces));
            let nodes = [(-(0.6f64.sqrt()), 5.0 / 9.0), (0.0, 8.0 / 9.0), (0.6f64.sqrt(), 5.0 / 9.0)];
            for i in 0..pieces {
                for (x, weight) in nodes {
                    let r = isco * ((f64::from(i) + 0.5 + 0.5 * x) * step).exp();
                    sum += 0.5 * weight * step * r * r * disc.flux(r) * disc.energy(r);
                }
            }
            sum += 1.5 / end;
            let efficiency = 1.0 - disc.energy(isco);
            assert!(near(sum, efficiency, 1e-12), "{a} {q2}: {sum} {efficiency} {:e}", sum / efficiency - 1.0);
        }
    }

    /// Against the polynomial of which the innermost stable orbit of a charged hole is a root.
    #[test]
    fn charged_holes_have_their_innermost_orbit() {
        for (a, q2) in [(0.0, 0.25), (0.0, 0.9), (0.5, 0.3), (-0.5, 0.3), (0.8, 0.09), (-0.8, 0.35)] {
            let r = PageThorne::new(a, q2).isco();
            let polynomial = r * (6.0 * r - r * r - 9.0 * q2 + 3.0 * a * a) + 4.0 * q2 * (q2 - a * a);
            let zero = polynomial - 8.0 * a * (r - q2).powf(1.5);
            assert!(zero.abs() < 1e-9, "{a} {q2}: {r} {zero}");
        }
        let (little, none) = (PageThorne::new(0.7, 1e-13), PageThorne::new(0.7, 0.0));
        assert!(near(little.flux(9.0), none.flux(9.0), 1e-11) && near(little.greatest_flux(), none.greatest_flux(), 1e-11));
    }
}
