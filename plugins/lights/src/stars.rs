//! `stars`: points of light infinitely far away, from a catalogue or drawn at random.
//!
//! Each star is a black body of its own temperature, as bright as its magnitude says: magnitude 0 is 3.631e-11 W m^-2 nm^-1, weighted by the eye
//! (docs/physics.md, section 16). A picture draws stars as points: along the rays that the integrator finds from the camera to each of them, with
//! the magnification, the shift and the aberration of that ray, without noise. In mirrors and glass they are discs of `radius`; surfaces are lit
//! by light sampling. Cameras whose rays start in several places, and integrators that find no such rays, see the discs.
//!
//! In the space of the light +z is up: the north pole of a catalogue, with right ascension 0 along +x and 90 degrees along -y (the axes of scenes
//! are left-handed: where north is up, right ascensions grow to the left), or the pole of the galaxy of a random sky, whose stars crowd towards
//! the plane z = 0. The current transform turns it.
//!
//! A catalogue is a text of values between commas. Its first line names the columns: `x`, `y`, `z` (a direction of any length), or `ra` and `dec`
//! (degrees); `mag`, or `flux` (W m^-2 nm^-1, weighted by the eye); `temperature` (K), or `ci` (the colour index B-V), which may be left empty.
//! Other columns are passed over; `#` starts a comment.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `filename` | string | none | | a catalogue (CSV); without one the sky is random |
//! | `number` | integer | 10000 | | stars of a random sky: the brightest ones of ours, by number |
//! | `seed` | integer | 0 | | another random sky for each |
//! | `concentration` | float | 4 | | stars per solid angle in the galactic plane of a random sky over those at its poles |
//! | `faintest` | float | none | mag | fainter stars are left out |
//! | `temperature` | float | 6000 | K | of stars whose temperature a catalogue does not tell |
//! | `radius` | float | 0.05 | deg | angular radius of the discs that stand for stars in mirrors and glass |
//! | `scale` | float | 1 | | multiplies what it emits |
//!
//! ```bhs
//! WorldBegin
//! LightSource "stars" "integer number" 20000 "float scale" 1e6
//! ```

mod catalogue;
mod discs;
mod random;

use crate::{scale, sky_from_chart};
use bhs_core::diagnostics::{Diagnostic, Spanned};
use bhs_core::light::{Light, SkySample};
use bhs_core::params::Params;
use bhs_core::plugin::Plugin;
use bhs_core::sampling::Discrete;
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum};
use bhs_elementary::Elementary;
use bhs_spectra::Planck;
use discs::Discs;
use glam::{DMat3, DVec3, Vec2};
use std::f64::consts::{PI, TAU};

/// The entry in the list of lights.
pub const PLUGIN: Plugin<dyn Light> =
    Plugin { name: "stars", summary: "stars, drawn as points: from a catalogue, or a random sky", build };

/// Spectral irradiance of a star of magnitude 0 in the V band [W m^-2 nm^-1] (Bessell, Castelli and Plez 1998, table A2).
const MAGNITUDE_0: f64 = 3.631e-11;

/// More faults of one file than this are not listed: it is the wrong file.
const MOST_FAULTS: usize = 4;

/// A star as catalogues have it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Star {
    /// Unit direction, in the space of the light.
    direction: DVec3,
    /// Irradiance, weighted by the eye [W m^-2 nm^-1].
    irradiance: f64,
    /// Temperature (K), if it is known.
    temperature: Option<f64>,
}

/// The irradiance, weighted by the eye, of a star of a magnitude [W m^-2 nm^-1].
fn irradiance_of(magnitude: f64) -> f64 {
    MAGNITUDE_0 * 10f64.power(-0.4 * magnitude)
}

fn build(p: &Params) -> Option<Box<dyn Light>> {
    let filename = p.optional::<String>("filename", "", "a catalogue (CSV); without one the sky is random");
    let number = p.get_in("number", 10_000, 1..=1_000_000, "", "stars of a random sky: the brightest ones of ours, by number");
    let seed = p.get_in("seed", 0, 0..=i64::from(u32::MAX), "", "another random sky for each");
    let about = "stars per solid angle in the galactic plane of a random sky over those at its poles";
    let concentration = p.get_in("concentration", 4.0, 1.0..=1000.0, "", about);
    let faintest = p.optional::<f64>("faintest", "mag", "fainter stars are left out");
    let unknown = p.get_in("temperature", 6000.0, 100.0..=1e6, "K", "of stars whose temperature a catalogue does not tell");
    let about = "angular radius of the discs that stand for stars in mirrors and glass";
    let radius = p.get_in("radius", 0.05, 1e-4..=10.0, "deg", about).to_radians();
    let scale = scale(p);
    let mut stars = match filename {
        None => random::sky(number as usize, seed as u64, concentration),
        Some(filename) => {
            for name in ["number", "seed", "concentration"].into_iter().filter(|name| p.is_given(name)) {
                p.reject(name, format!("`{name}` and `filename` exclude each other"), "it is of a random sky");
            }
            read(p, filename)?
        }
    };
    stars.retain(|star| faintest.is_none_or(|m| star.irradiance >= irradiance_of(m)));
    if stars.is_empty() {
        let at = if p.is_given("faintest") { "faintest" } else { "filename" };
        p.reject(at, "no star is left", "all are fainter than `faintest`");
    }
    let solid_angle = TAU * (1.0 - radius.cosine());
    let sum: f64 = stars.iter().map(|star| star.irradiance).sum();
    if sum * scale / solid_angle > f64::from(f32::MAX) * 1e-6 {
        p.reject("scale", "the stars are too bright", format!("together they have {:.3e} W m^-2 nm^-1", sum * scale));
        return None;
    }
    let chart_from_sky = sky_from_chart(p)?.transpose();
    Some(Box::new(Stars::new(&stars, &chart_from_sky, Looks { unknown, radius, scale })))
}

/// The stars of a catalogue.
fn read(p: &Params, filename: String) -> Option<Vec<Star>> {
    let path = Spanned::new(filename, p.span_of("filename"));
    let bytes = match p.context().files.read(&path.value, path.span) {
        Ok(bytes) => bytes,
        Err(why) => {
            p.report(Diagnostic::error("unreadable-file", format!("cannot read `{}`: {why}", path.value)).at(path.span, ""));
            return None;
        }
    };
    match catalogue::parse(&bytes) {
        Ok(stars) => Some(stars),
        Err(faults) => {
            let more = if faults.len() > MOST_FAULTS { format!(" ({} faults in all)", faults.len()) } else { String::new() };
            for fault in faults.iter().take(MOST_FAULTS) {
                let message = format!("`{}` is no catalogue of stars: {fault}{more}", path.value);
                p.report(
                    Diagnostic::error("bad-file", message)
                        .at(path.span, "")
                        .help("the first line names the columns, such as `ra,dec,mag,ci`; each other line is a star"),
                );
            }
            None
        }
    }
}

/// What all stars of a light share.
struct Looks {
    /// Temperature of those whose own is unknown (K).
    unknown: f64,
    /// Angular radius of the discs (rad).
    radius: f64,
    /// Multiplies the irradiance.
    scale: f64,
}

struct Stars {
    /// Unit chart directions.
    directions: Vec<DVec3>,
    /// The spectrum of each, and what that is multiplied by: the irradiance over the radiance of the black body.
    spectra: Vec<(Planck, f64)>,
    /// Choice by irradiance.
    choice: Discrete,
    /// Which discs cover a direction.
    discs: Discs,
}

impl Stars {
    fn new(stars: &[Star], chart_from_sky: &DMat3, looks: Looks) -> Self {
        let directions: Vec<DVec3> = stars.iter().map(|star| (*chart_from_sky * star.direction).normalize()).collect();
        let spectrum = |star: &Star| {
            let body = Planck::new(star.temperature.unwrap_or(looks.unknown));
            let seen = luminance(&body);
            // Of a star so cold that the eye sees nothing of it there is no magnitude.
            (body, if seen > 0.0 { looks.scale * star.irradiance / seen } else { 0.0 })
        };
        let choice = Discrete::new(stars.iter().map(|star| star.irradiance));
        let discs = Discs::new(&directions, looks.radius);
        Self { spectra: stars.iter().map(spectrum).collect(), directions, choice, discs }
    }
}

/// What the eye sees of a black body: as [`bhs_spectra::luminance`], from every tenth of its wavelengths, which is enough for curves so smooth.
fn luminance(body: &Planck) -> f64 {
    let (mut seen, mut total) = (0.0, 0.0);
    for [lambda, _, y, _] in bhs_colour::standard_observer().iter().step_by(10) {
        seen += y * body.radiance(*lambda);
        total += y;
    }
    seen / total
}

impl Light for Stars {
    fn sky_radiance(&self, direction: DVec3, lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
        let mut sum = SampledSpectrum::ZERO;
        for star in self.discs.at(direction, &self.directions) {
            sum += self.point_irradiance(star, lambda_nm);
        }
        sum * (1.0 / self.discs.solid_angle()) as f32
    }

    fn sample_sky(&self, u: Vec2) -> Option<SkySample> {
        let (star, rest) = self.choice.sample(u.x)?;
        let direction = self.discs.sample(self.directions[star], Vec2::new(rest, u.y));
        Some(SkySample { direction, pdf: self.sky_pdf(direction), is_parallel: false }).filter(|s| s.pdf > 0.0)
    }

    fn sky_pdf(&self, direction: DVec3) -> f64 {
        let covering = self.discs.at(direction, &self.directions);
        covering.map(|star| self.choice.probability(star)).sum::<f64>() / self.discs.solid_angle()
    }

    fn power(&self, lo: f32, hi: f32, radius: f64) -> f64 {
        // As exact as a choice among lights needs it.
        const WAVELENGTHS: usize = 16;
        let step = f64::from(hi - lo) / WAVELENGTHS as f64;
        let wavelengths: [f64; WAVELENGTHS] = std::array::from_fn(|i| f64::from(lo) + (i as f64 + 0.5) * step);
        let mean = |body: &Planck| wavelengths.iter().map(|l| body.radiance(*l)).sum::<f64>() / WAVELENGTHS as f64;
        PI * radius * radius * self.spectra.iter().map(|(body, factor)| factor * mean(body)).sum::<f64>()
    }

    fn points(&self) -> &[DVec3] {
        &self.directions
    }

    fn point_irradiance(&self, number: usize, lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
        let (body, factor) = &self.spectra[number];
        SampledSpectrum(lambda_nm.map(|l| (factor * body.radiance(f64::from(l))) as f32))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stars() -> Stars {
        let star = |x: f64, y: f64, magnitude, temperature| Star {
            direction: DVec3::new(x, y, 1.0).normalize(),
            irradiance: irradiance_of(magnitude),
            temperature: Some(temperature),
        };
        let all = [star(0.0, 0.0, 0.0, 9700.0), star(0.003, 0.0, 1.0, 3500.0), star(0.5, -0.2, -1.5, 20_000.0)];
        Stars::new(&all, &DMat3::IDENTITY, Looks { unknown: 6000.0, radius: 0.002, scale: 1.0 })
    }

    /// A star's spectrum, as the whole table of the eye weighs it.
    #[test]
    fn stars_are_as_bright_as_their_magnitudes() {
        let stars = stars();
        for (number, magnitude) in [0.0, 1.0, -1.5].into_iter().enumerate() {
            let (mut seen, mut total) = (0.0, 0.0);
            for [lambda, _, y, _] in bhs_colour::standard_observer() {
                seen += y * f64::from(stars.point_irradiance(number, [*lambda as f32; N_LAMBDA])[0]);
                total += y;
            }
            let expected = 3.631e-11 * 100f64.powf(-magnitude / 5.0);
            assert!((seen / total / expected - 1.0).abs() < 1e-5, "{number}: {}", seen / total / expected);
        }
        // Redder and bluer: the ratio of irradiances at two wavelengths is Planck's (Wien's limit within its accuracy).
        let slope = |i| stars.point_irradiance(i, [450.0, 650.0, 550.0, 550.0]).0;
        let [blue, red, ..] = slope(1);
        let wien = (650.0f64 / 450.0).powi(5) * f64::exp(1.438_776_9e7 / 3500.0 * (1.0 / 650.0 - 1.0 / 450.0));
        assert!((f64::from(blue / red) / wien - 1.0).abs() < 5e-3);
    }

    /// The integral of the discs over the sky is the irradiance, and directions are drawn with the density that is said.
    #[test]
    fn discs_hold_the_irradiance_and_are_drawn_with_their_density() {
        let stars = stars();
        let n = 20_000u32;
        let (mut sum, mut inverse) = ([0.0; 2], 0.0);
        for i in 0..n {
            let u = Vec2::new((i as f32 + 0.5) / n as f32, (f64::from(i) * 0.618_033_988_7).fract() as f32);
            let drawn = stars.sample_sky(u).expect("there is light");
            let radiance = stars.sky_radiance(drawn.direction, [550.0, 450.0, 550.0, 550.0]);
            for k in 0..2 {
                sum[k] += f64::from(radiance[k]) / drawn.pdf / f64::from(n);
            }
            inverse += 1.0 / drawn.pdf / f64::from(n);
        }
        for k in 0..2 {
            let total: f64 = (0..3).map(|i| f64::from(stars.point_irradiance(i, [550.0, 450.0, 550.0, 550.0])[k])).sum();
            assert!((sum[k] / total - 1.0).abs() < 2e-3, "{}", sum[k] / total);
        }
        // Solid angle of the union: two discs of radius 2 mrad whose centres are 3 mrad apart overlap in a lens (plane geometry), and one alone.
        let (r, d) = (2.0f64, 3.0f64);
        let lens = 2.0 * r * r * (d / (2.0 * r)).acos() - 0.5 * d * (4.0 * r * r - d * d).sqrt();
        let union = (3.0 * PI * r * r - lens) * 1e-6;
        assert!((inverse / union - 1.0).abs() < 0.02, "{}", inverse / union);
    }

    /// A black body that the eye hardly sees has the brightness of its magnitude, or none.
    #[test]
    fn cold_stars_are_finite() {
        for temperature in [100.0, 500.0, 1e6] {
            let star = Star { direction: DVec3::X, irradiance: 1e-9, temperature: Some(temperature) };
            let stars = Stars::new(&[star], &DMat3::IDENTITY, Looks { unknown: 1.0, radius: 0.1, scale: 1.0 });
            assert!(stars.point_irradiance(0, [400.0, 500.0, 600.0, 700.0]).is_finite(), "{temperature}");
        }
    }
}
