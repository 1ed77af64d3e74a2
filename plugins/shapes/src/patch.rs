//! One bilinear patch as a surface.
//!
//! A ray meets the lines of constant u of a patch where a quadratic equation in u says (Reshetov 2019, "Cool Patches: A Geometric
//! Approach to Ray/Bilinear Patch Intersections", Ray Tracing Gems, chapter 8); here in double precision.

use crate::ellipsoid::gauss_legendre;
use bhs_core::geometry::{Aabb, Analytic, AreaSample, Segment, SurfaceGeometry};
use glam::{DVec2, DVec3, Vec2, Vec4};

/// How far beyond its edges a patch is met, in u and v: rounding must not open a gap between two patches.
const EDGE: f64 = 1e-12;

/// `origin + u along + v across + u v twist` for u and v from 0 to 1.
pub(crate) struct Patch {
    origin: DVec3,
    along: DVec3,
    across: DVec3,
    twist: DVec3,
    /// Unit shading normals of the corners 00, 10, 01, 11.
    normals: Option<[DVec3; 4]>,
    uvs: [DVec2; 4],
    /// Whether the outer side is against `dp/du x dp/dv`.
    flip: bool,
    /// Twice the areas of the triangles at the corners: what points are drawn by.
    weights: [f64; 4],
}

/// A value between those of the corners 00, 10, 01, 11.
fn bilinear<T: Copy + std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T>>(c: [T; 4], u: f64, v: f64) -> T {
    (c[0] * (1.0 - u) + c[1] * u) * (1.0 - v) + (c[2] * (1.0 - u) + c[3] * u) * v
}

/// A number in 0..1 with a density that goes from `a` to `b`, not both 0, in a straight line.
fn sample_linear(x: f64, a: f64, b: f64) -> f64 {
    let root = (a * a + (b * b - a * a) * x).max(0.0).sqrt();
    if a + root == 0.0 { 0.0 } else { (x * (a + b) / (a + root)).min(1.0) }
}

impl Patch {
    /// The patch with the corners 00, 10, 01, 11.
    pub(crate) fn new([p00, p10, p01, p11]: [DVec3; 4], normals: Option<[DVec3; 4]>, uvs: [DVec2; 4], flip: bool) -> Self {
        let (along, across, twist) = (p10 - p00, p01 - p00, (p11 - p10) - (p01 - p00));
        let mut patch = Self { origin: p00, along, across, twist, normals, uvs, flip, weights: [1.0; 4] };
        let weights = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(u, v)| patch.cross(u, v).length());
        if weights.iter().sum::<f64>() > 0.0 {
            patch.weights = weights;
        }
        patch
    }

    fn point(&self, u: f64, v: f64) -> DVec3 {
        self.origin + self.along * u + (self.across + self.twist * u) * v
    }

    fn derivatives(&self, u: f64, v: f64) -> [DVec3; 2] {
        [self.along + self.twist * v, self.across + self.twist * u]
    }

    /// `dp/du x dp/dv`: its length is the area per du dv.
    fn cross(&self, u: f64, v: f64) -> DVec3 {
        let [du, dv] = self.derivatives(u, v);
        du.cross(dv)
    }

    fn corners(&self) -> [DVec3; 4] {
        [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(u, v)| self.point(u, v))
    }

    /// A vector across the patch as a whole.
    fn mean_normal(&self) -> DVec3 {
        (self.along + self.across + self.twist).cross(self.across - self.along)
    }

    /// Where the line `o + t d` meets the surface that the patch is a part of: t, u, v. What is no number is no meeting.
    fn meet(&self, o: DVec3, d: DVec3) -> [(f64, f64, f64); 2] {
        let from = self.origin - o;
        // The line meets that of constant u where the volume of (from + u along, across + u twist, d) is 0.
        let (straight, twisted) = (self.across.cross(d), self.twist.cross(d));
        let c = from.dot(straight);
        let b = self.along.dot(straight) + from.dot(twisted);
        let a = self.along.dot(twisted);
        let q = -0.5 * (b + (b * b - 4.0 * a * c).sqrt().copysign(b));
        [q / a, c / q].map(|u| {
            let (start, line) = (from + self.along * u, self.across + self.twist * u);
            let n = d.cross(line);
            let nn = n.length_squared();
            (start.cross(line).dot(n) / nn, u, start.cross(d).dot(n) / nn)
        })
    }

    /// The place on the patch that is nearest to a point of it.
    fn place(&self, point: DVec3) -> DVec2 {
        let met =
            self.meet(point, self.mean_normal()).into_iter().filter(|m| m.0.is_finite() && m.1.is_finite() && m.2.is_finite());
        let middles = (0..9).map(|i| DVec2::new(f64::from(i % 3), f64::from(i / 3)) * 0.5);
        let starts = met.map(|m| DVec2::new(m.1, m.2).clamp(DVec2::ZERO, DVec2::ONE)).chain(middles);
        let off = |s: &DVec2| (self.point(s.x, s.y) - point).length_squared();
        let mut best = starts.min_by(|a, b| off(a).total_cmp(&off(b))).unwrap_or(DVec2::splat(0.5));
        // Gauss and Newton's method, from where rounding or a tangent line have left it.
        for _ in 0..8 {
            let [du, dv] = self.derivatives(best.x, best.y);
            let gap = point - self.point(best.x, best.y);
            let (a, b, c) = (du.length_squared(), du.dot(dv), dv.length_squared());
            let determinant = a * c - b * b;
            let (x, y) = (du.dot(gap), dv.dot(gap));
            let step = DVec2::new(c * x - b * y, a * y - b * x) / determinant;
            let next = (best + step).clamp(DVec2::ZERO, DVec2::ONE);
            if !step.is_finite() || off(&next) >= off(&best) {
                break;
            }
            best = next;
        }
        best
    }

    fn surface_at(&self, place: DVec2) -> SurfaceGeometry {
        let (u, v) = (place.x, place.y);
        // Where two corners coincide the tangents do too: what is near there counts.
        let inward = DVec2::splat(0.5) + (place - 0.5) * (1.0 - 1e-6);
        let cross = [self.cross(u, v), self.cross(inward.x, inward.y), self.mean_normal()];
        let normal = cross.into_iter().find_map(DVec3::try_normalize).unwrap_or(DVec3::Z);
        let mut normal = if self.flip { -normal } else { normal };
        let mut shading_normal = normal;
        if let Some(n) = self.normals.and_then(|n| bilinear(n, u, v).try_normalize()) {
            shading_normal = n;
            // As in pbrt: the vertex normals decide which side is out.
            if normal.dot(n) < 0.0 {
                normal = -normal;
            }
        }
        SurfaceGeometry { normal, shading_normal, uv: bilinear(self.uvs, u, v).as_vec2(), second_uv: None, colour: Vec4::ONE }
    }

    fn density(&self, place: DVec2) -> f64 {
        let own = 4.0 * bilinear(self.weights, place.x, place.y) / self.weights.iter().sum::<f64>();
        own / self.cross(place.x, place.y).length()
    }
}

impl Analytic for Patch {
    fn bounds(&self) -> Aabb {
        self.corners().into_iter().fold(Aabb::EMPTY, Aabb::with_point)
    }

    fn may_pass(&self, middle: DVec3, half: DVec3) -> bool {
        // It lies between the planes through its outermost corners.
        let n = self.mean_normal();
        let range = self.corners().map(|c| n.dot(c - middle));
        let reach = n.abs().dot(half);
        range.into_iter().fold(f64::INFINITY, f64::min) <= reach && range.into_iter().fold(f64::NEG_INFINITY, f64::max) >= -reach
    }

    fn intersect(&self, segment: &Segment) -> Option<f64> {
        let within = |x: f64| (-EDGE..=1.0 + EDGE).contains(&x);
        let met = self.meet(segment.origin, segment.direction).into_iter();
        let hits = met.filter(|(t, u, v)| segment.t_min < *t && *t < segment.t_max && within(*u) && within(*v));
        hits.map(|m| m.0).min_by(f64::total_cmp)
    }

    fn intersect_again(&self, segment: &Segment) -> Option<f64> {
        let within = |x: f64| (-EDGE..=1.0 + EDGE).contains(&x);
        let met = self.meet(segment.origin, segment.direction);
        // The one that is nearer is where it starts.
        let [a, b] = met;
        let (t, u, v) = if b.0.is_nan() || a.0.abs() >= b.0.abs() { a } else { b };
        let is_other = !a.0.is_nan() && !b.0.is_nan() && 0.0 < t && t < segment.t_max;
        (is_other && within(u) && within(v)).then_some(t)
    }

    fn surface(&self, point: DVec3) -> SurfaceGeometry {
        self.surface_at(self.place(point))
    }

    fn tangents(&self, point: DVec3) -> Option<[DVec3; 2]> {
        let place = self.place(point);
        let [of_a, of_b] = self.derivatives(place.x, place.y);
        // The texture coordinates by the place on the patch.
        let [c00, c10, c01, c11] = self.uvs;
        let by_a = (c10 - c00) * (1.0 - place.y) + (c11 - c01) * place.y;
        let by_b = (c01 - c00) * (1.0 - place.x) + (c11 - c10) * place.x;
        let determinant = by_a.perp_dot(by_b);
        Some([(of_a * by_b.y - of_b * by_a.y) / determinant, (of_b * by_a.x - of_a * by_b.x) / determinant])
    }

    fn area(&self) -> f64 {
        let nodes = gauss_legendre();
        nodes.iter().map(|(u, a)| nodes.iter().map(|(v, b)| a * b * self.cross(*u, *v).length()).sum::<f64>()).sum()
    }

    fn sample(&self, u: Vec2) -> AreaSample {
        let ([w00, w10, w01, w11], x) = (self.weights, u.as_dvec2());
        let v = sample_linear(x.y, w00 + w10, w01 + w11);
        let u = sample_linear(x.x, w00 + (w01 - w00) * v, w10 + (w11 - w10) * v);
        let place = DVec2::new(u, v);
        let SurfaceGeometry { normal, uv, .. } = self.surface_at(place);
        AreaSample { point: self.point(u, v), normal, uv, pdf: self.density(place) }
    }

    fn pdf(&self, point: DVec3) -> f64 {
        self.density(self.place(point))
    }

    fn rebase(&mut self, origin: DVec3) {
        self.origin -= origin;
    }
}
