//! Light sampling around a hole that spins.
//!
//! [`Connection::phi`] is the parameter of the ray at its end (`orbit`): Mino's time, scaled to about the angle that it sweeps.

use crate::kerr::connect::bundle::Spin;
use crate::kerr::connect::newton::Found;
use crate::kerr::connect::search::{Guess, Target};
use crate::kerr::connect::{find_all, image_of};
use crate::kerr::course::KerrSetup;
use crate::kerr::orbit::{Hole, Light};
use crate::tolerance::Tolerance;
use crate::tracing::extent::Extent;
use crate::tracing::shadow::{ERROR, Sought, close};
use crate::tracing::surfaces::Surfaces;
use bhs_core::lanes::{LANES, Lanes};
use bhs_core::ray::Cost;
use bhs_core::spacetime::{Class, Kerr, Place, Side, Spacetime};
use bhs_engine::connections::{Connection, ConnectionPair, Connections, End, ShadowRay};
use bhs_engine::world::World;
use glam::DVec3;

/// Rays between two points around a hole that spins: the direct one and the one round the other side.
#[derive(Clone, Copy, Debug)]
pub struct KerrConnections {
    /// How far a ray may stray from the chords of its shadow ray.
    pub tolerance: Tolerance,
}

/// A hole in whose units rays are looked for: lengths are multiples of its mass, vectors have its axis as z.
struct Around {
    kerr: Kerr,
    hole: Hole,
    mass: f64,
    spin: Spin<f64>,
}

impl Around {
    fn new(world: &World) -> Option<Self> {
        let Class::Kerr(kerr) = world.spacetime().class() else { return None };
        // From the surface to the light: backward in time.
        let hole = Hole::new(&kerr, true);
        let round = kerr.round();
        let mass = 0.5 * round.rs;
        let spin = Spin { a: hole.a / mass, charge_squared: round.charge_squared / (mass * mass) };
        Some(Self { kerr, hole, mass, spin })
    }

    /// The chart vector `v` along the axes of the hole.
    fn components(&self, v: DVec3) -> DVec3 {
        self.hole.components::<f64>(v.into()).into()
    }

    fn chart(&self, v: DVec3) -> DVec3 {
        self.hole.chart::<f64>(v.into()).into()
    }

    /// `None` where nothing can stand.
    fn place(&self, place: Place) -> Option<DVec3> {
        self.kerr.at(place)?;
        Some(self.components(place.x - self.kerr.round().center) / self.mass)
    }

    fn point(&self, place: Place) -> Option<Target> {
        self.place(place).map(Target::Point)
    }

    fn sky(&self, (direction, side): (DVec3, Side)) -> Option<Target> {
        (side == Side::Near).then(|| Target::Sky(self.components(direction)))
    }

    /// The spread of the ray `found` in the chart.
    fn spread(&self, found: &Found, target: Target) -> f64 {
        match target {
            Target::Point(_) => found.end.spread(target) * self.mass * self.mass,
            Target::Sky(_) => found.end.spread(target),
        }
    }

    fn connection(&self, found: &Found, target: Target) -> Connection {
        let arrival = match target {
            Target::Point(_) => found.end.tangent().normalize(),
            Target::Sky(sky) => sky,
        };
        Connection {
            launch: self.chart(found.guess.launch),
            arrival: self.chart(arrival),
            spread: self.spread(found, target),
            phi: found.guess.tau * found.end.scale,
        }
    }

    /// About the same, of a ray around the hole without spin.
    fn outline(&self, c: &Connection, target: Target) -> Connection {
        let area = match target {
            Target::Point(_) => self.mass * self.mass,
            Target::Sky(_) => 1.0,
        };
        Connection { launch: self.chart(c.launch), arrival: self.chart(c.arrival), spread: c.spread * area, phi: c.phi }
    }

    /// Both rays of each of `ends`, or those of them that are chosen, written to the places of `found`.
    fn connect(
        &self,
        ends: impl Iterator<Item = (Option<DVec3>, Option<Target>)>,
        choose: &mut dyn FnMut(usize, &ConnectionPair) -> [bool; 2],
        found: &mut [ConnectionPair],
    ) {
        found.fill([None; 2]);
        let known = ends.enumerate().filter_map(|(k, (x, target))| Some((k, (x?, target?))));
        let (places, pairs): (Vec<usize>, Vec<(DVec3, Target)>) = known.unzip();
        let choose = |i: usize, outlines: &ConnectionPair| {
            let outline = |c: Option<Connection>| c.map(|c| self.outline(&c, pairs[i].1));
            choose(places[i], &outlines.map(outline))
        };
        for (k, (rays, (_, target))) in places.iter().zip(find_all(self.spin, &pairs, choose).into_iter().zip(&pairs)) {
            found[*k] = rays.map(|ray| ray.map(|ray| self.connection(&ray, *target)));
        }
    }

    /// The spread of the ray from `x` in the chart direction `launch` to `target` whose parameter there is `s`.
    fn spread_of(&self, x: Option<DVec3>, launch: DVec3, target: Option<Target>, s: f64) -> Option<f64> {
        let (x, target, launch) = (x?, target?, self.components(launch));
        let Light { orbit, .. } =
            self.hole.light::<f64>((self.chart(x) * self.mass + self.kerr.round().center).into(), self.chart(launch).into());
        let traced = Guess { launch, tau: s * self.mass / orbit.scale };
        image_of(self.spin, x, target, traced).map(|found| self.spread(&found, target))
    }
}

impl Connections for KerrConnections {
    fn turns(&self) -> u32 {
        1
    }

    fn connect(&self, world: &World, x: Place, y: Place, turn: u32) -> ConnectionPair {
        let mut found = [[None; 2]];
        if turn == 0 {
            self.connect_all(world, &[[x, y]], &mut [&mut found]);
        }
        found[0]
    }

    fn connect_all(&self, world: &World, pairs: &[[Place; 2]], found: &mut [&mut [ConnectionPair]]) {
        let (Some(around), Some(found)) = (Around::new(world), found.first_mut()) else { return };
        around.connect(pairs.iter().map(|[x, y]| (around.place(*x), around.point(*y))), &mut |_, _| [true; 2], found);
    }

    fn spread(&self, world: &World, x: Place, launch: DVec3, y: Place, phi: f64) -> Option<f64> {
        let around = Around::new(world)?;
        around.spread_of(around.place(x), launch, around.point(y), phi)
    }

    fn connect_sky(&self, world: &World, x: Place, sky: (DVec3, Side), turn: u32) -> ConnectionPair {
        let mut found = [[None; 2]];
        if turn == 0 {
            self.connect_sky_all(world, &[(x, sky)], &mut [&mut found]);
        }
        found[0]
    }

    fn connect_sky_all(&self, world: &World, ends: &[(Place, (DVec3, Side))], found: &mut [&mut [ConnectionPair]]) {
        let (Some(around), Some(found)) = (Around::new(world), found.first_mut()) else { return };
        around.connect(ends.iter().map(|(x, sky)| (around.place(*x), around.sky(*sky))), &mut |_, _| [true; 2], found);
    }

    fn spread_sky(&self, world: &World, x: Place, launch: DVec3, sky: (DVec3, Side), phi: f64) -> Option<f64> {
        let around = Around::new(world)?;
        around.spread_of(around.place(x), launch, around.sky(sky), phi)
    }

    fn is_dear(&self) -> bool {
        true
    }

    fn connect_chosen(
        &self,
        world: &World,
        ends: &[(Place, End)],
        choose: &mut dyn FnMut(usize, &ConnectionPair) -> [bool; 2],
        found: &mut [ConnectionPair],
    ) {
        let Some(around) = Around::new(world) else { return };
        let target = |end: End| match end {
            End::Point(y) => around.point(y),
            End::Sky(sky) => around.sky(sky),
        };
        around.connect(ends.iter().map(|(x, end)| (around.place(*x), target(*end))), choose, found);
    }

    fn occluded_all(&self, world: &World, shadow_rays: &[ShadowRay], occluded: &mut [bool]) -> Cost {
        let Class::Kerr(kerr) = world.spacetime().class() else {
            occluded.fill(true);
            return Cost::default();
        };
        let extent = Extent::of(world);
        let setting = KerrSetup::new(world, &kerr, &extent);
        let surfaces = Surfaces::of(world);
        let mut cost = Cost::default();
        for (rays, occluded) in shadow_rays.chunks(LANES).zip(occluded.chunks_mut(LANES)) {
            let end = |ray: &ShadowRay| (limit(&setting.hole, ray), extent.distance(self.tolerance, ray.start.footprint));
            let sought = Sought::<Lanes>::new(rays, end);
            let mut course = setting.by_series(sought.x, sought.d, Lanes::splat(ERROR));
            cost += sought.occluded((world, &surfaces), rays, &mut course, occluded);
        }
        cost
    }
}

/// The parameter after which a shadow ray ends, just before its end.
fn limit(hole: &Hole, ray: &ShadowRay) -> f64 {
    let Connection { launch, arrival, phi, .. } = ray.connection;
    let Light { orbit, .. } = hole.light::<f64>(ray.from.into(), launch.into());
    let Some(here) = hole.kerr.at(ray.to) else { return phi };
    // dx/dtau = S d / (N |d|), and the parameter is tau times the scale of the orbit.
    let speed = hole.kerr.oblate::<f64>(ray.to.x.into()).sigma / (here.lapse * here.root.apply(arrival).length());
    (phi - close(ray) * orbit.scale / speed).max(0.0)
}
