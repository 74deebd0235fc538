//! Unit tests of `src/codes/process.rs`.

use super::last_words;

/// Log of LIGGGHTS for a mesh that it refuses: the reason is in its own log alone, the terminal has the abort.
const PRINTED: &str = "LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0)\n\
        --------------------------------------------------------------------------\n\
        MPI_ABORT was invoked on rank 0 in communicator MPI_COMM_WORLD\nwith errorcode 1.\n";
const OWN: &str = "Reading STL file 'wall1.stl'\n\
        ERROR: Mesh wall1: contains highly skewed element, see above (surface_mesh_I.h:512)\nLast input line: fix wall1\n";

#[test]
fn the_reason_goes_before_the_words_of_who_aborts() {
    let words = last_words(PRINTED, &[OWN.to_string()]);
    assert!(words.starts_with("ERROR: Mesh wall1: contains highly skewed element"), "{words}");
    assert!(words.contains("MPI_ABORT was invoked"), "{words}");
    // Printed by the program itself it is found there, and the last one counts.
    let twice = format!("ERROR: an earlier one\nERROR on proc 0: Lost atoms\n{PRINTED}");
    assert!(last_words(&twice, &[]).starts_with("ERROR on proc 0: Lost atoms"));
    assert_eq!(last_words("Segmentation fault\n", &[]), "Segmentation fault");
    assert_eq!(last_words("a\x1b[2Jb", &[]), r"a\u001b[2Jb", "a terminal is told nothing");
    let long = "\u{e9}".repeat(1000);
    assert!(last_words(&long, &[]).len() <= 601);
}
