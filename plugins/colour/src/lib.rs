//! Colour: the standard observer, the illuminant D65, sRGB, white balance, tone curves and what is outside of the gamut. Films, spectra, lights and textures share these numbers, so that what an
//! `rgb` in a scene means and what a film records of it are the same.
//!
//! XYZ of a radiance L is `integral(L xyz-bar) / integral(y-bar)`: a spectrum that is 1 at all wavelengths has Y = 1. Linear sRGB follows by
//! [`SRGB_FROM_XYZ`].

mod gamut;
mod matrix;
mod observer;
mod srgb;
mod tone;
mod white;

pub use gamut::{from_oklab, into_gamut, oklab};
pub use matrix::{Matrix, product, times};
pub use observer::{D65_LUMINANCE, D65_XYZ, MatchingFunctions, OBSERVER_RANGE, Y_INTEGRAL, d65, standard_observer};
pub use srgb::{LUMINANCE, SRGB_FROM_XYZ, SRGB_PRIMARIES, XYZ_FROM_SRGB, luminance, srgb_decode, srgb_encode, srgb_from_xyz};
pub use tone::ToneCurve;
pub use white::{D65_KELVIN, TEMPERATURES, balance_of, balance_of_colour, bradford, white_of};
