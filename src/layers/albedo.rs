//! The albedo layer: reflectances as the film's colours, the same way for every ray, so that there is no noise of wavelengths in it.

use super::Value;
use bhs_core::camera::Film;
use bhs_core::material::{Material, Shading};
use bhs_core::scene::{Scene, Vertex};
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, SampledWavelengths};
use glam::{Vec2, Vec3};
use std::f32::consts::TAU;
use std::sync::{Arc, OnceLock};

/// Sets of wavelengths that stand for the film's range.
const WAVELENGTH_SETS: usize = 8;

/// Turns reflectances into the film's colours under D65.
pub struct AlbedoColor {
    wavelengths: [SampledWavelengths; WAVELENGTH_SETS],
    /// The colour of reflectance 1 at each wavelength alone; all of them together are white.
    colors: [[Value; N_LAMBDA]; WAVELENGTH_SETS],
    /// Of each uniform material of the scene once.
    tables: Vec<Table>,
    /// Number of the table of each geometry, if its material has one.
    table_of: Vec<Option<u32>>,
}

impl AlbedoColor {
    /// For the surfaces of `scene`, in the colours of `film`.
    pub fn new(scene: &Scene, film: &dyn Film) -> Self {
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

        let mut uniform: Vec<&Arc<dyn Material>> = Vec::new();
        let table_of = scene.shapes.iter().map(|shape| {
            let material = Some(&shape.material).filter(|material| material.is_uniform())?;
            let known = uniform.iter().position(|other| Arc::ptr_eq(other, material));
            Some(known.unwrap_or_else(|| {
                uniform.push(material);
                uniform.len() - 1
            }) as u32)
        });
        let table_of = table_of.collect();
        let tables = uniform.iter().map(|_| Table::default()).collect();
        Self { wavelengths, colors, tables, table_of }
    }

    /// Some that vertices may be made with: what is asked of them here does not depend on it.
    pub fn any_wavelengths(&self) -> &SampledWavelengths {
        &self.wavelengths[0]
    }

    /// The albedo of a surface as its light arrives: reflectance at the wavelengths there, `shift` times those that are seen.
    pub fn of(&self, vertex: &Vertex, shift: f64) -> Value {
        match self.table_of[vertex.hit.geometry as usize].filter(|_| shift == 1.0) {
            Some(table) => {
                self.tables[table as usize].at(vertex.wo.z, |wo| self.color(vertex.material, vertex.shading.uv, wo, 1.0))
            }
            None => self.color(vertex.material, vertex.shading.uv, vertex.wo, shift),
        }
    }

    fn color(&self, material: &dyn Material, uv: Vec2, wo: Vec3, shift: f64) -> Value {
        let mut sum = [0.0; 3];
        for (lambda, colors) in self.wavelengths.iter().zip(&self.colors) {
            let at = Shading { uv, lambda_nm: lambda.at(shift as f32) };
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
const AROUND: u32 = 4;

/// The albedo of a uniform material by the angle from which it is seen, for both of its sides. Entries are made when they are first asked for,
/// and are the same whoever does.
struct Table([[OnceLock<Value>; STEPS + 1]; 2]);

impl Default for Table {
    fn default() -> Self {
        Self(std::array::from_fn(|_| std::array::from_fn(|_| OnceLock::new())))
    }
}

impl Table {
    /// The albedo seen from where the cosine to the shading normal is `cos`; `color`: that seen from a direction.
    fn at(&self, cos: f32, color: impl Fn(Vec3) -> Value) -> Value {
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
        let (y, x) = (TAU / AROUND as f32 * (k as f32 + 0.5)).sin_cos();
        let value = color(Vec3::new(sin * x, sin * y, z));
        (0..3).for_each(|c| mean[c] += value[c] / f64::from(AROUND));
    }
    mean
}
