//! No ray gets to the wrong side of a surface, however close together surfaces are.
//!
//! Rays go through rooms of closed solids that are stacked, touch or nearly touch, and are passed on or thrown back at random at every
//! surface. Of each solid it is known whether the ray is inside: it must not enter one that it is in, leave one that it is not in, or
//! leave the room.

use crate::common;
use bhs::lang::BuiltScene;
use bhs_core::ray::{Arrival, Ray};
use bhs_core::sampling::mix64;
use glam::{DMat3, DVec3, EulerRot};
use std::fmt::Write;

/// Random numbers.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        (mix64(self.0) >> 11) as f64 / (1u64 << 53) as f64
    }

    fn within(&mut self, lo: f64, hi: f64) -> f64 {
        lo + (hi - lo) * self.unit()
    }

    fn direction(&mut self) -> DVec3 {
        let (z, phi) = (self.within(-1.0, 1.0), self.within(0.0, std::f64::consts::TAU));
        let r = (1.0 - z * z).sqrt();
        DVec3::new(r * phi.cos(), r * phi.sin(), z)
    }
}

/// Surfaces on the way of a path, at most.
const BOUNCES: u32 = 32;

/// A scene of closed solids in a closed room.
struct Rooms {
    text: String,
    /// The solid to which each geometry belongs; the room is number 0.
    solids: Vec<usize>,
    /// Objects that stand where `Translate` has them, after all shapes.
    instances: String,
    instanced: Vec<usize>,
    count: usize,
    turn: DMat3,
    at: DVec3,
}

impl Rooms {
    /// An empty room from -2 to 2, turned and moved.
    fn new(turn: DMat3, at: DVec3, split: bool) -> Self {
        let mut rooms =
            Self { text: String::new(), solids: Vec::new(), instances: String::new(), instanced: Vec::new(), count: 0, turn, at };
        rooms.brick(DVec3::splat(-2.0), DVec3::splat(2.0), split);
        rooms
    }

    fn place(&self, p: DVec3) -> DVec3 {
        self.turn * p + self.at
    }

    /// The corners of the faces of a box, anticlockwise from outside.
    fn faces(lo: DVec3, hi: DVec3) -> [[DVec3; 4]; 6] {
        let p = |x: bool, y: bool, z: bool| {
            DVec3::new(if x { hi.x } else { lo.x }, if y { hi.y } else { lo.y }, if z { hi.z } else { lo.z })
        };
        let (o, i) = (false, true);
        [
            [p(o, o, o), p(o, o, i), p(o, i, i), p(o, i, o)],
            [p(i, o, o), p(i, i, o), p(i, i, i), p(i, o, i)],
            [p(o, o, o), p(i, o, o), p(i, o, i), p(o, o, i)],
            [p(o, i, o), p(o, i, i), p(i, i, i), p(i, i, o)],
            [p(o, o, o), p(o, i, o), p(i, i, o), p(i, o, o)],
            [p(o, o, i), p(i, o, i), p(i, i, i), p(o, i, i)],
        ]
    }

    /// A box of one mesh, or of six.
    fn brick(&mut self, lo: DVec3, hi: DVec3, split: bool) {
        let faces = Self::faces(lo, hi).map(|face| face.map(|p| self.place(p)));
        let groups: Vec<&[[DVec3; 4]]> = if split { faces.chunks(1).collect() } else { vec![&faces] };
        for group in groups {
            let points: String = group.iter().flatten().map(|p| format!("{:?} {:?} {:?} ", p.x, p.y, p.z)).collect();
            let indices: String = (0..group.len())
                .map(|i| 4 * i)
                .fold(String::new(), |s, k| format!("{s}{} {} {} {} {} {} ", k, k + 1, k + 2, k, k + 2, k + 3));
            writeln!(self.text, "Shape \"trianglemesh\" \"point3 P\" [{points}] \"integer indices\" [{indices}]").unwrap();
            self.solids.push(self.count);
        }
        self.count += 1;
    }

    /// Shapes under this transform, which are one solid.
    fn shapes(&mut self, at: DVec3, shapes: &[&str]) {
        let m = self.turn;
        let [x, y, z, p] = [m.x_axis, m.y_axis, m.z_axis, self.place(at)].map(|c| format!("{:?} {:?} {:?}", c.x, c.y, c.z));
        writeln!(self.text, "AttributeBegin\nTransform [{x} 0 {y} 0 {z} 0 {p} 1]").unwrap();
        for shape in shapes {
            writeln!(self.text, "{shape}").unwrap();
            self.solids.push(self.count);
        }
        self.text.push_str("AttributeEnd\n");
        self.count += 1;
    }

    /// A box as an instance of the cube from 0 to 1.
    fn instance(&mut self, lo: DVec3, hi: DVec3) {
        let m = self.turn * DMat3::from_diagonal(hi - lo);
        let [x, y, z, p] = [m.x_axis, m.y_axis, m.z_axis, self.place(lo)].map(|c| format!("{:?} {:?} {:?}", c.x, c.y, c.z));
        writeln!(self.instances, "AttributeBegin\nTransform [{x} 0 {y} 0 {z} 0 {p} 1]\nObjectInstance \"cube\"\nAttributeEnd")
            .unwrap();
        self.instanced.push(self.count);
        self.count += 1;
    }

    fn build(&mut self, options: &str, more: &str) -> BuiltScene {
        let mut cube = Self::bare();
        cube.brick(DVec3::ZERO, DVec3::ONE, false);
        self.solids.append(&mut self.instanced);
        let Self { text, instances, .. } = &*self;
        let objects = if instances.is_empty() {
            String::new()
        } else {
            format!("ObjectBegin \"cube\"\n{}ObjectEnd\n{instances}", cube.text)
        };
        let overrides = bhs::lang::Overrides { without_camera: true, ..Default::default() };
        let built = common::build_with(&format!("{options}\nWorldBegin\n{more}\n{text}{objects}"), &overrides);
        assert_eq!(built.scene.world.geometries.len(), self.solids.len());
        built
    }

    fn bare() -> Self {
        let (text, instances) = (String::new(), String::new());
        Self { text, solids: vec![], instances, instanced: vec![], count: 0, turn: DMat3::IDENTITY, at: DVec3::ZERO }
    }

    /// Stacks of bricks that touch or leave `gap`, as meshes, as separate faces, or as instances.
    fn stacks(&mut self, gap: f64, kind: u32) {
        let brick = |rooms: &mut Self, lo: DVec3, hi: DVec3, k: u32| match k {
            0 => rooms.brick(lo, hi, false),
            1 => rooms.brick(lo, hi, true),
            _ => rooms.instance(lo, hi),
        };
        let mut k = 0;
        for (x, z) in [(-1.0, -1.0), (-1.0, 0.0), (0.0, -1.0), (0.5, 0.5)] {
            // The lowest stands on the floor, as near as the others are to each other.
            let mut y = -2.0 + gap;
            for height in [0.5, 0.25, 1e-3, 0.7] {
                let side = DVec3::new(1.0 - gap, height, 1.0 - gap);
                let lo = DVec3::new(x, y, z);
                brick(self, lo, lo + side, if kind == 3 { k % 3 } else { kind });
                y += height + gap;
                k += 1;
            }
        }
    }

    /// Slabs as wide as the room, which touch or leave `gap`: every hit is far from their edges.
    fn slabs(&mut self, gap: f64, instances: bool) {
        let mut y = -2.0 + gap;
        for height in [0.5, 0.25, 1e-3, 0.7, 1e-4] {
            let (lo, hi) = (DVec3::new(gap - 2.0, y, gap - 2.0), DVec3::new(2.0 - gap, y + height, 2.0 - gap));
            if instances {
                self.instance(lo, hi)
            } else {
                self.brick(lo, hi, false)
            }
            y += height + gap;
        }
    }

    /// Spheres, cylinders, disks and patches that touch each other, the floor and bricks.
    fn curved(&mut self, gap: f64) {
        self.shapes(DVec3::new(1.3, -1.5 + gap, -1.3), &["Shape \"sphere\" \"float radius\" 0.5"]);
        self.shapes(DVec3::new(1.3, -0.75 + 2.0 * gap, -1.3), &["Shape \"sphere\" \"float radius\" 0.25"]);
        // One sphere within the other, which it touches everywhere but for the gap.
        self.shapes(DVec3::new(1.3, 0.2, -1.3), &["Shape \"sphere\" \"float radius\" 0.4"]);
        let inner = format!("Shape \"sphere\" \"float radius\" {:?}", 0.4 - gap);
        self.shapes(DVec3::new(1.3, 0.2, -1.3), &[&inner]);
        let can = |radius: f64, lo: f64, hi: f64| {
            [
                format!("Shape \"cylinder\" \"float radius\" {radius:?} \"float zmin\" {lo:?} \"float zmax\" {hi:?}"),
                format!("ReverseOrientation\nShape \"disk\" \"float radius\" {radius:?} \"float height\" {lo:?}"),
                format!("ReverseOrientation\nShape \"disk\" \"float radius\" {radius:?} \"float height\" {hi:?}"),
            ]
        };
        for (radius, lo, hi) in [(0.5, -2.0 + gap, -1.0), (0.5, -1.0 + gap, -0.5), (0.5 - gap, -1.9, -1.3)] {
            let parts = can(radius, lo, hi);
            self.shapes(DVec3::new(-1.4, 1.4, 0.0), &parts.each_ref().map(String::as_str));
        }
    }
}

/// What became of rays.
#[derive(Default)]
struct Count {
    rays: u64,
    /// Rays that start where surfaces are close together.
    close: u64,
    /// Rays that end on the wrong side of something.
    wrong: u64,
}

/// Follows rays through the rooms, from above the solids, until so many have been traced. Says what went wrong.
fn follow(built: &BuiltScene, rooms: &Rooms, rays: u64, seed: u64, what: &str) -> Count {
    let mut random = Random(seed);
    let mut count = Count::default();
    while count.rays < rays {
        let start = DVec3::new(random.within(-0.8, 1.9), random.within(1.0, 1.9), random.within(-1.9, 1.9));
        let ray = Ray::new(rooms.place(start) - built.scene.world.origin, random.direction());
        if let Err(e) = path(built, rooms, ray, &mut random, &mut count) {
            count.wrong += 1;
            eprintln!("{what}, ray {}: {e}", count.rays);
        }
    }
    count
}

/// Follows one path, as long as pictures have them.
fn path(built: &BuiltScene, rooms: &Rooms, mut ray: Ray, random: &mut Random, count: &mut Count) -> Result<(), String> {
    let (scene, world) = (&built.scene, &built.scene.world);
    let mut inside = vec![false; rooms.count];
    inside[0] = true;
    for _ in 0..BOUNCES {
        count.rays += 1;
        count.close += u64::from(ray.leaving.is_some());
        let hit = match scene.integrator.trace(world, &ray).arrival {
            Arrival::Surface(hit) => hit,
            Arrival::Captured => break,
            other => return Err(format!("{ray:?} ends as {other:?}")),
        };
        let solid = rooms.solids[hit.geometry as usize];
        let normal = world.surface(&hit).normal;
        let enters = hit.direction.dot(normal) < 0.0;
        if enters == inside[solid] {
            let what = if enters { "enters" } else { "leaves" };
            return Err(format!("{ray:?} {what} solid {solid} at {hit:?}, inside {inside:?}"));
        }
        let passes = solid != 0 && random.unit() < 0.6;
        if passes {
            inside[solid] = enters;
        }
        // Straight on, anywhere on the right side, or almost along the surface.
        let side = if passes == enters { -normal } else { normal };
        let (choice, d) = (random.unit(), random.direction());
        let direction = match choice {
            c if c < 0.3 && passes => hit.direction,
            c if c < 0.9 => {
                if d.dot(side) < 0.0 {
                    -d
                } else {
                    d
                }
            }
            _ => (d - side * d.dot(side) + side * 10f64.powf(random.within(-7.0, -1.0))).normalize(),
        };
        if direction.dot(side) <= 0.0 {
            break;
        }
        ray = world.spawn(&hit, normal, direction);
    }
    Ok(())
}

/// How many rays for each test.
fn rays() -> u64 {
    // All of them by `BHS_RAYS=10000000 cargo test --release --test all watertight::`.
    std::env::var("BHS_RAYS").map_or(200_000, |n| n.parse().expect("BHS_RAYS is a number"))
}

/// The rooms that are looked at: gaps and places, some of them far from render space's origin.
fn settings(turn: DMat3, gaps: &[f64]) -> Vec<(f64, DMat3, DVec3, bool)> {
    let places = [(DVec3::ZERO, false), (DVec3::new(1e4, -2e4, 3e4), false), (DVec3::new(30.0, 50.0, -40.0), true)];
    gaps.iter().flat_map(|gap| places.map(|(at, far)| (*gap, turn, at, far))).collect()
}

/// Rooms with the walls and the solids of a kind, with gaps of some width.
type Fill = fn(&mut Rooms, f64, u32);

fn solids(rooms: &mut Rooms, gap: f64, kind: u32) {
    if kind < 4 { rooms.stacks(gap, kind) } else { rooms.curved(gap) }
}

fn slabs(rooms: &mut Rooms, gap: f64, kind: u32) {
    rooms.slabs(gap, kind == 1);
}

/// Follows rays through rooms that `fill` fills in `kinds` ways; with a hole above the solids, if the options name an integrator.
fn all_rooms(rays: u64, options: &str, settings: &[(f64, DMat3, DVec3, bool)], kinds: u32, fill: Fill) -> Count {
    let each = rays / (u64::from(kinds) * settings.len() as u64) + 1;
    let mut sum = Count::default();
    for (number, &(gap, turn, at, far)) in settings.iter().enumerate() {
        for kind in 0..kinds {
            let mut rooms = Rooms::new(turn, at, kind == 1);
            fill(&mut rooms, gap, kind);
            if far {
                // What keeps render space's origin far from the room.
                rooms.brick(DVec3::splat(-400.0), DVec3::splat(-399.0), false);
            }
            let [x, y, z] = rooms.place(DVec3::new(0.2, 0.8, 0.3)).to_array();
            let hole = format!("BlackHole \"schwarzschild\" \"point3 center\" [{x:?} {y:?} {z:?}] \"float rs\" 0.1");
            let built = rooms.build(options, if options.contains("schwarzschild") { &hole } else { "" });
            let what = format!("gap {gap}, at {at}, kind {kind}");
            let count = follow(&built, &rooms, each, 1000 * number as u64 + u64::from(kind), &what);
            sum = Count { rays: sum.rays + count.rays, close: sum.close + count.close, wrong: sum.wrong + count.wrong };
        }
    }
    eprintln!(
        "{} rays, {} of which start where surfaces are close together; {} on the wrong side",
        sum.rays, sum.close, sum.wrong
    );
    sum
}

const GAPS: [f64; 4] = [0.0, 1e-7, 1e-6, 1e-4];

fn turned() -> DMat3 {
    DMat3::from_euler(EulerRot::YXZ, 0.3, 1.1, -0.7)
}

#[test]
fn no_ray_gets_to_the_wrong_side() {
    assert_eq!(all_rooms(rays(), "", &settings(DMat3::IDENTITY, &GAPS), 5, solids).wrong, 0);
}

#[test]
fn nor_in_rooms_that_are_turned() {
    // Corners are rounded to single precision: with less space between them, solids would reach into each other.
    assert_eq!(all_rooms(rays() / 4, "", &settings(turned(), &[1e-4]), 5, solids).wrong, 0);
}

#[test]
fn one_in_a_million_where_solids_reach_into_each_other_by_rounding() {
    // Where two surfaces cross at an angle of 1e-7, rounding of a point decides on which side of that line it is.
    let count = all_rooms(rays(), "", &settings(turned(), &GAPS[..3]), 5, solids);
    assert!(count.wrong <= 1 + count.rays / 500_000, "{} of {}", count.wrong, count.rays);
}

#[test]
fn nor_by_the_reference() {
    let options = "Option \"string intersector\" \"reference\"";
    assert_eq!(all_rooms(rays() / 10, options, &settings(DMat3::IDENTITY, &GAPS), 5, solids).wrong, 0);
}

#[test]
fn nor_around_a_hole() {
    for integrator in ["adaptive", "exact", "rk4"] {
        let options = format!("Integrator \"schwarzschild-{integrator}\"");
        let mut settings = settings(DMat3::IDENTITY, &GAPS);
        // Around a hole rays are followed as precisely as the whole scene is large.
        settings.retain(|(.., far)| !far);
        assert_eq!(all_rooms(rays() / 20, &options, &settings, 2, slabs).wrong, 0, "{integrator}");
    }
}
