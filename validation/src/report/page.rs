//! The page: everything that the template shows, gathered and named.

use super::pictures::{Gallery, Picture};
use super::qualification::{Qualification, Verdict, join};
use super::{forces, forest, pictures, published, series, speed, studies, tables};
use crate::compare::{Comparison, Source};
use crate::draw::{names, numbers};
use crate::study::{environment, style};
use minijinja::{Value, context};

/// Renders the page.
pub(super) fn render(qualification: &Qualification) -> Result<String, minijinja::Error> {
    let mut environment = environment()?;
    environment.add_template("page", include_str!("page.html"))?;
    environment.add_template("laws", include_str!("laws.html"))?;
    environment.add_template("scene", include_str!("scene.html"))?;
    environment.add_template("studies", include_str!("studies.html"))?;
    environment.add_template("words", include_str!("words.html"))?;

    let verdict = qualification.verdict();
    let comparisons = &qualification.comparisons;
    let galleries: Vec<Option<Gallery>> =
        comparisons.iter().enumerate().map(|(place, c)| pictures::gallery(c, &anchor(place))).collect();
    let covers = covers(comparisons, &galleries);
    let sections: Vec<Value> =
        comparisons.iter().zip(galleries).enumerate().map(|(place, (c, gallery))| section(c, place, gallery)).collect();
    environment.get_template("page")?.render(context! {
        title => qualification.title,
        tier => qualification.tier,
        wall_time => numbers::duration(qualification.wall_seconds),
        verdict => verdict,
        standing => standing(&verdict),
        style => style(),
        grain_rules => pictures::rules(),
        gradients => pictures::gradients(),
        covers => covers,
        summary => tables::summary(comparisons).map(|table| table.html()),
        sources => sources(comparisons),
        speeds => speed::table(comparisons).map(|table| table.html()),
        slow_settings => slow_settings(comparisons),
        notes => qualification.notes,
        outside_spread => qualification.outside_spread,
        unchecked => qualification.unchecked,
        failed_runs => qualification.failed_runs,
        sections => sections,
        extent => extent(comparisons),
        studies => qualification.studies.iter().map(studies::shown).collect::<Vec<_>>(),
        judged => published::table(&qualification.laws).html(),
        laws => qualification.laws.iter().map(published::shown).collect::<Vec<_>>(),
        provenance => provenance(qualification),
    })
}

/// Word and style class of a verdict, and its sentence behind the word, which is not repeated where the sentence begins with it.
fn standing(verdict: &Verdict) -> Value {
    let word = verdict.standing.words();
    let rest = verdict.sentence.strip_prefix(word).and_then(|rest| Some((rest.chars().next()?, rest)));
    let (mark, sentence) = match rest {
        Some((mark, rest)) if mark.is_ascii_punctuation() => (mark, rest[1..].trim_start()),
        _ => ('.', verdict.sentence.as_str()),
    };
    context! { word => word, class => verdict.standing.class(), mark => mark.to_string(), sentence => sentence }
}

/// Anchor of a scene's section. Names of scenes may hold characters that an anchor may not.
fn anchor(place: usize) -> String {
    format!("scene-{}", place + 1)
}

/// The pictures at the head of the page: of one scene those of all codes, of several the judged code's of each.
fn covers(comparisons: &[Comparison], galleries: &[Option<Gallery>]) -> Vec<Value> {
    let is_alone = comparisons.len() == 1;
    let of_scene = |(place, (comparison, gallery)): (usize, (&Comparison, &Option<Gallery>))| {
        let pictures = gallery.iter().flat_map(|gallery| &gallery.rows).take(1).flat_map(|row| &row.pictures);
        let shown = pictures.filter(|picture| is_alone || picture.code == comparison.judged);
        let cover = |picture: &Picture| {
            let label = if is_alone { &picture.code } else { &comparison.scene.name };
            context! { label => label, section => anchor(place), picture => picture.anchor }
        };
        shown.map(cover).collect::<Vec<_>>()
    };
    comparisons.iter().zip(galleries).enumerate().flat_map(of_scene).collect()
}

fn section(comparison: &Comparison, place: usize, gallery: Option<Gallery>) -> Value {
    let gallery = gallery.map(|gallery| {
        let rows: Vec<Value> = gallery
            .rows
            .into_iter()
            .map(|row| {
                let pictures: Vec<Value> = row
                    .pictures
                    .into_iter()
                    .map(|Picture { code, svg, .. }| context! { class => names::code_style(&code).class, code => code, svg => svg })
                    .collect();
                context! { view => row.view, pictures => pictures }
            })
            .collect();
        context! { rows => rows, legend => gallery.legend, caption => gallery.caption }
    });
    let series: Vec<Value> = series::figures(comparison)
        .into_iter()
        .map(|figure| context! { observable => figure.observable, svg => figure.svg, caption => figure.caption })
        .collect();
    context! {
        anchor => anchor(place),
        name => comparison.scene.name,
        description => comparison.scene.description,
        facts => facts(comparison),
        results => tables::results(comparison).map(|table| table.html()),
        forest => forest::figure(comparison),
        gallery => gallery,
        series => series,
        forces => forces::figure(comparison).map(|(svg, caption)| context! { svg => svg, caption => caption }),
        runs => tables::runs(comparison).map(|table| table.html()),
        limits => tables::limits(comparison),
        notes => comparison.notes,
        scene_file => toml::to_string_pretty(&comparison.scene).unwrap_or_default(),
    }
}

/// How long is simulated and when it is measured, in a sentence.
fn facts(comparison: &Comparison) -> String {
    let scene = &comparison.scene;
    let measured = match scene.measure.from {
        Some(from) => format!(
            "measured from {} s on, every {} s",
            numbers::compact(from),
            numbers::compact(scene.measure.interval)
        ),
        None => "measured in the last frame".into(),
    };
    format!("Simulated time {} s, {measured}.", numbers::compact(scene.duration))
}

/// What was run here and now and what was read from recordings, a sentence or two a code.
///
/// The values of a scene come from the code's first summary; a live one after it is a run for timing.
fn sources(comparisons: &[Comparison]) -> Vec<String> {
    let mut codes: Vec<&str> = Vec::new();
    for code in comparisons.iter().flat_map(|c| &c.codes) {
        if !codes.contains(&code.code.as_str()) {
            codes.push(&code.code);
        }
    }
    let mut sentences = Vec::new();
    for name in codes {
        let (mut live, mut recorded, mut again) = (Vec::new(), Vec::new(), Vec::new());
        for comparison in comparisons {
            let scene = comparison.scene.name.as_str();
            let mut summaries = comparison.codes.iter().filter(|code| code.code == name);
            match summaries.next().map(|first| first.source) {
                Some(Source::Live) => live.push(scene),
                Some(Source::Recorded) => {
                    recorded.push(scene);
                    if summaries.any(|code| code.source == Source::Live) {
                        again.push(scene);
                    }
                }
                None => {}
            }
        }
        sentences.push(match (live.is_empty(), recorded.is_empty()) {
            (_, true) => format!("{name} was run live in {}.", join(&live)),
            (true, false) => format!("{name}'s values are recorded ones in {}.", join(&recorded)),
            (false, false) => {
                format!("{name} was run live in {}; its values are recorded ones in {}.", join(&live), join(&recorded))
            }
        });
        if !again.is_empty() {
            sentences
                .push(format!("It was also run live in {}, for its speed and to check the recordings.", join(&again)));
        }
    }
    sentences
}

/// How many seeds of each code there are, and whether it was run now, for the first lines of the page.
fn extent(comparisons: &[Comparison]) -> Option<String> {
    let mut codes: Vec<&str> = comparisons.iter().flat_map(|c| &c.codes).map(|code| code.code.as_str()).collect();
    let mut seen = std::collections::BTreeSet::new();
    codes.retain(|code| seen.insert(*code));
    let each = codes.iter().filter_map(|name| {
        // The first summary of a scene is that of its values; one after it was timed.
        let of_scene =
            |c: &'_ Comparison| c.codes.iter().filter(|code| code.code == *name).cloned().collect::<Vec<_>>();
        let summaries: Vec<_> = comparisons.iter().map(of_scene).filter(|of_scene| !of_scene.is_empty()).collect();
        let seeds = || summaries.iter().map(|of_scene| of_scene[0].seeds.len());
        let (fewest, most) = (seeds().min()?, seeds().max()?);
        let recorded = summaries.iter().any(|of_scene| of_scene[0].source == Source::Recorded);
        let again =
            summaries.iter().filter(|of_scene| of_scene[1..].iter().any(|one| one.source == Source::Live)).count();
        let how = match (recorded, again) {
            (false, _) => "live".into(),
            (true, 0) => "recorded, not run".into(),
            (true, 1) => "recorded, also live in 1 scene".into(),
            (true, scenes) => format!("recorded, also live in {scenes} scenes"),
        };
        let count = if fewest == most { fewest.to_string() } else { format!("{fewest} to {most}") };
        Some(format!("{name} {count} ({how})"))
    });
    let each: Vec<String> = each.collect();
    (!each.is_empty()).then(|| format!("Seeds a scene: {}.", each.join(", ")))
}

fn slow_settings(comparisons: &[Comparison]) -> Option<String> {
    let codes = speed::slow_settings(comparisons);
    (!codes.is_empty()).then(|| {
        format!(
            "{} ran below a fifth of the Rayleigh time step, the fastest setting at which restitution is still within 4%; \
             at that setting the ratio would be smaller.",
            join(&codes)
        )
    })
}

fn provenance(qualification: &Qualification) -> Vec<(String, &str)> {
    qualification.provenance.iter().map(|(key, value)| (key.replace('_', " "), value.as_str())).collect()
}
