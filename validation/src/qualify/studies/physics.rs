//! Studies of the physics: published laws, measured again; and effects that scenes need.

use super::{Job, Named, Part, Place, QualifyError, Results, weight};
use crate::compare::KeptRuns;
use crate::effects::{Ablated as Row, Ablation, Need, Plan};
use crate::laws::{self, Case, Law, LawError, LawResult, StoredRows};
use crate::peers::Makadam;
use crate::qualify::tier::Ablated;
use crate::report::{StudyOutcome, StudySection, StudyTest};
use crate::study::{DocumentError, File, Table, cells};

/// Sweeps of a step, which turn the work of a law (grains times steps) into that of other jobs.
const SWEEPS: f64 = 20.0;

/// Published laws.
pub(super) struct Laws<'a> {
    place: Place<'a>,
    laws: Vec<Measured>,
    /// Failure of a run of a law, by the name of the law.
    failed: Results<String>,
}

/// A law and its runs.
struct Measured {
    law: &'static dyn Law,
    cases: Vec<Case>,
    seeds: u64,
    kept: StoredRows,
    /// Rows by case and seed.
    rows: Results<laws::Row>,
}

impl<'a> Laws<'a> {
    pub(super) fn open(laws: &[(&'static str, u64)], place: Place<'a>) -> Result<Laws<'a>, QualifyError> {
        let open = |&(name, seeds): &(&'static str, u64)| {
            let law = laws::all().into_iter().find(|law| law.name() == name).expect("the table of tiers names laws");
            let folder = place.folder("laws").join(name);
            let plan = laws::Plan { seeds: &[], again: place.settings.again, folder: &folder };
            let kept = StoredRows::open(law, &plan).map_err(of_law)?;
            Ok(Measured { law, cases: law.cases(false), seeds, kept, rows: Results::new() })
        };
        let laws = laws.iter().map(open).collect::<Result<_, QualifyError>>()?;
        Ok(Laws { place, laws, failed: Results::new() })
    }

    fn job<'s>(&'s self, measured: &'s Measured, place: usize, seed: u64) -> Job<'s> {
        let case = &measured.cases[place];
        Job {
            identity: format!("law {} seed {seed}", case.name),
            weight: laws::work(case) * SWEEPS,
            alone: false,
            work: Box::new(move || {
                let share = (self.place.settings.announce)(&format!("{} seed {seed}", case.name));
                match measured.kept.take(case, seed, &*share) {
                    Ok(row) => measured.rows.add(&format!("{place:04} {seed:06}"), row),
                    Err(error @ LawError::Worthless { .. }) => self.failed.add(measured.law.name(), error.to_string()),
                    Err(error) => return Err(of_law(error)),
                }
                Ok(())
            }),
        }
    }
}

impl Part for Laws<'_> {
    fn jobs(&self) -> Vec<Job<'_>> {
        let mut jobs = Vec::new();
        for measured in &self.laws {
            for place in 0..measured.cases.len() {
                jobs.extend((1..=measured.seeds).map(|seed| self.job(measured, place, seed)));
            }
        }
        jobs
    }

    fn section(&self) -> Result<StudySection, QualifyError> {
        let mut section = StudySection {
            name: "laws".into(),
            title: "Published laws".into(),
            scope: "What others found in experiments and, for the friction of a flowing layer, in simulations: measured as its authors \
                    did, and judged by bounds that were set before."
                .into(),
            ..StudySection::default()
        };
        for Measured { law, rows, .. } in &self.laws {
            let name = law.name();
            if let Some(problem) = self.failed.get(name) {
                let right = "every run ends".into();
                let test = StudyTest::of(format!("{name}: runs"), "no numbers".into(), right, false);
                section.tests.push(StudyTest { outcome: StudyOutcome::NotMeasured, remark: Some(problem), ..test });
                continue;
            }
            let result = LawResult::new(*law, rows.all());
            section.runs += result.rows.len();
            section.wall_seconds += result.rows.iter().map(|row| row.wall_seconds).sum::<f64>();
            section.tests.extend(law_tests(&result));
            section.notes.push(format!("{name}: {}. {}", result.statement, result.source));
            section.figures.extend(law.figures(&result.means));
            section.files.push(laws::runs(&result.rows).csv(&format!("laws-{name}"))?);
        }
        Ok(section)
    }
}

/// Returns the figures of a law that have bounds.
fn law_tests(result: &LawResult) -> Vec<StudyTest> {
    let bounded = result.findings.iter().filter(|finding| finding.bounds() != [None, None]);
    let tests = bounded.map(|finding| {
        let [measured, right] = laws::in_words(finding);
        // A measured number is no part of a name.
        let what = finding.what.split(", I = ").next().unwrap_or(&finding.what);
        StudyTest::of(format!("{}: {what}", result.name), measured, right, finding.holds())
    });
    tests.collect()
}

fn of_law(error: LawError) -> QualifyError {
    match error {
        LawError::Interrupted => QualifyError::Interrupted,
        LawError::Scene(error) => error.into(),
        LawError::Write(error) => error.into(),
        other => QualifyError::Failed(format!("laws: {other}")),
    }
}

/// Scenes with each of their effects off, or on: an effect that a scene is known to need must move a measured value.
pub(super) struct Ablations<'a> {
    place: Place<'a>,
    scenes: Vec<(Ablated, Named, Vec<u64>)>,
    /// Wall time of each run, s.
    spent: Results<f64>,
}

impl<'a> Ablations<'a> {
    pub(super) fn open(ablated: &[Ablated], place: Place<'a>) -> Result<Ablations<'a>, QualifyError> {
        let open =
            |&ablated: &Ablated| Ok((ablated, Named::open(ablated.scene, place)?, (1..=ablated.seeds).collect()));
        let scenes = ablated.iter().map(open).collect::<Result<_, QualifyError>>()?;
        Ok(Ablations { place, scenes, spent: Results::new() })
    }

    fn plan<'s>(&'s self, named: &'s Named, seeds: &'s [u64]) -> Plan<'s> {
        Plan {
            scene: &named.scene,
            scene_file: &named.file,
            seeds,
            time_limit: self.place.settings.time_limit,
            kept: self.place.kept,
            announce: self.place.settings.announce,
        }
    }
}

impl Part for Ablations<'_> {
    fn jobs(&self) -> Vec<Job<'_>> {
        let mut jobs = Vec::new();
        for (_, named, seeds) in &self.scenes {
            for version in self.plan(named, seeds).versions() {
                for &seed in seeds {
                    let version = version.clone();
                    let identity = KeptRuns::identity(&self.plan(named, seeds).runs(&version, seed), &Makadam, seed);
                    jobs.push(Job {
                        identity: identity.clone(),
                        weight: weight(&version.scene),
                        alone: false,
                        work: Box::new(move || match self.plan(named, seeds).one(&version, seed) {
                            Ok(run) => {
                                self.spent.add(&identity, run.wall_seconds);
                                Ok(())
                            }
                            Err(error) if error.ends_all() => Err(error.into()),
                            // Without an effect a scene may have no run; a failure of the scene as it is shows in the tests.
                            Err(_) => Ok(()),
                        }),
                    });
                }
            }
        }
        jobs
    }

    fn section(&self) -> Result<StudySection, QualifyError> {
        let spent = self.spent.all();
        let mut section = StudySection {
            name: "effects".into(),
            title: "Effects that scenes need".into(),
            scope: "Scenes with each of their effects off, and resistance to turning on: what a scene is known to need must move an \
                    observable by more than its margin."
                .into(),
            runs: spent.len(),
            wall_seconds: spent.iter().sum(),
            ..StudySection::default()
        };
        for (ablated, named, seeds) in &self.scenes {
            let ablation = Ablation::run(&self.plan(named, seeds))?;
            section.tests.extend(ablation_tests(ablated, &ablation));
            section.files.push(ablation_rows(ablated.scene, &ablation)?);
        }
        Ok(section)
    }
}

fn ablation_rows(scene: &str, ablation: &Ablation) -> Result<File, DocumentError> {
    let row = |row: &Row| {
        let [low, high] = [0, 1].map(|end| row.interval90.map(|interval| interval[end]));
        let need = row.need.words();
        cells![row.effect, &row.change, &row.observable, row.mean, row.changed_mean, low, high, row.margin, need]
    };
    let columns = "effect change observable mean changed_mean interval90_low interval90_high margin need";
    Table::named(columns).of(&ablation.rows, row).csv(&format!("effects-{scene}"))
}

/// Tests that the scene as it is has all its observables, and that it needs its effects.
fn ablation_tests(ablated: &Ablated, ablation: &Ablation) -> Vec<StudyTest> {
    let unmeasured = |test: StudyTest| StudyTest { outcome: StudyOutcome::NotMeasured, ..test };
    let lacking: Vec<&str> =
        ablation.rows.iter().filter(|row| row.mean.is_none()).map(|row| row.observable.as_str()).collect();
    let measured = match lacking.is_empty() {
        true => "a value in every seed".into(),
        false => format!("no value of {}", lacking.join(", ")),
    };
    let right = "each observable with a margin has a value in every seed";
    let as_it_is = StudyTest::of(format!("{}: as it is", ablated.scene), measured, right.into(), lacking.is_empty());
    let mut tests = vec![if lacking.is_empty() { as_it_is } else { unmeasured(as_it_is) }];
    for effect in ablated.needed.split(", ") {
        let rows: Vec<&Row> = ablation.rows.iter().filter(|row| row.effect == effect).collect();
        let lacks = |row: &&&Row| row.mean.is_some() && row.changed_mean.is_none();
        // Where nothing can be measured without the effect, and that is known, the scene needs it as well.
        let counts = ablated.unmeasurable.split(", ").any(|known| known == effect);
        let is_needed = |row: &&&Row| row.need == Need::Needed || counts && lacks(row);
        let names = |rows: Vec<&&Row>| rows.iter().map(|row| row.observable.as_str()).collect::<Vec<_>>().join(", ");
        let moved = names(rows.iter().filter(is_needed).collect());
        let lacking = names(rows.iter().filter(lacks).collect());
        let measured = match (rows.first(), moved.is_empty(), lacking.is_empty()) {
            (None, ..) => "it was not varied".into(),
            (Some(row), true, true) => format!("{}: no observable moves beyond its margin", row.change),
            (Some(row), true, false) => format!("{}: no value of {lacking} in some seed", row.change),
            (Some(row), false, _) => format!("{}: {moved}", row.change),
        };
        let right = "an observable moves beyond its margin".into();
        let test = StudyTest::of(format!("{}: {effect}", ablated.scene), measured, right, !moved.is_empty());
        tests.push(if moved.is_empty() && !lacking.is_empty() { unmeasured(test) } else { test });
    }
    tests
}

#[cfg(test)]
#[path = "../../../tests/unit/qualify_studies_physics.rs"]
mod tests;
