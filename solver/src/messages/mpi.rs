//! Messages by MPI.

use super::Messages;
use ::mpi::Threading;
use ::mpi::datatype::PartitionMut;
use ::mpi::environment::Universe;
use ::mpi::request::{WaitGuard, scope};
use ::mpi::topology::SimpleCommunicator;
use ::mpi::traits::{Communicator, CommunicatorCollectives, Destination, Root, Source};
use std::fmt;

/// All processes that a launcher of MPI has started together.
pub struct World {
    // Dropped last: it ends MPI.
    communicator: SimpleCommunicator,
    _universe: Universe,
}

impl World {
    /// Joins the processes of this launch; a process without a launcher is a world of its own. `None` after an earlier call.
    ///
    /// # Panics
    /// If the library of MPI does not let several threads call it one after another.
    pub fn join() -> Option<World> {
        let (universe, granted) = ::mpi::initialize_with_threading(Threading::Serialized)?;
        assert!(
            granted >= Threading::Serialized,
            "this MPI offers threads {granted:?}; build it with MPI_THREAD_SERIALIZED"
        );
        Some(World { communicator: universe.world(), _universe: universe })
    }
}

// SAFETY: MPI was started for calls from several threads one after another, and a simulation makes its calls one after another.
unsafe impl Send for World {}
// SAFETY: as above.
unsafe impl Sync for World {}

impl fmt::Debug for World {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "rank {} of {}", self.rank(), self.ranks())
    }
}

/// Largest number of bytes of one message: MPI counts in 32 bits with a sign.
const LARGEST: usize = 1 << 30;

impl Messages for World {
    fn rank(&self) -> usize {
        self.communicator.rank() as usize
    }

    fn ranks(&self) -> usize {
        self.communicator.size() as usize
    }

    fn exchange(&self, sent: &[(usize, &[u8])], received: &mut [(usize, &mut [u8])]) {
        scope(|scope| {
            let mut guards = Vec::new();
            for (rank, bytes) in received {
                let process = self.communicator.process_at_rank(*rank as i32);
                let parts = bytes.chunks_mut(LARGEST);
                guards.extend(parts.map(|part| WaitGuard::from(process.immediate_receive_into(scope, part))));
            }
            for (rank, bytes) in sent {
                let process = self.communicator.process_at_rank(*rank as i32);
                guards.extend(bytes.chunks(LARGEST).map(|part| WaitGuard::from(process.immediate_send(scope, part))));
            }
        });
    }

    fn gather(&self, own: &[u8]) -> Vec<Vec<u8>> {
        let mut lengths = vec![0_u64; self.ranks()];
        self.communicator.all_gather_into(&(own.len() as u64), &mut lengths[..]);
        let all = lengths.iter().sum::<u64>();
        // Empty buffers have equal addresses, which MPI refuses.
        if all == 0 {
            return vec![Vec::new(); self.ranks()];
        }
        if all > LARGEST as u64 {
            return (0..self.ranks())
                .map(|rank| {
                    let mut bytes = if rank == self.rank() { own.to_vec() } else { Vec::new() };
                    self.broadcast(&mut bytes, rank);
                    bytes
                })
                .collect();
        }
        let counts: Vec<i32> = lengths.iter().map(|&length| length as i32).collect();
        let starts: Vec<i32> =
            counts.iter().scan(0, |next, count| Some(std::mem::replace(next, *next + count))).collect();
        let mut all = vec![0; all as usize];
        self.communicator.all_gather_varcount_into(own, &mut PartitionMut::new(&mut all[..], &counts[..], &starts[..]));
        let part = |(&start, &count): (&i32, &i32)| all[start as usize..(start + count) as usize].to_vec();
        starts.iter().zip(&counts).map(part).collect()
    }

    fn broadcast(&self, bytes: &mut Vec<u8>, from: usize) {
        let root = self.communicator.process_at_rank(from as i32);
        let mut length = bytes.len() as u64;
        root.broadcast_into(&mut length);
        bytes.resize(length as usize, 0);
        bytes.chunks_mut(LARGEST).for_each(|part| root.broadcast_into(part));
    }
}
