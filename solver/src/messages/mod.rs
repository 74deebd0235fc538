//! Messages between the ranks of a run: processes, each with its own memory, that share its contacts.
//!
//! A rank is a process of MPI (feature `mpi`) or whatever else implements [`Messages`], such as a thread in a test.

#[cfg(feature = "mpi")]
pub mod mpi;

use std::fmt::Debug;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// Messages between ranks. Every rank makes the same sequence of calls.
pub trait Messages: Debug + Send + Sync {
    /// Number of this rank, from 0.
    fn rank(&self) -> usize;

    /// Number of ranks.
    fn ranks(&self) -> usize;

    /// Sends bytes to other ranks, given by their numbers, and receives bytes from other ranks; their lengths are known on both sides.
    fn exchange(&self, sent: &[(usize, &[u8])], received: &mut [(usize, &mut [u8])]);

    /// Returns the bytes of every rank, in the order of the ranks.
    fn gather(&self, own: &[u8]) -> Vec<Vec<u8>>;

    /// Replaces the bytes of every rank by those of one.
    fn broadcast(&self, bytes: &mut Vec<u8>, from: usize);
}

/// Messages with the wall time that they take, which includes the wait for other ranks.
#[derive(Debug)]
pub(crate) struct Timed {
    messages: Arc<dyn Messages>,
    nanoseconds: AtomicU64,
}

impl Timed {
    pub fn new(messages: Arc<dyn Messages>) -> Timed {
        Timed { messages, nanoseconds: AtomicU64::new(0) }
    }

    /// Returns the wall time of all messages so far, s.
    pub fn seconds(&self) -> f64 {
        1e-9 * self.nanoseconds.load(Ordering::Relaxed) as f64
    }

    fn timed<R>(&self, call: impl FnOnce(&dyn Messages) -> R) -> R {
        let clock = Instant::now();
        let result = call(&*self.messages);
        self.nanoseconds.fetch_add(clock.elapsed().as_nanos() as u64, Ordering::Relaxed);
        result
    }
}

impl Messages for Timed {
    fn rank(&self) -> usize {
        self.messages.rank()
    }

    fn ranks(&self) -> usize {
        self.messages.ranks()
    }

    fn exchange(&self, sent: &[(usize, &[u8])], received: &mut [(usize, &mut [u8])]) {
        self.timed(|messages| messages.exchange(sent, received));
    }

    fn gather(&self, own: &[u8]) -> Vec<Vec<u8>> {
        self.timed(|messages| messages.gather(own))
    }

    fn broadcast(&self, bytes: &mut Vec<u8>, from: usize) {
        self.timed(|messages| messages.broadcast(bytes, from));
    }
}
