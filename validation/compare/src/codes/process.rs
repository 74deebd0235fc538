//! A code as a child process: started in its own group, watched, stopped as a group; the core fraction that it got.
//!
//! On a busy machine wall time depends on other processes. The time of a run is the processor time of its stepping on one core, for every code.
//! It is the wall time of the stepping, without set-up and output, times the fraction of a core that the run got.

use super::{CodeError, UNKNOWN_VERSION};
use makadam_frames::output::shown;
use rustix::process::{Pid, Signal, kill_process_group};
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom, Write};
use std::os::unix::process::CommandExt;
use std::path::{Component, Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Bytes of the log that an error quotes.
const TAIL: usize = 600;

/// Bytes of the end of a log that are searched for the reason of a failure.
const SEARCHED: u64 = 1 << 16;

/// Free bytes below which a failure is attributed to a full disk.
const FULL_DISK: u64 = 1 << 20;

/// Program of a reference code, and its version after the first request.
pub(super) struct Program {
    pub(super) path: OsString,
    pub(super) version: OnceLock<Option<String>>,
}

impl Program {
    /// Returns the version that `version_in` finds in the output for these arguments, else [`UNKNOWN_VERSION`]; none if the program is missing.
    pub fn version(&self, arguments: &[&str], version_in: impl Fn(&str) -> Option<&str>) -> Option<String> {
        let ask = || {
            let words = first_words(&self.path, arguments)?;
            Some(shown(version_in(&words).unwrap_or(UNKNOWN_VERSION), false).into_owned())
        };
        self.version.get_or_init(ask).clone()
    }
}

/// Declares a code with its program, given the program's name on `PATH`.
macro_rules! installed {
    ($(#[$about:meta])* $code:ident, $program:literal) => {
        $(#[$about])*
        pub struct $code {
            program: Program,
        }

        impl Default for $code {
            /// Returns the program that the code's environment variable names, else the one on `PATH`.
            fn default() -> Self {
                Self::new(std::env::var_os($crate::codes::process::variable_of(NAME)).unwrap_or_else(|| $program.into()))
            }
        }

        impl $code {
            /// Returns the code under another name or path of its program.
            pub fn new(program: impl Into<std::ffi::OsString>) -> Self {
                Self { program: Program { path: program.into(), version: Default::default() } }
            }
        }
    };
}
pub(super) use installed;

/// Environment variable that names a code's program.
pub(super) fn variable_of(code: &str) -> String {
    format!("MAKADAM_{}", code.to_uppercase())
}

/// Reason why a code's program is missing, and the remedy.
pub fn absent(code: &str) -> String {
    let variable = variable_of(code);
    match std::env::var_os(&variable) {
        None => format!("{code} is not installed; run scripts/install-codes"),
        Some(path) => {
            let path = Path::new(&path).display();
            format!("{code} does not run: {variable} names {path}, which is no program; correct it, or unset it")
        }
    }
}

/// One run of a program.
pub struct Run<'a> {
    /// Name of the code, for errors.
    pub code: &'static str,
    /// Program.
    pub program: &'a OsStr,
    /// Arguments.
    pub arguments: &'a [OsString],
    /// Working folder.
    pub folder: &'a Path,
    /// File for printed output.
    pub log: PathBuf,
    /// Log files of the program itself that may state the cause of a failure; that cause is added to the log.
    pub own_logs: &'a [PathBuf],
    /// Wall time after which the run is stopped.
    pub limit: Duration,
    /// Called at intervals during the run.
    pub watch: &'a dyn Fn(),
}

/// Stops the whole group when dropped, so that no process outlives an early return or a panic.
struct Group(Child);

impl Drop for Group {
    fn drop(&mut self) {
        let _ = kill_process_group(Pid::from_child(&self.0), Signal::KILL);
        let _ = self.0.wait();
    }
}

impl Run<'_> {
    /// Runs the program to its end. Returns the fraction of a core that it got, 0 to 1, if the run was long enough for the system to report one.
    pub fn execute(&self) -> Result<Option<f64>, CodeError> {
        let Some(program) = locate(self.program) else { return Err(CodeError::Missing { code: self.code }) };
        let log = File::create(&self.log).map_err(|source| io(&self.log, source))?;
        let log_copy = log.try_clone().map_err(|source| io(&self.log, source))?;
        let mut command = tied(&program);
        command
            .args(self.arguments)
            .current_dir(self.folder)
            .env("OMP_NUM_THREADS", "1")
            .stdin(Stdio::null())
            .stdout(log)
            .stderr(log_copy)
            .process_group(0);
        let mut group = Group(command.spawn().map_err(|source| io(&program, source))?);
        let start = Instant::now();
        let mut pause = Duration::from_millis(5);
        let mut core_share = None;
        let status = loop {
            if let Some(status) = group.0.try_wait().map_err(|source| io(&program, source))? {
                break status;
            }
            if makadam_frames::interrupt::requested() {
                return Err(CodeError::Interrupted { code: self.code });
            }
            if start.elapsed() > self.limit {
                drop(group);
                let seconds = self.limit.as_secs_f64();
                return Err(CodeError::TimedOut { code: self.code, seconds, log: self.log.clone() });
            }
            // Both times at the same moment: an ended process reports no more times.
            core_share = share_of(group.0.id(), start).or(core_share);
            std::thread::sleep(pause);
            pause = (pause * 2).min(Duration::from_millis(200));
            (self.watch)();
        };
        if status.success() {
            return Ok(core_share);
        }
        let tail = self.last_words();
        if tail.contains("No space left on device") {
            return Err(io(self.folder, std::io::ErrorKind::StorageFull.into()));
        }
        disk_has_room(self.folder)?;
        Err(CodeError::Crashed { code: self.code, status: status.to_string(), log: self.log.clone(), tail })
    }

    /// Returns the program's own cause of its failure; the log named to the user holds all of its output.
    fn last_words(&self) -> String {
        let printed = ending(&self.log);
        let own: Vec<String> = self.own_logs.iter().map(|log| ending(log)).collect();
        let appended = || -> std::io::Result<()> {
            let mut log = File::options().append(true).open(&self.log)?;
            for (file, text) in self.own_logs.iter().zip(&own).filter(|(_, text)| !text.is_empty()) {
                writeln!(log, "\n--- end of {} ---\n{text}", file.display())?;
            }
            Ok(())
        };
        // If the log cannot be extended, the output of the program is still in it.
        let _ = appended();
        last_words(&printed, &own)
    }
}

/// Returns the last line that reports an error, in the printed output or in the program's own logs, before the end of the printed output.
/// Output of an aborted program ends with messages of the process that aborted it.
fn last_words(printed: &str, own_logs: &[String]) -> String {
    let texts = || std::iter::once(printed).chain(own_logs.iter().map(String::as_str));
    let tells = |line: &&str| line.contains("ERROR") || line.contains("Error:");
    let reason = texts().find_map(|text| text.lines().rev().find(tells));
    let start = printed.ceil_char_boundary(printed.len().saturating_sub(TAIL));
    let words = reason.into_iter().chain([&printed[start..]]).flat_map(str::split_whitespace);
    shown(&words.collect::<Vec<_>>().join(" "), false).into_owned()
}

/// Returns an error if the disk under `folder` is full: programs that do not check their writes leave truncated files then.
pub(super) fn disk_has_room(folder: &Path) -> Result<(), CodeError> {
    match rustix::fs::statvfs(folder) {
        Ok(room) if room.f_bavail.saturating_mul(room.f_frsize) < FULL_DISK => {
            Err(io(folder, std::io::ErrorKind::StorageFull.into()))
        }
        _ => Ok(()),
    }
}

/// [`CodeError::Io`] for a path.
pub(super) fn io(path: &Path, source: std::io::Error) -> CodeError {
    CodeError::Io { path: path.display().to_string(), source }
}

/// Returns a command that is killed if this program dies without warning, and that prints line by line. Without `setpriv` and `stdbuf`
/// the command is a plain one.
fn tied(program: &Path) -> Command {
    // Line by line: buffered output is lost when a program aborts, and with it the cause.
    let helpers = [("setpriv", &["--pdeathsig", "KILL", "--"][..]), ("stdbuf", &["--output=L"][..])];
    let mut words: Vec<OsString> = Vec::new();
    for (name, arguments) in helpers {
        if let Some(helper) = locate(OsStr::new(name)) {
            words.push(helper.into());
            words.extend(arguments.iter().map(OsString::from));
        }
    }
    words.push(program.into());
    let mut command = Command::new(&words[0]);
    command.args(&words[1..]);
    command
}

/// Returns the file of a program: the path itself if `program` is one, else the first match on PATH.
pub(super) fn locate(program: &OsStr) -> Option<PathBuf> {
    let as_path = Path::new(program);
    if as_path.components().count() > 1 {
        return as_path.is_file().then(|| std::path::absolute(as_path).unwrap_or_else(|_| as_path.to_path_buf()));
    }
    std::env::split_paths(&std::env::var_os("PATH")?).map(|folder| folder.join(program)).find(|file| file.is_file())
}

/// Reads a program's output about its version; none if the program is missing, empty if it cannot be started. The run that follows
/// reports why.
fn first_words(program: &OsStr, arguments: &[&str]) -> Option<String> {
    let mut command = Command::new(locate(program)?);
    let answer = command.args(arguments).stdin(Stdio::null()).stderr(Stdio::null()).output();
    Some(answer.map_or_else(|_| String::new(), |answer| String::from_utf8_lossy(&answer.stdout).into_owned()))
}

/// End of a log file.
pub(super) fn ending(log: &Path) -> String {
    let read = || -> std::io::Result<Vec<u8>> {
        let mut file = File::open(log)?;
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(SEARCHED)))?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    String::from_utf8_lossy(&read().unwrap_or_default()).into_owned()
}

/// Clock ticks per second in the files of `/proc`: Linux reports 100 on every machine, whatever its internal tick.
const TICKS: f64 = 100.0;

/// Processor time of a stepping on this thread, from its start.
pub(super) struct ThreadClock {
    started: Instant,
    processor: f64,
}

impl ThreadClock {
    /// Starts the clock.
    pub(super) fn start() -> ThreadClock {
        ThreadClock { started: Instant::now(), processor: own_seconds() }
    }

    /// Processor time of a part of the thread's work since the start, s: its wall time times the core fraction; absent if no time has
    /// passed.
    pub(super) fn core_seconds(&self, wall: Duration) -> Option<f64> {
        Some(wall.as_secs_f64() * share(own_seconds() - self.processor, self.started.elapsed())?)
    }
}

/// Wall time below which ticks are too coarse for a fraction.
const SHORTEST: Duration = Duration::from_millis(300);

/// Fraction of a core that a process has got since its start, 0 to 1; absent in its first moments and where the system does not report it.
pub(super) fn share_of(process: u32, started: Instant) -> Option<f64> {
    let elapsed = started.elapsed();
    let text = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    let processor = seconds_in(&text)?;
    (elapsed >= SHORTEST).then(|| share(processor, elapsed)).flatten()
}

fn share(processor: f64, elapsed: Duration) -> Option<f64> {
    let elapsed = elapsed.as_secs_f64();
    (elapsed > 0.0).then(|| (processor / elapsed).clamp(0.0, 1.0))
}

/// Processor time of this thread, s.
fn own_seconds() -> f64 {
    // The files of /proc show a running thread as of its last tick, which is too coarse for a run of milliseconds.
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

/// Index of user time in a line of `stat` behind the program's name; system time follows.
const OWN: usize = 11;

/// User and system time in a line of `stat`, s.
fn seconds_in(line: &str) -> Option<f64> {
    // The program's name, in parentheses, may contain spaces.
    let fields: Vec<&str> = line.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |field: usize| fields.get(field)?.parse::<f64>().ok();
    Some((ticks(OWN)? + ticks(OWN + 1)?) / TICKS)
}

/// Checks that a pattern names files below the folder of a run.
///
/// # Errors
/// Message with reason and remedy, if the pattern leads out of the folder or is invalid.
pub(super) fn check_pattern(pattern: &str) -> Result<(), String> {
    let remedy = "name files below the folder in which the command runs, such as out/*.csv";
    let leads_out =
        |part: Component<'_>| matches!(part, Component::ParentDir | Component::RootDir | Component::Prefix(_));
    if pattern.is_empty() || Path::new(pattern).components().any(leads_out) {
        return Err(format!("'{pattern}' leads out of the folder of a run; {remedy}"));
    }
    match glob::Pattern::new(pattern) {
        Ok(_) => Ok(()),
        Err(error) => Err(format!("'{pattern}' is no pattern of files: {error}; {remedy}")),
    }
}

#[cfg(test)]
#[path = "../../tests/unit/codes_process.rs"]
mod tests;
