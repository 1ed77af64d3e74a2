//! `bhs denoise`

use clap::Args;
use std::path::PathBuf;

/// `bhs denoise`
#[derive(Args, Debug)]
pub struct DenoiseArgs {
    /// The picture, rendered with `--aov albedo --aov normal`
    #[arg(value_name = "IN.exr")]
    pub picture: PathBuf,
    /// EXR file to write; the PNG stands beside it
    #[arg(short, long, value_name = "OUT.exr")]
    pub output: PathBuf,
    /// Threads; if not given, what SLURM_CPUS_PER_TASK says, or all processors
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub threads: Option<u32>,
    /// Replace no file: end before denoising if one of the outputs is there
    #[arg(long)]
    pub no_overwrite: bool,
    /// No closing words
    #[arg(long)]
    pub quiet: bool,
}
