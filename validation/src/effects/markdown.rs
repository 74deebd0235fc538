//! An ablation as a table in Markdown.

use super::{Ablation, Study};

/// The verdicts on each effect, observable by observable; empty without an ablation.
pub fn markdown(study: &Study) -> String {
    let Some(ablation) = &study.ablation else { return String::new() };
    let mut text = format!(
        "# {}: which effects it needs\n\n{} seeds each; 90% interval of the scene as it is, less the changed one.\n\n\
         | effect | change | observable | as it is | changed | interval | margin | verdict |\n| {}\n",
        study.scene,
        ablation.seeds.len(),
        "--- |".repeat(8)
    );
    rows(ablation).for_each(|row| text += &row);
    text
}

fn rows(ablation: &Ablation) -> impl Iterator<Item = String> + '_ {
    ablation.rows.iter().map(|row| {
        let rounding = row.rounding();
        let changed = row.changed_mean.map_or("nothing to measure".into(), |mean| rounding.value(mean));
        let interval = row.interval90.map_or(String::new(), |interval| rounding.interval(interval));
        format!(
            "| {} | {} | {} | {} | {changed} | {interval} | {} | {} |\n",
            row.effect,
            row.change,
            row.observable,
            row.mean.map_or("not measured".into(), |mean| rounding.value(mean)),
            row.margin,
            row.need.words()
        )
    })
}
