//! `sphere`: an exact sphere around the origin of its own coordinates; an ellipsoid under a transform that stretches.
//!
//! The outer side is outside, mirrored by the transform or not; `ReverseOrientation` turns it inside. `zmin`, `zmax` and `phimax`
//! leave a part of the sphere, open where it is cut. Texture coordinates are pbrt's: u = phi/phimax with the azimuth phi
//! around z from x to y, v from 0 at `zmin` to 1 at `zmax` in proportion to the polar angle.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `radius` | float | 1 | scene | radius, above 0 |
//! | `zmin` | float | -radius | scene | the part below is left out |
//! | `zmax` | float | radius | scene | the part above is left out |
//! | `phimax` | float | 360 | degrees | the part at greater azimuth is left out |
//!
//! ```bhs
//! WorldBegin
//! Translate 0 1 0
//! Shape "sphere" "float radius" 0.5
//! ```

use crate::cone::Cone;
use crate::ellipsoid::{cofactors, part_area, whole_area};
use bhs_core::diagnostics::Diagnostic;
use bhs_core::geometry::{Aabb, Analytic, AreaSample, Segment, Shape, SurfaceGeometry, WorldGeometry};
use bhs_core::params::Params;
use bhs_core::plugin::Plugin;
use bhs_elementary::Elementary;
use glam::{DMat3, DVec3, Vec2, Vec4};
use std::f64::consts::TAU;

/// The entry in the list of shapes.
pub const PLUGIN: Plugin<dyn Shape> = Plugin { name: "sphere", summary: "an exact sphere or ellipsoid, or a part of one", build };

fn build(p: &Params) -> Option<Box<dyn Shape>> {
    let radius = p.get("radius", 1.0, "scene", "radius, above 0");
    let z_min = p.get("zmin", -radius, "scene", "the part below is left out");
    let z_max = p.get("zmax", radius, "scene", "the part above is left out");
    let phi_max = p.get("phimax", 360.0, "degrees", "the part at greater azimuth is left out");
    if radius <= 0.0 {
        p.reject("radius", "`radius` must be above 0", "");
        return None;
    }
    if !(0.0 < phi_max && phi_max <= 360.0) {
        p.reject("phimax", "`phimax` must be above 0 and at most 360", "");
        return None;
    }
    let (low, high) = (z_min.clamp(-radius, radius), z_max.clamp(-radius, radius));
    if low >= high {
        p.reject(
            "zmin",
            "nothing is left of the sphere between `zmin` and `zmax`",
            format!("z runs from {z_min} to {z_max}, on the sphere from {} to {radius}", -radius),
        );
        return None;
    }
    let to_world = p.context().world_from_object;
    let part = Part { z: [low / radius, high / radius], phi_max: if phi_max < 360.0 { phi_max.to_radians() } else { TAU } };
    let sphere = Sphere::new(to_world.translation, to_world.matrix3 * radius, part, p.context().reverse_orientation);
    if sphere.is_none() {
        p.report(
            Diagnostic::error("bad-transform", "the current transform flattens the sphere, or is out of range")
                .at(p.owner().span, ""),
        );
    }
    Some(Box::new(WorldGeometry::Analytic(Box::new(sphere?))))
}

/// What is left of the unit sphere.
#[derive(Clone, Copy)]
struct Part {
    z: [f64; 2],
    phi_max: f64,
}

impl Part {
    fn is_whole(&self) -> bool {
        self.z == [-1.0, 1.0] && self.phi_max == TAU
    }

    fn contains(&self, p: DVec3) -> bool {
        self.is_whole() || (self.z[0] <= p.z && p.z <= self.z[1] && azimuth(p) <= self.phi_max)
    }

    /// Its area on the unit sphere.
    fn solid_angle(&self) -> f64 {
        (self.z[1] - self.z[0]) * self.phi_max
    }
}

/// The angle around z, from 0 to 2 pi.
fn azimuth(p: DVec3) -> f64 {
    let phi = p.y.arctangent2(p.x);
    if phi < 0.0 { phi + TAU } else { phi }
}

/// The image of (a part of) the unit sphere under `center + world_from_unit p`.
struct Sphere {
    center: DVec3,
    world_from_unit: DMat3,
    unit_from_world: DMat3,
    /// Takes a point of the unit sphere to an outer normal whose length is the stretch of area there.
    outward: DMat3,
    part: Part,
    area: f64,
}

impl Sphere {
    /// `None` if the map is singular or out of the range of numbers.
    fn new(center: DVec3, world_from_unit: DMat3, part: Part, reverse: bool) -> Option<Self> {
        let unit_from_world = world_from_unit.inverse();
        let c = cofactors(world_from_unit);
        let area = if part.is_whole() { whole_area(c) } else { part_area(c, part.z[0], part.z[1], part.phi_max) };
        if !(center.is_finite() && unit_from_world.is_finite() && area.is_finite() && area > 0.0) {
            return None;
        }
        let inverts = (world_from_unit.determinant() < 0.0) != reverse;
        Some(Self { center, world_from_unit, unit_from_world, outward: if inverts { -c } else { c }, part, area })
    }

    /// The point of the unit sphere whose image is (nearest to) `point`.
    fn unit(&self, point: DVec3) -> DVec3 {
        (self.unit_from_world * (point - self.center)).try_normalize().unwrap_or(DVec3::Z)
    }

    fn surface_at(&self, p: DVec3) -> SurfaceGeometry {
        let normal = (self.outward * p).normalize();
        let [v0, v1] = self.part.z.map(Elementary::arccosine);
        let v = (p.z.clamp(-1.0, 1.0).arccosine() - v0) / (v1 - v0);
        let uv = Vec2::new((azimuth(p) / self.part.phi_max) as f32, v as f32).clamp(Vec2::ZERO, Vec2::ONE);
        SurfaceGeometry { normal, shading_normal: normal, uv, second_uv: None, colour: Vec4::ONE }
    }

    /// Density by area of the image of a uniform point of the unit sphere, at `p` of it.
    fn density(&self, p: DVec3) -> f64 {
        1.0 / (self.part.solid_angle() * self.stretch(p))
    }

    /// By how much the map stretches areas at `p` of the unit sphere.
    fn stretch(&self, p: DVec3) -> f64 {
        (self.outward * p).length()
    }

    /// The cone in which the unit sphere is seen from where the map takes `place` from; `None` if that sees all of it, and of a part, most of which may be
    /// out of sight. The map keeps straight lines and what they meet first: of an ellipsoid too the cone has just what is seen.
    fn cone(&self, place: DVec3) -> Option<Cone> {
        self.part.is_whole().then(|| Cone::new(self.unit_from_world * (place - self.center)))?
    }

    /// The sample whose point is the image of `p`, drawn with the density `pdf`.
    fn area_sample(&self, p: DVec3, pdf: f64) -> AreaSample {
        let SurfaceGeometry { normal, uv, .. } = self.surface_at(p);
        AreaSample { point: self.center + self.world_from_unit * p, normal, uv, pdf }
    }
}

impl Analytic for Sphere {
    fn bounds(&self) -> Aabb {
        // The whole ellipsoid reaches as far along an axis as that row of the matrix is long; a part lies in the image of its
        // slab too.
        let rows = self.world_from_unit.transpose();
        let reach = DVec3::new(rows.x_axis.length(), rows.y_axis.length(), rows.z_axis.length());
        let [low, high] = self.part.z;
        let slab = Aabb { min: DVec3::new(-1.0, -1.0, low), max: DVec3::new(1.0, 1.0, high) };
        let image = slab.corners().into_iter().fold(Aabb::EMPTY, |b, p| b.with_point(self.world_from_unit * p));
        Aabb { min: self.center + image.min.max(-reach), max: self.center + image.max.min(reach) }
    }

    fn may_pass(&self, middle: DVec3, half: DVec3) -> bool {
        // The box lies within a ball, and its image within a ball that is wider by no more than the matrix' Frobenius norm.
        let m = self.unit_from_world;
        let norm = (m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared()).sqrt();
        let (at, reach) = ((m * (middle - self.center)).length(), norm * half.length());
        at - reach <= 1.0 && at + reach >= 1.0
    }

    fn intersect(&self, segment: &Segment) -> Option<f64> {
        let o = self.unit_from_world * (segment.origin - self.center);
        let d = self.unit_from_world * segment.direction;
        // |o + t d| = 1, without cancellation for far and small spheres: the discriminant from the point of the line that is
        // nearest to the center (Haines et al. 2019, Ray Tracing Gems, chapter 7), one root from the other by their product.
        let (a, b) = (d.length_squared(), o.dot(d));
        let nearest = o - d * (b / a);
        let discriminant = 1.0 - nearest.length_squared();
        if !(discriminant >= 0.0 && a > 0.0) {
            return None;
        }
        let q = -(b + (a * discriminant).sqrt().copysign(b));
        let distance = o.length();
        let c = (distance - 1.0) * (distance + 1.0);
        let (t0, t1) = (if q == 0.0 { 0.0 } else { c / q }, q / a);
        [t0.min(t1), t0.max(t1)]
            .into_iter()
            .find(|t| segment.t_min < *t && *t < segment.t_max && self.part.contains((o + d * *t).normalize_or_zero()))
    }

    fn intersect_again(&self, segment: &Segment) -> Option<f64> {
        let o = self.unit_from_world * (segment.origin - self.center);
        let d = self.unit_from_world * segment.direction;
        // |o + t d| = |o|
        let t = -2.0 * o.dot(d) / d.length_squared();
        (0.0 < t && t < segment.t_max && self.part.contains((o + d * t).normalize_or_zero())).then_some(t)
    }

    fn surface(&self, point: DVec3) -> SurfaceGeometry {
        self.surface_at(self.unit(point))
    }

    fn tangents(&self, point: DVec3) -> Option<[DVec3; 2]> {
        let p = self.unit(point);
        let r = p.x.hypotenuse(p.y);
        // At a pole any meridian is as good as another.
        let [cos, sin] = if r > 0.0 { [p.x / r, p.y / r] } else { [1.0, 0.0] };
        let [v0, v1] = self.part.z.map(Elementary::arccosine);
        let du = DVec3::new(-p.y, p.x, 0.0) * self.part.phi_max;
        let dv = DVec3::new(p.z * cos, p.z * sin, -r) * (v1 - v0);
        Some([du, dv].map(|d| self.world_from_unit * d))
    }

    fn area(&self) -> f64 {
        self.area
    }

    fn sample(&self, u: Vec2) -> AreaSample {
        let u = u.as_dvec2();
        let [low, high] = self.part.z;
        let z = low + (high - low) * u.x;
        let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
        let (sin, cos) = (self.part.phi_max * u.y).sine_cosine();
        let p = DVec3::new(r * cos, r * sin, z);
        self.area_sample(p, self.density(p))
    }

    fn pdf(&self, point: DVec3) -> f64 {
        self.density(self.unit(point))
    }

    fn sample_from(&self, place: DVec3, u: Vec2) -> AreaSample {
        let Some(cone) = self.cone(place) else { return self.sample(u) };
        let (p, density) = cone.sample(u.as_dvec2());
        self.area_sample(p, density / self.stretch(p))
    }

    fn pdf_from(&self, place: DVec3, point: DVec3) -> f64 {
        let p = self.unit(point);
        self.cone(place).map_or_else(|| self.density(p), |cone| cone.density(p) / self.stretch(p))
    }

    fn thickness(&self) -> f64 {
        // Twice the least half axis, which is no less than 1 over the Frobenius norm of the inverse.
        let m = self.unit_from_world;
        2.0 / (m.x_axis.length_squared() + m.y_axis.length_squared() + m.z_axis.length_squared()).sqrt()
    }

    fn rebase(&mut self, origin: DVec3) {
        self.center -= origin;
    }
}
