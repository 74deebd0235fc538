//! `makadam picture`: one frame of a run as an image, or all frames as an animation.

use super::arguments::positive;
use super::beforehand::refuse_picture_beyond_memory;
use super::{Console, Failure};
use clap::Args;
use makadam_frames::output::create_folder_of;
use makadam_frames::run_frames::{Quantity, RunFolderError, RunFrame, RunFrames, rounded};
use makadam_view::pictures::{
    Animation, Content, Cut, Picture, Style, Subject, View, camera, caption, draw, has_scale, is_animation, memory,
    write_png,
};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Default width and height of an image, pixels.
const IMAGE_SIZE: [usize; 2] = [1200, 900];
/// Default width and height of an animation, pixels.
const ANIMATION_SIZE: [usize; 2] = [800, 600];

/// Number of frames sampled for the scale and the camera of an animation.
const LOOKS: usize = 9;

/// Bytes per pixel of an animation, in addition to the current picture.
const BESIDE: u64 = 24;

/// Largest relative deviation of the frames per second of an animation without a note: delays in files are whole numbers.
const RATE_OFF: f64 = 0.2;

#[derive(Debug, Args)]
pub(super) struct PictureArguments {
    /// Folder of a run, or the name of a folder below results; the run may be in progress.
    pub run: PathBuf,
    /// Simulated time, s: the nearest frame is drawn; if absent, the last frame.
    #[arg(long, value_name = "SECONDS")]
    pub time: Option<f64>,
    /// Every n-th frame of an animation.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..), conflicts_with = "time")]
    pub every: u32,
    /// Frames per second of an animation.
    #[arg(long, default_value_t = 20.0, value_parser = positive, conflicts_with = "time")]
    pub rate: f64,
    /// Width and height, pixels; if absent, 1200x900, or 800x600 for an animation.
    #[arg(long, value_parser = size)]
    pub size: Option<[usize; 2]>,
    /// Field of the frames that colours the grains, such as speed, pressure, force, coordination_number, diameter, material.
    /// If absent, speed, or pressure if all grains are at rest.
    #[arg(long)]
    pub field: Option<String>,
    /// Values at the ends of the colour scale, in the field's unit, as LOW,HIGH; if absent, from the frames.
    #[arg(long, value_name = "LOW,HIGH", value_parser = range, allow_hyphen_values = true)]
    pub range: Option<[f64; 2]>,
    /// View direction: natural, front, side, top, or AZIMUTH,ELEVATION in degrees.
    #[arg(long, default_value = "natural", allow_hyphen_values = true)]
    pub view: View,
    /// Clipping plane, such as y=0.02 (m), with everything in front of it hidden.
    #[arg(long, value_name = "AXIS=PLACE")]
    pub clip: Option<Cut>,
    /// Leave out walls.
    #[arg(long)]
    pub no_walls: bool,
    /// Show all grains, also those far from the walls.
    #[arg(long)]
    pub all_grains: bool,
    /// File to write: one frame as .png, all frames as .gif; if absent, picture.png in the folder of the run.
    #[arg(short, long)]
    pub output: Option<PathBuf>,
}

impl PictureArguments {
    /// Returns the style of pictures of a size.
    fn style(&self, size: [usize; 2]) -> Style {
        Style { size, view: self.view, cut: self.clip, walls: !self.no_walls }
    }

    fn content(&self) -> Content {
        Content { field: self.field.clone(), range: self.range, all_grains: self.all_grains }
    }
}

/// Parses a size such as 1200x900.
fn size(text: &str) -> Result<[usize; 2], String> {
    let parse = |text: &str| text.parse::<usize>().ok().filter(|pixels| (64..=16_384).contains(pixels));
    let sides = text.split_once(['x', 'X']).and_then(|(width, height)| Some([parse(width)?, parse(height)?]));
    sides.ok_or_else(|| {
        format!("'{text}' is no size: give WIDTHxHEIGHT in pixels, each from 64 to 16384, such as 1200x900")
    })
}

/// Parses a range such as 0,0.5.
fn range(text: &str) -> Result<[f64; 2], String> {
    let parse = |text: &str| text.trim().parse::<f64>().ok().filter(|value| value.is_finite());
    let ends = text.split_once(',').and_then(|(low, high)| Some([parse(low)?, parse(high)?]));
    ends.filter(|[low, high]| low < high).ok_or_else(|| format!("'{text}' is no range: give LOW,HIGH, such as 0,0.5"))
}

pub(super) fn picture(arguments: &PictureArguments, console: &Console) -> Result<ExitCode, Failure> {
    match arguments.output.as_ref().filter(|path| is_animation(path)) {
        Some(output) => animation(arguments, output, console),
        None => image(arguments, console),
    }
}

/// Draws one frame.
fn image(arguments: &PictureArguments, console: &Console) -> Result<ExitCode, Failure> {
    if arguments.every != 1 {
        return Err(Failure::Usage("--every is for animations: give --output FILE.gif".into()));
    }
    let size = arguments.size.unwrap_or(IMAGE_SIZE);
    refuse_picture_beyond_memory(size, memory(size))?;
    let run = RunFrames::open(&arguments.run)?;
    let number = match arguments.time {
        Some(time) => run.at(time)?,
        None => run.count() - 1,
    };
    let frame = run.read(number).map_err(|error| match error {
        RunFolderError::Damaged { .. } => Failure::Running(format!("{error}, or give another --time")),
        other => other.into(),
    })?;
    let style = arguments.style(size);
    let content = arguments.content();
    let drawn = content.picture(&run, &frame, &style)?;
    if makadam_frames::interrupt::requested() {
        return Err(Failure::interrupted("nothing: the picture was not finished"));
    }
    tell_scale_left_out(size, console);
    let output = arguments.output.clone().unwrap_or_else(|| run.folder().join("picture.png"));
    create_folder_of(&output)?;
    write_png(&output, &drawn)?;
    console.result(&format!(
        "{}: {} at {} s, coloured by {}",
        output.display(),
        run.scene(),
        rounded(frame.time),
        content.field_of(&frame)
    ))?;
    Ok(ExitCode::SUCCESS)
}

/// Draws all frames.
fn animation(arguments: &PictureArguments, output: &Path, console: &Console) -> Result<ExitCode, Failure> {
    if arguments.time.is_some() {
        return Err(Failure::Usage("--time is for one frame: give --output FILE.png".into()));
    }
    let size = arguments.size.unwrap_or(ANIMATION_SIZE);
    // Memory holds the sampled pictures for the choice of colours, and the table of colours, at the same time.
    let pixels = (size[0] * size[1]) as u64;
    refuse_picture_beyond_memory(size, memory(size) + BESIDE * pixels)?;
    let run = RunFrames::open(&arguments.run)?;
    let numbers: Vec<usize> = (0..run.count()).step_by(arguments.every as usize).collect();
    let style = arguments.style(size);
    // One scale and one camera for all frames: only the scene may move.
    let step = numbers.len().div_ceil(LOOKS).max(1);
    let looks: Vec<RunFrame> =
        numbers.iter().rev().step_by(step).map(|number| run.read(*number)).collect::<Result<_, _>>()?;
    let middle = &looks[looks.len() / 2];
    let content = arguments.content();
    let field = content.field_of(middle);
    let quantities: Vec<Quantity> =
        looks.iter().map(|frame| run.field(frame, &field)).collect::<Result<_, RunFolderError>>()?;
    let values: Vec<f64> = quantities.iter().flat_map(|quantity| quantity.values.iter().copied()).collect();
    let scale = content.scale_of(&quantities[0].title, &values);
    let camera = camera(&Subject::of(looks.iter(), arguments.all_grains), middle, &style);
    let one = |number: usize| -> Result<Picture, Failure> {
        let frame = run.read(numbers[number])?;
        let quantity = run.field(&frame, &field)?;
        let drawn = draw(&frame, &quantity, &scale, &camera, &style, &caption(&run, &frame));
        match makadam_frames::interrupt::requested() {
            true => Err(Failure::interrupted("nothing: the animation was not finished")),
            false => Ok(drawn),
        }
    };
    tell_scale_left_out(size, console);
    create_folder_of(output)?;
    let samples = Animation::samples(numbers.len()).into_iter().map(one).collect::<Result<Vec<Picture>, _>>()?;
    let mut animation = Animation::begin(output, &samples, arguments.rate)?;
    let bar = console.bar("drawing");
    for number in 0..numbers.len() {
        animation.push(&one(number)?)?;
        bar.set((number + 1) as f64 / numbers.len() as f64);
    }
    let each = animation.seconds_per_frame();
    animation.finish()?;
    if (each * arguments.rate - 1.0).abs() > RATE_OFF {
        console.note(&format!(
            "a GIF cannot show {} frames a second: it shows {}",
            arguments.rate,
            rounded(each.recip())
        ));
    }
    let seconds = rounded(numbers.len() as f64 * each);
    console.result(&format!("{}: {} frames, {seconds} s, coloured by {field}", output.display(), numbers.len()))?;
    Ok(ExitCode::SUCCESS)
}

/// Prints a note if a picture is too narrow for a colour scale.
fn tell_scale_left_out(size: [usize; 2], console: &Console) {
    if !has_scale(size) {
        console.note("the picture is too narrow for a colour scale, which is left out");
    }
}
