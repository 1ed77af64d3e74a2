//! Rays between two places of a round spacetime, in its isotropic chart, where chart directions are local ones.

use crate::round::profile::Profile;
use crate::round::solve::{End, Orbit, Pair};
use bhs_core::spacetime::{Place, Side};
use bhs_elementary::Elementary;
use bhs_engine::connections::Connection;
use glam::DVec3;
use std::f64::consts::TAU;

/// Which rays are there: number of whole turns, and whether it goes the shorter way round (0) or the other one (1).
pub type Label = (u32, usize);

/// Cosine of the largest angle between launches of one and the same image.
const SAME_LAUNCH: f64 = 0.95;

/// How far from its end a ray that was traced may be, over the distance between the ends, and be the ray that was found.
const SAME_END: f64 = 0.3;

/// By how much the angles that they sweep may differ (rad).
const SAME_ANGLE: f64 = 0.5;

/// What is known of the end of a ray that was traced.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Traced {
    /// The parameter sigma.
    Sigma(f64),
    /// The angle that it swept (rad).
    Angle(f64),
    /// That it left.
    Sky,
}

/// A pair of places, from the centre, and the plane of the rays between them.
#[derive(Clone, Copy, Debug)]
pub struct Rays<'a> {
    pair: Pair<'a>,
    ends: [End; 2],
    /// Unit vector from the centre to the first place.
    radial: DVec3,
    /// Unit vector at right angles to it, the shorter way to the second place.
    aside: DVec3,
    /// The angle between the places (rad).
    theta: f64,
    /// Isotropic distance of the second place from the centre (scene units); 1 for the sky.
    far: f64,
    /// The distance that errors at the end are compared with (scene units); 1 for the sky.
    distance: f64,
}

/// Whether directions away from the minimum of the optical radius lead away from the centre: not within the photon sphere of a hole.
fn outwards(profile: &Profile, end: &End) -> f64 {
    if end.is_beyond && !profile.is_throat() { -1.0 } else { 1.0 }
}

/// The end at the place `x`, which is relative to the centre; `None` if that is no place.
fn end_at(profile: &Profile, x: DVec3, side: Side) -> Option<End> {
    let coordinate = profile.coordinate(x.length());
    if !coordinate.is_finite() {
        return None;
    }
    if profile.is_throat() {
        // On the throat to rounding.
        let far = side == Side::Far;
        let x = coordinate.max(0.0);
        (coordinate > -1e-12).then(|| End { is_beyond: far, ..End::new(profile, x) })
    } else {
        (side == Side::Near).then(|| End::new(profile, coordinate))
    }
}

impl<'a> Rays<'a> {
    /// From `x` to `y`, both relative to the centre, in isotropic coordinates. `None` if one of them is no place, or if they are the same one.
    pub fn between(profile: &'a Profile, x: Place, y: Place) -> Option<Self> {
        let ends = [end_at(profile, x.x, x.side)?, end_at(profile, y.x, y.side)?];
        let rays = Self::new(profile, x.x, y.x, ends)?;
        let far = y.x.length();
        let distance = if x.side == y.side { (y.x - x.x).length() } else { x.x.length() + far };
        (x != y).then_some(Self { far, distance, ..rays })
    }

    /// From `x` to the sky in the unit direction `sky` of a side.
    pub fn to_sky(profile: &'a Profile, x: Place, (sky, side): (DVec3, Side)) -> Option<Self> {
        if side == Side::Far && !profile.is_throat() {
            return None;
        }
        Self::new(profile, x.x, sky, [end_at(profile, x.x, x.side)?, End::sky(side == Side::Far)])
    }

    fn new(profile: &'a Profile, x: DVec3, y: DVec3, ends: [End; 2]) -> Option<Self> {
        let radial = x.try_normalize()?;
        let axis = radial.cross(y);
        let theta = axis.length().arctangent2(radial.dot(y));
        let aside = axis.cross(radial).try_normalize().unwrap_or_else(|| radial.any_orthonormal_vector());
        Some(Self { pair: Pair::new(profile, ends), ends, radial, aside, theta, far: 1.0, distance: 1.0 })
    }

    /// Swept angle of an image, and the direction in which it sweeps.
    fn sweep(&self, (turn, way): Label) -> (f64, DVec3) {
        let whole = TAU * f64::from(turn);
        if way == 0 { (whole + self.theta, self.aside) } else { (whole + TAU - self.theta, -self.aside) }
    }

    /// Ray number `label`. Its `phi` is the swept angle if `by_angle`, else the parameter sigma.
    pub fn connection(&self, label: Label, by_angle: bool) -> Option<Connection> {
        Some(self.found(label, by_angle)?.1)
    }

    /// About the launch of ray number `label`, and its parameter sigma.
    pub fn rough(&self, label: Label) -> Option<(DVec3, f64)> {
        let (psi, aside) = self.sweep(label);
        let orbit = self.pair.rough(psi)?;
        let cos = outwards(self.pair.profile(), &self.ends[0]) * orbit.cos[0];
        Some(((self.radial * cos + aside * (orbit.h / self.ends[0].radius)).normalize(), orbit.sigma))
    }

    fn found(&self, label: Label, by_angle: bool) -> Option<(Orbit, Connection)> {
        let (psi, aside) = self.sweep(label);
        let orbit = self.pair.orbit(psi)?;
        let profile = self.pair.profile();
        let sin = self.ends.map(|end| orbit.h / end.radius);
        let [cos_x, cos_y] = [0, 1].map(|i| outwards(profile, &self.ends[i]) * orbit.cos[i]);
        let (sin_psi, cos_psi) = psi.sine_cosine();
        let radial_y = self.radial * cos_psi + aside * sin_psi;
        let aside_y = aside * cos_psi - self.radial * sin_psi;
        let launch = (self.radial * cos_x + aside * sin[0]).normalize();
        let arrival = (radial_y * cos_y + aside_y * sin[1]).normalize();
        let radius = self.ends[0].radius;
        let spread = self.far * self.far * radius * radius * (sin_psi / orbit.h * orbit.spread).abs();
        let phi = if by_angle { psi } else { orbit.sigma };
        let is_sound = launch.is_finite() && arrival.is_finite() && spread.is_finite();
        is_sound.then_some((orbit, Connection { launch, arrival, spread, phi }))
    }

    /// The image, one with less than `turns` whole turns, that a ray is which was traced from the first place in the unit direction `launch` to
    /// about the second one.
    pub fn image_of(&self, launch: DVec3, turns: u32, traced: Traced) -> Option<Connection> {
        let first = usize::from(launch.dot(self.aside) < 0.0);
        let mut labels = (0..2).flat_map(|k| (0..turns).map(move |turn| (turn, first ^ k)));
        labels.find_map(|label| {
            if let Traced::Angle(angle) = traced
                && (self.sweep(label).0 - angle).abs() > SAME_ANGLE
            {
                return None;
            }
            let (orbit, found) = self.found(label, matches!(traced, Traced::Angle(_)))?;
            self.is_same((&orbit, &found), launch, traced).then_some(found)
        })
    }

    /// Whether a ray that was traced in the direction `launch` is `found`: its launch is about the same, and by as much as that is turned in the plane
    /// it would not end far off.
    fn is_same(&self, (orbit, found): (&Orbit, &Connection), launch: DVec3, traced: Traced) -> bool {
        let normal = self.radial.cross(self.aside);
        let turned = launch.dot(normal.cross(found.launch)).abs();
        let aside = turned * self.ends[0].radius * orbit.spread * self.far;
        let along = match traced {
            Traced::Sigma(sigma) => (sigma - found.phi) * self.ends[1].radius / self.far,
            Traced::Angle(_) | Traced::Sky => 0.0,
        };
        found.launch.dot(launch) > SAME_LAUNCH && aside.hypotenuse(along) < SAME_END * self.distance
    }
}
