//! How pictures are shown: what can be typed for `bhs develop`, and for `bhs render` as well.

use crate::look::{Bits, Exposure, LookChanges, White, bloom, tone_curve};
use bhs_colour::ToneCurve;
use clap::Args;
use std::path::PathBuf;
use std::str::FromStr;

/// The colours of a picture: in the PNG, never in the EXR file.
#[derive(Args, Clone, Debug, Default)]
pub struct ToneArgs {
    /// Brightness of the PNG in stops, in place of the film's, or `auto`
    #[arg(long, value_name = "STOPS|auto", allow_hyphen_values = true, value_parser = Exposure::from_str)]
    pub exposure: Option<Exposure>,
    /// What becomes of what is brighter than a screen, in place of the film's
    #[arg(long, value_name = "clip|reinhard|aces|agx", value_parser = tone_curve)]
    pub tonecurve: Option<ToneCurve>,
    /// Temperature of the light that is shown as white, in kelvins, or `auto`; 6504 changes nothing
    #[arg(long, value_name = "KELVIN|auto", allow_hyphen_values = true, value_parser = White::from_str)]
    pub white: Option<White>,
    /// Radius of the glare of an aperture, in pixels at 550 nm, in place of the film's; 0: none
    #[arg(long, value_name = "PIXELS", allow_hyphen_values = true, value_parser = bloom)]
    pub bloom: Option<f64>,
    /// Bits of each of red, green and blue of the PNG
    #[arg(long, value_name = "8|16", value_parser = Bits::from_str)]
    pub bits: Option<Bits>,
}

/// How a picture is shown: in the PNG, never in the EXR file.
#[derive(Args, Clone, Debug, Default)]
pub struct LookArgs {
    /// Its colours
    #[command(flatten)]
    pub tone: ToneArgs,
    /// Show a layer in place of the picture, such as `normal`: as if it were light, or with --false-color
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    /// Write every layer as FILE.NAME.png too, in colours that stand for its numbers; with --layer, that layer is the picture
    #[arg(long)]
    pub false_color: bool,
}

impl ToneArgs {
    /// What they change.
    pub fn changes(&self) -> LookChanges {
        let Self { exposure, tonecurve, white, bloom, bits } = *self;
        LookChanges { exposure, curve: tonecurve, white, bloom, bits }
    }
}

impl LookArgs {
    /// What they change.
    pub fn changes(&self) -> LookChanges {
        self.tone.changes()
    }
}

/// `bhs develop`
#[derive(Args, Debug)]
pub struct DevelopArgs {
    /// The EXR picture, of bhs or of another program
    #[arg(value_name = "IN.exr")]
    pub picture: PathBuf,
    /// PNG file to write
    #[arg(short, long, value_name = "OUT.png")]
    pub output: PathBuf,
    /// How it is shown; what is not given is as the picture was rendered with
    #[command(flatten)]
    pub look: LookArgs,
    /// No notes
    #[arg(long)]
    pub quiet: bool,
}
