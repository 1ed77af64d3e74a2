//! `spherical`: everything around one point in one picture.
//!
//! Camera space has +y up. `equirectangular`: the top row looks along +y, the left edge along +x, and the picture goes on towards +z.
//! `equalarea`: the octahedral map of equal solid angles (Clarberg 2008), +y in its middle, for square pictures. Directions are those that
//! the observer at the camera measures.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `mapping` | string | "equalarea" | | `equalarea` or `equirectangular` |
//!
//! ```bhs
//! Camera "spherical" "string mapping" "equirectangular"
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::camera::{Camera, CameraMatrices, CameraRay, Projection, is_near_film};
use bhs_core::equal_area::{equal_area_direction, equal_area_point};
use bhs_core::params::Params;
use bhs_elementary::Elementary;
use glam::{DAffine3, DVec2, DVec3, Vec2};
use std::f64::consts::{PI, TAU};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Camera> = Plugin { name: "spherical", summary: "everything around one point in one picture", build };

#[derive(Clone, Copy, PartialEq)]
enum Mapping {
    EqualArea,
    Equirectangular,
}

struct Spherical {
    /// Camera space to render space.
    render_from_camera: DAffine3,
    mapping: Mapping,
    /// Width and height (pixels).
    resolution: DVec2,
}

fn build(p: &Params) -> Option<Box<dyn Camera>> {
    let name = p.get("mapping", "equalarea".to_owned(), "", "`equalarea` or `equirectangular`");
    let mapping = match name.as_str() {
        "equalarea" => Mapping::EqualArea,
        "equirectangular" => Mapping::Equirectangular,
        _ => {
            p.reject("mapping", "unknown mapping", "expected `equalarea` or `equirectangular`");
            return None;
        }
    };
    let [x, y] = p.context().resolution.map(f64::from);
    Some(Box::new(Spherical { render_from_camera: p.context().world_from_object, mapping, resolution: DVec2::new(x, y) }))
}

impl Spherical {
    /// All points of the plane that the picture's map, which goes on over its edges, shows at the point `p` of the unit square.
    fn repeated(&self, p: DVec2) -> [DVec2; 9] {
        let (x, y) = (p.x, p.y);
        let all = match self.mapping {
            // Over an edge, one comes back half way along it.
            Mapping::EqualArea => [
                (x, y),
                (-x, 1.0 - y),
                (2.0 - x, 1.0 - y),
                (1.0 - x, -y),
                (1.0 - x, 2.0 - y),
                (x - 1.0, y - 1.0),
                (x - 1.0, y + 1.0),
                (x + 1.0, y - 1.0),
                (x + 1.0, y + 1.0),
            ],
            // Over a pole, one comes down on the other side of it.
            Mapping::Equirectangular => {
                let beyond = if x < 0.5 { x + 0.5 } else { x - 0.5 };
                [
                    (x, y),
                    (x - 1.0, y),
                    (x + 1.0, y),
                    (beyond, -y),
                    (beyond - 1.0, -y),
                    (beyond + 1.0, -y),
                    (beyond, 2.0 - y),
                    (beyond - 1.0, 2.0 - y),
                    (beyond + 1.0, 2.0 - y),
                ]
            }
        };
        all.map(|(x, y)| DVec2::new(x, y))
    }
}

impl Projection for Spherical {
    fn project(&self, direction: DVec3, margin: f64, at: &mut dyn FnMut(DVec2, f64)) {
        let m = self.render_from_camera.matrix3;
        let seen = (m.inverse() * direction).normalize();
        let up_is_z = DVec3::new(seen.x, seen.z, seen.y);
        let area = self.resolution.x * self.resolution.y;
        let (p, solid_angle) = match self.mapping {
            Mapping::EqualArea => (equal_area_point(up_is_z), 2.0 * TAU / area),
            Mapping::Equirectangular => {
                let across = up_is_z.truncate().length();
                let phi = up_is_z.y.arctangent2(up_is_z.x).rem_euclid(TAU);
                (DVec2::new(phi / TAU, across.arctangent2(up_is_z.z) / PI), across * PI * TAU / area)
            }
        };
        let solid_angle = solid_angle * m.determinant().abs() / (m * seen).length().powi(3);
        for raster in self.repeated(p).map(|p| p * self.resolution) {
            if is_near_film(raster, self.resolution, margin) {
                at(raster, solid_angle);
            }
        }
    }
}

impl Camera for Spherical {
    fn ray(&self, raster: DVec2, _: Vec2) -> CameraRay {
        let uv = raster / self.resolution;
        let up_is_z = match self.mapping {
            Mapping::EqualArea => equal_area_direction(uv),
            Mapping::Equirectangular => {
                let ((sin, cos), (sin_phi, cos_phi)) = ((PI * uv.y).sine_cosine(), (TAU * uv.x).sine_cosine());
                DVec3::new(sin * cos_phi, sin * sin_phi, cos)
            }
        };
        let direction = DVec3::new(up_is_z.x, up_is_z.z, up_is_z.y);
        CameraRay { origin: self.position(), direction: self.render_from_camera.transform_vector3(direction).normalize() }
    }

    fn position(&self) -> DVec3 {
        self.render_from_camera.translation
    }

    fn pixel_width(&self, distance: f64) -> f64 {
        let angle = match self.mapping {
            Mapping::EqualArea => (2.0 * TAU / (self.resolution.x * self.resolution.y)).sqrt(),
            Mapping::Equirectangular => (TAU / self.resolution.x).min(PI / self.resolution.y),
        };
        angle * distance
    }

    fn matrices(&self) -> Option<CameraMatrices> {
        Some(CameraMatrices { camera_from_render: self.render_from_camera.inverse(), screen_from_camera: None })
    }

    fn projection(&self) -> Option<&dyn Projection> {
        Some(self)
    }

    fn rebase(&mut self, origin: DVec3) {
        self.render_from_camera.translation -= origin;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_areas_are_equal_solid_angles() {
        // Solid angles of cells all over the square, each from small pieces: the sides of a cell are no great circles.
        const CELLS: u32 = 20;
        const PIECES: u32 = 20;
        let n = CELLS * PIECES;
        let corner = |i: u32, j: u32| equal_area_direction(DVec2::new(f64::from(i), f64::from(j)) / f64::from(n));
        // Two spherical triangles (Van Oosterom and Strackee 1983).
        let triangle = |a: DVec3, b: DVec3, c: DVec3| 2.0 * a.dot(b.cross(c)).abs().atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a));
        let cell = 4.0 * PI / f64::from(CELLS * CELLS);
        let mut sum = 0.0;
        for (x, y) in (0..CELLS).flat_map(|y| (0..CELLS).map(move |x| (x * PIECES, y * PIECES))) {
            let mut solid_angle = 0.0;
            for (i, j) in (y..y + PIECES).flat_map(|j| (x..x + PIECES).map(move |i| (i, j))) {
                let [a, b, c, d] = [corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1)];
                assert!((a.length() - 1.0).abs() < 1e-12);
                solid_angle += triangle(a, b, c) + triangle(a, c, d);
            }
            sum += solid_angle;
            assert!((solid_angle / cell - 1.0).abs() < 0.01, "{x} {y}: {solid_angle} {cell}");
        }
        assert!((sum / (4.0 * PI) - 1.0).abs() < 1e-3);
        assert_eq!(equal_area_direction(DVec2::splat(0.5)), DVec3::Z);
        assert!((equal_area_direction(DVec2::ZERO) + DVec3::Z).length() < 1e-12);
    }

    #[test]
    fn the_map_goes_on_over_its_edges() {
        for t in [0.1, 0.3, 0.8] {
            for (inside, outside) in [
                (DVec2::new(1e-9, t), DVec2::new(-1e-9, t)),
                (DVec2::new(1.0 - 1e-9, t), DVec2::new(1.0 + 1e-9, t)),
                (DVec2::new(t, 1e-9), DVec2::new(t, -1e-9)),
                (DVec2::new(t, 1.0 - 1e-9), DVec2::new(t, 1.0 + 1e-9)),
            ] {
                let gap = (equal_area_direction(inside) - equal_area_direction(outside)).length();
                assert!(gap < 1e-6, "{inside} {outside}: {gap}");
            }
        }
    }
}
