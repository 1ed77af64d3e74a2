//! One ray from its start to where it ends, piece by piece, whatever bends it.

use crate::tracing::arc::Arc;
use crate::tracing::chords::Chords;
use bhs_core::integrator::{Arrival, SurfaceHit};
use bhs_core::intersector::Primitive;
use bhs_core::spacetime::Side;
use crate::log::TraceLog;
use bhs_core::world::World;
use glam::DVec3;

/// A ray that can be followed: its pieces, one after the other.
pub trait Course {
    /// The curve of one piece, in the chart of the side that the ray is on.
    type Piece: Arc<f64>;

    /// The next piece, and how the ray goes on behind it. A piece may have no length, and then no points.
    ///
    /// The parameters of a piece go on where those of the piece before end.
    fn advance(&mut self) -> (Self::Piece, Next);
}

/// How a ray goes on behind a piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Next {
    /// There is another piece.
    GoesOn,
    /// The piece ends on the throat; the next one begins in the chart of the other side.
    Crosses,
    /// It meets nothing any more.
    Escapes {
        /// Where to (unit vector of the chart).
        direction: DVec3,
        /// The parameter that stands for the whole ray.
        parameter: f64,
    },
    /// It ends where no light comes from.
    Falls,
    /// It cannot be followed further.
    Lost,
}

/// A ray that is to be followed, besides its course.
#[derive(Clone, Copy, Debug)]
pub struct Start {
    /// Where the first chord begins: on the course, or just off a surface beside it (scene units).
    pub origin: DVec3,
    /// Unit chart direction.
    pub launch: DVec3,
    /// The side on which that is.
    pub side: Side,
    /// What the ray leaves, if the origin lies on it exactly.
    pub leaving: Option<Primitive>,
    /// Largest distance between chords and course (scene units); may be infinite.
    pub gap: f64,
    /// The parameter at which the ray ends, if nothing stands in its way before.
    pub limit: f64,
    /// Pieces after which it is given up.
    pub max_steps: u64,
}

/// Where a ray ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// On a surface.
    Surface(SurfaceHit),
    /// Where it was to end: here, on this side.
    Limit(DVec3, Side),
    /// Far away, in this direction, on this side.
    Sky(DVec3, Side),
    /// Where no light comes from.
    Fallen,
    /// It was given up.
    Lost,
}

impl End {
    /// The same of a ray without a limit; counts it.
    pub fn arrival(self, log: &mut TraceLog) -> Arrival {
        let counters = &mut log.counters;
        match self {
            Self::Surface(hit) => {
                counters.hit += 1;
                Arrival::Surface(hit)
            }
            Self::Sky(direction, side) => {
                counters.escaped += 1;
                Arrival::Sky(direction, side)
            }
            Self::Fallen => {
                counters.captured += 1;
                Arrival::Hole
            }
            Self::Limit(..) | Self::Lost => {
                counters.out_of_steps += 1;
                Arrival::OutOfSteps
            }
        }
    }
}

/// Follows `course` through `world`: where it ends, and the parameter there. Counts steps, queries and leaps, and notes points.
pub fn follow<C: Course>(world: &World, start: &Start, course: &mut C, log: &mut TraceLog) -> (End, f64) {
    log.point(start.origin);
    let mut side = start.side;
    let mut chords = Chords::of_ray(world, start);
    let mut parameter = 0.0;
    for _ in 0..start.max_steps {
        let (piece, next) = course.advance();
        log.counters.steps += 1;
        let ends = piece.end() >= start.limit;
        let piece = if ends { piece.until(start.limit.max(piece.start())) } else { piece };
        if piece.end() > piece.start() {
            let crosses = next == Next::Crosses && !ends;
            if let Some((hit, parameter)) = chords.meet(&piece, crosses, log) {
                log.point(hit.point);
                return (End::Surface(hit), parameter);
            }
            parameter = piece.end();
        }
        if ends {
            return (End::Limit(chords.last().unwrap_or(start.origin), side), start.limit);
        }
        match next {
            Next::GoesOn => {}
            Next::Crosses => {
                side = side.other();
                chords = Chords::on_side(world, side, start.gap);
            }
            Next::Escapes { direction, parameter } => return (End::Sky(direction, side), parameter),
            Next::Falls => return (End::Fallen, parameter),
            Next::Lost => return (End::Lost, parameter),
        }
    }
    (End::Lost, parameter)
}
