//! What other renderers call things, and what bhs calls them: pbrt (v3 and v4), Mitsuba and Blender. For messages alone; the words stand in
//! `glossary.txt`.

const TABLES: &str = include_str!("glossary.txt");

/// A word without what differs between spellings: case, blanks, hyphens, underscores, and the parts that only say of which kind it is.
fn bare(word: &str) -> String {
    let letters: String = word.chars().filter(|c| c.is_ascii_alphanumeric()).collect::<String>().to_lowercase();
    let mut bare = letters.as_str();
    for prefix in ["shadernode", "bsdf"] {
        bare = bare.strip_prefix(prefix).unwrap_or(bare);
    }
    for suffix in ["bsdf", "brdf", "material", "shader", "emitter"] {
        bare = bare.strip_suffix(suffix).filter(|rest| !rest.is_empty()).unwrap_or(bare);
    }
    bare.to_owned()
}

/// The entries of a kind: their words, and what stands behind them.
fn entries(kind: &str) -> Vec<(String, String)> {
    let mut entries: Vec<(String, String)> = Vec::new();
    let mut is_kind = false;
    for line in TABLES.lines().filter(|line| !line.starts_with('#')) {
        if let Some(heading) = line.strip_prefix('[').and_then(|line| line.strip_suffix(']')) {
            is_kind = heading == kind;
        } else if is_kind && line.starts_with(' ') {
            if let Some((words, advice)) = entries.last_mut() {
                // The words may go on as well as what is said.
                let to = if advice.is_empty() { words } else { advice };
                to.push(' ');
                to.push_str(line.trim());
            }
        } else if is_kind && !line.is_empty() {
            entries.push((line.to_owned(), String::new()));
        }
        if let Some((words, advice)) = entries.last_mut().filter(|(_, advice)| advice.is_empty())
            && let Some((before, after)) = words.clone().split_once(" = ")
        {
            (*words, *advice) = (before.to_owned(), after.to_owned());
        }
    }
    entries
}

/// What stands behind the entries of a kind that have a word.
fn find(kind: &str, name: &str) -> Vec<String> {
    let [plain, bare] = [name.to_lowercase().replace(['_', '-', ' '], ""), bare(name)];
    let has = |words: &str| words.split(' ').any(|word| word == plain || word == bare);
    entries(kind).into_iter().filter(|(words, _)| has(words)).map(|(_, advice)| advice).collect()
}

/// What to write in place of a plugin of another renderer, or of a spectrum that is called otherwise here.
pub fn plugin(kind: &str, name: &str) -> Option<String> {
    find(kind, name).into_iter().next()
}

/// What to say of a parameter that a plugin, which takes `taken`, does not know: what it is called here.
pub fn parameter(name: &str, taken: &[&str]) -> Option<String> {
    let plain = name.to_lowercase().replace(['_', '-', ' '], "");
    let rows = find("parameter", name);
    let found = rows.iter().flat_map(|here| here.split(' ')).find(|here| taken.contains(here))?;
    if found.eq_ignore_ascii_case(name) {
        return None;
    }
    let more = match (plain.as_str(), found) {
        ("mass" | "m", "rs") => "; it is twice the mass, 2 G M/c^2",
        ("diameter", "radius") => "; half of it",
        ("aperture" | "fstop" | "fnumber", _) => "; a radius in scene units",
        ("focallength", "fov") => "; an angle in degrees",
        ("power", "I" | "L") => "; a power in W would be `power`, if the light takes that",
        ("glossiness" | "shininess", _) => "; 0 is polished, 1 is dull",
        _ => "",
    };
    Some(format!("bhs calls it `{found}`{more}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_found_however_they_are_spelt() {
        for name in ["principled_bsdf", "Principled BSDF", "BsdfPrincipled", "disney"] {
            assert!(plugin("material", name).unwrap().contains("`principled`"), "{name}");
        }
        assert!(plugin("light", "envmap").unwrap().contains("infinite"));
        assert!(plugin("shape", "rectangle").unwrap().contains("bilinearmesh"));
        assert_eq!(plugin("material", "wibble"), None);
    }

    #[test]
    fn no_entry_speaks_of_a_plugin_that_there_is() {
        for there in crate::registry::Registry::builtin().describe() {
            assert_eq!(plugin(there.kind, there.name), None, "{} {}", there.kind, there.name);
        }
    }

    #[test]
    fn entries_name_plugins_that_there_are() {
        let all = crate::registry::Registry::builtin().describe();
        for kind in TABLES.lines().filter_map(|line| line.strip_prefix('[')?.strip_suffix(']')) {
            for (words, advice) in entries(kind) {
                let named = advice
                    .split('`')
                    .nth(1)
                    .filter(|_| advice.starts_with("bhs calls it `") || advice.contains("nearest in bhs is `"));
                let is_there = |name: &str| all.iter().any(|p| p.kind == kind && p.name == name);
                let Some(name) = named.filter(|_| kind != "spectrum") else { continue };
                assert!(is_there(name), "{kind}: {words} = {advice}");
            }
        }
    }

    #[test]
    fn parameters_are_those_that_the_plugin_takes() {
        assert_eq!(parameter("int_ior", &["eta"]).as_deref(), Some("bhs calls it `eta`"));
        assert_eq!(parameter("intensity", &["L", "scale"]).as_deref(), Some("bhs calls it `L`"));
        assert_eq!(parameter("intensity", &["scale"]).as_deref(), Some("bhs calls it `scale`"));
        assert!(parameter("mass", &["rs", "center"]).unwrap().contains("twice"));
        assert_eq!(parameter("intensity", &["radius"]), None);
    }
}
