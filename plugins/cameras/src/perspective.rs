//! `perspective`: a pinhole camera, or one with a thin lens.
//!
//! Camera space is left-handed as in pbrt: +x right, +y up, +z into the picture. The directions are those that the observer at
//! the camera measures (at each point of the lens, the one there); near a hole they are not those of the chart.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `fov` | float | 90 | deg | field of view along the shorter side of the picture |
//! | `frameaspectratio` | float | width/height | | aspect ratio of the screen window |
//! | `screenwindow` | float | [-aspect aspect -1 1] | | window on the screen plane: x from, x to, y from, y to |
//! | `lensradius` | float | 0 | scene | radius of the lens; 0: everything is sharp |
//! | `focaldistance` | float | 1000000 | scene | distance, along the camera's z axis, of the plane that is sharp |
//!
//! ```bhs
//! LookAt 0 1 -5  0 1 0  0 1 0
//! Camera "perspective" "float fov" 40
//! WorldBegin
//! ```

use crate::screen::{Lens, Screen, nearest_in};
use bhs_core::Plugin;
use bhs_core::camera::{Camera, CameraMatrices, CameraRay, Projection, is_near_film};
use bhs_core::params::Params;
use bhs_elementary::Elementary;
use glam::{DAffine3, DMat4, DVec2, DVec3, DVec4, Vec2};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Camera> =
    Plugin { name: "perspective", summary: "a pinhole camera, or one with a thin lens", build };

struct Perspective {
    /// Camera space to render space.
    render_from_camera: DAffine3,
    /// The screen at z = 1.
    screen: Screen,
    lens: Lens,
    /// The film's far corner (pixels).
    resolution: DVec2,
}

/// From camera space to the screen at z = 1, after division by the fourth coordinate. The third one, which OpenEXR ignores, is 0 and 1 at
/// the distances 0.01 and 1000, as in pbrt-v4: a matrix with an inverse.
fn perspective() -> DMat4 {
    let (near, far) = (1e-2, 1e3);
    let depth = far / (far - near);
    DMat4::from_cols(DVec4::X, DVec4::Y, DVec4::new(0.0, 0.0, depth, 1.0), DVec4::new(0.0, 0.0, -depth * near, 0.0))
}

fn build(p: &Params) -> Option<Box<dyn Camera>> {
    let fov = p.get_in("fov", 90.0, 1e-6..=179.999, "deg", "field of view along the shorter side of the picture");
    let (screen, lens) = (Screen::read(p), Lens::read(p));
    let tan = (0.5 * fov).to_radians().tangent();
    let [x, y] = p.context().resolution.map(f64::from);
    let (screen, resolution) = (screen?.scaled(tan), DVec2::new(x, y));
    Some(Box::new(Perspective { render_from_camera: p.context().world_from_object, screen, lens, resolution }))
}

impl Camera for Perspective {
    fn ray(&self, raster: DVec2, u: Vec2) -> CameraRay {
        let (origin, direction) = self.lens.refract(DVec3::ZERO, self.screen.at(raster).extend(1.0), u);
        let m = &self.render_from_camera;
        CameraRay { origin: m.transform_point3(origin), direction: m.transform_vector3(direction).normalize() }
    }

    fn position(&self) -> DVec3 {
        self.render_from_camera.translation
    }

    fn nearest_origin(&self, point: DVec3) -> DVec3 {
        nearest_in(&self.render_from_camera, point, |p| self.lens.nearest(DVec3::ZERO, p))
    }

    fn pixel_width(&self, distance: f64) -> f64 {
        self.screen.pixel() * distance
    }

    fn matrices(&self) -> Option<CameraMatrices> {
        Some(CameraMatrices {
            camera_from_render: self.render_from_camera.inverse(),
            screen_from_camera: Some(self.screen.ndc_from_screen(self.resolution) * perspective()),
        })
    }

    fn projection(&self) -> Option<&dyn Projection> {
        // Through a lens light from one direction spreads over a disk of the film.
        self.lens.is_pinhole().then_some(self)
    }

    fn rebase(&mut self, origin: DVec3) {
        self.render_from_camera.translation -= origin;
    }
}

impl Projection for Perspective {
    fn project(&self, direction: DVec3, margin: f64, at: &mut dyn FnMut(DVec2, f64)) {
        let m = self.render_from_camera.matrix3;
        let seen = m.inverse() * direction;
        if seen.z <= 0.0 {
            return;
        }
        let on_screen = seen.truncate() / seen.z;
        let raster = self.screen.raster(on_screen);
        if is_near_film(raster, self.resolution, margin) {
            let pixel = self.screen.pixel_area() * m.determinant().abs();
            at(raster, pixel / (m * on_screen.extend(1.0)).length().powi(3));
        }
    }
}
