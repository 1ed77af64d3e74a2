//! The cost of a ray against the number of triangles: the dragon in all its resolutions, and cut finer still.

use crate::{build, show, text};
use anyhow::{Context, Result, anyhow};
use bhs::bench::clock::median;
use bhs::bench::integrators::nanoseconds;
use bhs::bench::rays::{arrivals, bounce_rays, camera_rays};
use bhs::bench::table::Table;
use bhs::lang::{BuiltScene, Overrides};
use bhs_core::geometry::{Geometry, TriangleMesh};
use bhs_core::intersector::IntersectorBuilder;
use bhs_engine::integrator::Integrator;
use bhs_engine::world::World;
use bhs_integrators::Tolerance;
use bhs_integrators::{Adaptive, Straight};
use std::sync::Arc;

const MESHES: [&str; 4] = ["dragon_vrip_res4", "dragon_vrip_res3", "dragon_vrip_res2", "dragon_vrip"];
const RAYS: usize = 20_000;
const ROUNDS: usize = 7;

pub fn measure() -> Result<()> {
    let scene = text("gold_dragon")?;
    let mut scenes = Vec::new();
    for mesh in MESHES {
        scenes.push(build(&scene.replace("/dragon_vrip.ply", &format!("/{mesh}.ply")), &Overrides::default())?);
    }
    let mut finer = build(&scene, &Overrides::default())?;
    finer.scene.world = subdivided(finer.scene.world)?;
    scenes.push(finer);

    let adaptive = Adaptive::new(Tolerance::DEFAULT, 100_000);
    let columns = [
        "triangles",
        "straight ns",
        "over the row before",
        "adaptive ns",
        "over the row before",
        "queries",
        "adaptive / straight",
    ];
    for kind in ["camera rays", "bounce rays"] {
        let rays_of = |built: &BuiltScene| {
            let camera = camera_rays(built, RAYS);
            if kind == "camera rays" { camera } else { bounce_rays(built, &camera) }
        };
        let rays: Vec<_> = scenes.iter().map(rays_of).collect();
        let mut times = vec![[Vec::new(), Vec::new()]; scenes.len()];
        for _ in 0..ROUNDS {
            for ((built, rays), times) in scenes.iter().zip(&rays).zip(&mut times) {
                for (integrator, times) in [&Straight as &dyn Integrator, &adaptive].into_iter().zip(times) {
                    times.push(nanoseconds(&built.scene.world, integrator, rays));
                }
            }
        }
        let mut table = Table::new(&columns);
        let mut before: Option<[f64; 2]> = None;
        for ((built, rays), times) in scenes.iter().zip(&rays).zip(&times) {
            let now = [median(&times[0]), median(&times[1])];
            let (_, counters) = arrivals(&built.scene.world, &adaptive, rays);
            let over = |i: usize| before.map_or(String::new(), |b| format!("{:.2}", now[i] / b[i]));
            table.row(&[
                triangles(&built.scene.world).to_string(),
                format!("{:.0}", now[0]),
                over(0),
                format!("{:.0}", now[1]),
                over(1),
                format!("{:.2}", counters.queries as f64 / rays.len() as f64),
                format!("{:.2}", now[1] / now[0]),
            ]);
            before = Some(now);
        }
        show(&format!("{kind} of `gold_dragon`; each row has four times the triangles of the one before"), &table);
    }
    Ok(())
}

fn triangles(world: &World) -> usize {
    let of = |g: &Geometry| if let Geometry::Mesh(mesh) = g { mesh.triangles.len() } else { 0 };
    world.geometries.iter().map(of).sum()
}

/// The same surfaces, with each triangle of the largest mesh cut into four.
fn subdivided(mut world: World) -> Result<World> {
    let size = |g: &Geometry| if let Geometry::Mesh(mesh) = g { mesh.triangles.len() } else { 0 };
    let mut geometries = std::mem::take(&mut world.geometries);
    let largest = geometries.iter_mut().max_by_key(|g| size(g)).context("no geometry")?;
    if let Geometry::Mesh(mesh) = largest {
        *largest = Geometry::Mesh(Arc::new(cut(mesh)));
    }
    let intersector = bhs_intersectors::embree::Embree.build(&geometries).map_err(|why| anyhow!(why))?;
    Ok(world.with_surfaces(geometries, intersector))
}

/// Each triangle cut into four at the middles of its sides. Neighbours do not share the middles.
fn cut(mesh: &TriangleMesh) -> TriangleMesh {
    let mut finer = TriangleMesh { positions: mesh.positions.clone(), ..Default::default() };
    for &[a, b, c] in &mesh.triangles {
        let middle = |finer: &mut TriangleMesh, i: u32, j: u32| {
            let [p, q] = [i, j].map(|v| mesh.positions[v as usize]);
            finer.positions.push(std::array::from_fn(|k| 0.5 * (p[k] + q[k])));
            finer.positions.len() as u32 - 1
        };
        let (ab, bc, ca) = (middle(&mut finer, a, b), middle(&mut finer, b, c), middle(&mut finer, c, a));
        finer.triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    finer
}
