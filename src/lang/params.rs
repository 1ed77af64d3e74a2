//! Directives taken apart and put together.

use crate::lang::ast::{Arg, Directive};
use bhs_core::diagnostics::{Span, Spanned};
use bhs_core::value::{Param, ParamType, Values};

/// The text number `i` behind the word of a directive.
pub(super) fn text(d: &Directive, i: usize) -> Option<&Spanned<String>> {
    match &d.args.get(i)?.values {
        Values::Strings(texts) if texts.len() == 1 => texts.first(),
        _ => None,
    }
}

/// The plugin that a directive names; empty if it names none.
pub(super) fn name(d: &Directive) -> &str {
    text(d, 0).map_or("", |t| &t.value)
}

/// Puts another text in place of text number `i`.
pub(super) fn set_text(d: &mut Directive, i: usize, to: &str) {
    if let Some(Values::Strings(texts)) = d.args.get_mut(i).map(|a| &mut a.values)
        && let Some(text) = texts.first_mut()
    {
        to.clone_into(&mut text.value);
    }
}

/// A directive that the file does not state: it stands where `span` does.
pub(super) fn directive(word: &str, span: Span) -> Directive {
    Directive { span, ..Directive::new(Spanned::new(word.to_owned(), span)) }
}

/// The same with a text behind it.
pub(super) fn named(word: &str, name: &str, span: Span) -> Directive {
    let values = Values::Strings(vec![Spanned::new(name.to_owned(), span)]);
    Directive { args: vec![Arg { values, span }], ..directive(word, span) }
}

/// Sixteen numbers, or as many as there are, behind the word of a directive.
pub(super) fn numbers(d: &Directive) -> Vec<f64> {
    let of = |a: &Arg| match &a.values {
        Values::Numbers { values, .. } => values.clone(),
        _ => Vec::new(),
    };
    d.args.iter().flat_map(of).collect()
}

/// A parameter by its name.
pub(super) fn find<'d>(d: &'d Directive, name: &str) -> Option<&'d Param> {
    d.params.iter().find(|p| p.name.value == name)
}

/// A parameter by its name, which is taken out.
pub(super) fn take(d: &mut Directive, name: &str) -> Option<Param> {
    let at = d.params.iter().position(|p| p.name.value == name)?;
    Some(d.params.remove(at))
}

/// Takes parameters out; whether there were any.
pub(super) fn drop_all(d: &mut Directive, names: &[&str]) -> bool {
    let before = d.params.len();
    d.params.retain(|p| !names.contains(&p.name.value.as_str()));
    d.params.len() < before
}

/// The one number of a parameter.
pub(super) fn number(p: &Param) -> Option<f64> {
    match &p.values {
        Values::Numbers { values, .. } if values.len() == 1 => values.first().copied(),
        _ => None,
    }
}

/// The one number of the parameter `name`; `None` where it is not given, or is no number.
pub(super) fn float(d: &Directive, name: &str) -> Option<f64> {
    find(d, name).filter(|p| matches!(p.ty.value, ParamType::Float | ParamType::Integer)).and_then(number)
}

/// The number of the parameter `name`, which is taken out if it is one: what is at fault stays, to be reported.
pub(super) fn take_float(d: &mut Directive, name: &str) -> Option<f64> {
    let value = float(d, name)?;
    take(d, name);
    Some(value)
}

/// The one text of the parameter `name`.
pub(super) fn string<'d>(d: &'d Directive, name: &str) -> Option<&'d Spanned<String>> {
    string_of(&d.params, name)
}

/// The same of a list of parameters.
pub(super) fn string_of<'p>(params: &'p [Param], name: &str) -> Option<&'p Spanned<String>> {
    match &params.iter().find(|p| p.name.value == name)?.values {
        Values::Strings(texts) if texts.len() == 1 => texts.first(),
        _ => None,
    }
}

/// The one truth value of the parameter `name`.
pub(super) fn boolean(d: &Directive, name: &str) -> Option<bool> {
    boolean_of(&d.params, name)
}

/// The same of a list of parameters.
pub(super) fn boolean_of(params: &[Param], name: &str) -> Option<bool> {
    match &params.iter().find(|p| p.name.value == name)?.values {
        Values::Bools(values) if values.len() == 1 => values.first().copied(),
        _ => None,
    }
}

/// Puts a parameter in place of one of the same name.
pub(super) fn set(d: &mut Directive, ty: ParamType, name: &str, values: Values) {
    let span = find(d, name).map_or(d.keyword.span, |p| p.span);
    let name = Spanned::new(name.to_owned(), span);
    let new = Param { ty: Spanned::new(ty, span), name, values, span };
    match d.params.iter_mut().find(|p| p.name.value == new.name.value) {
        Some(old) => *old = new,
        None => d.params.push(new),
    }
}

/// The same with numbers.
pub(super) fn set_floats(d: &mut Directive, name: &str, values: &[f64]) {
    set(d, ParamType::Float, name, Values::Numbers { values: values.to_vec(), whole: false });
}

/// The same with texts.
pub(super) fn set_strings(d: &mut Directive, ty: ParamType, name: &str, texts: &[&str]) {
    let span = find(d, name).map_or(d.keyword.span, |p| p.span);
    set(d, ty, name, Values::Strings(texts.iter().map(|t| Spanned::new((*t).to_owned(), span)).collect()));
}

/// The same with a colour.
pub(super) fn set_rgb(d: &mut Directive, name: &str, rgb: [f64; 3]) {
    set(d, ParamType::Rgb, name, Values::Numbers { values: rgb.to_vec(), whole: false });
}

/// The name of a parameter as another one.
pub(super) fn renamed(param: &Param, to: &str) -> bhs_core::diagnostics::Spanned<String> {
    bhs_core::diagnostics::Spanned::new(to.to_owned(), param.name.span)
}
