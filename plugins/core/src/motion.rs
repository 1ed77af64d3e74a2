//! Who moves how: the contract of the motions.
//!
//! A motion is a field of observers: it answers which one passes a place. Cameras name one, `static` by default. The answer is an
//! [`Observer`], who answers in turn, direction by direction, which local direction and which wavelength light has there.

use crate::Plugin;
use crate::diagnostics::{Diagnostic, Spanned};
use crate::observer::Observer;
use crate::params::{Params, Vector3};
use crate::spacetime::{Place, Spacetime};
use std::fmt::Debug;

/// How something moves. One implementation, one plugin.
pub trait Motion: Debug + Send + Sync {
    /// The observer who moves so where he passes `place` (render space); `None` where nothing can move so, as below a horizon.
    ///
    /// `spacetime` is what light moves through, in coordinates of render space; `None` is flat space. `at_rest` is the static observer of the
    /// place, by the conventions of the picture; `None` where nothing can stand still, which does not mean that nothing can move there.
    fn observer(&self, spacetime: Option<&dyn Spacetime>, place: Place, at_rest: Option<Observer>) -> Option<Observer>;

    /// Whether the answer is `at_rest` everywhere, so that nobody needs to ask.
    fn is_static(&self) -> bool {
        false
    }
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
