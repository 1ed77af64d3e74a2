//! Light sampling: which rays between two points are found in which spacetimes.

use crate::graded_index::connect::GradedConnections;
use crate::kerr::connections::KerrConnections;
use crate::round::charged::ChargedConnections;
use crate::spherical::connections::{Chord, SphericalConnections};
use crate::tolerance::Tolerance;
use bhs_core::spacetime::{Class, Spacetime};
use bhs_engine::connections::Connections;

/// What finds the rays between two points.
#[derive(Clone, Debug)]
pub enum AnyConnections {
    /// Around a hole without charge.
    Spherical(SphericalConnections),
    /// Around a charged hole.
    Charged(ChargedConnections),
    /// Around a hole that spins.
    Kerr(KerrConnections),
    /// Of a refractive index.
    Index(GradedConnections),
}

impl AnyConnections {
    /// For `spacetime`, wherever it is moved to; rays of less than `turns` whole turns around one centre, and shadow rays of such chords. `None` where
    /// none can be found.
    pub fn new(spacetime: &dyn Spacetime, chord: Chord, turns: u32) -> Option<Self> {
        // Steps of fixed size are a matter of orbits; elsewhere chords keep to the ray's footprint.
        let tolerance = match chord {
            Chord::Tolerance(tolerance) => tolerance,
            Chord::Angle(_) => Tolerance::DEFAULT,
        };
        match spacetime.class() {
            Class::Spherical(hole) if hole.charge_squared == 0.0 => Some(Self::Spherical(SphericalConnections { turns, chord })),
            Class::Spherical(hole) => Some(Self::Charged(ChargedConnections::new(&hole, tolerance, turns))),
            Class::Index(_) => GradedConnections::new(spacetime, tolerance, turns).map(Self::Index),
            Class::Kerr(_) => Some(Self::Kerr(KerrConnections { tolerance })),
            Class::Flat | Class::General(_) => None,
        }
    }

    /// Whether light sampling with them takes less time than it saves, in most pictures (`docs/performance.md`).
    pub fn pays(&self) -> bool {
        match self {
            Self::Spherical(_) | Self::Charged(_) | Self::Kerr(_) => true,
            Self::Index(connections) => connections.are_round(),
        }
    }

    /// As what light sampling asks.
    pub fn offered(&self) -> &dyn Connections {
        match self {
            Self::Spherical(connections) => connections,
            Self::Charged(connections) => connections,
            Self::Kerr(connections) => connections,
            Self::Index(connections) => connections,
        }
    }
}
