//! Frames that are looked at one after the other, as often as a measure needs, wherever they are kept.
//!
//! Fields averaged over time need several passes. Frames need not be in memory for that.

use makadam::scene::Domain;
use makadam::snapshot::{Particle, Snapshot};
use std::borrow::Cow;
use std::convert::Infallible;
use std::ops::Range;

/// Frames in the order of time.
pub trait Frames {
    /// Error of a frame that cannot be shown.
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

    /// Shows some of the frames, one after the other; their contacts may be left out.
    ///
    /// # Errors
    /// As [`Frames::visit`].
    fn visit_grains(&self, range: Range<usize>, look: &mut dyn FnMut(&Snapshot)) -> Result<(), Self::Error> {
        self.visit(range, look)
    }
}

/// Frames with their grains inside the domain along periodic axes, wherever the frames that they come from have them.
pub(super) struct Wrapped<'a, F: ?Sized> {
    frames: &'a F,
    domain: &'a Domain,
}

impl<'a, F: Frames + ?Sized> Wrapped<'a, F> {
    /// Takes frames and the domain of their scene.
    pub fn new(frames: &'a F, domain: &'a Domain) -> Self {
        Self { frames, domain }
    }
}

impl<F: Frames + ?Sized> Frames for Wrapped<'_, F> {
    type Error = F::Error;

    fn count(&self) -> usize {
        self.frames.count()
    }

    fn grains(&self, range: Range<usize>) -> usize {
        self.frames.grains(range)
    }

    fn visit(&self, range: Range<usize>, look: &mut dyn FnMut(&Snapshot)) -> Result<(), F::Error> {
        self.frames.visit(range, &mut |frame| look(&wrapped(self.domain, frame)))
    }

    fn visit_grains(&self, range: Range<usize>, look: &mut dyn FnMut(&Snapshot)) -> Result<(), F::Error> {
        self.frames.visit_grains(range, &mut |frame| look(&wrapped(self.domain, frame)))
    }
}

/// A frame with its grains inside the domain along periodic axes.
pub(super) fn wrapped<'f>(domain: &Domain, frame: &'f Snapshot) -> Cow<'f, Snapshot> {
    let is_out = |grain: &Particle| {
        let mut axes = domain.periodic.iter().map(|axis| axis.number());
        axes.any(|axis| !(domain.min[axis]..domain.max[axis]).contains(&grain.position[axis]))
    };
    if !frame.particles.iter().any(is_out) {
        return Cow::Borrowed(frame);
    }
    let (mut inside, period, low) = (frame.clone(), domain.period(), domain.min.into());
    for grain in inside.particles.iter_mut().filter(|grain| is_out(grain)) {
        grain.position = period.wrapped(&grain.position.into(), &low).into();
    }
    Cow::Owned(inside)
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
