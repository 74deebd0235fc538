//! Finished figure of a page.

use serde::{Deserialize, Serialize};

/// Finished figure.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Figure {
    /// Name of its file, without the extension.
    pub name: String,
    /// Drawing as SVG.
    pub svg: String,
    /// Caption.
    pub caption: String,
}
