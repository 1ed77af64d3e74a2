//! `cylinder`: an exact cylinder around the z axis of its own coordinates, open at both ends; elliptic and slanted under a transform
//! that stretches.
//!
//! The outer side is outside, mirrored by the transform or not; `ReverseOrientation` turns it inside. `phimax` leaves a part of it.
//! Texture coordinates are pbrt's: u = phi/phimax with the azimuth phi around z from x to y, v from 0 at `zmin` to 1 at `zmax`.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `radius` | float | 1 | scene | radius, above 0 |
//! | `zmin` | float | -1 | scene | one end |
//! | `zmax` | float | 1 | scene | the other end; the lower one is the first |
//! | `phimax` | float | 360 | degrees | the part at greater azimuth is left out |
//!
//! ```bhs
//! WorldBegin
//! Rotate -90 1 0 0
//! Shape "cylinder" "float radius" 0.2 "float zmin" 0 "float zmax" 2
//! ```

use crate::affine::{Affine, azimuth, phi_max};
use crate::ellipsoid::gauss_legendre;
use bhs_core::geometry::{Aabb, Analytic, AreaSample, Segment, Shape, SurfaceGeometry, WorldGeometry};
use bhs_core::params::Params;
use bhs_core::plugin::Plugin;
use bhs_elementary::Elementary;
use glam::{DVec3, Vec2, Vec4};

/// The entry in the list of shapes.
pub const PLUGIN: Plugin<dyn Shape> =
    Plugin { name: "cylinder", summary: "an exact cylinder, open at both ends, or a part of one", build };

/// Parts of the circumference whose lengths are found one by one.
const PARTS: usize = 16;

fn build(p: &Params) -> Option<Box<dyn Shape>> {
    let radius = p.get("radius", 1.0, "scene", "radius, above 0");
    let z_min: f64 = p.get("zmin", -1.0, "scene", "one end");
    let z_max: f64 = p.get("zmax", 1.0, "scene", "the other end; the lower one is the first");
    let phi_max = phi_max(p);
    if radius <= 0.0 {
        p.reject("radius", "`radius` must be above 0", "");
        return None;
    }
    if z_min == z_max {
        p.reject("zmin", "`zmin` and `zmax` are the same: nothing is left of the cylinder", "");
        return None;
    }
    let place = Affine::new(p, DVec3::new(radius, radius, 1.0))?;
    let mut cylinder = Cylinder { z: [z_min.min(z_max), z_min.max(z_max)], phi_max: phi_max?, place, area: 0.0 };
    cylinder.area = cylinder.quadrature();
    Some(Box::new(WorldGeometry::Analytic(Box::new(cylinder))))
}

/// The image of (a part of) a cylinder of radius 1.
struct Cylinder {
    z: [f64; 2],
    phi_max: f64,
    place: Affine,
    area: f64,
}

/// The outer unit normal of the cylinder of radius 1 at a point of it, or beside it.
fn normal_at(p: DVec3) -> DVec3 {
    DVec3::new(p.x, p.y, 0.0).normalize_or(DVec3::X)
}

impl Cylinder {
    fn contains(&self, p: DVec3) -> bool {
        self.z[0] <= p.z && p.z <= self.z[1] && azimuth(p) <= self.phi_max
    }

    fn surface_at(&self, p: DVec3) -> SurfaceGeometry {
        let normal = self.place.normal(normal_at(p));
        let [low, high] = self.z;
        let uv = Vec2::new((azimuth(p) / self.phi_max) as f32, ((p.z - low) / (high - low)) as f32);
        SurfaceGeometry {
            normal,
            shading_normal: normal,
            uv: uv.clamp(Vec2::ZERO, Vec2::ONE),
            second_uv: None,
            colour: Vec4::ONE,
        }
    }

    /// Area on the cylinder of radius 1.
    fn own_area(&self) -> f64 {
        (self.z[1] - self.z[0]) * self.phi_max
    }

    /// The image's area: that of every strip along the axis is stretched by its own factor. Gauss quadrature of 64 points in each
    /// of 16 parts: some 1e-9 for an ellipse 1000 times as long as it is wide.
    fn quadrature(&self) -> f64 {
        let nodes = gauss_legendre();
        let mean: f64 = (0..PARTS)
            .flat_map(|part| nodes.iter().map(move |(s, w)| ((part as f64 + s) / PARTS as f64, w / PARTS as f64)))
            .map(|(s, w)| {
                let (sin, cos) = (self.phi_max * s).sine_cosine();
                w * self.place.area_factor(DVec3::new(cos, sin, 0.0))
            })
            .sum();
        mean * self.own_area()
    }

    fn density(&self, p: DVec3) -> f64 {
        1.0 / (self.own_area() * self.place.area_factor(normal_at(p)))
    }
}

impl Analytic for Cylinder {
    fn bounds(&self) -> Aabb {
        let m = self.place.world_from_own;
        let reach =
            DVec3::new(m.x_axis.x.hypotenuse(m.y_axis.x), m.x_axis.y.hypotenuse(m.y_axis.y), m.x_axis.z.hypotenuse(m.y_axis.z));
        let ends = self.z.map(|z| self.place.center + m.z_axis * z);
        Aabb { min: ends[0].min(ends[1]) - reach, max: ends[0].max(ends[1]) + reach }
    }

    fn may_pass(&self, middle: DVec3, half: DVec3) -> bool {
        let (p, half) = (self.place.point_to_own(middle), self.place.half_to_own(half));
        let (r, reach) = (p.x.hypotenuse(p.y), half.x.hypotenuse(half.y));
        r - reach <= 1.0 && r + reach >= 1.0 && p.z - half.z <= self.z[1] && p.z + half.z >= self.z[0]
    }

    fn intersect(&self, segment: &Segment) -> Option<f64> {
        let o = self.place.point_to_own(segment.origin);
        let d = self.place.own_from_world * segment.direction;
        // As for a sphere, in the plane across the axis: the discriminant from the point of the line that is nearest to the axis (Haines et
        // al. 2019, Ray Tracing Gems, chapter 7), one root from the other by their product.
        let (p, w) = (o.truncate(), d.truncate());
        let (a, b) = (w.length_squared(), p.dot(w));
        let nearest = p - w * (b / a);
        let discriminant = 1.0 - nearest.length_squared();
        if !(discriminant >= 0.0 && a > 0.0) {
            return None;
        }
        let q = -(b + (a * discriminant).sqrt().copysign(b));
        let distance = p.length();
        let c = (distance - 1.0) * (distance + 1.0);
        let (t0, t1) = (if q == 0.0 { 0.0 } else { c / q }, q / a);
        [t0.min(t1), t0.max(t1)].into_iter().find(|t| segment.t_min < *t && *t < segment.t_max && self.contains(o + d * *t))
    }

    fn intersect_again(&self, segment: &Segment) -> Option<f64> {
        let o = self.place.point_to_own(segment.origin);
        let d = self.place.own_from_world * segment.direction;
        // As far from the axis as where it starts.
        let t = -2.0 * o.truncate().dot(d.truncate()) / d.truncate().length_squared();
        (0.0 < t && t < segment.t_max && self.contains(o + d * t)).then_some(t)
    }

    fn surface(&self, point: DVec3) -> SurfaceGeometry {
        self.surface_at(self.place.point_to_own(point))
    }

    fn tangents(&self, point: DVec3) -> Option<[DVec3; 2]> {
        let p = self.place.point_to_own(point);
        let [du, dv] = [DVec3::new(-p.y, p.x, 0.0) * self.phi_max, DVec3::Z * (self.z[1] - self.z[0])];
        Some([du, dv].map(|d| self.place.world_from_own * d))
    }

    fn area(&self) -> f64 {
        self.area
    }

    fn sample(&self, u: Vec2) -> AreaSample {
        let u = u.as_dvec2();
        let (sin, cos) = (self.phi_max * u.y).sine_cosine();
        let p = DVec3::new(cos, sin, self.z[0] + (self.z[1] - self.z[0]) * u.x);
        let SurfaceGeometry { normal, uv, .. } = self.surface_at(p);
        AreaSample { point: self.place.point_to_world(p), normal, uv, pdf: self.density(p) }
    }

    fn pdf(&self, point: DVec3) -> f64 {
        self.density(self.place.point_to_own(point))
    }

    fn thickness(&self) -> f64 {
        // Twice the least half axis across, which is no less than 1 over the norm of those rows of the inverse.
        let m = self.place.own_from_world.transpose();
        2.0 / (m.x_axis.length_squared() + m.y_axis.length_squared()).sqrt()
    }

    fn rebase(&mut self, origin: DVec3) {
        self.place.center -= origin;
    }
}
