//! Line charts over two logarithmic axes, as SVG: errors against steps, times against sizes.

use bhs_elementary::Elementary;
use std::fmt::Write;

/// A line of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Series {
    /// What the legend calls it.
    pub name: String,
    /// x and y, in the order in which they are joined. What has no logarithm is left out.
    pub points: Vec<[f64; 2]>,
    /// Whether the line is dashed: for what was not measured, such as a slope to compare with.
    pub dashed: bool,
}

/// A chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Chart {
    /// Heading.
    pub title: String,
    /// What is along, with its unit.
    pub x: String,
    /// What is up, with its unit.
    pub y: String,
    /// The lines; after the last of [`COLORS`] comes the first again.
    pub series: Vec<Series>,
}

/// Colours that colour-blind readers can tell apart (Okabe and Ito 2008, "Color Universal Design").
pub const COLORS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#000000"];

/// Size of the picture, and the corners of the plane within (SVG units, y down).
const SIZE: [f64; 2] = [640.0, 400.0];
const PLANE: [[f64; 2]; 2] = [[70.0, 36.0], [450.0, 350.0]];

/// A logarithmic axis over whole decades.
struct Axis {
    /// Exponents of the ends.
    decades: [i32; 2],
    /// Places of the ends (SVG units).
    ends: [f64; 2],
}

impl Axis {
    /// Around all `values`; one decade if there are none.
    fn around(values: impl Iterator<Item = f64>, ends: [f64; 2]) -> Self {
        let (lo, hi) =
            values.map(Elementary::logarithm10).fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)));
        let decades = if lo <= hi { [lo.floor() as i32, (hi.ceil() as i32).max(lo.floor() as i32 + 1)] } else { [0, 1] };
        Self { decades, ends }
    }

    fn place(&self, value: f64) -> f64 {
        let [lo, hi] = self.decades.map(f64::from);
        self.ends[0] + (self.ends[1] - self.ends[0]) * (value.logarithm10() - lo) / (hi - lo)
    }

    /// The exponents that get a line and a number: at most ten or so.
    fn ticks(&self) -> impl Iterator<Item = i32> {
        let [lo, hi] = self.decades;
        (lo..=hi).step_by(((hi - lo) as usize).div_ceil(10).max(1))
    }
}

/// Whether a point has a place on a logarithmic chart.
fn is_shown(p: &[f64; 2]) -> bool {
    p.iter().all(|v| *v > 0.0 && v.is_finite())
}

/// Text with the characters replaced that mean something in XML.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

impl Chart {
    /// The chart as an SVG document.
    pub fn to_svg(&self) -> String {
        let shown = || self.series.iter().flat_map(|s| &s.points).filter(|p| is_shown(p));
        let [[left, top], [right, bottom]] = PLANE;
        let x = Axis::around(shown().map(|p| p[0]), [left, right]);
        let y = Axis::around(shown().map(|p| p[1]), [bottom, top]);
        let mut svg = String::new();
        self.draw(&mut svg, &x, &y).expect("a string takes whatever is written to it");
        svg
    }

    fn draw(&self, svg: &mut String, x: &Axis, y: &Axis) -> std::fmt::Result {
        let [width, height] = SIZE;
        let [[left, top], [right, bottom]] = PLANE;
        let (center, middle) = (0.5 * (left + right), 0.5 * (top + bottom));
        writeln!(
            svg,
            r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="12">"#
        )?;
        writeln!(svg, r#"<rect width="{width}" height="{height}" fill="white"/>"#)?;
        writeln!(svg, r#"<text x="{center}" y="20" text-anchor="middle" font-size="14">{}</text>"#, escaped(&self.title))?;

        // ---- Axes
        for e in x.ticks() {
            let at = x.place(10f64.powi(e));
            writeln!(svg, r##"<path d="M{at:.1} {top}V{bottom}" stroke="#ddd"/>"##)?;
            writeln!(svg, r#"<text x="{at:.1}" y="{}" text-anchor="middle">1e{e}</text>"#, bottom + 16.0)?;
        }
        for e in y.ticks() {
            let at = y.place(10f64.powi(e));
            writeln!(svg, r##"<path d="M{left} {at:.1}H{right}" stroke="#ddd"/>"##)?;
            writeln!(svg, r#"<text x="{}" y="{:.1}" text-anchor="end">1e{e}</text>"#, left - 6.0, at + 4.0)?;
        }
        writeln!(svg, r#"<path d="M{left} {top}V{bottom}H{right}" stroke="black" fill="none"/>"#)?;
        writeln!(svg, r#"<text x="{center}" y="{}" text-anchor="middle">{}</text>"#, bottom + 36.0, escaped(&self.x))?;
        writeln!(
            svg,
            r#"<text transform="translate(16 {middle}) rotate(-90)" text-anchor="middle">{}</text>"#,
            escaped(&self.y)
        )?;

        // ---- Lines and legend
        for (i, s) in self.series.iter().enumerate() {
            let color = COLORS[i % COLORS.len()];
            let dash = if s.dashed { r#" stroke-dasharray="4 4""# } else { "" };
            let places: Vec<[f64; 2]> = s.points.iter().filter(|p| is_shown(p)).map(|p| [x.place(p[0]), y.place(p[1])]).collect();
            let path: Vec<String> = places.iter().map(|[x, y]| format!("{x:.1},{y:.1}")).collect();
            writeln!(svg, r#"<polyline points="{}" fill="none" stroke="{color}" stroke-width="1.5"{dash}/>"#, path.join(" "))?;
            for [x, y] in places.iter().filter(|_| !s.dashed) {
                writeln!(svg, r#"<circle cx="{x:.1}" cy="{y:.1}" r="2.5" fill="{color}"/>"#)?;
            }
            let line = top + 8.0 + 18.0 * i as f64;
            let begin = right + 12.0;
            writeln!(svg, r#"<path d="M{begin} {line}h20" stroke="{color}" stroke-width="2"{dash}/>"#)?;
            writeln!(svg, r#"<text x="{}" y="{}">{}</text>"#, begin + 26.0, line + 4.0, escaped(&s.name))?;
        }
        writeln!(svg, "</svg>")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart(points: Vec<[f64; 2]>) -> String {
        let series = vec![Series { name: "a < b".into(), points, dashed: false }];
        Chart { title: "t & u".into(), x: "step (rad)".into(), y: "error".into(), series }.to_svg()
    }

    #[test]
    fn points_stand_where_their_logarithms_say() {
        let svg = chart(vec![[1e-2, 1e-8], [1e-1, 1e-4], [1.0, 1.0]]);
        // Both axes span their decades exactly: ends and the middle of the plane.
        assert!(svg.contains(r#"points="70.0,350.0 260.0,193.0 450.0,36.0""#), "{svg}");
        assert!(svg.contains("a &lt; b") && svg.contains("t &amp; u"), "{svg}");
        assert!(svg.starts_with("<svg ") && svg.trim_end().ends_with("</svg>"));
    }

    #[test]
    fn what_has_no_logarithm_is_left_out() {
        let svg = chart(vec![[0.1, 0.0], [0.2, f64::INFINITY], [0.3, f64::NAN], [1.0, 0.5]]);
        assert_eq!(svg.matches("<circle").count(), 1, "{svg}");
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        assert_eq!(chart(vec![]).matches("<circle").count(), 0);
        assert!(!chart(vec![]).contains("NaN"));
    }
}
