//! `windy`: waves of water in wind: noise of six sizes, as strong as the magnitude of noise ten times as large.
//!
//! The noise is of points of space, in the coordinates in which the texture was defined: `Scale` before it makes the waves larger.
//!
//! Meaning of pbrt-v4, where it has no parameters either; its waves are other ones.
//!
//! ```bhs
//! WorldBegin
//! AttributeBegin
//!   Scale 0.2 0.2 0.2
//!   Texture "waves" "float" "windy"
//! AttributeEnd
//! ```

use crate::mapping::Space;
use crate::noise::Octaves;
use bhs_core::Plugin;
use bhs_core::material::Shading;
use bhs_core::params::Params;
use bhs_core::spectrum::SampledSpectrum;
use bhs_core::texture::Texture;

/// The entry in the list of plugins.
pub const PLUGIN: Plugin<dyn Texture> = Plugin { name: "windy", summary: "waves of water in wind, in space", build };

const WIND: Octaves = Octaves { octaves: 3, roughness: 0.5 };
const WAVES: Octaves = Octaves { octaves: 6, roughness: 0.5 };

struct Windy {
    space: Space,
}

fn build(p: &Params) -> Option<Box<dyn Texture>> {
    Some(Box::new(Windy { space: Space::read(p) }))
}

impl Texture for Windy {
    fn spectrum(&self, at: &Shading) -> SampledSpectrum {
        SampledSpectrum::splat(self.float(at))
    }

    fn float(&self, at: &Shading) -> f32 {
        let p = self.space.place(at);
        (WIND.in_space(p * 0.1).abs() * WAVES.in_space(p)) as f32
    }
}
