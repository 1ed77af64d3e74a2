//! `albedo`: the material's reflectance at the surface (linear sRGB, as seen under D65), at the wavelengths that the surface sees: reflected and
//! refracted light together.
//!
//! In mirrors and through smooth glass it is that of the surface that is seen there, times the share of its light that they leave: denoisers want
//! to know what is seen. Each sample goes one way, reflected or refracted, and a pixel has their mean. Rough surfaces that are nearly mirrors
//! count as such. Where nothing but the sky or a hole is seen in them, it is their own. The light transports `path` and `hemisphere` follow them.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `firstsurface` | bool | false | | whether it is that of the first surface, and not of what is seen in mirrors and through smooth glass |
//!
//! Reflectances become the film's colours in the same way for every ray, so that there is no noise of wavelengths in them.
//!
//! ```bhs
//! Film "rgb" "string layers" "albedo"
//! WorldBegin
//! ```

use crate::reflectance::{Colors, Table};
use bhs_core::Plugin;
use bhs_core::camera::Film;
use bhs_core::material::{Material, Shading};
use bhs_core::params::Params;
use bhs_core::spectrum::N_LAMBDA;
use bhs_engine::layer::{Display, Layer, LayerFormat, Value, VisibleSurface, read_first_surface};
use bhs_engine::scene::Scene;
use std::sync::Arc;

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Layer> = Plugin { name: "albedo", summary: "reflectance of the surface, as seen under D65", build };

/// The layer before it knows its scene: without values.
struct Albedo {
    /// Whether mirrors and glass are not followed.
    first_surface: bool,
}

fn build(p: &Params) -> Option<Box<dyn Layer>> {
    Some(Box::new(Albedo { first_surface: read_first_surface(p) }))
}

/// The layer in a scene.
struct AlbedoOfScene {
    first_surface: bool,
    colors: Colors,
    /// Of each uniform material of the scene once.
    tables: Vec<Table>,
    /// Number of the table of each geometry, if its material has one.
    table_of: Vec<Option<u32>>,
}

impl AlbedoOfScene {
    fn new(scene: &Scene, film: &dyn Film, first_surface: bool) -> Self {
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
        Self { first_surface, colors: Colors::new(film), tables, table_of }
    }

    /// The reflectance of the surface that a ray meets itself.
    fn own(&self, seen: &VisibleSurface) -> Option<Value> {
        let (hit, surface, observer) = (seen.hit()?, seen.surface()?, seen.observer()?);
        // Wavelengths at the surface over those that are seen.
        let shift = observer.ratio(hit.direction) / seen.camera_ratio;
        let value = match self.table_of[hit.geometry as usize].filter(|_| shift == 1.0) {
            Some(table) => {
                let material = &*seen.scene.shapes[hit.geometry as usize].material;
                let at = Shading::at_uv(surface.uv, [0.0; N_LAMBDA]);
                let cos = Scene::cos_to_viewer(observer, hit, surface);
                self.tables[table as usize].at(cos, |wo| self.colors.of(material, &at, wo, 1.0))
            }
            // Which wavelengths the vertex has does not matter: they are replaced.
            None => seen.scene.vertex(*hit, self.colors.some_wavelengths()).map_or([0.0; 3], |mut vertex| {
                if let Some(patch) = &seen.patch {
                    patch.fit(seen.scene, &mut vertex);
                }
                self.colors.of(vertex.material, &vertex.shading, vertex.wo, shift)
            }),
        };
        Some(value)
    }
}

const FORMAT: LayerFormat = LayerFormat::new(&["Albedo.R", "Albedo.G", "Albedo.B"], "").shown(Display::Reflectance);

impl Layer for Albedo {
    fn format(&self) -> LayerFormat {
        FORMAT
    }

    fn for_render(&self, scene: &Scene, film: &dyn Film) -> Option<Box<dyn Layer>> {
        Some(Box::new(AlbedoOfScene::new(scene, film, self.first_surface)))
    }

    fn value(&self, _: &VisibleSurface) -> Option<Value> {
        None
    }
}

impl Layer for AlbedoOfScene {
    fn format(&self) -> LayerFormat {
        FORMAT
    }

    fn value(&self, seen: &VisibleSurface) -> Option<Value> {
        let behind = if self.first_surface { None } else { seen.behind() };
        match behind.and_then(|(behind, share)| Some((self.own(&behind)?, share))) {
            Some((albedo, share)) => Some(albedo.map(|v| v * f64::from(share))),
            None => self.own(seen),
        }
    }
}
