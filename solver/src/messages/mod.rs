//! Messages between the ranks of a run: processes, each with its own memory, that share its contacts.
//!
//! A rank is a process of MPI ([`mpi`], with the feature of that name) or whatever else implements [`Messages`], such as a thread in a test.

#[cfg(feature = "mpi")]
pub mod mpi;

use std::fmt::Debug;

/// Bytes to or from another rank, by its number.
pub type Parcel = (usize, Vec<u8>);

/// Messages between ranks. Every rank makes the same sequence of calls.
pub trait Messages: Debug + Send + Sync {
    /// Number of this rank, from 0.
    fn rank(&self) -> usize;

    /// Number of ranks.
    fn ranks(&self) -> usize;

    /// Sends parcels to other ranks, and fills parcels from other ranks; their lengths are known on both sides.
    fn exchange(&self, sent: &[Parcel], received: &mut [Parcel]);

    /// Returns the bytes of every rank, in the order of the ranks.
    fn gather(&self, own: &[u8]) -> Vec<Vec<u8>>;

    /// Replaces the bytes of every rank by those of one.
    fn broadcast(&self, bytes: &mut Vec<u8>, from: usize);
}
