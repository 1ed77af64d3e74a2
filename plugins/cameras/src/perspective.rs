//! `perspective`: a pinhole camera.
//!
//! Camera space is left-handed as in pbrt: +x right, +y up, +z into the picture. The directions are those that the observer at
//! the camera measures; near a hole they are not those of the chart.
//!
//! | parameter | type | default | unit | meaning |
//! |---|---|---|---|---|
//! | `fov` | float | 90 | deg | field of view along the shorter side of the picture |
//! | `frameaspectratio` | float | width/height | | aspect ratio of the screen window |
//! | `screenwindow` | float | [-aspect aspect -1 1] | | window on the screen plane: x from, x to, y from, y to |
//!
//! ```bhs
//! LookAt 0 1 -5  0 1 0  0 1 0
//! Camera "perspective" "float fov" 40
//! WorldBegin
//! ```

use bhs_core::Plugin;
use bhs_core::camera::{Camera, CameraRay};
use bhs_core::params::Params;
use glam::{DAffine3, DVec2, DVec3, Vec2};

/// The entry of this file in the crate's list.
pub const PLUGIN: Plugin<dyn Camera> = Plugin { name: "perspective", summary: "a pinhole camera", build };

struct Perspective {
    /// Camera space to render space.
    render_from_camera: DAffine3,
    /// Camera-space x and y, at z = 1, of the film's corner (0, 0).
    corner: DVec2,
    /// Change of those for one pixel.
    per_pixel: DVec2,
}

fn build(p: &Params) -> Option<Box<dyn Camera>> {
    let fov = p.get_in("fov", 90.0, 1e-6..=179.999, "deg", "field of view along the shorter side of the picture");
    let resolution = DVec2::new(f64::from(p.context().resolution[0]), f64::from(p.context().resolution[1]));
    let given = p.optional::<f64>("frameaspectratio", "", "aspect ratio of the screen window, width over height if not given");
    let aspect = given.unwrap_or(resolution.x / resolution.y);
    if aspect <= 0.0 {
        p.reject("frameaspectratio", "`frameaspectratio` is out of range", "expected a positive number");
        return None;
    }
    let shorter_is_height = aspect > 1.0;
    let default = if shorter_is_height { [-aspect, aspect, -1.0, 1.0] } else { [-1.0, 1.0, -1.0 / aspect, 1.0 / aspect] };
    let window = p.optional::<Vec<f64>>("screenwindow", "", "window on the screen plane: x from, x to, y from, y to");
    let [x0, x1, y0, y1] = match window.as_deref() {
        None => default,
        Some(&[x0, x1, y0, y1]) if x0 != x1 && y0 != y1 => [x0, x1, y0, y1],
        Some(_) => {
            p.reject("screenwindow", "`screenwindow` expects 4 numbers", "x from, x to, y from, y to; not an empty window");
            return None;
        }
    };
    let tan = (0.5 * fov).to_radians().tan();
    Some(Box::new(Perspective {
        render_from_camera: p.context().world_from_object,
        corner: DVec2::new(x0, y1) * tan,
        per_pixel: DVec2::new(x1 - x0, y0 - y1) * tan / resolution,
    }))
}

impl Camera for Perspective {
    fn ray(&self, raster: DVec2, _: Vec2) -> CameraRay {
        let xy = self.corner + raster * self.per_pixel;
        CameraRay { origin: self.position(), direction: self.render_from_camera.transform_vector3(xy.extend(1.0)).normalize() }
    }

    fn position(&self) -> DVec3 {
        self.render_from_camera.translation
    }

    fn pixel_width(&self, distance: f64) -> f64 {
        self.per_pixel.abs().min_element() * distance
    }

    fn rebase(&mut self, origin: DVec3) {
        self.render_from_camera.translation -= origin;
    }
}
