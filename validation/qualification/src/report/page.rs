//! The page: all that the template shows, gathered and named.

use super::qualification::{Qualification, StudySection, Verdict};
use super::{figures, pictures, tables};
use makadam_compare::compare::Comparison;
use makadam_compare::study::{environment, style};
use makadam_view::draw::numbers;
use minijinja::{Value, context};

pub(super) fn render(qualification: &Qualification) -> Result<String, minijinja::Error> {
    let mut environment = environment()?;
    environment.add_template("page", include_str!("page.html"))?;
    environment.add_template("scene", include_str!("scene.html"))?;
    environment.add_template("words", include_str!("words.html"))?;
    let Qualification { title, tier, comparisons, notes, outside_spread, unchecked, failed_runs, .. } = qualification;
    let provenance = qualification.provenance.iter().map(|(key, value)| (key.replace('_', " "), value));
    let findings: Vec<&String> = [outside_spread, unchecked, failed_runs, notes].into_iter().flatten().collect();
    environment.get_template("page")?.render(context! {
        title,
        tier,
        wall_time => numbers::duration(qualification.wall_seconds),
        standing => standing(&qualification.verdict()),
        style => style(),
        summary => tables::summary(comparisons).map(|table| table.html()),
        notes => findings,
        sections => comparisons.iter().enumerate().map(section).collect::<Vec<_>>(),
        studies => qualification.studies.iter().map(study).collect::<Vec<_>>(),
        provenance => provenance.collect::<Vec<_>>(),
    })
}

/// Word and style class of a verdict, and its sentence without the word.
fn standing(verdict: &Verdict) -> Value {
    let word = verdict.standing.words();
    let rest = verdict.sentence.strip_prefix(word).and_then(|rest| rest.strip_prefix(": "));
    let (mark, sentence) = rest.map_or((".", verdict.sentence.as_str()), |rest| (":", rest));
    context! { word, mark, sentence, class => verdict.standing.class() }
}

/// A scene by its place: names of scenes may hold characters that an anchor may not.
fn section((place, comparison): (usize, &Comparison)) -> Value {
    let scene = &comparison.scene;
    let measured = match scene.measure.from {
        Some(from) => format!(
            "measured from {} s on, every {} s",
            numbers::compact(from),
            numbers::compact(scene.measure.interval)
        ),
        None => "measured in the last frame".into(),
    };
    context! {
        anchor => format!("scene-{}", place + 1),
        name => scene.name,
        description => scene.description,
        facts => format!("Simulated time {} s, {measured}.", numbers::compact(scene.duration)),
        results => tables::results(comparison).map(|table| table.html()),
        figures => figures::all(comparison),
        gallery => pictures::gallery(comparison),
        runs => tables::runs(comparison).map(|table| table.html()),
        notes => comparison.notes,
        scene_file => toml::to_string_pretty(scene).unwrap_or_default(),
    }
}

fn study(study: &StudySection) -> Value {
    let count = study.count();
    let (word, class) = match (count.failed.len(), count.not_measured.len()) {
        (0, 0) => ("Passed", "agree"),
        (0, _) => ("Not measured", "undecided"),
        _ => ("Failed", "disagree"),
    };
    context! {
        study,
        word,
        class,
        anchor => format!("study-{}", study.name),
        sentence => count.sentence(&study.title),
        wall_time => numbers::duration(study.wall_seconds),
        table => tables::study(study).html(),
        figures => study.figures,
        files => study.files.iter().map(|(name, _)| name).collect::<Vec<_>>(),
    }
}
