//! Numbers that a scene is given from outside: by `-D`, by the keys of an animation, and the number of the frame.

/// Frames a second, unless something else is asked for.
pub const FRAMES_PER_SECOND: f64 = 24.0;

/// The variables that are always there: the number of the frame, and its time (s).
pub(crate) const ALWAYS: [&str; 2] = ["frame", "time"];

/// Where the number of a variable comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// `-D name=value`.
    CommandLine,
    /// A column of a file of keys.
    Keys,
    /// The frame that is rendered.
    Frame,
}

/// Numbers from outside of a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Variables {
    /// What `-D` gives. Of several of one name the last counts.
    pub definitions: Vec<(String, f64)>,
    /// What the keys of an animation give at this frame.
    pub keys: Vec<(String, f64)>,
    /// The number of the frame, if it is one of several.
    pub frame: Option<u32>,
    /// Frames a second.
    pub frames_per_second: f64,
}

impl Default for Variables {
    fn default() -> Self {
        Self { definitions: Vec::new(), keys: Vec::new(), frame: None, frames_per_second: FRAMES_PER_SECOND }
    }
}

impl Variables {
    /// Only what `-D` gives.
    pub fn defined(definitions: &[(String, f64)]) -> Self {
        Self { definitions: definitions.to_vec(), ..Self::default() }
    }

    /// The number that `name` has from outside, and from where: `-D` wins over keys. `frame` and `time` are 0 if nobody says otherwise, and
    /// then count as the scene's own.
    pub fn find(&self, name: &str) -> Option<(f64, Origin)> {
        let last = |given: &[(String, f64)]| given.iter().rfind(|(n, _)| n == name).map(|(_, value)| *value);
        if let Some(value) = last(&self.definitions) {
            return Some((value, Origin::CommandLine));
        }
        if let Some(value) = last(&self.keys) {
            return Some((value, Origin::Keys));
        }
        match name {
            "frame" => self.frame.map(|n| (f64::from(n), Origin::Frame)),
            "time" => self.find("frame").map(|(frame, origin)| (frame / self.frames_per_second, origin)),
            _ => None,
        }
    }

    /// All names that have a number from outside.
    pub fn names(&self) -> impl Iterator<Item = (&str, Origin)> {
        let definitions = self.definitions.iter().map(|(name, _)| (name.as_str(), Origin::CommandLine));
        definitions.chain(self.keys.iter().map(|(name, _)| (name.as_str(), Origin::Keys)))
    }
}

/// The variables of a scene as far as they come from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GivenVariables {
    /// Those that the scene reads, by name, with their numbers.
    pub read: Vec<(String, f64)>,
    /// Those that it does not read, with the name of one that it may have been meant to be.
    pub unread: Vec<Unread>,
}

/// A variable that is given, and that nothing in the scene reads.
#[derive(Clone, Debug, PartialEq)]
pub struct Unread {
    /// Its name.
    pub name: String,
    /// Who gives it.
    pub origin: Origin,
    /// What it was probably meant to be called.
    pub near: Option<String>,
}

/// `name=value` of `-D`.
///
/// # Errors
/// What is expected in its place.
pub fn parse_definition(text: &str) -> Result<(String, f64), String> {
    let (name, value) = text.split_once('=').ok_or("expected a name and a number, such as radius=2.5")?;
    if !crate::lang::parse::is_variable_name(name) {
        let bare = name.trim_start_matches('$');
        return Err(match crate::lang::parse::is_variable_name(bare) {
            true => format!("the name stands without `$`: {bare}={value}"),
            false => "a name has letters, digits and `_`, and does not begin with a digit".to_owned(),
        });
    }
    match crate::lang::parse::read_number(value) {
        Some((value, _)) if !value.is_finite() => Err("the number is too large".to_owned()),
        Some((value, _)) if name == "frame" && value.fract() != 0.0 => Err("frames have whole numbers".to_owned()),
        Some((value, _)) => Ok((name.to_owned(), value)),
        None => Err(format!("`{value}` is not a number")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_wins_over_keys_and_the_last_definition_counts() {
        let pair = |name: &str, value: f64| (name.to_owned(), value);
        let given = Variables {
            definitions: vec![pair("x", 1.0), pair("x", 2.0)],
            keys: vec![pair("x", 3.0), pair("y", 4.0)],
            frame: Some(12),
            frames_per_second: 48.0,
        };
        assert_eq!(given.find("x"), Some((2.0, Origin::CommandLine)));
        assert_eq!(given.find("y"), Some((4.0, Origin::Keys)));
        assert_eq!(given.find("frame"), Some((12.0, Origin::Frame)));
        assert_eq!(given.find("time"), Some((0.25, Origin::Frame)));
        assert_eq!(given.find("z"), None);
        assert_eq!(Variables::default().find("time"), None);
        let single = Variables::defined(&[pair("frame", 6.0)]);
        assert_eq!(single.find("time"), Some((0.25, Origin::CommandLine)));
    }

    #[test]
    fn definitions_are_read_and_refused() {
        assert_eq!(parse_definition("x=-1.5e2"), Ok(("x".to_owned(), -150.0)));
        assert_eq!(parse_definition("_a1=+2"), Ok(("_a1".to_owned(), 2.0)));
        for (text, why) in [
            ("x", "expected a name and a number"),
            ("$x=1", "without `$`"),
            ("1x=1", "does not begin with a digit"),
            ("=1", "does not begin with a digit"),
            ("x=", "is not a number"),
            ("x=one", "is not a number"),
            ("x=inf", "is not a number"),
            ("x=1e999", "too large"),
            ("x=1,2", "is not a number"),
            ("frame=1.5", "whole numbers"),
        ] {
            let found = parse_definition(text).expect_err(text);
            assert!(found.contains(why), "{text}: {found}");
        }
    }
}
