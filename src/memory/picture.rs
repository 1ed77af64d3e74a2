//! Memory that a picture needs.

use super::{Available, Bytes, available};
use crate::film::Framebuffer;
use bhs_core::camera::Film;
use bhs_core::diagnostics::{Diagnostic, Span};
use bhs_engine::layer::NamedLayer;

/// What is done about a picture that is too large for the memory that there is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum TooLarge {
    /// Nothing: no picture is made.
    #[default]
    Ignore,
    /// It is said.
    Warn,
    /// It is an error.
    Refuse,
}

/// Buffers of the encoders, whatever the picture (bytes).
const ENCODERS: u64 = 2 << 20;

/// Memory that the picture of a film takes (bytes).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Need {
    /// Sums of samples, of colours and layers.
    pub sums: u64,
    /// What holds these together.
    pub tiles: u64,
    /// Besides, while it is written: the picture, its layers, and what the encoders of EXR and PNG hold.
    pub writing: u64,
}

impl Need {
    /// That of a film with these layers.
    pub fn of(film: &dyn Film, layers: &[NamedLayer]) -> Self {
        Self::shown(film, layers, film.bloom())
    }

    /// The same, if its picture is shown with a glare of this radius (pixels).
    fn shown(film: &dyn Film, layers: &[NamedLayer], bloom: f64) -> Self {
        let [x0, x1, y0, y1] = film.crop();
        let pixels = u64::from(x1.saturating_sub(x0)) * u64::from(y1.saturating_sub(y0));
        let colors = film.channels().len() as u64;
        let channels = colors + layers.iter().map(|l| l.format.channels.len() as u64).sum::<u64>();
        let [sums, tiles] = Framebuffer::bytes(film, layers);
        let layers = layers.len() as u64;
        // Glare: a channel and its transfer function, each beside its transpose, and the colours once more.
        let glare = if bloom > 0.0 { 4 * 8 + 4 * colors } else { 0 };
        // The colours as floats, the layers as options of three doubles, and these in colours of three bytes.
        let held = 4 * colors + (32 + 3) * layers;
        // Bytes of colour and what they are compressed to; for EXR the channels together, if there are layers, and then one by one.
        let (png, exr) = (3 + 3, 4 * channels + if layers > 0 { 4 * (colors + channels) } else { 0 });
        Self { sums, tiles, writing: ENCODERS + pixels.saturating_mul(held + glare + png.max(exr)) }
    }

    /// All of it, as it is needed at once.
    pub fn total(&self) -> u64 {
        self.sums.saturating_add(self.tiles).saturating_add(self.writing)
    }
}

/// An error if the picture of `film` with these layers needs more memory than there is now. `None`: it fits, or the system does not tell.
pub fn check(film: &dyn Film, layers: &[NamedLayer]) -> Option<Diagnostic> {
    check_shown(film, layers, film.bloom(), 0)
}

/// The same, if the picture is shown with a glare of this radius (pixels), with `besides` (bytes) for what is done with it before it is written.
pub fn check_shown(film: &dyn Film, layers: &[NamedLayer], bloom: f64, besides: u64) -> Option<Diagnostic> {
    let (mut need, available) = (Need::shown(film, layers, bloom), available()?);
    need.writing = need.writing.saturating_add(besides);
    (need.total() > available.bytes).then(|| too_large(film, need, &available))
}

fn too_large(film: &dyn Film, need: Need, available: &Available) -> Diagnostic {
    let [x0, x1, y0, y1] = film.crop();
    let message = format!(
        "the picture of {}x{} pixels is too large: it needs {} of memory, {} for the sums of its samples and {} to be written",
        x1 - x0,
        y1 - y0,
        Bytes(need.total()),
        Bytes(need.sums),
        Bytes(need.tiles.saturating_add(need.writing))
    );
    let help = format!("{available}; make it smaller, record fewer layers, or render parts of it with `--crop`");
    Diagnostic::error("too-large", message).help(help)
}

/// As [`check`], with the place in the scene that says how large it is.
pub fn check_at(film: &dyn Film, layers: &[NamedLayer], span: Span) -> Option<Diagnostic> {
    Some(check(film, layers)?.at(span, ""))
}
