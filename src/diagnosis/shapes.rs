//! Shapes that nobody can see.

use crate::lang::BuiltScene;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::geometry::Geometry;
use bhs_core::spacetime::{Class, Place, Side};
use bhs_engine::world::World;
use glam::{DVec3, Vec2};
use std::collections::BTreeMap;

/// Code of shapes within horizons.
pub const WITHIN: &str = "shape-inside-horizon";

/// Warns of shapes that lie wholly within a horizon.
pub fn within_horizons(built: &BuiltScene, found: &mut Vec<Diagnostic>) {
    let scene = &built.scene;
    if !scene.world.bends() {
        return;
    }
    // Of each directive, whether all that it makes lies within.
    let mut within: BTreeMap<u32, bool> = BTreeMap::new();
    for (number, shape) in scene.shapes.iter().enumerate() {
        let all = within.entry(shape.index).or_insert(true);
        *all = *all && is_within_horizon(&scene.world, number as u32);
    }
    for index in within.into_iter().filter(|(_, all)| *all).map(|(index, _)| index) {
        let Some((_, at)) = built.statements.shape(index) else { continue };
        let said = Diagnostic::warning(WITHIN, "this shape lies wholly inside the horizon: no light comes back from there")
            .at(at.span, "it will not be seen");
        let said = match &built.statements.spacetime {
            Some(spacetime) => said.and(spacetime.at.span, horizon_words(&scene.world)),
            None => said,
        };
        found.push(said.help("move it out, or make the hole smaller"));
    }
}

/// How large a round hole's horizon is.
fn horizon_words(world: &World) -> String {
    match world.spacetime().class() {
        Class::Spherical(hole) => format!("radius {}", hole.horizon()),
        _ => "of this hole".to_owned(),
    }
}

/// Whether a geometry lies wholly within a horizon, from where no light comes.
pub fn is_within_horizon(world: &World, number: u32) -> bool {
    if !world.bends() || world.side_of(number) != Side::Near {
        return false;
    }
    let (spacetime, holes) = (world.spacetime(), world.spacetime().captures());
    // Balls are convex: a triangle lies within if its corners do.
    holes.iter().any(|hole| {
        let within = |x: DVec3| (x - hole.center).length() < hole.radius && spacetime.normal(Place::near(x)).is_none();
        !points(&world.geometries[number as usize]).any(|x| !within(x))
            && points(&world.geometries[number as usize]).next().is_some()
    })
}

/// Points that stand for a surface: the corners of its triangles, or points all over it.
fn points(geometry: &Geometry) -> Box<dyn Iterator<Item = DVec3> + '_> {
    match geometry {
        Geometry::Analytic(surface) => {
            let at = |i: u32| Vec2::new((i % 16) as f32, (i / 16) as f32) / 15.0 * 0.999_999;
            Box::new((0..256).map(move |i| surface.sample(at(i)).point))
        }
        mesh => Box::new((0..mesh.triangle_count() as u32).filter_map(|t| mesh.corners(t)).flatten()),
    }
}
