//! Orbits in closed form, in stretches: what the driver follows by `exact`.

use crate::spherical::Attraction;
use crate::spherical::closed_form::{ClosedForm, ExactStep, STRETCH};
use crate::spherical::course::Method;
use crate::spherical::plane::{Polars, room};
use crate::spherical::steps::Stretch;
use bhs_core::real::Real;
use bhs_elementary::Elementary;

/// In closed form: those of the orbits, one after the other.
#[derive(Clone, Copy, Debug)]
pub struct ClosedForms<'a>(pub &'a [ClosedForm]);

/// Stretches of orbits in closed form.
#[derive(Clone, Copy, Debug)]
pub struct ExactStretch<'a, F> {
    forms: &'a [ClosedForm],
    start: Polars<F>,
    end: Polars<F>,
}

/// The states of orbits at the angles `phi`.
fn states<F: Real>(forms: &[ClosedForm], phi: F) -> Polars<F> {
    let form = |i: usize| &forms[i.min(forms.len() - 1)];
    let state = |i: usize| form(i).at(phi.lane(i));
    Polars {
        phi,
        u: F::from_fn(|i| state(i).0),
        du: F::from_fn(|i| state(i).1),
        cos: F::from_fn(|i| phi.lane(i).cosine()),
        sin: F::from_fn(|i| phi.lane(i).sine()),
    }
}

impl<'a, F: Real> Method<F> for ClosedForms<'a> {
    type Steps = ExactStretch<'a, F>;

    fn nowhere(&self, at: &Polars<F>) -> ExactStretch<'a, F> {
        ExactStretch { forms: self.0, start: *at, end: *at }
    }

    fn step(&self, hole: Attraction, start: &Polars<F>, steps: &mut ExactStretch<'a, F>) {
        let end = states(self.0, start.phi + room(hole, start.u, start.du, F::splat(STRETCH)));
        (steps.start, steps.end) = (*start, end);
    }
}

impl<'a, F: Real> Stretch<F> for ExactStretch<'a, F> {
    type One = ExactStep<'a>;

    fn start(&self) -> &Polars<F> {
        &self.start
    }

    fn end(&self) -> &Polars<F> {
        &self.end
    }

    fn polar(&self, phi: F) -> Polars<F> {
        states(self.forms, phi)
    }

    fn lane(&self, i: usize) -> ExactStep<'a> {
        ExactStep::new(&self.forms[i.min(self.forms.len() - 1)], self.start.lane(i), self.end.lane(i))
    }
}
