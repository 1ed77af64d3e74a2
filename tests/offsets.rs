//! A scene is the same wherever in the world it stands: the program moves it to its own origin before single precision begins.

use crate::common;
use bhs::lang::{BuiltScene, Overrides};
use bhs_core::ray::{Arrival, Ray};
use bhs_core::sampling::mix64;
use bhs_engine::integrator::Integrator;
use glam::DVec3;
use std::fmt::Write;

/// Random numbers: the `k`-th one of scene `scene`.
struct Random {
    scene: u64,
    k: u64,
}

impl Random {
    /// Uniform in `lo..hi`.
    fn within(&mut self, lo: f64, hi: f64) -> f64 {
        self.k += 1;
        lo + (hi - lo) * (mix64(mix64(self.scene) ^ self.k) >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Uniform in the cube of half the side `half`.
    fn point(&mut self, half: f64) -> DVec3 {
        DVec3::new(self.within(-half, half), self.within(-half, half), self.within(-half, half))
    }

    /// Any direction.
    fn direction(&mut self) -> DVec3 {
        loop {
            let p = self.point(1.0);
            if (0.01..1.0).contains(&p.length_squared()) {
                return p.normalize();
            }
        }
    }
}

/// The integrators that bend light.
const INTEGRATORS: [&str; 3] = ["schwarzschild-exact", "schwarzschild-adaptive", "schwarzschild-rk4"];

/// A random scene of about the size `size`: triangles, one of them without area and one of them twice, spheres, maybe walls.
/// Returns its text after `Translate`, and the hole's centre and radius.
fn surroundings(random: &mut Random, size: f64) -> (String, DVec3, f64) {
    let mut text = String::new();
    let mut triangle = |corners: [DVec3; 3]| {
        write!(text, "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point3 P\" [").unwrap();
        corners.iter().for_each(|p| write!(text, "{:?} {:?} {:?} ", p.x * size, p.y * size, p.z * size).unwrap());
        text.push_str("]\n");
    };
    let mut last = [DVec3::ZERO; 3];
    for _ in 0..random.within(4.0, 16.0) as usize {
        let (middle, half) = (random.point(1.0), random.within(0.1, 1.0));
        last = std::array::from_fn(|_| middle + random.point(half));
        triangle(last);
    }
    let [a, b, _] = last;
    triangle([a, b, b]);
    triangle(last);
    if random.within(0.0, 1.0) < 0.5 {
        // Three walls, each of two triangles.
        for axis in 0..3 {
            let (x, y) = (DVec3::AXES[axis] * 3.0, DVec3::AXES[(axis + 1) % 3] * 3.0);
            let corner = DVec3::splat(-1.5);
            triangle([corner, corner + x, corner + x + y]);
            triangle([corner, corner + x + y, corner + y]);
        }
    }
    for _ in 0..random.within(0.0, 3.0) as usize {
        let (p, radius) = (random.point(1.0) * size, random.within(0.05, 0.4) * size);
        writeln!(text, "AttributeBegin\nTranslate {:?} {:?} {:?}", p.x, p.y, p.z).unwrap();
        writeln!(text, "Shape \"sphere\" \"float radius\" {radius:?}\nAttributeEnd").unwrap();
    }
    let (center, rs) = (random.point(1.2) * size, random.within(0.01, 0.4) * size);
    let [x, y, z] = center.to_array();
    writeln!(text, "BlackHole \"schwarzschild\" \"point3 center\" [{x:?} {y:?} {z:?}] \"float rs\" {rs:?}").unwrap();
    (text, center, rs)
}

/// What an arrival is about.
fn outcome(a: &Arrival) -> (u8, u32, u32) {
    match a {
        Arrival::Surface(hit) => (0, hit.geometry, hit.primitive),
        Arrival::Sky(..) => (1, 0, 0),
        Arrival::Captured => (2, 0, 0),
        Arrival::OutOfSteps => (3, 0, 0),
    }
}

fn trace(built: &BuiltScene, ray: &Ray) -> Arrival {
    let integrator: &dyn Integrator = &*built.scene.integrator;
    integrator.trace(&built.scene.world, ray).arrival
}

#[test]
fn a_scene_a_hundred_thousand_sizes_away_is_the_same_scene() {
    let (mut rays, mut hits, mut other, mut beyond) = (0u32, 0u32, 0u32, 0u32);
    for number in 0..400 {
        let mut random = Random { scene: number, k: 0 };
        let size = 10f64.powf(random.within(-6.0, 6.0));
        let (text, center, rs) = surroundings(&mut random, size);
        let integrator = INTEGRATORS[number as usize % 3];
        let setting =
            if integrator.ends_with("rk4") { "step\" 0.02".to_owned() } else { format!("tolerance\" {:?}", 1e-4 * size) };
        let away = random.direction();
        // Both are moved to an origin of their own: what differs is what double precision rounds.
        let built = [20.0, 1e5].map(|sizes| {
            let at = away * sizes * size;
            let translate = format!("Translate {:?} {:?} {:?}", at.x, at.y, at.z);
            let text = format!("Integrator \"{integrator}\" \"float {setting}\nWorldBegin\n{translate}\n{text}");
            let overrides = Overrides { without_camera: true, ..Default::default() };
            (common::build_with(&text, &overrides), at)
        });
        let [near, far] = built;
        assert!((near.0.scene.world.origin - near.1).length() < size, "the near scene is moved to its own origin");
        assert!((far.0.scene.world.origin - far.1).length() < size, "the far scene is moved to its own origin");
        for _ in 0..100 {
            let (origin, target) = (random.point(1.4), random.point(1.0));
            let (origin, direction) = (origin * size, (target - origin).normalize());
            if (origin - center).length() < 1.001 * rs {
                continue;
            }
            let ray =
                |b: &(BuiltScene, DVec3), shift: DVec3| Ray::new(origin + shift + (b.1 - b.0.scene.world.origin), direction);
            let (a, b) = (trace(&near.0, &ray(&near, DVec3::ZERO)), trace(&far.0, &ray(&far, DVec3::ZERO)));
            rays += 1;
            if outcome(&a) != outcome(&b) {
                other += 1;
                // Single precision of the triangles decides, if rounding of the places moves one of its last digits.
                let beside =
                    |k: u32| DVec3::from_array(std::array::from_fn(|i| if k >> i & 1 == 0 { -1e-6 } else { 1e-6 })) * size;
                let near_edge = (0..8).any(|k| outcome(&trace(&near.0, &ray(&near, beside(k)))) != outcome(&a));
                assert!(near_edge, "scene {number} {integrator}: from {origin} along {direction}: {a:?} or {b:?}");
            } else if let (Arrival::Surface(a), Arrival::Surface(b)) = (&a, &b) {
                hits += 1;
                let shift = (near.0.scene.world.origin - near.1) - (far.0.scene.world.origin - far.1);
                let across = (a.point + shift - b.point).cross(a.direction).length() / size;
                beyond += u32::from(across > 1e-9);
                // Double precision at 1e5 sizes: 1e-11. Light that almost stays with the hole magnifies that.
                assert!(across < 1e-5, "scene {number} {integrator}: from {origin} along {direction}: {across:.1e}");
            }
        }
    }
    eprintln!("{rays} rays, {hits} hits, {beyond} of them more than 1e-9 apart, {other} rays end otherwise");
    assert!(rays > 35_000 && hits > 10_000 && beyond * 100 < hits && other * 1000 < rays);
}
