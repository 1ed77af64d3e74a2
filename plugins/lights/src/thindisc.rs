//! `thindisc`: a geometrically thin, optically thick disc of matter that falls slowly into a hole, on circular orbits.
//!
//! What matter loses of its energy on the way in is radiated where it is set free (Novikov and Thorne 1973, Page and Thorne 1974), by both faces,
//! as a black body and by Lambert's law, in the frame of the matter. The stress at the inner edge, the innermost stable orbit, is 0, and
//! nothing emits within. How hot the disc is says `temperature`, that of the hottest ring in its own frame, or `accretionrate` with `mass`.
//! It is meant for a `disk` in the plane of the spin, centred on the hole, that moves as `keplerian` says; a disk without `innerradius` begins
//! at the innermost stable orbit. The current transform does not matter but for `axis`.
//!
//! A texture may modulate it: clouds, arms. It lies on the matter at the coordinate time 0 and turns with it, every ring as fast as its orbit,
//! and light shows it as it was when it left: `time` is when light arrives at the camera. Then light sampling leaves the disc out.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `temperature` | float | 10000 | K | of the hottest ring, in its own frame |
//! | `accretionrate` | float | none | solar masses a year | matter that falls in, instead of `temperature` |
//! | `mass` | float | none | solar masses | mass of the hole, with `accretionrate` |
//! | `hardening` | float | 1 | | colour correction h: the radiance is that of a black body of h T, over h^4 |
//! | `retrograde` | bool | false | | whether it turns the other way: along `-axis x x` |
//! | `axis` | vector3 | that of the spin, or [0 1 0] | | it turns along `axis x x` |
//! | `scale` | float | 1 | | multiplies what it emits |
//! | `modulation` | texture | none | | multiplies the radiance; turns with the matter |
//! | `time` | float | 0 | scene | coordinate time, c = 1: when light arrives at the camera |
//!
//! ```bhs
//! LookAt 0 4 -60  0 0 0  0 1 0
//! WorldBegin
//! BlackHole "schwarzschild" "float rs" 2
//! AreaLightSource "thindisc" "float temperature" 8000 "float scale" 1e-5
//! Rotate -90 1 0 0
//! Shape "disk" "float radius" 30
//! ```

use crate::page_thorne::PageThorne;
use crate::{mean_of, scale};
use bhs_core::diagnostics::Diagnostic;
use bhs_core::light::{AreaLight, Emission, EmissionPoint, Matter};
use bhs_core::material::Shading;
use bhs_core::params::{Params, Vector3};
use bhs_core::plugin::Plugin;
use bhs_core::spacetime::{Axial, Spacetime};
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum};
use bhs_core::texture::{FloatParameter, Texture};
use bhs_elementary::{Elementary, rotation};
use bhs_spectra::{HOTTEST, Planck};
use glam::DVec3;
use std::f64::consts::PI;
use std::sync::Arc;

/// The entry in the list of area lights.
pub const PLUGIN: Plugin<dyn AreaLight> = Plugin { name: "thindisc", summary: "a thin disc of matter around a hole", build };

/// Speed of light (m/s), exact.
const C: f64 = 299_792_458.0;
/// Mass parameter of the sun (m^3/s^2): nominal, resolution B3 of the IAU of 2015.
const GM_SUN: f64 = 1.327_124_4e20;
/// Constant of gravitation (m^3 kg^-1 s^-2): CODATA 2018.
const G: f64 = 6.674_30e-11;
/// Stefan and Boltzmann's constant (W m^-2 K^-4): CODATA 2018.
const SIGMA: f64 = 5.670_374_419e-8;
/// A year of 365.25 days (s).
const YEAR: f64 = 31_557_600.0;

/// A place counts as one of the plane of the disc if its height over it is at most this share of its distance from the hole.
const OFF_PLANE: f64 = 1e-3;

/// How hot the disc is.
#[derive(Clone, Copy, Debug)]
enum Heat {
    /// Temperature of the hottest ring (K).
    Hottest(f64),
    /// The temperature (K) where the flux is 1 in units of [`PageThorne::flux`].
    Unit(f64),
}

struct ThinDisc {
    heat: Heat,
    hardening: f64,
    retrograde: bool,
    axis: Option<DVec3>,
    scale: f64,
    modulation: Option<Arc<dyn Texture>>,
    time: f64,
    bound: Option<Bound>,
}

/// What is known once the spacetime is.
struct Bound {
    hole: Axial,
    /// Unit vector: the disc turns along `axis x x`, or along its opposite.
    axis: DVec3,
    /// -1 if it turns the other way.
    sense: f64,
    orbits: PageThorne,
    /// The temperature (K) where the flux is 1 in units of [`PageThorne::flux`].
    unit: f64,
}

fn build(p: &Params) -> Option<Box<dyn AreaLight>> {
    let about = "of the hottest ring, in its own frame";
    let temperature = p.get_in("temperature", 10_000.0, 1.0..=HOTTEST, "K", about);
    let heat = match accretion(p) {
        Some(unit) => Heat::Unit(unit),
        None => Heat::Hottest(temperature),
    };
    let about = "colour correction h: the radiance is that of a black body of h T, over h^4";
    let hardening = p.get_in("hardening", 1.0, 0.1..=100.0, "", about);
    let retrograde = p.get("retrograde", false, "", "whether it turns the other way: along `-axis x x`");
    let axis = p.optional::<Vector3>("axis", "", "it turns along `axis x x`; by default the axis of the spin, or +y");
    let scale = scale(p);
    let about = "a texture of numbers; multiplies the radiance, and turns with the matter";
    let modulation = p.optional_float_parameter("modulation", 0.0..=f64::from(f32::MAX), "", about);
    let time = p.get_in("time", 0.0, -1e15..=1e15, "scene", "coordinate time, c = 1: when light arrives at the camera");
    let transform = p.context().world_from_object;
    let axis = match axis {
        Some(axis) => {
            // What a transform mirrors turns the other way.
            let turned = axis.0.try_normalize().and_then(|a| transform.transform_vector3(a).try_normalize());
            if turned.is_none() {
                p.reject("axis", "`axis` has no direction", "expected a vector that is not 0");
            }
            Some(turned? * transform.matrix3.determinant().signum())
        }
        None => None,
    };
    let (scale, modulation) = match modulation {
        Some(FloatParameter::Constant(factor)) => (scale * f64::from(factor), None),
        Some(FloatParameter::Texture { texture, .. }) => (scale, Some(texture)),
        None => (scale, None),
    };
    Some(Box::new(ThinDisc { heat, hardening, retrograde, axis, scale, modulation, time, bound: None }))
}

/// The temperature (K) where the flux is 1 in units of [`PageThorne::flux`], if the scene gives the rate of accretion.
fn accretion(p: &Params) -> Option<f64> {
    let rate = p.optional::<f64>("accretionrate", "solar masses a year", "matter that falls in, instead of `temperature`");
    let mass = p.optional::<f64>("mass", "solar masses", "mass of the hole, with `accretionrate`");
    if rate.is_some() && p.is_given("temperature") {
        p.reject("accretionrate", "`temperature` and `accretionrate` exclude each other", "each says how hot the disc is");
    }
    for (name, value, other) in [("accretionrate", rate, "mass"), ("mass", mass, "accretionrate")] {
        let Some(value) = value else { continue };
        if !(value > 0.0 && value.is_finite()) {
            p.reject(name, format!("`{name}` must be above 0"), format!("found {value}"));
        }
        if !p.is_given(other) {
            p.report(
                Diagnostic::error("missing-parameter", format!("`{name}` needs `{other}`"))
                    .at(p.span_of(name), "")
                    .help("the temperature follows from both; or give `temperature` instead"),
            );
        }
    }
    // What is wrong has been reported.
    let (rate, mass) = (rate.filter(|r| *r > 0.0)?, mass.filter(|m| *m > 0.0)?);
    let length = GM_SUN * mass / (C * C);
    let kilograms = rate * GM_SUN / G / YEAR;
    let flux = kilograms * C * C / (4.0 * PI * length * length);
    Some((flux / SIGMA).sqrt().sqrt())
}

impl Bound {
    /// Temperature (K) at a point, in the frame of the matter; 0 where nothing emits.
    fn temperature(&self, point: DVec3) -> f64 {
        let r = self.hole.radius(point, self.axis) / self.hole.mass;
        self.unit * self.orbits.flux(r).sqrt().sqrt()
    }

    /// Angular velocity at a point, against coordinate time, along `axis x x`.
    fn omega(&self, point: DVec3) -> f64 {
        self.sense * self.orbits.omega(self.hole.radius(point, self.axis) / self.hole.mass) / self.hole.mass
    }
}

impl ThinDisc {
    /// The radiance of a face at a point, without its modulation.
    fn black_body(&self, bound: &Bound, point: DVec3, lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
        let temperature = self.hardening * bound.temperature(point);
        if temperature <= 0.0 {
            return SampledSpectrum::ZERO;
        }
        let (body, factor) = (Planck::new(temperature), self.scale / self.hardening.powi(4));
        SampledSpectrum(lambda_nm.map(|l| (body.radiance(f64::from(l)) * factor) as f32))
    }
}

impl AreaLight for ThinDisc {
    fn radiance(&self, at: &Emission) -> SampledSpectrum {
        let Some(bound) = self.bound.as_ref().filter(|_| at.cos_theta != 0.0) else { return SampledSpectrum::ZERO };
        let radiance = self.black_body(bound, at.point, at.lambda_nm);
        match &self.modulation {
            Some(texture) => radiance * texture.float(&Shading::at_uv(at.uv, at.lambda_nm)).clamp(0.0, f32::MAX),
            None => radiance,
        }
    }

    fn exitance(&self, at: &EmissionPoint, lo: f32, hi: f32) -> f64 {
        let Some(bound) = &self.bound else { return 0.0 };
        2.0 * PI * mean_of(|lambda_nm| self.black_body(bound, at.point, lambda_nm), lo, hi)
    }

    fn is_uniform(&self) -> bool {
        false
    }

    fn bind(&mut self, spacetime: &dyn Spacetime) -> Result<(), String> {
        let hole = spacetime.axial().filter(|h| h.mass > 0.0);
        let hole = hole.ok_or("matter circles a single hole that is round or spins; there is none")?;
        let sense = if self.retrograde { -1.0 } else { 1.0 };
        // As the motion `keplerian` has it: the sense of the spin is that about the axis that is stated.
        let (axis, spin) = match (self.axis, hole.axis) {
            (given, None) => (given.unwrap_or(DVec3::Y), 1.0),
            (None, Some(axis)) => (axis, 1.0),
            (Some(given), Some(axis)) if given.dot(axis).abs() > 1.0 - 1e-9 => (given, given.dot(axis).signum()),
            _ => return Err("a hole that spins has one axis: leave `axis` out, or give that of the spin".to_owned()),
        };
        let (a, mass) = (sense * spin * hole.a / hole.mass, hole.mass);
        let orbits = PageThorne::new(a, hole.charge_squared / (mass * mass));
        let unit = match self.heat {
            Heat::Unit(unit) => unit,
            Heat::Hottest(temperature) => temperature / orbits.greatest_flux().sqrt().sqrt(),
        };
        let bound = Bound { hole, axis, sense, orbits, unit };
        let hottest = self.hardening * bound.unit * bound.orbits.greatest_flux().sqrt().sqrt();
        if hottest > HOTTEST || hottest.is_nan() {
            return Err(format!("its hottest ring has {hottest:.3e} K; hotter than {HOTTEST:e} K is not supported"));
        }
        // The peak of Planck's curve.
        let body = Planck::new(hottest);
        let brightest = self.scale / self.hardening.powi(4) * f64::from(body.max(0.0, f32::MAX));
        if brightest > f64::from(f32::MAX) || brightest.is_nan() {
            return Err(format!("times `scale` it is {brightest:.3e}, and light is at most {:.3e}", f32::MAX));
        }
        self.bound = Some(bound);
        Ok(())
    }

    fn inner_edge(&self) -> Option<f64> {
        let Bound { hole, orbits, .. } = self.bound.as_ref()?;
        Some((orbits.isco() * hole.mass).hypotenuse(hole.a))
    }

    fn matter(&self, point: DVec3) -> Matter {
        let Some(bound) = &self.bound else { return Matter::Any };
        let x = point - bound.hole.center;
        if x.dot(bound.axis).abs() > OFF_PLANE * x.length() {
            return Matter::Elsewhere;
        }
        Matter::Moving(bound.axis.cross(x) * bound.omega(point))
    }

    fn depends_on_time(&self) -> bool {
        self.modulation.is_some()
    }

    fn at_time_zero(&self, point: DVec3, time: f64) -> DVec3 {
        let Some(bound) = &self.bound else { return point };
        let back = rotation(bound.axis, -bound.omega(point) * (self.time + time));
        bound.hole.center + back * (point - bound.hole.center)
    }
}
