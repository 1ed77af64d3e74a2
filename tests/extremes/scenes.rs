//! The scenes: each plugin in a room, and each of its parameters with extreme values.

use bhs::registry::PluginInfo;

/// Numbers far from what anybody means.
pub const NUMBERS: &[&str] = &[
    "0",
    "-0.0",
    "-1",
    "1e-300",
    "-1e-300",
    "1e-40",
    "1e-30",
    "1e-10",
    "1e-3",
    "0.999999999",
    "1",
    "1.000001",
    "2",
    "60",
    "179.99999",
    "1e3",
    "1e6",
    "1e9",
    "1e15",
    "1e20",
    "1e30",
    "-1e30",
    "1e38",
    "3.4e38",
    "1e39",
    "1e300",
    "-1e300",
    "nan",
    "inf",
    "-inf",
    "1e999",
];

const INTEGERS: &[&str] = &[
    "0",
    "-1",
    "1",
    "2",
    "1000",
    "1000000",
    "1000000000",
    "2147483648",
    "4294967296",
    "9223372036854775807",
    "9223372036854775808",
    "-9223372036854775809",
    "100000000000000000000000000000",
];

/// A room with a lamp, seen by all plugins under test: `{options}`, `{world}` and what the floor is made of.
pub fn scene(options: &str, world: &str, film: bool, sampler: bool) -> String {
    let film = if film { "Film \"rgb\" \"integer xresolution\" 3 \"integer yresolution\" 3" } else { "" };
    let sampler = if sampler { "Sampler \"independent\" \"integer pixelsamples\" 2" } else { "" };
    format!(
        r#"LookAt 0 1 -4  0 0.5 0  0 1 0
        {film} {sampler}
        {options}
        WorldBegin
        LightSource "infinite" "float L" 0.5
        AttributeBegin
            Translate 0 3 0 Rotate 90 1 0 0
            AreaLightSource "diffuse" "float L" 4
            Shape "disk" "float radius" 0.5
        AttributeEnd
        {world}
        Rotate -90 1 0 0
        Shape "disk" "float radius" 5
        Translate 0 0 0.6
        Shape "sphere" "float radius" 0.6"#
    )
}

/// What a film has in these tests, and what shapes cannot do without: parameters by name.
const SIZE: &[(&str, &str)] = &[("xresolution", "\"integer xresolution\" 3"), ("yresolution", "\"integer yresolution\" 3")];
const SQUARE: &[(&str, &str)] =
    &[("P", "\"point3 P\" [-1 -1 0  1 -1 0  1 1 0  -1 1 0]"), ("indices", "\"integer indices\" [0 1 2  0 2 3]")];
const TURN: &[(&str, &str)] = &[("omega", "\"float omega\" 0.01")];
const PATCH: &[(&str, &str)] = &[("P", "\"point3 P\" [-1 -1 0  1 -1 0  -1 1 0  1 1 0.3]")];

/// Numbers of the lists that plugins take: what they are if nothing is wrong with them.
fn list(name: &str) -> &'static str {
    match name {
        "screenwindow" => "-1 1 -1 1",
        "cropwindow" => "0 1 0 1",
        "P" => "-1 -1 0  1 -1 0  1 1 0  -1 1 0",
        "N" => "0 0 1  0 0 1  0 0 1  0 0 1",
        "uv" => "0 0  1 0  1 1  0 1",
        "indices" => "0 1 2  0 2 3",
        _ => "",
    }
}

/// The scene in which the plugin has the parameter text `given`; `None` for plugins that no scene names.
pub fn scene_of(plugin: &PluginInfo, given: &str, parameter: &str) -> Option<String> {
    let name = plugin.name;
    // What else it takes to be made; a parameter under test replaces it.
    let needed = |all: &[(&str, &str)]| {
        let others = all.iter().filter(|(name, _)| *name != parameter);
        others.map(|(_, text)| *text).collect::<Vec<_>>().join(" ")
    };
    let hole = "BlackHole \"schwarzschild\" \"point3 center\" [0.5 1.2 1] \"float rs\" 0.1";
    Some(match plugin.kind {
        "integrator" => scene(&format!("Integrator \"{name}\" {given}"), hole, true, true),
        "light transport" => scene(&format!("LightTransport \"{name}\" {given}"), "", true, true),
        "motion" => {
            let needs = if name == "rotating" { needed(TURN) } else { String::new() };
            scene(&format!("Camera \"perspective\" \"string motion\" \"{name}\" {needs} {given}"), hole, true, true)
        }
        "camera" => scene(&format!("Camera \"{name}\" {given}"), "", true, true),
        "film" => {
            let size = needed(SIZE);
            scene(&format!("Film \"{name}\" {size} {given}"), "", false, true)
        }
        "filter" => scene(&format!("PixelFilter \"{name}\" {given}"), "", true, true),
        "sampler" => {
            // Sampling until there is hardly any noise has no end but this.
            let most = if given.contains(" noise\"") { "\"integer pixelsamples\" 4" } else { "" };
            scene(&format!("Sampler \"{name}\" {given} {most}"), "", true, false)
        }
        "material" if name == "mix" => {
            let world = format!(
                "MakeNamedMaterial \"a\" \"string type\" \"diffuse\" MakeNamedMaterial \"b\" \"string type\" \"conductor\"
                 Material \"mix\" \"string materials\" [\"a\" \"b\"] {given}"
            );
            scene("", &world, true, true)
        }
        "material" => scene("", &format!("Material \"{name}\" {given}"), true, true),
        "texture" => {
            let file = if name == "imagemap" { "\"string filename\" \"grammar/examples/tiles.png\"" } else { "" };
            // A texture of numbers takes no spectra.
            let is_spectrum = ["spectrum", "rgb", "blackbody", "tolman"].iter().any(|t| given.starts_with(&format!("\"{t} ")));
            let floats = if is_spectrum { "" } else { given };
            let world = format!(
                "Texture \"s\" \"spectrum\" \"{name}\" {file} {given} Texture \"f\" \"float\" \"{name}\" {file} {floats}
                 Texture \"zero\" \"spectrum\" \"scale\" \"texture tex\" \"s\" \"float scale\" 0
                 MakeNamedMaterial \"d\" \"string type\" \"diffuse\" \"texture reflectance\" \"s\"
                 MakeNamedMaterial \"e\" \"string type\" \"diffuse\" \"texture reflectance\" \"zero\"
                 MakeNamedMaterial \"de\" \"string type\" \"mix\" \"string materials\" [\"d\" \"e\"] \"texture amount\" \"f\"
                 MakeNamedMaterial \"c\" \"string type\" \"conductor\" \"texture eta\" \"s\" \"texture roughness\" \"f\"
                 Material \"mix\" \"string materials\" [\"de\" \"c\"]"
            );
            scene("", &world, true, true)
        }
        "light" => {
            let file = if name == "projection" { "\"string filename\" \"grammar/examples/tiles.png\"" } else { "" };
            scene("", &format!("LightSource \"{name}\" {file} {given}"), true, true)
        }
        "area light" if name == "thindisc" => {
            let world = format!(
                "AttributeBegin Translate 0.5 1.2 1 BlackHole \"schwarzschild\" \"float rs\" 0.1 Rotate -90 1 0 0
                 AreaLightSource \"thindisc\" {given} Shape \"disk\" \"float radius\" 1 \"string motion\" \"keplerian\" AttributeEnd"
            );
            scene("", &world, true, true)
        }
        "area light" => {
            let world = format!(
                "AttributeBegin Translate 1 1 0 AreaLightSource \"{name}\" {given} Shape \"sphere\" \"float radius\" 0.3 AttributeEnd"
            );
            scene("", &world, true, true)
        }
        "shape" => {
            let needs = match name {
                "trianglemesh" | "loopsubdiv" => needed(SQUARE),
                "bilinearmesh" => needed(PATCH),
                "curve" => needed(&[("P", "\"point3 P\" [-1 -1 0  -1 1 0  1 -1 0  1 1 0]")]),
                "plymesh" => "\"string filename\" \"grammar/examples/pyramid.ply\"".to_owned(),
                "objmesh" => "\"string filename\" \"grammar/examples/pyramid.obj\"".to_owned(),
                "stlmesh" => "\"string filename\" \"grammar/examples/tetrahedron.stl\"".to_owned(),
                "gltf" => "\"string filename\" \"grammar/examples/scene.gltf\"".to_owned(),
                _ => String::new(),
            };
            let shape = format!("Shape \"{name}\" {needs} {given}");
            scene(
                "",
                &format!("{shape} AttributeBegin Translate 0 2 0 AreaLightSource \"diffuse\" {shape} AttributeEnd"),
                true,
                true,
            )
        }
        "intersector" => return None,
        other => panic!("no scene for a plugin of the kind `{other}`"),
    })
}

/// All ways to give the parameter an extreme value.
pub fn given(name: &str, types: &str) -> Vec<String> {
    let mut all = Vec::new();
    let numbers = list(name);
    for ty in types.split(", ") {
        match ty {
            _ if !numbers.is_empty() => {
                // One of several goes astray.
                let values = if ty == "integer" { INTEGERS } else { NUMBERS };
                let count = numbers.split_whitespace().count();
                for (value, at) in values.iter().flat_map(|v| [0, count / 2, count - 1].map(|at| (v, at))) {
                    let list: Vec<&str> =
                        numbers.split_whitespace().enumerate().map(|(i, n)| if i == at { value } else { n }).collect();
                    all.push(format!("\"{ty} {name}\" [{}]", list.join(" ")));
                }
                all.push(format!("\"{ty} {name}\" []"));
                all.extend(values.iter().map(|v| format!("\"{ty} {name}\" [{}]", vec![*v; count].join(" "))));
            }
            "float" => all.extend(NUMBERS.iter().map(|v| format!("\"float {name}\" {v}"))),
            "integer" => all.extend(INTEGERS.iter().map(|v| format!("\"integer {name}\" {v}"))),
            "spectrum" => {
                for v in NUMBERS {
                    all.push(format!("\"spectrum {name}\" {v}"));
                    all.push(format!("\"spectrum {name}\" [400 {v}  700 0.5]"));
                    all.push(format!("\"spectrum {name}\" [{v} 1  700 0.5]"));
                    all.push(format!("\"rgb {name}\" [{v} 0.2 0]"));
                    all.push(format!("\"rgb {name}\" [{v} {v} {v}]"));
                    all.push(format!("\"blackbody {name}\" {v}"));
                    all.push(format!("\"tolman {name}\" {v}"));
                }
            }
            "point2" | "vector2" | "point3" | "vector3" | "normal" => {
                let count = if ty.ends_with('2') { 2 } else { 3 };
                for v in NUMBERS {
                    all.push(format!("\"{ty} {name}\" [{}]", vec![*v; count].join(" ")));
                    all.push(format!("\"{ty} {name}\" [{v}{}]", " 0.5".repeat(count - 1)));
                    all.push(format!("\"{ty} {name}\" [{}{v}]", "0 ".repeat(count - 1)));
                }
            }
            _ => {}
        }
    }
    all
}
