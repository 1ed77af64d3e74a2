//! `bhs format`: the same directives, the same comments, and nothing left to do the second time.

use bhs::lang::{format, parse::parse};
use bhs_core::value::{Param, Values};
use proptest::prelude::*;
use proptest::sample::select;

/// What a text says, without places.
fn meaning(text: &str) -> String {
    let (directives, found) = parse(text, 0);
    assert!(found.is_empty(), "{found:?}\n{text}");
    let values = |v: &Values| match v {
        Values::Numbers { values, whole } => format!("{values:?} {whole}"),
        Values::Strings(texts) => format!("{:?}", texts.iter().map(|t| &t.value).collect::<Vec<_>>()),
        Values::Bools(bools) => format!("{bools:?}"),
    };
    let param = |p: &Param| format!("{} {} {}", p.ty.value.word(), p.name.value, values(&p.values));
    let lines = directives.iter().map(|d| {
        let args = d.args.iter().map(|a| values(&a.values)).collect::<Vec<_>>();
        format!("{} {args:?} {:?}\n", d.keyword.value, d.params.iter().map(param).collect::<Vec<_>>())
    });
    lines.collect()
}

/// All comments of a text that has no `#` in quotes, with the lines' ends taken off.
fn comments(text: &str) -> Vec<&str> {
    text.lines().filter_map(|l| l.find('#').map(|at| l[at..].trim_end())).collect()
}

/// Formats a text, and checks what must hold of the result.
fn formatted(text: &str) -> String {
    let once = format(text, 0).unwrap_or_else(|found| panic!("{found:?}\n{text}"));
    assert_eq!(meaning(&once), meaning(text), "{text}\n----\n{once}");
    let twice = format(&once, 0).unwrap_or_else(|found| panic!("{found:?}\n{once}"));
    assert_eq!(twice, once, "{text}");
    once
}

#[test]
fn a_scene_is_printed_neatly() {
    let text = "

# A scene.
LookAt 0 1 -4 0 1 0   0 1 0   # the view
Camera   \"perspective\" \"float   fov\"   [ 45 ]
Film \"rgb\" \"integer xresolution\" 640 \"integer yresolution\" 480 \"string filename\" \"a # b.exr\" \"float exposure\" -1


WorldBegin AttributeBegin # begins
Translate 1 2 3
# about the shape
Shape \"trianglemesh\" \"point3 P\" [0 0 0 1 0 0 0 1 0 0 0 1 0.125 0.125 0.125 0.25 0.25 0.25 0.5 0.5 0.5 1e9 1e9 1e9]
 # about the indices
 \"integer indices\" [0 1 2 # first
 # second
 0 2 3]

AttributeEnd
# the end";
    let neat = "\
# A scene.
LookAt 0 1 -4  0 1 0  0 1 0  # the view
Camera \"perspective\" \"float fov\" [45]
Film \"rgb\" \"integer xresolution\" 640 \"integer yresolution\" 480 \"string filename\" \"a # b.exr\"
    \"float exposure\" -1

WorldBegin
AttributeBegin  # begins
    Translate 1 2 3
    # about the shape
    Shape \"trianglemesh\"
        \"point3 P\" [0 0 0  1 0 0  0 1 0  0 0 1  0.125 0.125 0.125  0.25 0.25 0.25  0.5 0.5 0.5
            1e9 1e9 1e9]
        # about the indices
        \"integer indices\" [0 1 2  # first
            # second
            0 2 3]

AttributeEnd
# the end
";
    assert_eq!(formatted(text), neat);
}

#[test]
fn windows_line_ends_and_no_text_at_all() {
    assert_eq!(formatted("Scale 1 1 1 # c\r\n\r\nWorldBegin\r\n"), "Scale 1 1 1  # c\n\nWorldBegin\n");
    assert_eq!(formatted(""), "");
    assert_eq!(formatted("\n\n# only this\n\n\n# and that"), "# only this\n\n# and that\n");
}

#[test]
fn a_fault_of_syntax_is_an_error() {
    let found = format("WorldBegin\nShape \"sphere\" \"float radius\" [1\n", 0).expect_err("a list is open");
    assert_eq!(found[0].code, "unclosed-list");
}

#[test]
fn the_scenes_of_the_tree_survive() {
    let mut count = 0;
    for folder in ["scenes", "scenes/include", "tests/diagnostics", "tests/diagnostics/include"] {
        for entry in std::fs::read_dir(folder).expect("the folder is there") {
            let path = entry.expect("and can be read").path();
            let is_scene = path.extension().is_some_and(|e| e == "bhs");
            let Some(text) = is_scene.then(|| std::fs::read_to_string(&path).ok()).flatten() else { continue };
            if parse(&text, 0).1.is_empty() {
                let neat = formatted(&text);
                assert_eq!(comments(&text), comments(&neat), "{}", path.display());
                count += 1;
            }
        }
    }
    assert!(count > 40, "only {count}");
}

/// What may stand between two words.
fn gap() -> impl Strategy<Value = String> {
    prop_oneof![
        12 => Just(" ".to_owned()),
        2 => Just("\n".to_owned()),
        1 => Just("\n\n\n".to_owned()),
        1 => Just("\t\r\n  ".to_owned()),
        1 => Just("  # trailing\n".to_owned()),
        1 => Just("\n  # on its own\n".to_owned()),
        1 => Just("\n\n# one\n# two \n\n".to_owned()),
    ]
}

fn number() -> impl Strategy<Value = String> {
    prop_oneof![
        (-99i32..1000).prop_map(|n| n.to_string()),
        any::<f32>().prop_filter("finite", |x| x.is_finite()).prop_map(|x| x.to_string())
    ]
}

fn text() -> impl Strategy<Value = String> {
    select(vec!["\"sphere\"", "\"two words\"", "\"\"", "\"esc \\\" aped\"", "\"brackets ][ \"", "\"\u{e9}\u{4e16}\""])
        .prop_map(str::to_owned)
}

fn list(element: impl Strategy<Value = String>) -> impl Strategy<Value = String> {
    let elements = proptest::collection::vec((element, gap()), 0..40);
    (elements, gap())
        .prop_map(|(elements, first)| format!("[{first}{}]", elements.into_iter().map(|(e, gap)| e + &gap).collect::<String>()))
}

fn parameter() -> impl Strategy<Value = String> {
    let declared = |types: &'static [&'static str], value: BoxedStrategy<String>| {
        let name = select(vec!["P", "uv", "indices", "a-long-name-that-fills-the-line", "L"]);
        (select(types.to_vec()), name, gap(), value).prop_map(|(ty, name, gap, value)| format!("\"{ty}  {name} \"{gap}{value}"))
    };
    prop_oneof![
        declared(&["float", "integer", "point3", "normal", "rgb", "point2", "spectrum"], list(number()).boxed()),
        declared(&["float", "integer", "blackbody"], number().boxed()),
        declared(&["string", "spectrum", "texture"], prop_oneof![text(), list(text())].boxed()),
        declared(&["bool"], select(vec!["true", "[ false]", "\"true\""]).prop_map(str::to_owned).boxed()),
    ]
}

fn directive() -> impl Strategy<Value = String> {
    let bare = select(vec!["AttributeBegin", "AttributeEnd", "WorldBegin", "ObjectEnd", "Identity"]).prop_map(str::to_owned);
    let numbers = (select(vec!["LookAt", "Scale", "Unknown"]), proptest::collection::vec((gap(), number()), 0..20))
        .prop_map(|(word, numbers)| numbers.into_iter().fold(word.to_owned(), |all, (gap, n)| all + &gap + &n));
    let matrix = (gap(), list(number())).prop_map(|(gap, list)| format!("Transform{gap}{list}"));
    let named = (select(vec!["Shape", "Film", "Option"]), gap(), text(), proptest::collection::vec((gap(), parameter()), 0..6))
        .prop_map(|(word, gap, name, params)| {
            params.into_iter().fold(format!("{word}{gap}{name}"), |all, (gap, param)| all + &gap + &param)
        });
    prop_oneof![2 => bare, 2 => numbers, 1 => matrix, 4 => named]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(500) })]

    #[test]
    fn the_same_directives_come_back(first in gap(), scene in proptest::collection::vec((directive(), gap()), 0..12)) {
        let text = scene.into_iter().fold(first, |all, (directive, gap)| all + &directive + &gap);
        let neat = formatted(&text);
        prop_assert_eq!(comments(&text), comments(&neat));
    }
}
