//! The Rust types that parameters are read as.

use crate::diagnostics::Spanned;
use crate::value::{ParamType, Values};
use glam::{DVec2, DVec3};

/// A place, as `"point3 name" [x y z]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point3(pub DVec3);

/// A direction, as `"vector3 name" [x y z]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vector3(pub DVec3);

/// A surface normal, as `"normal name" [x y z]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Normal3(pub DVec3);

/// A pair, as `"point2 name" [x y]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point2(pub DVec2);

/// A Rust type that a parameter can be read as.
pub trait FromParam: Sized {
    /// The type words that are accepted, the proper one first.
    const TYPES: &'static [ParamType];
    /// Reads the values.
    ///
    /// # Errors
    /// What was expected, in words such as `an integer`.
    fn read(values: &Values) -> Result<Self, String>;
    /// The value as a scene would state it, for the parameter tables.
    fn show(&self) -> String;
}

fn numbers(values: &Values) -> Option<&[f64]> {
    match values {
        Values::Numbers { values, .. } => Some(values),
        _ => None,
    }
}

impl FromParam for f64 {
    const TYPES: &'static [ParamType] = &[ParamType::Float];
    fn read(values: &Values) -> Result<Self, String> {
        match numbers(values) {
            Some([x]) => Ok(*x),
            _ => Err("a number".into()),
        }
    }
    fn show(&self) -> String {
        // Not hundreds of digits.
        let size = self.abs();
        if size >= 1e15 || (size > 0.0 && size < 1e-6) { format!("{self:e}") } else { format!("{self}") }
    }
}

impl FromParam for i64 {
    const TYPES: &'static [ParamType] = &[ParamType::Integer];
    fn read(values: &Values) -> Result<Self, String> {
        match values {
            Values::Numbers { values, whole: true } if values.len() == 1 => Ok(values[0] as i64),
            _ => Err("an integer".into()),
        }
    }
    fn show(&self) -> String {
        format!("{self}")
    }
}

impl FromParam for bool {
    const TYPES: &'static [ParamType] = &[ParamType::Bool];
    fn read(values: &Values) -> Result<Self, String> {
        match values {
            Values::Bools(b) if b.len() == 1 => Ok(b[0]),
            _ => Err("`true` or `false`".into()),
        }
    }
    fn show(&self) -> String {
        format!("{self}")
    }
}

impl FromParam for String {
    const TYPES: &'static [ParamType] = &[ParamType::String];
    fn read(values: &Values) -> Result<Self, String> {
        match values {
            Values::Strings(s) if s.len() == 1 => Ok(s[0].value.clone()),
            _ => Err("a string".into()),
        }
    }
    fn show(&self) -> String {
        format!("\"{self}\"")
    }
}

impl FromParam for Vec<Spanned<String>> {
    const TYPES: &'static [ParamType] = &[ParamType::String];
    fn read(values: &Values) -> Result<Self, String> {
        match values {
            Values::Strings(s) => Ok(s.clone()),
            _ => Err("strings".into()),
        }
    }
    fn show(&self) -> String {
        format!("[{}]", self.iter().map(|s| format!("\"{}\"", s.value)).collect::<Vec<_>>().join(" "))
    }
}

impl FromParam for Vec<f64> {
    const TYPES: &'static [ParamType] = &[ParamType::Float];
    fn read(values: &Values) -> Result<Self, String> {
        numbers(values).map(<[f64]>::to_vec).ok_or_else(|| "numbers".into())
    }
    fn show(&self) -> String {
        format!("[{}]", self.iter().map(f64::to_string).collect::<Vec<_>>().join(" "))
    }
}

impl FromParam for Vec<i64> {
    const TYPES: &'static [ParamType] = &[ParamType::Integer];
    fn read(values: &Values) -> Result<Self, String> {
        match values {
            Values::Numbers { values, whole: true } => Ok(values.iter().map(|v| *v as i64).collect()),
            _ => Err("integers".into()),
        }
    }
    fn show(&self) -> String {
        format!("[{}]", self.iter().map(i64::to_string).collect::<Vec<_>>().join(" "))
    }
}

macro_rules! tuple_param {
    ($name:ident, $ty:expr, $n:literal, $vec:ident, $one:literal, $many:literal) => {
        impl FromParam for $name {
            const TYPES: &'static [ParamType] = &[$ty];
            fn read(values: &Values) -> Result<Self, String> {
                match numbers(values) {
                    Some(v) if v.len() == $n => Ok($name($vec::from_slice(v))),
                    _ => Err($one.into()),
                }
            }
            fn show(&self) -> String {
                self.0.to_array().to_vec().show()
            }
        }
        impl FromParam for Vec<$name> {
            const TYPES: &'static [ParamType] = &[$ty];
            fn read(values: &Values) -> Result<Self, String> {
                match numbers(values) {
                    Some(v) if v.len() % $n == 0 => Ok(v.chunks_exact($n).map(|c| $name($vec::from_slice(c))).collect()),
                    _ => Err($many.into()),
                }
            }
            fn show(&self) -> String {
                self.iter().flat_map(|p| p.0.to_array()).collect::<Vec<f64>>().show()
            }
        }
    };
}
tuple_param!(Point2, ParamType::Point2, 2, DVec2, "2 numbers", "a multiple of 2 numbers");
tuple_param!(Point3, ParamType::Point3, 3, DVec3, "3 numbers", "a multiple of 3 numbers");
tuple_param!(Vector3, ParamType::Vector3, 3, DVec3, "3 numbers", "a multiple of 3 numbers");
tuple_param!(Normal3, ParamType::Normal, 3, DVec3, "3 numbers", "a multiple of 3 numbers");
