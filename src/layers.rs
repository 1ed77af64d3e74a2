//! The values of a picture's layers: of what the light transport has seen of each camera ray ([`PathSample::first`]); no ray is followed for
//! them.

mod picture;

pub use picture::{LayerPicture, numbers_in_files};

use bhs_core::camera::Film;
use bhs_engine::layer::{Layer, NamedLayer, Statistic, Value, VisibleSurface};
use bhs_engine::scene::Scene;
use bhs_engine::transport::PathSample;

/// Computes the layers of a picture.
pub struct LayerCollector<'a> {
    scene: &'a Scene,
    layers: &'a [NamedLayer],
    /// In place of those which need to know the scene.
    made: Vec<Option<Box<dyn Layer>>>,
}

impl<'a> LayerCollector<'a> {
    /// A collector of these layers of a film; `None` if none of them is of the camera's rays.
    pub fn new(scene: &'a Scene, film: &dyn Film, layers: &'a [NamedLayer]) -> Option<Self> {
        let of_rays = layers.iter().any(|l| l.format.statistic != Statistic::ColorVariance);
        of_rays.then(|| Self { scene, layers, made: layers.iter().map(|l| l.layer.for_render(scene, film)).collect() })
    }

    /// The values of all layers, in their order, for the camera ray of a path that has been followed; `None` for what this ray has no value
    /// of. `camera_ratio`: wavelength where the ray starts over that at E = 1, as the camera measures it.
    pub fn values(&self, path: &PathSample, camera_ratio: f64) -> impl Iterator<Item = Option<Value>> {
        let seen = VisibleSurface::new(self.scene, path, camera_ratio);
        let layers = self.layers.iter().zip(&self.made);
        layers.map(move |(named, made)| made.as_deref().unwrap_or(&*named.layer).value(&seen))
    }
}
