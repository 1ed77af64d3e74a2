//! Arithmetic of rays: polynomials, sines and cosines of one number or of eight ([`bhs_core::real::Real`]), and numbers of twice the precision.

pub(crate) mod double;
pub mod polynomial;
