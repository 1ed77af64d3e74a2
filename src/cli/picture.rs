//! How a picture is rendered: what can be typed for `bhs render`, and for `bhs watch` as well.

use super::values::{crop, resolution};
use clap::Args;

/// How a picture is rendered.
#[derive(Args, Clone, Debug, Default)]
pub struct PictureArgs {
    /// Samples per pixel; at most, with --time
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000_000))]
    pub spp: Option<u32>,
    /// Light transport, in place of the scene's
    #[arg(long, value_name = "NAME")]
    pub transport: Option<String>,
    /// Threads; if not given, what SLURM_CPUS_PER_TASK says, or all processors
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub threads: Option<u32>,
    /// Part to render, as fractions of width and height
    #[arg(long, value_name = "x0,x1,y0,y1", value_parser = crop)]
    pub crop: Option<[f64; 4]>,
    /// Size of the picture
    #[arg(long, value_name = "WxH", value_parser = resolution)]
    pub resolution: Option<[u32; 2]>,
}
