//! Stars in a picture: each point of the sky, joined to the camera along its geodesics and put where its light arrives.
//!
//! What they add to the pixels depends on the scene and the camera alone, on no sample: it is found before the first one and added when the
//! picture is made of the sums. So it has no noise, is in no checkpoint, and is the same for any number of threads.
//!
//! Formulas: docs/physics.md, section 16.

use crate::job::Job;
use crate::point_picture::{PointCounters, PointPicture};
use arrayvec::ArrayVec;
use bhs_core::camera::{Film, Projection};
use bhs_core::observer::Observer;
use bhs_core::ray::Ray;
use bhs_core::spacetime::{Place, Side};
use bhs_core::spectrum::{N_LAMBDA, SampledWavelengths};
use bhs_engine::connections::{Connection, ConnectionPair, Connections, MOST_TURNS};
use glam::{DVec2, DVec3};
use rayon::prelude::*;

/// Points that are worked on together.
const BATCH: usize = 64;

/// Geodesics that may lead to those.
const MOST: usize = BATCH * 2 * MOST_TURNS;

/// Steps between the wavelengths of a star's spectrum at most (nm), least and largest number of these.
const STEP_NM: f32 = 4.0;
const WAVELENGTHS: std::ops::RangeInclusive<usize> = 120..=8192;

/// Light of one image of a point at one place of the film.
struct Splat {
    /// Pixels.
    raster: DVec2,
    /// Channels of a pixel that has all of its light.
    channels: Vec<f64>,
}

/// The points of the sky in the picture of `job`. `None`: it draws none.
pub fn draw(job: &Job) -> Option<PointPicture> {
    let scene = job.scene;
    if !(scene.draws_points && job.transport.shows_light()) {
        return None;
    }
    let mut picture = PointPicture::new(job.film.channels().len());
    let camera = Place { x: job.camera.position(), side: job.viewpoint.side };
    // Where nothing can stand, nobody sees anything.
    let Some(observer) = scene.camera_observer(camera.x, job.viewpoint) else { return Some(picture) };
    let drawing = Drawing {
        job,
        camera,
        observer,
        connections: scene.integrator.connections()?,
        projection: job.camera.projection()?,
        wavelengths: wavelengths(job.film),
    };
    for (light, points) in scene.light_sampler.lights.iter().enumerate().map(|(i, light)| (i, light.points())) {
        picture.counters.points += points.len() as u64;
        let batches: Vec<usize> = (0..points.len()).step_by(BATCH).collect();
        // In their order, whoever found them.
        let found: Vec<(Vec<Splat>, PointCounters)> = batches.par_iter().map(|first| drawing.batch(light, *first)).collect();
        for (splats, counters) in found {
            picture.counters.images += counters.images;
            picture.counters.occluded += counters.occluded;
            splats.iter().for_each(|splat| drawing.splat(splat, &mut picture));
        }
    }
    Some(picture)
}

/// Wavelengths over the range of a film in equal steps, which its further channels divide evenly.
fn wavelengths(film: &dyn Film) -> Vec<SampledWavelengths> {
    let [lo, hi] = film.lambda_range();
    let buckets = film.channels().len().saturating_sub(3).max(1);
    let wanted = ((hi - lo) / STEP_NM).ceil().clamp(*WAVELENGTHS.start() as f32, *WAVELENGTHS.end() as f32) as usize;
    let count = N_LAMBDA * buckets * wanted.div_ceil(N_LAMBDA * buckets);
    let at = |i: usize| lo + (hi - lo) * ((i as f32 + 0.5) / count as f32);
    let group = |i: usize| std::array::from_fn(|k| at(i + k));
    let pdf = [1.0 / (hi - lo); N_LAMBDA];
    (0..count).step_by(N_LAMBDA).map(|i| SampledWavelengths { lambda_nm: group(i), pdf }).collect()
}

/// What all batches of points share. Whoever draws is `&self` in several threads.
struct Drawing<'a> {
    job: &'a Job<'a>,
    camera: Place,
    observer: Observer,
    connections: &'a dyn Connections,
    projection: &'a dyn Projection,
    wavelengths: Vec<SampledWavelengths>,
}

/// An image of a point that lies in the picture.
struct Image {
    /// Number of the point.
    point: usize,
    connection: Connection,
    /// Places of the film (pixels) with the solid angle of a pixel there (sr).
    places: ArrayVec<(DVec2, f64), 4>,
}

impl Drawing<'_> {
    /// The points of a light from number `first` on.
    fn batch(&self, light: usize, first: usize) -> (Vec<Splat>, PointCounters) {
        let Self { job, connections, .. } = *self;
        let scene = job.scene;
        let (side, points) = (scene.light_sampler.sides[light], scene.light_sampler.lights[light].points());
        let points = &points[first..(first + BATCH).min(points.len())];
        let ends: ArrayVec<(Place, (DVec3, Side)), BATCH> = points.iter().map(|d| (self.camera, (*d, side))).collect();
        let mut pairs: [[ConnectionPair; BATCH]; MOST_TURNS] = [[[None; 2]; BATCH]; MOST_TURNS];
        let turns = connections.turns() as usize;
        let mut rows: ArrayVec<&mut [ConnectionPair], MOST_TURNS> =
            pairs[..turns].iter_mut().map(|row| &mut row[..ends.len()]).collect();
        connections.connect_sky_all(&scene.world, &ends, &mut rows);
        drop(rows);
        let found =
            (0..ends.len()).flat_map(|i| pairs[..turns].iter().flat_map(move |row| row[i]).flatten().map(move |c| (i, c)));
        let images: ArrayVec<Image, MOST> = found.filter_map(|(i, connection)| self.image(first + i, connection)).collect();

        let ray = |image: &Image| {
            let footprint = scene.footprints.camera;
            let ray = Ray::new(self.camera.x, image.connection.launch);
            (Ray { footprint, side: self.camera.side, ..ray }, side)
        };
        let rays: ArrayVec<(Ray, Side), MOST> = images.iter().map(ray).collect();
        let mut escaped = [false; MOST];
        scene.integrator.escape_all(&scene.world, &rays, &mut escaped[..rays.len()]);
        let mut splats = Vec::new();
        let mut counters = PointCounters::default();
        for (image, escaped) in images.iter().zip(escaped) {
            match escaped {
                true => counters.images += 1,
                false => counters.occluded += 1,
            }
            if escaped {
                splats.extend(self.splats(light, image));
            }
        }
        (splats, counters)
    }

    /// The image of a point along a geodesic, if it lies in the picture or so near that the filter reaches it.
    fn image(&self, point: usize, connection: Connection) -> Option<Image> {
        let mut places = ArrayVec::new();
        let local = self.observer.local_direction(connection.launch);
        let [x0, x1, y0, y1] = self.job.film.crop().map(f64::from);
        let reach = self.job.filter.radius() + 0.5;
        self.projection.project(local, reach.max_element(), &mut |raster, solid_angle| {
            let inside = raster.cmpge(DVec2::new(x0, y0) - reach).all() && raster.cmple(DVec2::new(x1, y1) + reach).all();
            if inside && solid_angle > 0.0 {
                // A picture no wider than the filter may show more; they are of no account.
                let _ = places.try_push((raster, solid_angle));
            }
        });
        (!places.is_empty()).then_some(Image { point, connection, places })
    }

    /// The light of an image, for each of its places.
    fn splats(&self, light: usize, image: &Image) -> impl Iterator<Item = Splat> {
        let scene = self.job.scene;
        let Connection { launch, spread, .. } = image.connection;
        let ratio = self.observer.ratio(launch);
        // Solid angle that the camera measures over that far away, which a disc in place of the point would have.
        let magnification = self.observer.solid_angle_factor(launch) / spread;
        let factor = magnification * f64::from(scene.radiance_factor(ratio.recip()));
        let light = &scene.light_sampler.lights[light];
        let mut channels = vec![0.0; self.job.film.channels().len()];
        // Infinite for a point exactly behind a hole, which is on nobody's sky.
        if factor.is_finite() {
            for lambda in &self.wavelengths {
                let irradiance = light.point_irradiance(image.point, lambda.at(ratio.recip() as f32));
                self.job.film.add(irradiance, lambda, &mut channels);
            }
        }
        let scale = factor / self.wavelengths.len() as f64;
        let lit = factor.is_finite() && channels.iter().all(|c| (c * scale).is_finite());
        let places = image.places.clone().into_iter().filter(move |_| lit);
        places.map(move |(raster, solid_angle)| Splat {
            raster,
            channels: channels.iter().map(|c| c * (scale / solid_angle)).collect(),
        })
    }

    /// Puts light into the pixels around it, by the filter. All pixels together, those outside of the picture included, have all of it.
    fn splat(&self, Splat { raster, channels }: &Splat, picture: &mut PointPicture) {
        let filter = self.job.filter;
        let radius = filter.radius();
        let [first, last] = [(*raster - radius - 0.5).ceil(), (*raster + radius - 0.5).floor()];
        let (columns, rows) = (first.x as i64..=last.x as i64, first.y as i64..=last.y as i64);
        let pixels = || rows.clone().flat_map(|y| columns.clone().map(move |x| [x, y]));
        let value = |[x, y]: [i64; 2]| filter.value(*raster - DVec2::new(x as f64, y as f64) - 0.5);
        let sum: f64 = pixels().map(value).sum();
        let [x0, x1, y0, y1] = self.job.film.crop().map(i64::from);
        let mut add = |[x, y]: [i64; 2], weight: f64| {
            if (x0..x1).contains(&x) && (y0..y1).contains(&y) && weight != 0.0 {
                picture.add([x as u32, y as u32], weight, channels);
            }
        };
        // A filter so narrow that it reaches the middle of no pixel, or whose lobes cancel: the pixel in which the point lies.
        if sum.abs() <= 1e-3 * filter.value(DVec2::ZERO).abs() {
            add([raster.x.floor() as i64, raster.y.floor() as i64], 1.0);
            return;
        }
        pixels().for_each(|pixel| add(pixel, value(pixel) / sum));
    }
}
