//! What each feature costs a scene that uses it, beside the same scene without it.

use crate::{build, medians, show, text};
use anyhow::Result;
use bhs::bench::clock::processor_seconds;
use bhs::bench::table::Table;
use bhs::lang::Overrides;
use bhs::render::render_quietly;

const ROUNDS: usize = 5;

/// A feature: two scenes that differ in it.
struct Feature {
    name: String,
    without: (String, Overrides),
    with: (String, Overrides),
}

pub fn measure() -> Result<()> {
    let small = Overrides { resolution: Some([96, 72]), spp: Some(16), ..Default::default() };
    let feature = |name: &str, without: &str, with: &str| Feature {
        name: name.to_owned(),
        without: (without.to_owned(), small.clone()),
        with: (with.to_owned(), small.clone()),
    };
    let room = text("cornell_hole")?;
    let hole = |text: &str| text.lines().find(|l| l.starts_with("BlackHole")).map(str::to_owned).unwrap_or_default();
    let line = hole(&room);
    let flat = room.replace(&line, "");
    let replaced = |from: &str, to: &str| {
        assert!(room.contains(from), "the scene has no {from}");
        room.replace(from, to)
    };
    let sphere = "AttributeBegin\nTranslate 0.4 0.3 0.3\nShape \"sphere\" \"float radius\" 0.3\nAttributeEnd\n";
    let glass = sphere.replace("Shape", "Material \"dielectric\" \"float eta\" 1.45\nShape");
    let path = "LightTransport \"path\"";
    let mut features = vec![
        feature("black hole of no size (`rs 0`)", &flat, &replaced("\"float rs\" 0.07", "\"float rs\" 0")),
        feature("black hole", &flat, &room),
        feature("redshift", &room, &replaced("\"bool redshift\" false", "\"bool redshift\" true")),
        feature("light sampling, flat", &flat.replace(path, &format!("{path} \"bool lightsampling\" false")), &flat),
        feature("light sampling, around the hole", &replaced(path, &format!("{path} \"bool lightsampling\" false")), &room),
        feature("windings 1", &room, &format!("Integrator \"adaptive\" \"integer windings\" 1\n{room}")),
        feature("a matt sphere, flat", &flat, &format!("{flat}{sphere}")),
        feature("a glass sphere in place of the matt one", &format!("{flat}{sphere}"), &format!("{flat}{glass}")),
        feature("a dim sky, flat", &flat, &format!("{flat}LightSource \"infinite\" \"float L\" 0.01\n")),
        feature("a point light, flat", &flat, &format!("{flat}LightSource \"point\" \"point3 from\" [0 1 0]\n")),
        feature("sampler `sobol` in place of `independent`, flat", &flat.replace("\"sobol\"", "\"independent\""), &flat),
    ];
    for layer in bhs_layers::ALL {
        let with = Overrides { layers: vec![layer.name.to_owned()], ..small.clone() };
        features.push(Feature {
            name: format!("layer `{}`", layer.name),
            without: (room.clone(), small.clone()),
            with: (room.clone(), with),
        });
    }
    let mut ready = Vec::new();
    for feature in &features {
        for (text, overrides) in [&feature.without, &feature.with] {
            ready.push(build(text, overrides)?);
        }
    }
    let seconds = medians(ROUNDS, &mut ready, |built| {
        let start = processor_seconds();
        std::hint::black_box(render_quietly(built));
        Ok(processor_seconds() - start)
    })?;
    let mut table = Table::new(&["feature", "seconds without", "with", "with / without"]);
    for (feature, seconds) in features.iter().zip(seconds.chunks_exact(2)) {
        let [without, with] = [seconds[0], seconds[1]];
        table.row(&[feature.name.clone(), format!("{without:.3}"), format!("{with:.3}"), format!("{:.3}", with / without)]);
    }
    show("What features cost: the room of `cornell_hole`, 96 x 72 pixels, 16 samples, processor time", &table);
    Ok(())
}
