//! How much of a core a run got: on a busy machine wall time tells of the neighbours.

use std::time::Instant;

/// Clock ticks a second in the files of `/proc`: Linux shows 100 on every machine, whatever it counts in.
const TICKS: f64 = 100.0;

/// Watches the calling thread and the child processes that it waits for.
pub struct CoreClock {
    started: Instant,
    processor: Option<f64>,
}

impl CoreClock {
    /// Starts watching.
    pub fn start() -> CoreClock {
        CoreClock { started: Instant::now(), processor: processor_seconds() }
    }

    /// Processor time over elapsed time since the start, at most 1; absent where the system does not tell.
    pub fn share(&self) -> Option<f64> {
        let processor = processor_seconds()? - self.processor?;
        let elapsed = self.started.elapsed().as_secs_f64();
        (elapsed > 0.0).then(|| (processor / elapsed).clamp(0.0, 1.0))
    }
}

/// Processor time of this thread and of the children that it has waited for, s.
fn processor_seconds() -> Option<f64> {
    Some(own_seconds()? + children_seconds()?)
}

/// Processor time of this thread, s.
fn own_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?;
    text.split_whitespace().next()?.parse::<f64>().ok().map(|nanoseconds| 1e-9 * nanoseconds)
}

/// Processor time of children that have ended, s.
fn children_seconds() -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The program's name, in brackets, may hold blanks; user and system time of the children are fields 16 and 17.
    let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |field: usize| fields.get(field)?.parse::<f64>().ok();
    Some((ticks(13)? + ticks(14)?) / TICKS)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn sleeping_takes_no_core() {
        // Of this thread alone: other tests may wait for children meanwhile.
        let before = own_seconds().unwrap();
        std::thread::sleep(Duration::from_millis(200));
        assert!(own_seconds().unwrap() - before < 0.1);
    }

    #[test]
    fn children_count() {
        let before = children_seconds().unwrap();
        let busy = "i=0; while [ $i -lt 300000 ]; do i=$((i+1)); done";
        assert!(std::process::Command::new("sh").args(["-c", busy]).status().unwrap().success());
        assert!(children_seconds().unwrap() > before + 0.02, "the loop takes some hundredths of a second");
    }
}
