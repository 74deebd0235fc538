//! Picture files: PNG, and animations as GIF.

use super::Picture;
use color_quant::NeuQuant;
use gif::{Encoder, Frame, Repeat};
use makadam_frames::output::{Draft, WriteError, write_whole};
use std::fs::File;
use std::io::{BufWriter, Error, Write};
use std::path::{Path, PathBuf};

/// Number of colours of a GIF.
const COLOURS: usize = 256;

/// Sampling of colours for a GIF, 1 (best) to 30.
const THOROUGH: i32 = 10;

/// Number of frames sampled for the colours of a GIF.
const SAMPLES: usize = 3;

/// Error of a picture that cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum PictureError {
    /// Error of the system.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// File name without a known format.
    #[error("{file}: its name must end in {known}")]
    Format {
        /// File.
        file: String,
        /// Known extensions.
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
        return Err(PictureError::Format { file: path.display().to_string(), known: ".png, or .gif for an animation" });
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

/// Returns true if a file name is that of an animation.
pub fn is_animation(path: &Path) -> bool {
    ending(path) == "gif"
}

fn ending(path: &Path) -> String {
    path.extension().map_or(String::new(), |ending| ending.to_string_lossy().to_ascii_lowercase())
}

/// Animation written frame by frame into a temporary file, which is renamed when complete and removed if incomplete.
pub struct Animation {
    path: PathBuf,
    draft: Draft,
    encoder: Encoder<BufWriter<File>>,
    colours: Box<NeuQuant>,
    /// Cache of the nearest GIF colour for a colour of a picture, by the upper bits of its red, green and blue.
    known: Vec<Option<u8>>,
    /// Duration of a frame, hundredths of a second.
    delay: u16,
}

/// Bits per colour component in the choice of the nearest colour: the chosen colours are further apart.
const BITS: u32 = 6;

impl Animation {
    /// Begins a GIF with `rate` frames per second and colours chosen from `samples`, at least one.
    ///
    /// # Errors
    /// [`PictureError`] if the name has another extension, or the system refuses.
    pub fn begin(path: &Path, samples: &[Picture], rate: f64) -> Result<Animation, PictureError> {
        let format = || PictureError::Format { file: path.display().to_string(), known: ".gif or .png" };
        let first = samples.first().filter(|_| is_animation(path)).ok_or_else(format)?;
        let draft = Draft::of(path);
        let file = File::create(draft.name()).map_err(|source| WriteError::new(path, source))?;
        let colours = Box::new(palette(samples));
        let (width, height) = (first.width as u16, first.height as u16);
        let encoder = Encoder::new(BufWriter::new(file), width, height, &colours.color_map_rgb());
        let mut encoder = encoder.map_err(|error| refused(path, error))?;
        encoder.set_repeat(Repeat::Infinite).map_err(|error| refused(path, error))?;
        let (known, delay) = (vec![None; 1 << (3 * BITS)], (100.0 / rate).round().max(1.0) as u16);
        Ok(Animation { path: path.to_path_buf(), draft, encoder, colours, known, delay })
    }

    /// Returns the best sample frames for [`Animation::begin`], out of `frames`.
    pub fn samples(frames: usize) -> Vec<usize> {
        let mut samples: Vec<usize> = (0..SAMPLES).map(|part| part * (frames - 1) / (SAMPLES - 1).max(1)).collect();
        samples.dedup();
        samples
    }

    /// Returns the duration of a frame, s: the nearest that the format permits.
    pub fn seconds_per_frame(&self) -> f64 {
        0.01 * f64::from(self.delay)
    }

    /// Adds a frame.
    ///
    /// # Errors
    /// [`PictureError`] if the system refuses.
    pub fn push(&mut self, picture: &Picture) -> Result<(), PictureError> {
        let (width, height) = (picture.width as u16, picture.height as u16);
        let buffer = indices(picture, &self.colours, &mut self.known).into();
        let frame = Frame { width, height, delay: self.delay, buffer, ..Frame::default() };
        self.encoder.write_frame(&frame).map_err(|error| refused(&self.path, error))?;
        Ok(())
    }

    /// Renames the file to its final name.
    ///
    /// # Errors
    /// [`PictureError`] if the system refuses.
    pub fn finish(self) -> Result<(), PictureError> {
        let Animation { path, draft, encoder, .. } = self;
        let mut file = encoder.into_inner().map_err(|error| refused(&path, error))?;
        file.flush().map_err(|source| WriteError::new(&path, source))?;
        Ok(draft.finish()?)
    }
}

/// Chooses the colours of a GIF from pictures.
fn palette(samples: &[Picture]) -> NeuQuant {
    // Every fourth pixel suffices.
    let opaque = |pixel: &[u8]| [pixel[0], pixel[1], pixel[2], 255];
    let pixels: Vec<u8> =
        samples.iter().flat_map(|picture| picture.bytes.chunks_exact(3).step_by(4)).flat_map(opaque).collect();
    NeuQuant::new(THOROUGH, COLOURS, &pixels)
}

/// Returns the nearest of the chosen colours for each pixel. Neighbours and frames are often alike, so results are cached.
fn indices(picture: &Picture, colours: &NeuQuant, known: &mut [Option<u8>]) -> Vec<u8> {
    let nearest = |pixel: &[u8; 3]| {
        let place = pixel.iter().fold(0, |place, share| place << BITS | usize::from(share >> (8 - BITS)));
        *known[place].get_or_insert_with(|| {
            let [red, green, blue] = *pixel;
            colours.index_of(&[red, green, blue, 255]) as u8
        })
    };
    picture.bytes.as_chunks::<3>().0.iter().map(nearest).collect()
}
