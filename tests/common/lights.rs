//! What tests of lights share: a floor to shine on, and what surfaces receive.

use bhs::lang::BuiltScene;
use bhs_core::geometry::{Geometry, sample_triangle, triangle_area};
use bhs_core::observer::Observer;
use bhs_core::sampling::mix64;
use glam::{DVec3, Vec2};

/// Number `k` of the random numbers of `i`, uniform in [0,1).
pub fn random(i: u64, k: u64) -> f64 {
    (mix64(mix64(i) ^ k) >> 11) as f64 / (1u64 << 53) as f64
}

/// Luminance of linear sRGB.
pub fn luminance(p: &[f32]) -> f64 {
    f64::from(0.212_671 * p[0] + 0.715_160 * p[1] + 0.072_169 * p[2])
}

/// Mean luminance of the picture of a scene.
pub fn mean(text: &str) -> f64 {
    let picture = super::render(&super::build(text)).frame.picture();
    picture.data.chunks_exact(3).map(luminance).sum::<f64>() / (picture.size[0] * picture.size[1]) as f64
}

/// Luminance of a white floor seen from straight above, one pixel wide, under `light`.
pub fn floor(options: &str, light: &str) -> f64 {
    mean(&format!(
        r#"
        {options}
        Film "rgb" "integer xresolution" 1 "integer yresolution" 1
        LookAt 0 5 0  0 0 0  0 0 1
        Camera "perspective" "float fov" 0.01
        WorldBegin
        Material "diffuse" "spectrum reflectance" 0.8
        Shape "trianglemesh" "integer indices" [0 1 2  0 2 3] "point3 P" [-9 0 -9  9 0 -9  9 0 9  -9 0 9]
        {light}
    "#
    ))
}

/// What each geometry of a scene of meshes receives: `irradiance` at a point with a normal, as the observer there measures it, over
/// the surface in the observers' measure; from `points` points of each triangle.
pub fn received(built: &BuiltScene, points: u64, mut irradiance: impl FnMut(DVec3, DVec3, &Observer) -> f64) -> Vec<f64> {
    let scene = &built.scene;
    let mut received = vec![0.0; scene.shapes.len()];
    for (g, geometry) in scene.world.geometries.iter().enumerate() {
        let Geometry::Mesh(mesh) = geometry else { panic!("made of triangles") };
        for triangle in 0..mesh.triangles.len() as u32 {
            let area = triangle_area(mesh.corners(triangle));
            for i in 0..points {
                let u = Vec2::new(((i as f64 + 0.5) / points as f64) as f32, random(i, 7 + u64::from(triangle)) as f32);
                let (x, b) = sample_triangle(mesh.corners(triangle), u);
                let observer = scene.observer(bhs_core::spacetime::Place::near(x)).expect("outside");
                let normal = mesh.surface(triangle, b).normal;
                let measure = area * observer.frame.area_factor(normal) / points as f64;
                received[g] += irradiance(x, normal, &observer) * measure;
            }
        }
    }
    received
}
