//! Better help for what newcomers write: the words of other renderers, values of another type than was meant.

use crate::glossary;
use crate::lang::description::Entity;
use bhs_core::diagnostics::Diagnostic;
use bhs_core::params::ParamInfo;
use bhs_core::value::{Param, ParamType, Values};
use bhs_elementary::Elementary;

/// Endings of files that hold pictures.
const PICTURES: [&str; 8] = [".png", ".jpg", ".jpeg", ".exr", ".hdr", ".tga", ".tif", ".bmp"];

/// Says more about what is wrong with the parameters of a directive, which asked for `asked`.
pub fn advise(found: &mut [Diagnostic], entity: &Entity, asked: &[ParamInfo]) {
    for d in found {
        let Some(at) = d.primary.as_ref().map(|primary| primary.span) else { continue };
        let by = |place: fn(&Param) -> bhs_core::diagnostics::Span| entity.params.iter().find(|p| place(p) == at);
        let help = match d.code {
            "unknown-parameter" => by(|p| p.name.span).and_then(|p| {
                let taken: Vec<&str> = asked.iter().map(|a| a.name).collect();
                glossary::parameter(&p.name.value, &taken)
            }),
            "wrong-type" => by(|p| p.ty.span).and_then(|p| other_type(p, asked)),
            "wrong-value" => by(|p| p.span).and_then(|p| other_value(p, asked)),
            "bad-value" => by(|p| p.span).and_then(|p| in_nanometres(p).or_else(|| of_bytes(p))),
            "unreadable-file" | "bad-file" => {
                let names_picture = |p: &&Param| p.ty.value == ParamType::Spectrum && picture(p).is_some();
                entity
                    .params
                    .iter()
                    .filter(names_picture)
                    .find(|p| p.span.start <= at.start && at.end <= p.span.end)
                    .and_then(textured)
            }
            _ => None,
        };
        // A word that is only misspelt stays so.
        let same = |near: &String| {
            near.starts_with("did you mean") && help.as_ref().is_some_and(|h| near.split('`').nth(1) == h.split('`').nth(1))
        };
        if !d.help.as_ref().is_some_and(same) {
            d.help = help.or_else(|| d.help.take());
        }
    }
}

/// Help for a limit of the film that is in other units.
fn in_nanometres(param: &Param) -> Option<String> {
    let Values::Numbers { values, .. } = &param.values else { return None };
    let is_limit = matches!(param.name.value.as_str(), "lambdamin" | "lambdamax") && values.len() == 1;
    let in_nm =
        values.first().filter(|x| is_limit && (0.0..1.0).contains(*x)).map(|x| if *x < 1e-3 { x * 1e9 } else { x * 1e3 })?;
    Some(format!("wavelengths are in nm: write {:.0}", in_nm))
}

/// Linear light of a colour whose channels are written from 0 to 255, encoded as in sRGB.
fn linear(bytes: [f64; 3]) -> String {
    let one = |c: f64| {
        let c = c / 255.0;
        let linear = if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).power(2.4) };
        (linear * 1000.0).round() / 1000.0
    };
    let [r, g, b] = bytes.map(one);
    format!("[{r} {g} {b}]")
}

/// Help for a colour whose channels go to 255.
fn of_bytes(param: &Param) -> Option<String> {
    let Values::Numbers { values, .. } = &param.values else { return None };
    let &[r, g, b] = values.as_slice() else { return None };
    let are_bytes =
        param.ty.value == ParamType::Rgb && values.iter().all(|c| (0.0..=255.0).contains(c)) && values.iter().any(|c| *c > 1.0);
    are_bytes.then(|| {
        format!("colours are linear, from 0 to 1: as 8 bits of sRGB that is \"rgb {}\" {}", param.name.value, linear([r, g, b]))
    })
}

/// Help for a colour that is written as text.
fn color_text(name: &str, text: &str) -> String {
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6 && digits.is_ascii());
    let byte = |i: usize| digits.and_then(|digits| u8::from_str_radix(&digits[i..i + 2], 16).ok()).map(f64::from);
    match (byte(0), byte(2), byte(4)) {
        (Some(r), Some(g), Some(b)) => format!("a colour is three numbers of linear light: \"rgb {name}\" {}", linear([r, g, b])),
        _ => format!("a colour is three numbers from 0 to 1: \"rgb {name}\" [0.8 0.1 0.1] is a red"),
    }
}

/// The types that a parameter may have, as its table says.
fn types<'a>(param: &Param, asked: &'a [ParamInfo]) -> &'a str {
    asked.iter().find(|a| a.name == param.name.value).map_or("", |a| a.ty)
}

/// The picture that a parameter names, if it is one.
fn picture(param: &Param) -> Option<&str> {
    let Values::Strings(texts) = &param.values else { return None };
    let name = texts.first()?.value.as_str();
    let ending = name.to_lowercase();
    PICTURES.iter().any(|picture| ending.ends_with(picture)).then_some(name)
}

/// How a parameter gets a picture.
fn textured(param: &Param) -> Option<String> {
    let (name, picture) = (&param.name.value, picture(param)?);
    Some(format!(
        "a picture is a texture: write Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"{picture}\", then \"texture {name}\" \"t\""
    ))
}

/// Help for a parameter of another type.
fn other_type(param: &Param, asked: &[ParamInfo]) -> Option<String> {
    let (name, types) = (&param.name.value, types(param, asked));
    let takes_spectrum = types.contains("spectrum");
    match (&param.values, param.ty.value) {
        (Values::Strings(_), ParamType::String) if takes_spectrum && picture(param).is_some() => textured(param),
        (Values::Strings(_), ParamType::String) if takes_spectrum => {
            let texture = if types.contains("texture") { format!(", of a texture \"texture {name}\"") } else { String::new() };
            Some(format!("the name of a spectrum is written \"spectrum {name}\"{texture}"))
        }
        (Values::Numbers { values, .. }, _) if takes_spectrum && values.len() == 3 => {
            Some(format!("a colour is written \"rgb {name}\""))
        }
        (Values::Numbers { values, .. }, ParamType::Rgb) if types.starts_with("float") && values.len() == 3 => {
            Some(format!("`{name}` is one number: write \"float {name}\" {}", values[0]))
        }
        _ => None,
    }
}

/// Help for values that do not fit the type.
fn other_value(param: &Param, asked: &[ParamInfo]) -> Option<String> {
    let (name, types) = (&param.name.value, types(param, asked));
    let ty = param.ty.value.word();
    match &param.values {
        Values::Strings(texts) if texts.len() == 1 && texts[0].value.trim().parse::<f64>().is_ok() => {
            Some(format!("numbers stand without quotes: \"{ty} {name}\" {}", texts[0].value.trim()))
        }
        Values::Strings(_) if param.ty.value == ParamType::Spectrum => textured(param),
        Values::Strings(texts) if param.ty.value == ParamType::Rgb && texts.len() == 1 => {
            Some(textured(param).unwrap_or_else(|| color_text(name, &texts[0].value)))
        }
        Values::Strings(texts) if param.ty.value == ParamType::Bool && texts.len() == 1 => {
            let is_yes = ["yes", "on", "1", "True", "TRUE"].contains(&texts[0].value.as_str());
            Some(format!("write \"bool {name}\" {is_yes}"))
        }
        Values::Numbers { values, .. } if param.ty.value == ParamType::Blackbody && values.len() == 2 => Some(format!(
            "the second number of pbrt-v3 is a parameter of its own: \"blackbody {name}\" {} \"float scale\" {}",
            values[0], values[1]
        )),
        Values::Numbers { values, .. }
            if types.contains("spectrum")
                && param.ty.value == ParamType::Spectrum
                && values.len() == 3
                && values.iter().all(|c| *c < 100.0) =>
        {
            let [r, g, b] = [values[0], values[1], values[2]];
            Some(format!("three numbers are a colour: write \"rgb {name}\" [{r} {g} {b}]"))
        }
        Values::Numbers { values, .. } if param.ty.value == ParamType::Rgb && values.len() == 1 => {
            let all = values[0];
            Some(format!(
                "a colour has three numbers in brackets: \"rgb {name}\" [{all} {all} {all}]; one number is \"spectrum {name}\" {all}"
            ))
        }
        Values::Numbers { values, .. } if param.ty.value == ParamType::Rgb && values.len() == 4 => {
            Some("a colour has no alpha: leave out the fourth number".to_owned())
        }
        Values::Numbers { values, .. } if param.ty.value == ParamType::Rgb && values.is_empty() => None,
        Values::Numbers { values, whole: false } if param.ty.value == ParamType::Integer && values.len() == 1 => {
            let whole = values[0].round();
            Some(format!("an integer has no point: write \"integer {name}\" {whole}"))
        }
        Values::Numbers { values, .. } if param.ty.value == ParamType::String && values.len() == 1 => {
            Some(format!("text stands in quotes: \"string {name}\" \"{}\"", values[0]))
        }
        Values::Numbers { values, .. } if param.ty.value == ParamType::Bool && values.len() == 1 => {
            Some(format!("write \"bool {name}\" {}", values[0] != 0.0))
        }
        Values::Bools(bools) if types == "bool" && param.ty.value != ParamType::Bool && bools.len() == 1 => {
            Some(format!("write \"bool {name}\" {}", bools[0]))
        }
        _ => None,
    }
}
