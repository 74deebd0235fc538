//! Sequence of frames from any storage, for measures that need several passes: fields averaged over time do.

use makadam::scene::Domain;
use makadam::snapshot::{Particle, Snapshot};
use std::borrow::Cow;
use std::convert::Infallible;
use std::ops::Range;

/// Frames in the order of time.
pub trait Frames {
    /// Error of a frame that cannot be provided.
    type Error;

    /// Returns the number of frames.
    fn count(&self) -> usize;

    /// Returns the total number of grains in a range of frames.
    fn grains(&self, range: Range<usize>) -> usize;

    /// Passes a range of frames to a function, one after the other.
    ///
    /// # Errors
    /// Error of the first frame that cannot be provided; earlier frames have been passed.
    fn visit(&self, range: Range<usize>, look: &mut dyn FnMut(&Snapshot)) -> Result<(), Self::Error>;

    /// Passes a range of frames to a function, one after the other, possibly without contacts.
    ///
    /// # Errors
    /// As [`Frames::visit`].
    fn visit_grains(&self, range: Range<usize>, look: &mut dyn FnMut(&Snapshot)) -> Result<(), Self::Error> {
        self.visit(range, look)
    }
}

/// Frames with their grains wrapped into the domain along periodic axes.
pub(super) struct Wrapped<'a, F: ?Sized> {
    frames: &'a F,
    domain: &'a Domain,
}

impl<'a, F: Frames + ?Sized> Wrapped<'a, F> {
    /// Wraps frames into the domain of their scene.
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

/// Returns a frame with its grains wrapped into the domain along periodic axes.
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
