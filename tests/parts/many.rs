//! Many parts: of the scenes that README shows, and what they take of memory.

use super::{Random, open, shown, split, write};
use crate::common;
use bhs::lang::{self, Overrides, SourceMap};
use bhs::parts::{Cover, join, joined};
use bhs::registry::Registry;
use std::path::PathBuf;

#[test]
fn the_scenes_split_into_up_to_64_parts() {
    let mut random = Random(64);
    for name in ["cornell_hole", "gold_dragon", "kerr_disc", "flyby"] {
        let overrides = Overrides {
            resolution: Some([24, 18]),
            spp: Some(8),
            layers: vec!["variance".into(), "redshift".into()],
            ..Overrides::default()
        };
        let path = common::root().join(format!("scenes/{name}.bhs"));
        let mut sources = SourceMap::new();
        let built = lang::load(path, &Registry::builtin(), &overrides, &mut sources)
            .unwrap_or_else(|found| panic!("{}", bhs::report::render(&found, &sources, false)));
        let expected = common::render(&built);
        let whole = Cover::whole(&*built.film, 8);
        for cuts in [0, 5, 63] {
            let covers = split(whole, cuts, &mut random);
            let folder = tempfile::tempdir().expect("a temporary folder");
            let sorted = join::sort(&write(&built, &covers, folder.path()), open);
            assert!(sorted.refused.is_empty() && sorted.pictures[0].missing.is_empty(), "{name}: {:?}", sorted.refused);
            let (joined, _) = joined::join(&sorted.pictures[0], open).expect("they can be joined");
            assert!(shown(&joined).same_channels(&shown(&expected)), "{name} {covers:?}");
        }
    }
}

#[test]
fn parts_in_number_take_the_memory_of_one() {
    let text = r#"Film "rgb" "integer xresolution" 300 "integer yresolution" 200
        Sampler "sobol" "integer pixelsamples" 30
        WorldBegin
        LightSource "infinite""#;
    let built = common::build(text);
    let folder = tempfile::tempdir().expect("a temporary folder");
    let covers: Vec<Cover> = (0..30).map(|s| Cover { samples: [s, s + 1], ..Cover::whole(&*built.film, 30) }).collect();
    let paths = write(&built, &covers, folder.path());
    let taken = |paths: &[PathBuf]| {
        let measured = allocation_counter::measure(|| {
            let sorted = join::sort(paths, open);
            joined::join(&sorted.pictures[0], open).expect("they can be joined");
        });
        measured.bytes_max
    };
    let (few, many) = (taken(&paths[..2]), taken(&paths));
    let [sums, tiles] = bhs::film::Framebuffer::bytes(&*built.film, &built.layers);
    eprintln!("2 parts take {few} bytes, 30 take {many}; the frame has {}", sums + tiles);
    assert!(many < few + 100_000, "{few} {many}");
    assert!(many < 2 * (sums + tiles), "{many} {sums}");
}
