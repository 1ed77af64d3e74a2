//! Nothing that a person, an exporter or a broken disk can write makes the program panic, hang, or ask for more memory than the
//! input justifies: mutated scenes and random ones through parser and builder, mutated meshes, spectra and
//! pictures through their readers.
//!
//! Everything is drawn from fixed seeds. `BHS_FUZZ=10` multiplies the number of inputs.

mod files;

use crate::common;
use bhs::lang::parse::Directives;
use bhs::lang::{self, Overrides, SourceMap};
use bhs::registry::Registry;

/// Scenes that are read; every [`BUILT`]th of them is built too.
const SCENES: u64 = 100_000;
const BUILT: u64 = 10;

/// Bytes that reading may hold at once for each byte of input, and besides.
const BYTES_A_BYTE: usize = 200;
const BYTES_BESIDES: usize = 4 << 20;

fn times(n: u64) -> u64 {
    n * std::env::var("BHS_FUZZ").ok().and_then(|s| s.parse::<u64>().ok()).unwrap_or(1)
}

/// Runs `work` on input of `size` bytes, and checks how much memory it holds at once.
fn within_memory(size: usize, input: &dyn std::fmt::Debug, work: impl FnOnce()) {
    let most = allocation_counter::measure(work).bytes_max;
    assert!(most <= (BYTES_BESIDES + BYTES_A_BYTE * size) as u64, "{most} bytes for an input of {size}: {input:?}");
}

/// Random numbers: PCG's output of a counter (O'Neill 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let word = ((self.0 >> ((self.0 >> 59) + 5)) ^ self.0).wrapping_mul(12_605_985_483_714_917_081);
        (word >> 43) ^ word
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n.max(1) as u64) as usize
    }

    fn one<'t, T: ?Sized>(&mut self, of: &[&'t T]) -> &'t T {
        of[self.below(of.len())]
    }
}

/// Changes bytes here and there: other bytes, fewer, more, parts twice, parts of `words` in between.
fn mutate(random: &mut Random, bytes: &mut Vec<u8>, words: &[&str]) {
    for _ in 0..=random.below(4) {
        let at = random.below(bytes.len() + 1);
        let end = (at + random.below(12)).min(bytes.len());
        match random.below(7) {
            0 if at < bytes.len() => bytes[at] = random.next() as u8,
            1 if at < bytes.len() => bytes[at] ^= 1 << random.below(8),
            2 => drop(bytes.drain(at..end)),
            3 => bytes.truncate(at),
            4 => {
                let part = bytes[at..end].to_vec();
                let to = random.below(bytes.len() + 1);
                bytes.splice(to..to, part);
            }
            _ => drop(bytes.splice(at..at, random.one(words).bytes())),
        }
    }
}

const WORDS: &[&str] = &[
    "\"",
    "[",
    "]",
    "#",
    "\n",
    "\r\n",
    "\\",
    " ",
    ",",
    "-",
    "+",
    ".",
    "e",
    "\"float",
    "x\"",
    "\"float radius\" ",
    "\"rgb L\" ",
    "\"string type\" ",
    "\"spectrum L\" ",
    "\"diffuse\" ",
    "\"sphere\" ",
    "\"point3 P\" ",
    "\"integer indices\" ",
    "\"trianglemesh\" ",
    "\"perspective\" ",
    "\"schwarzschild\" ",
    "\"float rs\" ",
    "1e999 ",
    "-1e308 ",
    "1e-320 ",
    "nan ",
    "-inf ",
    "99999999999999999999 ",
    "0 ",
    "0.5 ",
    "1 ",
    "7 ",
    "true ",
    "false ",
    "$x ",
    "-$frame ",
    "$",
    "Define \"x\" 0.5 ",
    "\u{feff}",
    "\u{e9}",
    "\0",
    "[0 1 2] ",
    "[0 0 0  1 0 0  0 1 0] ",
    "\"a\" ",
    "Nonsense ",
    "worldbegin ",
    "\"metal-Au-eta\" ",
    "\"bool redshift\" ",
    "\"string filename\" ",
    "\"nowhere.ply\" ",
    "AttributeBegin ",
    "AttributeEnd ",
    "WorldBegin ",
];

/// Words of the language, one after the other, as likely right as wrong.
fn soup(random: &mut Random, keywords: &[&str]) -> String {
    let mut text = String::new();
    for _ in 0..random.below(60) {
        match random.below(4) {
            0 => text += random.one(keywords),
            1 => text += &(random.below(40) as i32 - 5).to_string(),
            _ => text += random.one(WORDS),
        }
        if random.below(5) > 0 {
            text.push(' ');
        }
    }
    text
}

/// Scenes of the tree that are small, and need no file.
fn scenes() -> Vec<Vec<u8>> {
    let mut scenes: Vec<Vec<u8>> = Vec::new();
    for folder in ["scenes", "scenes/include", "tests/diagnostics"] {
        let mut paths: Vec<_> =
            std::fs::read_dir(folder).expect("the folder is there").map(|e| e.expect("readable").path()).collect();
        paths.sort();
        for path in paths.iter().filter(|p| p.extension().is_some_and(|e| e == "bhs")) {
            let text = std::fs::read(path).expect("scenes can be read");
            let reads_a_file = ["Include", "plymesh", "/"].iter().any(|w| String::from_utf8_lossy(&text).contains(w));
            if text.len() < 4000 && !reads_a_file {
                scenes.push(text);
            }
        }
    }
    let reference = common::read("grammar/README.md");
    scenes.extend(reference.split("```bhs\n").skip(1).filter_map(|rest| Some(rest.split("```").next()?.as_bytes().to_vec())));
    scenes
}

/// Reads a text, by the grammar alone too, and perhaps builds it; what is found lies within the text. Whether it was read and
/// built without a fault.
fn read_scene(text: &str, build: bool, registry: &Registry) -> [bool; 2] {
    let mut directives = Directives::new(text, 0);
    let read: Vec<_> = directives.by_ref().collect();
    let found = directives.into_faults();
    let mut by_grammar = Directives::by_grammar(text, 0);
    assert_eq!(read, by_grammar.by_ref().collect::<Vec<_>>(), "{text:?}");
    assert_eq!(found, by_grammar.into_faults(), "{text:?}");
    for label in found.iter().flat_map(|d| d.primary.iter().chain(&d.labels)) {
        assert!(text.get(label.span.start as usize..label.span.end as usize).is_some(), "{label:?} in {text:?}");
    }
    if let Ok(neat) = lang::format(text, 0) {
        assert_eq!(lang::format(&neat, 0).as_ref(), Ok(&neat), "{text:?}");
    }
    let is_read = found.is_empty();
    if !build {
        return [is_read, false];
    }
    let mut sources = SourceMap::new();
    let overrides = Overrides { intersector: Some("reference".into()), ..Default::default() };
    let found = match lang::load_text("fuzz", text, registry, &overrides, &mut sources) {
        Ok(scene) => scene.warnings,
        Err(found) => found,
    };
    for label in found.iter().flat_map(|d| d.primary.iter().chain(&d.labels)) {
        let text = &sources.get(label.span.file).expect("the file is there").text;
        assert!(text.get(label.span.start as usize..label.span.end as usize).is_some(), "{label:?} in {text:?}");
    }
    bhs::report::render(&found, &sources, true);
    [is_read, !lang::has_errors(&found)]
}

#[test]
fn mutated_and_random_scenes() {
    let (scenes, registry) = (scenes(), Registry::builtin());
    assert!(scenes.len() > 100);
    let keywords: Vec<&str> = lang::keywords().collect();
    // What is loaded once and kept does not count.
    read_scene(&String::from_utf8_lossy(&scenes[0]), true, &registry);
    let mut without_fault = [0, 0];
    for seed in 0..times(SCENES) {
        let mut random = Random(seed);
        let text = if seed % 3 == 0 {
            let soup = soup(&mut random, &keywords);
            if seed % 2 == 0 { format!("WorldBegin {soup}") } else { soup }
        } else {
            let mut bytes = scenes[random.below(scenes.len())].clone();
            mutate(&mut random, &mut bytes, WORDS);
            String::from_utf8_lossy(&bytes).into_owned()
        };
        within_memory(text.len(), &text, || {
            let fine = read_scene(&text, seed % BUILT == 0, &registry);
            (0..2).for_each(|i| without_fault[i] += u64::from(fine[i]));
        });
    }
    // They are scenes, more or less.
    let [read, built] = without_fault;
    assert!(read > times(SCENES) / 10 && built > times(SCENES) / BUILT / 50, "{read} {built}");
}
