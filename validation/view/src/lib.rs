//! Figures of studies, pictures of frames, and the page that shows a run in a browser.

pub mod draw;
pub mod pictures;
pub mod viewer;
