//! The metric at a point as observers have it who do not turn with respect to space.

use super::{Metric, Place, Side, Spacetime, Stretch};
use crate::dual::Dual;
use glam::{DMat3, DVec3};

/// The metric split as the observers have it who do not turn with respect to space (of zero angular momentum; orthogonal to the slices of
/// constant time): `ds^2 = -alpha^2 dt^2 + h (dx - W dt)(dx - W dt)`.
///
/// They exist down to horizons, also in ergospheres, where nothing can stand still; in static spacetimes they are the static observers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normal {
    /// `alpha`: rate of their clock against that of a clock far away.
    pub lapse: f64,
    /// Symmetric root of `h`.
    pub root: Stretch,
    /// `W`: how they move through the chart, dx/dt.
    pub drag: DVec3,
}

impl Normal {
    /// That of the point `x` of a metric; `None` where there is none, as within horizons.
    pub fn of_metric(metric: &(impl Metric + ?Sized), x: DVec3) -> Option<Self> {
        let inverse = metric.inverse(Dual::variables(x));
        let square = -1.0 / inverse.tt.value;
        let drag = DVec3::from_array(inverse.t.map(|t| -t.value)) * square;
        let [xx, yy, zz, yz, xz, xy] = inverse.space.map(|g| g.value);
        let space = DMat3::from_cols(DVec3::new(xx, xy, xz), DVec3::new(xy, yy, yz), DVec3::new(xz, yz, zz));
        let dyad = DMat3::from_cols(drag * drag.x, drag * drag.y, drag * drag.z);
        let root = Stretch::of_metric((space + dyad * (1.0 / square)).inverse())?;
        (square > 0.0 && square.is_finite()).then(|| Self { lapse: square.sqrt(), root, drag })
    }

    /// That of a place where something may stand still, in a static spacetime; else of its metric.
    pub(super) fn of<S: Spacetime + ?Sized>(spacetime: &S, place: Place) -> Option<Self> {
        match spacetime.at(place) {
            Some(here) if here.beta == DVec3::ZERO => Some(Self { lapse: here.lapse, root: here.root, drag: DVec3::ZERO }),
            Some(_) => Self::of_metric(spacetime.metric(), place.x),
            // Where nothing stands still in a static spacetime, there is no place.
            None if place.side == Side::Near && spacetime.drags() => Self::of_metric(spacetime.metric(), place.x),
            None => None,
        }
    }

    /// Velocity against this observer, in its frame, of what moves through the chart with dx/dt = `velocity` (units of c).
    pub fn relative(&self, velocity: DVec3) -> DVec3 {
        self.root.apply(velocity - self.drag) / self.lapse
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kerr, Spherical};
    use super::*;

    fn hole(spin: f64) -> Kerr {
        let round = Spherical { center: DVec3::new(0.5, 0.0, -1.0), rs: 2.0, charge_squared: 0.04 };
        Kerr::new(round, DVec3::new(0.6, 0.0, 0.8), spin)
    }

    #[test]
    fn closed_forms_are_those_of_the_metric() {
        for spin in [0.9, -0.5] {
            let hole = hole(spin);
            // The last two in the ergosphere.
            for x in [DVec3::new(4.0, 1.0, -2.0), DVec3::new(0.5, 2.0, -0.9), DVec3::new(0.4, 1.85, -0.9)] {
                let place = Place::near(hole.round().center + x);
                let (found, right) = (hole.normal(place).unwrap(), Normal::of_metric(&hole, place.x).unwrap());
                assert!((found.lapse - right.lapse).abs() < 1e-13 && (found.drag - right.drag).length() < 1e-13);
                for v in [DVec3::X, DVec3::new(0.3, -0.4, 0.8)] {
                    assert!((found.root.apply(v) - right.root.apply(v)).length() < 1e-12);
                }
            }
            assert!(hole.normal(Place::near(hole.round().center + DVec3::X)).is_none());
        }
    }
}
