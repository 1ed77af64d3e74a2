//! What the tests of this crate share: random numbers, and small worlds over the reference intersector.
#![allow(dead_code, reason = "every test file is a crate of its own and uses its part")]

use bhs_core::geometry::{Aabb, Analytic, AreaSample, Geometry, Segment, SurfaceGeometry, TriangleMesh};
use bhs_core::intersector::IntersectorBuilder;
use bhs_core::observer::Conventions;
use bhs_core::spacetime::{Class, Spherical};
use bhs_engine::world::World;
use bhs_intersectors::reference::Reference;
use glam::{DVec3, Vec2};
use std::ops::AddAssign;
use std::sync::Arc;

/// Random numbers (SplitMix64, Steele et al. 2014).
pub struct Dice(pub u64);

impl Dice {
    /// Uniform in 0..1.
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in `lo..hi`.
    pub fn within(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    /// Uniform in the cube of half the side `half`.
    pub fn point(&mut self, half: f64) -> DVec3 {
        DVec3::new(self.within(-half, half), self.within(-half, half), self.within(-half, half))
    }

    /// A uniform direction.
    pub fn direction(&mut self) -> DVec3 {
        let z = self.within(-1.0, 1.0);
        let (sin, cos) = self.within(0.0, std::f64::consts::TAU).sin_cos();
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * cos, r * sin, z)
    }
}

/// What `case` says of each of the numbers below `count`, added up; on all processors. The sum must not depend on the order.
pub fn on_all_processors<T: Default + AddAssign + Send>(count: u64, case: impl Fn(u64) -> T + Sync) -> T {
    let threads = std::thread::available_parallelism().map_or(1, |n| n.get() as u64);
    let sum_of_every = |first: u64| {
        let mut sum = T::default();
        for number in (first..count).step_by(threads as usize) {
            sum += case(number);
        }
        sum
    };
    std::thread::scope(|scope| {
        let running: Vec<_> = (0..threads).map(|first| scope.spawn(move || sum_of_every(first))).collect();
        let mut sum = T::default();
        for thread in running {
            sum += thread.join().unwrap_or_else(|failure| std::panic::resume_unwind(failure));
        }
        sum
    })
}

/// A sphere.
#[derive(Clone, Copy)]
pub struct Ball {
    pub center: DVec3,
    pub radius: f64,
}

impl Analytic for Ball {
    fn bounds(&self) -> Aabb {
        Aabb { min: self.center - self.radius, max: self.center + self.radius }
    }

    fn intersect(&self, s: &Segment) -> Option<f64> {
        let (o, d) = ((s.origin - self.center) / self.radius, s.direction / self.radius);
        let (a, b) = (d.length_squared(), o.dot(d));
        let h = o - d * (b / a);
        let root = (a * (1.0 - h.length_squared())).sqrt();
        let q = -(b + root.copysign(b));
        let c = (o.length() - 1.0) * (o.length() + 1.0);
        let (t0, t1) = (c / q, q / a);
        [t0.min(t1), t0.max(t1)].into_iter().find(|t| s.t_min < *t && *t < s.t_max)
    }

    fn intersect_again(&self, s: &Segment) -> Option<f64> {
        let t = -2.0 * (s.origin - self.center).dot(s.direction) / s.direction.length_squared();
        (t > 0.0 && t < s.t_max).then_some(t)
    }

    fn surface(&self, point: DVec3) -> SurfaceGeometry {
        let normal = (point - self.center).normalize();
        SurfaceGeometry { normal, shading_normal: normal, uv: Vec2::ZERO, second_uv: None, colour: glam::Vec4::ONE }
    }

    fn area(&self) -> f64 {
        4.0 * std::f64::consts::PI * self.radius * self.radius
    }

    fn sample(&self, _: Vec2) -> AreaSample {
        unreachable!("no test samples lights")
    }

    fn pdf(&self, _: DVec3) -> f64 {
        unreachable!("no test samples lights")
    }

    fn rebase(&mut self, origin: DVec3) {
        self.center -= origin;
    }
}

/// A world of these surfaces with a hole at `center`.
pub fn world(geometries: Vec<Geometry>, center: DVec3, rs: f64) -> World {
    let hole = Spherical { center, rs, charge_squared: 0.0 };
    let intersector = Reference.build(&geometries).expect("the meshes are sound");
    World::new(geometries, intersector, DVec3::ZERO).in_spacetime(Arc::new(hole), Conventions::NATURE)
}

/// The hole of a world that has one.
pub fn hole_of(world: &World) -> Spherical {
    match world.spacetime().class() {
        Class::Spherical(hole) => hole,
        other => panic!("no hole: {other:?}"),
    }
}

/// A mesh of triangles, each with its own corners.
pub fn mesh(triangles: &[[DVec3; 3]]) -> Geometry {
    let positions = triangles.iter().flatten().map(|p| p.as_vec3().to_array()).collect();
    let triangles = (0..triangles.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Geometry::Mesh(Arc::new(TriangleMesh { positions, triangles, ..Default::default() }))
}

/// An analytic sphere.
pub fn ball(center: DVec3, radius: f64) -> Geometry {
    Geometry::Analytic(Arc::new(Ball { center, radius }))
}

/// The twelve triangles of a box, watertight.
pub fn room(min: DVec3, max: DVec3) -> Geometry {
    let corner = |i: usize| {
        let pick = |bit: usize, lo: f64, hi: f64| if i & bit == 0 { lo } else { hi };
        DVec3::new(pick(1, min.x, max.x), pick(2, min.y, max.y), pick(4, min.z, max.z))
    };
    let positions = (0..8).map(|i| corner(i).as_vec3().to_array()).collect();
    let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = faces.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    Geometry::Mesh(Arc::new(TriangleMesh { positions, triangles, ..Default::default() }))
}

/// A sphere of triangles: an octahedron, its faces divided `levels` times and pushed out; watertight.
pub fn faceted_ball(center: DVec3, radius: f64, levels: u32) -> Geometry {
    let (x, y, z) = (DVec3::X, DVec3::Y, DVec3::Z);
    let mut faces = vec![[x, y, z], [y, -x, z], [-x, -y, z], [-y, x, z], [y, x, -z], [-x, y, -z], [-y, -x, -z], [x, -y, -z]];
    for _ in 0..levels {
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = ((a + b).normalize(), (b + c).normalize(), (c + a).normalize());
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            })
            .collect();
    }
    mesh(&faces.iter().map(|f| f.map(|p| center + p * radius)).collect::<Vec<_>>())
}
