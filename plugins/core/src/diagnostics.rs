//! Errors and warnings as plain data.
//!
//! A diagnostic is made where the fault is noticed, carries the places in the text that it is about, and is drawn far away
//! (the program's `report` module). Messages are lower case, without a full stop; backticks stand around the user's words;
//! `help` says what to do.

/// A place in the text of a scene: byte offsets `start..end` in the file number `file` of the source map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub struct Span {
    /// Index of the file in the order in which files were opened; the scene itself is 0.
    pub file: u16,
    /// First byte.
    pub start: u32,
    /// One past the last byte.
    pub end: u32,
}

impl Span {
    /// The smallest span that covers `self` and `other`, which lie in the same file.
    pub fn to(self, other: Span) -> Span {
        Span { file: self.file, start: self.start.min(other.start), end: self.end.max(other.end) }
    }
}

/// A value and the place in the text that it comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct Spanned<T> {
    /// The value.
    pub value: T,
    /// Where it stands.
    pub span: Span,
}

impl<T> Spanned<T> {
    /// Joins a value with its place.
    pub fn new(value: T, span: Span) -> Self {
        Self { value, span }
    }
}

/// How bad it is: an error stops the program before it renders, a warning does not.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The scene is rendered all the same.
    Warning,
    /// The scene is not rendered.
    Error,
}

/// An underlined place with a few words.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// The underlined text.
    pub span: Span,
    /// What is said under it; may be empty.
    pub text: String,
}

/// One finding about the user's input.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnostic {
    /// Error or warning.
    pub severity: Severity,
    /// Stable name of the kind of finding, such as `unknown-parameter`.
    pub code: &'static str,
    /// The finding in one sentence.
    pub message: String,
    /// The place it is about, if it is about a place in the scene's text.
    pub primary: Option<Label>,
    /// Further places.
    pub labels: Vec<Label>,
    /// What to do about it.
    pub help: Option<String>,
}

impl Diagnostic {
    /// An error without a place yet.
    pub fn error(code: &'static str, message: impl Into<String>) -> Self {
        Self { severity: Severity::Error, code, message: message.into(), primary: None, labels: Vec::new(), help: None }
    }

    /// A warning without a place yet.
    pub fn warning(code: &'static str, message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(code, message) }
    }

    /// Sets the place that the finding is about, with words to stand under it.
    pub fn at(mut self, span: Span, text: impl Into<String>) -> Self {
        self.primary = Some(Label { span, text: text.into() });
        self
    }

    /// Adds a further place.
    pub fn and(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push(Label { span, text: text.into() });
        self
    }

    /// Says what to do.
    pub fn help(mut self, text: impl Into<String>) -> Self {
        self.help = Some(text.into());
        self
    }

    /// Says what to do, if there is something to say.
    pub fn maybe_help(mut self, text: Option<String>) -> Self {
        self.help = text.or(self.help);
        self
    }
}

/// `text`, cut if it is long.
pub fn shorten(text: &str) -> String {
    match text.char_indices().nth(40) {
        Some((cut, _)) => format!("{}...", &text[..cut]),
        None => text.to_owned(),
    }
}

/// The candidate that `word` was probably meant to be, if one is close: optimal string alignment distance of at most a third
/// of the word's length (and at least one), case ignored.
pub fn did_you_mean<'a>(word: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase();
    let limit = (word.chars().count() / 3).max(1);
    candidates
        .into_iter()
        .map(|c| (strsim::osa_distance(&word, &c.to_lowercase()), c))
        .filter(|(distance, _)| *distance <= limit)
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, c)| c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suggestions_are_near_and_only_near() {
        assert_eq!(did_you_mean("tolerence", ["step", "tolerance"]), Some("tolerance"));
        assert_eq!(did_you_mean("SPHERE", ["sphere", "disk"]), Some("sphere"));
        assert_eq!(did_you_mean("eta", ["reflectance", "roughness"]), None);
    }
}
