//! `makadam picture`: one frame of a run as an image, or all frames as an animation.

use super::arguments::PictureArguments;
use super::beforehand::refuse_picture_beyond_memory;
use super::{Console, Failure};
use crate::output::create_folder_of;
use crate::pictures::{Animation, Picture, PictureError, Subject, camera, caption, draw, has_scale, memory, write_png};
use crate::run_frames::{Quantity, RunFolderError, RunFrame, RunFrames, rounded};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Width and height of an image where none are given, pixels.
const IMAGE_SIZE: [usize; 2] = [1200, 900];
/// Width and height of an animation where none are given, pixels.
const ANIMATION_SIZE: [usize; 2] = [800, 600];

/// Frames that are looked at to choose the scale and the place of the camera of an animation.
const LOOKS: usize = 9;

/// Bytes of a pixel in what an animation keeps beside the picture that is drawn.
const BESIDE: u64 = 24;

/// How far the frames per second of an animation may be off what was asked for without a word: delays are whole numbers in files.
const RATE_OFF: f64 = 0.2;

/// Draws a frame, or all frames if the output file is one of animations.
pub(super) fn picture(arguments: &PictureArguments, console: &Console) -> Result<ExitCode, Failure> {
    let animated = |path: &PathBuf| {
        path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gif") || ending.eq_ignore_ascii_case("apng"))
    };
    match arguments.output.as_ref().filter(|path| animated(path)) {
        Some(output) => animation(arguments, output, console),
        None => image(arguments, console),
    }
}

/// Draws one frame.
fn image(arguments: &PictureArguments, console: &Console) -> Result<ExitCode, Failure> {
    if arguments.every != 1 {
        return Err(Failure::Usage("--every is for animations: give --output FILE.gif or FILE.apng".into()));
    }
    let size = arguments.size.unwrap_or(IMAGE_SIZE);
    refuse_picture_beyond_memory(size, memory(size))?;
    let run = RunFrames::open(&arguments.frames.run)?;
    let number = match arguments.time {
        Some(time) => run.at(time)?,
        None => run.count() - 1,
    };
    let frame = run.read(number).map_err(|error| match error {
        RunFolderError::Damaged { .. } => Failure::Running(format!("{error}, or give another --time")),
        other => other.into(),
    })?;
    let style = arguments.style.style(size);
    let content = arguments.style.content();
    let drawn = content.picture(&run, &frame, &style)?;
    if crate::interrupt::requested() {
        return Err(Failure::Interrupted("nothing: the picture was not finished".into()));
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
    if arguments.time.is_some() || arguments.last {
        return Err(Failure::Usage("--time and --last are for one frame: give --output FILE.png".into()));
    }
    let size = arguments.size.unwrap_or(ANIMATION_SIZE);
    // The pictures that colours are chosen from are there at the same time, and what has its colours.
    let pixels = (size[0] * size[1]) as u64;
    refuse_picture_beyond_memory(size, memory(size) + BESIDE * pixels)?;
    let run = RunFrames::open(&arguments.frames.run)?;
    let numbers: Vec<usize> = (0..run.count()).step_by(arguments.every as usize).collect();
    let style = arguments.style.style(size);
    // One scale and one camera for all: what is seen must move, not they.
    let step = numbers.len().div_ceil(LOOKS).max(1);
    let looks: Vec<RunFrame> =
        numbers.iter().rev().step_by(step).map(|number| run.read(*number)).collect::<Result<_, _>>()?;
    let middle = &looks[looks.len() / 2];
    let content = arguments.style.content();
    let field = content.field_of(middle);
    let quantities: Vec<Quantity> =
        looks.iter().map(|frame| run.field(frame, &field)).collect::<Result<_, RunFolderError>>()?;
    let values: Vec<f64> = quantities.iter().flat_map(|quantity| quantity.values.iter().copied()).collect();
    let scale = content.scale_of(&quantities[0].title, &values);
    let camera = camera(&Subject::of(looks.iter(), arguments.style.all_grains), middle, &style);
    let one = |number: usize| -> Result<Picture, Failure> {
        let frame = run.read(numbers[number])?;
        let quantity = run.field(&frame, &field)?;
        let drawn = draw(&frame, &quantity, &scale, &camera, &style, &caption(&run, &frame));
        match crate::interrupt::requested() {
            true => Err(Failure::Interrupted("nothing: the animation was not finished".into())),
            false => Ok(drawn),
        }
    };
    tell_scale_left_out(size, console);
    create_folder_of(output)?;
    let samples = Animation::samples(numbers.len()).into_iter().map(one).collect::<Result<Vec<Picture>, _>>()?;
    let mut animation = Animation::begin(output, &samples, numbers.len(), arguments.rate)?;
    let bar = console.bar("drawing");
    for number in 0..numbers.len() {
        animation.push(&one(number)?)?;
        bar.set((number + 1) as f64 / numbers.len() as f64);
    }
    let each = animation.seconds_per_frame();
    animation.finish()?;
    if (each * arguments.rate - 1.0).abs() > RATE_OFF {
        console.note(&format!(
            "the format cannot show {} frames a second: it shows {}",
            arguments.rate,
            rounded(each.recip())
        ));
    }
    let seconds = rounded(numbers.len() as f64 * each);
    console.result(&format!("{}: {} frames, {seconds} s, coloured by {field}", output.display(), numbers.len()))?;
    Ok(ExitCode::SUCCESS)
}

/// Says that a picture has no colour scale where it is too narrow for one.
fn tell_scale_left_out(size: [usize; 2], console: &Console) {
    if !has_scale(size) {
        console.note("the picture is too narrow for a colour scale, which is left out");
    }
}

impl From<RunFolderError> for Failure {
    fn from(error: RunFolderError) -> Failure {
        match error {
            RunFolderError::Damaged { .. } => Failure::Running(error.to_string()),
            _ => Failure::Usage(error.to_string()),
        }
    }
}

impl From<PictureError> for Failure {
    fn from(error: PictureError) -> Failure {
        match error {
            PictureError::Write(error) => error.into(),
            PictureError::Format { .. } => Failure::Usage(error.to_string()),
        }
    }
}
