//! Graded indices from arithmetic that is written once: for one point, for eight side by side, and with derivatives.

use bhs_core::dual::Dual;
use bhs_core::real::Vector;
use glam::{DMat3, DVec3};

/// Coordinates as a vector.
pub fn variables_of([x, y, z]: [Dual; 3]) -> Vector<Dual> {
    Vector { x, y, z }
}

/// The matrix of derivatives of the gradient field `gradient` at `x`.
pub fn hessian(gradient: impl Fn(Vector<Dual>) -> Vector<Dual>, x: DVec3) -> DMat3 {
    let found = gradient(variables_of(Dual::variables(x)));
    DMat3::from_cols(found.x.gradient, found.y.gradient, found.z.gradient)
}

/// The part of [`bhs_core::spacetime::GradedIndex`] that follows from a method `index_of<F: Real>(&self, Vector<F>) -> (F, Vector<F>)`.
macro_rules! from_index_of {
    () => {
        fn index(&self, x: glam::DVec3) -> (f64, glam::DVec3) {
            let (square, gradient) = self.index_of(x.into());
            (square, gradient.into())
        }

        fn index_each(&self, x: bhs_core::real::Vectors) -> (bhs_core::lanes::Lanes, bhs_core::real::Vectors) {
            self.index_of(x)
        }

        fn hessian(&self, x: glam::DVec3) -> glam::DMat3 {
            $crate::graded::hessian(|x| self.index_of(x).1, x)
        }
    };
}
pub(crate) use from_index_of;
