//! `Spacetime`, `BlackHole`, `Wormhole`: what light moves through, with the conventions of the picture; and what may not stand where.

use crate::lang::create::create_with;
use crate::lang::description::Entity;
use crate::registry::{NoFiles, Registry, bare_context};
use bhs_core::camera::{Camera, Viewpoint};
use bhs_core::diagnostics::{Diagnostic, Span, Spanned};
use bhs_core::geometry::{Analytic, AreaSample, Geometry};
use bhs_core::motion::Surroundings;
use bhs_core::observer::Conventions;
use bhs_core::params::{Context, Params};
use bhs_core::sampling::ONE_MINUS_EPSILON;
use bhs_core::spacetime::{Class, Minkowski, Place, Side, Spacetime};
use bhs_engine::integrator::{Integrator, IntegratorBuilder};
use glam::{DVec3, Vec2};
use std::sync::Arc;

/// What bends light in a scene.
#[derive(Clone, Debug)]
pub(super) struct Gravity {
    /// Place of the plugin's name.
    pub span: Span,
    pub spacetime: Arc<dyn Spacetime>,
    pub conventions: Conventions,
}

/// Makes the spacetime that `entity` describes, in world space; `None` if it is flat and has one side, or if something is wrong, which goes to
/// `found`.
pub(super) fn build_spacetime(
    entity: &Entity,
    registry: &Registry,
    context: Context,
    found: &mut Vec<Diagnostic>,
) -> Option<Gravity> {
    let (made, conventions) = create_with::<dyn Spacetime, _>(entity, registry, context, found, Conventions::read);
    let spacetime: Arc<dyn Spacetime> = made?.into();
    let bends = !matches!(spacetime.class(), Class::Flat) || spacetime.has_far_side();
    bends.then_some(Gravity { span: entity.name.span, spacetime, conventions: conventions? })
}

/// What is said of something that cannot stand where it stands.
struct Refusal {
    found: Diagnostic,
    /// What is in its way.
    label: String,
    /// Where it is then.
    within: &'static str,
    /// What could be made smaller.
    smaller: &'static str,
}

impl Gravity {
    /// The same in coordinates with the origin `origin`.
    pub fn moved(&self, origin: DVec3) -> Self {
        Self { spacetime: self.spacetime.moved(origin), ..self.clone() }
    }

    /// What is wrong with something that stands on `side` at all of `points`, if nothing can stand at any of them; and what that is.
    fn refusal(&self, what: &str, side: Side, points: impl IntoIterator<Item = DVec3>) -> Option<Refusal> {
        let mut any = false;
        for x in points {
            any = true;
            if self.spacetime.at(Place { x, side }).is_some() {
                return None;
            }
        }
        any.then(|| self.refused(what))
    }

    /// What is said of something that can be at none of its places.
    fn refused(&self, what: &str) -> Refusal {
        let radius = |radius: f64| format!("radius {radius}");
        let (code, message, label, within, smaller) = match self.spacetime.class() {
            Class::Spherical(hole) => {
                ("inside-horizon", "inside the black hole", radius(hole.horizon()), "within the horizon", "`rs`")
            }
            Class::Index(index) => match index.throat() {
                Some(throat) => {
                    ("inside-throat", "inside the throat of the wormhole", radius(throat.radius), "within the throat", "`throat`")
                }
                None => ("inside-horizon", "on a black hole", "its centre is its horizon".to_owned(), "there", "its mass"),
            },
            _ => ("inside-horizon", "where nothing can stand still", String::new(), "there", "`rs`"),
        };
        Refusal { found: Diagnostic::error(code, format!("{what} {message}")), label, within, smaller }
    }

    /// Nothing is seen from where no camera can stand, or move as it says.
    pub fn check_camera(
        &self,
        camera: &dyn Camera,
        viewpoint: &Viewpoint,
        (span, target): (Option<Span>, Option<DVec3>),
        found: &mut Vec<Diagnostic>,
    ) {
        let nearest = self.center().map_or_else(|| camera.position(), |center| camera.nearest_origin(center));
        let place = Place { x: nearest, side: viewpoint.side };
        let here = Surroundings { spacetime: Some(self.spacetime.as_ref()), place, conventions: self.conventions };
        let observer = match &viewpoint.motion {
            Some(motion) => motion.observer(&here),
            None => here.at_rest(),
        };
        if observer.is_some() {
            return;
        }
        let why = match (&viewpoint.motion, span) {
            (Some(motion), _) if here.normal().is_some() => {
                let said = Diagnostic::error("no-such-motion", "no camera can move so there");
                let why = motion.fault(here.spacetime);
                let why = why.unwrap_or_else(|| {
                    format!("it would be as fast as light, or there is no such orbit, {}", self.distance(nearest))
                });
                Some(said.and(self.span, why).help("move the camera, or let it move otherwise"))
            }
            (None, _) if here.normal().is_some() => {
                let said =
                    Diagnostic::error("in-ergosphere", "nothing can stand still in the ergosphere, and the camera is there");
                let help = "move the camera out, or let it be dragged along: \"string motion\" \"zamo\"";
                Some(said.and(self.span, "of this hole").help(help))
            }
            _ => None,
        };
        if let Some(said) = why {
            found.push(said.at(span.unwrap_or(self.span), self.distance(nearest)));
            return;
        }
        let Refusal { found: d, label, smaller, .. } = self.refused("the camera stands");
        let stands_there = target.is_some_and(|x| self.spacetime.at(Place { x, side: viewpoint.side }).is_some());
        let exchanged = if stands_there { "; or are from and to of `LookAt` exchanged?" } else { "" };
        found.push(match span {
            Some(span) => d
                .at(span, self.distance(nearest))
                .and(self.span, label)
                .help(format!("move the camera out, or make {smaller} smaller{exchanged}")),
            None => d.at(self.span, label).help("the scene has no `Camera`; the default one stands at the origin of the world"),
        });
    }

    /// A light behind the horizon lights nothing.
    pub fn check_light(&self, geometry: &Geometry, side: Side, span: Span, found: &mut Vec<Diagnostic>) {
        let points = points_of(geometry);
        if let Some(Refusal { found: d, label, within, smaller }) = self.refusal("this light lies", side, points) {
            let help = format!("move it out, or make {smaller} smaller");
            found.push(d.at(span, format!("all of it is {within}")).and(self.span, label).help(help));
        }
    }

    /// As [`Gravity::check_light`], of a light that shines from a point.
    pub fn check_point(&self, position: DVec3, side: Side, span: Span, found: &mut Vec<Diagnostic>) -> bool {
        let refusal = self.refusal("this light lies", side, [position]);
        let Some(Refusal { found: d, label, smaller, .. }) = refusal else { return true };
        let help = format!("move it out, or make {smaller} smaller");
        found.push(d.at(span, self.distance(position)).and(self.span, label).help(help));
        false
    }

    /// The ball within the throat of a wormhole is no place: nothing may reach into it.
    pub fn check_throat(&self, geometry: &Geometry, span: Span, found: &mut Vec<Diagnostic>) {
        let Class::Index(index) = self.spacetime.class() else { return };
        let Some(throat) = index.throat() else { return };
        let within = |p: DVec3| (p - throat.center).length() < throat.radius;
        let reaches_in = match geometry {
            Geometry::Analytic(_) => points_of(geometry).any(within),
            mesh => (0..mesh.triangle_count() as u32)
                .filter_map(|t| mesh.corners(t))
                .any(|corners| within(nearest_on_triangle(throat.center, corners))),
        };
        if reaches_in {
            found.push(
                Diagnostic::error("inside-throat", "this shape reaches into the throat of the wormhole")
                    .at(span, "the ball within the throat is no place")
                    .and(self.span, format!("radius {}", throat.radius))
                    .help("move the shape out of the throat, or make the throat smaller"),
            );
        }
    }

    /// The middle of the throat, or of the first hole.
    fn center(&self) -> Option<DVec3> {
        let throat = match self.spacetime.class() {
            Class::Index(index) => index.throat(),
            _ => None,
        };
        throat.map(|throat| throat.center).or_else(|| self.spacetime.captures().first().map(|hole| hole.center))
    }

    /// How far from the middle `x` is, in words.
    fn distance(&self, x: DVec3) -> String {
        self.center().map_or_else(String::new, |center| format!("{} from its centre", (x - center).length()))
    }
}

/// The integrator to use, and whether light bends under it: where nothing bends light it is `straight`, so that the picture is the same bit for
/// bit.
pub(super) fn choose_integrator(
    given: Option<(String, Box<dyn IntegratorBuilder>)>,
    gravity: Option<&Gravity>,
    registry: &Registry,
    found: &mut Vec<Diagnostic>,
) -> (String, Option<Box<dyn Integrator>>, bool) {
    let Some((name, builder)) = given else { return (String::new(), None, true) };
    // A wormhole whose throat has closed is flat.
    let bends = gravity.filter(|g| !matches!(g.spacetime.class(), Class::Flat));
    let Some(Gravity { span, spacetime, .. }) = bends else {
        let name = if builder.is_curved() { "straight".to_owned() } else { name };
        return (name, straight(registry), false);
    };
    if !builder.is_curved() {
        let what = if matches!(spacetime.class(), Class::Spherical(_)) { "black hole" } else { "spacetime" };
        found.push(
            Diagnostic::warning("hole-ignored", format!("the integrator `{name}` ignores the {what}"))
                .at(*span, "light passes it straight")
                .help("choose another `Integrator` to see what bends it; without one, the scene gets one that bends light"),
        );
    }
    match builder.build(&**spacetime) {
        Ok(integrator) => (name, Some(integrator), builder.is_curved()),
        Err(why) => {
            found.push(
                Diagnostic::error("unfit-integrator", format!("the integrator `{name}` cannot follow light here: it {why}"))
                    .at(*span, "in this spacetime")
                    .help("leave `Integrator` out: the one that bhs chooses follows light in every spacetime"),
            );
            (name, None, true)
        }
    }
}

/// The integrator of flat space.
fn straight(registry: &Registry) -> Option<Box<dyn Integrator>> {
    let plugin = registry.find::<dyn IntegratorBuilder>("straight")?;
    let context = bare_context(&NoFiles, registry.spectra());
    let params = Params::new(Spanned::new("straight".to_owned(), Span::default()), &[], context);
    (plugin.build)(&params)?.build(&Minkowski::default()).ok()
}

/// The point of a triangle nearest to `p` (Ericson 2004, "Real-Time Collision Detection", section 5.1.5).
fn nearest_on_triangle(p: DVec3, [a, b, c]: [DVec3; 3]) -> DVec3 {
    let (ab, ac) = (b - a, c - a);
    let [(d1, d2), (d3, d4), (d5, d6)] = [a, b, c].map(|corner| (ab.dot(p - corner), ac.dot(p - corner)));
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    if d1 <= 0.0 && d2 <= 0.0 {
        a
    } else if d3 >= 0.0 && d4 <= d3 {
        b
    } else if d6 >= 0.0 && d5 <= d6 {
        c
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        a + ab * (d1 / (d1 - d3))
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        a + ac * (d2 / (d2 - d6))
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))
    } else {
        let per = 1.0 / (va + vb + vc);
        a + ab * (vb * per) + ac * (vc * per)
    }
}

/// Points all over an analytic surface, with their normals.
pub(super) fn samples_of(surface: &dyn Analytic) -> impl Iterator<Item = AreaSample> {
    (0..256).map(|i| {
        let u = Vec2::new((i % 16) as f32, (i / 16) as f32) / 15.0 * ONE_MINUS_EPSILON;
        surface.sample(u)
    })
}

/// Points all over a surface, which stand for it: the corners of triangles.
pub(super) fn points_of(geometry: &Geometry) -> Box<dyn Iterator<Item = DVec3> + '_> {
    match geometry {
        Geometry::Analytic(surface) => Box::new(samples_of(&**surface).map(|sample| sample.point)),
        mesh => Box::new((0..mesh.triangle_count() as u32).filter_map(|t| mesh.corners(t)).flatten()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_point_of_a_triangle_is_that_of_a_fine_net() {
        let corners = [DVec3::new(0.1, 0.2, -0.3), DVec3::new(1.2, 0.1, 0.4), DVec3::new(0.3, 0.9, 0.2)];
        for i in 0..125 {
            let p = DVec3::new((i % 5) as f64, (i / 5 % 5) as f64, (i / 25) as f64) * 0.5 - 0.75;
            let found = (nearest_on_triangle(p, corners) - p).length();
            let mut least = f64::INFINITY;
            for v in 0..=200 {
                for w in 0..=200 - v {
                    let q = corners[0]
                        + (corners[1] - corners[0]) * (f64::from(v) / 200.0)
                        + (corners[2] - corners[0]) * (f64::from(w) / 200.0);
                    least = least.min((q - p).length());
                }
            }
            assert!(found <= least + 1e-12 && found >= least - 0.01, "{p}: {found}, {least}");
        }
    }
}
