//! Pictures of the final states: grains coloured by speed on one scale, seen by one camera, one picture per code.

use crate::compare::Comparison;
use crate::draw::numbers::compact;
use crate::pictures::{Scale, Style, Subject, View, camera, draw, png};
use crate::run_frames::{Quantity, RunFrame};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use rayon::prelude::*;
use serde::Serialize;

/// Width and height of a picture, pixels.
const SIZE: [usize; 2] = [560, 460];

/// The pictures of a scene.
#[derive(Serialize)]
pub(super) struct Gallery {
    pictures: Vec<Shown>,
    caption: String,
}

/// A picture of the page.
#[derive(Serialize)]
struct Shown {
    code: String,
    /// Style class of the code's mark.
    class: &'static str,
    /// Address that holds the picture itself.
    address: String,
    width: usize,
    height: usize,
}

/// Draws the final state of each code; `None` if no code has left one.
pub(super) fn gallery(comparison: &Comparison) -> Option<Gallery> {
    let states: Vec<_> = comparison.final_states.iter().filter(|state| !state.particles.is_empty()).collect();
    let frame = |time, particles| RunFrame::of_state(&comparison.scene, time, particles);
    let frames: Vec<RunFrame> = states.iter().map(|state| frame(state.time, &state.particles)).collect();
    let first = states.first()?;
    let speeds: Vec<Quantity> = frames.iter().filter_map(|frame| frame.quantity("speed")).collect();
    let all: Vec<f64> = speeds.iter().flat_map(|speed| speed.values.iter().copied()).collect();
    let scale = Scale::of("speed", &all);
    let style = Style { size: SIZE, view: View::Natural, cut: None, walls: true };
    let camera = camera(&Subject::of(frames.iter(), false), &frames[0], &style);
    let shown = |((state, frame), speed): ((_, &RunFrame), &Quantity)| {
        let state: &&crate::compare::FinalState = state;
        let picture = draw(frame, speed, &scale, &camera, &style, "");
        Shown {
            code: state.code.clone(),
            class: crate::draw::names::code_style(&state.code).class,
            address: format!("data:image/png;base64,{}", BASE64_STANDARD.encode(png(&picture))),
            width: picture.width,
            height: picture.height,
        }
    };
    Some(Gallery {
        pictures: states.par_iter().zip(&frames).zip(&speeds).map(shown).collect(),
        caption: format!(
            "Final states at {} s, seed {}, coloured by speed on one scale. Single grains need not coincide: the smallest differences grow from \
             contact to contact, and only averages are compared.",
            compact(first.time),
            first.seed
        ),
    })
}
