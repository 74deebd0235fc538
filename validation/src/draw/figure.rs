//! A finished figure of a page.

use serde::Serialize;

/// A finished figure.
#[derive(Serialize)]
pub(crate) struct Figure {
    /// Name of its file, without the ending.
    pub(crate) name: String,
    /// The drawing.
    pub(crate) svg: String,
    /// What it shows.
    pub(crate) caption: String,
}
