//! `makadam picture` and `makadam animate`: what a run has left, as an image and as a film.

use super::arguments::{AnimateArguments, PictureArguments};
use super::beforehand::refuse_picture_beyond_memory;
use super::{Console, Failure};
use crate::output::create_folder_of;
use crate::pictures::{Animation, Picture, PictureError, Subject, camera, caption, draw, has_scale, memory, write_png};
use crate::run_frames::{Quantity, RunFolderError, RunFrame, RunFrames, rounded};
use std::process::ExitCode;

/// Frames that are looked at to choose the scale and the place of the camera of an animation.
const LOOKS: usize = 9;

/// Bytes of a pixel in what an animation keeps beside the picture that is drawn.
const BESIDE: u64 = 24;

/// How far the frames per second of an animation may be off what was asked for without a word: delays are whole numbers in files.
const RATE_OFF: f64 = 0.2;

/// Draws one frame.
pub(super) fn picture(arguments: &PictureArguments, console: &Console) -> Result<ExitCode, Failure> {
    refuse_picture_beyond_memory(arguments.size, memory(arguments.size))?;
    let run = RunFrames::open(&arguments.frames.run)?;
    let number = match arguments.time {
        Some(time) => run.at(time)?,
        None => run.count() - 1,
    };
    let frame = run.read(number).map_err(|error| match error {
        RunFolderError::Damaged { .. } => Failure::Running(format!("{error}, or give another --time")),
        other => other.into(),
    })?;
    let style = arguments.style.style(arguments.size);
    let content = arguments.style.content();
    let drawn = content.picture(&run, &frame, &style)?;
    if crate::interrupt::requested() {
        return Err(Failure::Interrupted("nothing: the picture was not finished".into()));
    }
    tell_scale_left_out(arguments.size, console);
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
pub(super) fn animate(arguments: &AnimateArguments, console: &Console) -> Result<ExitCode, Failure> {
    // The pictures that colours are chosen from are there at the same time, and what has its colours.
    let pixels = (arguments.size[0] * arguments.size[1]) as u64;
    refuse_picture_beyond_memory(arguments.size, memory(arguments.size) + BESIDE * pixels)?;
    let run = RunFrames::open(&arguments.frames.run)?;
    let numbers: Vec<usize> = (0..run.count()).step_by(arguments.every as usize).collect();
    let output = arguments.output.clone().unwrap_or_else(|| run.folder().join("animation.gif"));
    let style = arguments.style.style(arguments.size);
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
    tell_scale_left_out(arguments.size, console);
    create_folder_of(&output)?;
    let samples = Animation::samples(numbers.len()).into_iter().map(one).collect::<Result<Vec<Picture>, _>>()?;
    let mut animation = Animation::begin(&output, &samples, numbers.len(), arguments.rate)?;
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
