//! A run as one HTML file: grains as spheres drawn by WebGL 2, walls, force chains, time. It needs no network.
//!
//! ```text
//! RunFrames ─> payload (quantised, zlib, base64) ─> page.html + page.css + shaders.js + page.js + controls.js ─> one file
//! ```

mod page;
mod payload;

pub use page::{Page, ViewerError, write};
pub use payload::{Payload, Wishes, fields_of, unpack};
