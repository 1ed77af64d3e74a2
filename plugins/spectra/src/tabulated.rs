//! Piecewise linear functions of wavelength, looked up in constant time.

use bhs_core::diagnostics::{Diagnostic, Spanned};
use bhs_core::spectrum::{N_LAMBDA, SampledSpectrum, Spectrum};
use bhs_core::value::{Param, Values};

/// The word that a scene adds to a name or file to make the spectrum zero outside its data.
const ZERO_OUTSIDE: &str = "zero-outside";

/// The numbers of a table that belongs to this crate, row by row; lines that do not start with a number are headings.
pub fn rows<const N: usize>(text: &str) -> Vec<[f64; N]> {
    let row = |line: &str| {
        let words = line.split(|c: char| c == ',' || c.is_whitespace()).filter(|w| !w.is_empty());
        let numbers: Vec<f64> = words.map_while(|w| w.parse().ok()).collect();
        numbers.try_into().ok()
    };
    text.lines().filter_map(row).collect()
}

/// What a table does outside its data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outside {
    /// Keeps the end value.
    EndValue,
    /// Is zero.
    Zero,
}

/// The name or path in `param`, and what the scene wants outside the data: `"name"` or `["name" "zero-outside"]`.
pub fn name_and_outside(param: &Param) -> Result<(&Spanned<String>, Outside), Vec<Diagnostic>> {
    let strings: &[_] = if let Values::Strings(s) = &param.values { s } else { &[] };
    match strings {
        [name] => Ok((name, Outside::EndValue)),
        [name, word] if word.value == ZERO_OUTSIDE => Ok((name, Outside::Zero)),
        [_, word] => Err(vec![
            Diagnostic::error("wrong-value", format!("`{}` cannot follow the name of a spectrum", word.value))
                .at(word.span, format!("only `{ZERO_OUTSIDE}` can stand here")),
        ]),
        _ => Err(vec![crate::wrong_value(param, &format!("the name of a spectrum, and `{ZERO_OUTSIDE}` if wanted"))]),
    }
}

/// A piecewise linear function of wavelength (nm).
#[derive(Debug)]
pub struct Tabulated {
    /// Wavelengths (nm), not decreasing, at least one; two equal ones make a step.
    lambda_nm: Vec<f32>,
    values: Vec<f32>,
    outside: Outside,
    /// Cells per nm of the index.
    cells_per_nm: f32,
    /// For each cell of equal width, the interval in which it begins. Empty for a table with equal steps: there a cell is an
    /// interval.
    index: Vec<u32>,
}

impl Tabulated {
    /// The function through the points `(lambda_nm, value)`, of which there is at least one; wavelengths do not decrease.
    pub fn new(points: &[(f64, f64)], outside: Outside) -> Self {
        let lambda_nm: Vec<f32> = points.iter().map(|p| p.0 as f32).collect();
        let values = points.iter().map(|p| p.1 as f32).collect();
        let intervals = lambda_nm.len() - 1;
        let (first, last) = (lambda_nm[0], lambda_nm[intervals]);
        let mut table = Self { lambda_nm, values, outside, cells_per_nm: 0.0, index: Vec::new() };
        if last <= first {
            return table;
        }
        let step = (last - first) / intervals as f32;
        table.cells_per_nm = 1.0 / step;
        let nodes = || table.lambda_nm.iter().enumerate();
        if nodes().all(|(i, l)| (l - (first + step * i as f32)).abs() < 1e-5 * step) {
            return table;
        }
        // Two cells for each interval: a table with moderate changes of step needs at most a step or two from its cell.
        let cells = 2 * intervals;
        table.cells_per_nm *= 2.0;
        table.index = (0..=cells)
            .map(|c| {
                let start = first + c as f32 / table.cells_per_nm;
                table.lambda_nm.partition_point(|l| *l <= start).saturating_sub(2).min(intervals - 1) as u32
            })
            .collect();
        table
    }

    /// The first of the two points between which `lambda_nm`, which lies inside the data, falls.
    fn interval(&self, lambda_nm: f32) -> usize {
        let cell = ((lambda_nm - self.lambda_nm[0]) * self.cells_per_nm) as usize;
        let last = self.lambda_nm.len() - 2;
        if self.index.is_empty() {
            return cell.min(last);
        }
        let mut i = self.index[cell.min(self.index.len() - 1)] as usize;
        while i < last && lambda_nm >= self.lambda_nm[i + 1] {
            i += 1;
        }
        i
    }
}

impl Spectrum for Tabulated {
    fn sample(&self, lambda_nm: [f32; N_LAMBDA]) -> SampledSpectrum {
        let last = self.values.len() - 1;
        if !self.index.is_empty() || self.outside == Outside::Zero || last == 0 {
            return SampledSpectrum(lambda_nm).map(|l| self.at(l));
        }
        // Equal steps, and the end values outside: no case is left to tell apart. (What is not a number becomes the first cell's.)
        SampledSpectrum(lambda_nm).map(|l| {
            let x = ((l - self.lambda_nm[0]) * self.cells_per_nm).max(0.0).min(last as f32);
            let i = (x as usize).min(last - 1);
            let (v0, v1) = (self.values[i], self.values[i + 1]);
            v0 + (x - i as f32) * (v1 - v0)
        })
    }

    fn at(&self, lambda_nm: f32) -> f32 {
        let last = self.lambda_nm.len() - 1;
        // Written so that NaN counts as outside.
        if !(lambda_nm > self.lambda_nm[0] && lambda_nm < self.lambda_nm[last]) {
            let end = if lambda_nm >= self.lambda_nm[last] { last } else { 0 };
            let inside = lambda_nm == self.lambda_nm[end];
            return if inside || self.outside == Outside::EndValue { self.values[end] } else { 0.0 };
        }
        let i = self.interval(lambda_nm);
        let (l0, l1, v0, v1) = (self.lambda_nm[i], self.lambda_nm[i + 1], self.values[i], self.values[i + 1]);
        let t = ((lambda_nm - l0) / (l1 - l0)).clamp(0.0, 1.0);
        v0 + t * (v1 - v0)
    }

    fn max(&self, lo: f32, hi: f32) -> f32 {
        let inside = |l: f32| l >= lo && l <= hi;
        let nodes = self.lambda_nm.iter().zip(&self.values).filter(|(l, _)| inside(**l)).map(|(_, v)| *v);
        nodes.fold(self.at(lo).max(self.at(hi)), f32::max)
    }

    fn is_constant(&self) -> bool {
        self.outside == Outside::EndValue && self.values.iter().all(|v| *v == self.values[0])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bhs_core::sampling::mix64;

    /// The definition, by linear search.
    fn slow(points: &[(f64, f64)], l: f64) -> f64 {
        for w in points.windows(2) {
            if l >= w[0].0 && l < w[1].0 {
                return w[0].1 + (l - w[0].0) / (w[1].0 - w[0].0) * (w[1].1 - w[0].1);
            }
        }
        if l < points[0].0 { points[0].1 } else { points[points.len() - 1].1 }
    }

    #[test]
    fn lookup_agrees_with_linear_search_on_even_and_uneven_grids() {
        let random = |i: u64| (mix64(i) >> 11) as f64 / (1u64 << 53) as f64;
        let even: Vec<_> = (0..76).map(|i| (400.0 + 4.0 * f64::from(i), random(i as u64))).collect();
        let mut l = 250.0;
        let uneven: Vec<_> = (0..60)
            .map(|i| {
                l += 0.01 + 40.0 * random(1000 + i).powi(4);
                (l, random(2000 + i))
            })
            .collect();
        let clustered = vec![(400.0, 0.0), (400.0, 1.0), (400.01, 0.5), (400.02, 0.7), (700.0, 1.0), (700.0, 0.0)];
        for points in [even, uneven, clustered, vec![(500.0, 0.3)], vec![(400.0, 0.0), (401.0, 1.0)]] {
            let table = Tabulated::new(&points, Outside::EndValue);
            for i in 0..20_000u32 {
                let l = 200.0 + 0.04 * f64::from(i);
                // Nodes lie where single precision puts them; skip the hair's breadth around a step.
                if points.windows(2).any(|w| w[0].0 == w[1].0 && (l - w[0].0).abs() < 1e-3) {
                    continue;
                }
                let (fast, slow) = (f64::from(table.at(l as f32)), slow(&points, f64::from(l as f32)));
                assert!((fast - slow).abs() < 4e-3, "{l} nm: {fast}, not {slow}");
            }
            for p in points.iter().filter(|p| points.iter().filter(|q| q.0 == p.0).count() == 1) {
                assert!((f64::from(table.at(p.0 as f32)) - p.1).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn outside_and_bounds() {
        let points = [(400.0, 2.0), (500.0, 8.0), (600.0, 3.0)];
        let ends = Tabulated::new(&points, Outside::EndValue);
        let zero = Tabulated::new(&points, Outside::Zero);
        assert_eq!((ends.at(300.0), ends.at(400.0), ends.at(600.0), ends.at(900.0)), (2.0, 2.0, 3.0, 3.0));
        assert_eq!((zero.at(399.9), zero.at(400.0), zero.at(600.0), zero.at(600.1)), (0.0, 2.0, 3.0, 0.0));
        assert_eq!((ends.max(360.0, 830.0), ends.max(500.0, 830.0), ends.max(700.0, 830.0)), (8.0, 8.0, 3.0));
        assert_eq!((zero.max(360.0, 830.0), zero.max(700.0, 830.0)), (8.0, 0.0));
        assert!((ends.max(440.0, 450.0) - 5.0).abs() < 1e-6);
        assert!(ends.at(f32::NAN).is_finite() && !ends.is_constant());
        assert!(Tabulated::new(&[(400.0, 0.78), (700.0, 0.78)], Outside::EndValue).is_constant());
    }

    #[test]
    fn steps_make_a_table_zero_outside() {
        let step = Tabulated::new(&[(400.0, 0.0), (400.0, 1.0), (700.0, 1.0), (700.0, 0.0)], Outside::EndValue);
        assert_eq!((step.at(399.9), step.at(400.1), step.at(699.9), step.at(700.1)), (0.0, 1.0, 1.0, 0.0));
        assert_eq!(step.max(300.0, 400.0), 1.0);
    }
}
