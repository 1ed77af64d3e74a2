//! The pages of `docs/` that have scenes and commands of their own: the scenes are without fault, the commands can be typed, and the
//! numbers of the page about numerics are those that the program finds.

use crate::common;
use crate::common::examples::{build_all, examples};
use bhs::cli::Cli;
use bhs::lang::variables::Variables;
use bhs::lang::{self, Overrides, SourceMap};
use bhs::registry::Registry;
use bhs::trace::{Answers, trace};
use clap::Parser;

const PAGES: [&str; 2] = ["docs/numerics.md", "docs/pictures.md"];
const NUMERICS: &str = PAGES[0];

/// The lines of a page that call the program, without what feeds its standard input.
fn commands(text: &str) -> Vec<&str> {
    let typed = text.lines().filter_map(|line| line.strip_prefix("    "));
    let called = typed.map(|line| line.rsplit_once("| ").map_or(line, |(_, last)| last));
    called.filter(|line| line.starts_with("bhs ")).map(|line| line.split("  #").next().unwrap_or(line)).collect()
}

#[test]
fn scenes_are_without_fault_and_commands_can_be_typed() {
    for path in PAGES {
        let text = common::read(path);
        assert!(!examples(&text).is_empty(), "{path}");
        build_all(path, &text);
        let commands = commands(&text);
        assert!(!commands.is_empty(), "{path}");
        for line in commands {
            Cli::try_parse_from(line.split_whitespace()).unwrap_or_else(|fault| panic!("{path}: {line}\n{fault}"));
        }
    }
}

/// What `bhs trace` says of the page's ray.
fn swept(scene: &str, overrides: &Overrides) -> (f64, u64) {
    let built = lang::load_text(NUMERICS, scene, &Registry::builtin(), overrides, &mut SourceMap::new()).expect("a scene");
    let mut out = Vec::new();
    trace(&Answers::new(&built.scene), "0,0,-20,0.3,0,1\n".as_bytes(), &mut out).expect("a ray");
    let answer: serde_json::Value = serde_json::from_slice(&out).expect("JSON");
    (answer["phi"].as_f64().expect("an angle"), answer["steps"].as_u64().expect("a count"))
}

#[test]
fn the_table_of_steps_is_what_the_program_finds() {
    let text = common::read(NUMERICS);
    let scene = examples(&text)[0];
    let rows =
        text.lines().filter_map(|line| line.strip_prefix("| ")).map(|line| line.split('|').map(str::trim).collect::<Vec<_>>());
    let mut errors = Vec::new();
    let truth = swept(scene, &Overrides { integrator: Some("exact".into()), ..Overrides::default() }).0;
    for row in rows.filter(|row| row.len() == 6 && row[1].starts_with("4.844")) {
        let overrides = match row[0].parse() {
            Ok(step) => Overrides {
                variables: Variables { definitions: vec![("step".into(), step)], ..Variables::default() },
                ..Overrides::default()
            },
            Err(_) => Overrides { integrator: Some("exact".into()), ..Overrides::default() },
        };
        let (phi, steps) = swept(scene, &overrides);
        assert_eq!(format!("{phi:.12}"), row[1], "{row:?}");
        assert_eq!(steps.to_string(), row[4], "{row:?}");
        if phi != truth {
            assert_eq!(format!("{:.1e}", (phi - truth).abs()), row[2], "{row:?}");
            errors.push(phi - truth);
        }
    }
    assert_eq!(errors.len(), 5);
    // Order 4: towards a factor of 16 for half a step.
    let factors: Vec<f64> = errors.windows(2).map(|pair| pair[0] / pair[1]).collect();
    assert!(factors.windows(2).all(|pair| pair[0] < pair[1]) && factors[3] > 15.0 && factors[3] < 16.0, "{factors:?}");
}
