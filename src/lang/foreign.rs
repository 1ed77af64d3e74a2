//! Marks and words of other languages, and what stands for them here: help for messages.

/// Help for a word that is no word of the language, by its look.
pub(super) fn mark(word: &str) -> Option<String> {
    let help = match word {
        "{" | "}" => "there are no braces: blocks are `AttributeBegin` ... `AttributeEnd`, lists stand in `[` and `]`",
        "(" | ")" => "there are no parentheses: lists stand in `[` and `]`, numbers are separated by blanks",
        "=" | ":" => "there is no `=`: a parameter is written \"type name\" and its value, such as \"float radius\" 1",
        _ if word.starts_with("//")
            || word.starts_with("/*")
            || word.strip_prefix("--").is_some_and(|rest| !rest.starts_with(|c: char| c.is_ascii_digit() || c == '.'))
            || word.starts_with('%') =>
        {
            "comments start with `#` and end with the line"
        }
        _ if word.ends_with("*/") => "comments start with `#` and end with the line",
        _ if word.starts_with('<') => "this looks like XML, as Mitsuba reads it; bhs reads what pbrt-v4 reads",
        _ if word.ends_with(';') => "there are no semicolons: a directive ends where the next one begins",
        _ if word.starts_with(['{', '}']) || word.ends_with(['{', '}']) => {
            "there are no braces: blocks are `AttributeBegin` ... `AttributeEnd`, lists stand in `[` and `]`"
        }
        _ if word.starts_with('(') || word.ends_with(')') => {
            "there are no parentheses and no arithmetic: lists stand in `[` and `]`, numbers are separated by blanks"
        }
        _ => return axis(word).or_else(|| number(word)),
    };
    Some(help.to_owned())
}

/// Help for what begins as a number does.
fn number(word: &str) -> Option<String> {
    if word.contains('$') && word.contains(['*', '/', '+', '-']) && !word.trim_start_matches(['+', '-']).starts_with('$') {
        return Some(
            "there is no arithmetic: give the number that is meant a name of its own with `Define`, or by `-D`".to_owned(),
        );
    }
    if let Some((whole, part)) = word.split_once(',')
        && !part.is_empty()
        && part.bytes().all(|b| b.is_ascii_digit())
        && whole.trim_start_matches(['+', '-']).bytes().all(|b| b.is_ascii_digit())
        && !whole.is_empty()
    {
        return Some(format!("a number has a decimal point: {whole}.{part}; several numbers are separated by blanks"));
    }
    let end = word.rfind(|c: char| c.is_ascii_digit() || c == '.')? + 1;
    let (value, unit) = word.split_at(end);
    let x: f64 = value.parse().ok()?;
    match unit {
        "%" => Some(format!("write {}", x / 100.0)),
        "deg" | "\u{b0}" => Some(format!("angles are in degrees, without the word: write {value}")),
        "rad" => Some(format!("angles are in degrees: write {}", x.to_degrees())),
        "f" | "F" => Some(format!("write {value}")),
        "K" | "nm" | "m" | "cm" | "mm" | "km" | "um" | "s" | "px" | "W" | "Msun" => Some(format!(
            "numbers have no unit: lengths are in scene units, angles in degrees, wavelengths in nm, temperatures in kelvin; write {value}"
        )),
        _ => None,
    }
}

/// A text without the comments that it begins with.
pub(super) fn after_comments(text: &str) -> &str {
    let mut rest = text.trim_start();
    while rest.starts_with('#') {
        rest = rest.find('\n').map_or("", |end| &rest[end..]).trim_start();
    }
    rest
}

/// Whether a text is the scene of another program altogether: what it looks like.
pub(super) fn other_language(text: &str) -> Option<&'static str> {
    let start = after_comments(text);
    if start.starts_with("<?xml") || start.starts_with("<scene") || start.starts_with("<!") || start.starts_with("<html") {
        return Some("XML, as Mitsuba reads it");
    }
    (start.starts_with('{') && start[1..].trim_start().starts_with(['"', '}'])).then_some("JSON")
}

/// Help for a letter in place of an axis.
fn axis(word: &str) -> Option<String> {
    let (sign, letter) = word.strip_prefix('-').map_or(("", word), |letter| ("-", letter));
    let axis = match letter.to_lowercase().as_str() {
        "x" => format!("{sign}1 0 0"),
        "y" => format!("0 {sign}1 0"),
        "z" => format!("0 0 {sign}1"),
        _ => return None,
    };
    Some(format!("an axis is three numbers: write {axis} in place of `{word}`, as in Rotate 90 {axis}"))
}

/// The type that a word means elsewhere.
pub(super) fn type_word(word: &str) -> Option<&'static str> {
    Some(match word.to_lowercase().as_str() {
        "color" | "colour" | "color3f" | "color3" | "srgb" | "rgba" => "rgb",
        "double" | "real" | "number" | "f32" | "f64" | "single" | "scalar" => "float",
        "int" | "i32" | "uint" | "long" | "size" => "integer",
        "boolean" | "flag" => "bool",
        "str" | "text" | "filename" | "file" | "path" | "char" => "string",
        "vec3" | "float3" | "vector3f" | "xyz" => "vector3",
        "position" | "point3f" | "vertex" => "point3",
        "vec2" | "float2" | "uv" => "point2",
        "bb" | "temperature" | "kelvin" => "blackbody",
        "ref" | "tex" | "map" | "image" | "bitmap" => "texture",
        "spec" | "spectral" => "spectrum",
        _ => return None,
    })
}

/// Help for a directive that other renderers have.
pub(super) fn directive(word: &str) -> Option<&'static str> {
    Some(match word.to_lowercase().as_str() {
        "surfaceintegrator" | "volumeintegrator" | "renderer" | "pathtracer" => "write LightTransport \"path\"",
        "light" | "lamp" | "pointlight" | "sun" | "sky" | "background" | "environment" | "envmap" | "world" => {
            "lights are written LightSource \"infinite\" (a sky), \"distant\" (a sun), \"point\"; surfaces that shine AreaLightSource \"diffuse\""
        }
        "arealight" | "emitter" | "emission" => "write AreaLightSource \"diffuse\", then the `Shape` that shines",
        "sphere" | "mesh" | "cube" | "plane" | "disk" | "cylinder" | "trianglemesh" | "plymesh" | "objmesh" | "object"
        | "geometry" => "surfaces are written Shape \"sphere\", Shape \"plymesh\" ...",
        "bsdf" | "brdf" | "diffuse" | "conductor" | "dielectric" | "glass" | "metal" => {
            "materials are written Material \"diffuse\", Material \"conductor\" ..."
        }
        "hole" | "schwarzschild" | "kerr" => "write BlackHole \"schwarzschild\" \"float rs\" 1",
        "resolution" | "output" | "image" | "exposure" => {
            "write it into the film: Film \"rgb\" \"integer xresolution\" 640 \"integer yresolution\" 480"
        }
        "samples" | "spp" => "write Sampler \"sobol\" \"integer pixelsamples\" 64",
        "fov" | "eye" | "view" => "write LookAt ex ey ez  tx ty tz  ux uy uz, then Camera \"perspective\" \"float fov\" 45",
        "push" | "pushmatrix" | "begin" | "group" | "transformbegin" | "attributestart" => "write `AttributeBegin`",
        "pop" | "popmatrix" | "end" | "groupend" => "write `AttributeEnd`",
        "move" | "position" | "location" => "write Translate x y z",
        "let" | "set" | "var" | "param" | "const" => "write Define \"name\" value",
        "instance" | "use" => "write ObjectInstance \"name\"",
        "worldend" => "remove it; the world ends with the file",
        _ => return None,
    })
}

/// Help for a directive that has another count of numbers than it takes.
pub(super) fn count(word: &str, numbers: &[f64]) -> Option<String> {
    let all = |n: usize| numbers.iter().take(n).map(f64::to_string).collect::<Vec<_>>().join(" ");
    Some(match (word, numbers.len()) {
        ("Scale", 1) => format!("a factor for each axis: write Scale {0} {0} {0}", numbers[0]),
        ("Scale", 2) => "a factor for each axis: write Scale x y z".to_owned(),
        ("Translate", 1 | 2) => "write Translate x y z".to_owned(),
        ("Rotate", 1) => format!("the angle comes first, then the axis: Rotate {} 0 1 0 turns around y", numbers[0]),
        ("Rotate", 3) => {
            format!("write the angle and then the axis x y z; three turns are three lines, such as Rotate {} 1 0 0", numbers[0])
        }
        ("Rotate", _) => "write Rotate degrees x y z".to_owned(),
        ("LookAt", 6) => format!("what is up in the picture is missing: write LookAt {}  0 1 0", all(6)),
        ("LookAt", 3) => {
            "write where the camera stands, what it looks at, and what is up: LookAt ex ey ez  tx ty tz  0 1 0".to_owned()
        }
        ("LookAt", _) => "write LookAt ex ey ez  tx ty tz  ux uy uz".to_owned(),
        ("Transform" | "ConcatTransform", 12) => {
            "a matrix has 16 numbers, column after column: add 0, 0, 0 and 1 as numbers 4, 8, 12 and 16".to_owned()
        }
        ("Transform" | "ConcatTransform", _) => "a matrix has 16 numbers, column after column, in brackets".to_owned(),
        _ => return None,
    })
}
