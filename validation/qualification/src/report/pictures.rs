//! Pictures of the final states: grains coloured by speed on one scale, seen by one camera, one picture per code.

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use makadam_compare::compare::{Comparison, FinalState};
use makadam_frames::run_frames::{Quantity, RunFrame};
use makadam_view::draw::names::code_style;
use makadam_view::draw::numbers::compact;
use makadam_view::pictures::{Scale, Style, Subject, View, camera, draw, png};
use minijinja::{Value, context};
use rayon::prelude::*;

/// Width and height of a picture, pixels.
const SIZE: [usize; 2] = [560, 460];

/// Draws the final state of each code; `None` if no code has left one.
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
        compact(first.time),
        first.seed
    );
    let pictures: Vec<Value> = states.par_iter().zip(&frames).zip(&speeds).map(shown).collect();
    Some(context! { pictures, caption })
}
