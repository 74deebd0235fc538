//! What a report is made from: the comparisons of one run, and the verdict that follows from their rows.

use super::on_record::{Lost, TestOnRecord};
use super::published::PublishedLaw;
use super::studies::{StudyCount, StudySection, StudyTestOnRecord};
use crate::compare::Comparison;
use crate::draw::numbers::plural;
use crate::statistics::Outcome;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// One qualification: every scene that was compared, and where the numbers came from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Qualification {
    /// Title of the report.
    pub title: String,
    /// Tier that was run: "quick", "full", "release", or "compare" for a single scene.
    pub tier: String,
    /// Wall time of the whole qualification, s.
    pub wall_seconds: f64,
    /// Comparisons, a scene after the other.
    pub comparisons: Vec<Comparison>,
    /// Where the numbers came from, by name: version, commit, compiler, instruction set, threads, processor, date.
    pub provenance: BTreeMap<String, String>,
    /// What a reader must know of the whole run: scenes that were left out, codes that are missing.
    pub notes: Vec<String>,
    /// Values of live runs of reference codes that lie outside the spread of their recorded runs, one in a sentence.
    #[serde(default)]
    pub outside_spread: Vec<String>,
    /// Values of live runs of reference codes that could not be held against their recorded runs, one in a sentence.
    #[serde(default)]
    pub unchecked: Vec<String>,
    /// Live runs of reference codes that failed, one in a sentence.
    #[serde(default)]
    pub failed_runs: Vec<String>,
    /// What is recorded of published laws; no part of the verdict.
    #[serde(default)]
    pub laws: Vec<PublishedLaw>,
    /// Tests that must be made, whatever the scenes say.
    #[serde(default)]
    pub on_record: Vec<TestOnRecord>,
    /// Studies that were a part of it.
    #[serde(default)]
    pub studies: Vec<StudySection>,
    /// Tests of studies that must be made.
    #[serde(default)]
    pub studies_on_record: Vec<StudyTestOnRecord>,
}

/// What a qualification says as a whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Standing {
    /// Every test of equivalence and of a study passed, and every live run lies inside the recorded spread.
    Agree,
    /// At least one failed, or a live run lies outside the recorded spread.
    Disagree,
    /// None failed, at least one is undecided.
    Undecided,
    /// None failed, and the runs are not those that the scene has registered, so that none counts as agreement.
    Exploratory,
    /// None failed, and something that was asked for was not measured.
    NotMeasured,
    /// No observable was tested against a margin.
    NothingCompared,
}

/// The verdict of a qualification, counted over the tests of the judged code against the others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Verdict {
    /// What it comes to.
    pub standing: Standing,
    /// Tests of equivalence that passed.
    pub agree: usize,
    /// That failed.
    pub disagree: usize,
    /// That too few seeds, or references at odds with each other, leave open.
    pub undecided: usize,
    /// Whose interval lies inside the margin, of runs that the scene has not registered: they do not count as agreement.
    #[serde(default)]
    pub exploratory: usize,
    /// That were asked for and could not be made so: a code lacks a value of the observable in some or all of its seeds, or the test was made
    /// with less than is on record, or not at all.
    #[serde(default)]
    pub not_measured: usize,
    /// Differences without a margin, which are no tests, that were asked for and could not be made for want of values.
    #[serde(default)]
    pub differences_not_measured: usize,
    /// Undecided tests in whose observable the references differ from each other by more than the margin: more seeds would not decide.
    pub floor_above_margin: usize,
    /// Live runs of reference codes outside the spread of their recorded runs.
    pub outside_spread: usize,
    /// Live values of reference codes that could not be held against their recorded runs.
    #[serde(default)]
    pub unchecked: usize,
    /// Live runs of reference codes that failed.
    #[serde(default)]
    pub failed_runs: usize,
    /// Tests of the studies that were a part.
    #[serde(default)]
    pub studies: Vec<StudyCount>,
    /// The verdict in words; the first sentence is that of the tests of equivalence.
    pub sentence: String,
}

impl Standing {
    /// In a word or two.
    pub fn words(self) -> &'static str {
        match self {
            Standing::Agree => "Agree",
            Standing::Disagree => "Disagree",
            Standing::Undecided => "Undecided",
            Standing::Exploratory => "Exploratory",
            Standing::NotMeasured => "Not measured",
            Standing::NothingCompared => "No verdict",
        }
    }

    /// Style class of its mark.
    pub(crate) fn class(self) -> &'static str {
        match self {
            Standing::Agree => "agree",
            Standing::Disagree => "disagree",
            Standing::Undecided | Standing::Exploratory | Standing::NotMeasured | Standing::NothingCompared => {
                "undecided"
            }
        }
    }
}

impl Verdict {
    /// Tests of equivalence and of studies that passed.
    pub fn passed(&self) -> usize {
        self.agree + self.studies.iter().map(|study| study.passed).sum::<usize>()
    }

    /// All tests of equivalence and of studies.
    pub fn tests(&self) -> usize {
        let of_studies = self.studies.iter().map(|study| study.tests).sum::<usize>();
        self.agree + self.disagree + self.undecided + self.exploratory + self.not_measured + of_studies
    }
}

impl Qualification {
    /// The verdict that follows from the rows. Differences between two references set the floor and do not count.
    pub fn verdict(&self) -> Verdict {
        let mut verdict = Verdict {
            standing: Standing::NothingCompared,
            agree: 0,
            disagree: 0,
            undecided: 0,
            exploratory: 0,
            not_measured: 0,
            differences_not_measured: 0,
            floor_above_margin: 0,
            outside_spread: self.outside_spread.len(),
            unchecked: self.unchecked.len(),
            failed_runs: self.failed_runs.len(),
            studies: self.studies.iter().map(StudySection::count).collect(),
            sentence: String::new(),
        };
        let lost = self.lost();
        let mut lost_with_row = 0;
        let mut references: Vec<&str> = Vec::new();
        let mut scenes = 0;
        for comparison in &self.comparisons {
            let mut tested = false;
            // Where the judged code took no part, what the others lack still is no success.
            let judged = comparison.rows.iter().any(|row| row.code == comparison.judged);
            for row in comparison.rows.iter().filter(|row| row.code == comparison.judged || !judged) {
                let Some(outcome) = row.outcome else { continue };
                let wanting = if judged { lost.iter().filter(|lost| lost.is_of(row)).count() } else { 0 };
                lost_with_row += wanting;
                if outcome == Outcome::NotMeasured && row.margin.is_none() && wanting == 0 {
                    verdict.differences_not_measured += 1;
                    continue;
                }
                // A disagreement goes before what the test lacks.
                if outcome == Outcome::NotMeasured || (wanting > 0 && outcome != Outcome::Disagree) {
                    verdict.not_measured += 1;
                    tested = true;
                    continue;
                }
                let Some(reference) = row.reference_code.as_deref().filter(|_| judged) else { continue };
                tested = true;
                match outcome {
                    Outcome::Disagree => verdict.disagree += 1,
                    // Reports of earlier versions have agreement there.
                    Outcome::Agree | Outcome::Exploratory | Outcome::Undecided
                        if comparison.references_at_odds(row) =>
                    {
                        verdict.undecided += 1;
                        verdict.floor_above_margin += 1;
                    }
                    Outcome::Agree => verdict.agree += 1,
                    Outcome::Exploratory => verdict.exploratory += 1,
                    Outcome::Undecided | Outcome::NotMeasured => verdict.undecided += 1,
                }
                if !references.contains(&reference) {
                    references.push(reference);
                }
            }
            scenes += usize::from(tested);
        }
        verdict.not_measured += lost.len() - lost_with_row;
        let of_studies = |names: fn(&StudyCount) -> usize| verdict.studies.iter().map(names).sum::<usize>();
        let failed = of_studies(|study| study.failed.len());
        let lacks = verdict.not_measured
            + verdict.differences_not_measured
            + verdict.unchecked
            + verdict.failed_runs
            + of_studies(|study| study.not_measured.len())
            > 0;
        verdict.standing = match (verdict.agree + verdict.exploratory, verdict.disagree, verdict.undecided) {
            _ if failed > 0 => Standing::Disagree,
            (0, 0, 0) if lacks => Standing::NotMeasured,
            (0, 0, 0) => Standing::NothingCompared,
            (_, 0, _) if verdict.outside_spread > 0 => Standing::Disagree,
            (_, 0, _) if lacks => Standing::NotMeasured,
            (_, 0, _) if verdict.exploratory > 0 => Standing::Exploratory,
            (_, 0, 0) => Standing::Agree,
            (_, 0, _) => Standing::Undecided,
            _ => Standing::Disagree,
        };
        let judged = self.comparisons.first().map_or("", |comparison| &comparison.judged);
        verdict.sentence = sentence(&verdict, judged, &references, scenes);
        if verdict.exploratory > 0 {
            let unregistered = self.comparisons.iter().find_map(|comparison| comparison.unregistered());
            verdict.sentence += &unregistered.map_or(String::new(), |words| format!(" Exploratory: {words}."));
        }
        for (study, count) in self.studies.iter().zip(&verdict.studies) {
            verdict.sentence += &format!(" {}", count.sentence(&study.title));
        }
        verdict.sentence += &told(&lost);
        verdict
    }
}

/// Tests on record that were not made as they stand there, in sentences: one for all of which the same became.
fn told(lost: &[Lost]) -> String {
    let mut fates: Vec<(&str, Vec<String>)> = Vec::new();
    for Lost { test, what } in lost {
        match fates.iter_mut().find(|(fate, _)| fate == what) {
            Some((_, tests)) => tests.push(test.to_string()),
            None => fates.push((what, vec![test.to_string()])),
        }
    }
    let sentence = |(fate, tests): (&str, Vec<String>)| match tests.as_slice() {
        [test] => format!(" A test on record {fate}: {test}."),
        tests => format!(" Each of {} tests on record {fate}: {}.", tests.len(), tests.join(", ")),
    };
    fates.into_iter().map(sentence).collect()
}

fn sentence(verdict: &Verdict, judged: &str, references: &[&str], scenes: usize) -> String {
    let tests = verdict.agree + verdict.disagree + verdict.undecided + verdict.exploratory + verdict.not_measured;
    let lacking = match verdict.not_measured {
        0 => String::new(),
        count => format!(" {} could not be made as asked for.", plural(count, "test")),
    };
    let names = join(references);
    let over = format!("{} of {}", plural(tests, "test"), plural(scenes, "scene"));
    let mut text = match (verdict.agree, verdict.disagree, verdict.undecided) {
        (agree, disagree, undecided) if verdict.exploratory > 0 => format!(
            "No verdict: of {over} against {names}, {} {} within the margins, {disagree} {}, and {undecided} {} undecided.{lacking}",
            agree + verdict.exploratory,
            if agree + verdict.exploratory == 1 { "lies" } else { "lie" },
            if disagree == 1 { "disagrees" } else { "disagree" },
            is(undecided),
        ),
        (0, 0, 0) if verdict.not_measured > 0 => {
            format!("Not measured: none of {over} could be made as asked for.")
        }
        (0, 0, 0) if verdict.differences_not_measured + verdict.unchecked + verdict.failed_runs == 0 => {
            return "No verdict: no observable was tested against a margin and a reference code.".into();
        }
        (0, 0, 0) => "No observable was tested against a margin and a reference code.".into(),
        (agree, 0, 0) if verdict.not_measured > 0 => format!(
            "Not measured: of {over} against {names}, {agree} agree, none disagrees, and {} could not be made as asked for.",
            verdict.not_measured,
        ),
        (1, 0, 0) => format!("{judged} agrees with {names} in the one test that was made."),
        (_, 0, 0) => format!("{judged} agrees with {names} within the margins in all {over}."),
        (agree, 0, undecided) => format!(
            "{}: of {over} against {names}, {agree} agree, none disagrees, and {}.{lacking}",
            if lacking.is_empty() { "Undecided" } else { "Not measured" },
            match undecided - verdict.floor_above_margin {
                0 => format!("{undecided} {} undecided", is(undecided)),
                1 => "1 has too few seeds to tell".into(),
                few => format!("{few} have too few seeds to tell"),
            },
        ),
        (agree, disagree, undecided) => format!(
            "{judged} disagrees with {names} in {disagree} of {over}; {agree} agree{}.{lacking}",
            if undecided > 0 { format!(" and {undecided} {} undecided", is(undecided)) } else { String::new() },
        ),
    };
    if verdict.differences_not_measured > 0 {
        text += &format!(
            " {} without a margin could not be made for want of values.",
            plural(verdict.differences_not_measured, "difference"),
        );
    }
    if verdict.outside_spread > 0 {
        text += &format!(
            " {} of a reference code {} outside the spread of its recorded runs.",
            plural(verdict.outside_spread, "live value"),
            if verdict.outside_spread == 1 { "lies" } else { "lie" },
        );
    }
    if verdict.unchecked > 0 {
        text += &format!(
            " {} of a reference code could not be held against its recorded runs.",
            plural(verdict.unchecked, "live value"),
        );
    }
    if verdict.failed_runs > 0 {
        text += &format!(" {} of a reference code failed.", plural(verdict.failed_runs, "live run"));
    }
    if verdict.floor_above_margin > 0 {
        text += &format!(
            " In {} the means of the references differ by more than the margin, so {} nothing.",
            plural(verdict.floor_above_margin, "test"),
            if verdict.floor_above_margin == 1 { "it proves" } else { "they prove" },
        );
    }
    text
}

fn is(count: usize) -> &'static str {
    if count == 1 { "is" } else { "are" }
}

/// "a", "a and b", "a, b and c".
pub(super) fn join<T: AsRef<str>>(names: &[T]) -> String {
    match names {
        [] => "no code".into(),
        [only] => only.as_ref().into(),
        [first @ .., last] => {
            let first: Vec<&str> = first.iter().map(AsRef::as_ref).collect();
            format!("{} and {}", first.join(", "), last.as_ref())
        }
    }
}
