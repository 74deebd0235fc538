//! `makadam measure`: frames of any code, measured as those of Makadam are.

use super::arguments::{MeasureArguments, load};
use super::{Console, Failure, OUTSIDE_TOLERANCE, json};
use crate::draw::values;
use crate::import::{Assembly, Imported, Manifest, Stated, StatedColumns, Tables, check_kinds, unlike};
use crate::observables::{Measurement, Unmeasured, measured_frames, measured_in, unmeasured};
use crate::output::JSON_VERSION;
use crate::plan::Scene;
use crate::recording::Recording;
use makadam::snapshot::Snapshot;
use serde::Serialize;
use std::path::PathBuf;
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
    let Sources { grains, contacts, stated } = sources(arguments)?;
    check_kinds(&scene, &stated.kinds).map_err(Failure::Usage)?;
    let mut tables = Tables::default();
    for path in &grains {
        tables.add_grains(path, &stated.columns)?;
    }
    for path in &contacts {
        tables.add_contacts(path, &stated.contact_columns)?;
    }
    let assembly = Assembly { scene: &scene, code: &arguments.name, version: "", stated: &stated };
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

/// Files of grains and of contacts, and statements about them.
struct Sources {
    grains: Vec<PathBuf>,
    contacts: Vec<PathBuf>,
    stated: Stated,
}

/// The files and statements of the command line, and those of a manifest, which the command line completes or replaces.
fn sources(arguments: &MeasureArguments) -> Result<Sources, Failure> {
    let is_manifest = |path: &&PathBuf| path.extension().is_some_and(|extension| extension == "toml");
    let (mut grains, mut contacts) = (arguments.grains.clone(), arguments.contacts.clone());
    let mut stated = Stated::default();
    if let Some(file) = arguments.grains.iter().find(is_manifest) {
        if grains.len() > 1 || !contacts.is_empty() {
            let problem = format!("{} is a manifest, which names all files; give it alone", file.display());
            return Err(Failure::Usage(problem));
        }
        let manifest = Manifest::load(file)?;
        (grains, contacts, stated) = (manifest.grains()?, manifest.contacts()?, manifest.stated());
    }
    let joined = |own: StatedColumns, more: &[StatedColumns]| {
        StatedColumns::joined([own].into_iter().chain(more.iter().cloned()))
    };
    stated.columns = joined(stated.columns, &arguments.columns);
    stated.contact_columns = joined(stated.contact_columns, &arguments.contact_columns);
    if arguments.time_step.is_some() || arguments.interval.is_some() {
        (stated.time_step, stated.interval) = (arguments.time_step, arguments.interval);
    }
    stated.first_id = arguments.first_id.or(stated.first_id);
    stated.seed = arguments.seed.or(stated.seed);
    stated.kinds.extend(arguments.kinds.iter().cloned());
    Ok(Sources { grains, contacts, stated })
}

/// That the frames that are measured are not those of the scene: its end, or all times from `measure.from` to it.
fn other_window(scene: &Scene, measured: &[&Snapshot]) -> Option<String> {
    let (first, last) = (measured.first()?.time, measured.last()?.time);
    let (end, slack, interval) = (scene.duration, scene.measure.slack(), scene.measure.interval);
    let Some(from) = scene.measure.from else {
        let is_other = (last - end).abs() > slack;
        return is_other.then(|| format!("the last frame is measured, at {last} s, and the scene ends at {end} s"));
    };
    let gaps: Vec<f64> = measured.windows(2).map(|pair| pair[1].time - pair[0].time).collect();
    let gap = gaps.iter().copied().fold(0.0, f64::max);
    // The end may lie within an interval of the frame before it.
    let is_finer = gaps.iter().rev().skip(1).any(|gap| gap + slack < interval);
    let is_other = (last - end).abs() > slack || first > from + interval + slack || gap > interval + slack || is_finer;
    is_other.then(|| {
        let widest = if measured.len() > 1 { format!(", up to {gap:.6} s apart") } else { String::new() };
        format!(
            "the measured frames are from {first} to {last} s{widest}, and the scene is measured from {from} to {end} s, each {interval} s"
        )
    })
}

fn text(recording: &Recording, frames: usize, measurements: &[Measurement], not_measured: &[Unmeasured]) -> String {
    let all = recording.frames.len();
    let rows = measurements.iter();
    let rows = rows.map(|one| (one.observable.as_str(), one.value, one.standard_error, one.unit.as_str()));
    let grains = recording.frames[all - 1].particles.len();
    let mut text = format!("{}\n{frames} of {all} frames measured, {grains} grains", values(rows));
    for Unmeasured { observable, reason } in not_measured {
        text += &format!("\nnot measured: {observable}: {reason}");
    }
    text
}
