//! Lines of comma-separated values whose columns a first line may name, in any order.

use std::fmt;

/// What is wrong with a line.
#[derive(Debug)]
pub(super) struct Fault {
    /// Where in the line, counted in characters from 1; `None`: all of it.
    pub column: Option<usize>,
    pub message: String,
}

impl Fault {
    /// About the line as a whole.
    pub fn whole(message: impl Into<String>) -> Self {
        Self { column: None, message: message.into() }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.message)
    }
}

/// A value of a line.
#[derive(Clone, Copy)]
pub(super) struct Field<'l> {
    pub text: &'l str,
    name: &'static str,
    column: usize,
}

impl Field<'_> {
    /// What is wrong with it.
    pub fn fault(&self, message: impl Into<String>) -> Fault {
        Fault { column: Some(self.column), message: message.into() }
    }

    /// A number that is finite.
    pub fn number(&self) -> Result<f64, Fault> {
        match self.text.parse::<f64>() {
            Ok(x) if x.is_finite() => Ok(x),
            Ok(_) => Err(self.fault(format!("`{}` in the column `{}` is not finite", self.text, self.name))),
            Err(_) => Err(self.fault(format!("`{}` in the column `{}` is not a number", self.text, self.name))),
        }
    }
}

/// Columns, in the order of a file.
pub(super) struct Columns {
    /// Those that have to be there, in the order in which they stand where no line names them.
    required: &'static [&'static str],
    /// Those that may be there.
    optional: &'static [&'static str],
    /// Their names as the file has them.
    order: Vec<&'static str>,
}

/// The words of a line between its commas, without blanks and quotes, with where each begins.
fn words(line: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut at = 1;
    line.split(',').map(move |word| {
        let start = at + word.chars().take_while(|c| c.is_whitespace()).count();
        at += word.chars().count() + 1;
        let word = word.trim();
        (start, word.strip_prefix('"').and_then(|w| w.strip_suffix('"')).unwrap_or(word))
    })
}

impl Columns {
    /// Those that are `required` alone, in this order, until a line names others.
    pub fn new(required: &'static [&'static str], optional: &'static [&'static str]) -> Self {
        Self { required, optional, order: required.to_vec() }
    }

    fn known(&self, word: &str) -> Option<&'static str> {
        self.required.iter().chain(self.optional).find(|name| **name == word).copied()
    }

    /// The values of a line; `None` of an empty one, a comment, and one that names the columns of those that follow.
    pub fn read<'l>(&mut self, line: &'l str) -> Result<Option<Vec<Field<'l>>>, Fault> {
        let line = line.trim_start_matches('\u{feff}').trim_end();
        let first = line.trim_start();
        if first.is_empty() || first.starts_with('#') {
            return Ok(None);
        }
        if words(line).any(|(_, word)| self.known(word).is_some()) {
            self.order = self.named(line)?;
            return Ok(None);
        }
        let found = words(line).count();
        if found != self.order.len() {
            let all = self.order.join(",");
            // A side is a word.
            let what = if self.order.contains(&"side") { "values" } else { "numbers" };
            return Err(Fault::whole(format!("expected {} {what} {all}, found {found}", self.order.len())));
        }
        let fields = words(line).zip(&self.order).map(|((column, text), &name)| Field { text, name, column });
        Ok(Some(fields.collect()))
    }

    /// The columns that a line names.
    fn named(&self, line: &str) -> Result<Vec<&'static str>, Fault> {
        let mut order = Vec::new();
        for (column, word) in words(line) {
            let fault = |message| Fault { column: Some(column), message };
            let all = || [self.required, self.optional].concat().join(", ");
            let name = self.known(word).ok_or_else(|| fault(format!("`{word}` is no column: there are {}", all())))?;
            if order.contains(&name) {
                return Err(fault(format!("two columns are called `{name}`")));
            }
            order.push(name);
        }
        match self.required.iter().find(|name| !order.contains(name)) {
            Some(missing) => Err(Fault::whole(format!("the column `{missing}` is missing"))),
            None => Ok(order),
        }
    }
}

/// The value of the column called `name`; `None` if there is none, or nothing in it.
pub(super) fn optional<'f, 'l>(fields: &'f [Field<'l>], name: &str) -> Option<&'f Field<'l>> {
    fields.iter().find(|field| field.name == name && !field.text.is_empty())
}

/// The numbers of the columns `names`, which are required.
pub(super) fn numbers<const N: usize>(fields: &[Field], names: [&str; N]) -> Result<[f64; N], Fault> {
    let mut numbers = [0.0; N];
    for (number, name) in numbers.iter_mut().zip(names) {
        if let Some(field) = fields.iter().find(|field| field.name == name) {
            *number = field.number()?;
        }
    }
    Ok(numbers)
}
