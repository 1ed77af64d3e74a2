//! Reflectances of materials as the film's colours under D65.

use bhs_core::camera::Film;
use bhs_core::material::{Material, Shading};
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, SampledWavelengths};
use bhs_elementary::Elementary;
use bhs_engine::layer::Value;
use glam::Vec3;
use std::f32::consts::TAU;
use std::sync::OnceLock;

/// Sets of wavelengths that stand for the film's range.
const WAVELENGTH_SETS: usize = 8;

/// Turns reflectances into the film's colours.
pub struct Colors {
    wavelengths: [SampledWavelengths; WAVELENGTH_SETS],
    /// The colour of reflectance 1 at each wavelength alone; all of them together are white.
    colors: [[Value; N_LAMBDA]; WAVELENGTH_SETS],
}

impl Colors {
    /// In the colours of `film`.
    pub fn new(film: &dyn Film) -> Self {
        let [lo, hi] = film.lambda_range();
        let set = |i| SampledWavelengths::visible((i as f32 + 0.5) / (WAVELENGTH_SETS * N_LAMBDA) as f32, lo, hi);
        let wavelengths: [SampledWavelengths; WAVELENGTH_SETS] = std::array::from_fn(set);
        let colors = wavelengths.map(|lambda| {
            let light = bhs_spectra::d65().sample(lambda.lambda_nm);
            std::array::from_fn(|i| {
                let (mut alone, mut color) = (SampledSpectrum::ZERO, [0.0; 3]);
                alone.0[i] = light[i];
                film.add(alone, &lambda, &mut color);
                color
            })
        });
        let mut white = [0.0; 3];
        colors.iter().flatten().for_each(|color| (0..3).for_each(|c| white[c] += color[c]));
        let colors = colors.map(|set| set.map(|color| std::array::from_fn(|c| color[c] / white[c])));
        Self { wavelengths, colors }
    }

    /// Any of the wavelengths.
    pub fn some_wavelengths(&self) -> &SampledWavelengths {
        &self.wavelengths[0]
    }

    /// The colour of a material at a point, whose wavelengths do not matter, seen from `wo` (shading frame), at `shift` times the wavelengths that
    /// are seen.
    pub fn of(&self, material: &dyn Material, at: &Shading, wo: Vec3, shift: f64) -> Value {
        let mut sum = [0.0; 3];
        for (lambda, colors) in self.wavelengths.iter().zip(&self.colors) {
            let at = Shading { lambda_nm: lambda.at(shift as f32), ..*at };
            for (reflectance, color) in material.reflectance(&at, wo).0.into_iter().zip(colors) {
                (0..3).for_each(|c| sum[c] += f64::from(reflectance) * color[c]);
            }
        }
        sum
    }
}

/// Steps of |cos(theta)| in a table. Between them a conductor's albedo is interpolated to 1e-4.
const STEPS: usize = 64;

/// Directions around the normal over which an entry is a mean: the reflectance of rough materials is an estimate that varies with them.
const AROUND: u32 = 16;

/// The albedo of a uniform material by the angle from which it is seen, for both of its sides. Entries are made when they are first asked for,
/// and are the same whoever does.
pub struct Table([[OnceLock<Value>; STEPS + 1]; 2]);

impl Default for Table {
    fn default() -> Self {
        Self(std::array::from_fn(|_| std::array::from_fn(|_| OnceLock::new())))
    }
}

impl Table {
    /// The albedo seen from where the cosine to the shading normal is `cos`; `color`: that seen from a direction.
    pub fn at(&self, cos: f32, color: impl Fn(Vec3) -> Value) -> Value {
        let side = &self.0[usize::from(cos < 0.0)];
        let along = cos.abs().min(1.0) * STEPS as f32;
        let step = (along as usize).min(STEPS - 1);
        let t = f64::from(along - step as f32);
        let [a, b] = [step, step + 1].map(|i| side[i].get_or_init(|| around((i as f32 / STEPS as f32).copysign(cos), &color)));
        std::array::from_fn(|c| a[c] + t * (b[c] - a[c]))
    }
}

/// The mean of `color` over directions around the normal with the cosine `cos` to it, which is kept off the horizon.
fn around(cos: f32, color: impl Fn(Vec3) -> Value) -> Value {
    let z = cos.abs().max(1e-3).copysign(cos);
    let sin = (1.0 - z * z).max(0.0).sqrt();
    let mut mean = [0.0; 3];
    for k in 0..AROUND {
        let (y, x) = (TAU / AROUND as f32 * (k as f32 + 0.5)).sine_cosine();
        let value = color(Vec3::new(sin * x, sin * y, z));
        (0..3).for_each(|c| mean[c] += value[c] / f64::from(AROUND));
    }
    mean
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use bhs_core::diagnostics::{Span, Spanned};
    use bhs_core::params::{Context, Files, Nameless, Params};
    use bhs_core::value::{Param, ParamType, Values};
    use bhs_spectra::Builder;
    use glam::{DAffine3, Vec2};

    struct NoFiles;

    impl Files for NoFiles {
        fn read(&self, _: &str, _: Span) -> Result<Vec<u8>, String> {
            Err("no file is read here".into())
        }
    }

    /// A scene of nothing.
    pub fn context() -> Context<'static> {
        Context {
            files: &NoFiles,
            spectra: &Builder,
            named: &Nameless,
            world_from_object: DAffine3::IDENTITY,
            reverse_orientation: false,
            resolution: [1, 1],
            lambda_range: [360.0, 830.0],
            seed: 0,
        }
    }

    fn spanned<T>(value: T) -> Spanned<T> {
        Spanned::new(value, Span::default())
    }

    fn param(ty: ParamType, name: &str, values: Values) -> Param {
        Param { ty: spanned(ty), name: spanned(name.to_owned()), values, span: Span::default() }
    }

    fn numbers(ty: ParamType, name: &str, values: &[f64]) -> Param {
        param(ty, name, Values::Numbers { values: values.to_vec(), whole: false })
    }

    /// The largest difference between a table and its material, per material: of the colour from any direction, and of its mean around the
    /// normal.
    fn differences(name: &str, params: &[Param]) -> [f64; 2] {
        let film = bhs_films::ALL.iter().find(|film| film.name == "rgb").expect("it is listed");
        let film = (film.build)(&Params::new(spanned("rgb".to_owned()), &[], context())).expect("it needs nothing");
        let material = bhs_materials::ALL.iter().find(|material| material.name == name).expect("it is listed");
        let params = Params::new(spanned(name.to_owned()), params, context());
        let material = (material.build)(&params).expect("without fault");
        assert!(params.finish().0.is_empty() && material.is_uniform(), "{name}");
        let (colors, table) = (Colors::new(&*film), Table::default());
        let exact = |wo| colors.of(&*material, &Shading::at_uv(Vec2::ZERO, [0.0; N_LAMBDA]), wo, 1.0);
        let mut worst = [0.0f64; 2];
        for i in 0..400 {
            let cos = (0.02 + 0.98 * (i as f32 + 0.3) / 400.0).copysign(if i % 2 == 0 { 1.0 } else { -1.0 });
            let found = table.at(cos, exact);
            let (sin, count) = ((1.0 - cos * cos).sqrt(), 64);
            let mut mean = [0.0; 3];
            for k in 0..count {
                let (y, x) = (TAU * k as f32 / count as f32).sine_cosine();
                let one = exact(Vec3::new(sin * x, sin * y, cos));
                for c in 0..3 {
                    worst[0] = worst[0].max((one[c] - found[c]).abs());
                    mean[c] += one[c] / f64::from(count);
                }
            }
            worst[1] = (0..3).map(|c| (mean[c] - found[c]).abs()).fold(worst[1], f64::max);
        }
        worst
    }

    #[test]
    fn tables_have_the_albedo_of_their_materials() {
        let red = numbers(ParamType::Rgb, "reflectance", &[0.7, 0.2, 0.1]);
        let named =
            |name: &str, spectrum: &str| param(ParamType::Spectrum, name, Values::Strings(vec![spanned(spectrum.to_owned())]));
        let gold = [named("eta", "metal-Au-eta"), named("k", "metal-Au-k")];
        let float = |name: &str, value: f64| numbers(ParamType::Float, name, &[value]);
        let rough = |params: &[Param]| [&gold[..], params].concat();
        let alpha = [float("roughness", 0.15), param(ParamType::Bool, "remaproughness", Values::Bools(vec![false]))];
        // Of rough metal, the estimate from sixteen directions varies around the normal where it is seen at grazing angles; a table has its mean.
        let cases = [
            ("diffuse", vec![red.clone()], [1e-6, 1e-6]),
            ("mirror", vec![float("reflectance", 0.8)], [1e-6, 1e-6]),
            ("conductor", gold.to_vec(), [1e-3, 1e-3]),
            ("conductor", rough(&alpha), [0.06, 5e-3]),
            ("conductor", rough(&[float("roughness", 0.6)]), [0.06, 5e-3]),
            ("coateddiffuse", vec![red], [1e-3, 1e-3]),
        ];
        for (material, params, [one, mean]) in cases {
            let found = differences(material, &params);
            assert!(found[0] < one && found[1] < mean, "{material}: {found:?}");
        }
    }
}
