//! Directives that change the current transform or give it a name.

use crate::lang::resolve::Resolver;
use crate::lang::resolve::call::Call;
use crate::lang::transform::{self, NotAffine};
use bhs_core::diagnostics::shorten;
use glam::{DAffine3, DVec3};
use std::sync::Arc;

impl Resolver<'_> {
    pub(crate) fn identity(&mut self, _: Call) {
        self.state.ctm = Arc::default();
        self.look_at = None;
    }

    pub(crate) fn translate(&mut self, call: Call) {
        self.apply(DAffine3::from_translation(call.point(0)), call.numbers_span);
    }

    pub(crate) fn scale(&mut self, call: Call) {
        let factors = call.point(0);
        if factors.cmpeq(DVec3::ZERO).any() {
            return self.error(
                "bad-transform",
                "a scale of 0 flattens what follows",
                call.numbers_span,
                "",
                "use 1 to keep a size",
            );
        }
        self.apply(DAffine3::from_scale(factors), call.numbers_span);
    }

    pub(crate) fn rotate(&mut self, call: Call) {
        let (degrees, axis) = (call.numbers[0], DVec3::new(call.numbers[1], call.numbers[2], call.numbers[3]));
        match transform::rotate(degrees, axis) {
            Some(t) => self.apply(t, call.numbers_span),
            None => {
                let help = "write Rotate degrees x y z";
                self.error("bad-transform", "the axis of `Rotate` has no direction", call.numbers_span, "", help);
            }
        }
    }

    pub(crate) fn look_at(&mut self, call: Call) {
        match transform::look_at(call.point(0), call.point(1), call.point(2)) {
            Some(t) => {
                self.apply(t, call.numbers_span);
                self.look_at = Some((call.numbers_span, self.state.ctm.transform_point3(call.point(1))));
            }
            None => {
                let (message, help) = if call.point(0) == call.point(1) {
                    (
                        "`LookAt` gives no view: eye and target coincide",
                        "the first point is where the camera stands, the second what it looks at",
                    )
                } else {
                    (
                        "`LookAt` gives no view: up points along it",
                        "another axis is up in such a picture: for a view straight down take 0 0 1",
                    )
                };
                self.error("bad-transform", message, call.numbers_span, "", help);
            }
        }
    }

    pub(crate) fn transform(&mut self, call: Call) {
        if let Some(t) = self.matrix(&call) {
            self.state.ctm = Arc::new(t);
            self.look_at = None;
        }
    }

    pub(crate) fn concat_transform(&mut self, call: Call) {
        if let Some(t) = self.matrix(&call) {
            self.apply(t, call.numbers_span);
        }
    }

    fn matrix(&mut self, call: &Call) -> Option<DAffine3> {
        let numbers: &[f64; 16] = call.numbers.as_slice().try_into().ok()?;
        let (message, help) = match transform::matrix(numbers) {
            Ok(t) => return Some(t),
            Err(NotAffine::Projective) => (
                "this matrix is projective, not a transform of space",
                "matrices are written column by column, as in pbrt: numbers 4, 8 and 12 are 0, and the translation is in 13, 14, 15",
            ),
            Err(NotAffine::Singular) => ("this matrix flattens space", "its three axes must span space"),
        };
        self.error("bad-transform", message, call.numbers_span, "", help);
        None
    }

    pub(crate) fn coordinate_system(&mut self, call: Call) {
        self.systems.insert(call.name.value, *self.state.ctm);
    }

    pub(crate) fn coord_sys_transform(&mut self, call: Call) {
        if let Some(t) = self.systems.get(&call.name.value) {
            self.state.ctm = Arc::new(*t);
            self.look_at = None;
        } else if !self.scene.incomplete {
            let near = self.suggestions.near(&call.name.value, self.systems.keys().map(String::as_str));
            let help = near.map_or_else(|| "name one with `CoordinateSystem`".to_owned(), |n| format!("did you mean `{n}`?"));
            let message = format!("unknown coordinate system `{}`", shorten(&call.name.value));
            self.error("unknown-coordinate-system", message, call.name.span, "", help);
        }
    }
}
