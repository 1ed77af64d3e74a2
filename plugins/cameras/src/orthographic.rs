//! `orthographic`: all rays start side by side, in the same direction.
//!
//! The rays start on the plane z = 0 of camera space, where the screen window lies in scene units, and look along +z. Each is that of the
//! observer where it starts: near a hole their clocks, and so the wavelengths that they see, differ across the picture, and lines that
//! are parallel for them are not parallel in the chart.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `frameaspectratio` | float | width/height | | aspect ratio of the screen window |
//! | `screenwindow` | float | [-aspect aspect -1 1] | scene | window that is seen: x from, x to, y from, y to |
//! | `lensradius` | float | 0 | scene | radius of the lens; 0: everything is sharp |
//! | `focaldistance` | float | 1000000 | scene | distance, along the camera's z axis, of the plane that is sharp |
//!
//! ```bhs
//! LookAt 0 1 -5  0 1 0  0 1 0
//! Camera "orthographic" "float screenwindow" [-2 2 -1 1]
//! WorldBegin
//! ```

use crate::screen::{Lens, Screen, nearest_in};
use bhs_core::Plugin;
use bhs_core::camera::{Camera, CameraMatrices, CameraRay};
use bhs_core::params::Params;
use glam::{DAffine3, DVec2, DVec3, Vec2};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Camera> =
    Plugin { name: "orthographic", summary: "rays side by side, all in the same direction", build };

struct Orthographic {
    /// Camera space to render space.
    render_from_camera: DAffine3,
    screen: Screen,
    lens: Lens,
    /// The film's far corner (pixels).
    resolution: DVec2,
}

fn build(p: &Params) -> Option<Box<dyn Camera>> {
    let (screen, lens) = (Screen::read(p), Lens::read(p));
    let [x, y] = p.context().resolution.map(f64::from);
    let render_from_camera = p.context().world_from_object;
    Some(Box::new(Orthographic { render_from_camera, screen: screen?, lens, resolution: DVec2::new(x, y) }))
}

impl Camera for Orthographic {
    fn ray(&self, raster: DVec2, u: Vec2) -> CameraRay {
        let (origin, direction) = self.lens.refract(self.screen.at(raster).extend(0.0), DVec3::Z, u);
        let m = &self.render_from_camera;
        CameraRay { origin: m.transform_point3(origin), direction: m.transform_vector3(direction).normalize() }
    }

    fn position(&self) -> DVec3 {
        self.render_from_camera.transform_point3(self.screen.at(0.5 * self.resolution).extend(0.0))
    }

    fn nearest_origin(&self, point: DVec3) -> DVec3 {
        let (a, b) = (self.screen.at(DVec2::ZERO), self.screen.at(self.resolution));
        nearest_in(&self.render_from_camera, point, |p| {
            let on_screen = p.truncate().clamp(a.min(b), a.max(b)).extend(0.0);
            self.lens.nearest(on_screen, p)
        })
    }

    fn pixel_width(&self, _: f64) -> f64 {
        let m = self.render_from_camera.matrix3;
        self.screen.pixel() * m.x_axis.length().min(m.y_axis.length())
    }

    fn matrices(&self) -> Option<CameraMatrices> {
        Some(CameraMatrices {
            camera_from_render: self.render_from_camera.inverse(),
            screen_from_camera: Some(self.screen.ndc_from_screen(self.resolution)),
        })
    }

    fn rebase(&mut self, origin: DVec3) {
        self.render_from_camera.translation -= origin;
    }
}
