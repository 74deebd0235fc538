//! Pictures into files: PNG, and animations as APNG or GIF.

use super::Picture;
use color_quant::NeuQuant;
use gif::{Encoder, Frame, Repeat};
use makadam_frames::output::{Draft, WriteError, write_whole};
use std::fs::File;
use std::io::{BufWriter, Error, Write};
use std::path::{Path, PathBuf};

/// Colours of a GIF.
const COLOURS: usize = 256;

/// Sampling of colours for a GIF, 1 (best) to 30.
const THOROUGH: i32 = 10;

/// Frames from which the colours of a GIF are chosen.
const SAMPLES: usize = 3;

/// Error of a picture that cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// The system refuses.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A name that says nothing of the format.
    #[error("{file}: its name must end in {known}")]
    Format {
        /// The file.
        file: String,
        /// The endings that are known.
        known: &'static str,
    },
}

fn refused(path: &Path, error: impl std::fmt::Display) -> WriteError {
    WriteError::new(path, Error::other(error.to_string()))
}

/// Writes a picture as PNG.
///
/// # Errors
/// [`PictureError`] if the name does not end in `.png`, or the system refuses.
pub fn write_png(path: &Path, picture: &Picture) -> Result<(), PictureError> {
    if ending(path) != "png" {
        return Err(PictureError::Format {
            file: path.display().to_string(),
            known: ".png, or .gif or .apng for an animation",
        });
    }
    Ok(write_whole(path, &png(picture))?)
}

/// Encodes a picture as PNG.
pub fn png(picture: &Picture) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, picture.width as u32, picture.height as u32);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(&picture.bytes));
    written.expect("a picture has three bytes per pixel, and memory takes them");
    bytes
}

/// Returns true if a file is named as an animation.
pub fn is_animation(path: &Path) -> bool {
    matches!(&*ending(path), "gif" | "apng")
}

fn ending(path: &Path) -> String {
    path.extension().map_or(String::new(), |ending| ending.to_string_lossy().to_ascii_lowercase())
}

/// An animation that is written frame after frame, into a draft that takes its name when it is complete, and is removed if it never is.
pub struct Animation {
    path: PathBuf,
    draft: Draft,
    format: Format,
}

/// The colour of the GIF that is nearest to one of a picture, by the upper bits of its red, green and blue, as far as that was asked
/// for already.
type Known = Vec<Option<u8>>;

/// Bits of a share of a colour that the nearest one is chosen by: the chosen ones are further apart.
const BITS: u32 = 6;

enum Format {
    Gif { encoder: Encoder<BufWriter<File>>, colours: Box<NeuQuant>, known: Known, delay: u16 },
    Apng { writer: png::Writer<BufWriter<File>>, milliseconds: u16 },
}

impl Animation {
    /// Begins an animation of so many frames, so many a second: a GIF, whose colours are chosen from `samples`, or an APNG.
    ///
    /// # Errors
    /// [`PictureError`] if the name ends otherwise, or the system refuses.
    pub fn begin(path: &Path, samples: &[Picture], frames: usize, rate: f64) -> Result<Animation, PictureError> {
        let known = ".gif, .apng or .png";
        let format = || PictureError::Format { file: path.display().to_string(), known };
        let is_gif = match &*ending(path) {
            "gif" => true,
            "apng" | "png" => false,
            _ => return Err(format()),
        };
        let first = samples.first().ok_or_else(format)?;
        let draft = Draft::of(path);
        let file = File::create(draft.name()).map_err(|source| WriteError::new(path, source))?;
        let file = BufWriter::new(file);
        let (width, height) = (first.width, first.height);
        let format = match is_gif {
            true => {
                let colours = Box::new(palette(samples));
                let map = colours.color_map_rgb();
                let encoder = Encoder::new(file, width as u16, height as u16, &map);
                let mut encoder = encoder.map_err(|error| refused(path, error))?;
                encoder.set_repeat(Repeat::Infinite).map_err(|error| refused(path, error))?;
                Format::Gif {
                    encoder,
                    colours,
                    known: vec![None; 1 << (3 * BITS)],
                    delay: (100.0 / rate).round().max(1.0) as u16,
                }
            }
            false => {
                let mut encoder = png::Encoder::new(file, width as u32, height as u32);
                encoder.set_color(png::ColorType::Rgb);
                encoder.set_depth(png::BitDepth::Eight);
                let milliseconds = (1000.0 / rate).round().clamp(1.0, 60_000.0) as u16;
                let begun = encoder
                    .set_animated(frames as u32, 0)
                    .and_then(|()| encoder.set_frame_delay(milliseconds, 1000))
                    .and_then(|()| encoder.write_header());
                Format::Apng { writer: begun.map_err(|error| refused(path, error))?, milliseconds }
            }
        };
        Ok(Animation { path: path.to_path_buf(), draft, format })
    }

    /// Frames whose pictures [`Animation::begin`] is best given, of so many.
    pub fn samples(frames: usize) -> Vec<usize> {
        let mut samples: Vec<usize> = (0..SAMPLES).map(|part| part * (frames - 1) / (SAMPLES - 1).max(1)).collect();
        samples.dedup();
        samples
    }

    /// Returns the duration of a frame, s: the format's nearest to the requested one.
    pub fn seconds_per_frame(&self) -> f64 {
        match &self.format {
            Format::Gif { delay, .. } => 0.01 * f64::from(*delay),
            Format::Apng { milliseconds, .. } => 1e-3 * f64::from(*milliseconds),
        }
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// [`PictureError`] if the system refuses.
    pub fn push(&mut self, picture: &Picture) -> Result<(), PictureError> {
        let written = match &mut self.format {
            Format::Gif { encoder, colours, known, delay } => {
                let mut frame =
                    Frame { width: picture.width as u16, height: picture.height as u16, ..Frame::default() };
                frame.delay = *delay;
                frame.buffer = indices(picture, colours, known).into();
                encoder.write_frame(&frame).map_err(|error| refused(&self.path, error))
            }
            Format::Apng { writer, .. } => {
                writer.write_image_data(&picture.bytes).map_err(|error| refused(&self.path, error))
            }
        };
        Ok(written?)
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// [`PictureError`] if the system refuses.
    pub fn finish(self) -> Result<(), PictureError> {
        let Animation { path, draft, format } = self;
        match format {
            Format::Gif { encoder, .. } => {
                let mut file = encoder.into_inner().map_err(|error| refused(&path, error))?;
                file.flush().map_err(|source| WriteError::new(&path, source))?;
            }
            Format::Apng { writer, .. } => writer.finish().map_err(|error| refused(&path, error))?,
        }
        Ok(draft.finish()?)
    }
}

/// The colours of a GIF, chosen from pictures.
fn palette(samples: &[Picture]) -> NeuQuant {
    // Each fourth pixel will do.
    let opaque = |pixel: &[u8]| [pixel[0], pixel[1], pixel[2], 255];
    let pixels: Vec<u8> =
        samples.iter().flat_map(|picture| picture.bytes.chunks_exact(3).step_by(4)).flat_map(opaque).collect();
    NeuQuant::new(THOROUGH, COLOURS, &pixels)
}

/// The nearest of the chosen colours for each pixel. Neighbours and frames are often alike, so that what was found is kept.
fn indices(picture: &Picture, colours: &NeuQuant, known: &mut Known) -> Vec<u8> {
    let nearest = |pixel: &[u8; 3]| {
        let place = pixel.iter().fold(0, |place, share| place << BITS | usize::from(share >> (8 - BITS)));
        *known[place].get_or_insert_with(|| {
            let [red, green, blue] = *pixel;
            colours.index_of(&[red, green, blue, 255]) as u8
        })
    };
    picture.bytes.as_chunks::<3>().0.iter().map(nearest).collect()
}
