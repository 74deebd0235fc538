//! A command that runs while a test goes on.

use std::process::{Child, Command};
use std::time::{Duration, Instant};

/// Waits until something is there that a running command leaves.
pub fn wait_for(child: &mut Child, what: &str, there: impl Fn() -> bool) {
    let patience = Instant::now() + Duration::from_secs(120);
    while !there() {
        assert!(child.try_wait().unwrap().is_none(), "the run ended before there was {what}");
        assert!(Instant::now() < patience, "no {what}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Sends a signal, such as `-TERM`.
pub fn signal(child: &Child, name: &str) {
    assert!(Command::new("kill").args([name, &child.id().to_string()]).status().unwrap().success());
}
