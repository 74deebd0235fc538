//! Frames that are looked at one after the other, as often as a measure needs, wherever they are kept.
//!
//! Some measures take more than one look: the bulk lies below a free surface that all frames have shaped, and only then can a
//! frame's contacts be told to lie in it. Frames need not be in memory for that: whoever has them shows them again.

use makadam::snapshot::Snapshot;
use std::convert::Infallible;
use std::ops::Range;

/// Frames in the order of time.
pub trait Frames {
    /// Why a frame could not be shown.
    type Error;

    /// Number of frames.
    fn count(&self) -> usize;

    /// Number of grains in some of the frames together.
    fn grains(&self, range: Range<usize>) -> usize;

    /// Shows some of the frames, one after the other.
    ///
    /// # Errors
    /// Where a frame cannot be shown; those before it have been.
    fn visit(&self, range: Range<usize>, look: &mut dyn FnMut(&Snapshot)) -> Result<(), Self::Error>;

    /// Shows all frames.
    ///
    /// # Errors
    /// As [`Frames::visit`].
    fn each(&self, look: &mut dyn FnMut(&Snapshot)) -> Result<(), Self::Error> {
        self.visit(0..self.count(), look)
    }
}

impl Frames for [&Snapshot] {
    type Error = Infallible;

    fn count(&self) -> usize {
        self.len()
    }

    fn grains(&self, range: Range<usize>) -> usize {
        self[range].iter().map(|frame| frame.particles.len()).sum()
    }

    fn visit(&self, range: Range<usize>, look: &mut dyn FnMut(&Snapshot)) -> Result<(), Infallible> {
        self[range].iter().for_each(|frame| look(frame));
        Ok(())
    }
}
