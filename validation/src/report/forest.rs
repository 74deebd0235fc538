//! Intervals of differences against the margins: one line an observable and pair of codes, in units of the margin.

use super::words;
use crate::compare::{Comparison, Row};
use crate::draw::names;
use crate::draw::svg::{Anchor, Drawing};
use crate::statistics::Outcome;

const WIDTH: f64 = 580.0;
const LEFT: f64 = 168.0;
const RIGHT: f64 = 88.0;
const LINE: f64 = 21.0;
const HEADING: f64 = 25.0;

/// The plot; none if no row has a margin.
pub(super) fn figure(comparison: &Comparison) -> Option<String> {
    let rows: Vec<&Row> = comparison
        .rows
        .iter()
        .filter(|r| {
            r.difference.is_some_and(f64::is_finite) && r.margin.is_some_and(|m| m > 0.0) && r.reference_code.is_some()
        })
        .collect();
    let mut observables: Vec<&str> = rows.iter().map(|r| r.observable.as_str()).collect();
    observables.dedup();
    // `dedup` joins neighbours only; rows of one observable may be apart.
    let mut seen = Vec::new();
    observables.retain(|o| {
        if seen.contains(o) {
            false
        } else {
            seen.push(*o);
            true
        }
    });
    if observables.is_empty() {
        return None;
    }
    let reach = rows
        .iter()
        .flat_map(|r| {
            interval(r).into_iter().flatten().chain(r.difference).map(|v| (v / r.margin.unwrap_or(1.0)).abs())
        })
        .filter(|v| v.is_finite())
        .fold(1.6, f64::max);
    // A pair that is far outside would press all others into a line; it gets an arrow.
    let reach = (reach * 1.08).min(4.0);
    let height = 26.0 + observables.len() as f64 * HEADING + rows.len() as f64 * LINE + 34.0;
    let mut drawing = Drawing::new(WIDTH, height);
    let x = |v: f64| LEFT + (v / reach + 1.0) / 2.0 * (WIDTH - LEFT - RIGHT);
    let bottom = height - 34.0;

    drawing.rectangle("band", [x(-1.0), 22.0], [x(1.0), bottom]);
    drawing.text("tick", [x(0.0), 14.0], Anchor::Middle, "inside the margin");
    for tick in (-4..=4).map(f64::from).filter(|t| t.abs() <= reach) {
        let class = if tick == 0.0 { "zero" } else { "grid" };
        drawing.line(class, [x(tick), 22.0], [x(tick), bottom]);
        let label = if tick == 0.0 {
            "0".to_string()
        } else {
            format!("{}{}", if tick < 0.0 { "−" } else { "+" }, tick.abs())
        };
        drawing.text("tick", [x(tick), bottom + 14.0], Anchor::Middle, &label);
    }
    drawing.text("label", [x(0.0), height - 5.0], Anchor::Middle, "difference of the means, in margins");

    let mut y = 24.0;
    for observable in observables {
        y += HEADING;
        drawing.text("heading", [0.0, y - 8.0], Anchor::Start, &names::observable(observable));
        for row in rows.iter().filter(|r| r.observable == observable) {
            line(&mut drawing, row, row.code == comparison.judged, y + LINE / 2.0 - 4.0, reach, &x);
            y += LINE;
        }
    }
    Some(drawing.finish("intervals of differences against the margins"))
}

fn interval(row: &Row) -> Option<[f64; 2]> {
    row.interval_of_verdict.or(row.interval90)
}

fn line(drawing: &mut Drawing, row: &Row, judged: bool, y: f64, reach: f64, x: &impl Fn(f64) -> f64) {
    let (Some(difference), Some(margin), Some(reference)) = (row.difference, row.margin, row.reference_code.as_deref())
    else {
        return;
    };
    let style = names::code_style(if judged { reference } else { "" });
    let label = format!("{} − {reference}", row.code);
    drawing.text(if judged { "name" } else { "name faint" }, [LEFT - 10.0, y + 4.0], Anchor::End, &label);
    let clamp = |v: f64| (v / margin).clamp(-reach, reach);
    if let Some([low, high]) = interval(row).filter(|i| i.iter().all(|v| v.is_finite())) {
        drawing.line(&format!("{} whisker", style.class), [x(clamp(low)), y], [x(clamp(high)), y]);
        for end in [low, high] {
            let at = x(clamp(end));
            if (end / margin).abs() > reach {
                let way = (end / margin).signum();
                drawing.polygon(
                    &format!("{} marker", style.class),
                    &[[at + 7.0 * way, y], [at - way, y - 5.0], [at - way, y + 5.0]],
                );
            } else {
                drawing.line(&format!("{} whisker", style.class), [at, y - 4.0], [at, y + 4.0]);
            }
        }
    }
    if (difference / margin).abs() <= reach {
        drawing.marker(style, [x(difference / margin), y], 4.5, !judged);
    }
    let (class, text) = match (judged, row.outcome) {
        (false, _) => ("name faint", "floor".to_string()),
        (true, Some(outcome)) => (outcome_class(outcome), words::outcome(outcome).to_string()),
        (true, None) => ("name", String::new()),
    };
    drawing.text(class, [WIDTH - RIGHT + 14.0, y + 4.0], Anchor::Start, &text);
}

/// Class of a text that states an outcome.
fn outcome_class(outcome: Outcome) -> &'static str {
    match outcome {
        Outcome::Agree => "name agree",
        Outcome::Disagree => "name disagree",
        Outcome::Undecided | Outcome::NotMeasured => "name undecided",
    }
}
