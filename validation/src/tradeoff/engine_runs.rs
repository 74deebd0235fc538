//! The runs of an engine that stands beside the codes: setting by setting, seed by seed, each kept as it ends.

use super::configuration::{Configuration, Knobs};
use super::engines::{EngineError, EngineOrigin, EngineRecord};
use super::kept::KeptRun;
use crate::compare::{Runs, Share};
use crate::output::WriteError;
use crate::peers::{Code, CodeError, CoreClock, Purpose};
use crate::plan::{Scene, physics_hash};
use crate::provenance::{Build, utc};
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// What is run of an engine.
pub struct EngineRuns<'a> {
    /// Its name.
    pub code: &'a str,
    /// Crate or package and its version.
    pub engine: &'a str,
    /// What is common to all settings, in words.
    pub common: &'a str,
    /// Name of the files that are written, without their ending.
    pub stem: &'a str,
    /// The scene.
    pub scene: &'a Scene,
    /// Its file.
    pub scene_file: &'a Path,
    /// Number of seeds, counted from 1.
    pub seeds: u64,
    /// Observables beside those that the scene compares.
    pub further: &'a [&'a str],
    /// Where the record is kept; runs that it holds are not made again.
    pub folder: &'a Path,
    /// The command line.
    pub command: &'a str,
}

/// Why runs of an engine ended early. What had been run is kept.
#[derive(Debug, thiserror::Error)]
pub enum EngineRunError {
    /// The engine failed.
    #[error(transparent)]
    Code(#[from] CodeError),
    /// The record cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// There is a record that cannot be read.
    #[error(transparent)]
    Damaged(#[from] EngineError),
    /// There is a record that these runs do not belong to; it would be lost.
    #[error("{}: it holds runs of {there}, and these are of {here}; move it away, or write into another folder", file.display())]
    Foreign {
        /// The file.
        file: PathBuf,
        /// What it holds.
        there: String,
        /// What was asked for.
        here: String,
    },
}

impl EngineRuns<'_> {
    /// Runs what the record does not hold: all settings with one seed, then with the next, so that a study that is stopped has
    /// something of each. Tells of each run as it ends.
    ///
    /// # Errors
    /// [`EngineRunError`].
    pub fn carry_out(
        &self,
        settings: &[(Knobs, Box<dyn Code>)],
        told: impl Fn(&KeptRun),
    ) -> Result<EngineRecord, EngineRunError> {
        let compared = self.scene.compare.iter().map(|expectation| expectation.observable.clone());
        let mut observables: Vec<String> = compared.collect();
        for name in self.further {
            if !observables.iter().any(|known| known == name) {
                observables.push((*name).into());
            }
        }
        let mut record = self.record()?;
        let announce = |_: &str| -> Share { Box::new(|_| {}) };
        for (seed, (knobs, code)) in (1..=self.seeds).flat_map(|seed| settings.iter().map(move |one| (seed, one))) {
            let configuration = Configuration { code: self.code.into(), stiffness_factor: 1.0, knobs: knobs.clone() };
            let is_this = |kept: &KeptRun| kept.configuration == configuration && kept.run.seed == seed;
            if record.runs.iter().any(is_this) {
                continue;
            }
            let asked = Runs {
                scene: self.scene,
                scene_file: self.scene_file,
                purpose: Purpose::Timing,
                seeds: vec![seed],
                rayleigh_fraction: 0.0,
                stiffness_factor: 1.0,
                time_limit: Duration::MAX,
                recordings: None,
                announce: &announce,
            };
            let clock = CoreClock::start();
            let run = asked.one(code.as_ref(), self.scene, seed)?.run;
            let kept = KeptRun {
                configuration,
                extrapolated: false,
                core_share: clock.share(),
                run,
                build: Build::here(),
                command: self.command.into(),
            };
            told(&kept);
            record.runs.push(kept);
            record.origin.date = utc(SystemTime::now());
            record.save(self.folder, self.stem, &observables)?;
        }
        Ok(record)
    }

    /// What the folder holds of this engine, scene and processor, to be gone on with; an empty record if it holds nothing.
    fn record(&self) -> Result<EngineRecord, EngineRunError> {
        let origin = EngineOrigin {
            code: self.code.into(),
            engine: self.engine.into(),
            common: self.common.into(),
            scene: self.scene.name.clone(),
            scene_hash: physics_hash(self.scene),
            date: utc(SystemTime::now()),
            command: self.command.into(),
            build: Build::here(),
        };
        let file = self.folder.join(format!("{}.json", self.stem));
        if !self.folder.join(format!("{}.csv", self.stem)).exists() {
            return Ok(EngineRecord { runs: Vec::new(), origin });
        }
        let kept = EngineRecord::load(self.folder, self.stem)?;
        let identity = |origin: &EngineOrigin| {
            let EngineOrigin { engine, scene, scene_hash, common, build, .. } = origin;
            format!("{engine} ({common}) on {scene} of hash {scene_hash}, {}", build.processor)
        };
        let (there, here) = (identity(&kept.origin), identity(&origin));
        if there != here {
            return Err(EngineRunError::Foreign { file, there, here });
        }
        Ok(EngineRecord { runs: kept.runs, origin })
    }
}
