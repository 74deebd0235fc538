//! A peer as a child process: started in its own group, watched, stopped whole.

use super::CodeError;
use rustix::process::{Pid, Signal, kill_process_group};
use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::{Read, Seek, SeekFrom};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Bytes of the log that an error quotes.
const TAIL: u64 = 600;

/// Free bytes below which a failure is put down to a full disk.
const FULL_DISK: u64 = 1 << 20;

/// A peer's program, and its version once that was asked for.
pub(super) struct Program {
    path: OsString,
    version: OnceLock<Option<String>>,
}

impl Program {
    /// A program by its name or path.
    pub fn new(path: impl Into<OsString>) -> Program {
        Program { path: path.into(), version: OnceLock::new() }
    }

    /// The program that an environment variable names, else the one on PATH.
    pub fn from_environment(variable: &str, name: &str) -> Program {
        Program::new(std::env::var_os(variable).unwrap_or_else(|| name.into()))
    }

    /// Its name or path.
    pub fn path(&self) -> &OsStr {
        &self.path
    }

    /// Its version as `version_in` finds it in what it prints with these arguments, else "unknown"; none if it is not there.
    pub fn version(&self, arguments: &[&str], version_in: impl Fn(&str) -> Option<&str>) -> Option<String> {
        let ask = || {
            let words = first_words(&self.path, arguments)?;
            Some(version_in(&words).unwrap_or("unknown").to_string())
        };
        self.version.get_or_init(ask).clone()
    }
}

/// One run of a program.
pub(super) struct Run<'a> {
    /// Name of the code, for errors.
    pub code: &'static str,
    /// The program.
    pub program: &'a OsStr,
    /// Its arguments.
    pub arguments: &'a [OsString],
    /// Folder in which it runs.
    pub folder: &'a Path,
    /// File for what it prints.
    pub log: PathBuf,
    /// Wall time after which it is stopped.
    pub limit: Duration,
    /// Called now and then while it runs.
    pub watch: &'a dyn Fn(),
}

/// Stops the whole group when dropped, so that nothing outlives an early return or a panic.
struct Group(Child);

impl Drop for Group {
    fn drop(&mut self) {
        let _ = kill_process_group(Pid::from_child(&self.0), Signal::KILL);
        let _ = self.0.wait();
    }
}

impl Run<'_> {
    /// Runs the program to its end.
    pub fn execute(&self) -> Result<(), CodeError> {
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
        let status = loop {
            if let Some(status) = group.0.try_wait().map_err(|source| io(&program, source))? {
                break status;
            }
            if crate::interrupt::requested() {
                return Err(CodeError::Interrupted { code: self.code });
            }
            if start.elapsed() > self.limit {
                drop(group);
                let seconds = self.limit.as_secs_f64();
                return Err(CodeError::TimedOut { code: self.code, seconds, log: self.log.clone() });
            }
            std::thread::sleep(pause);
            pause = (pause * 2).min(Duration::from_millis(200));
            (self.watch)();
        };
        if status.success() {
            return Ok(());
        }
        let tail = tail(&self.log);
        if tail.contains("No space left on device") {
            return Err(io(self.folder, std::io::ErrorKind::StorageFull.into()));
        }
        disk_has_room(self.folder)?;
        Err(CodeError::Crashed { code: self.code, status: status.to_string(), log: self.log.clone(), tail })
    }
}

/// An error if the disk under `folder` is full: programs that do not check their writes leave torn files then.
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

/// A command that is killed should this program die without a word; without `setpriv` it is a plain one.
fn tied(program: &Path) -> Command {
    match locate(OsStr::new("setpriv")) {
        Some(helper) => {
            let mut command = Command::new(helper);
            command.args(["--pdeathsig", "KILL", "--"]).arg(program);
            command
        }
        None => Command::new(program),
    }
}

/// The file of a program: itself if it is a path, else the first match on PATH.
pub(super) fn locate(program: &OsStr) -> Option<PathBuf> {
    let as_path = Path::new(program);
    if as_path.components().count() > 1 {
        return as_path.is_file().then(|| std::path::absolute(as_path).unwrap_or_else(|_| as_path.to_path_buf()));
    }
    std::env::split_paths(&std::env::var_os("PATH")?).map(|folder| folder.join(program)).find(|file| file.is_file())
}

/// What a program prints when asked for its version; nothing if it is not there, empty if it cannot be started or does
/// not answer in time. Why it cannot be started is told by the run that follows.
fn first_words(program: &OsStr, arguments: &[&str]) -> Option<String> {
    let program = locate(program)?;
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).process_group(0);
    let Ok(child) = command.spawn() else { return Some(String::new()) };
    let mut group = Group(child);
    let mut pipe = group.0.stdout.take()?;
    let reader = std::thread::spawn(move || {
        let mut words = vec![0; 4096];
        let mut length = 0;
        while length < words.len() {
            match pipe.read(&mut words[length..]) {
                Ok(0) | Err(_) => break,
                Ok(count) => length += count,
            }
        }
        words.truncate(length);
        String::from_utf8_lossy(&words).into_owned()
    });
    let start = Instant::now();
    while !reader.is_finished() && start.elapsed() < Duration::from_secs(10) {
        std::thread::sleep(Duration::from_millis(5));
    }
    drop(group);
    Some(reader.join().unwrap_or_default())
}

/// End of a log file, on one line.
fn tail(log: &Path) -> String {
    let read = || -> std::io::Result<Vec<u8>> {
        let mut file = File::open(log)?;
        let length = file.metadata()?.len();
        file.seek(SeekFrom::Start(length.saturating_sub(TAIL)))?;
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes)?;
        Ok(bytes)
    };
    let bytes = read().unwrap_or_default();
    String::from_utf8_lossy(&bytes).split_whitespace().collect::<Vec<_>>().join(" ")
}
