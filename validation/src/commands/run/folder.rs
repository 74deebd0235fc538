//! What an output folder holds before a run begins, and what may be done with it.

use super::kept::Place;
use crate::commands::Failure;
use crate::output::RunFiles;
use crate::plan::Scene;
use crate::provenance::scene_hash;
use serde_json::Value;
use std::path::Path;

/// What the summary of an earlier run says.
pub(super) struct Record {
    /// Whether it reached its last step.
    pub complete: bool,
    /// Steps taken.
    pub steps: u64,
    /// Name of the scene.
    pub scene: String,
    /// Whether it kept a ledger.
    pub ledger: bool,
    /// The summary itself.
    pub text: String,
    document: Value,
}

impl Record {
    /// The summary in a folder; none where there is none that can be read.
    pub fn read(output: &Path) -> Option<Record> {
        let text = std::fs::read_to_string(output.join(RunFiles::SUMMARY)).ok()?;
        let document: Value = serde_json::from_str(&text).ok()?;
        (document["command"] == "run").then_some(())?;
        Some(Record {
            complete: document["complete"].as_bool()?,
            steps: document["steps"].as_u64()?,
            scene: document["scene"].as_str()?.to_string(),
            ledger: !document["balance"].is_null(),
            text,
            document,
        })
    }

    /// Whether it is of this scene with these settings and this seed.
    pub fn is_of(&self, scene: &Scene, seed: u64) -> bool {
        let provenance = &self.document["provenance"];
        provenance["scene_hash"] == format!("{:016x}", scene_hash(scene)) && provenance["seed"] == seed
    }

    /// Its end in a line or two, for people.
    pub fn describe(&self) -> String {
        let text = |field: &str| self.document[field].as_str().unwrap_or("unknown").to_string();
        format!(
            "{}: complete since its {} steps were taken\nstate hash       {}\nframes, observables.csv and run.json: {}",
            self.scene,
            self.steps,
            text("state_hash"),
            text("output")
        )
    }
}

/// What is done in a folder.
pub(super) enum Task {
    /// A run begins; what an earlier one has left is removed.
    Begin,
    /// A run goes on from its checkpoint.
    GoOn,
    /// The run has ended already.
    Ended(Record),
}

/// How the command is to treat what it finds.
#[derive(Clone, Copy)]
pub(super) struct Wish {
    /// Go on from what is there.
    pub resume: bool,
    /// Remove what is there.
    pub restart: bool,
    /// Keep a ledger.
    pub ledger: bool,
    /// Steps of the run.
    pub steps: u64,
}

/// What to do in a folder that nobody else writes into: nothing that a run has left is touched unless that was asked for.
pub(super) fn task(output: &Path, scene: &Scene, seed: u64, wish: Wish) -> Result<Task, Failure> {
    let shown = output.display();
    let refuse = |what: String| Err(Failure::Usage(what));
    let (record, place) = (Record::read(output), Place::inside(output));
    let ended = record.as_ref().is_some_and(|record| record.complete);
    if wish.restart || !(place.is_taken() || RunFiles::inside(output).any()) {
        return Ok(Task::Begin);
    }
    let other = format!("{shown} holds a run of another scene, or with another seed or other settings");
    const WAYS: &str = "--restart removes it and begins anew, --output writes elsewhere";
    match record {
        Some(record) if ended && wish.resume => {
            let Record { steps, scene: name, .. } = &record;
            if !record.is_of(scene, seed) {
                return refuse(format!("{other} ({name}), which has ended: {WAYS}"));
            }
            if wish.ledger && !record.ledger {
                return refuse(format!("{shown} holds this run without a ledger, and it has ended: {WAYS}"));
            }
            if *steps != wish.steps {
                return refuse(format!(
                    "{shown} holds this run, which has ended after {steps} steps, not {}; one that has ended cannot be made longer \
                     or shorter: {WAYS}",
                    wish.steps
                ));
            }
            // A kill between the last word of the summary and the end of the program leaves them.
            place.clear();
            let _ = std::fs::remove_file(output.join(RunFiles::MEASURED));
            Ok(Task::Ended(record))
        }
        Some(Record { steps, scene: name, .. }) if ended => {
            refuse(format!("{shown} holds a run of {name} that has ended after {steps} steps: {WAYS}"))
        }
        _ if place.is_taken() && wish.resume => Ok(Task::GoOn),
        _ if place.is_taken() => refuse(format!(
            "{} is left of a run that did not end: --resume goes on from there, --restart throws it away, --output writes \
             elsewhere",
            place.file().display()
        )),
        Some(record) if wish.resume && record.is_of(scene, seed) => Ok(Task::Begin),
        Some(record) if wish.resume => refuse(format!("{other} ({}), which left no checkpoint: {WAYS}", record.scene)),
        Some(record) => refuse(format!(
            "{shown} holds what is left of a run of {} that did not end and left no checkpoint: {WAYS}",
            record.scene
        )),
        None => refuse(format!(
            "{shown} holds frames or tables of a run, but no {} that can be read: {WAYS}",
            RunFiles::SUMMARY
        )),
    }
}
