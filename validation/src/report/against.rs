//! A qualification against an earlier one: tests that came or went, verdicts that changed, numbers that moved beyond noise.

use super::qualification::Qualification;
use super::studies::{StudySection, StudyTest};
use crate::compare::{Comparison, Row};
use crate::draw::names;
use crate::draw::numbers::{significant, two_digits};
use crate::plan::physics_hash;
use serde::Serialize;

/// Standard errors of a difference beyond which a number has moved: by chance about once in 300 tests of many seeds, and once in 100 of eight.
const BEYOND_NOISE: f64 = 3.0;

/// What is different from an earlier qualification.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Changes {
    /// Tests that were made then and not now, in words.
    pub lost: Vec<String>,
    /// Tests that are made now and were not then.
    pub gained: Vec<String>,
    /// Tests whose outcome is another one.
    pub outcomes: Vec<String>,
    /// What tests rest on and is another one: margins, scenes.
    pub conditions: Vec<String>,
    /// Means that moved by more than three standard errors of their difference.
    pub moved: Vec<String>,
}

impl Changes {
    /// What is different now.
    pub fn between(earlier: &Qualification, now: &Qualification) -> Changes {
        let mut changes = Changes::default();
        let (before, after) = (rows(earlier), rows(now));
        for (comparison, row) in &before {
            if is_test(comparison, row) && !after.iter().any(|(_, other)| same(row, other) && other.outcome.is_some()) {
                changes.lost.push(name(row));
            }
        }
        for (comparison, row) in &after {
            let known = before.iter().map(|(_, other)| *other).find(|other| same(row, other));
            match known {
                None if is_test(comparison, row) => changes.gained.push(name(row)),
                None => {}
                Some(other) => {
                    if other.outcome != row.outcome
                        && let (Some(was), Some(is)) = (other.outcome, row.outcome)
                    {
                        let words = super::words::outcome;
                        changes.outcomes.push(format!("{}: {} before, {} now", name(row), words(was), words(is)));
                    }
                    if let (Some(was), Some(is)) = (other.margin, row.margin)
                        && was != is
                        && is_test(comparison, row)
                    {
                        changes.conditions.push(format!("{}: a margin of {was} before, {is} now", name(row)));
                    }
                    let text = moved(other, row).filter(|text| !changes.moved.contains(text));
                    changes.moved.extend(text);
                }
            }
        }
        for comparison in &now.comparisons {
            let is = physics_hash(&comparison.scene);
            let same = |other: &&Comparison| other.scene.name == comparison.scene.name;
            let was = earlier.comparisons.iter().find(same).map(|other| physics_hash(&other.scene));
            if was.is_some_and(|was| was != is) {
                changes.conditions.push(format!("{}: another scene than before", comparison.scene.name));
            }
        }
        changes.studies(earlier, now);
        changes
    }

    /// What is different in the tests of studies.
    fn studies(&mut self, earlier: &Qualification, now: &Qualification) {
        let (before, after) = (study_tests(earlier), study_tests(now));
        let known = |tests: &[(&StudySection, &StudyTest)], study: &StudySection, test: &StudyTest| {
            let same =
                |(other, made): &&(&StudySection, &StudyTest)| (&other.name, &made.name) == (&study.name, &test.name);
            tests.iter().find(same).map(|(_, made)| made.outcome)
        };
        let name = |study: &StudySection, test: &StudyTest| format!("{}: {}", study.name, test.name);
        for (study, test) in before {
            match known(&after, study, test) {
                None => self.lost.push(name(study, test)),
                Some(is) if is != test.outcome => {
                    let (was, is) = (test.outcome.words(), is.words());
                    self.outcomes.push(format!("{}: {was} before, {is} now", name(study, test)));
                }
                Some(_) => {}
            }
        }
        let before = study_tests(earlier);
        let gained = after.iter().filter(|(study, test)| known(&before, study, test).is_none());
        self.gained.extend(gained.map(|(study, test)| name(study, test)));
    }

    /// Whether something is worse than it was: a test is gone.
    pub fn has_lost(&self) -> bool {
        !self.lost.is_empty()
    }

    /// Each change in a line, after the kind of change.
    pub fn lines(&self) -> Vec<String> {
        let parts = [
            ("lost", &self.lost),
            ("new", &self.gained),
            ("changed", &self.outcomes),
            ("other conditions", &self.conditions),
            ("moved beyond noise", &self.moved),
        ];
        parts.iter().flat_map(|(word, list)| list.iter().map(move |text| format!("{word}: {text}"))).collect()
    }

    /// In lines.
    pub fn text(&self) -> String {
        let lines = self.lines();
        match lines.is_empty() {
            true => {
                "against the earlier report: the same tests, conditions and outcomes, and no mean moved beyond noise"
                    .into()
            }
            false => format!("against the earlier report:\n  {}", lines.join("\n  ")),
        }
    }
}

fn study_tests(qualification: &Qualification) -> Vec<(&StudySection, &StudyTest)> {
    qualification.studies.iter().flat_map(|study| study.tests.iter().map(move |test| (study, test))).collect()
}

fn rows(qualification: &Qualification) -> Vec<(&Comparison, &Row)> {
    let each = |comparison| move |row| (comparison, row);
    qualification.comparisons.iter().flat_map(|comparison| comparison.rows.iter().map(each(comparison))).collect()
}

fn is_test(comparison: &Comparison, row: &Row) -> bool {
    row.code == comparison.judged && row.reference_code.is_some() && row.outcome.is_some()
}

fn same(one: &Row, other: &Row) -> bool {
    (&one.scene, &one.observable, &one.code, &one.reference_code)
        == (&other.scene, &other.observable, &other.code, &other.reference_code)
}

fn name(row: &Row) -> String {
    let against = row.reference_code.as_ref().map_or(String::new(), |code| format!(" against {code}"));
    format!("{}, {} of {}{against}", row.scene, names::observable(&row.observable), row.code)
}

/// A mean that is another one, beyond what its spread over seeds explains.
fn moved(before: &Row, now: &Row) -> Option<String> {
    let error = |row: &Row| {
        let deviation = row.standard_deviation.filter(|_| row.seeds > 1)?;
        Some(deviation / (row.seeds as f64).sqrt())
    };
    let shift = now.mean? - before.mean?;
    let noise = error(before)?.hypot(error(now)?);
    (shift.abs() > BEYOND_NOISE * noise).then(|| {
        format!(
            "{}, {} of {}: {} before, {} now, {} standard errors apart",
            now.scene,
            names::observable(&now.observable),
            now.code,
            significant(before.mean.unwrap_or_default()),
            significant(now.mean.unwrap_or_default()),
            two_digits(shift.abs() / noise)
        )
    })
}
