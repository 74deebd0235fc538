//! How much of a core a run got: on a busy machine wall time tells of the neighbours.

use std::time::Instant;

/// Clock ticks a second in the files of `/proc`: Linux shows 100 on every machine, whatever it counts in.
const TICKS: f64 = 100.0;

/// Watches the calling thread and the child processes that it waits for.
pub(super) struct CoreClock {
    started: Instant,
    processor: Option<f64>,
}

impl CoreClock {
    /// Starts watching.
    pub(super) fn start() -> CoreClock {
        CoreClock { started: Instant::now(), processor: processor_seconds() }
    }

    /// Processor time over elapsed time since the start, at most 1; absent where the system does not tell.
    pub(super) fn share(&self) -> Option<f64> {
        let processor = processor_seconds()? - self.processor?;
        let elapsed = self.started.elapsed().as_secs_f64();
        (elapsed > 0.0).then(|| (processor / elapsed).clamp(0.0, 1.0))
    }
}

/// Processor time of this thread and of the children that it has waited for, s.
fn processor_seconds() -> Option<f64> {
    let own = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    let nanoseconds: f64 = own.split_whitespace().next()?.parse().ok()?;
    let status = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The program's name, in brackets, may hold blanks; user and system time of the children are fields 16 and 17.
    let fields: Vec<&str> = status.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks: f64 = fields.get(13)?.parse::<f64>().ok()? + fields.get(14)?.parse::<f64>().ok()?;
    Some(1e-9 * nanoseconds + ticks / TICKS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn sleeping_takes_no_core_and_children_count() {
        let clock = CoreClock::start();
        std::thread::sleep(Duration::from_millis(300));
        assert!(clock.share().unwrap() < 0.3);
        let before = processor_seconds().unwrap();
        let busy = "i=0; while [ $i -lt 200000 ]; do i=$((i+1)); done";
        assert!(std::process::Command::new("sh").args(["-c", busy]).status().unwrap().success());
        assert!(processor_seconds().unwrap() > before + 0.02, "the loop of a child takes some hundredths of a second");
    }
}
