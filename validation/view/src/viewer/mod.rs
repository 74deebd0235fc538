//! A run as one HTML file: grains as spheres drawn by WebGL 2, walls, force chains, time. It needs no network.
//!
//! ```text
//! RunFrames ─> payload (quantised, zlib, base64) ─> page.html + page.css + shaders.js + page.js + controls.js ─> one file
//! ```

mod payload;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use makadam_frames::output::{WriteError, write_whole};
use makadam_frames::run_frames::{RunFolderError, RunFrames};
use payload::payload;
pub use payload::{Payload, Wishes, fields_of, unpack};
use std::io::Write;
use std::path::Path;

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
const SCRIPTS: [&str; 3] = [include_str!("shaders.js"), include_str!("page.js"), include_str!("controls.js")];

/// Level of zlib for the payload.
const LEVEL: u32 = 4;

/// Error of a page.
#[derive(Debug, thiserror::Error)]
pub enum ViewerError {
    /// The frames cannot be read.
    #[error(transparent)]
    Frames(#[from] RunFolderError),
    /// The system refuses.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// Written page.
#[derive(Clone, Debug)]
pub struct Page {
    /// Number of frames.
    pub frames: usize,
    /// Size of the file, bytes.
    pub bytes: usize,
    /// Note on content that was left out; empty if all is there.
    pub note: String,
}

/// Writes the page of a run. `progress` is told the share that is done.
///
/// # Errors
/// [`ViewerError`] if a frame cannot be read, or the system refuses.
pub fn write(path: &Path, run: &RunFrames, wishes: &Wishes, progress: &dyn Fn(f64)) -> Result<Page, ViewerError> {
    let Payload { bytes, frames, note } = payload(run, wishes, progress)?;
    let refused = |source| WriteError::new(path, source);
    let mut packer = ZlibEncoder::new(Vec::with_capacity(bytes.len() / 2), Compression::new(LEVEL));
    packer.write_all(&bytes).map_err(refused)?;
    let packed = packer.finish().map_err(refused)?;
    drop(bytes);
    let (title, script) = (escaped(run.scene()), SCRIPTS.concat());
    let mut text = String::with_capacity(PAGE.len() + STYLE.len() + script.len() + packed.len().div_ceil(3) * 4);
    for piece in pieces(PAGE) {
        match piece {
            Piece::Text(words) => text += words,
            Piece::Hole("title") => text += &title,
            Piece::Hole("style") => text += STYLE,
            Piece::Hole("script") => text += &script,
            Piece::Hole("size") => text += &format!("{:.1} MB", packed.len().div_ceil(3) as f64 * 4e-6),
            Piece::Hole("payload") => STANDARD.encode_string(&packed, &mut text),
            Piece::Hole(other) => unreachable!("page.html has a hole '{other}'"),
        }
    }
    write_whole(path, text.as_bytes())?;
    Ok(Page { frames, bytes: text.len(), note })
}

/// A part of a template.
#[derive(Debug, PartialEq)]
enum Piece<'t> {
    /// Text that stays as it is.
    Text(&'t str),
    /// `{{name}}`, which a value takes the place of.
    Hole(&'t str),
}

/// Splits a template at its holes, so that no value is searched for holes of its own.
fn pieces(template: &str) -> Vec<Piece<'_>> {
    let mut parts = template.split("{{");
    let mut pieces = vec![Piece::Text(parts.next().unwrap_or_default())];
    for part in parts {
        let (name, rest) = part.split_once("}}").expect("every hole of page.html is closed");
        pieces.extend([Piece::Hole(name), Piece::Text(rest)]);
    }
    pieces
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
