//! Films: from spectral samples to the numbers of a picture. One file, one plugin; `cie` holds the standard observer.

pub mod cie;
mod rgb;

use bhs_core::Plugin;
use bhs_core::camera::Film;

/// All films, by name.
pub const ALL: &[Plugin<dyn Film>] = &[rgb::PLUGIN];

#[cfg(test)]
mod tests {
    bhs_core::every_file_is_listed!([super::ALL], helpers: ["cie"]);
}
