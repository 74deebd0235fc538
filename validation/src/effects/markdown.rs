//! An ablation as a table in Markdown.

use super::Study;
use super::ablation::Ablated;
use crate::study::{Cell, Table};

/// The verdicts on each effect, observable by observable; empty without an ablation.
pub fn markdown(study: &Study) -> String {
    let Some(ablation) = &study.ablation else { return String::new() };
    let heads = ["effect", "change", "observable", "as it is", "changed", "interval", "margin", "verdict"];
    format!(
        "# {}: which effects it needs\n\n{} seeds each; 90% interval of the scene as it is, less the changed one.\n\n{}",
        study.scene,
        ablation.seeds.len(),
        Table::new(&heads, &[]).of(&ablation.rows, cells).markdown()
    )
}

fn cells(row: &Ablated) -> Vec<Cell> {
    let rounding = row.rounding();
    vec![
        row.effect.into(),
        row.change.as_str().into(),
        row.observable.as_str().into(),
        row.mean.map_or("not measured".into(), |mean| rounding.value(mean)).into(),
        row.changed_mean.map_or("nothing to measure".into(), |mean| rounding.value(mean)).into(),
        row.interval90.map(|interval| rounding.interval(interval)).into(),
        row.margin.to_string().into(),
        row.need.words().into(),
    ]
}
