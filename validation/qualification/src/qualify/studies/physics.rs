//! Studies of the physics: stress tests, published laws, and effects that scenes need.

use super::{Job, Named, Part, Place, QualifyError, unless_fatal, weight};
use crate::qualify::tier::Ablated;
use crate::report::{StudyOutcome, StudySection, StudyTest};
use makadam_compare::codes::Makadam;
use makadam_compare::laws::{self, Case as LawCase, LAWS, Law, LawResult, figure_and_bounds, row_of};
pub use makadam_compare::stability::{Campaign, Case, Outcome, Verdict, catalogue, known_exception};
use makadam_compare::study::{DocumentError, File, RunCache, RunError, Table, cells};
use makadam_frames::output::WriteError;
pub use makadam_studies::effects::{Ablated as Row, Ablation, Need, Plan};
use std::path::PathBuf;

/// Wall time after which a stress test is stopped, s: that of the whole catalogue.
const TIME_LIMIT: f64 = 600.0;

/// The stress tests of `makadam stability`, in Makadam.
pub(super) struct StressTests<'a> {
    place: Place<'a>,
    folder: PathBuf,
    cache: RunCache,
    cases: Vec<Case>,
}

impl<'a> StressTests<'a> {
    pub(super) fn open(filters: &[&str], place: Place<'a>) -> Result<StressTests<'a>, WriteError> {
        let is_wanted = |case: &Case| filters.is_empty() || filters.iter().any(|filter| case.matches(filter));
        let (folder, cases) = (place.folder("stability"), catalogue().into_iter().filter(is_wanted).collect());
        Ok(StressTests { place, folder, cache: place.open("stability")?, cases })
    }

    fn outcome(&self, case: &Case) -> Result<Outcome, RunError> {
        let (folder, cache) = (&self.folder, &self.cache);
        Campaign { cases: &[], codes: &[], time_limit: TIME_LIMIT, folder, cache }.outcome(case, &Makadam)
    }
}

impl Part for StressTests<'_> {
    fn jobs(&self) -> Vec<Job<'_>> {
        let job = |place: usize| Job {
            identity: format!("stability {}", self.cases[place].name),
            weight: weight(&self.cases[place].scene),
            alone: false,
            work: Box::new(move || {
                let _display = (self.place.settings.announce)(&self.cases[place].name);
                self.outcome(&self.cases[place]).map(|_| ())
            }),
        };
        (0..self.cases.len()).map(job).collect()
    }

    fn section(&self) -> Result<StudySection, RunError> {
        let outcomes = self.cases.iter().map(|case| self.outcome(case)).collect::<Result<Vec<_>, RunError>>()?;
        Ok(StudySection {
            name: "stability".into(),
            title: "Hard cases".into(),
            scope: "Scenes that break simulators, each with what is right by a closed form or a law of conservation."
                .into(),
            runs: outcomes.len(),
            wall_seconds: outcomes.iter().map(|outcome| outcome.wall_seconds).sum(),
            tests: self.cases.iter().zip(&outcomes).map(|(case, outcome)| case_test(case, outcome)).collect(),
            ..StudySection::default()
        })
    }
}

fn case_test(case: &Case, outcome: &Outcome) -> StudyTest {
    let measured = outcome.text();
    let test = StudyTest::of(case.name.clone(), measured, case.right.clone(), outcome.verdict == Verdict::AsStated);
    let remark = outcome.reason.clone().filter(|_| test.outcome == StudyOutcome::Failed);
    StudyTest { remark, ..test }.with_exception(known_exception(&case.name))
}

/// Sweeps of a step, which turn the work of a law (grains times steps) into that of other jobs.
const SWEEPS: f64 = 20.0;

/// Published laws.
pub(super) struct Laws<'a> {
    place: Place<'a>,
    laws: Vec<Measured>,
}

/// A law and its runs.
struct Measured {
    law: &'static Law,
    cases: Vec<LawCase>,
    seeds: u64,
    cache: RunCache,
}

impl<'a> Laws<'a> {
    pub(super) fn open(laws: &[(&'static str, u64)], place: Place<'a>) -> Result<Laws<'a>, QualifyError> {
        let open = |&(name, seeds): &(&'static str, u64)| {
            let law = LAWS.iter().find(|law| law.name == name).expect("the table of tiers names laws");
            let cache = place.open(&format!("laws/{name}"))?;
            Ok(Measured { law, cases: (law.cases)(false), seeds, cache })
        };
        Ok(Laws { place, laws: laws.iter().map(open).collect::<Result<_, QualifyError>>()? })
    }
}

impl Measured {
    /// Cases, each with each seed.
    fn runs(&self) -> impl Iterator<Item = (&LawCase, u64)> {
        self.cases.iter().flat_map(|case| (1..=self.seeds).map(move |seed| (case, seed)))
    }

    fn row(&self, case: &LawCase, seed: u64, progress: &(dyn Fn(f64) + Sync)) -> Result<laws::Row, RunError> {
        row_of(self.law, case, seed, &self.cache, progress)
    }
}

impl Part for Laws<'_> {
    fn jobs(&self) -> Vec<Job<'_>> {
        let mut jobs = Vec::new();
        for measured in &self.laws {
            jobs.extend(measured.runs().map(|(case, seed)| Job {
                identity: format!("law {} seed {seed}", case.name),
                weight: laws::work(case) * SWEEPS,
                alone: false,
                work: Box::new(move || {
                    let share = (self.place.settings.announce)(&format!("{} seed {seed}", case.name));
                    unless_fatal(measured.row(case, seed, &*share))
                }),
            }));
        }
        jobs
    }

    fn section(&self) -> Result<StudySection, RunError> {
        let mut section = StudySection {
            name: "laws".into(),
            title: "Published laws".into(),
            scope: "What others found in experiments and, for the friction of a flowing layer, in simulations: measured as its authors \
                    did, and judged by bounds that were set before."
                .into(),
            ..StudySection::default()
        };
        for measured in &self.laws {
            let name = measured.law.name;
            let rows = measured.runs().map(|(case, seed)| measured.row(case, seed, &|_| {}));
            match rows.collect::<Result<Vec<_>, RunError>>() {
                Ok(rows) => {
                    let result = LawResult::new(measured.law, rows);
                    section.runs += result.rows.len();
                    section.wall_seconds += result.wall_seconds();
                    section.tests.extend(law_tests(&result));
                    section.notes.push(format!("{name}: {}. {}", result.statement, result.source));
                    section.files.push(laws::runs(&result.rows).csv(&format!("laws-{name}"))?);
                    section.figures.extend(result.figures);
                }
                Err(error) if error.ends_all() => return Err(error),
                Err(error) => {
                    let test =
                        StudyTest::of(format!("{name}: runs"), "no numbers".into(), "every run ends".into(), false);
                    let remark = Some(error.to_string());
                    section.tests.push(StudyTest { outcome: StudyOutcome::NotMeasured, remark, ..test });
                }
            }
        }
        Ok(section)
    }
}

/// Returns the figures of a law that have bounds.
fn law_tests(result: &LawResult) -> Vec<StudyTest> {
    let bounded = result.findings.iter().filter(|finding| [finding.low, finding.high] != [None, None]);
    let tests = bounded.map(|finding| {
        let [measured, right] = figure_and_bounds(finding);
        // A measured number is no part of a name.
        let what = finding.what.split(", I = ").next().unwrap_or(&finding.what);
        StudyTest::of(format!("{}: {what}", result.name), measured, right, finding.holds())
    });
    tests.collect()
}

/// Scenes with each of their effects off, or on: an effect that a scene is known to need must move a measured value.
pub(super) struct Ablations<'a> {
    place: Place<'a>,
    scenes: Vec<(Ablated, Named, Vec<u64>)>,
}

impl<'a> Ablations<'a> {
    pub(super) fn open(ablated: &[Ablated], place: Place<'a>) -> Result<Ablations<'a>, QualifyError> {
        let open =
            |&ablated: &Ablated| Ok((ablated, Named::open(ablated.scene, place)?, (1..=ablated.seeds).collect()));
        Ok(Ablations { place, scenes: ablated.iter().map(open).collect::<Result<_, QualifyError>>()? })
    }

    fn plan<'s>(&'s self, named: &'s Named, seeds: &'s [u64]) -> Plan<'s> {
        Plan {
            scene: &named.scene,
            scene_file: &named.file,
            seeds,
            time_limit: self.place.settings.time_limit,
            cache: self.place.cache,
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
                    jobs.push(Job {
                        identity: self.plan(named, seeds).runs(&version, seed).key(&Makadam, seed, false).name().into(),
                        weight: weight(&version.scene),
                        alone: false,
                        work: Box::new(move || unless_fatal(self.plan(named, seeds).take(&version, seed))),
                    });
                }
            }
        }
        jobs
    }

    fn section(&self) -> Result<StudySection, RunError> {
        let mut section = StudySection {
            name: "effects".into(),
            title: "Effects that scenes need".into(),
            scope: "Scenes with each of their effects off, and resistance to turning on: what a scene is known to need must move an \
                    observable by more than its margin."
                .into(),
            ..StudySection::default()
        };
        for (ablated, named, seeds) in &self.scenes {
            let ablation = Ablation::run(&self.plan(named, seeds))?;
            section.runs += ablation.runs;
            section.wall_seconds += ablation.wall_seconds;
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
