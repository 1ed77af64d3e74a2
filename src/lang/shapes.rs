//! The shapes of a scene, several at a time on all cores: files are read and meshes made side by side, and what comes of it is put together in the
//! order of the scene, so that nothing depends on who was first.

use crate::lang::create::{create, create_with};
use crate::lang::description::{Entity, SceneDescription, ShapeEntity};
use crate::lang::errors::ErrorCount;
use crate::lang::instances;
use crate::lang::params::string_of;
use crate::lang::parse::MAX_ERRORS;
use crate::lang::parts::{ObjectPart, Part};
use crate::lang::pictured::Pictured;
use crate::lang::source::{Side as SideReader, SourceMap};
use crate::lang::strands::Strands;
use crate::registry::{Registry, bare_context};
use bhs_core::diagnostics::Diagnostic;
use bhs_core::geometry::Shape;
use bhs_core::motion::Motion;
use bhs_core::params::{Context, Params};
use rayon::prelude::*;

/// Shapes that are made side by side.
const GROUP: usize = 64;
/// Bytes of the files that a group reads; larger ones are read one by one, lest several of them take memory at once.
const GROUP_BYTES: u64 = 1 << 26;

/// A shape that has been made, with how it moves and what was found.
struct Made {
    shape: Option<Box<dyn Shape>>,
    motion: Option<Box<dyn Motion>>,
    found: Vec<Diagnostic>,
}

/// What shapes are made of besides the scene.
#[derive(Clone, Copy)]
struct Maker<'m> {
    registry: &'m Registry,
    sources: &'m SourceMap,
    resolution: [u32; 2],
    lambda_range: [f32; 2],
    seed: u64,
}

impl Maker<'_> {
    fn make(&self, shape: &ShapeEntity, context: Context) -> Made {
        let context = Context { reverse_orientation: shape.reverse_orientation, ..context };
        let mut found = Vec::new();
        let read = |p: &Params| self.registry.motion(p);
        let (made, motion) = create_with::<dyn Shape, _>(&shape.entity, self.registry, context, &mut found, read);
        Made { shape: made, motion, found }
    }

    /// A group of shapes, side by side. Those that ask for more than a file of their own are made when it is their turn.
    fn group(&self, shapes: &[ShapeEntity], in_turn: Context) -> Vec<Made> {
        if let [shape] = shapes {
            return vec![self.make(shape, in_turn)];
        }
        let aside = |shape: &ShapeEntity| {
            let files = SideReader::new(self.sources);
            let (resolution, lambda_range, seed) = (self.resolution, self.lambda_range, self.seed);
            let context = Context { resolution, lambda_range, seed, ..bare_context(&files, self.registry.spectra()) };
            let made = self.make(shape, context);
            files.finish().map(|read| (made, read))
        };
        let all: Vec<_> = shapes.par_iter().map(aside).collect();
        let in_order = all.into_iter().zip(shapes).map(|(made, shape)| match made {
            Some((made, read)) => {
                read.iter().for_each(|content| self.sources.hash_content(content));
                made
            }
            None => self.make(shape, in_turn),
        });
        in_order.collect()
    }

    /// How many of the next shapes are a group.
    fn next_group(&self, shapes: &[ShapeEntity]) -> usize {
        let mut bytes = 0u64;
        let size = |shape: &ShapeEntity| {
            let name = string_of(&shape.entity.params, "filename");
            name.map_or(0, |name| self.sources.size(&name.value, name.span))
        };
        let fits = |shape: &&ShapeEntity| {
            bytes = bytes.saturating_add(size(shape));
            bytes <= GROUP_BYTES
        };
        shapes.iter().take(GROUP).take_while(fits).count().max(1)
    }
}

/// What stands in the scene, and the objects with their instances.
pub(super) fn build_shapes(
    description: &mut SceneDescription,
    (registry, sources): (&Registry, &SourceMap),
    context: Context,
    (pictured, found): (&mut Pictured, &mut Vec<Diagnostic>),
) -> (Vec<Part>, Vec<Box<dyn Motion>>, Vec<ObjectPart>) {
    let mut shapes = std::mem::take(&mut description.shapes);
    let mut objects = instances::places(description.objects.len(), &description.instances);
    let (mut parts, mut motions) = (Vec::with_capacity(shapes.len()), Vec::new());
    let (mut errors, mut strands) = (ErrorCount::default(), Strands::default());
    let Context { resolution, lambda_range, seed, .. } = context;
    let maker = Maker { registry, sources, resolution, lambda_range, seed };
    let (all, mut index) = (shapes.len(), 0u32);
    // Taken from the end: each shape's parameters, which may be a large mesh, are let go before the next group is made.
    shapes.reverse();
    'groups: while !shapes.is_empty() {
        let mut ahead: Vec<ShapeEntity> = shapes.drain(shapes.len().saturating_sub(GROUP)..).rev().collect();
        let later = ahead.split_off(maker.next_group(&ahead));
        shapes.extend(later.into_iter().rev());
        let made = maker.group(&ahead, context);
        for (shape, made) in ahead.into_iter().zip(made) {
            if errors.count(found) >= MAX_ERRORS {
                // What follows is not looked at: the scene is not rendered.
                break 'groups;
            }
            let number = index;
            index += 1;
            found.extend(made.found);
            let (Some(shape_made), motion) = (made.shape, made.motion) else { continue };
            let surfaces = shape_made.into_geometry();
            pictured.look_at(&shape, &surfaces);
            if let Some(object) = shape.object.and_then(|o| objects.get_mut(o)) {
                if motion.is_some() {
                    found.push(
                        Diagnostic::error("moving-instance", "shapes of objects do not move")
                            .at(shape.entity.name.span, "it states a `motion`")
                            .help("put the shape into the scene by itself"),
                    );
                }
                let context = Context { reverse_orientation: shape.reverse_orientation, ..context };
                let make = |entity: &Entity, found: &mut Vec<Diagnostic>| create::<dyn Shape>(entity, registry, context, found);
                parts.extend(instances::add_shape(object, &shape, number, surfaces, make, found));
                continue;
            }
            let surfaces = strands.add(&shape, motion.is_some(), surfaces, &mut parts);
            let motion = motion.map(|motion| {
                motions.push(motion);
                motions.len() - 1
            });
            let (span, side) = (shape.entity.name.span, shape.entity.side);
            let (material, area_light) = (shape.material, shape.area_light);
            parts.extend(surfaces.into_iter().map(|geometry| Part {
                geometry,
                side,
                span,
                index: number,
                material,
                area_light,
                motion,
            }));
        }
        sources.loading().shapes(all - shapes.len(), all);
    }
    // What files were taken apart for shapes is large, and has been used.
    sources.forget_shared();
    (parts, motions, objects)
}
