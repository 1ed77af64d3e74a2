//! A directive with its arguments, checked against what it takes.

use crate::lang::ast::{Arg, Directive};
use crate::lang::defaults::Defaults;
use crate::lang::description::Entity;
use crate::lang::foreign;
use crate::lang::resolve::Resolver;
use crate::lang::resolve::directives::{self, Row, Takes};
use bhs_core::diagnostics::{Diagnostic, Span, Spanned, did_you_mean};
use bhs_core::spacetime::Side;
use bhs_core::value::{Param, ParamType, Values};
use glam::{DAffine3, DVec3};
use std::sync::Arc;

/// A directive whose arguments have been checked against its row.
pub(crate) struct Call {
    pub(in crate::lang) keyword: Span,
    pub(super) span: Span,
    pub(in crate::lang) name: Spanned<String>,
    /// The second and third text, of a directive that takes them.
    pub(super) more: Option<[Spanned<String>; 2]>,
    pub(super) numbers: Vec<f64>,
    pub(super) numbers_span: Span,
    pub(in crate::lang) params: Vec<Param>,
    pub(super) faulty: bool,
}

impl Call {
    /// The same with other parameters.
    pub(in crate::lang) fn with_params(&self, params: Vec<Param>) -> Self {
        let Self { keyword, span, numbers_span, faulty, .. } = *self;
        let (name, numbers) = (self.name.clone(), self.numbers.clone());
        Self { keyword, span, name, more: self.more.clone(), numbers, numbers_span, params, faulty }
    }

    pub(super) fn point(&self, i: usize) -> DVec3 {
        // The number of numbers has been checked.
        DVec3::from_array(std::array::from_fn(|k| self.numbers.get(3 * i + k).copied().unwrap_or(0.0)))
    }

    pub(super) fn entity(self, world_from_object: Arc<DAffine3>) -> Entity {
        let Call { keyword, span, name, mut params, faulty, .. } = self;
        // A scene of very many small directives is made of these lists, which mostly have one member.
        params.shrink_to_fit();
        Entity { name, params, defaults: Defaults::default(), span, keyword, faulty, world_from_object, side: Side::Near }
    }
}

impl Resolver<'_> {
    /// Checks the arguments of a directive; `None` if it cannot be run.
    pub(super) fn call(&mut self, row: &Row, directive: Directive) -> Option<Call> {
        let Directive { keyword, args, params, span, faulty, .. } = directive;
        let word = row.keyword;
        let mut call = Call {
            keyword: keyword.span,
            span,
            name: Spanned::new(String::new(), keyword.span),
            more: None,
            numbers: Vec::new(),
            numbers_span: keyword.span,
            params,
            faulty,
        };
        let mut args = args.into_iter().peekable();

        // What the directive needs.
        match row.takes {
            Takes::Nothing | Takes::Params => {}
            Takes::Numbers(count) => {
                while let Some(arg) = args.next_if(|a| matches!(a.values, Values::Numbers { .. })) {
                    if let Values::Numbers { values, .. } = arg.values {
                        call.numbers_span = if call.numbers.is_empty() { arg.span } else { call.numbers_span.to(arg.span) };
                        call.numbers.extend(values);
                    }
                }
                if call.numbers.len() != count {
                    if !faulty {
                        let message = format!("`{word}` takes {count} numbers, found {}", call.numbers.len());
                        let help = foreign::count(word, &call.numbers).unwrap_or_default();
                        self.error("wrong-count", message, call.numbers_span, "", help);
                    }
                    return None;
                }
            }
            Takes::Name | Takes::NameAndParams | Takes::NameAndNumber => match args.peek().map(|a| &a.values) {
                Some(Values::Strings(texts)) if texts.len() == 1 => {
                    if let Some(Values::Strings(mut texts)) = args.next().map(|a| a.values) {
                        call.name = texts.pop()?;
                    }
                }
                _ => {
                    if !faulty {
                        let help = format!("such as {word} \"{}\"", directives::example_name(word));
                        self.error("missing-name", format!("`{word}` needs a name"), keyword.span, "", help);
                    }
                    return None;
                }
            },
            Takes::TextureAndParams => {
                let texts: Vec<Spanned<String>> = std::iter::from_fn(|| {
                    let one_text = |a: &Arg| matches!(&a.values, Values::Strings(texts) if texts.len() == 1);
                    match args.next_if(one_text)?.values {
                        Values::Strings(mut texts) => texts.pop(),
                        _ => None,
                    }
                })
                .take(3)
                .collect();
                match <[Spanned<String>; 3]>::try_from(texts) {
                    Ok([name, kind, plugin]) => (call.name, call.more) = (name, Some([kind, plugin])),
                    Err(texts) => {
                        if !faulty {
                            let message = format!("`{word}` needs a name, a type and a class, found {}", texts.len());
                            let help = format!("such as {word} \"{}\"", directives::example_name(word));
                            self.error("missing-name", message, keyword.span, "", help);
                        }
                        return None;
                    }
                }
            }
        }

        if row.takes == Takes::NameAndNumber {
            match args.next().map(|arg| arg.values) {
                Some(Values::Numbers { values, .. }) if values.len() == 1 => call.numbers = values,
                _ => {
                    if !faulty {
                        let help = format!("such as {word} \"{}\" 2.5", directives::example_name(word));
                        self.error("missing-value", format!("`{word}` needs a number after the name"), call.name.span, "", help);
                    }
                    return None;
                }
            }
        }

        // What it does not take.
        if let Some(extra) = args.next().filter(|_| !faulty) {
            let (help, is_declaration) = match &extra.values {
                Values::Strings(texts) => match texts.first().map(|t| t.value.split(' ').collect::<Vec<_>>()) {
                    Some(words) if words.len() == 2 && args.peek().is_some() => {
                        let types = ParamType::ALL.map(ParamType::word);
                        let near = foreign::type_word(words[0]).or_else(|| did_you_mean(words[0], types));
                        (near.map(|near| format!("did you mean \"{near} {}\"?", words[1])), true)
                    }
                    Some(words) if words.len() == 1 => {
                        let help = format!(
                            "a parameter's type stands before its name, such as \"float {}\", and its value behind",
                            words[0]
                        );
                        (Some(help), false)
                    }
                    _ => (Some("a parameter is written \"type name\" and its value".to_owned()), false),
                },
                _ => (None, false),
            };
            let message = match is_declaration {
                true => "unknown type of a parameter".to_owned(),
                false => format!("`{word}` does not take {} here", extra.values.describe()),
            };
            self.found.push(Diagnostic::error("stray", message).at(extra.span, "").maybe_help(help));
            call.faulty = true;
        }
        if !matches!(row.takes, Takes::Params | Takes::NameAndParams | Takes::TextureAndParams)
            && let Some(first) = call.params.first()
        {
            let span = first.ty.span.to(first.span);
            self.error("stray", format!("`{word}` takes no parameters"), span, "", "remove it");
        }
        Some(call)
    }
}
