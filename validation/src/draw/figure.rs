//! A finished figure of a page.

use serde::Serialize;

/// A finished figure.
#[derive(Serialize)]
pub struct Figure {
    /// Name of its file, without the ending.
    pub name: String,
    /// The drawing.
    pub svg: String,
    /// What it shows.
    pub caption: String,
}
