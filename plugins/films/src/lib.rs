//! Films: from spectral samples to the numbers of a picture. One file, one plugin; `picture` holds what all films
//! share.

mod picture;
mod rgb;
mod sensor;
mod spectral;

use bhs_core::Plugin;
use bhs_core::camera::Film;

/// All films, by name.
pub const ALL: &[Plugin<dyn Film>] = &[rgb::PLUGIN, spectral::PLUGIN];

#[cfg(test)]
mod tests {
    bhs_core::every_file_is_listed!([super::ALL], helpers: ["picture", "sensor"]);
}
