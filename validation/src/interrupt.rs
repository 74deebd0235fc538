//! Ctrl-C, termination and the end of a terminal: the step at hand is finished, what was computed is written, and the command
//! ends. A second request ends the process at once.

use libc::{SIG_IGN, SIGHUP, SIGINT, SIGTERM, c_int};
use std::sync::atomic::{AtomicBool, Ordering};

static REQUESTED: AtomicBool = AtomicBool::new(false);

/// Starts listening. A signal that the process was started to ignore stays ignored: `nohup` relies on that, and so do jobs in
/// the background of a script. Where the system refuses, the default stays.
pub fn listen() {
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        // SAFETY: a zeroed `sigaction` is a valid one (default action, empty mask, no flags); both pointers are to such.
        let inherited = unsafe {
            let mut inherited: libc::sigaction = std::mem::zeroed();
            (libc::sigaction(signal, std::ptr::null(), &raw mut inherited) == 0).then_some(inherited.sa_sigaction)
        };
        if inherited.is_none_or(|action| action == SIG_IGN) {
            continue;
        }
        // SAFETY: as above; the handler takes one number, as a handler without SA_SIGINFO does, and does nothing but what is
        // allowed in one: an atomic exchange and `_exit`.
        unsafe {
            let mut action: libc::sigaction = std::mem::zeroed();
            action.sa_sigaction = request as *const () as usize;
            action.sa_flags = libc::SA_RESTART;
            libc::sigaction(signal, &raw const action, std::ptr::null_mut());
        }
    }
}

extern "C" fn request(_signal: c_int) {
    if REQUESTED.swap(true, Ordering::SeqCst) {
        // SAFETY: `_exit` runs nothing of this process and may be called in a handler.
        unsafe { libc::_exit(1) }
    }
}

/// Whether the user has asked to stop.
pub fn requested() -> bool {
    REQUESTED.load(Ordering::SeqCst)
}
