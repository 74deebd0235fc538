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

/// What a line of the plot shows.
pub(super) struct Line<'a> {
    /// The row that it is of.
    pub(super) row: &'a Row,
    /// Whether it is of the judged code; the others are the floor.
    pub(super) judged: bool,
    /// The code that it is compared with.
    pub(super) reference: &'a str,
    /// The difference, in margins.
    pub(super) difference: f64,
    /// The interval that the verdict rests on, in margins; absent for want of seeds.
    pub(super) interval: Option<[f64; 2]>,
}

/// The lines of the plot, those of an observable together.
pub(super) fn lines(comparison: &Comparison) -> Vec<Line<'_>> {
    let line = |row: &'_ Row| {
        let margin = row.margin.filter(|margin| *margin > 0.0)?;
        let difference = row.difference.filter(|difference| difference.is_finite())? / margin;
        let interval = row.shown_interval();
        let interval = interval.filter(|ends| ends.iter().all(|end| end.is_finite()));
        Some((difference, interval.map(|ends| ends.map(|end| end / margin))))
    };
    let lines = comparison.rows.iter().filter_map(|row| {
        let (difference, interval) = line(row)?;
        let judged = row.code == comparison.judged;
        Some(Line { row, judged, reference: row.reference_code.as_deref()?, difference, interval })
    });
    let mut lines: Vec<Line<'_>> = lines.collect();
    let mut observables: Vec<&str> = Vec::new();
    for line in &lines {
        if !observables.contains(&line.row.observable.as_str()) {
            observables.push(&line.row.observable);
        }
    }
    lines.sort_by_key(|line| observables.iter().position(|known| *known == line.row.observable));
    lines
}

/// The plot; none if no row has a margin.
pub(super) fn figure(comparison: &Comparison) -> Option<String> {
    let lines = lines(comparison);
    let groups = || lines.chunk_by(|one, other| one.row.observable == other.row.observable);
    if lines.is_empty() {
        return None;
    }
    let values = lines.iter().flat_map(|line| line.interval.into_iter().flatten().chain([line.difference]));
    let reach = values.map(f64::abs).fold(1.6, f64::max);
    // A pair that is far outside would press all others into a line; it gets an arrow.
    let reach = (reach * 1.08).min(4.0);
    let height = 26.0 + groups().count() as f64 * HEADING + lines.len() as f64 * LINE + 34.0;
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
    for group in groups() {
        y += HEADING;
        drawing.text("heading", [0.0, y - 8.0], Anchor::Start, &names::observable(&group[0].row.observable));
        for line in group {
            draw(&mut drawing, line, y + LINE / 2.0 - 4.0, reach, &x);
            y += LINE;
        }
    }
    Some(drawing.finish("intervals of differences against the margins"))
}

fn draw(drawing: &mut Drawing, line: &Line<'_>, y: f64, reach: f64, x: &impl Fn(f64) -> f64) {
    let Line { row, judged, reference, difference, interval } = *line;
    let style = names::code_style(if judged { reference } else { "" });
    let label = format!("{} − {reference}", row.code);
    drawing.text(if judged { "name" } else { "name faint" }, [LEFT - 10.0, y + 4.0], Anchor::End, &label);
    let clamp = |v: f64| v.clamp(-reach, reach);
    if let Some([low, high]) = interval {
        drawing.line(&format!("{} whisker", style.class), [x(clamp(low)), y], [x(clamp(high)), y]);
        for end in [low, high] {
            let at = x(clamp(end));
            if end.abs() > reach {
                let way = end.signum();
                drawing.polygon(
                    &format!("{} marker", style.class),
                    &[[at + 7.0 * way, y], [at - way, y - 5.0], [at - way, y + 5.0]],
                );
            } else {
                drawing.line(&format!("{} whisker", style.class), [at, y - 4.0], [at, y + 4.0]);
            }
        }
    }
    if difference.abs() <= reach {
        drawing.marker(style, [x(difference), y], 4.5, !judged);
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
        Outcome::Undecided | Outcome::Exploratory | Outcome::NotMeasured => "name undecided",
    }
}
