//! Run as one HTML file: grains as spheres drawn by WebGL 2, walls, force chains, time. The file needs no network.
//!
//! ```text
//! RunFrames ─> payload (quantised, zlib, base64) ─> page.html + page.css + shaders.js + page.js + controls.js ─> one file
//! ```

mod payload;

use crate::draw::svg::escape;
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

/// Error during the writing of a page.
#[derive(Debug, thiserror::Error)]
pub enum ViewerError {
    /// Unreadable frames.
    #[error(transparent)]
    Frames(#[from] RunFolderError),
    /// Error of the system.
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
    /// Note on omitted content; empty if complete.
    pub note: String,
}

/// Writes the page of a run. `progress` receives the fraction done.
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
    let size = format!("{:.1} MB", packed.len().div_ceil(3) as f64 * 4e-6);
    let page = PAGE.replace("{{style}}", STYLE).replace("{{script}}", &SCRIPTS.concat()).replace("{{size}}", &size);
    let (before, after) = page.split_once("{{payload}}").expect("page.html has a place for it");
    // Last, so that placeholders in a title are not replaced.
    let mut text = before.replace("{{title}}", &escape(run.scene()));
    STANDARD.encode_string(&packed, &mut text);
    text += after;
    write_whole(path, text.as_bytes())?;
    Ok(Page { frames, bytes: text.len(), note })
}
