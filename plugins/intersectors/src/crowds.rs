//! An intersector of single precision, made exact where surfaces touch or nearly touch.

use crate::contacts::Contacts;
use crate::exact::Exact;
use bhs_core::geometry::{Geometry, Segment};
use bhs_core::intersector::{Ends, Intersector, Primitive, PrimitiveHit, SHADOW_END};
use glam::DVec3;

/// What finds surfaces in single precision.
pub(crate) trait SinglePrecision: Send + Sync {
    /// The first surface along a segment, leaving out the primitives of `without`.
    fn find(&self, segment: &Segment, without: Option<&Contacts>) -> Option<PrimitiveHit>;

    /// Whether there is any, leaving out the primitives of `without`.
    fn find_any(&self, segment: &Segment, without: Option<&Contacts>) -> bool;
}

/// A scene of single precision, and where that is not enough.
pub(crate) struct Guarded<S> {
    pub scene: S,
    pub crowds: Option<Crowds>,
}

/// Where surfaces are close together, and what tells them apart there.
pub(crate) struct Crowds {
    contacts: Contacts,
    exact: Exact,
    geometries: Vec<Geometry>,
}

impl<S: SinglePrecision> Intersector for Guarded<S> {
    fn closest(&self, segment: &Segment) -> Option<PrimitiveHit> {
        let found = self.scene.find(segment, None);
        let Some(crowds) = &self.crowds else { return found };
        if crowds.is_in_doubt(segment, found.as_ref()) { self.closest_exactly(crowds, segment, None) } else { found }
    }

    fn blocked(&self, segment: &Segment) -> bool {
        self.scene.find_any(segment, None) || self.slips_through(segment)
    }

    fn closest_from(&self, segment: &Segment, leaving: Option<Primitive>) -> Option<PrimitiveHit> {
        match &self.crowds {
            Some(crowds) => self.closest_exactly(crowds, segment, leaving),
            None => self.closest(segment),
        }
    }

    fn blocked_between(&self, segment: &Segment, ends: Ends) -> bool {
        if let Some(crowds) = &self.crowds {
            let is_crowded = |p| crowds.contacts.involves(p) && crowds.contacts.is_crowded(segment.at(segment.t_max));
            let end_is_crowded = || ends.target.is_some_and(is_crowded);
            if ends.leaving.is_some() || end_is_crowded() {
                return self.blocked_exactly(crowds, segment, ends);
            }
        }
        self.blocked(&shortened(segment, ends))
    }

    fn is_crowded(&self, point: DVec3) -> bool {
        self.crowds.as_ref().is_some_and(|crowds| crowds.contacts.is_crowded(point))
    }
}

/// A segment without the part just before the primitive on which it ends, if it does.
fn shortened(segment: &Segment, ends: Ends) -> Segment {
    Segment { t_max: if ends.target.is_some() { SHADOW_END * segment.t_max } else { segment.t_max }, ..*segment }
}

impl Crowds {
    /// Those among `geometries`; `None` where nothing comes near anything else.
    pub fn find(geometries: &[Geometry]) -> Option<Self> {
        let contacts = Contacts::find(geometries)?;
        let exact = Exact::new(geometries, contacts.with_neighbours(geometries));
        Some(Self { contacts, exact, geometries: geometries.to_vec() })
    }

    /// Whether something else than what was `found` may come first: another surface near that or near the start, or one where surfaces meet at edges that
    /// they do not share, between which single precision may have let the segment through.
    #[inline]
    fn is_in_doubt(&self, segment: &Segment, found: Option<&PrimitiveHit>) -> bool {
        found.is_some_and(|hit| self.contacts.is_crowded(segment.at(hit.t)))
            || self.contacts.is_crowded(segment.origin)
            || self.contacts.may_slip_through(&Segment { t_max: found.map_or(segment.t_max, |hit| hit.t), ..*segment })
    }

    /// The segment moved off the primitive that it leaves: what is not in the zones is farther away than that.
    fn off_surface(&self, segment: &Segment, leaving: Option<Primitive>) -> Segment {
        let Some(Primitive { geometry, primitive }) = leaving else { return *segment };
        let geometry = &self.geometries[geometry as usize];
        let normal = geometry.normal(primitive, segment.origin);
        let side = if normal.dot(segment.direction) < 0.0 { -normal } else { normal };
        Segment { origin: segment.origin + side * geometry.step_off(primitive), ..*segment }
    }
}

impl<S: SinglePrecision> Guarded<S> {
    /// Whether a segment that is found free is blocked where it may have slipped through between two surfaces.
    #[inline]
    fn slips_through(&self, segment: &Segment) -> bool {
        let crowds = self.crowds.as_ref().filter(|crowds| crowds.contacts.may_slip_through(segment));
        crowds.is_some_and(|crowds| self.blocked_exactly(crowds, segment, Ends::default()))
    }

    /// The first surface along a segment that passes where surfaces are close together, or leaves a primitive there.
    #[cold]
    fn closest_exactly(&self, crowds: &Crowds, segment: &Segment, leaving: Option<Primitive>) -> Option<PrimitiveHit> {
        let close = crowds.exact.closest(segment, leaving);
        let t_max = close.map_or(segment.t_max, |hit| hit.t);
        let others = Segment { t_max, ..crowds.off_surface(segment, leaving) };
        let hit = self.scene.find(&others, Some(&crowds.contacts)).or(close)?;
        let primitive = Primitive { geometry: hit.geometry, primitive: hit.primitive };
        let is_crowded = crowds.contacts.involves(primitive) && crowds.contacts.is_crowded(segment.at(hit.t));
        Some(PrimitiveHit { is_crowded, ..hit })
    }

    /// Whether anything stands in such a segment's way.
    #[cold]
    fn blocked_exactly(&self, crowds: &Crowds, segment: &Segment, ends: Ends) -> bool {
        let others = || shortened(&crowds.off_surface(segment, ends.leaving), ends);
        crowds.exact.blocked(segment, ends) || self.scene.find_any(&others(), Some(&crowds.contacts))
    }
}
