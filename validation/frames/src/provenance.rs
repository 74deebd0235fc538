//! Provenance of a result: version, commit, compiler, machine, seed, scene, settings.

use crate::execution::Execution;
pub use crate::plan::scene_hash;

use crate::plan::MeasuredScene;
use crate::stepping::steps_in;
use makadam::checkpoint::checksum;
use makadam::lanes::InstructionSet;
use makadam::scene::SolverSettings;
use makadam::schedule::Scheduler;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::Path;
use std::sync::OnceLock;
use std::time::{SystemTime, UNIX_EPOCH};

/// Version of Makadam.
pub const VERSION: &str = env!("CARGO_PKG_VERSION");

/// Commit of the running program and whether its sources differed from it, as set at the start of the program.
static COMMIT: OnceLock<(String, Option<bool>)> = OnceLock::new();

/// Sets the commit of the running program, and whether its sources differed from it; only the first call has an effect.
pub fn set_commit(commit: &str, dirty: Option<bool>) {
    let _ = COMMIT.set((commit.into(), dirty));
}

/// Build of the program, and its machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Build {
    pub version: String,
    /// [`makadam::BUILD`], the key of builds with possibly different bits; empty in records from before this field.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub build: String,
    pub commit: String,
    /// True if tracked files differed from the commit; absent if unknown.
    pub dirty: Option<bool>,
    pub compiler: String,
    pub target: String,
    pub profile: String,
    /// Instruction set of the contact sweeps.
    pub instruction_set: String,
    pub processor: String,
}

impl Build {
    /// Returns the running program on this machine.
    pub fn here() -> Build {
        let (commit, dirty) = COMMIT.get().cloned().unwrap_or_else(|| ("unknown".into(), None));
        Build {
            version: VERSION.into(),
            build: makadam::BUILD.into(),
            commit,
            dirty,
            compiler: env!("MAKADAM_COMPILER").into(),
            target: env!("MAKADAM_TARGET").into(),
            profile: env!("MAKADAM_PROFILE").into(),
            instruction_set: InstructionSet::detect().name().into(),
            processor: processor(),
        }
    }

    /// Returns version, commit and build key as text, such as "0.1.0 (1a2b3c4d, modified, build 0123456789abcdef)".
    pub fn summary(&self) -> String {
        let commit: String = self.commit.chars().take(8).collect();
        let modified = if self.dirty == Some(true) { ", modified" } else { "" };
        let key = self.build.rsplit('-').next().unwrap_or_default();
        format!("{} ({commit}{modified}, build {key})", self.version)
    }
}

/// Provenance of one run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Provenance {
    #[serde(flatten)]
    pub build: Build,
    /// Number of ranks; left out if it is 1.
    #[serde(default = "one", skip_serializing_if = "is_one")]
    pub ranks: usize,
    pub threads: usize,
    pub scheduler: Scheduler,
    pub seed: u64,
    pub scene_file: String,
    /// [`scene_hash`] as 16 hexadecimal digits.
    pub scene_hash: String,
    /// Solver settings of the run, tolerances included.
    pub solver: SolverSettings,
    /// Preparation of a flowing start, excluded from the run's steps and times.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prepared: Option<Prepared>,
    /// Start of the run, ISO 8601, UTC.
    pub time: String,
    pub command: String,
}

fn one() -> usize {
    1
}

fn is_one(ranks: &usize) -> bool {
    *ranks == 1
}

/// Preparation of the flowing initial state of a run.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Prepared {
    pub seconds: f64,
    pub steps: u64,
    pub time_step: f64,
}

impl Prepared {
    /// Returns the preparation that a scene requests.
    pub fn of(scene: &MeasuredScene) -> Option<Prepared> {
        scene.prepare.as_ref().map(|prepare| Prepared {
            seconds: prepare.duration,
            steps: steps_in(prepare.duration, prepare.step),
            time_step: prepare.step,
        })
    }
}

impl Provenance {
    /// Returns the provenance of a run that starts now.
    pub fn of_run(scene: &MeasuredScene, scene_file: &Path, seed: u64, execution: &Execution) -> Provenance {
        Provenance {
            build: Build { instruction_set: execution.instruction_set.name().into(), ..Build::here() },
            ranks: 1,
            threads: execution.threads,
            scheduler: execution.scheduler,
            seed,
            scene_file: from_here(scene_file).display().to_string(),
            scene_hash: format!("{:016x}", scene_hash(scene)),
            solver: scene.solver.clone(),
            prepared: Prepared::of(scene),
            time: utc(SystemTime::now()),
            command: command_line(),
        }
    }

    /// Returns names and values as text, for tables.
    pub fn pairs(&self) -> Vec<(String, String)> {
        let Ok(serde_json::Value::Object(fields)) = serde_json::to_value(self) else { return Vec::new() };
        let plain = |value: serde_json::Value| match value {
            serde_json::Value::String(text) => text,
            other => other.to_string(),
        };
        fields.into_iter().map(|(key, value)| (key.replace('_', " "), plain(value))).collect()
    }
}

/// Returns a path relative to the working folder, if it lies below: records are moved to other machines.
fn from_here(path: &Path) -> &Path {
    std::env::current_dir().ok().and_then(|here| path.strip_prefix(here).ok()).unwrap_or(path)
}

/// Returns the provenance of a comparison by name, for tables.
pub fn account(threads: usize, scenes: &[&MeasuredScene]) -> BTreeMap<String, String> {
    let build = Build::here();
    let modified = match build.dirty {
        Some(true) => ", with changes",
        Some(false) => "",
        None => ", changes unknown",
    };
    let mut account = BTreeMap::from(
        [
            ("version", build.version),
            ("commit", format!("{}{modified}", build.commit)),
            ("compiler", build.compiler),
            ("target", format!("{}, {}", build.target, build.profile)),
            ("instruction_set", build.instruction_set),
            ("processor", build.processor),
            ("threads", threads.to_string()),
            ("date", utc(SystemTime::now())),
            ("command", command_line()),
        ]
        .map(|(name, value)| (name.to_string(), value)),
    );
    for scene in scenes {
        account.insert(format!("scene_hash_of_{}", scene.name), format!("{:016x}", scene_hash(scene)));
    }
    account
}

/// Returns processor and version from a comparison's provenance, for the head of a report.
pub fn facts(account: &BTreeMap<String, String>) -> Vec<String> {
    let of = |key: &str| account.get(key).cloned();
    let version = of("version").map(|version| format!("version {version}"));
    [of("processor"), version].into_iter().flatten().collect()
}

/// Arguments of the program, if set by a caller.
static ARGUMENTS: OnceLock<Vec<OsString>> = OnceLock::new();

/// Sets the arguments for [`command_line`], the first being the program's name; only the first call has an effect.
pub fn set_command_line(arguments: &[OsString]) {
    let _ = ARGUMENTS.set(arguments.to_vec());
}

/// Returns the command line of this process, with the program's name instead of its path.
pub fn command_line() -> String {
    let arguments = ARGUMENTS.get().cloned().unwrap_or_else(|| std::env::args_os().collect());
    // A path may be invalid text.
    let words = arguments.iter().skip(1).map(|argument| argument.to_string_lossy().into_owned());
    let arguments = words.map(|argument| match argument.contains(char::is_whitespace) {
        true => format!("'{argument}'"),
        false => argument,
    });
    std::iter::once("makadam".to_string()).chain(arguments).collect::<Vec<_>>().join(" ")
}

/// Returns a time as ISO 8601 in UTC, to the second.
pub fn utc(time: SystemTime) -> String {
    let seconds = time.duration_since(UNIX_EPOCH).map_or(0, |elapsed| elapsed.as_secs());
    let (days, rest) = (seconds / 86_400, seconds % 86_400);
    let (year, month, day) = civil_date(days);
    format!("{year:04}-{month:02}-{day:02}T{:02}:{:02}:{:02}Z", rest / 3600, rest / 60 % 60, rest % 60)
}

/// Returns year, month and day of a number of days after 1970-01-01, by whole 400-year eras of the Gregorian calendar
/// with years from the first of March.
fn civil_date(days: u64) -> (u64, u64, u64) {
    let shifted = days + 719_468;
    let (era, day_of_era) = (shifted / 146_097, shifted % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month_from_march = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month_from_march + 2) / 5 + 1;
    let month = if month_from_march < 10 { month_from_march + 3 } else { month_from_march - 9 };
    (era * 400 + year_of_era + u64::from(month <= 2), month, day)
}

/// Returns the model of the processor, from the system.
pub fn processor() -> String {
    of_processor("model name").unwrap_or_else(|| std::env::consts::ARCH.into())
}

/// Returns the machine, distinct from others with the same processor name if the system permits: times of different machines are not comparable.
pub fn machine() -> String {
    let told =
        ["cpu family", "model", "stepping", "cache size", "flags"].map(of_processor).map(Option::unwrap_or_default);
    let id = std::fs::read_to_string("/etc/machine-id").unwrap_or_default();
    let apart = checksum(format!("{}/{}", told.join("/"), id.trim()).as_bytes());
    format!("{} {apart:016x}", processor())
}

/// Reads a property of the first processor.
fn of_processor(name: &str) -> Option<String> {
    let information = std::fs::read_to_string("/proc/cpuinfo").ok()?;
    information.lines().find_map(|line| Some(line.strip_prefix(name)?.trim_start().strip_prefix(':')?.trim().into()))
}

/// Returns the largest resident memory of this process so far, bytes; 0 if the system does not report it.
pub fn peak_bytes() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:")?.trim().strip_suffix("kB"));
    peak.and_then(|kilobytes| kilobytes.trim().parse::<u64>().ok()).map_or(0, |kilobytes| kilobytes * 1024)
}

#[cfg(test)]
#[path = "../tests/unit/provenance.rs"]
mod tests;
