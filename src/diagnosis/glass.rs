//! Glass that is inside out: normals that look inwards, where light takes the air for the glass.

use crate::lang::BuiltScene;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::geometry::{Aabb, Geometry};
use bhs_core::spacetime::Side;
use glam::{DVec2, DVec3, Vec2};
use std::collections::BTreeSet;

/// Code of glass that is inside out.
pub const INSIDE_OUT: &str = "glass-inside-out";

/// Sum of the area vectors of a surface over its area, up to which it counts as closed: scanned meshes have holes where they stood.
const CLOSED: f64 = 0.1;

/// Warns of closed surfaces of glass whose outer side is the inner one. A bubble in other glass is so by right, and so is all around a camera. Where
/// glass lies open, as the top of a lake does, nobody knows what is within it.
pub fn inside_out(built: &BuiltScene, found: &mut Vec<Diagnostic>) {
    let scene = &built.scene;
    let is_glass = |number: usize| scene.shapes[number].material.refractive_index().is_some_and(|eta| eta > 1.0);
    let glass: Vec<usize> = (0..scene.shapes.len()).filter(|number| is_glass(*number)).collect();
    let mut open: Option<bool> = None;
    let mut looked_at = BTreeSet::new();
    for number in &glass {
        // Instances of one shape are turned inside out together.
        let index = scene.shapes[*number].index;
        if !looked_at.insert(index) {
            continue;
        }
        let geometry = &scene.world.geometries[*number];
        let Some(enclosed) = enclosed_volume(geometry).filter(|volume| *volume < 0.0).map(|_| geometry.bounds()) else {
            continue;
        };
        let side = scene.world.side_of(*number as u32);
        let in_glass = || {
            let others = glass.iter().filter(|other| scene.shapes[**other].index != index);
            others.map(|other| scene.world.geometries[*other].bounds()).any(|around| holds(&around, &enclosed))
        };
        let around_camera = side == built.viewpoint.side && enclosed.contains(built.camera.position());
        if around_camera || in_glass() || side == Side::Far && glass.len() > 1 {
            continue;
        }
        if *open.get_or_insert_with(|| glass.iter().any(|other| enclosed_volume(&scene.world.geometries[*other]).is_none())) {
            return;
        }
        let Some((_, at)) = built.statements.shape(index) else { continue };
        found.push(
            Diagnostic::warning(INSIDE_OUT, "the normals of this glass look inwards: light takes its inside for the outside")
                .at(at.span, "a closed surface of a `dielectric`")
                .help("write `ReverseOrientation` before it, or turn the normals of the mesh"),
        );
    }
}

/// Whether one box holds another.
fn holds(outer: &Aabb, inner: &Aabb) -> bool {
    outer.contains(inner.min) && outer.contains(inner.max)
}

/// The volume within a closed surface, negative if its outer side is within; `None` if it is not closed, or has hardly any.
fn enclosed_volume(geometry: &Geometry) -> Option<f64> {
    let bounds = geometry.bounds();
    let middle = bounds.center();
    let (mut area, mut vector, mut volume) = (0.0, DVec3::ZERO, 0.0);
    let mut add = |point: DVec3, normal: DVec3, part: f64| {
        if part.is_finite() && normal.is_finite() {
            area += part;
            vector += normal * part;
            volume += (point - middle).dot(normal) * part / 3.0;
        }
    };
    match geometry {
        Geometry::Analytic(surface) => {
            const N: u32 = 32;
            let cell = |i: u32| (i as f32 + 0.5) / N as f32;
            for i in 0..N * N {
                let sample = surface.sample(Vec2::new(cell(i % N), cell(i / N)));
                add(sample.point, sample.normal, 1.0 / (sample.pdf * f64::from(N * N)));
            }
        }
        mesh => {
            let third = DVec2::splat(1.0 / 3.0);
            for triangle in 0..mesh.triangle_count() as u32 {
                let Some([a, b, c]) = mesh.corners(triangle) else { continue };
                let middle = (a + b + c) / 3.0;
                add(middle, mesh.surface(middle, triangle, third).normal, 0.5 * (b - a).cross(c - a).length());
            }
        }
    }
    let size = (bounds.max - bounds.min).length();
    (vector.length() <= CLOSED * area && volume.abs() > 1e-4 * area * size).then_some(volume)
}
