//! Scenes with each of their effects off, or on: an effect that a scene is known to need must move what is measured.

use super::{Job, Part, Place, QualifyError, test};
use crate::compare::KeptRuns;
use crate::effects::{Ablation, Need, Plan, Study};
use crate::execution::Execution;
use crate::peers::Makadam;
use crate::plan::Scene;
use crate::provenance::Provenance;
use crate::qualify::jobs::weight;
use crate::qualify::tier::Ablated;
use crate::report::{StudyOutcome, StudySection, StudyTest};
use crate::scenes;
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Mutex;

pub(super) struct Ablations<'a> {
    place: Place<'a>,
    scenes: Vec<Opened>,
    /// Wall time of each run, s, in an order that does not depend on which ends first.
    spent: Mutex<BTreeMap<String, f64>>,
}

/// A scene that is varied.
struct Opened {
    ablated: Ablated,
    file: PathBuf,
    scene: Scene,
    seeds: Vec<u64>,
}

impl<'a> Ablations<'a> {
    pub(super) fn open(ablated: &[Ablated], place: Place<'a>) -> Result<Ablations<'a>, QualifyError> {
        let open = |&ablated: &Ablated| {
            let file = scenes::find(ablated.scene, &place.settings.roots)?;
            Ok(Opened { ablated, scene: scenes::load(&file)?, file, seeds: (1..=ablated.seeds).collect() })
        };
        let scenes = ablated.iter().map(open).collect::<Result<_, QualifyError>>()?;
        Ok(Ablations { place, scenes, spent: Mutex::default() })
    }

    fn plan<'s>(&'s self, opened: &'s Opened) -> Plan<'s> {
        Plan {
            scene: &opened.scene,
            scene_file: &opened.file,
            seeds: &opened.seeds,
            time_limit: self.place.settings.time_limit,
            kept: self.place.kept,
            announce: self.place.settings.announce,
        }
    }
}

impl Part for Ablations<'_> {
    fn jobs(&self) -> Vec<Job<'_>> {
        let mut jobs = Vec::new();
        for opened in &self.scenes {
            for version in self.plan(opened).versions() {
                for &seed in &opened.seeds {
                    let version = version.clone();
                    let identity = KeptRuns::identity(&self.plan(opened).runs(&version, seed), &Makadam, seed);
                    jobs.push(Job {
                        identity: identity.clone(),
                        weight: weight(&version.scene),
                        work: Box::new(move || match self.plan(opened).one(&version, seed) {
                            Ok(run) => {
                                let mut spent = self.spent.lock().expect("nothing panics while it holds the lock");
                                spent.insert(identity.clone(), run.wall_seconds);
                                Ok(())
                            }
                            Err(error) if error.ends_all() => Err(error.into()),
                            // Without an effect a scene may have no run; that of the scene as it is comes to light below.
                            Err(_) => Ok(()),
                        }),
                    });
                }
            }
        }
        jobs
    }

    fn section(&self) -> Result<StudySection, QualifyError> {
        let (mut tests, mut pages) = (Vec::new(), Vec::new());
        for opened in &self.scenes {
            let Opened { ablated, file, scene, .. } = opened;
            let ablation = Ablation::run(&self.plan(opened))?;
            tests.extend(judged(ablated, &ablation));
            let provenance = Provenance::of_run(scene, file, 1, &Execution::serial());
            let study = Study::new(scene, &scenes::text(file)?, (None, None), Some(ablation), provenance);
            study.write(&self.place.folder("effects").join(ablated.scene))?;
            pages.push(format!("effects/{}/ablation.md", ablated.scene));
        }
        let spent = self.spent.lock().expect("nothing panics while it holds the lock");
        Ok(StudySection {
            name: "effects".into(),
            title: "Effects that scenes need".into(),
            scope: "Scenes with each of their effects off, and resistance to turning on: what a scene is known to need must move an \
                    observable by more than its margin."
                .into(),
            runs: spent.len(),
            wall_seconds: spent.values().sum(),
            pages,
            tests,
            notes: Vec::new(),
        })
    }
}

/// Whether the scene as it is has all its observables, and whether it needs what it is known to need.
fn judged(ablated: &Ablated, ablation: &Ablation) -> Vec<StudyTest> {
    let lacking: Vec<&str> =
        ablation.rows.iter().filter(|row| row.mean.is_none()).map(|row| row.observable.as_str()).collect();
    let mut tests = vec![StudyTest {
        name: format!("{}: as it is", ablated.scene),
        measured: if lacking.is_empty() {
            "a value in every seed".into()
        } else {
            format!("no value of {}", lacking.join(", "))
        },
        right: "each observable with a margin has a value in every seed".into(),
        outcome: if lacking.is_empty() { StudyOutcome::Passed } else { StudyOutcome::NotMeasured },
        remark: None,
    }];
    for effect in ablated.needed {
        let rows: Vec<_> = ablation.rows.iter().filter(|row| row.effect == *effect).collect();
        let lacks = |row: &&&crate::effects::Ablated| row.mean.is_some() && row.changed_mean.is_none();
        // Where nothing can be measured without it, and that is on record, the scene needs it as well.
        let counts = ablated.unmeasurable.contains(effect);
        let needed = |row: &&&crate::effects::Ablated| row.need == Need::Needed || counts && lacks(row);
        let moved: Vec<&str> = rows.iter().filter(needed).map(|row| row.observable.as_str()).collect();
        let lacking: Vec<&str> = rows.iter().filter(lacks).map(|row| row.observable.as_str()).collect();
        let measured = match (rows.first(), moved.is_empty(), lacking.is_empty()) {
            (None, ..) => "it was not varied".into(),
            (Some(row), true, true) => format!("{}: no observable moves beyond its margin", row.change),
            (Some(row), true, false) => format!("{}: no value of {} in some seed", row.change, lacking.join(", ")),
            (Some(row), false, _) => format!("{}: {}", row.change, moved.join(", ")),
        };
        let name = format!("{}: {effect}", ablated.scene);
        let judged = test(name, measured, "an observable moves beyond its margin".into(), !moved.is_empty());
        tests.push(match moved.is_empty() && !lacking.is_empty() {
            true => StudyTest { outcome: StudyOutcome::NotMeasured, ..judged },
            false => judged,
        });
    }
    tests
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variation_that_fails_proves_a_need_only_where_that_is_on_record() {
        let row = |effect: &'static str, changed_mean: Option<f64>, need: Need| crate::effects::Ablated {
            effect,
            change: "off".into(),
            observable: "packing_fraction".into(),
            mean: Some(0.6),
            changed_mean,
            interval90: None,
            margin: 0.006,
            need,
        };
        let outcome = |unmeasurable: &'static [&'static str], changed_mean: Option<f64>, need: Need| {
            let ablated = Ablated { scene: "tiny", seeds: 2, needed: &["Coulomb friction"], unmeasurable };
            let rows = vec![row("Coulomb friction", changed_mean, need)];
            let tests = judged(&ablated, &Ablation { seeds: vec![1, 2], rows });
            assert_eq!(tests.len(), 2);
            tests[1].outcome
        };
        assert_eq!(outcome(&[], Some(0.65), Need::Needed), StudyOutcome::Passed);
        assert_eq!(outcome(&[], Some(0.6), Need::NotNeeded), StudyOutcome::Failed);
        assert_eq!(outcome(&[], None, Need::NotMeasurable), StudyOutcome::NotMeasured);
        assert_eq!(outcome(&["Coulomb friction"], None, Need::NotMeasurable), StudyOutcome::Passed);
    }
}
