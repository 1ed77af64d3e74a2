//! Photons by place: those within a radius of a point.

use super::spectrum::COUNT;
use arrayvec::ArrayVec;
use bhs_core::sampling::{mix64, unit_f32};
use glam::{DVec3, IVec3, Vec3};

/// Light that has come to a rough surface by way of specular ones.
#[derive(Clone, Copy, Debug)]
pub struct Photon {
    /// Where, render space.
    pub point: Vec3,
    /// Unit chart direction in which one looks to see it.
    pub looked: Vec3,
    /// Unit chart normal of the surface.
    pub normal: Vec3,
    /// What it carries: radiance at E = 1 times area times solid angle (W nm^-1), at each of its wavelengths.
    pub flux: [f32; COUNT],
    /// Its wavelengths: see [`super::spectrum::Range::lambda`].
    pub first: f32,
    /// Wavelength at E = 1 here over that where it left.
    pub scale: f32,
    /// Expected number of such photons per area across and solid angle where it left; infinite if nothing else can find its light.
    pub density: f32,
    /// Specular surfaces that it met.
    pub bounces: u32,
    /// Whether it is of its first wavelength alone: colours have parted.
    pub is_single: bool,
}

/// Photons of a bucket that are kept, about: enough for noise of a few percent, and not more than a path has time for.
const MOST_IN_BUCKET: f32 = 512.0;

/// Photons in cells of a grid as wide as the disc around a point.
pub struct PhotonMap {
    radius: f32,
    /// Start of each bucket's photons among `photons`, and the end of the last.
    starts: Vec<u32>,
    photons: Vec<Photon>,
    /// Their points: most of those in the cells are outside of the disc, and nothing else is asked of them.
    points: Vec<Vec3>,
}

impl PhotonMap {
    /// The map of `photons` for discs of the given radius (scene units). Where very many are, in a focus, some stand for all of them.
    pub fn new(photons: &[Photon], radius: f64) -> Self {
        let radius = radius as f32;
        let buckets = photons.len().next_power_of_two().max(16);
        let bucket = |p: &Photon| hash(cell(p.point, radius)) & (buckets - 1);
        let mut counts = vec![0u32; buckets];
        photons.iter().for_each(|p| counts[bucket(p)] += 1);
        let share = |p: &Photon| (MOST_IN_BUCKET / counts[bucket(p)] as f32).min(1.0);
        let is_kept = |i: usize, p: &Photon| unit_f32((mix64(i as u64) >> 32) as u32) < share(p);
        // Photons are large: their numbers are sorted in their place.
        let mut starts = vec![0u32; buckets + 1];
        let mut kept: Vec<u32> = Vec::with_capacity(photons.len());
        for (i, p) in photons.iter().enumerate().filter(|(i, p)| is_kept(*i, p)) {
            kept.push(i as u32);
            starts[bucket(p) + 1] += 1;
        }
        (0..buckets).for_each(|b| starts[b + 1] += starts[b]);
        let (mut next, mut order) = (starts.clone(), vec![0u32; kept.len()]);
        for i in kept {
            let at = &mut next[bucket(&photons[i as usize])];
            order[*at as usize] = i;
            *at += 1;
        }
        let scaled = |p: &Photon| Photon { flux: p.flux.map(|f| f / share(p)), ..*p };
        let points = order.iter().map(|i| photons[*i as usize].point).collect();
        let photons = order.iter().map(|i| scaled(&photons[*i as usize])).collect();
        Self { radius, starts, photons, points }
    }

    /// The radius (scene units).
    pub fn radius(&self) -> f64 {
        f64::from(self.radius)
    }

    /// Calls `each` with all photons within the radius of `point`, always in the same order.
    #[inline]
    pub fn near(&self, point: DVec3, mut each: impl FnMut(&Photon)) {
        let point = point.as_vec3();
        // The cell of the point, and those that the disc reaches into.
        let corner = cell(point - Vec3::splat(self.radius), self.radius);
        let mask = self.starts.len() - 2;
        let mut seen = ArrayVec::<usize, 8>::new();
        for i in 0..8 {
            let bucket = hash(corner.wrapping_add(IVec3::new(i & 1, (i >> 1) & 1, i >> 2))) & mask;
            if seen.contains(&bucket) {
                continue;
            }
            seen.push(bucket);
            let all = self.starts[bucket] as usize..self.starts[bucket + 1] as usize;
            for i in all.filter(|i| self.points[*i].distance_squared(point) < self.radius * self.radius) {
                each(&self.photons[i]);
            }
        }
    }
}

/// The cell of a point: cells are as wide as a disc, so that one reaches into eight of them at most.
#[inline]
fn cell(point: Vec3, radius: f32) -> IVec3 {
    (point / (2.0 * radius)).floor().as_ivec3()
}

/// Teschner et al. 2003, "Optimized Spatial Hashing for Collision Detection of Deformable Objects".
#[inline]
fn hash(cell: IVec3) -> usize {
    let [x, y, z] = cell.to_array().map(|c| c as u32);
    let mixed = x.wrapping_mul(73_856_093) ^ y.wrapping_mul(19_349_663) ^ z.wrapping_mul(83_492_791);
    (mixed ^ (mixed >> 15)) as usize
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_finds_what_looking_at_all_finds() {
        let random = |i: u64| unit_f32((mix64(i) >> 32) as u32) * 4.0 - 2.0;
        let photon = |i: u64| Photon {
            point: Vec3::new(random(3 * i), random(3 * i + 1), 0.1 * random(3 * i + 2)),
            looked: Vec3::Z,
            normal: Vec3::Z,
            flux: [i as f32; COUNT],
            first: 0.0,
            scale: 1.0,
            density: 1.0,
            bounces: 1,
            is_single: false,
        };
        let photons: Vec<Photon> = (0..2000).map(photon).collect();
        for radius in [0.03, 0.2, 1.0] {
            let map = PhotonMap::new(&photons, radius);
            for i in 0..50 {
                let at = Vec3::new(random(7000 + i), random(8000 + i), 0.0);
                let mut found = Vec::new();
                map.near(at.as_dvec3(), |p| found.push(p.flux[0] as usize));
                found.sort_unstable();
                let near = |p: &&Photon| p.point.distance_squared(at) < map.radius * map.radius;
                let expected: Vec<usize> = photons.iter().filter(near).map(|p| p.flux[0] as usize).collect();
                assert_eq!(found, expected);
            }
        }
        PhotonMap::new(&[], 1.0).near(DVec3::ZERO, |_| panic!("there is none"));
        // In a focus fewer bring the same light.
        let focus: Vec<Photon> =
            (0..100_000).map(|i| Photon { point: Vec3::splat(1e-4), flux: [1.0; COUNT], ..photon(i) }).collect();
        let (mut count, mut light) = (0, 0.0);
        PhotonMap::new(&focus, 0.1).near(DVec3::ZERO, |p| (count, light) = (count + 1, light + f64::from(p.flux[0])));
        assert!((400..640).contains(&count) && (light / 1e5 - 1.0).abs() < 0.2, "{count} {light}");
    }
}
