//! The command line: what can be typed.

mod denoise;
mod develop;
mod merge;
mod picture;
mod show;
mod values;
mod watch;

pub use denoise::DenoiseArgs;
pub use develop::{DevelopArgs, LookArgs, ToneArgs};
pub use merge::MergeArgs;
pub use picture::PictureArgs;
pub use show::ShowArgs;
pub use watch::WatchArgs;

use crate::animation::FrameRange;
use crate::checkpoint;
use crate::lang::variables::FRAMES_PER_SECOND;
use crate::parts::PartArgs;
use bhs_core::sampling::NoiseOver;
use clap::{Args, CommandFactory, Parser, Subcommand, ValueEnum};
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::Duration;
use values::{frames_per_second, layer_name, noise, noise_over, pixel, preview, resolution, seconds};

/// A renderer for scenes with a black hole in them.
#[derive(Debug, Parser)]
#[command(name = "bhs", version, about, max_term_width = 110)]
pub struct Cli {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
    /// Colours in what is said about a scene
    #[arg(long, global = true, value_enum, value_name = "WHEN", default_value_t)]
    pub color: Color,
    /// Folder that nothing leads out of that a scene reads or writes; files that the command line names may lie elsewhere
    #[arg(long, global = true, value_name = "FOLDER")]
    pub root: Option<PathBuf>,
    /// Read the scene with pbrt-v4's meaning, even if its name does not end in `.pbrt`
    #[arg(long, global = true)]
    pub pbrt: bool,
    /// Read this file at the end of the scene too, such as one that has a black hole; can be repeated
    #[arg(long, global = true, value_name = "FILE")]
    pub include: Vec<PathBuf>,
    /// With --version: also commit, its date, Embree, vector code and denoiser
    #[arg(long, requires = "version")]
    pub verbose: bool,
}

/// What stands under the help of every command.
const EXIT_CODES: &str = "Exit codes: 0 done; 1 the scene or a file is at fault; 2 the command line is at fault; 75 a part of a picture was stopped, and is kept for --resume; 130, 143, 129 stopped by \
                          Ctrl-C, SIGTERM, SIGHUP, with what was rendered written";

/// The command line with all that stands in its help.
pub fn full_command() -> clap::Command {
    let command = Cli::command();
    let names: Vec<String> = command.get_subcommands().map(|c| c.get_name().to_owned()).collect();
    let add = |c: clap::Command| if c.get_after_help().is_some() { c } else { c.after_help(EXIT_CODES) };
    names.into_iter().fold(add(command), |all, name| all.mut_subcommand(name, add))
}

/// When what is said has colours.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Color {
    /// On a terminal, unless the environment variable `NO_COLOR` is set
    #[default]
    Auto,
    /// Always
    Always,
    /// Never
    Never,
}

impl Color {
    /// Whether what goes to standard error has colours.
    pub fn on_standard_error(self) -> bool {
        match self {
            Self::Auto => std::io::stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none_or(|v| v.is_empty()),
            Self::Always => true,
            Self::Never => false,
        }
    }
}

/// The program's commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render scenes, each to an EXR file and a PNG beside it
    Render(Box<RenderArgs>),
    /// Render a scene anew whenever it, or anything that it reads, is saved: coarse first, to NAME.watch.png, until Ctrl-C
    Watch(Box<WatchArgs>),
    /// Join parts of a picture that `render --samples` or `render --part` have made; exit 1, and no file, if one is missing or does not belong
    Merge(MergeArgs),
    /// Parse and build scenes without rendering them; exit 1 on errors
    Check {
        /// The scenes; `-` reads standard input
        #[arg(value_name = "SCENE", required = true)]
        scenes: Vec<PathBuf>,
        /// Print one JSON object a finding on standard output, for editors
        #[arg(long)]
        json: bool,
        /// Numbers for its variables
        #[command(flatten)]
        definitions: Definitions,
    },
    /// Print a scene neatly, comments kept
    Format {
        /// The scene; `-` reads standard input
        scene: PathBuf,
        /// Write it back to its file
        #[arg(long)]
        write: bool,
    },
    /// Write a scene, such as one of pbrt-v4's, as one file in our own terms
    Convert {
        /// The scene; `-` reads standard input
        scene: PathBuf,
        /// File to write; standard output if not given
        #[arg(short, long, value_name = "FILE.bhs")]
        output: Option<PathBuf>,
        /// Numbers for its variables
        #[command(flatten)]
        definitions: Definitions,
    },
    /// List the plugins, with their parameters
    Plugins {
        /// Only this kind: integrator, transport, material, light, shape, ...
        kind: Option<String>,
        /// Only this plugin, with its parameter table
        name: Option<String>,
        /// Print JSON, parameters included
        #[arg(long)]
        json: bool,
    },
    /// Follow rays through a scene, or join points by light; one line of JSON or CSV each, in input order
    Trace(TraceArgs),
    /// Measure integrators and light transports on a scene: time against error
    Bench(BenchArgs),
    /// Take the noise out of an EXR picture that has the layers `albedo` and `normal`
    Denoise(DenoiseArgs),
    /// Make a PNG of an EXR picture, without rendering it again
    Develop(DevelopArgs),
    /// Compare two EXR pictures
    Compare {
        /// The picture
        a: PathBuf,
        /// The reference
        b: PathBuf,
        /// Also write pictures of the differences: FLIP, what the eye notices, as OUT.png, the relative error as OUT.relative.png
        #[arg(long, value_name = "OUT.png")]
        diff: Option<PathBuf>,
        /// Print JSON, with the mean of FLIP
        #[arg(long)]
        json: bool,
    },
    /// Print the script by which a shell completes the words of bhs
    Completions {
        /// The shell
        shell: clap_complete::Shell,
    },
    /// Print the manual page, as roff: `bhs man | man -l -`
    Man {
        /// That of this command
        command: Option<String>,
    },
}

/// What changes a scene from the command line.
#[derive(Args, Clone, Debug, Default)]
pub struct SceneArgs {
    /// Integrator of light rays, in place of the scene's
    #[arg(long, value_name = "NAME")]
    pub integrator: Option<String>,
    /// Seed of all random numbers, from 0 to 9223372036854775807
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(..=crate::lang::LARGEST_SEED))]
    pub seed: Option<u64>,
    /// Numbers for its variables
    #[command(flatten)]
    pub definitions: Definitions,
}

/// Numbers for the variables of a scene.
#[derive(Args, Clone, Debug, Default)]
pub struct Definitions {
    /// Number of the variable `$NAME`, in place of the scene's `Define`; can be repeated
    #[arg(short = 'D', long = "define", value_name = "NAME=VALUE", value_parser = crate::lang::variables::parse_definition)]
    pub define: Vec<(String, f64)>,
}

/// `bhs render`
#[derive(Args, Clone, Debug)]
pub struct RenderArgs {
    /// The scenes, rendered one after the other; `-` reads standard input
    #[arg(value_name = "SCENE", required = true)]
    pub scenes: Vec<PathBuf>,
    /// The one of them that has its turn: see [`RenderArgs::each`]
    #[arg(skip)]
    pub scene: PathBuf,
    /// Its number, from 0, and how many there are
    #[arg(skip = [0, 1])]
    pub of_scenes: [u32; 2],
    /// EXR file to write, in place of the scene's `filename`; the PNG stands beside it
    #[arg(short, long, value_name = "FILE.exr")]
    pub output: Option<PathBuf>,
    /// How the picture is rendered
    #[command(flatten)]
    pub picture: PictureArgs,
    /// End each picture after so many seconds of rendering, with the samples that it has then
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    pub time: Option<Duration>,
    /// Sample each pixel until its noise is below T: the standard error of its luminance over that luminance, or over 2 % of the picture's mean
    /// where that is more. 0.01 is a good picture. --spp is then the most that a pixel may take, and there is no limit if it is not given
    #[arg(long, value_name = "T", value_parser = noise, conflicts_with_all = ["pixel", "sample"])]
    pub noise: Option<f64>,
    /// What has less noise than T: `pixel`, each pixel, or `picture`, the root of the mean square of all pixels' noise, which takes fewer samples
    #[arg(long, value_name = "WHAT", value_parser = noise_over, conflicts_with_all = ["pixel", "sample"])]
    pub noise_over: Option<NoiseOver>,
    /// Samples per pixel that --time and --noise leave at least; 1 and 16 if not given
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1_000_000_000))]
    pub min_spp: Option<u32>,
    /// Save the state of the render now and then, so that --resume can go on from it: beside the picture, as NAME.checkpoint, beside a part, as
    /// NAME.bhspart.checkpoint, or in FILE
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true)]
    pub checkpoint: Option<Option<PathBuf>>,
    /// Seconds between checkpoints; the first one comes soon
    #[arg(long, value_name = "SECONDS", value_parser = seconds, default_value = "300")]
    pub checkpoint_every: Duration,
    /// Go on from the checkpoint, or start if there is none; saves checkpoints too
    #[arg(long)]
    pub resume: bool,
    /// Write the picture as it is, with every checkpoint
    #[arg(long)]
    pub write_partial: bool,
    /// Part of a picture
    #[command(flatten)]
    pub parts: PartArgs,
    /// Several frames
    #[command(flatten)]
    pub frames: FrameArgs,
    /// What changes the scene
    #[command(flatten)]
    pub scene_args: SceneArgs,
    /// Only the camera of this name; all cameras of the scene if not given
    #[arg(long, value_name = "NAME")]
    pub camera: Option<String>,
    /// Record a layer besides the colour, such as `sweptangle` or `normal`; can be repeated
    #[arg(long, value_name = "NAME", value_parser = layer_name)]
    pub aov: Vec<String>,
    /// How the picture is shown
    #[command(flatten)]
    pub look: LookArgs,
    /// Take the noise out of the picture in the end; records the layers `albedo` and `normal` for it, and keeps the noisy picture as layer `noisy`
    #[arg(long)]
    pub denoise: bool,
    /// A preview: small and with few samples, as NAME.quick.exr unless -o names it
    #[arg(long)]
    pub quick: bool,
    /// Replace no file: end before rendering if one of the outputs is there
    #[arg(long)]
    pub no_overwrite: bool,
    /// No progress and no closing words
    #[arg(long)]
    pub quiet: bool,
    /// What is shown meanwhile
    #[command(flatten)]
    pub show: ShowArgs,
    /// Write what it took as JSON; `-` prints it on standard output, one line a picture
    #[arg(long, value_name = "FILE.json|-")]
    pub stats: Option<PathBuf>,
    /// Replay one sample of this pixel, counted from the upper left corner, print its path as JSON, and write no file
    #[arg(long, value_name = "X,Y", value_parser = pixel, requires = "sample", conflicts_with_all = ["output", "stats", "false_color", "denoise"])]
    pub pixel: Option<[u32; 2]>,
    /// Which sample of the pixel to replay, counted from 0
    #[arg(long, value_name = "N", requires = "pixel")]
    pub sample: Option<u32>,
}

/// The frames of an animation.
#[derive(Args, Clone, Debug, Default)]
pub struct FrameArgs {
    /// Render several frames, as NAME.0001.exr and so on: the scene's variables `$frame` and `$time` go with them, and those of --keys
    #[arg(long = "frames", value_name = "A-B[:STEP]", value_parser = FrameRange::parse, allow_hyphen_values = true, conflicts_with_all = ["pixel", "sample"])]
    pub range: Option<FrameRange>,
    /// Numbers of variables over the frames: a table whose first line is `frame,NAME,...`, or `smooth frame,NAME,...` for smooth motion
    #[arg(long, value_name = "FILE.csv", requires = "range")]
    pub keys: Option<PathBuf>,
    /// Frames a second: `$time` is `$frame` over this, and the film plays so fast
    #[arg(long, value_name = "N", requires = "range", value_parser = frames_per_second, default_value_t = FRAMES_PER_SECOND)]
    pub fps: f64,
    /// Leave out frames whose pictures are there and complete
    #[arg(long, requires = "range")]
    pub skip_existing: bool,
    /// Also write the frames as a small film to look at, an animated GIF or PNG
    #[arg(long, value_name = "FILE.gif|FILE.png", requires = "range", value_parser = preview)]
    pub preview: Option<PathBuf>,
}

impl RenderArgs {
    /// The same for each scene by itself.
    pub fn each(&self) -> impl Iterator<Item = Self> {
        let count = self.scenes.len() as u32;
        (0..).zip(&self.scenes).map(move |(number, scene)| Self {
            scene: scene.clone(),
            of_scenes: [number, count],
            ..self.clone()
        })
    }

    /// Whether what it took is printed.
    pub fn prints_stats(&self) -> bool {
        self.stats.as_deref() == Some(Path::new("-"))
    }

    /// Where the checkpoint of the picture `exr` stands, if there is to be one; `named` turns the name that is given into that of this picture.
    pub fn checkpoint_for(&self, exr: &Path, named: impl Fn(&Path) -> PathBuf) -> Option<PathBuf> {
        match &self.checkpoint {
            Some(Some(path)) => Some(named(path)),
            None if !self.resume => None,
            _ => Some(checkpoint::beside(exr)),
        }
    }
}

/// `bhs trace`
#[derive(Args, Debug)]
pub struct TraceArgs {
    /// The scene; `-` reads standard input
    pub scene: PathBuf,
    /// Rays, one a line: ox,oy,oz,dx,dy,dz in world coordinates; `-` reads standard input. A first line may name the columns, in any order, and add
    /// `side` (near, far) and `footprint` (scene units; 0: unknown)
    #[arg(long, value_name = "FILE.csv|-", required_unless_present_any = ["connect", "pixel"])]
    pub rays: Option<PathBuf>,
    /// The camera's ray through the centre of this pixel, counted from the upper left corner; can be repeated
    #[arg(long, value_name = "X,Y", value_parser = pixel, conflicts_with = "rays")]
    pub pixel: Vec<[u32; 2]>,
    /// Name of the camera of --pixel, where there are several
    #[arg(long, value_name = "NAME", requires = "pixel")]
    pub camera: Option<String>,
    /// Size of the picture of --pixel, in place of the scene's
    #[arg(long, value_name = "WxH", value_parser = resolution, requires = "pixel")]
    pub resolution: Option<[u32; 2]>,
    /// Pairs of points, one a line: x1,y1,z1,x2,y2,z2 in world coordinates; prints the light rays that join them, as JSON
    #[arg(long, value_name = "FILE.csv|-", conflicts_with_all = ["rays", "path", "pixel", "format"])]
    pub connect: Option<PathBuf>,
    /// Also print the points of the polyline that is traced, with the time, the angle and the redshift to each; in CSV, these in place of the ends
    #[arg(long)]
    pub path: bool,
    /// How answers are written, one a line
    #[arg(long, value_name = "json|csv", value_parser = ["json", "csv"], default_value = "json")]
    pub format: String,
    /// What changes the scene
    #[command(flatten)]
    pub scene_args: SceneArgs,
}

/// `bhs bench`
#[derive(Args, Debug)]
pub struct BenchArgs {
    /// The scenes, one after the other
    #[arg(value_name = "SCENE", required = true)]
    pub scenes: Vec<PathBuf>,
    /// Camera rays that integrators are measured on, and as many that bounce
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = clap::value_parser!(u32).range(100..=10_000_000))]
    pub rays: u32,
    /// How often everything is measured, in turn; medians count
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub rounds: u32,
    /// Size of the pictures that light transports are measured on
    #[arg(long, value_name = "WxH", value_parser = resolution, default_value = "96x72")]
    pub resolution: [u32; 2],
    /// Only one of the two
    #[arg(long, value_name = "integrators|transports", value_parser = ["integrators", "transports"])]
    pub only: Option<String>,
    /// Folder for the tables (CSV) and charts (SVG), with one of its own in it for each scene if there are several; none are written without it
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
    /// Numbers for the scene's variables
    #[command(flatten)]
    pub definitions: Definitions,
}
