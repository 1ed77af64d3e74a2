//! `bhs watch`

use super::values::{frames_per_second, layer_name, seconds};
use super::{PictureArgs, SceneArgs, ShowArgs, ToneArgs};
use crate::lang::variables::FRAMES_PER_SECOND;
use clap::Args;
use std::path::PathBuf;
use std::time::Duration;

/// `bhs watch`
#[derive(Args, Debug)]
pub struct WatchArgs {
    /// The scene
    pub scene: PathBuf,
    /// PNG file to write, in place of NAME.watch.png
    #[arg(short, long, value_name = "FILE.png", value_parser = png)]
    pub output: Option<PathBuf>,
    /// How the picture is rendered
    #[command(flatten)]
    pub picture: PictureArgs,
    /// End each picture after so many seconds of rendering
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub time: Option<Duration>,
    /// This frame of an animation: the scene's variables `$frame` and `$time` are its, and those of --keys
    #[arg(long, value_name = "N")]
    pub frame: Option<u32>,
    /// Numbers of variables over the frames, as for `render --frames`
    #[arg(long, value_name = "FILE.csv", requires = "frame")]
    pub keys: Option<PathBuf>,
    /// Frames a second: `$time` is `$frame` over this
    #[arg(long, value_name = "N", requires = "frame", value_parser = frames_per_second, default_value_t = FRAMES_PER_SECOND)]
    pub fps: f64,
    /// What changes the scene
    #[command(flatten)]
    pub scene_args: SceneArgs,
    /// The camera of this name; the scene's first one if not given
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// Show a layer besides the colour in the viewer of --display-server; can be repeated
    #[arg(long, value_name = "NAME", value_parser = layer_name)]
    pub aov: Vec<String>,
    /// The colours of the PNG
    #[command(flatten)]
    pub tone: ToneArgs,
    /// Small and with few samples
    #[arg(long)]
    pub quick: bool,
    /// No progress and no words but errors and warnings
    #[arg(long)]
    pub quiet: bool,
    /// What is shown meanwhile
    #[command(flatten)]
    pub show: ShowArgs,
}

fn png(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    let is_png = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("png"));
    if is_png { Ok(path) } else { Err("expected a name that ends in .png".to_owned()) }
}
