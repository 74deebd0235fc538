//! Ctrl-C and termination: the step at hand is finished, or given up where it takes long, what was computed is written, and the
//! command ends.

use makadam::Interrupt;
use std::sync::LazyLock;

static INTERRUPT: LazyLock<Interrupt> = LazyLock::new(Interrupt::new);

/// Starts listening; a second request ends the process at once. Where the system refuses, the default stays.
pub fn listen() {
    let interrupt = handle();
    let _ = ctrlc::set_handler(move || {
        if interrupt.request() {
            std::process::exit(1);
        }
    });
}

/// Whether the user has asked to stop.
pub fn requested() -> bool {
    INTERRUPT.is_requested()
}

/// What a simulation must heed to be stopped inside a step.
pub fn handle() -> Interrupt {
    INTERRUPT.clone()
}
