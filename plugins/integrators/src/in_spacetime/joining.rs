//! Light sampling in spacetimes other than flat space and the plain hole: which rays between two points are found in which class.

use crate::flight::Tolerance;
use crate::graded_index::connect::GradedConnections;
use crate::round::charged::ChargedConnections;
use bhs_core::integrator::Connections;
use bhs_core::spacetime::{Class, Spacetime};

/// What finds the rays between two points.
#[derive(Clone, Debug)]
pub enum Joining {
    /// Of a refractive index.
    Index(GradedConnections),
    /// Around a charged hole.
    Charged(ChargedConnections),
}

impl Joining {
    /// For `spacetime`, wherever it is moved to; rays of less than `turns` whole turns around one centre. `None` where none can be found.
    pub fn new(spacetime: &dyn Spacetime, tolerance: Tolerance, turns: u32) -> Option<Self> {
        match spacetime.class() {
            Class::Index(_) => GradedConnections::new(spacetime, tolerance, turns).map(Self::Index),
            Class::Spherical(hole) => Some(Self::Charged(ChargedConnections::new(&hole, tolerance, turns))),
            Class::Flat | Class::General(_) => None,
        }
    }

    /// Whether light sampling with them takes less time than it saves, in most pictures (`docs/performance.md`).
    pub fn pays(&self) -> bool {
        match self {
            Self::Index(connections) => connections.are_round(),
            Self::Charged(_) => true,
        }
    }

    /// As what light sampling asks.
    pub fn offered(&self) -> &dyn Connections {
        match self {
            Self::Index(connections) => connections,
            Self::Charged(connections) => connections,
        }
    }
}
