//! What is said of a ray, as a line of JSON or of comma-separated values.

use super::{Answers, Asked, Format};
use bhs_core::ray::{Arrival, Ray, RayEnd};
use bhs_core::spacetime::{Place, Side};
use bhs_engine::layer::VisibleSurface;
use bhs_engine::scene::Scene;
use bhs_engine::way::WayPoint;
use bhs_layers::orbit::{Constants, impact_parameter, swept_angle};
use bhs_layers::redshift;
use glam::DVec3;
use std::f64::consts::TAU;
use std::fmt::Write as _;

/// The columns of answers in CSV.
pub(super) const COLUMNS: &str = "ox,oy,oz,dx,dy,dz,start_side,footprint,outcome,x,y,z,end_dx,end_dy,end_dz,shape,shape_name,shape_place,side,phi,steps,queries,\
                                  time,redshift,b,L,Q,winding\n";

/// The columns of points of ways in CSV.
pub(super) const PATH_COLUMNS: &str = "ray,point,x,y,z,side,phi,time,redshift,dx,dy,dz\n";

/// What is known of the light that arrives along a ray; `None` of what it does not have.
struct Light {
    /// Coordinate time from the surface to where the ray starts (scene units).
    time: Option<f64>,
    /// `nu_observed / nu_emitted`
    redshift: Option<f64>,
    /// Impact parameter (scene units).
    b: Option<f64>,
    constants: Option<Constants>,
    /// Turns around the hole.
    winding: Option<f64>,
}

impl Light {
    /// That along `ray` (render space), which has come to `end`. `ratio`: wavelength at its start over that at E = 1.
    fn of(scene: &Scene, ray: &Ray, end: RayEnd, ratio: Option<f64>) -> Self {
        let seen = VisibleSurface::of_ray(scene, *ray, end, ratio.unwrap_or(f64::NAN));
        Self {
            time: scene.integrator.travel_time(&scene.world, ray),
            redshift: redshift(&seen).filter(|g| g.is_finite()),
            b: impact_parameter(&seen),
            constants: Constants::of(&seen),
            winding: swept_angle(&seen).map(|angle| angle / TAU),
        }
    }

    /// Names and numbers, in the order in which they are written.
    fn all(&self) -> [(&'static str, Option<f64>); 6] {
        let Self { time, redshift, b, constants, winding } = self;
        let (l, q) = constants.map_or((None, None), |c| (Some(c.angular_momentum), Some(c.carter)));
        [("time", *time), ("redshift", *redshift), ("b", *b), ("L", l), ("Q", q), ("winding", *winding)]
    }
}

/// The static observer's wavelength over that at E = 1 at `place`; `None` where nothing can stand still.
fn static_ratio(scene: &Scene, place: Place, direction: DVec3) -> Option<f64> {
    scene.observer(place).map(|observer| observer.ratio(direction))
}

/// The side in words.
fn word(side: Side) -> &'static str {
    match side {
        Side::Near => "near",
        Side::Far => "far",
    }
}

impl Answers<'_> {
    /// What becomes of the ray that is `asked` about, with the end of the last line. Numbers have 17 significant digits: enough to read the same bits
    /// back. `number`: which one it is, counted from 0.
    pub(super) fn answer(&self, asked: &Asked, number: u64) -> String {
        let scene = self.scene;
        let ray = Ray { origin: asked.ray.origin - scene.world.origin, ..asked.ray };
        let (end, points) = match self.with_path {
            true => scene.integrator.way(&scene.world, &ray),
            false => (scene.integrator.trace(&scene.world, &ray), Vec::new()),
        };
        let start = Place { x: ray.origin, side: ray.side };
        let ratio = asked.ratio.or_else(|| static_ratio(scene, start, ray.direction));
        match (self.format, self.with_path) {
            (Format::Json, _) => self.json(asked, &end, &Light::of(scene, &ray, end, ratio), (&points, ratio)),
            (Format::Csv, true) => self.csv_path(number, &points, ratio),
            (Format::Csv, false) => self.csv(asked, &end, &Light::of(scene, &ray, end, ratio)),
        }
    }

    fn to_world(self, x: DVec3) -> DVec3 {
        x + self.scene.world.origin
    }

    /// Wavelength that the static observer at `point` has over that of who looks along the ray: how much bluer the light is there.
    fn redshift_to(&self, point: &WayPoint, ratio: Option<f64>) -> Option<f64> {
        static_ratio(self.scene, point.place, point.tangent).zip(ratio).map(|(there, here)| there / here)
    }

    /// The side on which a ray ends.
    fn side(&self, end: &RayEnd) -> Option<Side> {
        match end.arrival {
            Arrival::Surface(hit) => Some(self.scene.world.side_of(hit.geometry)),
            Arrival::Sky(_, side) => Some(side),
            Arrival::Captured | Arrival::OutOfSteps => None,
        }
    }

    /// Where the `Shape` directive number `index` stands.
    fn shape_place(&self, index: u32) -> Option<&str> {
        self.shape_places.get(index as usize).map(String::as_str)
    }

    /// The shape that a ray ends on: its number and what it is called.
    fn shape(&self, end: &RayEnd) -> Option<(u32, Option<&str>)> {
        let Arrival::Surface(hit) = end.arrival else { return None };
        let index = self.scene.shapes[hit.geometry as usize].index;
        Some((index, self.shape_names.get(index as usize).map(String::as_str)))
    }

    fn json(&self, asked: &Asked, end: &RayEnd, light: &Light, (points, ratio): (&[WayPoint], Option<f64>)) -> String {
        let mut json = String::from("{\"outcome\":");
        let _ = write!(json, "\"{}\"", outcome(end));
        match end.arrival {
            Arrival::Surface(hit) => {
                json += ",\"point\":";
                push_vector(&mut json, self.to_world(hit.point));
                json += ",\"direction\":";
                push_vector(&mut json, hit.direction);
            }
            Arrival::Sky(direction, _) => {
                json += ",\"direction\":";
                push_vector(&mut json, direction);
            }
            Arrival::Captured | Arrival::OutOfSteps => {}
        }
        if let Some((index, name)) = self.shape(end) {
            // Writing to a string cannot fail.
            let _ = write!(json, ",\"shape\":{index},\"shape_name\":{}", serde_json::json!(name));
            if let Some(place) = self.shape_place(index) {
                let _ = write!(json, ",\"shape_place\":{}", serde_json::json!(place));
            }
        }
        if let Some(side) = self.side(end).filter(|_| self.scene.world.spacetime().has_far_side()) {
            let _ = write!(json, ",\"side\":\"{}\"", word(side));
        }
        let _ = write!(json, ",\"phi\":{:.16e},\"steps\":{},\"queries\":{}", end.swept, end.cost.steps, end.cost.queries);
        for (name, number) in light.all() {
            let _ = write!(json, ",\"{name}\":");
            push_number(&mut json, number);
        }
        if asked.ratio.is_some() {
            let Ray { origin, direction, side, footprint, .. } = asked.ray;
            json += ",\"ray\":{\"origin\":";
            push_vector(&mut json, origin);
            json += ",\"direction\":";
            push_vector(&mut json, direction);
            let _ = write!(json, ",\"side\":\"{}\",\"footprint\":{footprint:.16e}}}", word(side));
        }
        if self.with_path {
            push_list(&mut json, "path", points, |json, p| push_vector(json, self.to_world(p.place.x)));
            push_list(&mut json, "path_phi", points, |json, p| push_number(json, Some(p.swept)));
            push_list(&mut json, "path_time", points, |json, p| push_number(json, p.time));
            push_list(&mut json, "path_redshift", points, |json, p| push_number(json, self.redshift_to(p, ratio)));
        }
        json += "}\n";
        json
    }

    fn csv(&self, asked: &Asked, end: &RayEnd, light: &Light) -> String {
        let mut line = String::new();
        let Ray { origin, direction, side, footprint, .. } = asked.ray;
        push_values(&mut line, &[origin, direction]);
        let _ = write!(line, "{},{footprint:.16e},{}", word(side), outcome(end));
        let (point, direction) = match end.arrival {
            Arrival::Surface(hit) => (Some(self.to_world(hit.point)), Some(hit.direction)),
            Arrival::Sky(direction, _) => (None, Some(direction)),
            Arrival::Captured | Arrival::OutOfSteps => (None, None),
        };
        for v in [point, direction] {
            match v {
                Some(v) => {
                    let _ = write!(line, ",{:.16e},{:.16e},{:.16e}", v.x, v.y, v.z);
                }
                None => line += ",,,",
            }
        }
        match self.shape(end) {
            Some((index, name)) => {
                let place = self.shape_place(index).map(quoted).unwrap_or_default();
                let _ = write!(line, ",{index},{},{place}", name.unwrap_or_default());
            }
            None => line += ",,,",
        }
        let side = self.side(end).map_or("", word);
        let _ = write!(line, ",{side},{:.16e},{},{}", end.swept, end.cost.steps, end.cost.queries);
        for (_, number) in light.all() {
            push_value(&mut line, number);
        }
        line += "\n";
        line
    }

    /// One line a point.
    fn csv_path(&self, number: u64, points: &[WayPoint], ratio: Option<f64>) -> String {
        let mut lines = String::new();
        for (k, point) in points.iter().enumerate() {
            let _ = write!(lines, "{number},{k},");
            push_values(&mut lines, &[self.to_world(point.place.x)]);
            let _ = write!(lines, "{},{:.16e}", word(point.place.side), point.swept);
            push_value(&mut lines, point.time);
            push_value(&mut lines, self.redshift_to(point, ratio));
            let DVec3 { x, y, z } = point.tangent;
            let _ = writeln!(lines, ",{x:.16e},{y:.16e},{z:.16e}");
        }
        lines
    }
}

fn outcome(end: &RayEnd) -> &'static str {
    match end.arrival {
        Arrival::Surface(_) => "hit",
        Arrival::Sky(..) => "escaped",
        Arrival::Captured => "captured",
        Arrival::OutOfSteps => "out of steps",
    }
}

/// A list of something of each point.
fn push_list(json: &mut String, name: &str, points: &[WayPoint], mut push: impl FnMut(&mut String, &WayPoint)) {
    let _ = write!(json, ",\"{name}\":[");
    for (i, point) in points.iter().enumerate() {
        if i > 0 {
            json.push(',');
        }
        push(json, point);
    }
    json.push(']');
}

fn push_number(json: &mut String, number: Option<f64>) {
    let _ = match number.filter(|x| x.is_finite()) {
        Some(x) => write!(json, "{x:.16e}"),
        None => write!(json, "null"),
    };
}

/// A vector as JSON.
pub(super) fn push_vector(json: &mut String, v: DVec3) {
    let _ = write!(json, "[{:.16e},{:.16e},{:.16e}]", v.x, v.y, v.z);
}

/// Numbers with a comma behind each.
fn push_values(line: &mut String, vectors: &[DVec3]) {
    for v in vectors {
        let _ = write!(line, "{:.16e},{:.16e},{:.16e},", v.x, v.y, v.z);
    }
}

/// A text as a value between commas.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

/// A number with a comma before it, or nothing.
fn push_value(line: &mut String, number: Option<f64>) {
    let _ = match number.filter(|x| x.is_finite()) {
        Some(x) => write!(line, ",{x:.16e}"),
        None => write!(line, ","),
    };
}
