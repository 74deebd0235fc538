//! Effects of a scene: active ones, their costs, and the need for each.
//!
//! ```text
//! scene ─> called ────────────────────────────────> active effects with their lines
//!       ├> flowing state ─> costs ────────────────> nanoseconds and bytes per contact
//!       └> each effect off or on, seeds ─> ablation > needed, not needed, undecided
//! ```

mod ablation;
mod costs;

pub use ablation::{Ablated, Ablation, Need, Plan, Variation, variations};
pub use costs::{Called, Costs, called};

use makadam_compare::study::{Answer, Cell, Document, Report, Section, Table, cells};
use makadam_frames::output::JSON_VERSION;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::provenance::Provenance;
use makadam_view::draw::numbers::{Rounding, plural};
use serde::Serialize;

/// Content of `effects.json`.
#[derive(Clone, Debug, Serialize)]
#[expect(missing_docs, reason = "validation/docs/json.md describes the fields of documents")]
pub struct Study {
    pub version: u32,
    pub command: &'static str,
    pub scene: String,
    /// Effects, active or not.
    pub effects: Vec<Called>,
    /// Costs of kernels on the contacts of the scene; absent where it has none.
    pub costs: Option<Costs>,
    /// Each effect off or on; absent where it was not requested.
    pub ablation: Option<Ablation>,
    pub provenance: Provenance,
}

impl Study {
    /// Joins the measurements of a scene, whose file has this text, with its effects.
    pub fn new(
        scene: &MeasuredScene,
        text: &str,
        costs: Option<Costs>,
        ablation: Option<Ablation>,
        provenance: Provenance,
    ) -> Study {
        Study {
            version: JSON_VERSION,
            command: "effects",
            scene: scene.name.clone(),
            effects: called(scene, text),
            costs,
            ablation,
            provenance,
        }
    }
}

impl Document for Study {
    const NAME: &'static str = "effects";

    fn report(&self) -> Report {
        let active: Vec<&str> = self.effects.iter().filter(|effect| effect.on).map(|effect| effect.effect).collect();
        let build = &self.provenance.build;
        let kernels = self.costs.as_ref().map(kernels);
        let verdicts = self.ablation.as_ref().map(verdicts);
        Report {
            kind: "Makadam, effects of a scene",
            title: format!("Effects of the scene {}", self.scene),
            facts: vec![build.processor.clone(), format!("version {}", build.version), self.provenance.time.clone()],
            answer: Answer {
                class: "agree",
                word: format!("{}.", plural(active.len(), "active effect")),
                sentence: format!("{}.", active.join(", ")),
            },
            findings: Vec::new(),
            sections: [Section::new("Effects", "", effects(&self.effects))]
                .into_iter()
                .chain(kernels)
                .chain(verdicts)
                .collect(),
            notes: Vec::new(),
            limits: vec![
                "Kernels are timed in turn on the contacts of one state; ratios are medians over rounds.".into(),
                "An effect is needed if an observable moves beyond its margin without it.".into(),
            ],
            provenance: self.provenance.pairs(),
            files: "effects.json",
        }
    }
}

fn effects(effects: &[Called]) -> Table {
    Table::new(&["effect", "state", "reason", "line"], &[]).of(effects, |called| {
        let line = called.line.map(|line| line.to_string());
        cells![called.effect, if called.on { "on" } else { "off" }, &called.why, line]
    })
}

fn kernels(costs: &Costs) -> Section {
    let table = Table::new(&["kernel"], &["ns per contact sweep", "of friction's", "bytes per contact"]);
    let table = table.of(&costs.kernels, |cost| {
        let [time, ratio] = [cost.nanoseconds, cost.over_friction].map(|value| format!("{value:.2}"));
        vec![Cell::from(cost.effects).strong(cost.called), time.into(), ratio.into(), cost.bytes.into()]
    });
    let title = format!("Kernels over {} contacts, one thread, {}", costs.contacts, costs.instruction_set);
    Section::new(format!("{title} (* of this scene)"), "", table)
}

fn verdicts(ablation: &Ablation) -> Section {
    let heads = ["effect", "change", "observable", "as it is", "changed", "interval", "margin", "verdict"];
    let table = Table::new(&heads, &[]).of(&ablation.rows, |row: &Ablated| {
        let rounding = Rounding::to_margin(row.margin);
        cells![
            row.effect,
            &row.change,
            &row.observable,
            row.mean.map_or("not measured".into(), |mean| rounding.value(mean)),
            row.changed_mean.map_or("nothing to measure".into(), |mean| rounding.value(mean)),
            row.interval90.map(|interval| rounding.interval(interval)),
            row.margin.to_string(),
            row.need.words(),
        ]
    });
    let text = "Intervals are those of 90% of the scene as it is, less the changed one.";
    Section::new(format!("Ablation, {} seeds each", ablation.seeds.len()), text, table)
}
