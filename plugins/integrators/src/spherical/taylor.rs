//! Light orbits around a round hole by long Taylor steps (`series`).

use crate::spherical::Attraction;
use crate::spherical::orbit::{Dense, Fate, State, Stepper};
use crate::spherical::plane::Polars;
use crate::spherical::steps::{Steps, Stretch, errors};
use bhs_elementary::Elementary;

/// An orbit stepped by Taylor series.
#[derive(Clone, Copy, Debug)]
pub struct TaylorOrbit {
    hole: Attraction,
    state: Polars<f64>,
    /// Largest error of u in a step.
    error: f64,
}

impl TaylorOrbit {
    /// The orbit from `start`. Its points stray from the true orbit by about `error` times the distance from the hole, as far as
    /// double precision goes ([`errors`]).
    pub fn new(hole: impl Into<Attraction>, start: State, error: f64) -> Self {
        let hole = hole.into();
        let State { phi, u, du } = start;
        let state = Polars { phi, u, du, cos: phi.cosine(), sin: phi.sine() };
        Self { hole, state, error: errors(hole, &state, error) }
    }
}

fn state(p: &Polars<f64>) -> State {
    State { phi: p.phi, u: p.u, du: p.du }
}

impl Dense for Steps<f64> {
    fn start(&self) -> State {
        state(&self.start)
    }

    fn end(&self) -> State {
        state(&self.end)
    }

    fn at(&self, phi: f64) -> State {
        state(&Stretch::polar(self, phi))
    }

    fn until(self, end: State) -> Self {
        // The state itself, not what the series gives for it.
        let State { phi, u, du } = end;
        Self { end: Polars { phi, u, du, ..Stretch::polar(&self, phi) }, ..self }
    }
}

impl Stepper for TaylorOrbit {
    type Step = Steps<f64>;

    fn advance(&mut self) -> (Steps<f64>, Fate) {
        let step = Steps::from(self.hole, &self.state, self.error);
        self.state = step.end;
        (step, step.fate(self.hole))
    }
}
