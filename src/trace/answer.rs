//! What is said of a ray, as a line of JSON or of comma-separated values.

use super::followed::{Asked, Followed, Light, WayPoint, word};
use super::{Answers, Format};
use bhs_core::ray::Ray;
use glam::DVec3;
use std::fmt::Write as _;

/// The columns of answers in CSV.
pub(super) const COLUMNS: &str = "ox,oy,oz,dx,dy,dz,start_side,footprint,outcome,x,y,z,end_dx,end_dy,end_dz,shape,shape_name,shape_place,side,phi,steps,queries,\
                                  time,redshift,b,L,Q,winding\n";

/// The columns of points of ways in CSV.
pub(super) const PATH_COLUMNS: &str = "ray,point,x,y,z,side,phi,time,redshift,dx,dy,dz\n";

impl Answers<'_> {
    /// What becomes of the rays that are `asked` about, each with the end of its last line. Numbers have 17 significant digits: enough to read the same
    /// bits back. `first`: which one the first of them is, counted from 0.
    pub(super) fn answer(&self, asked: &[Asked], first: u64) -> Vec<String> {
        if self.with_path {
            return (first..).zip(asked).map(|(number, asked)| self.answer_with_path(asked, number)).collect();
        }
        let write = |(asked, followed): (&Asked, &Followed)| match self.format {
            Format::Json => self.json(asked, followed, None),
            Format::Csv => self.csv(asked, followed),
        };
        asked.iter().zip(&Followed::all(self.scene, asked)).map(write).collect()
    }

    fn answer_with_path(&self, asked: &Asked, number: u64) -> String {
        let (followed, points) = Followed::with_way(self.scene, asked);
        match self.format {
            Format::Json => self.json(asked, &followed, Some(&points)),
            Format::Csv => csv_path(number, &points),
        }
    }

    /// Where the `Shape` directive number `index` stands.
    fn shape_place(&self, index: u32) -> Option<&str> {
        self.shape_places.get(index as usize).map(String::as_str)
    }

    /// What the `Shape` directive number `index` is called.
    fn shape_name(&self, index: u32) -> Option<&str> {
        self.shape_names.get(index as usize).map(String::as_str)
    }

    /// `path`: the points of its way.
    fn json(&self, asked: &Asked, followed: &Followed, path: Option<&[WayPoint]>) -> String {
        let Followed { outcome, point, direction, shape, side, phi, steps, queries, light } = followed;
        // Writing to a string cannot fail.
        let mut json = format!("{{\"outcome\":\"{outcome}\"");
        for (name, vector) in [("point", point), ("direction", direction)] {
            if let Some(vector) = vector {
                let _ = write!(json, ",\"{name}\":");
                push_vector(&mut json, *vector);
            }
        }
        if let Some(index) = *shape {
            let _ = write!(json, ",\"shape\":{index},\"shape_name\":{}", serde_json::json!(self.shape_name(index)));
            if let Some(place) = self.shape_place(index) {
                let _ = write!(json, ",\"shape_place\":{}", serde_json::json!(place));
            }
        }
        if let Some(side) = side.filter(|_| self.scene.world.spacetime().has_far_side()) {
            let _ = write!(json, ",\"side\":\"{}\"", word(side));
        }
        let _ = write!(json, ",\"phi\":{phi:.16e},\"steps\":{steps},\"queries\":{queries}");
        for (name, number) in Light::NAMES.iter().zip(light.numbers()) {
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
        if let Some(points) = path {
            push_list(&mut json, "path", points, |json, p| push_vector(json, p.point));
            push_list(&mut json, "path_phi", points, |json, p| push_number(json, Some(p.phi)));
            push_list(&mut json, "path_time", points, |json, p| push_number(json, p.time));
            push_list(&mut json, "path_redshift", points, |json, p| push_number(json, p.redshift));
        }
        json += "}\n";
        json
    }

    fn csv(&self, asked: &Asked, followed: &Followed) -> String {
        let mut line = String::new();
        let Ray { origin, direction, side, footprint, .. } = asked.ray;
        push_values(&mut line, &[origin, direction]);
        let _ = write!(line, "{},{footprint:.16e},{}", word(side), followed.outcome);
        for v in [followed.point, followed.direction] {
            match v {
                Some(v) => {
                    let _ = write!(line, ",{:.16e},{:.16e},{:.16e}", v.x, v.y, v.z);
                }
                None => line += ",,,",
            }
        }
        match followed.shape {
            Some(index) => {
                let place = self.shape_place(index).map(quoted).unwrap_or_default();
                let _ = write!(line, ",{index},{},{place}", self.shape_name(index).unwrap_or_default());
            }
            None => line += ",,,",
        }
        let side = followed.side.map_or("", word);
        let _ = write!(line, ",{side},{:.16e},{},{}", followed.phi, followed.steps, followed.queries);
        for number in followed.light.numbers() {
            push_value(&mut line, number);
        }
        line += "\n";
        line
    }
}

/// One line a point of the way of the ray `number`.
fn csv_path(number: u64, points: &[WayPoint]) -> String {
    let mut lines = String::new();
    for (k, point) in points.iter().enumerate() {
        let _ = write!(lines, "{number},{k},");
        push_values(&mut lines, &[point.point]);
        let _ = write!(lines, "{},{:.16e}", word(point.side), point.phi);
        push_value(&mut lines, point.time);
        push_value(&mut lines, point.redshift);
        let DVec3 { x, y, z } = point.direction;
        let _ = writeln!(lines, ",{x:.16e},{y:.16e},{z:.16e}");
    }
    lines
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
