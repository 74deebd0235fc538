//! `makadam measure`: frames of any code, measured as those of Makadam are.

use super::arguments::{MeasureArguments, load};
use super::{Console, Failure, OUTSIDE_TOLERANCE, json};
use crate::draw::values;
use crate::import::{Imported, Manifest, StatedColumns, Tables, assemble, unlike};
use crate::observables::{Measurement, Unmeasured, measured_frames, measured_in, unmeasured};
use crate::output::JSON_VERSION;
use crate::plan::Scene;
use crate::recording::Recording;
use crate::run_frames::RunFrames;
use makadam::snapshot::Snapshot;
use serde::Serialize;
use std::path::{Path, PathBuf};
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

/// Returns the folder of a run of Makadam, which is measured alone.
fn run_folder(manifest: &Manifest) -> Result<Option<PathBuf>, Failure> {
    let mut paths = Vec::new();
    for pattern in &manifest.grains {
        paths.extend(manifest.files(pattern)?);
    }
    match paths.iter().find(|path| path.is_dir()) {
        Some(folder) if paths.len() > 1 || !manifest.contacts.is_empty() => Err(Failure::Usage(format!(
            "{} is the folder of a run, which is measured alone; give one folder and no other files",
            folder.display()
        ))),
        folder => Ok(folder.cloned()),
    }
}

/// Reads the files and prints the numbers.
pub(super) fn measure(arguments: &MeasureArguments, console: &Console) -> Result<ExitCode, Failure> {
    let (_, scene) = load(&arguments.scene, &arguments.changes)?;
    let manifest = manifest(arguments)?;
    manifest.check(&scene).map_err(Failure::Usage)?;
    let Imported { recording, mut notes } = match run_folder(&manifest)? {
        Some(folder) => {
            let seed = manifest.seed.unwrap_or(scene.seed);
            let mut recording =
                RunFrames::open(&folder)?.recording(manifest.name.as_deref().unwrap_or("frames"), seed, &scene)?;
            Imported { notes: std::mem::take(&mut recording.notes), recording }
        }
        None => assemble(&scene, &manifest, &Tables::read(&manifest)?)?,
    };
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
            code: &recording.code,
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

/// Manifest that is given, or that of the files on the command line, with the statements of the command line.
fn manifest(arguments: &MeasureArguments) -> Result<Manifest, Failure> {
    let is_manifest = |file: &&Path| file.extension().is_some_and(|extension| extension == "toml");
    let file = arguments.grains.iter().map(|pattern| Path::new(pattern.text())).find(is_manifest);
    let mut manifest = match file {
        Some(file) if arguments.grains.len() > 1 || !arguments.contacts.is_empty() => {
            let problem = format!("{} is a manifest, which names all files; give it alone", file.display());
            return Err(Failure::Usage(problem));
        }
        Some(file) => Manifest::load(file)?,
        None => {
            Manifest { grains: arguments.grains.clone(), contacts: arguments.contacts.clone(), ..Manifest::default() }
        }
    };
    let joined = |own: StatedColumns, more: &[StatedColumns]| {
        StatedColumns::joined([own].into_iter().chain(more.iter().cloned()))
    };
    manifest.name = arguments.name.clone().or(manifest.name);
    manifest.columns = joined(manifest.columns, &arguments.columns);
    manifest.contact_columns = joined(manifest.contact_columns, &arguments.contact_columns);
    manifest.contacts_complete |= arguments.contacts_complete;
    manifest.time_step = arguments.time_step.or(manifest.time_step);
    manifest.time = arguments.time.or(manifest.time);
    manifest.first_id = arguments.first_id.or(manifest.first_id);
    manifest.seed = arguments.seed.or(manifest.seed);
    manifest.kinds.extend(arguments.kinds.iter().cloned());
    Ok(manifest)
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
