//! The syntax highlighting under `docs/editor` knows the words of the language, and no others.

use crate::common;
use bhs::lang;
use bhs_core::value::ParamType;
use serde_json::Value;
use std::collections::BTreeSet;

fn grammar() -> Value {
    serde_json::from_str(&common::read("docs/editor/bhs.tmLanguage.json")).expect("it is JSON")
}

/// The words of the first group `(a|b|c)` of a pattern that is made of words alone.
fn words(pattern: &Value) -> BTreeSet<String> {
    let groups = pattern.as_str().expect("a pattern").split('(').filter_map(|rest| rest.split_once(')'));
    let is_words = |g: &&str| g.contains('|') && g.chars().all(|c| c.is_ascii_alphanumeric() || c == '|');
    groups.map(|(group, _)| group).find(is_words).expect("a group of words").split('|').map(str::to_owned).collect()
}

#[test]
fn directives_are_the_parsers() {
    let grammar = grammar();
    let patterns = grammar["repository"]["directive"]["patterns"].as_array().expect("patterns");
    let coloured: Vec<String> = patterns.iter().flat_map(|p| words(&p["match"])).collect();
    let unique: BTreeSet<&str> = coloured.iter().map(String::as_str).collect();
    assert_eq!(unique.len(), coloured.len(), "a directive has two colours");
    assert_eq!(unique, lang::keywords().collect());
}

#[test]
fn types_are_the_parsers() {
    let coloured = words(&grammar()["repository"]["declaration"]["match"]);
    for ty in ParamType::ALL {
        assert!(coloured.contains(ty.word()), "{}", ty.word());
    }
    for word in &coloured {
        assert!(ParamType::from_word(word).is_some(), "{word}");
    }
}

#[test]
fn everything_that_is_included_is_there() {
    let grammar = grammar();
    assert_eq!((&grammar["scopeName"], &grammar["fileTypes"][0]), (&"source.bhs".into(), &"bhs".into()));
    fn includes(value: &Value, into: &mut Vec<String>) {
        match value {
            Value::Object(members) => {
                into.extend(members.get("include").and_then(Value::as_str).map(str::to_owned));
                members.values().for_each(|v| includes(v, into));
            }
            Value::Array(elements) => elements.iter().for_each(|v| includes(v, into)),
            _ => {}
        }
    }
    let mut names = Vec::new();
    includes(&grammar, &mut names);
    assert!(names.len() > 7);
    for name in names {
        assert!(grammar["repository"][name.trim_start_matches('#')].is_object(), "{name}");
    }
}
