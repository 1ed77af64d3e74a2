//! Who moves how: the contract of the motions.
//!
//! A motion is a field of observers: it answers which one passes a place. Cameras and shapes name one, `static` by default. The answer is an
//! [`Observer`], who answers in turn, direction by direction, which local direction and which wavelength light has there.

use crate::Plugin;
use crate::diagnostics::{Diagnostic, Spanned};
use crate::observer::{Conventions, Observer};
use crate::params::{Params, Vector3};
use crate::spacetime::{Axial, Normal, Place, Spacetime, Stationary, Stretch};
use glam::DVec3;
use std::fmt::Debug;

/// A place, and what a motion may know of it.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings<'a> {
    /// What light moves through, in coordinates of render space; `None`: flat space.
    pub spacetime: Option<&'a dyn Spacetime>,
    /// The place, render space.
    pub place: Place,
    /// What the picture takes of nature.
    pub conventions: Conventions,
}

impl Surroundings<'_> {
    /// The metric as the static observer has it; `None` where nothing can stand still.
    pub fn stationary(&self) -> Option<Stationary> {
        self.spacetime.map_or(Some(Stationary::FLAT), |spacetime| spacetime.at(self.place))
    }

    /// The static observer; `None` where nothing can stand still.
    pub fn at_rest(&self) -> Option<Observer> {
        self.stationary().map(|here| self.conventions.observer(&here))
    }

    /// The metric as the observer has it who is dragged with space, also where nothing can stand still; `None` where there is none.
    pub fn normal(&self) -> Option<Normal> {
        let flat = Normal { lapse: 1.0, root: Stretch::IDENTITY, drag: DVec3::ZERO };
        self.spacetime.map_or(Some(flat), |spacetime| spacetime.normal(self.place))
    }

    /// The observer who moves through the chart with dx/dt = `velocity` (units of c); `None` where that is as fast as light.
    pub fn moving(&self, velocity: DVec3) -> Option<Observer> {
        let normal = self.normal()?;
        let relative = normal.relative(velocity);
        (relative.length_squared() < 1.0).then(|| self.conventions.normal_observer(&normal).moving(relative))
    }

    /// The single hole that there is.
    pub fn axial(&self) -> Option<Axial> {
        self.spacetime.and_then(Spacetime::axial)
    }
}

/// How something moves. One implementation, one plugin.
pub trait Motion: Debug + Send + Sync {
    /// The observer who moves so where he passes a place; `None` where nothing can move so, as below a horizon.
    fn observer(&self, here: &Surroundings) -> Option<Observer>;

    /// Whether everything that moves so is at rest, so that nobody needs to ask.
    fn is_static(&self) -> bool {
        false
    }

    /// Why nothing moves so anywhere in `spacetime` (`None`: flat space), in words that stand under the name; `None` if something may.
    fn fault(&self, _spacetime: Option<&dyn Spacetime>) -> Option<String> {
        None
    }

    /// Moves it by `-origin`, from world space to render space. Called once, before anything else.
    fn rebase(&mut self, _origin: DVec3) {}
}

/// What finds the motion of a name, or says that there is none.
pub type FindMotion<'a> = &'a dyn Fn(&Spanned<String>) -> Result<Plugin<dyn Motion>, Box<Diagnostic>>;

/// The name of the motion that its own parameter implies.
const IMPLIED: &str = "velocity";

/// The motion that the parameters of a directive name: `motion`, and those of the motion itself beside it. `velocity` need not be named where
/// the parameter of that name stands. `None`: at rest, or something is wrong, which is reported.
pub fn read_motion(p: &Params, find: FindMotion) -> Option<Box<dyn Motion>> {
    let about = "how it moves, the name of a motion; that motion's parameters stand beside it";
    let name = p.get("motion", "static".to_owned(), "", about);
    let name = match (p.is_given("motion"), p.is_given(IMPLIED)) {
        (false, false) => return None,
        (false, true) => Spanned::new(IMPLIED.to_owned(), p.span_of(IMPLIED)),
        (true, _) => Spanned::new(name, p.span_of("motion")),
    };
    if name.value != IMPLIED && p.is_given(IMPLIED) {
        // Asked for, so that it is not unknown as well.
        p.optional::<Vector3>(IMPLIED, "c", "");
    }
    match find(&name) {
        Ok(plugin) => {
            if plugin.name != IMPLIED && p.is_given(IMPLIED) {
                p.reject(
                    IMPLIED,
                    format!("the motion `{}` takes no `{IMPLIED}`", plugin.name),
                    "remove it, or leave `motion` out",
                );
            }
            (plugin.build)(p).filter(|motion| !motion.is_static())
        }
        Err(unknown) => {
            p.report(*unknown);
            None
        }
    }
}
