//! Cases in codes, several side by side; each outcome is kept as soon as it is there, and taken up by the next start; the study is
//! written with each case that is finished.

use super::{Case, CaseResult, Outcome, StabilityError, Study, markdown};
use crate::output::{JSON_VERSION, WriteError, create_folder, write_whole};
use crate::peers::Code;
use crate::provenance::{JUDGE, account, scene_hash};
use crate::study::{Key, RunCache};
use makadam::BUILD;
use rayon::prelude::*;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

/// What is run.
pub struct Campaign<'a> {
    /// The cases, in the order in which they are shown.
    pub cases: &'a [Case],
    /// The codes.
    pub codes: &'a [Box<dyn Code>],
    /// Wall time after which a run is stopped, s.
    pub time_limit: f64,
    /// Folder of the study.
    pub folder: &'a Path,
    /// Whether cases are run again whose outcomes an earlier start has kept.
    pub again: bool,
    /// Told what begins.
    pub begins: &'a (dyn Fn(&Case, &dyn Code) + Sync),
    /// Told what has ended, and the share of all runs that have, 0 to 1.
    pub ended: &'a (dyn Fn(&Case, &Outcome, f64) + Sync),
}

impl Campaign<'_> {
    /// Runs every case in every code; `scenes`, `stability.md` and `stability.json` are written into the folder.
    ///
    /// # Errors
    /// [`StabilityError`]; what is finished stays written.
    pub fn carry_out(&self) -> Result<Study, StabilityError> {
        self.write_scenes()?;
        let study = Mutex::new(Study {
            version: JSON_VERSION,
            command: "stability",
            as_stated: true,
            cases: Vec::new(),
            unfinished: self.cases.iter().map(|case| case.name.clone()).collect(),
            codes: self.codes.iter().filter_map(|code| Some((code.name().to_string(), code.version()?))).collect(),
            time_limit: self.time_limit,
            provenance: account(rayon::current_num_threads(), &[]),
        });
        let done = AtomicUsize::new(0);
        let finish = |case: &Case| -> Result<(), StabilityError> {
            let outcomes =
                self.codes.par_iter().map(|code| self.run(case, &**code, &done)).collect::<Result<_, _>>()?;
            let mut study = study.lock().expect("nothing panics while it holds the lock");
            Ok(self.add(&mut study, CaseResult::new(case, outcomes))?)
        };
        let ended: Result<(), StabilityError> = self.cases.par_iter().map(finish).collect();
        let study = study.into_inner().expect("nothing panics while it holds the lock");
        match ended {
            Ok(()) => Ok(study),
            Err(StabilityError::Interrupted(_)) => Err(StabilityError::Interrupted(match study.cases.len() {
                0 => "nothing: no case was finished".into(),
                count => format!("{count} finished cases in {}", self.folder.join("stability.json").display()),
            })),
            Err(error) => Err(error),
        }
    }

    fn run(&self, case: &Case, code: &dyn Code, done: &AtomicUsize) -> Result<Outcome, StabilityError> {
        let outcome = self.take(case, code, self.again)?;
        let done = done.fetch_add(1, Ordering::Relaxed) + 1;
        (self.ended)(case, &outcome, done as f64 / (self.cases.len() * self.codes.len()) as f64);
        Ok(outcome)
    }

    /// How a case ended in a code: the outcome that is kept, unless it is to be made `again`; else that of a run now, which is kept.
    ///
    /// # Errors
    /// [`StabilityError`] if it has to be run and cannot.
    pub fn take(&self, case: &Case, code: &dyn Code, again: bool) -> Result<Outcome, StabilityError> {
        let cache = RunCache::open(&self.folder.join("outcomes"))?;
        cache.take(&self.key(case, code), again, || {
            (self.begins)(case, code);
            let limit = Duration::from_secs_f64(self.time_limit);
            match code.name() {
                "Makadam" => case.in_makadam(limit),
                name => case.in_peer(code, &self.folder.join("runs").join(&case.name).join(name), limit),
            }
        })
    }

    /// What an outcome follows from: the case, the code, how long it may take, the build, and the sources that judge.
    fn key(&self, case: &Case, code: &dyn Code) -> Key {
        let parts = [
            format!("{:016x}", scene_hash(&case.scene)),
            format!("{:?}", case.peer_step),
            format!("{} {}, {}", code.name(), code.version().unwrap_or_default(), code.contact_law()),
            self.time_limit.to_string(),
            BUILD.to_string(),
            JUDGE.to_string(),
        ];
        let name = format!("{}-{}", case.name, code.name().to_lowercase());
        Key::new(name, &parts.each_ref().map(String::as_str))
    }

    /// Takes in a case and writes the study.
    fn add(&self, study: &mut Study, result: CaseResult) -> Result<(), WriteError> {
        study.unfinished.retain(|name| *name != result.name);
        study.cases.push(result);
        study.cases.sort_by_key(|result| self.cases.iter().position(|case| case.name == result.name));
        study.as_stated = Study::all_as_stated(&study.cases);
        write_whole(&self.folder.join("stability.md"), markdown(study).as_bytes())?;
        let json = serde_json::to_vec_pretty(study).expect("a study holds only numbers, plain text and lists");
        write_whole(&self.folder.join("stability.json"), &json)
    }

    /// Writes the scene of each case to `scenes/CASE.toml`, to be run by hand.
    fn write_scenes(&self) -> Result<(), WriteError> {
        let folder = self.folder.join("scenes");
        create_folder(&folder)?;
        self.cases.iter().try_for_each(|case| {
            let text = toml::to_string(&case.scene).expect("a scene is made of plain tables");
            write_whole(&folder.join(format!("{}.toml", case.name)), text.as_bytes())
        })
    }
}
