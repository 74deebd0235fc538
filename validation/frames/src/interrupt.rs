//! Ctrl-C, termination and the end of a terminal. The current step is finished, or abandoned if long, results so far are
//! written, and the command ends. Before a computation starts, for example during input of a scene from standard input, there is nothing to
//! write, and the first request ends the process at once, as a second request does at any time.

use libc::{SIG_IGN, SIGHUP, SIGINT, SIGTERM, c_int};
use makadam::Interrupt;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicBool, Ordering};

static INTERRUPT: LazyLock<Interrupt> = LazyLock::new(Interrupt::new);

/// True while a computation runs that polls for a request.
static POLLED: AtomicBool = AtomicBool::new(false);

/// Starts listening. A signal ignored at the start of the process stays ignored: `nohup` and background jobs of scripts
/// rely on that. If the system refuses, the default action stays.
pub fn listen() {
    // A handler may not allocate: its data are created before.
    LazyLock::force(&INTERRUPT);
    for signal in [SIGINT, SIGTERM, SIGHUP] {
        // SAFETY: a zeroed `sigaction` is a valid one (default action, empty mask, no flags); both pointers are to such.
        let inherited = unsafe {
            let mut inherited: libc::sigaction = std::mem::zeroed();
            (libc::sigaction(signal, std::ptr::null(), &raw mut inherited) == 0).then_some(inherited.sa_sigaction)
        };
        if inherited.is_none_or(|action| action == SIG_IGN) {
            continue;
        }
        // SAFETY: as above; the handler takes one number, as a handler without SA_SIGINFO does, and performs only permitted
        // operations: atomic operations and `_exit`.
        unsafe {
            let mut action: libc::sigaction = std::mem::zeroed();
            action.sa_sigaction = request as *const () as usize;
            action.sa_flags = libc::SA_RESTART;
            libc::sigaction(signal, &raw const action, std::ptr::null_mut());
        }
    }
}

extern "C" fn request(_signal: c_int) {
    let second = INTERRUPT.request();
    if second || !POLLED.load(Ordering::SeqCst) {
        // SAFETY: `_exit` runs nothing of this process and may be called in a handler.
        unsafe { libc::_exit(1) }
    }
}

/// Returns true if the user has requested a stop. From the first poll on, the polling code handles requests.
pub fn requested() -> bool {
    start_polling();
    INTERRUPT.is_requested()
}

/// Returns the flag that a simulation polls to stop inside a step.
pub fn handle() -> Interrupt {
    start_polling();
    INTERRUPT.clone()
}

fn start_polling() {
    // Many threads poll, and all but the first find the flag set.
    if !POLLED.load(Ordering::Relaxed) {
        POLLED.store(true, Ordering::SeqCst);
    }
}
