//! Spaces in which differential equations are solved.

use bhs_core::real::{Real, Vector};

/// What a differential equation is about: numbers, vectors, several of them.
pub trait Space<F: Real>: Copy {
    /// `self + o s`
    fn plus(self, o: Self, s: F) -> Self;

    /// `self s`
    fn times(self, s: F) -> Self;

    /// Where `which` says so, this, elsewhere `o`.
    fn or(self, o: Self, which: F::Mask) -> Self;
}

impl<F: Real> Space<F> for Vector<F> {
    #[inline(always)]
    fn plus(self, o: Self, s: F) -> Self {
        Self::plus(self, o, s)
    }

    #[inline(always)]
    fn times(self, s: F) -> Self {
        self * s
    }

    #[inline(always)]
    fn or(self, o: Self, which: F::Mask) -> Self {
        Self::or(self, o, which)
    }
}

impl<F: Real, S: Space<F>, const N: usize> Space<F> for [S; N] {
    #[inline(always)]
    fn plus(self, o: Self, s: F) -> Self {
        std::array::from_fn(|i| self[i].plus(o[i], s))
    }

    #[inline(always)]
    fn times(self, s: F) -> Self {
        self.map(|x| x.times(s))
    }

    #[inline(always)]
    fn or(self, o: Self, which: F::Mask) -> Self {
        std::array::from_fn(|i| self[i].or(o[i], which))
    }
}
