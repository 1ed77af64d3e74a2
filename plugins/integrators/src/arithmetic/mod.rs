//! Arithmetic of rays: polynomials, sines and cosines of one number or of eight ([`bhs_core::real::Real`]), numbers of twice the precision,
//! and one method for differential equations of the first order.

pub mod dormand_prince;
pub(crate) mod double;
pub mod polynomial;
pub mod root;
pub mod space;
