//! Page: all data of the template, gathered and named.

use super::qualification::{Qualification, StudyOutcome, StudySection, Verdict};
use super::{bias, figures, tables};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use makadam_compare::compare::{Comparison, FinalState};
use makadam_compare::study::{environment, style};
use makadam_frames::run_frames::{Quantity, RunFrame};
use makadam_view::draw::names::code_style;
use makadam_view::draw::numbers;
use makadam_view::pictures::{Scale, Style, Subject, View, camera, draw, png};
use minijinja::{Value, context};
use rayon::prelude::*;

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
        bias => bias_section(comparisons),
        sections => comparisons.iter().enumerate().map(section).collect::<Vec<_>>(),
        studies => qualification.studies.iter().map(study).collect::<Vec<_>>(),
        provenance => provenance.collect::<Vec<_>>(),
    })
}

/// Name and style class of a verdict, and its sentence without the name.
fn standing(verdict: &Verdict) -> Value {
    let word = verdict.standing.words();
    let rest = verdict.sentence.strip_prefix(word).and_then(|rest| rest.strip_prefix(": "));
    let (mark, sentence) = rest.map_or((".", verdict.sentence.as_str()), |rest| (":", rest));
    context! { word, mark, sentence, class => verdict.standing.class() }
}

/// Bias and scatter of each observable; `None` if no observable is compared in two scenes.
fn bias_section(comparisons: &[Comparison]) -> Option<Value> {
    let biases = bias::biases(comparisons);
    Some(context! {
        figure => bias::figure(&biases)?,
        table => bias::table(&biases).html(),
        conditions => bias::conditions(comparisons).html(),
    })
}

/// Identifies a scene by its index: names of scenes may contain characters that an anchor may not.
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
        gallery => gallery(comparison),
        runs => tables::runs(comparison).map(|table| table.html()),
        notes => comparison.notes,
        scene_file => toml::to_string_pretty(scene).unwrap_or_default(),
    }
}

fn study(study: &StudySection) -> Value {
    let count = |outcome| study.named(outcome).len();
    let (word, class) = match (count(StudyOutcome::Failed), count(StudyOutcome::NotMeasured)) {
        (0, 0) => ("Passed", "agree"),
        (0, _) => ("Not measured", "undecided"),
        _ => ("Failed", "disagree"),
    };
    context! {
        study,
        word,
        class,
        anchor => format!("study-{}", study.name),
        sentence => study.sentence(),
        wall_time => numbers::duration(study.wall_seconds),
        table => tables::study(study).html(),
        figures => study.figures,
        files => study.files.iter().map(|(name, _)| name).collect::<Vec<_>>(),
    }
}

/// Width and height of a picture, pixels.
const SIZE: [usize; 2] = [560, 460];

/// Draws the final state of each code; `None` if no code has one.
pub(super) fn gallery(comparison: &Comparison) -> Option<Value> {
    let states: Vec<_> = comparison.final_states.iter().filter(|state| !state.particles.is_empty()).collect();
    let frame = |time, particles| RunFrame::of_state(&comparison.scene, time, particles);
    let frames: Vec<RunFrame> = states.iter().map(|state| frame(state.time, &state.particles)).collect();
    let first = states.first()?;
    let speeds: Vec<Quantity> = frames.iter().filter_map(|frame| frame.quantity("speed")).collect();
    let all: Vec<f64> = speeds.iter().flat_map(|speed| speed.values.iter().copied()).collect();
    let scale = Scale::of("speed", &all);
    let style = Style { size: SIZE, view: View::Natural, cut: None, walls: true };
    let camera = camera(&Subject::of(frames.iter(), false), &frames[0], &style);
    let shown = |((state, frame), speed): ((&&FinalState, &RunFrame), &Quantity)| {
        let picture = draw(frame, speed, &scale, &camera, &style, "");
        context! {
            code => state.code,
            class => code_style(&state.code).class,
            address => format!("data:image/png;base64,{}", BASE64_STANDARD.encode(png(&picture))),
            width => picture.width,
            height => picture.height,
        }
    };
    let caption = format!(
        "Final states at {} s, seed {}, coloured by speed on one scale. Single grains need not coincide: the smallest differences grow from \
         contact to contact, and only averages are compared.",
        numbers::compact(first.time),
        first.seed
    );
    let pictures: Vec<Value> = states.par_iter().zip(&frames).zip(&speeds).map(shown).collect();
    Some(context! { pictures, caption })
}
