//! Layers: what a picture may record besides colour. One file, one plugin; `orbit` holds what the layers about orbits share, `reflectance` the
//! colours of materials.
//!
//! A film's directive names them: `"string layers" ["depth" "normal"]`.

mod albedo;
mod angularmomentum;
mod carter;
mod closestapproach;
mod depth;
mod impactparameter;
mod normal;
pub mod orbit;
mod outcome;
mod position;
mod queries;
mod redshift;
mod reflectance;
mod samples;
mod shadingnormal;
mod side;
mod sweptangle;
mod traveltime;
mod variance;
mod winding;

pub use redshift::redshift;

use bhs_core::Plugin;
use bhs_engine::layer::Layer;

/// All layers, in the order of the language reference.
pub const ALL: &[Plugin<dyn Layer>] = &[
    impactparameter::PLUGIN,
    sweptangle::PLUGIN,
    closestapproach::PLUGIN,
    winding::PLUGIN,
    angularmomentum::PLUGIN,
    carter::PLUGIN,
    traveltime::PLUGIN,
    redshift::PLUGIN,
    queries::PLUGIN,
    outcome::PLUGIN,
    albedo::PLUGIN,
    position::PLUGIN,
    normal::PLUGIN,
    shadingnormal::PLUGIN,
    depth::PLUGIN,
    side::PLUGIN,
    variance::PLUGIN,
    samples::PLUGIN,
];

#[cfg(test)]
mod tests {
    use super::ALL;
    use bhs_core::diagnostics::{Span, Spanned};
    use bhs_core::params::Params;
    use bhs_engine::layer::{Statistic, find};
    use std::collections::BTreeSet;

    bhs_core::every_file_is_listed!([ALL], helpers: ["orbit", "reflectance"]);

    #[test]
    fn names_and_channels_are_unique_and_found_again() {
        let mut channels = BTreeSet::from(["R", "G", "B"]);
        for plugin in ALL {
            assert_eq!(find(plugin.name, ALL).map(|found| found.name), Ok(plugin.name));
            let owner = Spanned::new(plugin.name.to_owned(), Span::default());
            let layer = (plugin.build)(&Params::new(owner, &[], crate::reflectance::tests::context())).expect(plugin.name);
            let format = layer.format();
            assert!(matches!(format.channels.len(), 1 | 3));
            assert!(format.channels.iter().all(|c| channels.insert(c)), "{}", plugin.name);
            assert_eq!(format.statistic == Statistic::ColorVariance, plugin.name == "variance");
        }
    }

    #[test]
    fn a_wrong_name_gets_a_suggestion_and_the_list() {
        let near = find("redshft", ALL).err().expect("no such layer");
        assert!(near.contains("did you mean `redshift`") && near.contains("sweptangle"), "{near}");
        let far = find("cheese", ALL).err().expect("no such layer");
        assert!(!far.contains("did you mean") && far.contains("albedo"), "{far}");
    }
}
