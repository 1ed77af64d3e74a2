//! The albedo layer: reflectances as the film's colours, the same way for every ray, so that there is no noise of wavelengths in it.

use super::Value;
use bhs_core::camera::Film;
use bhs_core::geometry::SurfaceGeometry;
use bhs_core::material::{Material, Shading};
use bhs_core::observer::Observer;
use bhs_core::ray::SurfaceHit;
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, SampledWavelengths};
use bhs_engine::scene::Scene;
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

    /// The albedo of the surface that a ray has hit, as its light arrives: reflectance at the wavelengths there, `shift` times those that are
    /// seen.
    pub fn of(&self, scene: &Scene, at: (&SurfaceHit, &SurfaceGeometry, &Observer), shift: f64) -> Value {
        let (hit, surface, observer) = at;
        match self.table_of[hit.geometry as usize].filter(|_| shift == 1.0) {
            Some(table) => {
                let material = &*scene.shapes[hit.geometry as usize].material;
                let cos = Scene::cos_to_viewer(observer, hit, surface);
                self.tables[table as usize].at(cos, |wo| self.color(material, surface.uv, wo, 1.0))
            }
            // Which wavelengths the vertex has does not matter: they are replaced.
            None => scene
                .vertex(*hit, &self.wavelengths[0])
                .map_or([0.0; 3], |vertex| self.color(vertex.material, vertex.shading.uv, vertex.wo, shift)),
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
const AROUND: u32 = 16;

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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lang::{self, Overrides, SourceMap};
    use crate::registry::Registry;

    /// The largest difference between a table and its material, per material: of the colour from any direction, and of its mean around the
    /// normal.
    fn differences(material: &str) -> [f64; 2] {
        let text = format!("WorldBegin LightSource \"infinite\" {material} Shape \"sphere\"");
        let built = lang::load_text("test.bhs", &text, &Registry::builtin(), &Overrides::default(), &mut SourceMap::new());
        let Ok(built) = built else { panic!("{material}") };
        let colors = AlbedoColor::new(&built.scene, &*built.film);
        let material = &*built.scene.shapes[0].material;
        let exact = |wo| colors.color(material, Vec2::ZERO, wo, 1.0);
        let mut worst = [0.0f64; 2];
        for i in 0..400 {
            let cos = (0.02 + 0.98 * (i as f32 + 0.3) / 400.0).copysign(if i % 2 == 0 { 1.0 } else { -1.0 });
            let found = colors.tables[colors.table_of[0].expect("a table") as usize].at(cos, exact);
            let (sin, count) = ((1.0 - cos * cos).sqrt(), 64);
            let mut mean = [0.0; 3];
            for k in 0..count {
                let (y, x) = (TAU * k as f32 / count as f32).sin_cos();
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
        let gold = "Material \"conductor\" \"spectrum eta\" \"metal-Au-eta\" \"spectrum k\" \"metal-Au-k\"";
        // Of rough metal, the estimate from sixteen directions varies around the normal where it is seen at grazing angles; a table has its mean.
        let cases = [
            ("Material \"diffuse\" \"rgb reflectance\" [0.7 0.2 0.1]", [1e-6, 1e-6]),
            ("Material \"mirror\" \"float reflectance\" 0.8", [1e-6, 1e-6]),
            (gold, [1e-3, 1e-3]),
            (&format!("{gold} \"float roughness\" 0.15 \"bool remaproughness\" false"), [0.06, 5e-3]),
            (&format!("{gold} \"float roughness\" 0.6"), [0.06, 5e-3]),
            ("Material \"coateddiffuse\" \"rgb reflectance\" [0.7 0.2 0.1]", [1e-3, 1e-3]),
        ];
        for (material, [one, mean]) in cases {
            let found = differences(material);
            assert!(found[0] < one && found[1] < mean, "{material}: {found:?}");
        }
    }
}
