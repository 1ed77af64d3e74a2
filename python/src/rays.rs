//! Rays in batches, and what is known of them as columns.

use crate::fault::Fault;
use crate::scene::Made;
use crate::watched::watched;
use bhs::render::Job;
use bhs::threads;
use bhs::trace::followed::{Asked, Followed, Joined, Light, WayPoint, joined};
use bhs_core::ray::Ray;
use bhs_core::spacetime::Side;
use glam::DVec3;
use numpy::{IntoPyArray, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Rays that a thread follows together.
const TOGETHER: usize = 64;

/// What may become of a ray, in the order of the numbers that stand for it.
const OUTCOMES: [&str; 4] = ["hit", "escaped", "captured", "out of steps"];

/// Rays as arrays of one length.
#[derive(FromPyObject)]
pub struct RayArrays<'py>(
    /// Where they start, in world space, a row a ray.
    PyReadonlyArray2<'py, f64>,
    /// Chart directions, of any length.
    PyReadonlyArray2<'py, f64>,
    /// Whether each starts on the far side.
    PyReadonlyArray1<'py, bool>,
    /// Widths of the patches that they stand for (scene units).
    PyReadonlyArray1<'py, f64>,
);

/// The rows of an array of three columns.
fn points(array: &PyReadonlyArray2<f64>) -> Vec<DVec3> {
    let numbers: Vec<f64> = array.as_array().iter().copied().collect();
    numbers.chunks_exact(3).map(DVec3::from_slice).collect()
}

impl RayArrays<'_> {
    /// The rays, or which of them is none.
    pub fn asked(&self) -> Result<Vec<Asked>, Fault> {
        let Self(origins, directions, far, footprints) = self;
        let (origins, directions) = (points(origins), points(directions));
        let (far, footprints) = (far.as_array(), footprints.as_array());
        let read = |number: usize| {
            let (origin, direction, footprint) = (origins[number], directions[number], footprints[number]);
            let fault = |what: &str| Fault::new(format!("ray {number}: {what}"));
            if !origin.is_finite() || !direction.is_finite() {
                return Err(fault("its origin and direction are to be finite numbers"));
            }
            if !(footprint.is_finite() && footprint >= 0.0) {
                return Err(fault("its footprint is to be a length, or 0 if it is unknown"));
            }
            let side = if far[number] { Side::Far } else { Side::Near };
            Asked::ray(origin, direction, side, footprint).map_err(fault)
        };
        (0..origins.len()).map(read).collect()
    }
}

/// Does something with each of many in parallel, in groups, and can be stopped.
fn in_groups<'py, T: Send + Sync + 'static, R: Send + 'static>(
    py: Python<'py>,
    all: Vec<T>,
    (threads, progress): (Option<u32>, Option<Bound<'py, PyAny>>),
    work: impl Fn(&[T], usize) -> Vec<R> + Send + Sync + 'static,
) -> PyResult<Vec<R>> {
    let count = all.len();
    let stop = Arc::new(AtomicBool::new(false));
    let done = Arc::new(AtomicUsize::new(0));
    let (stopped, counted) = (Arc::clone(&stop), Arc::clone(&done));
    let run = move || -> Result<Vec<R>, Fault> {
        let group = |(i, group): (usize, &[T])| {
            if stopped.load(Ordering::Relaxed) {
                return Vec::new();
            }
            let found = work(group, i * TOGETHER);
            counted.fetch_add(group.len(), Ordering::Relaxed);
            found
        };
        let pool = threads::start(threads)?;
        Ok(pool.install(|| all.par_chunks(TOGETHER).enumerate().flat_map_iter(group).collect()))
    };
    let tell = || match &progress {
        Some(call) => call.call1((done.load(Ordering::Relaxed), count)).map(|_| ()),
        None => Ok(()),
    };
    Ok(watched(py, run, || stop.store(true, Ordering::Relaxed), tell)??)
}

/// Columns under way.
struct Columns<'py>(Bound<'py, PyDict>);

impl<'py> Columns<'py> {
    fn new(py: Python<'py>) -> Self {
        Self(PyDict::new(py))
    }

    fn numbers<T: numpy::Element>(&self, name: &str, values: impl Iterator<Item = T>) -> PyResult<()> {
        self.0.set_item(name, values.collect::<Vec<T>>().into_pyarray(self.0.py()))
    }

    fn vectors(&self, name: &str, values: impl Iterator<Item = Option<DVec3>>) -> PyResult<()> {
        let flat: Vec<f64> = values.flat_map(|v| v.unwrap_or(DVec3::NAN).to_array()).collect();
        let rows = flat.len() / 3;
        self.0.set_item(name, flat.into_pyarray(self.0.py()).reshape([rows, 3])?)
    }

    fn sides(&self, name: &str, values: impl Iterator<Item = Option<Side>>) -> PyResult<()> {
        let number = |side| match side {
            None => 0,
            Some(Side::Near) => 1,
            Some(Side::Far) => 2,
        };
        self.numbers::<u8>(name, values.map(number))
    }

    /// What has become of rays.
    fn followed(&self, all: &[Followed]) -> PyResult<()> {
        let outcome = |f: &Followed| OUTCOMES.iter().position(|o| *o == f.outcome).unwrap_or_default() as u8;
        self.numbers("outcome", all.iter().map(outcome))?;
        self.vectors("point", all.iter().map(|f| f.point))?;
        self.vectors("direction", all.iter().map(|f| f.direction))?;
        self.numbers("shape", all.iter().map(|f| f.shape.map_or(-1, i64::from)))?;
        self.sides("side", all.iter().map(|f| f.side))?;
        self.numbers("phi", all.iter().map(|f| f.phi))?;
        self.numbers("steps", all.iter().map(|f| f.steps))?;
        self.numbers("queries", all.iter().map(|f| f.queries))?;
        (0..)
            .zip(Light::NAMES)
            .try_for_each(|(k, name)| self.numbers(name, all.iter().map(|f| f.light.numbers()[k].unwrap_or(f64::NAN))))
    }
}

/// Follows rays, by so many threads, telling how far that is.
pub fn trace<'py>(
    py: Python<'py>,
    made: &Arc<Made>,
    asked: Vec<Asked>,
    how: (Option<u32>, Option<Bound<'py, PyAny>>),
) -> PyResult<Bound<'py, PyDict>> {
    let made = Arc::clone(made);
    let all = in_groups(py, asked, how, move |asked: &[Asked], _| Followed::all(&made.built.scene, asked))?;
    let columns = Columns::new(py);
    columns.followed(&all)?;
    Ok(columns.0)
}

/// Follows the rays of pixels.
pub fn trace_pixels<'py>(
    py: Python<'py>,
    made: &Arc<Made>,
    pixels: &PyReadonlyArray2<'py, u32>,
    threads: Option<u32>,
) -> PyResult<Bound<'py, PyDict>> {
    let [width, height] = made.built.film.resolution();
    let job = Job::of(&made.built);
    let read = |row: [u32; 2]| match row {
        [x, y] if x < width && y < height => Ok(Asked::pixel(&job, row)),
        [x, y] => Err(Fault::new(format!("pixel {x},{y}: the picture has {width} columns and {height} rows"))),
    };
    let pixels: Vec<u32> = pixels.as_array().iter().copied().collect();
    let asked: Vec<Asked> = pixels.chunks_exact(2).map(|row| read([row[0], row[1]])).collect::<Result<_, _>>()?;
    let rays: Vec<Ray> = asked.iter().map(|asked| asked.ray).collect();
    let columns = trace(py, made, asked, (threads, None))?;
    let columns = Columns(columns);
    columns.vectors("ray_origin", rays.iter().map(|ray| Some(ray.origin)))?;
    columns.vectors("ray_direction", rays.iter().map(|ray| Some(ray.direction)))?;
    Ok(columns.0)
}

/// The points of the way of one ray.
pub fn path<'py>(py: Python<'py>, made: &Arc<Made>, asked: Vec<Asked>) -> PyResult<Bound<'py, PyDict>> {
    let made = Arc::clone(made);
    let work = move |asked: &[Asked], _| asked.iter().flat_map(|asked| Followed::with_way(&made.built.scene, asked).1).collect();
    let points: Vec<WayPoint> = in_groups(py, asked, (Some(1), None), work)?;
    let columns = Columns::new(py);
    columns.vectors("point", points.iter().map(|p| Some(p.point)))?;
    columns.vectors("direction", points.iter().map(|p| Some(p.direction)))?;
    columns.sides("side", points.iter().map(|p| Some(p.side)))?;
    columns.numbers("phi", points.iter().map(|p| p.phi))?;
    columns.numbers("time", points.iter().map(|p| p.time.unwrap_or(f64::NAN)))?;
    columns.numbers("redshift", points.iter().map(|p| p.redshift.unwrap_or(f64::NAN)))?;
    Ok(columns.0)
}

/// The geodesics between pairs of points.
pub fn connect<'py>(
    py: Python<'py>,
    made: &Arc<Made>,
    (from, to): (&PyReadonlyArray2<'py, f64>, &PyReadonlyArray2<'py, f64>),
    threads: Option<u32>,
) -> PyResult<Bound<'py, PyDict>> {
    if made.built.scene.integrator.connections().is_none() {
        return Err(Fault::new("the integrator cannot connect points").into());
    }
    let pairs: Vec<[DVec3; 2]> = points(from).into_iter().zip(points(to)).map(|(from, to)| [from, to]).collect();
    for (number, [from, to]) in pairs.iter().enumerate() {
        let fault = |what: &str| Err(Fault::new(format!("pair {number}: {what}")).into());
        if !from.is_finite() || !to.is_finite() {
            return fault("its points are to be finite numbers");
        }
        if from == to {
            return fault("the two points are the same");
        }
    }
    let made = Arc::clone(made);
    let work = move |pairs: &[[DVec3; 2]], first: usize| {
        let Some(connections) = made.built.scene.integrator.connections() else { return Vec::new() };
        let each = pairs.iter().enumerate();
        each.flat_map(|(i, pair)| {
            joined(&made.built.scene, connections, *pair).into_iter().map(move |joined| (first + i, joined))
        })
        .collect()
    };
    let all: Vec<(usize, Joined)> = in_groups(py, pairs, (threads, None), work)?;
    let columns = Columns::new(py);
    columns.numbers("pair", all.iter().map(|(pair, _)| *pair as i64))?;
    columns.numbers("image", all.iter().map(|(_, joined)| joined.image as i64))?;
    columns.numbers("phi", all.iter().map(|(_, joined)| joined.connection.phi))?;
    columns.vectors("launch", all.iter().map(|(_, joined)| Some(joined.connection.launch)))?;
    columns.vectors("arrival", all.iter().map(|(_, joined)| Some(joined.connection.arrival)))?;
    columns.numbers("spread", all.iter().map(|(_, joined)| joined.connection.spread))?;
    columns.numbers("blocked", all.iter().map(|(_, joined)| joined.is_blocked))?;
    Ok(columns.0)
}
