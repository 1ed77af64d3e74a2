//! Layers: what a picture may record of every pixel besides its colour (elsewhere: AOVs, arbitrary output variables).
//!
//! A film says which layers it wants ([`crate::camera::Film::layers`]); nothing is computed or stored for the others. A layer's
//! value of a pixel is the mean over the camera rays of the pixel that have such a value.

use crate::diagnostics::did_you_mean;

/// Something that is recorded of the camera rays of a pixel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// Impact parameter b of the orbit (scene units).
    ImpactParameter,
    /// Angle swept around the hole (rad).
    SweptAngle,
    /// Smallest distance from the hole's centre (scene units, areal radius).
    ClosestApproach,
    /// Turns around the hole: the swept angle over 2 pi.
    Winding,
    /// `g = nu_observed / nu_emitted = lambda_emitted / lambda_observed`.
    Redshift,
    /// Questions that were put to the intersector.
    Queries,
    /// Shares of the rays that arrive on a surface, escape, and fall into the hole.
    Outcome,
    /// The material's reflectance (linear sRGB, as seen under D65).
    Albedo,
    /// The point of the surface (world space).
    Position,
    /// The surface's outer unit normal (world space, chart).
    Normal,
    /// The unit normal that shading uses (world space, chart).
    ShadingNormal,
    /// Distance of the surface's point from where the ray starts, in the chart (scene units).
    Depth,
    /// The side of a wormhole on which the ray ends, on a surface or far away: 0 the near one, 1 the far one.
    Side,
    /// Variance of the samples of a pixel's colour (linear sRGB). Not of the camera rays: of what the light transport finds.
    Variance,
}

impl Layer {
    /// All layers, in the order of the language reference.
    pub const ALL: [Self; 14] = [
        Self::ImpactParameter,
        Self::SweptAngle,
        Self::ClosestApproach,
        Self::Winding,
        Self::Redshift,
        Self::Queries,
        Self::Outcome,
        Self::Albedo,
        Self::Position,
        Self::Normal,
        Self::ShadingNormal,
        Self::Depth,
        Self::Side,
        Self::Variance,
    ];

    /// The name that scenes and the command line use.
    pub fn name(self) -> &'static str {
        match self {
            Self::ImpactParameter => "impactparameter",
            Self::SweptAngle => "sweptangle",
            Self::ClosestApproach => "closestapproach",
            Self::Winding => "winding",
            Self::Redshift => "redshift",
            Self::Queries => "queries",
            Self::Outcome => "outcome",
            Self::Albedo => "albedo",
            Self::Position => "position",
            Self::Normal => "normal",
            Self::ShadingNormal => "shadingnormal",
            Self::Depth => "depth",
            Self::Side => "side",
            Self::Variance => "variance",
        }
    }

    /// The layer of the given name.
    ///
    /// # Errors
    /// What to write instead.
    pub fn from_name(name: &str) -> Result<Self, String> {
        Self::ALL.into_iter().find(|l| l.name() == name).ok_or_else(|| {
            let names = Self::ALL.map(Self::name);
            let all = names.join(", ");
            match did_you_mean(name, names) {
                Some(near) => format!("did you mean `{near}`? There is {all}"),
                None => format!("there is {all}"),
            }
        })
    }

    /// Names of its channels in the EXR file: one or three. Those of surfaces are the names of pbrt-v4's film `gbuffer`.
    #[inline]
    pub fn channels(self) -> &'static [&'static str] {
        match self {
            Self::ImpactParameter => &["impactparameter"],
            Self::SweptAngle => &["sweptangle"],
            Self::ClosestApproach => &["closestapproach"],
            Self::Winding => &["winding"],
            Self::Redshift => &["redshift"],
            Self::Queries => &["queries"],
            Self::Outcome => &["outcome.hit", "outcome.escaped", "outcome.captured"],
            Self::Albedo => &["Albedo.R", "Albedo.G", "Albedo.B"],
            Self::Position => &["P.X", "P.Y", "P.Z"],
            Self::Normal => &["N.X", "N.Y", "N.Z"],
            Self::ShadingNormal => &["Ns.X", "Ns.Y", "Ns.Z"],
            Self::Depth => &["depth"],
            Self::Side => &["side"],
            Self::Variance => &["Variance.R", "Variance.G", "Variance.B"],
        }
    }

    /// Its unit; empty for pure numbers.
    pub fn unit(self) -> &'static str {
        match self {
            Self::ImpactParameter | Self::ClosestApproach | Self::Position | Self::Depth => "scene",
            Self::SweptAngle => "rad",
            _ => "",
        }
    }

    /// Whether it is a unit vector, whose mean is brought back to length 1.
    pub fn is_unit_vector(self) -> bool {
        matches!(self, Self::Normal | Self::ShadingNormal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn names_and_channels_are_unique_and_found_again() {
        let mut channels = BTreeSet::from(["R", "G", "B"]);
        for layer in Layer::ALL {
            assert_eq!(Layer::from_name(layer.name()), Ok(layer));
            assert!(matches!(layer.channels().len(), 1 | 3));
            assert!(layer.channels().iter().all(|c| channels.insert(c)), "{layer:?}");
        }
    }

    #[test]
    fn a_wrong_name_gets_a_suggestion_and_the_list() {
        let near = Layer::from_name("redshft").expect_err("no such layer");
        assert!(near.contains("did you mean `redshift`") && near.contains("sweptangle"), "{near}");
        let far = Layer::from_name("cheese").expect_err("no such layer");
        assert!(!far.contains("did you mean") && far.contains("albedo"), "{far}");
    }
}
