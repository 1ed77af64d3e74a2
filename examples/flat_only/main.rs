//! A renderer of flat space: bhs with the integrator `straight` and no other. `cargo run --release --example scaling flat` compares it with
//! the whole program, to see what curved light costs a scene that has none.

#[path = "../scaling/timer.rs"]
mod timer;

use bhs::registry::Registry;
use bhs_core::Plugin;
use bhs_engine::integrator::IntegratorBuilder;
use bhs_integrators::Straight;

/// All plugins but the integrators of curved light, which nothing here names, so that they are not part of the program.
fn registry() -> Registry {
    const STRAIGHT: Plugin<dyn IntegratorBuilder> =
        Plugin { name: "straight", summary: "straight lines", build: |_| Some(Box::new(Straight)) };
    let mut registry = Registry::empty().with(STRAIGHT);
    macro_rules! all {
        ($($list:expr),*) => { $(for plugin in $list { registry = registry.with(*plugin); })* };
    }
    all!(bhs_transports::ALL, bhs_intersectors::ALL, bhs_cameras::ALL, bhs_films::ALL, bhs_filters::ALL, bhs_samplers::ALL);
    all!(bhs_materials::ALL, bhs_lights::ALL, bhs_lights::AREA, bhs_motions::ALL, bhs_shapes::ALL, bhs_layers::ALL);
    registry
}

fn main() -> anyhow::Result<()> {
    timer::answer(&registry())
}
