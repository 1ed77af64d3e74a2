//! Films: from spectral samples to the numbers of a picture. One file, one plugin; `cie` holds the standard observer,
//! `picture` what all films share.

pub mod cie;
mod picture;
mod rgb;
mod spectral;

use bhs_core::Plugin;
use bhs_core::camera::Film;

/// All films, by name.
pub const ALL: &[Plugin<dyn Film>] = &[rgb::PLUGIN, spectral::PLUGIN];

#[cfg(test)]
mod tests {
    bhs_core::every_file_is_listed!([super::ALL], helpers: ["cie", "picture"]);
}
