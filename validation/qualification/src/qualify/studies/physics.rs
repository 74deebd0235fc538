//! Studies of the physics: stress tests, published laws, and effects that scenes need.

use super::{Item, Job, Named, Part, Place, QualifyError, Solved, unless_fatal, weight};
use crate::qualify::tier::Ablated;
use crate::report::{StudyOutcome, StudyTest};
use makadam_compare::codes::Makadam;
use makadam_compare::laws::{self, Case as LawCase, LAWS, LawResult, figure_and_bounds, row_of};
pub use makadam_compare::stability::{Campaign, Case, Outcome, Verdict, catalogue, known_exception};
use makadam_compare::study::{DocumentError, File, RunError, Table, cells};
pub use makadam_studies::effects::{Ablated as Row, Ablation, Need, Plan};
use std::sync::Arc;

/// Wall time after which a stress test is stopped, s: that of the whole catalogue.
const TIME_LIMIT: f64 = 600.0;

/// Stress tests of `makadam stability`, in Makadam.
pub(super) fn stress_tests<'a>(filters: &[&str], place: Place<'a>) -> Result<Part<'a>, QualifyError> {
    let cache = Arc::new(place.open("stability")?);
    let is_wanted = |case: &Case| filters.is_empty() || filters.iter().any(|filter| case.matches(filter));
    let item = |case: Case| {
        let cache = cache.clone();
        Item::of(format!("stability {}", case.name), weight(&case.scene), false, move || {
            let _display = (place.settings.announce)(&case.name);
            let folder = &place.folder("stability");
            let campaign = Campaign { cases: &[], codes: &[], time_limit: TIME_LIMIT, folder, cache: &cache };
            let outcome = campaign.outcome(&case, &Makadam)?;
            let (wall_seconds, tests) = (outcome.wall_seconds, vec![case_test(&case, &outcome)]);
            Ok(Solved { runs: 1, wall_seconds, tests, ..Solved::default() })
        })
    };
    let scope = "Scenes that break simulators, each with what is right by a closed form or a law of conservation.";
    let items = catalogue().into_iter().filter(is_wanted).map(item).collect();
    Ok(Part::new("stability", "Hard cases", scope, items))
}

fn case_test(case: &Case, outcome: &Outcome) -> StudyTest {
    let measured = outcome.text();
    let test = StudyTest::of(case.name.clone(), measured, case.right.clone(), outcome.verdict == Verdict::AsStated);
    let remark = outcome.reason.clone().filter(|_| test.outcome == StudyOutcome::Failed);
    StudyTest { remark, ..test }.with_exception(known_exception(&case.name))
}

/// Sweeps of a step, which convert the work of a law (grains times steps) to that of other jobs.
const SWEEPS: f64 = 20.0;

/// Published laws.
pub(super) fn laws<'a>(laws: &[(&'static str, u64)], place: Place<'a>) -> Result<Part<'a>, QualifyError> {
    let scope = "What others found in experiments and, for the friction of a flowing layer, in simulations: measured as its authors did, and \
                 judged by bounds that were set before.";
    let items = laws.iter().map(|&(name, seeds)| law_item(name, seeds, place)).collect::<Result<_, _>>()?;
    Ok(Part::new("laws", "Published laws", scope, items))
}

fn law_item<'a>(name: &'static str, seeds: u64, place: Place<'a>) -> Result<Item<'a>, QualifyError> {
    let law = LAWS.iter().find(|law| law.name == name).expect("the table of tiers names laws");
    let cache = Arc::new(place.open(&format!("laws/{name}"))?);
    let cases = (law.cases)(false).into_iter().map(Arc::new);
    let runs: Vec<_> = cases.flat_map(|case| (1..=seeds).map(move |seed| (case.clone(), seed))).collect();
    let job = |(case, seed): (Arc<LawCase>, u64)| {
        let cache = cache.clone();
        Job {
            identity: format!("law {} seed {seed}", case.name),
            weight: laws::work(&case) * SWEEPS,
            alone: false,
            work: Box::new(move || {
                let share = (place.settings.announce)(&format!("{} seed {seed}", case.name));
                unless_fatal(row_of(law, &case, seed, &cache, &*share))
            }),
        }
    };
    let jobs = runs.iter().cloned().map(job).collect();
    let solved = move || {
        let rows = runs.iter().map(|(case, seed)| row_of(law, case, *seed, &cache, &|_| {}));
        match rows.collect::<Result<Vec<_>, RunError>>() {
            Ok(rows) => Ok(law_solved(LawResult::new(law, rows))?),
            Err(error) if error.ends_all() => Err(error),
            Err(error) => {
                let test = StudyTest::of(format!("{name}: runs"), "no numbers".into(), "every run ends".into(), false);
                let test = StudyTest { outcome: StudyOutcome::NotMeasured, remark: Some(error.to_string()), ..test };
                Ok(Solved { tests: vec![test], ..Solved::default() })
            }
        }
    };
    Ok(Item { jobs, solved: Box::new(solved) })
}

fn law_solved(result: LawResult) -> Result<Solved, DocumentError> {
    Ok(Solved {
        runs: result.rows.len(),
        wall_seconds: result.wall_seconds(),
        tests: law_tests(&result),
        notes: vec![format!("{}: {}. {}", result.name, result.statement, result.source)],
        files: vec![laws::runs(&result.rows).csv(&format!("laws-{}", result.name))?],
        figures: result.figures,
    })
}

/// Returns the figures of a law that have bounds.
fn law_tests(result: &LawResult) -> Vec<StudyTest> {
    let bounded = result.findings.iter().filter(|finding| [finding.low, finding.high] != [None, None]);
    let tests = bounded.map(|finding| {
        let [measured, right] = figure_and_bounds(finding);
        // A measured number does not belong to a name.
        let what = finding.what.split(", I = ").next().unwrap_or(&finding.what);
        StudyTest::of(format!("{}: {what}", result.name), measured, right, finding.holds())
    });
    tests.collect()
}

/// Scenes with each of their effects off, or on: an effect that a scene is known to need must change a measured value.
pub(super) fn ablations<'a>(scenes: &[Ablated], place: Place<'a>) -> Result<Part<'a>, QualifyError> {
    let scope = "Scenes with each of their effects off, and resistance to turning on: what a scene is known to need must move an observable by \
                 more than its margin.";
    let items = scenes.iter().map(|ablated| ablation_item(*ablated, place)).collect::<Result<_, _>>()?;
    Ok(Part::new("effects", "Effects that scenes need", scope, items))
}

fn ablation_item<'a>(ablated: Ablated, place: Place<'a>) -> Result<Item<'a>, QualifyError> {
    let own = Arc::new((Named::open(ablated.scene, place)?, (1..=ablated.seeds).collect::<Vec<_>>()));
    let mut jobs = Vec::new();
    let plan = plan_of(&own, place);
    for (version, &seed) in plan.versions().iter().flat_map(|version| own.1.iter().map(move |seed| (version, seed))) {
        let (own, version) = (own.clone(), version.clone());
        jobs.push(Job {
            identity: plan.runs(&version, seed).key(&Makadam, seed, false).name().into(),
            weight: weight(&version.scene),
            alone: false,
            work: Box::new(move || unless_fatal(plan_of(&own, place).take(&version, seed))),
        });
    }
    let solved = move || {
        let ablation = Ablation::run(&plan_of(&own, place))?;
        Ok(Solved {
            runs: ablation.runs,
            wall_seconds: ablation.wall_seconds,
            tests: ablation_tests(&ablated, &ablation),
            files: vec![ablation_rows(ablated.scene, &ablation)?],
            ..Solved::default()
        })
    };
    Ok(Item { jobs, solved: Box::new(solved) })
}

fn plan_of<'s>((named, seeds): &'s (Named, Vec<u64>), place: Place<'s>) -> Plan<'s> {
    Plan {
        scene: &named.scene,
        scene_file: &named.file,
        seeds,
        time_limit: place.settings.time_limit,
        cache: place.cache,
        announce: place.settings.announce,
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

/// Tests that the unchanged scene has all its observables, and that it needs its effects.
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
        // Where an effect is known to be necessary for any measurement, the scene needs it as well.
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
