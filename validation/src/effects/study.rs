//! Results of `makadam effects`: the document, its text and the table of an ablation.

use super::{Ablated, Ablation, Called, Costs, Look, called, warnings};
use crate::output::JSON_VERSION;
use crate::plan::Scene;
use crate::provenance::Provenance;
use crate::study::{Cell, DocumentError, Table, json, write_together};
use serde::Serialize;
use std::fmt::Write;
use std::path::Path;

/// The effects of a scene.
#[derive(Clone, Debug, Serialize)]
pub struct Study {
    /// Version of the document's form.
    pub version: u32,
    /// `effects`.
    pub command: &'static str,
    /// The scene.
    pub scene: String,
    /// Which effects it calls for.
    pub effects: Vec<Called>,
    /// What kernels cost on its contacts; absent where it has none.
    pub costs: Option<Costs>,
    /// A stretch of the run.
    pub look: Option<Look>,
    /// What a user should know.
    pub warnings: Vec<String>,
    /// Each effect off or on; absent where it was not asked for.
    pub ablation: Option<Ablation>,
    /// Where it was measured.
    pub provenance: Provenance,
}

impl Study {
    /// The effects of a scene, whose file has this text, and what was measured of them.
    pub fn new(
        scene: &Scene,
        text: &str,
        (look, costs): (Option<Look>, Option<Costs>),
        ablation: Option<Ablation>,
        provenance: Provenance,
    ) -> Study {
        Study {
            version: JSON_VERSION,
            command: "effects",
            scene: scene.name.clone(),
            effects: called(scene, text),
            costs,
            warnings: warnings(scene, look.as_ref()),
            look,
            ablation,
            provenance,
        }
    }

    /// Writes `effects.json` and, where there is an ablation, `ablation.md`.
    ///
    /// # Errors
    /// [`DocumentError`] if a file cannot be written; none is changed then.
    pub fn write(&self, folder: &Path) -> Result<(), DocumentError> {
        let table = self.ablation.is_some().then(|| ("ablation.md".into(), markdown(self).into_bytes()));
        let files: Vec<_> = [json("effects", self)?].into_iter().chain(table).collect();
        write_together(folder, &files)
    }
}

/// Tables of effects, costs, ablation, and the warnings.
pub fn table(study: &Study) -> String {
    let mut text = format!("{}\n\n", study.scene);
    for called in &study.effects {
        let place = called.line.map_or(String::new(), |line| format!(" (line {line})"));
        let state = if called.on { "on" } else { "off" };
        let _ = writeln!(text, "{:<20} {state:<4} {}{place}", called.effect, called.why);
    }
    if let Some(look) = &study.look {
        text += &energy(look);
    }
    if let Some(costs) = &study.costs {
        text += &kernels(costs);
    }
    if let Some(ablation) = &study.ablation {
        text += &verdicts(ablation);
    }
    for warning in &study.warnings {
        let _ = writeln!(text, "\nwarning: {warning}");
    }
    text.trim_end().to_string()
}

fn energy(look: &Look) -> String {
    format!(
        "\nover {:.2} s: {:.3e} J lost, to friction {:.1}%, resistance to turning {:.1}%, impacts {:.1}%; largest overlap {:.2}% of \
         a radius\n",
        look.seconds,
        look.lost,
        100.0 * look.friction,
        100.0 * look.resistance,
        100.0 * look.impacts,
        100.0 * look.largest_overlap
    )
}

fn kernels(costs: &Costs) -> String {
    let mut text = format!(
        "\nkernel over {} contacts, one thread, {}                 ns a contact sweep   of friction's   bytes a contact\n",
        costs.contacts, costs.instruction_set
    );
    for cost in &costs.kernels {
        let called = if cost.called { "  <- this scene" } else { "" };
        let _ = writeln!(
            text,
            "{:<42} {:>18.2} {:>15.2} {:>17}{called}",
            cost.effects, cost.nanoseconds, cost.over_friction, cost.bytes
        );
    }
    text
}

fn verdicts(ablation: &Ablation) -> String {
    let mut text = format!("\nablation, {} seeds each\n", ablation.seeds.len());
    for row in &ablation.rows {
        let rounding = row.rounding();
        let changed = row.changed_mean.map_or("-".into(), |mean| rounding.value(mean));
        let interval = row.interval90.map_or(String::new(), |interval| format!(" {}", rounding.interval(interval)));
        let _ = writeln!(
            text,
            "{:<20} {:<28} {:<28} {} -> {changed}{interval}, margin {}: {}",
            row.effect,
            row.change,
            row.observable,
            row.mean.map_or("not measured".into(), |mean| rounding.value(mean)),
            row.margin,
            row.need.words()
        );
    }
    text
}

/// The verdicts on each effect, observable by observable; empty without an ablation.
fn markdown(study: &Study) -> String {
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
