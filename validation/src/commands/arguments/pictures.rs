//! Arguments of the commands that show what a run has left.

use super::values::{positive, rayleigh_fraction};
use crate::export::{FORMATS, Format};
use crate::peers::CodeName;
use crate::pictures::{Content, Cut, Style, View};
use crate::scenes::Change;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, ValueEnum};
use std::path::PathBuf;

/// The run of a command.
#[derive(Debug, Args)]
pub struct FramesArguments {
    /// The folder of a run, or the name of one below results; the run may be under way.
    #[arg(value_name = "RUN")]
    pub run: PathBuf,
}

/// How pictures are drawn.
#[derive(Debug, Args)]
pub struct StyleArguments {
    /// What grains are coloured by: a field of the frames, such as speed, pressure, force, coordination_number, diameter, material.
    /// If absent, their speed, or the pressure in them where all are at rest.
    #[arg(long)]
    pub field: Option<String>,
    /// Values at the ends of the colour scale, in the field's unit, as LOW,HIGH; taken from the frames, if absent.
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, allow_hyphen_values = true)]
    pub range: Option<[f64; 2]>,
    /// From where: natural, front, side, top, or AZIMUTH,ELEVATION in degrees.
    #[arg(long, default_value = "natural", allow_hyphen_values = true)]
    pub view: View,
    /// A plane in front of which nothing is shown, such as y=0.02 (m).
    #[arg(long, value_name = "AXIS=PLACE")]
    pub clip: Option<Cut>,
    /// Leave walls out.
    #[arg(long)]
    pub no_walls: bool,
    /// Show all grains, also those that are far from the walls.
    #[arg(long)]
    pub all_grains: bool,
}

impl StyleArguments {
    /// The style of pictures of a size.
    pub fn style(&self, size: [usize; 2]) -> Style {
        Style { size, view: self.view, cut: self.clip, walls: !self.no_walls }
    }

    /// Returns the content of pictures.
    pub fn content(&self) -> Content {
        Content { field: self.field.clone(), range: self.range, all_grains: self.all_grains }
    }
}

/// Arguments of `makadam picture`.
#[derive(Debug, Args)]
pub struct PictureArguments {
    /// The run.
    #[command(flatten)]
    pub frames: FramesArguments,
    /// The frame nearest to this simulated time, s; the last one, if absent.
    #[arg(long, value_name = "SECONDS")]
    pub time: Option<f64>,
    /// The last frame.
    #[arg(long, conflicts_with = "time")]
    pub last: bool,
    /// Every n-th frame of an animation.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..), conflicts_with_all = ["time", "last"])]
    pub every: u32,
    /// Frames per second of an animation.
    #[arg(long, default_value_t = 20.0, value_parser = positive, conflicts_with_all = ["time", "last"])]
    pub rate: f64,
    /// Width and height, pixels; if absent, 1200x900, or 800x600 of an animation.
    #[arg(long, value_parser = size)]
    pub size: Option<[usize; 2]>,
    /// How it is drawn.
    #[command(flatten)]
    pub style: StyleArguments,
    /// File to write: one frame as .png, all frames as .gif or .apng; if absent, picture.png in the folder of the run.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
}

/// Arguments of `makadam view`.
#[derive(Debug, Args)]
pub struct ViewArguments {
    /// The run.
    #[command(flatten)]
    pub frames: FramesArguments,
    /// What grains can be coloured by: fields of the frames, with commas; each takes two bytes per grain and frame. If absent, speed and
    /// pressure.
    #[arg(long, value_delimiter = ',')]
    pub field: Option<Vec<String>>,
    /// Show each so many frames only; as many as fit into --megabytes, if absent.
    #[arg(long, value_parser = clap::value_parser!(u32).range(1..))]
    pub every: Option<u32>,
    /// Largest size of the file, MB: first contacts are left out, then frames.
    #[arg(long, default_value_t = 200.0, value_parser = positive)]
    pub megabytes: f64,
    /// Leave contacts, and with them force chains, out.
    #[arg(long)]
    pub no_contacts: bool,
    /// Begin with a view of all grains, also of those that are far from the walls.
    #[arg(long)]
    pub all_grains: bool,
    /// HTML file to write; view.html in the folder of the run, if absent.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
}

/// Formats by their names.
fn frame_format() -> impl TypedValueParser<Value = Format> {
    let of = |name: String| FORMATS.into_iter().find(|format| format.name == name).ok_or("unknown format");
    PossibleValuesParser::new(FORMATS.map(|format| format.name)).try_map(of)
}

/// The codes that read another input than a scene.
fn another_code() -> impl TypedValueParser<Value = CodeName> {
    let others = CodeName::value_variants().iter().filter(|name| **name != CodeName::Makadam);
    PossibleValuesParser::new(others.filter_map(ValueEnum::to_possible_value)).try_map(|name| CodeName::of(&name))
}

/// Arguments of `makadam export`.
#[derive(Debug, Args)]
pub struct ExportArguments {
    /// Folder of a run, or the name of one below results; with --for, a scene.
    #[arg(value_name = "RUN or SCENE")]
    pub what: String,
    /// Format of the frames of a run: VTP or VTKHDF for ParaView, GSD for OVITO.
    #[arg(long, value_parser = frame_format(), required_unless_present = "code")]
    pub format: Option<Format>,
    /// Code for which a scene is written: deck or driver, grains, meshes of walls.
    #[arg(long = "for", id = "code", value_parser = another_code(), value_name = "CODE", conflicts_with = "format")]
    pub code: Option<CodeName>,
    /// With --for, replace a value of the scene; can be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE", requires = "code")]
    pub changes: Vec<Change>,
    /// With --for, seed of the initial positions; if absent, the scene's.
    #[arg(long, requires = "code", conflicts_with = "format")]
    pub seed: Option<u64>,
    /// With --for, time step of the code, as a fraction of the Rayleigh step.
    #[arg(long, default_value_t = 0.1, value_parser = rayleigh_fraction, requires = "code")]
    pub rayleigh_fraction: f64,
    /// Folder to write into; that of the run, or one named after scene and code, if absent.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
}

/// A size such as 1200x900.
fn size(text: &str) -> Result<[usize; 2], String> {
    let parse = |text: &str| text.parse::<usize>().ok().filter(|pixels| (64..=16_384).contains(pixels));
    let sides = text.split_once(['x', 'X']).and_then(|(width, height)| Some([parse(width)?, parse(height)?]));
    sides.ok_or_else(|| {
        format!("'{text}' is no size: give WIDTHxHEIGHT in pixels, each from 64 to 16384, such as 1200x900")
    })
}

/// A range such as 0,0.5.
fn range(text: &str) -> Result<[f64; 2], String> {
    let parse = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    let ends = text.split_once(',').and_then(|(low, high)| Some([parse(low)?, parse(high)?]));
    ends.filter(|[low, high]| low < high).ok_or_else(|| format!("'{text}' is no range: give LOW,HIGH, such as 0,0.5"))
}
