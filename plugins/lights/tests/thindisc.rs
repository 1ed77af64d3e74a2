//! The thin disc radiates as Page and Thorne's flux and Planck's law say, and carries its pattern around.

use bhs_core::diagnostics::{Diagnostic, Span, Spanned};
use bhs_core::image::Image;
use bhs_core::light::{AreaLight, Emission, EmissionPoint};
use bhs_core::material::{Material, Shading};
use bhs_core::params::{Context, Files, Named, Params, SpectrumSource};
use bhs_core::spacetime::{Kerr, Minkowski, Spacetime, Spherical};
use bhs_core::spectrum::{SampledSpectrum, Spectrum, SpectrumRole};
use bhs_core::texture::{Texture, TextureKind};
use bhs_core::value::{Param, ParamType, Values};
use glam::{DAffine3, DVec3, Vec2};
use std::f64::consts::PI;
use std::sync::Arc;

/// A texture of the numbers u.
struct Gradient;

impl Texture for Gradient {
    fn spectrum(&self, _: &Shading) -> SampledSpectrum {
        SampledSpectrum::ZERO
    }
    fn float(&self, at: &Shading) -> f32 {
        at.uv.x
    }
}

/// A scene that has nothing but that texture.
struct Things;

impl Named for Things {
    fn texture(&self, _: &Spanned<String>, kind: TextureKind, _: &Context) -> Result<Arc<dyn Texture>, Box<Diagnostic>> {
        assert_eq!(kind, TextureKind::Float);
        Ok(Arc::new(Gradient))
    }
    fn material(&self, _: &Spanned<String>, _: &Context) -> Result<Arc<dyn Material>, Box<Diagnostic>> {
        Err(Diagnostic::error("test", "no materials").into())
    }
    fn image(&self, _: &Spanned<String>, _: &Context) -> Result<Arc<Image>, String> {
        Err("no pictures".into())
    }
}

impl Files for Things {
    fn read(&self, _: &str, _: Span) -> Result<Vec<u8>, String> {
        Err("no files".into())
    }
}

impl SpectrumSource for Things {
    fn build(&self, _: &Param, _: SpectrumRole, _: &Context) -> Result<Arc<dyn Spectrum>, Vec<Diagnostic>> {
        Err(vec![Diagnostic::error("test", "no spectra")])
    }
}

fn param(ty: ParamType, name: &str, values: Values) -> Param {
    let span = Span::default();
    Param { ty: Spanned::new(ty, span), name: Spanned::new(name.into(), span), values, span }
}

fn number(name: &str, value: f64) -> Param {
    param(ParamType::Float, name, Values::Numbers { values: vec![value], whole: false })
}

fn texture(name: &str) -> Param {
    param(ParamType::Texture, name, Values::Strings(vec![Spanned::new("any".into(), Span::default())]))
}

fn disc(params: &[Param], spacetime: &dyn Spacetime) -> Result<Box<dyn AreaLight>, String> {
    let context = Context {
        files: &Things,
        spectra: &Things,
        named: &Things,
        world_from_object: DAffine3::IDENTITY,
        reverse_orientation: false,
        resolution: [1, 1],
        lambda_range: [360.0, 830.0],
        seed: 0,
    };
    let plugin = bhs_lights::AREA.iter().find(|p| p.name == "thindisc").expect("it is there");
    let p = Params::new(Spanned::new("thindisc".into(), Span::default()), params, context);
    let built = (plugin.build)(&p);
    let errors: Vec<String> = p.finish().0.into_iter().map(|d| d.message).collect();
    if !errors.is_empty() {
        return Err(errors.join("; "));
    }
    let mut light = built.expect("no errors, so a light");
    light.bind(spacetime)?;
    Ok(light)
}

/// In the plane y = 0 of a hole at (1, 2, 3) with M = 2 that spins about +y.
fn hole(spin: f64) -> Kerr {
    Kerr::new(Spherical { center: DVec3::new(1.0, 2.0, 3.0), rs: 4.0, charge_squared: 0.0 }, DVec3::Y, spin)
}

/// The point of the plane at Boyer and Lindquist's radius `r` in units of M.
fn point(spin: f64, r: f64, phi: f64) -> DVec3 {
    let across = 2.0 * r.hypot(spin);
    DVec3::new(1.0 + across * phi.cos(), 2.0, 3.0 + across * phi.sin())
}

fn at(point: DVec3) -> Emission {
    Emission { uv: Vec2::splat(0.25), point, time: 0.0, cos_theta: 0.3, lambda_nm: [400.0, 500.0, 600.0, 700.0], clock_rate: 1.0 }
}

/// Planck's law in SI units.
fn planck(temperature: f64, lambda_nm: f64) -> f64 {
    let (h, c, k, l) = (6.626_070_15e-34, 299_792_458.0, 1.380_649e-23, lambda_nm * 1e-9);
    2.0 * h * c * c / l.powi(5) / (h * c / (l * k * temperature)).exp_m1() * 1e-9
}

fn is_black_body(found: SampledSpectrum, temperature: f64, factor: f64) {
    for (l, value) in at(DVec3::ZERO).lambda_nm.into_iter().zip(found.0) {
        let wanted = factor * planck(temperature, f64::from(l));
        assert!((f64::from(value) / wanted - 1.0).abs() < 3e-7, "{l} nm: {value} {wanted}");
    }
}

#[test]
fn the_hottest_ring_has_the_temperature_that_is_stated() {
    // Radii and values of the greatest flux, and the flux at r = 10: by quadrature with 30 digits.
    for (spin, hottest, greatest, at_ten) in
        [(0.5, 6.6150876, 5.3589399e-4, 3.43906805338e-4), (0.9, 3.4418434, 4.262872624e-3, 6.03709639901e-4)]
    {
        let light = disc(&[number("temperature", 9000.0), number("scale", 0.01)], &hole(spin)).unwrap();
        is_black_body(light.radiance(&at(point(spin, hottest, 0.4))), 9000.0, 0.01);
        let both = light.radiance(&at(point(spin, 10.0, 2.0)));
        is_black_body(both, 9000.0 * f64::powf(at_ten / greatest, 0.25), 0.01);
        assert_eq!(light.radiance(&Emission { cos_theta: -0.3, ..at(point(spin, 10.0, 2.0)) }), both, "both faces");
        // Against the spin it begins farther out.
        let against = param(ParamType::Bool, "retrograde", Values::Bools(vec![true]));
        let (spin, r) = (0.9, 8.717_352_279_606_49);
        let light = disc(&[against], &hole(spin)).unwrap();
        assert!((light.inner_edge().unwrap() / (2.0 * f64::hypot(r, spin)) - 1.0).abs() < 1e-13);
        assert!(
            light.radiance(&at(point(spin, r * 0.9999, 1.0))).is_zero()
                && !light.radiance(&at(point(spin, r * 1.1, 1.0))).is_zero()
        );
    }
}

#[test]
fn accretion_says_how_hot_it_is() {
    let params = [number("accretionrate", 1e-8), number("mass", 10.0), number("hardening", 1.5)];
    let light = disc(&params, &hole(0.9)).unwrap();
    // 10 suns have G M / c^2 = 14766.25 m; 1e-8 of their mass a year are 6.30103e14 kg/s.
    let (length, rate) = (14_766.250_4, 1e-8 * 1.988_409_87e30 / 31_557_600.0);
    let flux: f64 = rate * 299_792_458f64.powi(2) / (4.0 * PI * length * length) * 6.037_096_399_01e-4;
    let temperature = (flux / 5.670_374_419e-8).powf(0.25);
    let found = light.radiance(&at(point(0.9, 10.0, 0.0)));
    for (l, value) in at(DVec3::ZERO).lambda_nm.into_iter().zip(found.0) {
        let wanted = planck(1.5 * temperature, f64::from(l)) / 1.5f64.powi(4);
        assert!((f64::from(value) / wanted - 1.0).abs() < 1e-6, "{value} {wanted}");
    }
    for (params, error) in [
        (vec![number("mass", 10.0)], "`mass` needs `accretionrate`"),
        (vec![number("accretionrate", 10.0)], "`accretionrate` needs `mass`"),
        (vec![number("accretionrate", -1.0), number("mass", 1.0)], "`accretionrate` must be above 0"),
    ] {
        assert_eq!(disc(&params, &hole(0.5)).err().expect("it is refused"), error);
    }
    assert!(disc(&[], &Minkowski::default()).is_err());
    let hot = [number("accretionrate", 1e20), number("mass", 1e-3)];
    assert!(disc(&hot, &hole(0.5)).err().expect("it is refused").contains("hotter"));
}

/// The exitance is what the radiance adds up to over all directions of both faces.
#[test]
fn the_exitance_is_that_of_two_faces() {
    let light = disc(&[], &hole(0.5)).unwrap();
    let here = point(0.5, 9.0, 1.0);
    let radiance = light.radiance(&Emission { lambda_nm: [560.0; 4], ..at(here) })[0];
    let exitance = light.exitance(&EmissionPoint { uv: Vec2::ZERO, point: here }, 560.0, 560.0);
    assert!((exitance / (2.0 * PI * f64::from(radiance)) - 1.0).abs() < 1e-6);
    assert!(!light.is_uniform() && !light.depends_on_time());
}

#[test]
fn a_pattern_turns_with_the_matter() {
    let (spin, r, phi) = (0.9, 6.0f64, 0.7);
    // M = 2: the orbit turns by 1/(r^1.5 + a) in a time M.
    let omega = 0.5 / (r.powf(1.5) + spin);
    for (sense, retrograde) in [(1.0, false), (-1.0, true)] {
        let against = param(ParamType::Bool, "retrograde", Values::Bools(vec![retrograde]));
        let light = disc(&[texture("modulation"), number("time", 100.0), against], &hole(spin)).unwrap();
        assert!(light.depends_on_time());
        let omega = if retrograde { 0.5 / (r.powf(1.5) - spin) } else { omega };
        // +y x x = (z, 0, -x): from +x towards -z.
        let start = light.at_time_zero(point(spin, r, phi), -30.0);
        let wanted = point(spin, r, phi + sense * omega * 70.0);
        assert!((start - wanted).length() < 1e-12 * start.length(), "{start} {wanted}");
    }
    let plain = disc(&[], &hole(spin)).unwrap().radiance(&at(point(spin, r, phi)));
    let light = disc(&[texture("modulation")], &hole(spin)).unwrap();
    let modulated = light.radiance(&at(point(spin, r, phi)));
    assert!((modulated - plain * 0.25).map(f32::abs).max() <= 1e-6 * plain.max());
}
