//! `makadam measure`: measurement of the output files of any code, by the definitions used for Makadam.

use super::arguments::{load, positive};
use super::{Console, Failure, within_tolerance};
use clap::Args;
use makadam::snapshot::Snapshot;
use makadam_compare::scenes::{Change, with_changes};
use makadam_frames::import::{FilePattern, Manifest, StatedColumns, Tables, assemble, unlike};
use makadam_frames::output::JSON_VERSION;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::recording::Recording;
use makadam_frames::run_frames::RunFrames;
use makadam_measure::observables::{Measurement, Unmeasured, measured_frames, measured_in, unmeasured};
use makadam_view::draw::values;
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

#[derive(Debug, Args)]
pub(super) struct MeasureArguments {
    /// Files of grains: dumps of LIGGGHTS or LAMMPS, VTK or text of YADE, CSV, VTKHDF, plain or compressed by gzip; {step} or {time} in a name
    /// matches a number. Alternatively, the folder of a run of Makadam, or a manifest (.toml) with the names of a run's files and statements
    /// missing from them.
    #[arg(required = true, value_name = "FILES")]
    pub grains: Vec<FilePattern>,
    /// Simulated scene: a file, a name (see `makadam print scenes`), or - for standard input; if absent, that of the folder of a run.
    #[arg(long)]
    pub scene: Option<String>,
    /// Replace a value of the scene, such as measure.from=0.5; can be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<Change>,
    /// Files of contacts, of grains and of walls.
    #[arg(long, num_args = 1.., value_name = "FILES")]
    pub contacts: Vec<FilePattern>,
    /// Names of the columns of grains, replacing the names in the files, such as id,_,x,y,z,radius; _ for an unwanted column.
    #[arg(long, value_name = "NAMES")]
    pub columns: Vec<StatedColumns>,
    /// Names of the columns of contacts, such as first,second,_,fx,fy,fz,px,py,pz. A name and a colon before them select the columns that files
    /// number under this name: c_pairs:first,second,_,fx,fy,fz for c_pairs[1] to c_pairs[6]. Can be given several times.
    #[arg(long, value_name = "NAMES")]
    pub contact_columns: Vec<StatedColumns>,
    /// The files of contacts list all contacts of their frames.
    #[arg(long)]
    pub contacts_complete: bool,
    /// Time (s) between frames with consecutive numbers: the time step, if frames are numbered by steps.
    #[arg(long, value_parser = positive)]
    pub time_step: Option<f64>,
    /// Time (s) of the only frame.
    #[arg(long)]
    pub time: Option<f64>,
    /// Number in the files of the scene's first grain, for files with the scene's numbering: listed grains first, then each
    /// population.
    #[arg(long, value_name = "NUMBER", allow_negative_numbers = true)]
    pub first_id: Option<i64>,
    /// Seed of the scene's grain positions; with --first-id, determines radii missing from the files.
    #[arg(long)]
    pub seed: Option<u64>,
    /// Material of the scene, or population (population.0), for each value of a column type or material, such as
    /// 1=glass,2=steel.
    #[arg(long, value_delimiter = ',', value_name = "VALUE=NAME", value_parser = kind)]
    pub kinds: Vec<(String, String)>,
    /// Name of the code that wrote the frames; "frames" if absent.
    #[arg(long)]
    pub name: Option<String>,
    /// Print the measurements as JSON.
    #[arg(long)]
    pub json: bool,
}

/// Parses a value of a column, and the name of its material or population.
fn kind(text: &str) -> Result<(String, String), String> {
    match text.split_once('=').map(|(value, name)| (value.trim(), name.trim())) {
        Some((value, name)) if !value.is_empty() && !name.is_empty() => Ok((value.into(), name.into())),
        _ => Err("give VALUE=NAME, such as 1=glass".into()),
    }
}

/// Document of `makadam measure --json`; `validation/docs/json.md` describes it.
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

/// Returns the folder of a run of Makadam, which must be the only input.
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

pub(super) fn measure(arguments: &MeasureArguments, console: &Console) -> Result<ExitCode, Failure> {
    let manifest = manifest(arguments)?;
    let run = run_folder(&manifest)?.map(|folder| RunFrames::open(&folder)).transpose()?;
    let scene = match (&arguments.scene, &run) {
        (Some(name), _) => load(name, &arguments.changes)?.1,
        (None, Some(run)) => with_changes(run.own_scene(), run.folder(), &arguments.changes)?,
        (None, None) => return Err(Failure::Usage("files have no scene; give it by --scene".into())),
    };
    manifest.check(&scene).map_err(Failure::Usage)?;
    let mut recording = match run {
        Some(run) => {
            let seed = manifest.seed.or(run.seed()).unwrap_or(scene.seed);
            run.recording(manifest.name.as_deref().unwrap_or("frames"), seed, &scene)?
        }
        None => assemble(&scene, &manifest, &Tables::read(&manifest)?)?,
    };
    let mut notes = std::mem::take(&mut recording.notes);
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
    notes.iter().for_each(|note| console.note(note));
    let document = MeasureDocument {
        version: JSON_VERSION,
        command: "measure",
        scene: &scene.name,
        code: &recording.code,
        frames: recording.frames.len(),
        measured_frames: frames,
        measurements: &measurements,
        not_measured: &not_measured,
        notes: &notes,
    };
    console.document(&document, arguments.json, || text(&recording, frames, &measurements, &not_measured))?;
    let is_compared = |one: &Unmeasured| scene.compare.iter().any(|expected| expected.observable == one.observable);
    Ok(within_tolerance(!not_measured.iter().any(is_compared)))
}

/// Returns the given manifest, or the manifest of the files on the command line, with the statements of the command line.
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

/// Returns a note if the measured frames are not those of the scene: its end, or all times from `measure.from` to its end.
fn other_window(scene: &MeasuredScene, measured: &[&Snapshot]) -> Option<String> {
    if !scene.stage.is_empty() {
        // Conditions end stages at times that the scene does not state.
        return None;
    }
    // Rounding would show in the words.
    let [first, last] = [measured.first()?, measured.last()?].map(|frame| (frame.time * 1e9).round() / 1e9);
    let (end, slack, interval) = (scene.duration, scene.measure.slack(), scene.measure.interval);
    let Some(from) = scene.measure.from else {
        let is_other = (last - end).abs() > slack;
        return is_other.then(|| format!("the last frame is measured, at {last} s, and the scene ends at {end} s"));
    };
    let gaps: Vec<f64> = measured.windows(2).map(|pair| pair[1].time - pair[0].time).collect();
    let gap = gaps.iter().copied().fold(0.0, f64::max);
    // The end may lie within an interval of the previous frame.
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
