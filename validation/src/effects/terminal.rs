//! The study as text.

use super::{Ablation, Costs, Look, Study};
use std::fmt::Write;

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
