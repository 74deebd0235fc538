//! The folder of one run of any code: made anew, given files, and searched for those that the run has left.

use super::CodeError;
use super::process::io;
use std::io::ErrorKind;
use std::path::{Component, Path, PathBuf};
use std::time::{Duration, SystemTime};

/// Clocks of file systems are as coarse as this.
const COARSE: Duration = Duration::from_secs(2);

/// A folder in which nothing lies but what the run was given, and what it leaves.
pub(super) struct RunFolder {
    path: PathBuf,
    /// Names of the files that it was given.
    given: Vec<String>,
    /// When it was given them, by the clock of the file system.
    started: SystemTime,
}

impl RunFolder {
    /// Empties the folder, or makes it, and writes files into it.
    ///
    /// # Errors
    /// [`CodeError::Io`] if the system refuses.
    pub fn fresh(path: &Path, input: Vec<(String, Vec<u8>)>) -> Result<RunFolder, CodeError> {
        match std::fs::remove_dir_all(path) {
            Err(source) if source.kind() != ErrorKind::NotFound => return Err(io(path, source)),
            _ => {}
        }
        std::fs::create_dir_all(path).map_err(|source| io(path, source))?;
        let (mut given, mut started) = (Vec::new(), SystemTime::now());
        for (name, bytes) in input {
            let file = path.join(&name);
            let written = std::fs::write(&file, bytes).and_then(|()| file.metadata()?.modified());
            let written = written.map_err(|source| io(&file, source))?;
            // The clock of a disk elsewhere may be behind that of this machine.
            started = started.min(written);
            given.push(name);
        }
        Ok(RunFolder { path: path.to_path_buf(), given, started })
    }

    /// The files of a pattern, in the order of their names.
    ///
    /// # Errors
    /// Where there are none, or one that is not of this run, in words.
    pub fn files(&self, pattern: &str) -> Result<Vec<PathBuf>, String> {
        let whole = Path::new(&glob::Pattern::escape(&self.path.display().to_string())).join(pattern);
        let paths = glob::glob(&whole.display().to_string()).map_err(|error| error.to_string())?;
        let paths: Vec<PathBuf> = paths.collect::<Result<_, _>>().map_err(|error| error.to_string())?;
        let mut files: Vec<PathBuf> = paths.into_iter().filter(|path| path.is_file()).collect();
        if files.is_empty() {
            return Err(format!("the run has left no file {pattern}"));
        }
        files.iter().try_for_each(|file| self.is_of_run(file))?;
        files.sort();
        Ok(files)
    }

    /// Refuses what the run did not make.
    fn is_of_run(&self, file: &Path) -> Result<(), String> {
        let whole = |path: &Path| path.canonicalize().map_err(|error| format!("{}: {error}", path.display()));
        let (real, folder) = (whole(file)?, whole(&self.path)?);
        let name = file.file_name().unwrap_or_default().display();
        let Ok(below) = real.strip_prefix(&folder) else {
            return Err(format!(
                "{name} is a link to {}, out of the folder of the run; leave the file itself",
                real.display()
            ));
        };
        if self.given.iter().any(|given| Path::new(given) == below) {
            return Err(format!(
                "{} is what the run was given; let it leave its frames under another name, and name those alone",
                below.display()
            ));
        }
        let modified = real.metadata().and_then(|data| data.modified()).map_err(|error| format!("{name}: {error}"))?;
        match self.started.duration_since(modified) {
            Ok(before) if before > COARSE => Err(format!(
                "{name} was written {:.0} s before the run began: it is of another one; let each run write its frames anew",
                before.as_secs_f64()
            )),
            _ => Ok(()),
        }
    }
}

/// Checks that a pattern names files below the folder of a run.
///
/// # Errors
/// Why not, and the remedy.
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
#[path = "../../tests/unit/codes_run_folder.rs"]
mod tests;
