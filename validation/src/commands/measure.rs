//! `makadam measure`: frames of any code, measured as those of Makadam are.

use super::arguments::{MeasureArguments, load};
use super::{Console, Failure, OUTSIDE_TOLERANCE, json};
use crate::draw::numbers::significant;
use crate::import::{Assembly, Imported, Tables, unlike};
use crate::observables::{Measurement, Unmeasured, measured_frames, measured_in, unmeasured};
use crate::output::JSON_VERSION;
use crate::plan::Scene;
use crate::recording::Recording;
use crate::study::{Table, cells};
use makadam::snapshot::Snapshot;
use serde::Serialize;
use std::process::ExitCode;

/// What `makadam measure --json` prints; its documentation is `validation/docs/json.md`.
#[derive(Serialize)]
struct MeasureDocument<'a> {
    version: u32,
    command: &'static str,
    scene: &'a str,
    code: &'a str,
    frames: usize,
    measured_frames: usize,
    measurements: &'a [Measurement],
    not_measured: &'a [Unmeasured],
    notes: &'a [String],
}

/// Reads the files and prints the numbers.
pub(super) fn measure(arguments: &MeasureArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (_, scene) = load(&arguments.scene, &arguments.changes)?;
    let mut tables = Tables::default();
    for path in &arguments.grains {
        tables.add_grains(path, &arguments.columns)?;
    }
    for path in &arguments.contacts {
        tables.add_contacts(path, &arguments.contact_columns)?;
    }
    let assembly = Assembly {
        scene: &scene,
        code: &arguments.name,
        version: "",
        seed: arguments.seed.unwrap_or(scene.seed),
        time_step: arguments.time_step,
        interval: arguments.interval,
    };
    let Imported { recording, mut notes } = assembly.assemble(&tables)?;
    let measured = measured_frames(&scene, &recording);
    notes.extend(unlike(&scene, measured.iter().copied()));
    notes.extend(other_window(&scene, &measured));
    let frames = measured.len();
    if frames == 0 {
        let (last, from) = (recording.simulated_seconds, scene.measure.from.unwrap_or(0.0));
        return Err(Failure::Usage(format!(
            "no frame is measured: the last one is at {last} s, and {} measures from {from} s on; give --set measure.from=TIME",
            scene.name
        )));
    }
    let measured = measured_in(&scene, &recording);
    let not_measured = unmeasured(&scene, &recording.lacks, &measured);
    let measurements = measured.measurements;
    let text = match arguments.json {
        true => json(&MeasureDocument {
            version: JSON_VERSION,
            command: "measure",
            scene: &scene.name,
            code: &arguments.name,
            frames: recording.frames.len(),
            measured_frames: frames,
            measurements: &measurements,
            not_measured: &not_measured,
            notes: &notes,
        }),
        false => text(&recording, frames, &measurements, &not_measured),
    };
    notes.iter().for_each(|note| console.note(note));
    console.result(&text)?;
    let is_compared = |one: &Unmeasured| scene.compare.iter().any(|expected| expected.observable == one.observable);
    match not_measured.iter().any(is_compared) {
        true => Ok(ExitCode::from(OUTSIDE_TOLERANCE)),
        false => Ok(ExitCode::SUCCESS),
    }
}

/// That the frames that are measured are not those of the scene: its end, or all times from `measure.from` to it.
fn other_window(scene: &Scene, measured: &[&Snapshot]) -> Option<String> {
    let (first, last) = (measured.first()?.time, measured.last()?.time);
    let (end, slack, interval) = (scene.duration, scene.measure.slack(), scene.measure.interval);
    let Some(from) = scene.measure.from else {
        let is_other = (last - end).abs() > slack;
        return is_other.then(|| format!("the last frame is measured, at {last} s, and the scene ends at {end} s"));
    };
    let gap = measured.windows(2).map(|pair| pair[1].time - pair[0].time).fold(0.0, f64::max);
    let is_other = (last - end).abs() > slack || first > from + interval + slack || gap > interval + slack;
    is_other.then(|| {
        let widest = if measured.len() > 1 { format!(", up to {gap} s apart") } else { String::new() };
        format!(
            "the measured frames are from {first} to {last} s{widest}, and the scene is measured from {from} to {end} s, each {interval} s"
        )
    })
}

fn text(recording: &Recording, frames: usize, measurements: &[Measurement], not_measured: &[Unmeasured]) -> String {
    let table = Table::new(&["observable"], &["value", "standard error"]).with_words("unit").of(measurements, |one| {
        let error = one.standard_error.map(|error| format!("{error:.2e}"));
        cells![one.observable.as_str(), significant(one.value), error, one.unit.as_str()]
    });
    let all = recording.frames.len();
    let mut text = format!(
        "{}\n{frames} of {all} frames measured, {} grains",
        table.text(),
        recording.frames[all - 1].particles.len()
    );
    for Unmeasured { observable, reason } in not_measured {
        text += &format!("\nnot measured: {observable}: {reason}");
    }
    text
}
