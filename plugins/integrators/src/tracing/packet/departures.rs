//! Those of a packet that begin exactly on surfaces.

use super::Packet;
use crate::tracing::arc::Arc;
use crate::tracing::places::{CurvePoint, CurvePoints};
use crate::tracing::surfaces::Surfaces;
use bhs_core::geometry::Segment;
use bhs_core::intersector::PrimitiveHit;
use bhs_core::lanes::{LANES, set_bits};
use bhs_core::real::{Mask, Real, Vector};

impl<F: Real> Packet<'_, F> {
    /// Cuts the first chords of the rays `departing` (bits) short, which go to `to`, if they have to be.
    #[cold]
    pub fn cut_short<A: Arc<F>>(&mut self, piece: &A, from: &CurvePoints<F>, to: &mut CurvePoints<F>, departing: u32) {
        let mut places: [CurvePoint; LANES] = std::array::from_fn(|i| to.lane(i.min(F::COUNT - 1)));
        for i in set_bits(departing) {
            let Some(departure) = self.departures[i].as_mut() else { continue };
            // Only the first chord leaves anything; the next may begin as near to the surface.
            let is_first = self.has_before.bits() >> i & 1 == 0;
            let cut = if is_first { departure.cut_short(&piece.lane(i), &from.lane(i), &places[i]) } else { None };
            if let Some(departure) = self.departures[i].as_mut() {
                departure.cut = if is_first { cut.map(|cut| cut.s) } else { departure.cut };
            }
            places[i] = cut.unwrap_or(places[i]);
        }
        *to = CurvePoints { s: F::from_fn(|i| places[i].s), points: Vector::from_fn(|i| places[i].point) };
    }

    /// What the part `segment`, which begins at the parameter `enter`, of a chord of ray number `i` meets, which has just left a surface.
    #[cold]
    pub fn depart(&self, i: usize, surfaces: &Surfaces<'_>, segment: &Segment, enter: f64) -> Option<PrimitiveHit> {
        let departure = self.departures[i].as_ref()?;
        let is_first = self.has_before.bits() >> i & 1 == 0;
        if is_first && enter == 0.0 {
            surfaces.half.closest_from(segment, Some(departure.primitive))
        } else if !is_first && departure.cut.is_some() {
            surfaces.half.closest_from(segment, None)
        } else {
            surfaces.half.closest(segment, None)
        }
    }

    /// The rays `departing` (bits) have made a chord: those of them whose first was not cut short, or whose second it was, have left.
    #[cold]
    pub fn have_departed(&mut self, departing: u32) {
        for i in set_bits(departing) {
            let is_first = self.has_before.bits() >> i & 1 == 0;
            let is_cut = self.departures[i].is_some_and(|departure| departure.cut.is_some());
            if !(is_first && is_cut) {
                self.departing &= !(1 << i);
            }
        }
    }
}
