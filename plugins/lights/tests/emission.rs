//! The lights emit what their parameters say: radiance, sides, scale and exitance.

use bhs_core::diagnostics::{Diagnostic, Span, Spanned};
use bhs_core::image::{Image, Texels};
use bhs_core::light::{AreaLight, Emission, EmissionPoint, Light};
use bhs_core::material::{Material, Shading};
use bhs_core::params::{Context, Files, Named, Params, SpectrumSource};
use bhs_core::plugin::Plugin;
use bhs_core::spectrum::{SampledSpectrum, Spectrum, SpectrumRole};
use bhs_core::texture::{Texture, TextureKind};
use bhs_core::value::{Param, ParamType, Values};
use glam::{DAffine3, DVec3, Vec2};
use std::f32::consts::PI;
use std::sync::Arc;

/// A texture whose spectra are u at all wavelengths, and a picture of two texels of light side by side.
struct Gradient;

impl Texture for Gradient {
    fn spectrum(&self, at: &Shading) -> SampledSpectrum {
        SampledSpectrum::splat(at.uv.x)
    }
    fn float(&self, at: &Shading) -> f32 {
        at.uv.x
    }
}

struct Things;

impl Named for Things {
    fn texture(&self, _: &Spanned<String>, kind: TextureKind, _: &Context) -> Result<Arc<dyn Texture>, Box<Diagnostic>> {
        assert!([TextureKind::Spectrum(SpectrumRole::Emission), TextureKind::Float].contains(&kind));
        Ok(Arc::new(Gradient))
    }
    fn material(&self, _: &Spanned<String>, _: &Context) -> Result<Arc<dyn Material>, Box<Diagnostic>> {
        Err(Diagnostic::error("test", "no materials").into())
    }
    fn image(&self, _: &Spanned<String>, _: &Context) -> Result<Arc<Image>, String> {
        Ok(Arc::new(Image::new([2, 1], Texels::Floats(vec![[1.0; 3], [3.0; 3]]))))
    }
}

/// The one number that the scene gives, times the wavelength over 500 nm.
#[derive(Debug)]
struct Ramp(f32);

impl Spectrum for Ramp {
    fn at(&self, lambda_nm: f32) -> f32 {
        self.0 * lambda_nm / 500.0
    }
    fn max(&self, _: f32, hi: f32) -> f32 {
        self.at(hi)
    }
}

struct Ramps;

impl SpectrumSource for Ramps {
    fn build(&self, param: &Param, role: SpectrumRole, _: &Context) -> Result<Arc<dyn Spectrum>, Vec<Diagnostic>> {
        assert_eq!(role, SpectrumRole::Emission);
        match &param.values {
            Values::Numbers { values, .. } => Ok(Arc::new(Ramp(values[0] as f32))),
            _ => Err(vec![Diagnostic::error("test", "not a number")]),
        }
    }
}

fn at(cos_theta: f32, lambda_nm: [f32; 4]) -> Emission {
    Emission { uv: Vec2::ZERO, point: DVec3::ZERO, time: 0.0, cos_theta, lambda_nm, clock_rate: 1.0 }
}

struct NoFiles;

impl Files for NoFiles {
    fn read(&self, _: &str, _: Span) -> Result<Vec<u8>, String> {
        Err("no such file".into())
    }
}

fn param(ty: ParamType, name: &str, values: Values) -> Param {
    let span = Span::default();
    Param { ty: Spanned::new(ty, span), name: Spanned::new(name.into(), span), values, span }
}

fn number(ty: ParamType, name: &str, value: f64) -> Param {
    param(ty, name, Values::Numbers { values: vec![value], whole: false })
}

fn build<T: ?Sized>(plugin: &Plugin<T>, params: &[Param]) -> (Option<Box<T>>, Vec<String>) {
    let context = Context {
        files: &NoFiles,
        spectra: &Ramps,
        named: &Things,
        world_from_object: DAffine3::IDENTITY,
        reverse_orientation: false,
        resolution: [1, 1],
        lambda_range: [360.0, 830.0],
        seed: 0,
    };
    let p = Params::new(Spanned::new(plugin.name.into(), Span::default()), params, context);
    let built = (plugin.build)(&p);
    (built, p.finish().0.into_iter().map(|d| d.message).collect())
}

fn area(params: &[Param]) -> Box<dyn AreaLight> {
    let (light, errors) = build(&bhs_lights::AREA[0], params);
    assert_eq!(errors, Vec::<String>::new());
    light.expect("no errors, so a light")
}

fn sky(params: &[Param]) -> Box<dyn Light> {
    light("infinite", params)
}

fn light(name: &str, params: &[Param]) -> Box<dyn Light> {
    let (light, errors) = build(plugin(name), params);
    assert_eq!(errors, Vec::<String>::new());
    light.expect("no errors, so a light")
}

fn plugin(name: &str) -> &'static Plugin<dyn Light> {
    bhs_lights::ALL.iter().find(|p| p.name == name).expect("a light")
}

fn point3(name: &str, values: [f64; 3]) -> Param {
    param(ParamType::Point3, name, Values::Numbers { values: values.to_vec(), whole: false })
}

/// Any point of a surface.
const MIDDLE: EmissionPoint = EmissionPoint { uv: Vec2::splat(0.5), point: DVec3::ZERO };

const LAMBDA: [f32; 4] = [400.0, 500.0, 600.0, 700.0];

#[test]
fn by_default_one_side_emits_one() {
    let light = area(&[]);
    assert_eq!(light.radiance(&at(0.3, LAMBDA)), SampledSpectrum::ONE);
    assert_eq!(light.radiance(&at(-0.3, LAMBDA)), SampledSpectrum::ZERO);
    assert_eq!(light.radiance(&at(0.0, LAMBDA)), SampledSpectrum::ZERO);
    assert!((light.exitance(&MIDDLE, 360.0, 830.0) / f64::from(PI) - 1.0).abs() < 1e-6);
}

#[test]
fn two_sides_emit_twice_as_much() {
    let two = area(&[param(ParamType::Bool, "twosided", Values::Bools(vec![true]))]);
    assert_eq!(two.radiance(&at(-0.3, LAMBDA)), SampledSpectrum::ONE);
    assert_eq!(two.exitance(&MIDDLE, 400.0, 700.0), 2.0 * area(&[]).exitance(&MIDDLE, 400.0, 700.0));
}

#[test]
fn spectrum_and_scale_multiply() {
    let params = [number(ParamType::Spectrum, "L", 3.0), number(ParamType::Float, "scale", 2.0)];
    let expected = SampledSpectrum([4.8, 6.0, 7.2, 8.4]);
    let near = |s: SampledSpectrum| (s - expected).map(f32::abs).max() < 1e-5;
    assert!(near(area(&params).radiance(&at(1.0, LAMBDA))));
    assert!(near(sky(&params).sky_radiance(DVec3::Y, LAMBDA)));
    // The mean of a ramp is its value in the middle.
    assert!((area(&params).exitance(&MIDDLE, 400.0, 700.0) / f64::from(PI * 6.6) - 1.0).abs() < 1e-5);
    assert!((area(&params).exitance(&MIDDLE, 550.0, 550.0) / f64::from(PI * 6.6) - 1.0).abs() < 1e-5);
}

fn text(ty: ParamType, name: &str, value: &str) -> Param {
    param(ty, name, Values::Strings(vec![Spanned::new(value.into(), Span::default())]))
}

#[test]
fn textures_and_pictures_emit_what_they_show_where_they_show_it() {
    let at_u = |u: f32| Emission { uv: Vec2::new(u, 0.5), ..at(1.0, [560.0; 4]) };
    let exitance =
        |light: &dyn AreaLight, u: f32| light.exitance(&EmissionPoint { uv: Vec2::new(u, 0.5), ..MIDDLE }, 560.0, 560.0);
    let textured = area(&[text(ParamType::Texture, "L", "gradient"), number(ParamType::Float, "scale", 2.0)]);
    let pictured = area(&[text(ParamType::String, "filename", "a.exr"), number(ParamType::Float, "scale", 2.0)]);
    // The picture is white light, in proportion; between the middles of its texels it rises evenly.
    let unit = f64::from(bhs_spectra::d65().at(560.0));
    for (u, of_texture, of_picture) in [(0.1, 0.1, 1.0), (0.5, 0.5, 2.0), (0.625, 0.625, 2.5), (0.9, 0.9, 3.0)] {
        for (light, wanted) in [(&textured, of_texture), (&pictured, of_picture * unit)] {
            let found = f64::from(light.radiance(&at_u(u))[0]);
            assert!((found / (2.0 * wanted) - 1.0).abs() < 1e-5, "{u}: {found} {wanted}");
            assert!((exitance(light.as_ref(), u) / (f64::from(PI) * found) - 1.0).abs() < 1e-5);
            assert!(!light.is_uniform());
        }
    }
    assert!(area(&[]).is_uniform());
    let both = [text(ParamType::String, "filename", "a.exr"), number(ParamType::Spectrum, "L", 1.0)];
    assert_eq!(build(&bhs_lights::AREA[0], &both).1, ["`L` and `filename` exclude each other"]);
}

#[test]
fn the_exitance_is_the_integral_of_the_radiance() {
    let light = area(&[number(ParamType::Spectrum, "L", 3.0), param(ParamType::Bool, "twosided", Values::Bools(vec![true]))]);
    // By the midpoint rule over cos(theta): the integral of L cos(theta) over all directions is 2 pi times that of L |c| dc.
    let n = 1000;
    let mut sum = 0.0;
    for i in 0..n {
        let c = -1.0 + 2.0 * (i as f32 + 0.5) / n as f32;
        sum += light.radiance(&at(c, [550.0; 4]))[0] * c.abs() * 2.0 / n as f32;
    }
    assert!((f64::from(2.0 * PI * sum) / light.exitance(&MIDDLE, 550.0, 550.0) - 1.0).abs() < 1e-4);
}

#[test]
fn the_sky_is_white_by_default() {
    let white = bhs_spectra::d65().sample(LAMBDA);
    assert_eq!(sky(&[]).sky_radiance(DVec3::Z, LAMBDA), white);
    assert!((bhs_spectra::luminance(bhs_spectra::d65()) - 1.0).abs() < 1e-4);
}

#[test]
fn faults_are_told() {
    let errors = |params: &[Param]| build(plugin("infinite"), params).1;
    assert_eq!(errors(&[number(ParamType::Float, "scale", -1.0)]), ["`scale` is out of range"]);
    assert_eq!(errors(&[number(ParamType::Float, "scale", 1e300)]), ["`scale` is out of range"]);
    assert_eq!(errors(&[number(ParamType::Integer, "filename", 1.0)]), ["`filename` has the type `string`, not `integer`"]);
    assert_eq!(errors(&[number(ParamType::Integer, "portal", 1.0)]), ["unknown parameter `portal`"]);
    assert_eq!(errors(&[number(ParamType::Float, "illuminance", -1.0)]), ["`illuminance` must be above 0"]);
    let dark = [number(ParamType::Spectrum, "L", 0.0), number(ParamType::Float, "illuminance", 1.0)];
    assert_eq!(errors(&dark), ["`illuminance` cannot be reached"]);
    let same = [point3("from", [1.0, 2.0, 3.0]), point3("to", [1.0, 2.0, 3.0])];
    for name in ["distant", "spot"] {
        assert_eq!(build(plugin(name), &same).1, ["`from` and `to` are the same point"]);
    }
    assert_eq!(errors(&[number(ParamType::Point2, "L", 1.0)]), ["`L` takes a spectrum, not a value of the type `point2`"]);
}

/// Directions all over the sphere with equal solid angles.
fn directions(n: u32) -> impl Iterator<Item = DVec3> {
    (0..n).map(move |i| {
        let z = 1.0 - (2.0 * f64::from(i) + 1.0) / f64::from(n);
        let (sin, cos) = (f64::from(i) * 2.399_963_229_728_653).sin_cos();
        let s = (1.0 - z * z).sqrt();
        DVec3::new(s * cos, s * sin, z)
    })
}

#[test]
fn a_spot_falls_off_between_its_cones_and_its_power_is_the_integral() {
    let params = [
        number(ParamType::Float, "coneangle", 40.0),
        number(ParamType::Float, "conedeltaangle", 15.0),
        point3("from", [1.0, 1.0, 1.0]),
        point3("to", [1.0, 3.0, 1.0]),
        number(ParamType::Spectrum, "I", 7.0),
    ];
    let spot = light("spot", &params);
    assert_eq!(spot.position(), Some(DVec3::ONE));
    let towards = |degrees: f64| {
        let (sin, cos) = degrees.to_radians().sin_cos();
        spot.intensity(DVec3::new(sin, cos, 0.0), [500.0; 4])[0]
    };
    assert_eq!([towards(0.0), towards(24.9), towards(40.1), towards(180.0)], [7.0, 7.0, 0.0, 0.0]);
    // Half way in cosine it is half.
    let middle = ((40f64.to_radians().cos() + 25f64.to_radians().cos()) / 2.0).acos().to_degrees();
    assert!((towards(middle) - 3.5).abs() < 1e-4 && towards(39.0) < towards(30.0));
    let n = 200_000;
    let sum: f64 = directions(n).map(|d| f64::from(spot.intensity(d, [500.0; 4])[0])).sum();
    let power = 4.0 * std::f64::consts::PI * sum / f64::from(n);
    assert!((power / spot.power(500.0, 500.0, 1.0) - 1.0).abs() < 1e-3);
}

#[test]
fn power_and_illuminance_say_how_bright_a_light_is() {
    // The luminance of a ramp by its value at 500 nm: the mean wavelength of y-bar (560.2 nm by the observer's table) over 500 nm.
    let luminance = |at_500: f32| at_500 * 560.2 / 500.0;
    for (name, strength, measure) in [("point", "I", 4.0 * PI), ("spot", "I", 0.0)] {
        let params = [number(ParamType::Spectrum, strength, 5.0), number(ParamType::Float, "power", 30.0)];
        let l = light(name, &params);
        let n = 100_000;
        let along = luminance(l.intensity(DVec3::Z, [500.0; 4])[0]);
        let solid_angle = if measure > 0.0 {
            measure
        } else {
            directions(n).map(|d| l.intensity(d, [500.0; 4])[0] / l.intensity(DVec3::Z, [500.0; 4])[0]).sum::<f32>() * 4.0 * PI
                / n as f32
        };
        assert!((along * solid_angle / 30.0 - 1.0).abs() < 2e-3, "{name}: {along} {solid_angle}");
    }
    let distant = light("distant", &[number(ParamType::Float, "illuminance", 30.0), number(ParamType::Float, "scale", 2.0)]);
    assert!((distant.irradiance([500.0; 4])[0] / 60.0 - 1.0).abs() < 1e-5, "of an equal-energy spectrum, times `scale`");
    let sky = sky(&[number(ParamType::Float, "illuminance", 30.0)]);
    let white = bhs_spectra::d65().at(500.0);
    assert!((sky.sky_radiance(DVec3::Z, [500.0; 4])[0] * PI / (30.0 * white) - 1.0).abs() < 1e-4);
}

#[test]
fn a_distant_light_shines_from_from_to_to() {
    let distant = light("distant", &[point3("from", [0.0, 3.0, 4.0]), point3("to", [0.0, 0.0, 0.0])]);
    let sample = distant.sample_sky(Vec2::splat(0.3)).expect("a direction");
    assert!((sample.direction - DVec3::new(0.0, 0.6, 0.8)).length() < 1e-12 && sample.is_parallel);
    assert_eq!((distant.sky_radiance(sample.direction, LAMBDA), distant.sky_pdf(sample.direction)), (SampledSpectrum::ZERO, 0.0));
    // pi r^2 falls on a sphere.
    assert!((distant.power(400.0, 700.0, 3.0) / f64::from(9.0 * PI) - 1.0).abs() < 1e-5);
}
