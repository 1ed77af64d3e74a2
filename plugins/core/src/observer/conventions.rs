//! What a picture takes of nature, and what it leaves out.

use super::Observer;
use crate::diagnostics::shorten;
use crate::params::Params;
use crate::spacetime::{Normal, Stationary};

/// Which frame surfaces and the camera measure angles in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameConvention {
    /// The static observer's: physically right.
    Static,
    /// The chart's own angles, as in Aikawa, Zhou and Wang 2019.
    Chart,
}

/// What a picture takes of nature, and what it leaves out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Conventions {
    /// Whether wavelengths shift along a ray.
    pub redshift: bool,
    /// Whether radiance shifts with them, as it does in nature (`L lambda^5` is constant); without it, as in Aikawa, Zhou and
    /// Wang 2019, wavelengths alone do.
    pub radiance_shift: bool,
    /// The frame of cameras, lights and materials.
    pub frame: FrameConvention,
}

impl Conventions {
    /// Spectral radiance per wavelength at E = 1 over that where the wavelength is `ratio` times as long: `L lambda^5` is constant along a
    /// ray (Liouville; I_nu/nu^3 is invariant).
    #[inline]
    pub fn radiance_factor(&self, ratio: f64) -> f32 {
        if ratio == 1.0 || !self.radiance_shift { 1.0 } else { ratio.powi(5) as f32 }
    }

    /// All that there is.
    pub const NATURE: Self = Self { redshift: true, radiance_shift: true, frame: FrameConvention::Static };

    /// Those that the parameters of a spacetime's directive state; `None` if something is wrong with them.
    pub fn read(p: &Params) -> Option<Self> {
        let redshift = p.get("redshift", true, "", "whether wavelengths and radiance shift along a ray");
        let radiance =
            p.get("radiance", "full".to_owned(), "", "what redshift does to radiance: `full`, or `shift-only`: nothing");
        let frame = p.get("frame", "static".to_owned(), "", "whose angles count: `static` observers' or the `chart`'s");
        let frame = match frame.as_str() {
            "static" => Some(FrameConvention::Static),
            "chart" => Some(FrameConvention::Chart),
            _ => {
                p.reject("frame", format!("unknown frame `{}`", shorten(&frame)), "expected `static` or `chart`");
                None
            }
        };
        let radiance_shift = match radiance.as_str() {
            "full" => Some(true),
            "shift-only" => Some(false),
            _ => {
                p.reject("radiance", format!("unknown radiance `{}`", shorten(&radiance)), "expected `full` or `shift-only`");
                None
            }
        };
        Some(Self { redshift, radiance_shift: radiance_shift?, frame: frame? })
    }

    /// The observer at rest where the metric is `here`.
    #[inline]
    pub fn observer(&self, here: &Stationary) -> Observer {
        let mut observer = Observer::at_rest(here);
        if self.frame == FrameConvention::Chart {
            observer = observer.in_chart();
        }
        if self.redshift { observer } else { observer.without_shift() }
    }

    /// The observer dragged with space where the metric is `here`.
    pub fn normal_observer(&self, here: &Normal) -> Observer {
        let mut observer = Observer::dragged(here);
        if self.frame == FrameConvention::Chart {
            observer = observer.in_chart();
        }
        if self.redshift { observer } else { observer.without_shift() }
    }
}
