//! Published laws, measured anew.

use super::{Job, Part, Place, QualifyError, link, test};
use crate::laws::{
    Case, KeptRows, Law, LawError, LawResult, Plan, Study, all, carry_out, markdown, work, write, write_scenes,
};
use crate::output::{JSON_VERSION, write_whole};
use crate::provenance::account;
use crate::report::{StudyOutcome, StudySection, StudyTest};
use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Mutex;

/// Sweeps of a step that the work of a law is told by, which is grains times steps.
const SWEEPS: f64 = 20.0;

pub(super) struct Laws<'a> {
    place: Place<'a>,
    folder: PathBuf,
    laws: Vec<Measured>,
    /// What was wrong with a run of a law that has no numbers, by its name.
    failed: Mutex<BTreeMap<&'static str, String>>,
}

/// A law and the runs behind it.
struct Measured {
    law: &'static dyn Law,
    cases: Vec<Case>,
    seeds: Vec<u64>,
    folder: PathBuf,
    kept: KeptRows,
}

impl<'a> Laws<'a> {
    pub(super) fn open(laws: &[(&'static str, u64)], place: Place<'a>) -> Result<Laws<'a>, QualifyError> {
        let folder = place.folder("laws");
        let open = |&(name, seeds): &(&'static str, u64)| {
            let law = all().into_iter().find(|law| law.name() == name).expect("the table of tiers names laws");
            let (seeds, folder): (Vec<u64>, _) = ((1..=seeds).collect(), folder.join(name));
            let kept = KeptRows::open(law, &Plan { seeds: &seeds, again: place.settings.again, folder: &folder });
            Ok(Measured { law, cases: law.cases(false), seeds, folder, kept: kept.map_err(of_law)? })
        };
        let laws = laws.iter().map(open).collect::<Result<_, QualifyError>>()?;
        Ok(Laws { place, folder, laws, failed: Mutex::default() })
    }

    fn run(&self, measured: &Measured, case: &Case, seed: u64) -> Result<(), QualifyError> {
        let share = (self.place.settings.announce)(&format!("{} seed {seed}", case.name));
        match measured.kept.take(case, seed, &*share) {
            Ok(_) => Ok(()),
            Err(error @ LawError::Worthless { .. }) => {
                let mut failed = self.failed.lock().expect("nothing panics while it holds the lock");
                failed.entry(measured.law.name()).or_insert_with(|| error.to_string());
                Ok(())
            }
            Err(error) => Err(of_law(error)),
        }
    }
}

impl Part for Laws<'_> {
    fn jobs(&self) -> Vec<Job<'_>> {
        let mut jobs = Vec::new();
        for measured in &self.laws {
            for (case, &seed) in
                measured.cases.iter().flat_map(|case| measured.seeds.iter().map(move |seed| (case, seed)))
            {
                jobs.push(Job {
                    identity: format!("law {} seed {seed}", case.name),
                    weight: work(case) * SWEEPS,
                    work: Box::new(move || self.run(measured, case, seed)),
                });
            }
        }
        jobs
    }

    fn section(&self) -> Result<StudySection, QualifyError> {
        let failed = self.failed.lock().expect("nothing panics while it holds the lock");
        let (mut tests, mut pages, mut results) = (Vec::new(), vec!["laws/laws.md".to_string()], Vec::new());
        for Measured { law, cases, seeds, folder, .. } in &self.laws {
            let name = law.name();
            if let Some(problem) = failed.get(name) {
                tests.push(StudyTest {
                    name: format!("{name}: runs"),
                    measured: "no numbers".into(),
                    right: "every run ends".into(),
                    outcome: StudyOutcome::NotMeasured,
                    remark: Some(problem.clone()),
                });
                continue;
            }
            write_scenes(cases, folder)?;
            let plan = Plan { seeds, again: false, folder };
            let result = LawResult::new(*law, carry_out(*law, cases, &plan, &|_| {}).map_err(of_law)?);
            write(*law, &study(vec![result.clone()], seeds), folder)?;
            pages.push(link(&self.place.settings.folder, &folder.join("laws.json")));
            tests.extend(judged(&result));
            results.push(result);
        }
        write_whole(&self.folder.join("laws.md"), markdown(&results).as_bytes())?;
        let rows = || results.iter().flat_map(|result| &result.rows);
        Ok(StudySection {
            name: "laws".into(),
            title: "Published laws".into(),
            scope: "What others found in experiments and, for the friction of a flowing layer, in simulations: measured as its authors \
                    did, and judged by bounds that were set before."
                .into(),
            runs: rows().count(),
            wall_seconds: rows().map(|row| row.wall_seconds).sum(),
            pages,
            tests,
            notes: results.iter().map(|result| format!("{}: {}. {}", result.name, result.statement, result.source)).collect(),
        })
    }
}

/// The figures of a law that have bounds.
fn judged(result: &LawResult) -> Vec<StudyTest> {
    let bounded = result.findings.iter().filter(|finding| finding.bounds() != [None, None]);
    let tests = bounded.map(|finding| {
        let [measured, right] = crate::laws::in_words(finding);
        // A number that was measured is no part of a name.
        let what = finding.what.split(", I = ").next().unwrap_or(&finding.what);
        test(format!("{}: {what}", result.name), measured, right, finding.holds())
    });
    tests.collect()
}

fn study(laws: Vec<LawResult>, seeds: &[u64]) -> Study {
    Study {
        version: JSON_VERSION,
        command: "laws",
        hold: laws.iter().all(|law| law.holds),
        quick: false,
        seeds: seeds.to_vec(),
        laws,
        provenance: account(rayon::current_num_threads(), &[]),
    }
}

fn of_law(error: LawError) -> QualifyError {
    match error {
        LawError::Interrupted => QualifyError::Interrupted,
        LawError::Scene(error) => error.into(),
        LawError::Write(error) => error.into(),
        other => QualifyError::Study { study: "laws", problem: other.to_string() },
    }
}

#[cfg(test)]
mod tests {
    use crate::qualify::{Tier, studies_on_record};

    #[test]
    fn every_figure_of_a_law_that_has_bounds_is_a_test_on_record() {
        let mut judged: Vec<String> = crate::laws::recorded()
            .iter()
            .flat_map(|(_, result)| super::judged(result))
            .map(|test| test.name)
            .collect();
        let record = studies_on_record(Tier::Full).into_iter().filter(|test| test.study == "laws");
        let mut record: Vec<String> = record.map(|test| test.test).collect();
        judged.sort();
        record.sort();
        assert_eq!(judged, record);
    }
}
