//! Pictures of the final states: grains shaded by speed on one scale for all codes of a scene.

use super::outlines;
use crate::compare::{Comparison, FinalState};
use crate::draw::numbers::{compact, round_ticks};
use crate::draw::svg::{Anchor, Drawing};
use crate::draw::view::{self, Frame, View};
use nalgebra::Vector3;
use std::fmt::Write as _;

/// Steps of the colour scale.
const BINS: usize = 20;
/// Place of the colour of grains in a scene at rest, behind the scale.
const AT_REST: usize = BINS;
/// Steps of the darkening with depth.
const DEPTHS: usize = 4;
/// Width of a picture in pixels; the height follows from the frame.
const WIDTH: f64 = 340.0;
const TALLEST: f64 = 420.0;

/// One picture.
pub(super) struct Picture {
    /// Code whose grains it shows.
    pub(super) code: String,
    /// Its anchor on the page.
    pub(super) anchor: String,
    /// The drawing.
    pub(super) svg: String,
}

/// The pictures of one view, one a code.
pub(super) struct Row {
    /// From where they are seen.
    pub(super) view: &'static str,
    /// The pictures.
    pub(super) pictures: Vec<Picture>,
}

/// All pictures of a scene with their common legend and caption.
pub(super) struct Gallery {
    /// One row a view.
    pub(super) rows: Vec<Row>,
    /// The colour scale; empty where every grain is at rest.
    pub(super) legend: String,
    /// What to see.
    pub(super) caption: String,
}

/// The states that are drawn.
pub(super) fn states(comparison: &Comparison) -> Vec<&FinalState> {
    comparison.final_states.iter().filter(|state| !state.particles.is_empty()).collect()
}

/// The pictures of the scene whose section has an anchor; none if no code left a final state.
pub(super) fn gallery(comparison: &Comparison, section: &str) -> Option<Gallery> {
    let states = states(comparison);
    let first = states.first()?;
    let top = top_of_scale(comparison, &states);
    let mut outside = 0;
    let rows: Vec<Row> = view::views(&comparison.scene)
        .into_iter()
        .filter_map(|view| {
            let grains = states.iter().flat_map(|s| &s.particles);
            let frame = Frame::of(&view, &comparison.scene, grains)?;
            let pictures = states
                .iter()
                .enumerate()
                .map(|(place, state)| {
                    let (drawing, strays) = picture(comparison, state, &view, &frame, top);
                    outside += strays;
                    let anchor = format!("{section}-{}-{}", view.name.replace(' ', "-"), place + 1);
                    let name = format!("grains of {} at the end of the run, seen {}", state.code, view.name);
                    Picture { code: state.code.clone(), svg: drawing.finish_at(&anchor, &name), anchor }
                })
                .collect();
            Some(Row { view: view.name, pictures })
        })
        .collect();
    let views: Vec<&str> = rows.iter().map(|r| r.view).collect();
    let shade = match top {
        Some(top) => format!(
            "Grains are shaded by their speed on one scale; faster ones than {} m/s have its last colour.",
            compact(top)
        ),
        None => "All grains are at rest (slower than 1% of √(g d)), so the shade shows depth only.".into(),
    };
    let mut caption = format!(
        "Final state at {} s, seed {}, seen {}. {shade} Farther grains are darker. Single grains need not coincide: \
         the smallest differences grow from contact to contact, and only averages are compared.",
        compact(first.time),
        first.seed,
        super::qualification::join(&views),
    );
    if outside > 0 {
        let _ = write!(caption, " Stray grains outside the frames: {outside}.");
    }
    Some(Gallery { rows, legend: top.map(legend).unwrap_or_default(), caption })
}

/// Upper end of the colour scale: a round number that 99% of all grains stay below; none if all are at rest.
fn top_of_scale(comparison: &Comparison, states: &[&FinalState]) -> Option<f64> {
    let mut speeds: Vec<f64> = states
        .iter()
        .flat_map(|s| &s.particles)
        .map(|p| Vector3::from(p.velocity).norm())
        .filter(|v| v.is_finite())
        .collect();
    speeds.sort_by(f64::total_cmp);
    let high = *speeds.get(speeds.len().saturating_sub(1) * 99 / 100)?;
    let radius = states[0].particles.iter().map(|p| p.radius).fold(0.0, f64::max);
    let gravity = Vector3::from(comparison.scene.gravity).norm();
    if high <= 0.01 * (gravity * 2.0 * radius).sqrt() {
        return None;
    }
    let (ticks, _) = round_ticks(0.0, 2.0 * high, 20);
    ticks.into_iter().find(|&t| t >= high)
}

fn picture(
    comparison: &Comparison,
    state: &FinalState,
    view: &View,
    frame: &Frame,
    top: Option<f64>,
) -> (Drawing, usize) {
    let scale = (WIDTH / frame.width()).min(TALLEST / frame.height());
    let height = frame.height() * scale;
    // Below the picture, where no wall can cross it.
    let strip = 24.0;
    let left = (WIDTH - frame.width() * scale) / 2.0;
    let place = |p: [f64; 2]| [left + (p[0] - frame.min[0]) * scale, height - (p[1] - frame.min[1]) * scale];
    let (spots, outside) = view::visible(view, frame, &state.particles);
    let mut drawing = Drawing::new(WIDTH, height + strip);
    drawing.begin_clip([0.0, 0.0], WIDTH, height);
    for spot in &spots {
        let bin = top.map_or(AT_REST, |top| ((spot.speed / top * BINS as f64) as usize).min(BINS - 1));
        let depth = ((spot.depth * DEPTHS as f64) as usize).min(DEPTHS - 1);
        drawing.circle(&class(bin, depth), place(spot.centre), spot.radius * scale);
    }
    outlines::walls(&mut drawing, &comparison.scene, view, state.time, scale, &place);
    drawing.end_clip();
    bar_of_scale(&mut drawing, frame.width(), scale, height + strip);
    (drawing, outside)
}

/// A bar of known length below the picture.
fn bar_of_scale(drawing: &mut Drawing, width: f64, scale: f64, height: f64) {
    let (ticks, _) = round_ticks(0.0, width, 6);
    let Some(&length) = ticks.get(1) else { return };
    let (right, y) = (WIDTH - 6.0, height - 8.0);
    drawing.line("scalebar", [right - length * scale, y], [right, y]);
    drawing.text(
        "tick",
        [right - length * scale - 8.0, y + 4.0],
        Anchor::End,
        &format!("{} mm", compact(1e3 * length)),
    );
}

fn class(bin: usize, depth: usize) -> String {
    format!("g{}{}", (b'a' + bin as u8) as char, depth)
}

/// The colour scale with its ticks.
fn legend(top: f64) -> String {
    let (width, height) = (340.0, 40.0);
    let (left, right) = (10.0, 280.0);
    let mut drawing = Drawing::new(width, height);
    let step = (right - left) / BINS as f64;
    for bin in 0..BINS {
        let x = left + step * bin as f64;
        // A little overlap hides the seams of antialiasing.
        drawing.rectangle(&format!("s{}", (b'a' + bin as u8) as char), [x, 4.0], [x + step + 0.5, 16.0]);
    }
    let (ticks, digits) = round_ticks(0.0, top, 4);
    for tick in ticks {
        let x = left + (right - left) * tick / top;
        drawing.line("scaletick", [x, 16.0], [x, 20.0]);
        drawing.text("tick", [x, 32.0], Anchor::Middle, &format!("{tick:.digits$}"));
    }
    drawing.text("tick", [right + 8.0, 14.0], Anchor::Start, "m/s");
    drawing.finish("colour scale of the speed")
}

/// Gradients that every picture of the page refers to, one a colour and depth.
pub(super) fn gradients() -> String {
    let mut body = String::new();
    for bin in 0..=AT_REST {
        for depth in 0..DEPTHS {
            let base = shaded(bin, depth);
            let light = base.map(|c| c + (255.0 - c) * 0.45);
            let _ = write!(
                body,
                r#"<radialGradient id="{}" cx=".5" cy=".5" r=".5" fx=".36" fy=".32"><stop offset="0" stop-color="{}"/><stop offset=".6" stop-color="{}"/><stop offset="1" stop-color="{}"/></radialGradient>"#,
                class(bin, depth),
                hexadecimal(light),
                hexadecimal(base),
                hexadecimal(rim(base)),
            );
        }
    }
    format!(r#"<svg class="definitions" aria-hidden="true"><defs>{body}</defs></svg>"#)
}

/// Style rules of the grains. On paper they are flat: a gradient for every grain would nearly double the PDF.
pub(super) fn rules() -> String {
    let (mut rules, mut paper) = (String::new(), String::new());
    for bin in 0..=AT_REST {
        for depth in 0..DEPTHS {
            let class = class(bin, depth);
            let _ = writeln!(rules, ".{class}{{fill:url(#{class})}}");
            let base = shaded(bin, depth);
            let (fill, rim) = (hexadecimal(base), hexadecimal(rim(base)));
            let _ = writeln!(paper, ".{class}{{fill:{fill};stroke:{rim};stroke-width:.8px}}");
        }
        let _ = writeln!(rules, ".s{}{{fill:{}}}", (b'a' + bin as u8) as char, hexadecimal(colour(bin)));
    }
    format!("{rules}@media print {{\n{paper}}}\n")
}

/// Colour of a grain by its speed and its distance. Strong shade would be taken for another speed; at rest there is none to mistake it for.
fn shaded(bin: usize, depth: usize) -> [f64; 3] {
    let dark = 1.0 - if bin == AT_REST { 0.2 } else { 0.07 } * depth as f64;
    colour(bin).map(|c| c * dark)
}

/// Colour of a grain's rim.
fn rim(base: [f64; 3]) -> [f64; 3] {
    base.map(|c| c * 0.55)
}

/// The scale `viridis` from its second tenth on: its order is seen in grey and by colour-blind readers.
fn colour(bin: usize) -> [f64; 3] {
    if bin == AT_REST {
        return [214.0, 190.0, 148.0];
    }
    const STOPS: [[f64; 3]; 7] = [
        [70.0, 50.0, 126.0],
        [57.0, 86.0, 140.0],
        [39.0, 119.0, 142.0],
        [31.0, 150.0, 139.0],
        [74.0, 193.0, 109.0],
        [160.0, 218.0, 57.0],
        [253.0, 231.0, 37.0],
    ];
    let at = bin as f64 / (BINS - 1) as f64 * (STOPS.len() - 1) as f64;
    let below = (at as usize).min(STOPS.len() - 2);
    let share = at - below as f64;
    std::array::from_fn(|k| STOPS[below][k] * (1.0 - share) + STOPS[below + 1][k] * share)
}

fn hexadecimal(colour: [f64; 3]) -> String {
    let [r, g, b] = colour.map(|c| c.round().clamp(0.0, 255.0) as u8);
    format!("#{r:02x}{g:02x}{b:02x}")
}
