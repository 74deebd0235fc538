//! A finished figure of a page.

use serde::{Deserialize, Serialize};

/// A finished figure.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Figure {
    /// Name of its file, without the ending.
    pub name: String,
    /// The drawing.
    pub svg: String,
    /// Caption.
    pub caption: String,
}
