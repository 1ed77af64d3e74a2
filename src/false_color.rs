//! Layers as pictures that a person can look at.
//!
//! A number becomes a colour of viridis, from dark blue at the data's 1st percentile to yellow at its 99th. A vector becomes
//! red, green and blue: positions each axis over its own range, directions from -1 to 1. What has no value is black.

use crate::colour_map::{VIRIDIS, colour};
use crate::layers::LayerPicture;
use bhs_engine::layer::{Display, Value};
use std::path::{Path, PathBuf};

/// Shares of the values that lie below and above the range of the colours.
const TAIL: f64 = 0.01;

/// A layer with the range of its values that the colours show.
pub struct FalseColor<'p> {
    picture: &'p LayerPicture,
    /// Least and greatest shown value of each channel, in the layer's unit; `None` if no pixel has a value.
    ranges: Option<[[f64; 2]; 3]>,
}

impl<'p> FalseColor<'p> {
    /// Finds the range.
    pub fn new(picture: &'p LayerPicture) -> Self {
        let fixed = match picture.format.display {
            Display::Range(range) => Some(range),
            Display::Reflectance => Some([0.0, 1.0]),
            Display::Spread => None,
        };
        let valued: Vec<&Value> = picture.values.iter().flatten().collect();
        let channel = |c: usize| fixed.unwrap_or_else(|| percentiles(valued.iter().map(|v| v[c]).collect()));
        let ranges = (!valued.is_empty()).then(|| std::array::from_fn(channel));
        Self { picture, ranges }
    }

    /// The colours of all pixels, sRGB, row by row from the top.
    pub fn pixels(&self) -> Vec<[u8; 3]> {
        self.picture.values.iter().map(|value| value.map_or([0; 3], |v| self.color(v))).collect()
    }

    fn color(&self, value: Value) -> [u8; 3] {
        let Some(ranges) = self.ranges else { return [0; 3] };
        let share = |c: usize| {
            let ([lo, hi], v): ([f64; 2], f64) = (ranges[c], value[c]);
            if hi > lo { ((v - lo) / (hi - lo)).clamp(0.0, 1.0) } else { 0.5 }
        };
        let byte = |x: f64| (255.0 * x + 0.5) as u8;
        let format = &self.picture.format;
        match format.display {
            _ if format.channels.len() == 1 => colour(&VIRIDIS, share(0)),
            // Reflectances are light; the others are numbers.
            Display::Reflectance => std::array::from_fn(|c| byte(f64::from(bhs_colour::srgb_encode(share(c) as f32)))),
            _ => std::array::from_fn(|c| byte(share(c))),
        }
    }
}

/// What the colours mean, in words.
impl std::fmt::Display for FalseColor<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let LayerPicture { name, format, .. } = self.picture;
        let Some(ranges) = self.ranges else { return write!(f, "{name}: no pixel has a value") };
        let unit = match format.unit {
            "" => String::new(),
            "scene" => " scene units".to_owned(),
            "scene^2" => " square scene units".to_owned(),
            unit => format!(" {unit}"),
        };
        let colors = if format.channels.len() == 1 { "dark blue to yellow" } else { "red, green, blue" };
        let shown: Vec<String> = ranges[..format.channels.len()].iter().map(|[lo, hi]| format!("{lo:.6} to {hi:.6}")).collect();
        write!(f, "{name}: {}{unit} ({colors})", shown.join(", "))
    }
}

/// The file of the layer called `name` beside the picture `exr`: `<stem>.<layer>.png`.
pub fn path(exr: &Path, name: &str) -> PathBuf {
    exr.with_extension(format!("{name}.png"))
}

/// The 1st and the 99th percentile of some numbers, at least one.
fn percentiles(mut values: Vec<f64>) -> [f64; 2] {
    values.sort_by(f64::total_cmp);
    let last = values.len() - 1;
    [TAIL, 1.0 - TAIL].map(|p| values[(p * last as f64).round() as usize])
}

#[cfg(test)]
mod tests {
    use super::*;
    use bhs_engine::layer::LayerFormat;

    const SWEPT_ANGLE: (&str, LayerFormat) = ("sweptangle", LayerFormat::new(&["sweptangle"], "rad"));
    const WINDING: (&str, LayerFormat) = ("winding", LayerFormat::new(&["winding"], ""));
    const NORMAL: (&str, LayerFormat) =
        ("normal", LayerFormat::new(&["N.X", "N.Y", "N.Z"], "").shown(Display::Range([-1.0, 1.0])));

    fn colors((name, format): (&'static str, LayerFormat), values: Vec<Option<Value>>) -> (Vec<[u8; 3]>, String) {
        let picture = LayerPicture { name, format, values };
        let shown = FalseColor::new(&picture);
        (shown.pixels(), shown.to_string())
    }

    #[test]
    fn numbers_run_from_dark_blue_to_yellow_and_outliers_do_not_stretch_them() {
        let mut values: Vec<Option<Value>> = (0..=200).map(|i| Some([f64::from(i), 0.0, 0.0])).collect();
        values[200] = Some([1e9, 0.0, 0.0]);
        values.push(None);
        let (pixels, said) = colors(SWEPT_ANGLE, values);
        assert_eq!((pixels[0], pixels[199], pixels[200], pixels[201]), (VIRIDIS[0], VIRIDIS[9], VIRIDIS[9], [0; 3]));
        assert!(pixels[100][1] > pixels[50][1] && pixels[150][1] > pixels[100][1], "green grows along viridis");
        assert_eq!(said, "sweptangle: 2.000000 to 198.000000 rad (dark blue to yellow)");
    }

    #[test]
    fn constant_and_empty_layers_have_colours_too() {
        assert_eq!(colors(WINDING, vec![Some([3.0; 3]); 4]).0, vec![colour(&VIRIDIS, 0.5); 4]);
        assert_eq!(colors(WINDING, vec![None]), (vec![[0; 3]], "winding: no pixel has a value".to_owned()));
    }

    #[test]
    fn directions_are_red_green_and_blue() {
        assert_eq!(colors(NORMAL, vec![Some([1.0, -1.0, 0.0])]).0, [[255, 0, 128]]);
    }
}
