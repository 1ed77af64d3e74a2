//! What the filters share that are a product of two curves: how to draw offsets from them.

use bhs_core::camera::Filter;
use bhs_core::sampling::Discrete;
use glam::{DVec2, Vec2};

/// Cells that half a curve is tabulated in.
const CELLS: usize = 256;

/// A curve over -radius..radius that is the same on both sides, and may be negative in places.
struct Curve<F> {
    value: F,
    radius: f64,
    /// Choice of a cell of one half by the size of the curve in it.
    cells: Discrete,
}

impl<F: Fn(f64) -> f64> Curve<F> {
    fn new(radius: f64, value: F) -> Self {
        let size = |half_cells: usize| value(half_cells as f64 / (2 * CELLS) as f64 * radius).abs();
        // The largest of edges and middle: weights stay below about 1 where the curve crosses zero.
        let cells = Discrete::new((0..CELLS).map(|i| size(2 * i).max(size(2 * i + 1)).max(size(2 * i + 2))));
        Self { value, radius, cells }
    }

    /// A place from a number in [0,1), by the size of the curve, and its weight: the curve over what the table says of its size, which is
    /// close to its sign.
    fn sample(&self, u: f32) -> (f64, f64) {
        let (side, u) = if u < 0.5 { (-1.0, 2.0 * u) } else { (1.0, 2.0 * u - 1.0) };
        let Some((cell, within)) = self.cells.sample(u) else { return (0.0, 1.0) };
        let x = (cell as f64 + f64::from(within)) / CELLS as f64 * self.radius;
        // What the table says of the cell.
        let size = self.cells.probability(cell) * self.cells.total();
        (side * x, (self.value)(x) / size)
    }
}

/// A filter that is the product of a curve across and a curve down.
pub(crate) struct Separable<F> {
    x: Curve<F>,
    y: Curve<F>,
}

impl<F: Fn(f64) -> f64> Separable<F> {
    /// The filter of the given radii (pixels) and curves of the offset (pixels).
    pub fn new(radius: [f64; 2], curve: impl Fn(f64) -> F) -> Self {
        let [x, y] = radius.map(|r| Curve::new(r, curve(r)));
        Self { x, y }
    }
}

impl<F: Fn(f64) -> f64 + Send + Sync> Filter for Separable<F> {
    fn radius(&self) -> DVec2 {
        DVec2::new(self.x.radius, self.y.radius)
    }

    fn value(&self, offset: DVec2) -> f64 {
        if offset.abs().cmpgt(self.radius()).any() {
            return 0.0;
        }
        (self.x.value)(offset.x.abs()) * (self.y.value)(offset.y.abs())
    }

    fn sample(&self, u: Vec2) -> (Vec2, f32) {
        let ((x, wx), (y, wy)) = (self.x.sample(u.x), self.y.sample(u.y));
        (Vec2::new(x as f32, y as f32), (wx * wy) as f32)
    }
}
