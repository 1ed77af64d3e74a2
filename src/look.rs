//! How a picture is shown, as scenes, the command line and the headers of EXR files say it.

use bhs_colour::{D65_KELVIN, TEMPERATURES, ToneCurve};
use bhs_core::camera;
use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

/// How a picture is shown.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// Brightness.
    pub exposure: Exposure,
    /// What becomes of what is brighter than a screen.
    pub curve: ToneCurve,
    /// What is white.
    pub white: White,
    /// Radius of the glare of an aperture (pixels, at 550 nm); 0: none.
    pub bloom: f64,
    /// Bits of a colour's part in a PNG file.
    pub bits: Bits,
}

impl From<camera::Look> for Look {
    fn from(film: camera::Look) -> Self {
        let camera::Look { exposure, curve, bloom } = film;
        Self { exposure: Exposure::Stops(exposure), curve: ToneCurve::find(curve).unwrap_or_default(), bloom, ..Self::default() }
    }
}

impl Look {
    /// As words, by the names that EXR files give them after `bhs:`.
    pub fn words(&self) -> BTreeMap<&'static str, String> {
        BTreeMap::from([
            ("exposure", self.exposure.to_string()),
            ("tonecurve", self.curve.name().to_owned()),
            ("white", self.white.to_string()),
            ("bloom", self.bloom.to_string()),
            ("bits", self.bits.to_string()),
        ])
    }

    /// From these words; what is missing, or makes no sense, is as if nothing was said.
    pub fn of_words(word: impl Fn(&str) -> Option<String>) -> Self {
        fn said<T: FromStr + Default>(word: Option<String>) -> T {
            word.and_then(|word| word.parse().ok()).unwrap_or_default()
        }
        Self {
            exposure: said(word("exposure")),
            curve: word("tonecurve").and_then(|name| ToneCurve::find(&name)).unwrap_or_default(),
            white: said(word("white")),
            bloom: word("bloom").and_then(|x| x.parse().ok()).filter(|x| (0.0..=1000.0).contains(x)).unwrap_or_default(),
            bits: said(word("bits")),
        }
    }
}

/// What is changed of a look.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LookChanges {
    /// Brightness.
    pub exposure: Option<Exposure>,
    /// What becomes of what is brighter than a screen.
    pub curve: Option<ToneCurve>,
    /// What is white.
    pub white: Option<White>,
    /// Radius of the glare.
    pub bloom: Option<f64>,
    /// Bits of a colour's part.
    pub bits: Option<Bits>,
}

impl LookChanges {
    /// How a picture is shown then that says `own` of itself.
    pub fn over(&self, own: Look) -> Look {
        Look {
            exposure: self.exposure.unwrap_or(own.exposure),
            curve: self.curve.unwrap_or(own.curve),
            white: self.white.unwrap_or(own.white),
            bloom: self.bloom.unwrap_or(own.bloom),
            bits: self.bits.unwrap_or(own.bits),
        }
    }
}

/// Brightness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// Stops: powers of two.
    Stops(f64),
    /// As the picture's own brightness asks for.
    Auto,
}

/// Greatest exposure either way (stops).
const MOST_STOPS: f64 = 64.0;

impl Default for Exposure {
    fn default() -> Self {
        Self::Stops(0.0)
    }
}

impl FromStr for Exposure {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse::<f64>() {
            _ if text == "auto" => Ok(Self::Auto),
            Ok(stops) if stops.abs() <= MOST_STOPS => Ok(Self::Stops(stops)),
            _ => Err(format!("expected a number of stops from -{MOST_STOPS} to {MOST_STOPS}, such as -1.5, or `auto`")),
        }
    }
}

impl fmt::Display for Exposure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Stops(stops) => write!(f, "{stops}"),
            Self::Auto => f.write_str("auto"),
        }
    }
}

/// What is white in a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum White {
    /// Light of a temperature (K): a phase of daylight from 4000 K on, below that of a black body.
    Kelvin(f64),
    /// The mean colour of the picture.
    Auto,
}

impl Default for White {
    fn default() -> Self {
        Self::Kelvin(D65_KELVIN)
    }
}

impl FromStr for White {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let [lo, hi] = TEMPERATURES;
        match text.parse::<f64>() {
            _ if text == "auto" => Ok(Self::Auto),
            Ok(kelvin) if (lo..=hi).contains(&kelvin) => Ok(Self::Kelvin(kelvin)),
            _ => {
                Err(format!("expected a temperature from {lo} to {hi} K, such as 3200, or `auto`; {D65_KELVIN} changes nothing"))
            }
        }
    }
}

impl fmt::Display for White {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Self::Kelvin(kelvin) => write!(f, "{kelvin}"),
            Self::Auto => f.write_str("auto"),
        }
    }
}

/// The tone curve of this name.
///
/// # Errors
/// What there is.
pub fn tone_curve(text: &str) -> Result<ToneCurve, String> {
    ToneCurve::find(text).ok_or_else(|| format!("expected {}", ToneCurve::ALL.map(ToneCurve::name).join(", ")))
}

/// A radius of glare (pixels).
///
/// # Errors
/// What is expected.
pub fn bloom(text: &str) -> Result<f64, String> {
    let radius = text.parse::<f64>().ok().filter(|radius| (0.0..=1000.0).contains(radius));
    radius.ok_or_else(|| "expected a radius from 0 to 1000 pixels, such as 1.5".to_owned())
}

/// Bits of a colour's part in a PNG file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bits {
    /// 8.
    #[default]
    Eight,
    /// 16.
    Sixteen,
}

impl FromStr for Bits {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "8" => Ok(Self::Eight),
            "16" => Ok(Self::Sixteen),
            _ => Err("expected 8 or 16".to_owned()),
        }
    }
}

impl fmt::Display for Bits {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(if *self == Self::Eight { "8" } else { "16" })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_go_there_and_back_and_nonsense_is_refused() {
        for word in ["auto", "-2", "0.5", "64"] {
            assert_eq!(word.parse::<Exposure>().map(|e| e.to_string()).as_deref(), Ok(word));
        }
        for word in ["auto", "6504", "2856.5"] {
            assert_eq!(word.parse::<White>().map(|e| e.to_string()).as_deref(), Ok(word));
        }
        for word in ["", "NaN", "inf", "65", "-1e3", "Auto", "2 stops"] {
            word.parse::<Exposure>().expect_err("no exposure");
        }
        for word in ["", "NaN", "0", "-6504", "1e9", "warm"] {
            word.parse::<White>().expect_err("no temperature");
        }
    }
}
