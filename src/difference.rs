//! Where two pictures differ: as pictures of the differences.

use crate::colour_map::{MAGMA, colour};
use crate::flip;
use crate::image::{self, Picture};
use anyhow::{Result, bail};
use std::io::Write;
use std::path::{Path, PathBuf};

/// The differences of a picture from a reference, a number a pixel, row by row from the top.
pub struct Difference {
    /// Width and height (pixels).
    pub size: [usize; 2],
    /// FLIP, from 0 to 1: how much it catches the eye.
    pub flip: Vec<f32>,
    /// The root of the mean over red, green and blue of squared difference over squared reference, with 1e-2 of the reference's mean square added below.
    pub relative: Vec<f32>,
}

impl Difference {
    /// That of `a` from the reference `b`, of the same size; `None` where one of them has no red, green and blue.
    pub fn new(a: &Picture, b: &Picture) -> Option<Self> {
        let [test, reference] = [colours(a)?, colours(b)?];
        let square = |v: &f32| f64::from(*v) * f64::from(*v);
        let power = reference.as_flattened().iter().map(square).sum::<f64>() / (3 * reference.len()).max(1) as f64;
        let floor = (1e-2 * power).max(f64::MIN_POSITIVE);
        let relative = test.iter().zip(&reference).map(|(a, b)| {
            let sum: f64 = a.iter().zip(b).map(|(x, y)| (f64::from(*x) - f64::from(*y)).powi(2) / (square(y) + floor)).sum();
            (sum / 3.0).sqrt() as f32
        });
        Some(Self { size: a.size, relative: relative.collect(), flip: flip::hdr(a.size, &test, &reference) })
    }

    /// The mean of FLIP.
    pub fn mean_flip(&self) -> f64 {
        self.flip.iter().map(|v| f64::from(*v)).sum::<f64>() / self.flip.len().max(1) as f64
    }

    /// Writes some of the numbers as PNG, from black for 0 to light yellow for 1; `said` is what they are.
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn write_png(&self, to: impl Write, numbers: &[f32], said: &str) -> Result<()> {
        let texts = [
            ("Software", concat!("bhs ", env!("CARGO_PKG_VERSION")).to_owned()),
            ("Description", format!("{said}, from 0 (black) to 1 (light yellow)")),
        ];
        image::write_rows(to, self.size, false, &texts, |y, row| {
            numbers[y * self.size[0]..][..self.size[0]].iter().for_each(|v| row.extend(colour(&MAGMA, f64::from(*v))));
        })
    }
}

/// The file of the relative error beside that of FLIP.
pub fn relative_path(flip: &Path) -> PathBuf {
    flip.with_extension("relative.png")
}

/// Red, green and blue of all pixels.
fn colours(picture: &Picture) -> Option<Vec<[f32; 3]>> {
    let position = |name: &str| picture.channels.iter().position(|c| c == name);
    let [r, g, b] = [position("R")?, position("G")?, position("B")?];
    Some(picture.data.chunks_exact(picture.channels.len()).map(|p| [p[r], p[g], p[b]]).collect())
}

/// Makes sure that pictures of differences can be made.
///
/// # Errors
/// Says why not.
pub fn check(difference: Option<&Difference>) -> Result<&Difference> {
    match difference {
        Some(difference) => Ok(difference),
        None => bail!("--diff shows how colours differ, and one of the pictures has no R, G and B"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::Frame;

    #[test]
    fn relative_errors_are_those_of_the_channels() {
        let picture = |data: &[f32]| {
            let size = [data.len() / 3, 1];
            Picture {
                size,
                frame: Frame { offset: [0, 0], size },
                channels: ["G", "B", "R"].map(str::to_owned).to_vec(),
                data: data.to_vec(),
            }
        };
        let (a, b) = (picture(&[1.1, 1.0, 1.0, 0.0, 0.0, 0.0]), picture(&[1.0, 1.0, 1.0, 0.0, 0.0, 0.0]));
        let found = Difference::new(&a, &b).expect("colours");
        // 1e-2 of a mean square of one half.
        assert!(
            (f64::from(found.relative[0]) - (0.01 / 1.005 / 3.0f64).sqrt()).abs() < 1e-6 && found.relative[1] == 0.0,
            "{:?}",
            found.relative
        );
        assert!(found.flip[0] > 0.0 && found.mean_flip() > 0.0);
    }
}
