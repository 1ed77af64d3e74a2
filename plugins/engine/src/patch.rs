//! The patch of a surface that a pixel sees, for textures that are blurred over it.
//!
//! Light that bends makes a pixel's patch larger or smaller than its distance says, and turns it. So the patch is found by the integrator itself:
//! three rays, through the middle of the pixel and through those of two of its edges, say how the point moves that is seen (flat space: Igehy 1999,
//! "Tracing Ray Differentials"). They are followed once for a pixel, not for each of its samples, and only where a texture asks. At edges of
//! surfaces and of pictures of them there is no patch, and nothing is blurred but by the mean over the samples.

use crate::scene::{Scene, Vertex};
use bhs_core::ray::{Arrival, RayEnd, SurfaceHit};
use glam::DVec3;

/// The most that a patch is inclined to its surface, as a sine: beyond, its rays have met two parts of a surface that is bent.
const MOST_INCLINED: f64 = 0.7;

/// How far from its middle a patch counts, in half pixels: filters reach as far.
const REACH: f64 = 4.0;

/// What a pixel sees of one surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Index of the geometry.
    pub geometry: u32,
    /// What the middle of the pixel sees (render space).
    pub point: DVec3,
    /// By what that moves from there to the middle of the right edge, and to that of the lower edge.
    pub beside: [DVec3; 2],
}

impl Patch {
    /// Of the ends of the rays through the middle of a pixel and those of two of its edges; `None`: they do not see one surface.
    pub fn new(scene: &Scene, ends: &[RayEnd; 3]) -> Option<Self> {
        let surface = |end: &RayEnd| if let Arrival::Surface(hit) = end.arrival { Some(hit) } else { None };
        let middle: SurfaceHit = surface(&ends[0])?;
        let normal = scene.world.surface(&middle).normal;
        let beside = |end: &RayEnd| {
            let way = surface(end).filter(|hit| hit.geometry == middle.geometry)?.point - middle.point;
            let is_along = way.dot(normal).abs() <= MOST_INCLINED * way.length();
            (is_along && way != DVec3::ZERO).then_some(way)
        };
        Some(Self { geometry: middle.geometry, point: middle.point, beside: [beside(&ends[1])?, beside(&ends[2])?] })
    }

    /// Tells the vertex of a camera ray of this pixel of the patch, if it lies on it.
    pub fn fit(&self, scene: &Scene, vertex: &mut Vertex) {
        let reach = REACH * (self.beside[0].length() + self.beside[1].length());
        if vertex.hit.geometry != self.geometry || vertex.hit.point.distance(self.point) > reach {
            return;
        }
        let tangents = scene.world.tangents(&vertex.hit);
        vertex.shading.tangents.world = [tangents.dpdu, tangents.dpdv].map(|t| t.as_vec3());
        vertex.shading.beside = self.beside.map(|way| way.as_vec3());
    }
}
