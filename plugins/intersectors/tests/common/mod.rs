//! Geometry and segments for the tests, made by rule, so that nothing has to be there.

#![allow(dead_code)] // each test program uses its part

use bhs_core::geometry::instance::Object;
use bhs_core::geometry::{Aabb, Analytic, AreaSample, Geometry, Segment, SurfaceGeometry, TriangleMesh, WorldMesh};
use bhs_core::intersector::{Intersector, IntersectorBuilder};
use bhs_core::sampling::mix64;
use bhs_intersectors::{embree::Embree, reference::Reference};
use glam::{DAffine3, DMat3, DVec3, Vec2};
use std::collections::HashMap;
use std::f64::consts::TAU;
use std::sync::Arc;

/// What the fast intersector is built from.
pub fn embree(geometries: &[Geometry]) -> Box<dyn Intersector> {
    Embree.build(geometries).unwrap()
}

/// The oracle over the same geometry.
pub fn reference(geometries: &[Geometry]) -> Box<dyn Intersector> {
    Reference.build(geometries).unwrap()
}

/// Random numbers that are the same every time.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        Self(mix64(seed))
    }

    /// Uniform in 0..1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (mix64(self.0) >> 11) as f64 * 2f64.powi(-53)
    }

    /// Uniform in the cube from -1 to 1.
    pub fn point(&mut self) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| 2.0 * self.unit() - 1.0))
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> DVec3 {
        let (z, phi) = (2.0 * self.unit() - 1.0, TAU * self.unit());
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * phi.cos(), r * phi.sin(), z)
    }
}

/// All of the line ahead.
pub fn ray(origin: DVec3, direction: DVec3) -> Segment {
    Segment { origin, direction, t_min: 0.0, t_max: f64::INFINITY }
}

/// A mesh in single precision.
pub fn mesh(positions: &[DVec3], triangles: Vec<[u32; 3]>) -> TriangleMesh {
    let positions = positions.iter().map(|p| p.as_vec3().to_array()).collect();
    TriangleMesh { positions, triangles, ..Default::default() }
}

pub fn shared(mesh: TriangleMesh) -> Geometry {
    Geometry::Mesh(Arc::new(mesh))
}

/// A mesh as an object has it, `size` times as large and moved.
pub fn defined(mesh: &TriangleMesh, size: f64, at: DVec3) -> WorldMesh {
    let positions = mesh.positions.iter().map(|p| DVec3::from_array(p.map(f64::from)) * size + at).collect();
    WorldMesh { positions, triangles: mesh.triangles.clone(), ..Default::default() }
}

/// The geometries of an instance.
pub fn place(object: &Arc<Object>, world_from_defined: DAffine3) -> Vec<Geometry> {
    object.place(world_from_defined, DVec3::ZERO).unwrap().into_iter().map(Geometry::Instance).collect()
}

/// Turned, `size` times as large, mirrored or not, anywhere in the cube from -1 to 1.
pub fn similarity(random: &mut Random, size: f64) -> DAffine3 {
    let turn = DMat3::from_axis_angle(random.direction(), TAU * random.unit());
    let mirror = DVec3::new(if random.unit() < 0.5 { -1.0 } else { 1.0 }, 1.0, 1.0);
    DAffine3::from_mat3_translation(turn * DMat3::from_diagonal(size * mirror), random.point())
}

/// A unit sphere of `20 * 4^levels` triangles, closed, with shared vertices.
pub fn icosphere(levels: u32) -> TriangleMesh {
    let g = (1.0 + 5f64.sqrt()) / 2.0;
    let corners = [(-1., g, 0.), (1., g, 0.), (-1., -g, 0.), (1., -g, 0.), (0., -1., g), (0., 1., g)];
    let corners =
        corners.into_iter().chain([(0., -1., -g), (0., 1., -g), (g, 0., -1.), (g, 0., 1.), (-g, 0., -1.), (-g, 0., 1.)]);
    let mut positions: Vec<DVec3> = corners.map(|p| DVec3::from(p).normalize()).collect();
    let around = |top: u32, ring: [u32; 5]| (0..5).map(move |i| [top, ring[i], ring[(i + 1) % 5]]);
    let mut triangles: Vec<[u32; 3]> = around(0, [11, 5, 1, 7, 10]).chain(around(3, [9, 4, 2, 6, 8])).collect();
    triangles.extend([[1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8]]);
    triangles.extend([[4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1]]);
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        let mut finer = Vec::with_capacity(4 * triangles.len());
        for [a, b, c] in triangles {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        triangles = finer;
    }
    mesh(&positions, triangles)
}

/// The cube from -1 to 1, each face cut into `n * n` squares, as a closed mesh with shared vertices.
pub fn cube(n: u32) -> TriangleMesh {
    let (mut positions, mut numbers) = (Vec::new(), HashMap::new());
    let mut vertex = |p: [u32; 3]| {
        *numbers.entry(p).or_insert_with(|| {
            positions.push(DVec3::from_array(p.map(|x| 2.0 * f64::from(x) / f64::from(n) - 1.0)));
            positions.len() as u32 - 1
        })
    };
    let mut triangles = Vec::new();
    for (axis, side, i, j) in
        (0..3).flat_map(|a| [0, n].map(|s| (a, s))).flat_map(|(a, s)| (0..n * n).map(move |k| (a, s, k / n, k % n)))
    {
        let [a, b, c, d] = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| {
            let mut p = [0; 3];
            (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (side, i, j);
            vertex(p)
        });
        triangles.extend([[a, b, c], [a, c, d]]);
    }
    mesh(&positions, triangles)
}

/// Triangles of all sizes and shapes anywhere in the cube from -1 to 1, slivers among them.
pub fn soup(random: &mut Random, triangles: u32) -> TriangleMesh {
    let mut positions = Vec::new();
    for _ in 0..triangles {
        let (place, size) = (random.point(), 10f64.powf(-2.0 * random.unit()));
        positions.extend([place, place + random.point() * size, place + random.point() * size]);
    }
    mesh(&positions, (0..triangles).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

/// A sphere, as far as intersectors ask.
pub struct Ball {
    pub center: DVec3,
    pub radius: f64,
}

impl Analytic for Ball {
    fn bounds(&self) -> Aabb {
        Aabb { min: self.center, max: self.center }.grown(self.radius)
    }

    fn intersect(&self, segment: &Segment) -> Option<f64> {
        let (o, d) = (segment.origin - self.center, segment.direction);
        let (a, b) = (d.length_squared(), o.dot(d));
        // As in Haines et al. 2019, Ray Tracing Gems chapter 7: the distance of the line from the center, without cancellation.
        let across = o - d * (b / a);
        let root = (a * (self.radius * self.radius - across.length_squared())).sqrt();
        let q = -b - root.copysign(b);
        let (s, t) = (q / a, (o.length_squared() - self.radius * self.radius) / q);
        [s.min(t), s.max(t)].into_iter().find(|t| segment.t_min < *t && *t < segment.t_max)
    }

    fn surface(&self, point: DVec3) -> SurfaceGeometry {
        let normal = (point - self.center).normalize_or(DVec3::Z);
        SurfaceGeometry { normal, shading_normal: normal, uv: Vec2::ZERO, second_uv: None, colour: glam::Vec4::ONE }
    }

    fn area(&self) -> f64 {
        unimplemented!()
    }

    fn sample(&self, _: Vec2) -> AreaSample {
        unimplemented!()
    }

    fn pdf(&self, _: DVec3) -> f64 {
        unimplemented!()
    }

    fn rebase(&mut self, origin: DVec3) {
        self.center -= origin;
    }
}

pub fn ball(center: DVec3, radius: f64) -> Geometry {
    Geometry::Analytic(Arc::new(Ball { center, radius }))
}

/// What Embree is told, so that it takes the same code as for us: other code rounds otherwise.
const SAME_CODE: Option<&str> = if cfg!(target_arch = "x86_64") { Some("isa=sse4.2") } else { None };

/// What embree4-rs says, which calls the same library by other code.
pub struct Peer(embree4_rs::CommittedScene);

// embree4-rs overruns this type when it is too small.
const _: () =
    assert!(size_of::<embree4_sys::RTCRayHit>() >= 84, "RTCRayHit is too small for Embree 4.3 and newer: run ./bhs once");

impl Peer {
    pub fn new(mesh: &TriangleMesh) -> Self {
        let device = embree4_rs::Device::try_new(SAME_CODE).unwrap();
        let positions: Vec<_> = mesh.positions.iter().map(|p| (p[0], p[1], p[2])).collect();
        let triangles: Vec<_> = mesh.triangles.iter().map(|t| (t[0], t[1], t[2])).collect();
        let geometry = embree4_rs::geometry::TriangleMeshGeometry::try_new(&device, &positions, &triangles).unwrap();
        let options = embree4_rs::SceneOptions { flags: embree4_sys::RTCSceneFlags::ROBUST, ..Default::default() };
        let scene = embree4_rs::Scene::try_new(device, options).unwrap();
        scene.attach_geometry(&geometry).unwrap();
        Self(scene.commit().unwrap())
    }

    /// The parameter and the triangle of the closest hit.
    pub fn closest(&self, segment: &Segment) -> Option<(f32, u32)> {
        let (o, d) = (segment.origin.as_vec3(), segment.direction.as_vec3());
        let ray = embree4_sys::RTCRay {
            org_x: o.x,
            org_y: o.y,
            org_z: o.z,
            dir_x: d.x,
            dir_y: d.y,
            dir_z: d.z,
            tnear: segment.t_min as f32,
            tfar: segment.t_max as f32,
            ..Default::default()
        };
        self.0.intersect_1(ray, None).unwrap().map(|found| (found.ray.tfar, found.hit.primID))
    }
}
