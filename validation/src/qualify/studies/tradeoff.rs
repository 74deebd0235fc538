//! What accuracy costs in time: few settings of Makadam, timed one after the other, alone on the machine; and the settings that scenes come
//! with, judged side by side.

use super::own_settings::OwnSettings;
use super::{Job, Named, Part, Place, QualifyError, scenes_named};
use crate::compare::FEW_SEEDS;
use crate::output::file_stem;
use crate::peers::{Code, Makadam};
use crate::plan::Scene;
use crate::provenance::account;
use crate::report::StudySection;
use crate::study::{Document, RunCache};
use crate::tradeoff::{Bound, Campaign, CampaignError, Outcome, Plan, QUICK_TIME_LIMIT, Scope, Study, Terms};
use std::path::PathBuf;
use std::sync::{Arc, Mutex};

pub(super) struct Tradeoff<'a> {
    place: Place<'a>,
    scenes: Vec<Named>,
    own_settings: Vec<OwnSettings<'a>>,
    outcomes: Mutex<Vec<Outcome>>,
}

impl<'a> Tradeoff<'a> {
    pub(super) fn open(scenes: &[(&'static str, u64)], place: Place<'a>) -> Result<Tradeoff<'a>, QualifyError> {
        let names: Vec<&'static str> = scenes.iter().map(|(name, _)| *name).collect();
        let seeds = scenes.iter().map(|(_, seeds)| *seeds);
        let scenes = scenes_named(&names, place)?;
        let judged = |((name, file, scene), seeds): (&Named, u64)| OwnSettings::new(name, file, scene, seeds, place);
        let own_settings = scenes.iter().zip(seeds).map(judged).collect();
        Ok(Tradeoff { place, scenes, own_settings, outcomes: Mutex::default() })
    }

    fn folder(&self, scene: &Scene) -> PathBuf {
        self.place.folder("tradeoff").join(file_stem(&scene.name))
    }

    fn plan(scene: &Scene) -> Plan {
        Plan::new(scene, Scope::Quick, &["Makadam"], &[1.0])
    }
}

impl Part for Tradeoff<'_> {
    fn alone(&self) -> Result<(), QualifyError> {
        let codes: [Box<dyn Code>; 1] = [Box::new(Makadam)];
        for (name, file, scene) in &self.scenes {
            (self.place.settings.say)(&format!(
                "{name}: settings of Makadam, timed one after the other, alone on the machine"
            ));
            let folder = self.folder(scene).join("runs");
            if self.place.settings.again && folder.is_dir() {
                std::fs::remove_dir_all(&folder).map_err(|error| crate::output::WriteError::new(&folder, error))?;
            }
            let outcome = Campaign {
                scene,
                scene_file: file,
                plan: &Self::plan(scene),
                seeds: FEW_SEEDS,
                codes: &codes,
                time_limit: QUICK_TIME_LIMIT,
                cache: &RunCache::open(&folder)?,
                progress: Arc::new(|_, _| {}),
            }
            .carry_out()
            .map_err(|error| match error {
                CampaignError::Scene(error) => error.into(),
                CampaignError::Write(error) => error.into(),
                CampaignError::Code(error) => QualifyError::from(error),
            })?;
            if outcome.interrupted {
                return Err(QualifyError::Interrupted);
            }
            self.outcomes.lock().expect("nothing panics while it holds the lock").push(outcome);
        }
        Ok(())
    }

    fn jobs(&self) -> Vec<Job<'_>> {
        self.own_settings.iter().flat_map(OwnSettings::jobs).collect()
    }

    fn section(&self) -> Result<StudySection, QualifyError> {
        let outcomes = self.outcomes.lock().expect("nothing panics while it holds the lock");
        let (mut tests, mut pages, mut notes) = (Vec::new(), Vec::new(), Vec::new());
        for ((name, _, scene), outcome) in self.scenes.iter().zip(&*outcomes) {
            let terms = Terms {
                quick: true,
                seeds: FEW_SEEDS,
                bounds: Bound::usual(),
                time_limit: QUICK_TIME_LIMIT,
                provenance: account(1, &[scene]),
            };
            let study = Study::new(scene, &Self::plan(scene), outcome, terms).with_findings();
            study.write(&self.folder(scene))?;
            pages.push(format!("tradeoff/{}/tradeoff.html", file_stem(&scene.name)));
            notes.extend(study.findings.iter().map(|finding| format!("{name}: {finding}")));
        }
        for own in &self.own_settings {
            tests.extend(own.tests()?);
        }
        let runs = || outcomes.iter().flat_map(|outcome| outcome.runs.iter().flatten());
        Ok(StudySection {
            name: "tradeoff".into(),
            title: "What accuracy costs".into(),
            scope: format!(
                "Makadam at few settings, {FEW_SEEDS} seeds each, against its own converged reference: timed one after the other on one \
                 core, alone on the machine. The settings that the scenes come with are judged with as many seeds as it takes to tell."
            ),
            runs: runs().count(),
            wall_seconds: runs().map(|kept| kept.run.wall_seconds).sum(),
            pages,
            tests,
            notes,
        })
    }
}
