//! `Define`, and what `$name` stands for.

use crate::lang::ast::{Directive, Holder};
use crate::lang::parse::is_variable_name;
use crate::lang::resolve::Resolver;
use crate::lang::resolve::call::Call;
use crate::lang::variables::{ALWAYS, Unread, Variables};
use bhs_core::diagnostics::{Diagnostic, Span, Spanned, shorten};
use bhs_core::value::Values;
use std::collections::{BTreeMap, BTreeSet};

/// The variables of a scene.
pub(super) struct Scope<'v> {
    /// Those that come from outside, which win.
    given: &'v Variables,
    /// Those of `Define`.
    defined: BTreeMap<String, (f64, Span)>,
    /// Names that have been read.
    read: BTreeSet<String>,
    /// Where names that nothing defines have been read first.
    unknown: BTreeMap<String, Span>,
}

impl<'v> Scope<'v> {
    /// Only what comes from outside.
    pub fn new(given: &'v Variables) -> Self {
        Self { given, defined: BTreeMap::new(), read: BTreeSet::new(), unknown: BTreeMap::new() }
    }

    /// The number that `$name` stands for.
    fn read(&mut self, name: &Spanned<String>) -> Option<f64> {
        let found = self.given.find(&name.value).map(|(value, _)| value);
        let found = found.or_else(|| self.defined.get(&name.value).map(|(value, _)| *value));
        let found = found.or_else(|| ALWAYS.contains(&name.value.as_str()).then_some(0.0));
        match found {
            Some(_) if !self.read.contains(&name.value) => drop(self.read.insert(name.value.clone())),
            None if !self.unknown.contains_key(&name.value) => drop(self.unknown.insert(name.value.clone(), name.span)),
            _ => {}
        }
        found
    }
}

impl Resolver<'_> {
    /// Puts numbers in place of the variables of a directive. Values with one that is unknown are left out, to be reported in the end.
    pub(super) fn substitute(&mut self, directive: &mut Directive) {
        let (mut args, mut params) = (BTreeSet::new(), BTreeSet::new());
        for reference in std::mem::take(&mut directive.references) {
            let values = match reference.of {
                Holder::Arg(i) => directive.args.get_mut(i).map(|arg| &mut arg.values),
                Holder::Param(i) => directive.params.get_mut(i).map(|param| &mut param.values),
            };
            let Some(Values::Numbers { values, whole }) = values else { continue };
            match (self.variables.read(&reference.name), values.get_mut(reference.index)) {
                (Some(number), Some(value)) => {
                    *value = if reference.negative { -number } else { number };
                    *whole &= number.fract() == 0.0;
                }
                _ => {
                    directive.faulty = true;
                    match reference.of {
                        Holder::Arg(i) => args.insert(i),
                        Holder::Param(i) => params.insert(i),
                    };
                }
            }
        }
        let mut i = 0;
        directive.args.retain(|_| (!args.contains(&i), i += 1).0);
        i = 0;
        directive.params.retain(|_| (!params.contains(&i), i += 1).0);
    }

    /// `Define "name" value`.
    pub(crate) fn define(&mut self, call: Call) {
        let Some(value) = call.numbers.first() else { return };
        let name = call.name;
        if !is_variable_name(&name.value) {
            let help = "names have letters, digits and `_`, and begin with none of the digits";
            let message = format!("a variable cannot be called `{}`", shorten(&name.value));
            return self.error("bad-value", message, name.span, "", help);
        }
        if ALWAYS.contains(&name.value.as_str()) {
            let message = format!("`{}` is always there and cannot be defined", name.value);
            let help = format!("-D {}=... gives it a number, and so does --frames", name.value);
            return self.error("duplicate-variable", message, name.span, "", help);
        }
        if let Some((_, first)) = self.variables.defined.get(&name.value) {
            self.found.push(
                Diagnostic::error("duplicate-variable", format!("the variable `{}` is defined twice", shorten(&name.value)))
                    .at(name.span, "defined again here")
                    .and(*first, "first defined here")
                    .help("give one of the two another name"),
            );
            return;
        }
        self.variables.defined.insert(name.value, (*value, name.span));
    }

    /// Says which variables are unknown, and notes what is given and not read.
    pub(super) fn finish_variables(&mut self) {
        let unknown = std::mem::take(&mut self.variables.unknown);
        let defined = &self.variables.defined;
        let given = self.variables.given;
        let names: BTreeSet<&str> =
            defined.keys().map(String::as_str).chain(given.names().map(|(name, _)| name)).chain(ALWAYS).collect();
        if !self.scene.incomplete {
            for (name, span) in unknown {
                let error = Diagnostic::error("unknown-variable", format!("unknown variable `${}`", shorten(&name))).at(span, "");
                self.found.push(match (defined.get(&name), self.suggestions.near(&name, names.iter().copied())) {
                    (Some((_, below)), _) => error.and(*below, "defined only here").help("define it before it is used"),
                    (None, Some(near)) => error.help(format!("did you mean `${near}`?")),
                    (None, None) => {
                        let name = shorten(&name);
                        error.help(format!("write Define \"{name}\" and a number before it, or give it with -D {name}=..."))
                    }
                });
            }
        }
        let read = self.variables.read.iter().filter_map(|name| Some((name.clone(), given.find(name)?.0)));
        self.scene.variables.read = read.collect();
        let is_sound = !self.scene.incomplete && !crate::lang::has_errors(&self.found);
        let mut unread: Vec<_> = given.names().filter(|(name, _)| is_sound && !self.variables.read.contains(*name)).collect();
        unread.sort_by_key(|(name, _)| *name);
        unread.dedup_by_key(|(name, _)| *name);
        self.scene.variables.unread = unread
            .into_iter()
            .map(|(name, origin)| {
                let read = self.variables.read.iter().map(String::as_str);
                let near = self.suggestions.near(name, read).map(str::to_owned);
                Unread { name: name.to_owned(), origin, near }
            })
            .collect();
    }
}
