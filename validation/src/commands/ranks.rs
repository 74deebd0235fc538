//! Runs on several ranks, started by a launcher of MPI: the first rank runs the command, the others follow.

use super::Failure;
use makadam::messages::Messages;
use makadam::{Scene, Simulation};
use std::sync::{Arc, Mutex, PoisonError};

/// Ranks of this run, if there are several.
static RANKS: Mutex<Option<Arc<dyn Messages>>> = Mutex::new(None);

/// Variables in which launchers state the number of processes: of Open MPI, and of MPICH and its descendants.
const LAUNCHED: [&str; 2] = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE"];

fn ranks() -> Option<Arc<dyn Messages>> {
    RANKS.lock().unwrap_or_else(PoisonError::into_inner).clone()
}

/// Returns the number of ranks of this run.
pub(super) fn count() -> usize {
    ranks().map_or(1, |ranks| ranks.ranks())
}

/// Joins the ranks of the launcher. Returns true on a rank that has followed the first one to the end of its run.
///
/// # Errors
/// [`Failure::Usage`] if the launcher has started several processes that do not know of each other, and for a command other than `run`.
pub(super) fn join(runs: bool) -> Result<bool, Failure> {
    let stated = LAUNCHED.iter().filter_map(|name| std::env::var(name).ok()?.parse::<usize>().ok());
    let launched = stated.max().unwrap_or(1);
    let joined = joined();
    let found = joined.as_ref().map_or(1, |ranks| ranks.ranks());
    // Not all launchers state the number; MPI knows it then.
    if found < launched {
        let remedy = match cfg!(feature = "mpi") {
            true => "use the launcher of the library of MPI that makadam was built with",
            false => "build makadam with --features mpi (scripts/install-mpi)",
        };
        return Err(Failure::Usage(format!(
            "a launcher has started {launched} processes, and each is a run of its own here; {remedy}, or start one process"
        )));
    }
    let Some(ranks) = joined.filter(|_| found > 1) else { return Ok(false) };
    if !runs {
        return match ranks.rank() {
            0 => Err(Failure::Usage(format!("only makadam run knows several ranks; start one process, not {found}"))),
            _ => Ok(true),
        };
    }
    // A rank that fails must not let the others wait: the launcher ends them.
    let report = std::panic::take_hook();
    std::panic::set_hook(Box::new(move |panic| {
        report(panic);
        std::process::exit(1)
    }));
    if ranks.rank() > 0 {
        // The first rank answers requests to stop.
        let _ = makadam_frames::interrupt::requested();
        makadam::follow(&ranks);
        return Ok(true);
    }
    *RANKS.lock().unwrap_or_else(PoisonError::into_inner) = Some(ranks);
    Ok(false)
}

/// Divides a simulation among the ranks, if there are several.
///
/// # Errors
/// [`Failure::Usage`] for settings that only one rank knows.
pub(super) fn divide(simulation: &mut Simulation, scene: &Scene) -> Result<(), Failure> {
    let Some(ranks) = ranks() else { return Ok(()) };
    simulation.divide_among(scene, &ranks).map_err(|error| Failure::Usage(error.to_string()))
}

/// Ends the other ranks.
pub(super) fn leave() {
    let ranks = RANKS.lock().unwrap_or_else(PoisonError::into_inner).take();
    if let Some(ranks) = ranks {
        makadam::dismiss(&ranks);
    }
}

#[cfg(feature = "mpi")]
fn joined() -> Option<Arc<dyn Messages>> {
    makadam::messages::mpi::World::join().map(|world| Arc::new(world) as Arc<dyn Messages>)
}

#[cfg(not(feature = "mpi"))]
fn joined() -> Option<Arc<dyn Messages>> {
    None
}
