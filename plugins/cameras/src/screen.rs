//! What the projecting cameras share: the window on the screen plane, and the lens.

use bhs_core::params::Params;
use bhs_core::sampling::concentric_disk;
use glam::{DAffine3, DMat4, DVec2, DVec3, Vec2};

/// Maps the film to the screen plane.
pub(crate) struct Screen {
    /// Screen coordinates of the film's corner (0, 0).
    corner: DVec2,
    /// Change of those for one pixel.
    per_pixel: DVec2,
}

/// Largest coordinate of a window, and its least width and height.
const LARGEST: f64 = 1e15;
const LEAST: f64 = 1e-15;

/// Whether a window may reach from `a` to `b`.
fn fits(a: f64, b: f64) -> bool {
    a.abs().max(b.abs()) <= LARGEST && (a - b).abs() >= LEAST
}

impl Screen {
    /// Reads the window: from -1 to 1 along the shorter side unless the scene says otherwise, as in pbrt-v4.
    pub fn read(p: &Params) -> Option<Self> {
        let resolution = DVec2::new(f64::from(p.context().resolution[0]), f64::from(p.context().resolution[1]));
        let about = "aspect ratio of the screen window, width over height if not given";
        let aspect = p.optional::<f64>("frameaspectratio", "", about).unwrap_or(resolution.x / resolution.y);
        let window = p.optional::<Vec<f64>>("screenwindow", "", "window on the screen plane: x from, x to, y from, y to");
        if !(1e-6..=1e6).contains(&aspect) {
            let cause = format!("expected a value from 0.000001 to 1000000, found {aspect}");
            p.reject("frameaspectratio", "`frameaspectratio` is out of range", cause);
            return None;
        }
        let shorter_is_height = aspect > 1.0;
        let default = if shorter_is_height { [-aspect, aspect, -1.0, 1.0] } else { [-1.0, 1.0, -1.0 / aspect, 1.0 / aspect] };
        let [x0, x1, y0, y1] = match window.as_deref() {
            None => default,
            Some(&[x0, x1, y0, y1]) if fits(x0, x1) && fits(y0, y1) => [x0, x1, y0, y1],
            Some([_, _, _, _]) => {
                let cause = format!("expected coordinates up to {LARGEST:e} that differ by at least {LEAST:e}");
                p.reject("screenwindow", "`screenwindow` is out of range", cause);
                return None;
            }
            Some(_) => {
                p.reject("screenwindow", "`screenwindow` expects 4 numbers", "x from, x to, y from, y to");
                return None;
            }
        };
        Some(Self { corner: DVec2::new(x0, y1), per_pixel: DVec2::new(x1 - x0, y0 - y1) / resolution })
    }

    /// The same window, larger by `factor`.
    pub fn scaled(self, factor: f64) -> Self {
        Self { corner: self.corner * factor, per_pixel: self.per_pixel * factor }
    }

    /// Screen coordinates of a point of the film (pixels).
    pub fn at(&self, raster: DVec2) -> DVec2 {
        self.corner + raster * self.per_pixel
    }

    /// The point of the film (pixels) that has the given screen coordinates.
    pub fn raster(&self, on_screen: DVec2) -> DVec2 {
        (on_screen - self.corner) / self.per_pixel
    }

    /// Area of a pixel, screen coordinates.
    pub fn pixel_area(&self) -> f64 {
        (self.per_pixel.x * self.per_pixel.y).abs()
    }

    /// From screen coordinates to the film of the given size (pixels), 0 to 1 from left to right and from top to bottom.
    pub fn ndc_from_screen(&self, resolution: DVec2) -> DMat4 {
        let scale = (self.per_pixel * resolution).recip();
        let offset = -self.corner * scale;
        DMat4::from_translation(offset.extend(0.0)) * DMat4::from_scale(scale.extend(1.0))
    }

    /// Width of a pixel along its shorter side, screen coordinates.
    pub fn pixel(&self) -> f64 {
        self.per_pixel.abs().min_element()
    }
}

/// A thin lens in the plane z = 0 of camera space.
#[derive(Clone, Copy)]
pub(crate) struct Lens {
    radius: f64,
    focal_distance: f64,
}

impl Lens {
    /// Reads radius and focal distance.
    pub fn read(p: &Params) -> Self {
        let radius = p.get_in("lensradius", 0.0, 0.0..=1e15, "scene", "radius of the lens; 0: everything is sharp");
        let about = "distance, along the camera's z axis, of the plane that is sharp";
        let focal_distance = p.get_in("focaldistance", 1e6, 1e-15..=1e30, "scene", about);
        Self { radius, focal_distance }
    }

    /// Whether it has no width, so that everything is sharp.
    pub fn is_pinhole(self) -> bool {
        self.radius == 0.0
    }

    /// Moves a ray of camera space, whose direction has the z component 1, from its place to one of the lens around it; it meets the same
    /// point of the plane that is sharp. `u`: two numbers in [0,1).
    pub fn refract(self, origin: DVec3, direction: DVec3, u: Vec2) -> (DVec3, DVec3) {
        if self.is_pinhole() {
            return (origin, direction);
        }
        let on_lens = (concentric_disk(u).as_dvec2() * self.radius).extend(0.0);
        (origin + on_lens, direction - on_lens / self.focal_distance)
    }

    /// The nearest to `point` (camera space) of the places on the lens around `center`.
    pub fn nearest(self, center: DVec3, point: DVec3) -> DVec3 {
        center + (point - center).truncate().clamp_length_max(self.radius).extend(0.0)
    }
}

/// The place of render space nearest to `point` among those that `nearest` finds in camera space.
pub(crate) fn nearest_in(render_from_camera: &DAffine3, point: DVec3, nearest: impl Fn(DVec3) -> DVec3) -> DVec3 {
    render_from_camera.transform_point3(nearest(render_from_camera.inverse().transform_point3(point)))
}
