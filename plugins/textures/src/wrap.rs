//! What lies outside of a picture that is laid on a surface.

/// What lies outside of the picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Wrap {
    Repeat,
    Clamp,
    Mirror,
    Black,
    /// The square of an octahedral map of directions, whose edges are folded onto themselves.
    Sphere,
}

/// The words for it, in the order of [`Wrap`].
pub const WRAPS: [&str; 5] = ["repeat", "clamp", "mirror", "black", "octahedralsphere"];

impl Wrap {
    /// By its word; the first if there is none.
    pub fn of(word: &str) -> Self {
        match word {
            "clamp" => Self::Clamp,
            "mirror" => Self::Mirror,
            "black" => Self::Black,
            "octahedralsphere" => Self::Sphere,
            _ => Self::Repeat,
        }
    }

    /// The place within a row or column of `n` texels for one that may lie outside; `None`: there is nothing.
    #[inline]
    fn within(self, x: i64, n: i64) -> Option<i64> {
        match self {
            Self::Repeat => Some(x.rem_euclid(n)),
            Self::Clamp | Self::Sphere => Some(x.clamp(0, n - 1)),
            Self::Mirror => Some(mirrored(x, n)),
            Self::Black => (0..n).contains(&x).then_some(x),
        }
    }
}

/// The texel in a row of `n` that stands at `x`, where every other repetition is mirrored.
fn mirrored(x: i64, n: i64) -> i64 {
    let within = x.rem_euclid(2 * n);
    if within < n { within } else { 2 * n - 1 - within }
}

/// The texel inside for one outside of an octahedral map: over an edge the map goes on at the opposite place of the same edge.
fn on_sphere([x, y]: [i64; 2], [w, h]: [i64; 2]) -> (i64, i64) {
    // What is beyond two widths repeats.
    let (x, y) = ((x + w / 2).rem_euclid(2 * w) - w / 2, (y + h / 2).rem_euclid(2 * h) - h / 2);
    let (x, y) = if x < 0 {
        (-1 - x, h - 1 - y)
    } else if x >= w {
        (2 * w - 1 - x, h - 1 - y)
    } else {
        (x, y)
    };
    let (x, y) = if y < 0 {
        (w - 1 - x, -1 - y)
    } else if y >= h {
        (w - 1 - x, 2 * h - 1 - y)
    } else {
        (x, y)
    };
    (x.clamp(0, w - 1), y.clamp(0, h - 1))
}

/// The number of the texel in a column and a row from the top, of a picture of the given width and height, beyond which it goes on as `wrap` says
/// along u and along v; `None`: there is nothing.
#[inline]
pub fn index(wrap: [Wrap; 2], [w, h]: [i64; 2], x: i64, y: i64) -> Option<usize> {
    let (x, y) = match wrap {
        [Wrap::Repeat, Wrap::Repeat] => (x.rem_euclid(w), y.rem_euclid(h)),
        [Wrap::Sphere, _] => on_sphere([x, y], [w, h]),
        [u, v] => (u.within(x, w)?, v.within(y, h)?),
    };
    Some((y * w + x) as usize)
}
