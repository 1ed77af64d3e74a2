//! `disk`: an exact disk in a plane of constant z of its own coordinates; an ellipse under a transform that stretches.
//!
//! The outer side is that of +z, mirrored by the transform or not; `ReverseOrientation` turns it. `innerradius` leaves a ring and
//! `phimax` a sector. Texture coordinates are pbrt's: u = phi/phimax with the azimuth phi from x to y, v from 0 at `radius` to 1 at
//! `innerradius`. As a light it is sampled uniformly, with its hole and its sector (pbrt-v4 samples the whole disk). Under the area light
//! `thindisc` a disk that does not state its `innerradius` begins where that does.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `height` | float | 0 | scene | z of its plane |
//! | `radius` | float | 1 | scene | outer radius, above 0 |
//! | `innerradius` | float | 0 | scene | the part within is left out; less than `radius` |
//! | `phimax` | float | 360 | degrees | the part at greater azimuth is left out |
//!
//! ```bhs
//! WorldBegin
//! Rotate -90 1 0 0
//! Shape "disk" "float radius" 2 "float innerradius" 0.5
//! ```

use crate::affine::{Affine, azimuth, phi_max};
use bhs_core::geometry::{Aabb, Analytic, AreaSample, Segment, Shape, SurfaceGeometry, WorldGeometry};
use bhs_core::params::Params;
use bhs_core::plugin::Plugin;
use bhs_elementary::Elementary;
use glam::{DVec3, Vec2, Vec4};

/// The entry in the list of shapes.
pub const PLUGIN: Plugin<dyn Shape> =
    Plugin { name: "disk", summary: "an exact disk or ellipse, or a ring or sector of one", build };

fn build(p: &Params) -> Option<Box<dyn Shape>> {
    let height = p.get("height", 0.0, "scene", "z of its plane");
    let radius = p.get("radius", 1.0, "scene", "outer radius, above 0");
    let inner = p.get("innerradius", 0.0, "scene", "the part within is left out; less than `radius`");
    let phi_max = phi_max(p);
    if radius <= 0.0 {
        p.reject("radius", "`radius` must be above 0", "");
        return None;
    }
    if !(0.0 <= inner && inner < radius) {
        p.reject("innerradius", "`innerradius` must be at least 0 and less than `radius`", format!("the radius is {radius}"));
        return None;
    }
    // The unit disk, moved along its own axis.
    let mut place = Affine::new(p, DVec3::new(radius, radius, radius))?;
    place.center += place.world_from_own.z_axis * (height / radius);
    let opens = !p.is_given("innerradius");
    let disk = Disk { inner: inner / radius, opens, phi_max: phi_max?, place };
    Some(Box::new(WorldGeometry::Analytic(Box::new(disk))))
}

/// The image of (a part of) the unit disk in the plane z = 0.
struct Disk {
    inner: f64,
    /// Whether what it emits may say where it begins.
    opens: bool,
    phi_max: f64,
    place: Affine,
}

impl Disk {
    fn contains(&self, p: DVec3) -> bool {
        let r2 = p.x * p.x + p.y * p.y;
        self.inner * self.inner <= r2 && r2 <= 1.0 && azimuth(p) <= self.phi_max
    }

    fn surface_at(&self, p: DVec3) -> SurfaceGeometry {
        let normal = self.place.normal(DVec3::Z);
        let v = (1.0 - p.x.hypotenuse(p.y)) / (1.0 - self.inner);
        let uv = Vec2::new((azimuth(p) / self.phi_max) as f32, v as f32).clamp(Vec2::ZERO, Vec2::ONE);
        SurfaceGeometry { normal, shading_normal: normal, uv, second_uv: None, colour: Vec4::ONE }
    }
}

impl Analytic for Disk {
    fn bounds(&self) -> Aabb {
        // The whole ellipse reaches as far along an axis as that row of the matrix' first two columns is long.
        let (x, y) = (self.place.world_from_own.x_axis, self.place.world_from_own.y_axis);
        let reach = DVec3::new(x.x.hypotenuse(y.x), x.y.hypotenuse(y.y), x.z.hypotenuse(y.z));
        Aabb { min: self.place.center - reach, max: self.place.center + reach }
    }

    fn may_pass(&self, middle: DVec3, half: DVec3) -> bool {
        let (p, half) = (self.place.point_to_own(middle), self.place.half_to_own(half));
        let (r, reach) = (p.x.hypotenuse(p.y), half.x.hypotenuse(half.y));
        p.z.abs() <= half.z && r - reach <= 1.0 && r + reach >= self.inner
    }

    fn intersect(&self, segment: &Segment) -> Option<f64> {
        let o = self.place.point_to_own(segment.origin);
        let d = self.place.own_from_world * segment.direction;
        // Not a number, which no comparison lets through, for a line within the plane.
        let t = -o.z / d.z;
        (segment.t_min < t && t < segment.t_max && self.contains(o + d * t)).then_some(t)
    }

    fn surface(&self, point: DVec3) -> SurfaceGeometry {
        self.surface_at(self.place.point_to_own(point))
    }

    fn tangents(&self, point: DVec3) -> Option<[DVec3; 2]> {
        let p = self.place.point_to_own(point);
        let outwards = DVec3::new(p.x, p.y, 0.0).normalize_or(DVec3::X);
        let [du, dv] = [DVec3::new(-p.y, p.x, 0.0) * self.phi_max, outwards * (self.inner - 1.0)];
        Some([du, dv].map(|d| self.place.world_from_own * d))
    }

    fn area(&self) -> f64 {
        0.5 * (1.0 - self.inner) * (1.0 + self.inner) * self.phi_max * self.place.area_factor(DVec3::Z)
    }

    fn sample(&self, u: Vec2) -> AreaSample {
        let u = u.as_dvec2();
        let inside = self.inner * self.inner;
        let r = (inside + (1.0 - inside) * u.x).sqrt();
        let (sin, cos) = (self.phi_max * u.y).sine_cosine();
        let p = DVec3::new(r * cos, r * sin, 0.0);
        let SurfaceGeometry { normal, uv, .. } = self.surface_at(p);
        AreaSample { point: self.place.point_to_world(p), normal, uv, pdf: 1.0 / self.area() }
    }

    fn pdf(&self, _: DVec3) -> f64 {
        1.0 / self.area()
    }

    fn open(&mut self, inner: f64) -> bool {
        // A disk that a transform stretches is measured along its first axis.
        let inner = inner / self.place.world_from_own.x_axis.length();
        if self.opens && inner < 1.0 {
            self.inner = inner;
        }
        !self.opens || inner < 1.0
    }

    fn rebase(&mut self, origin: DVec3) {
        self.place.center -= origin;
    }
}
