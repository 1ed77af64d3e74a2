//! Lights that are points of the sky: whether pictures draw them, and what to say where they do not.

use crate::lang::parts::{PartCamera, PartLight};
use bhs_core::camera::Camera;
use bhs_core::diagnostics::{Diagnostic, Span};

/// The lights of a scene that are points of the sky.
pub(super) struct SkyPoints {
    /// Place of the name of the first one.
    span: Option<Span>,
    /// Whether the integrator finds the geodesics from a camera to them.
    joins: bool,
}

impl SkyPoints {
    /// Those among `lights`; `joins`: whether the integrator finds geodesics.
    pub fn new(lights: &[PartLight], joins: bool) -> Self {
        let span = lights.iter().find(|l| l.light.as_ref().is_some_and(|light| !light.points().is_empty())).map(|l| l.span);
        Self { span, joins }
    }

    /// Whether the picture of `camera` draws them.
    pub fn is_drawn_by(&self, camera: &dyn Camera) -> bool {
        self.span.is_some() && self.joins && camera.projection().is_some()
    }

    /// Says which cameras see discs in their places, and why.
    pub fn check(&self, cameras: &[PartCamera], found: &mut Vec<Diagnostic>) {
        let Some(span) = self.span else { return };
        let message = "stars are not drawn as points: camera rays find them as small discs, with noise";
        let warning = |help| Diagnostic::warning("stars-as-discs", message).at(span, "").help(help);
        if !self.joins {
            let help = "use an integrator that finds the geodesics to them, such as \"adaptive\" with its `connections`; a larger `radius` \
                        makes less noise";
            found.push(warning(help));
            return;
        }
        for PartCamera { span, camera, .. } in cameras {
            if camera.as_ref().is_some_and(|camera| camera.projection().is_none()) {
                let help = "use Camera \"perspective\" with `lensradius` 0, or \"spherical\"; a larger `radius` makes less noise";
                let warning = warning(help);
                found.push(match span {
                    Some(span) => warning.and(*span, "the rays of this camera start in several places"),
                    None => warning,
                });
            }
        }
    }
}
