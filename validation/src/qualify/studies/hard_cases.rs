//! The hard cases of `makadam stability`, in Makadam.

use super::{Job, Part, Place, QualifyError};
use crate::peers::{Code, Makadam};
use crate::qualify::jobs::weight;
use crate::report::{StudyOutcome, StudySection, StudyTest};
use crate::stability::{Campaign, Case, CaseResult, Verdict, catalogue, known_exception, telling};
use std::path::PathBuf;

/// Wall time after which a case is stopped, s: that of the whole catalogue.
const TIME_LIMIT: f64 = 600.0;

pub(super) struct HardCases<'a> {
    place: Place<'a>,
    folder: PathBuf,
    cases: Vec<Case>,
    codes: [Box<dyn Code>; 1],
}

impl<'a> HardCases<'a> {
    pub(super) fn new(filters: &[&str], place: Place<'a>) -> HardCases<'a> {
        let wanted = |case: &Case| {
            filters.is_empty() || filters.iter().any(|filter| case.name.contains(filter) || case.group.contains(filter))
        };
        let cases = catalogue().into_iter().filter(wanted).collect();
        HardCases { place, folder: place.folder("stability"), cases, codes: [Box::new(Makadam)] }
    }

    fn job<'s>(&'s self, case: &'s Case) -> Job<'s> {
        Job {
            identity: format!("stability {}", case.name),
            weight: weight(&case.scene),
            work: Box::new(move || {
                let _display = (self.place.settings.announce)(&case.name);
                self.campaign().take(case, &Makadam, self.place.settings.again)?;
                Ok(())
            }),
        }
    }

    fn campaign(&self) -> Campaign<'_> {
        Campaign {
            cases: &self.cases,
            codes: &self.codes,
            time_limit: TIME_LIMIT,
            folder: &self.folder,
            again: false,
            begins: &|_, _| {},
            ended: &|_, _, _| {},
        }
    }
}

impl Part for HardCases<'_> {
    fn jobs(&self) -> Vec<Job<'_>> {
        self.cases.iter().map(|case| self.job(case)).collect()
    }

    fn section(&self) -> Result<StudySection, QualifyError> {
        let study = self.campaign().carry_out()?;
        let outcomes = study.cases.iter().flat_map(|case| &case.outcomes);
        Ok(StudySection {
            name: "stability".into(),
            title: "Hard cases".into(),
            scope: "Scenes that break simulators, each with what is right by a closed form or a law of conservation."
                .into(),
            runs: study.cases.len(),
            wall_seconds: outcomes.map(|outcome| outcome.wall_seconds).sum(),
            pages: vec!["stability/stability.md".into(), "stability/stability.json".into()],
            tests: study.cases.iter().map(judged).collect(),
            notes: Vec::new(),
        })
    }
}

/// A case as a test. One that is known not to end as stated is excused, and only as long as it does not.
fn judged(case: &CaseResult) -> StudyTest {
    let outcome = case.outcomes.first().expect("a case is run in Makadam");
    let as_stated = outcome.verdict == Verdict::AsStated;
    let (verdict, remark) = match (as_stated, known_exception(&case.name)) {
        (true, None) => (StudyOutcome::Passed, None),
        (false, None) => (StudyOutcome::Failed, outcome.reason.clone()),
        (false, Some(reason)) => (StudyOutcome::KnownException, Some(reason.to_string())),
        (true, Some(_)) => {
            let remark = "it is listed as a case that does not end as stated, and does: take it off the list";
            (StudyOutcome::Failed, Some(remark.to_string()))
        }
    };
    let measured = format!("{}: {}", outcome.verdict.words(), telling(outcome));
    StudyTest {
        name: case.name.clone(),
        measured: measured.trim_end_matches(": ").into(),
        right: case.right.clone(),
        outcome: verdict,
        remark,
    }
}
