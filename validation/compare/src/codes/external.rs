//! Any code under test: a command that receives the folder of the scene and writes frames as files.
//!
//! ```text
//! code.toml ─> folder with scene.json, grains.csv, frames.csv, wall0.stl ... ─> the command ─> files of frames ─> import ─> Recording
//! ```

use super::input::stl;
use super::process::{Run, check_pattern, io, locate};
use super::{Code, CodeError, CodeName, Job, UNKNOWN_VERSION, starting_grains, write_files};
use makadam::scene::{Grain, Reaction};
use makadam::snapshot::Particle;
use makadam_frames::import::{FilePattern, ImportError, Manifest, Tables, assemble, unlike};
use makadam_frames::output::mesh::{FINE, wall_mesh};
use makadam_frames::output::{RunFiles, cells::csv_below, shown};
use makadam_frames::plan::{Measure, MeasuredScene};
use makadam_frames::recording::{Recording, SAME_SIZE, frame_belongs_to, outside_domain};
use makadam_frames::run_frames::RunFrames;
use makadam_measure::observables::measured_frames;
use std::collections::BTreeMap;
use std::ffi::{OsStr, OsString};
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Code that a file describes.
pub struct External {
    name: &'static str,
    version: String,
    /// Command, files and statements.
    description: Manifest,
    /// Folder of the file, from the root.
    here: PathBuf,
    /// Folders of frames that exist, by seed; absent where the code is run.
    folders: Option<BTreeMap<u64, PathBuf>>,
}

/// Error of a description.
#[derive(Debug, thiserror::Error)]
#[error("{}: {problem}", file.display())]
pub struct DescriptionError {
    /// File.
    pub file: PathBuf,
    /// Fault and remedy.
    pub problem: String,
}

impl External {
    /// Reads the description of a code.
    ///
    /// # Errors
    /// [`DescriptionError`].
    pub fn load(file: &Path) -> Result<External, DescriptionError> {
        let fault = |problem: String| DescriptionError { file: file.to_path_buf(), problem };
        let (description, here) = read_description(file)?;
        if description.command.is_empty() {
            return Err(fault(
                "command is missing: give a program and its arguments, or --frames for frames that exist".into(),
            ));
        }
        let program = program_of(&description, &here);
        if locate(OsStr::new(&program)).is_none() {
            return Err(fault(format!(
                "there is no program '{program}'; give a name on PATH, or a path, where {{here}} is the folder of this file"
            )));
        }
        Ok(External::new(description, here, None))
    }

    /// Reads frames in folders that `patterns` name, one folder per seed, whose number ends the folder's name. `file` describes the code; its
    /// command is not run. Without `file`, a folder is that of a run of Makadam, or each of its files holds grains.
    ///
    /// # Errors
    /// [`DescriptionError`].
    pub fn of_frames(file: Option<&Path>, patterns: &[String]) -> Result<External, DescriptionError> {
        let mut folders = BTreeMap::new();
        for pattern in patterns {
            let fault = |problem: String| DescriptionError { file: pattern.into(), problem };
            let found = glob::glob(pattern).map_err(|error| fault(format!("is no pattern of folders: {error}")))?;
            let found: Vec<PathBuf> = found.flatten().filter(|path| path.is_dir()).collect();
            if found.is_empty() {
                return Err(fault("there is no such folder; give one folder for each seed, such as 'seed*/'".into()));
            }
            for folder in found {
                let fault = |problem: String| DescriptionError { file: folder.clone(), problem };
                let seed = seed_of(&folder).ok_or_else(|| {
                    fault("the name of a folder ends with the number of its seed, such as seed1".into())
                })?;
                let other = folders.insert(seed, folder.clone()).filter(|other| *other != folder);
                if let Some(other) = other {
                    return Err(fault(format!(
                        "{} is of seed {seed} too; give one folder for each seed",
                        other.display()
                    )));
                }
            }
        }
        let (description, here) = match file {
            Some(file) => read_description(file)?,
            None => (Manifest { grains: vec!["*".into()], ..Manifest::default() }, PathBuf::new()),
        };
        Ok(External::new(description, here, Some(folders)))
    }

    fn new(description: Manifest, here: PathBuf, folders: Option<BTreeMap<u64, PathBuf>>) -> External {
        // Names of codes live as long as the program; one program tests one code.
        let name = description.name.as_deref().unwrap_or("frames");
        let name = Box::leak(shown(name, false).into_owned().into_boxed_str());
        let version = description.version.clone().unwrap_or_else(|| UNKNOWN_VERSION.into());
        External { name, version, description, here, folders }
    }

    /// Returns an argument of the command with the braces filled in.
    fn word(&self, word: &str, job: &Job<'_>) -> OsString {
        let text = |path: &Path| path.display().to_string();
        word.replace("{seed}", &job.seed.to_string())
            .replace("{folder}", &text(job.work_folder))
            .replace("{here}", &text(&self.here))
            .into()
    }

    /// Returns the folder of the frames of a run.
    fn place<'p>(&'p self, job: &'p Job<'_>) -> &'p Path {
        self.folders.as_ref().and_then(|folders| folders.get(&job.seed)).map_or(job.work_folder, PathBuf::as_path)
    }

    /// Returns the times at which a frame is due, as text that follows "at each time".
    fn times(&self) -> &'static str {
        match self.folders {
            None => "of frames.csv",
            Some(_) => "that the scene measures (measure.from and interval, and its end)",
        }
    }

    fn output(&self, file: &Path, line: usize, problem: String) -> CodeError {
        CodeError::Output { code: self.name, file: file.to_path_buf(), line, problem }
    }

    fn refused(&self, ImportError { file, line, problem }: ImportError) -> CodeError {
        CodeError::Output { code: self.name, file, line, problem }
    }

    /// Empties or creates the folder of a run, and writes the input. The description must name none of the input files as frames.
    fn prepare(&self, job: &Job<'_>, input: Vec<(String, Vec<u8>)>) -> Result<(), CodeError> {
        let folder = job.work_folder;
        match std::fs::remove_dir_all(folder) {
            Err(source) if source.kind() != ErrorKind::NotFound => return Err(io(folder, source)),
            _ => write_files(folder, input)?,
        }
        let manifest = Manifest { folder: folder.into(), ..self.description.clone() };
        let patterns = manifest.grains.iter().chain(&manifest.contacts);
        let mut found = patterns.flat_map(|pattern| manifest.files(pattern).unwrap_or_default());
        match found.find(|file| file.exists()) {
            None => Ok(()),
            Some(file) => {
                let name = file.strip_prefix(folder).unwrap_or(&file).display();
                let remedy = "let it leave its frames under another name, and name those alone";
                Err(self.output(folder, 1, format!("{name} is what the run was given; {remedy}")))
            }
        }
    }

    /// Reads the frames of a run that the description names; `grains` are the initial grains, where known.
    fn recording(&self, job: &Job<'_>, grains: Option<&[Grain]>, wall_seconds: f64) -> Result<Recording, CodeError> {
        let manifest = Manifest {
            name: Some(self.name.into()),
            version: Some(self.version.clone()),
            // A code that is run must number grains as grains.csv does.
            first_id: self.description.first_id.or(self.folders.is_none().then_some(0)),
            seed: Some(job.seed),
            folder: self.place(job).into(),
            ..self.description.clone()
        };
        let tables = Tables::read(&manifest).map_err(|error| self.refused(error))?;
        manifest.check(job.scene).map_err(|problem| self.output(self.place(job), 1, problem))?;
        let mut recording = assemble(job.scene, &manifest, &tables).map_err(|error| self.refused(error))?;
        self.check_times(job, &recording)?;
        self.check_grains(job, grains, &recording)?;
        let unlike = unlike(job.scene, measured_frames(job.scene, &recording).into_iter());
        recording.notes.extend(unlike);
        Ok(Recording {
            rayleigh_fraction: None,
            stiffness_factor: job.stiffness_factor,
            wall_seconds,
            simulated_seconds: job.scene.duration,
            ..recording
        })
    }

    /// Refuses frames without all grains of the scene. Frames without any grain are not measured.
    fn check_grains(&self, job: &Job<'_>, grains: Option<&[Grain]>, recording: &Recording) -> Result<(), CodeError> {
        let refused = |problem: String| Err(self.output(self.place(job), 1, problem));
        let (wanted, source) = match grains {
            Some(grains) => (grains.len(), "grains.csv"),
            None => (job.scene.grain_count(), "the scene"),
        };
        for frame in recording.frames.iter().filter(|frame| !frame.particles.is_empty()) {
            let (found, time) = (frame.particles.len(), frame.time);
            if found != wanted {
                return refused(format!(
                    "the frame at {time} s has {found} grains, and {source} has {wanted}; leave all of them in each frame"
                ));
            }
            // Grains are ranked by their numbers over all frames.
            if (0..).zip(&frame.particles).any(|(place, particle)| particle.id != place) {
                return refused(format!(
                    "grains have other numbers in the frame at {time} s than in others; number them alike in all frames"
                ));
            }
            frame_belongs_to(frame, job.scene).or_else(refused)?;
            let is_other = |(particle, grain): &(&Particle, &Grain)| {
                (particle.radius - grain.radius).abs() > SAME_SIZE * grain.radius
            };
            if let Some((particle, grain)) = frame.particles.iter().zip(grains.unwrap_or_default()).find(is_other) {
                return refused(format!(
                    "grain {} has a radius of {} m in the frame at {time} s, and of {} m in grains.csv; number grains as there",
                    particle.id, particle.radius, grain.radius
                ));
            }
            // A scene may let grains escape: escaped grains of Makadam are measured, too.
            let stops = job.scene.watch.on_escape == Reaction::Stop;
            if let Some(problem) = outside_domain(frame, job.scene).filter(|_| stops) {
                return refused(problem);
            }
        }
        Ok(())
    }

    /// Refuses a run whose measured frames differ from those of frames.csv: a mean over other frames is another number.
    fn check_times(&self, job: &Job<'_>, recording: &Recording) -> Result<(), CodeError> {
        let refused = |problem: String| Err(self.output(self.place(job), 1, problem));
        let (slack, asked, times) = (job.scene.measure.slack(), asked(job.scene), self.times());
        let measured: Vec<f64> = measured_frames(job.scene, recording).iter().map(|frame| frame.time).collect();
        let is_among = |time: &f64, others: &[f64]| others.iter().any(|other| (time - other).abs() <= slack);
        if let Some(other) = measured.iter().find(|time| !is_among(time, &asked)) {
            return refused(format!(
                "a frame at {other} s would be measured, and is not at a time {times}; leave those that are"
            ));
        }
        if let Some(time) = asked.iter().find(|time| !is_among(time, &measured)) {
            return refused(format!("no frame with grains at {time} s; leave one at each time {times}"));
        }
        match (measured.len(), asked.len()) {
            (found, wanted) if found == wanted => Ok(()),
            (found, wanted) => {
                refused(format!("{found} frames where {wanted} are measured; leave one at each time {times}"))
            }
        }
    }
}

/// Times of the measured frames, s: whole intervals from `measure.from` on, and the end of the run.
fn asked(scene: &MeasuredScene) -> Vec<f64> {
    let Measure { interval, from, .. } = scene.measure;
    let slack = scene.measure.slack();
    // A frame just before measure.from is measured too.
    let first = from.map(|from| ((from - slack) / interval).ceil().max(0.0));
    let times = (0..).map(|place| (first.unwrap_or(0.0) + f64::from(place)) * interval);
    let before_end = times.take_while(|time| first.is_some() && *time < scene.duration - slack);
    before_end.chain([scene.duration]).collect()
}

impl Code for External {
    fn name(&self) -> &'static str {
        self.name
    }

    fn version(&self) -> Option<String> {
        Some(self.version.clone())
    }

    fn seeds(&self) -> Option<Vec<u64>> {
        self.folders.as_ref().map(|folders| folders.keys().copied().collect())
    }

    fn simulate(&self, job: &Job<'_>) -> Result<Recording, CodeError> {
        if self.folders.is_some() {
            let folder = self.place(job);
            if folder.join(RunFiles::FRAMES).is_file() {
                let refused = |problem: String| self.output(folder, 1, problem);
                let run = RunFrames::open(folder).map_err(|error| refused(error.to_string()))?;
                if let Some(seed) = run.seed().filter(|seed| *seed != job.seed) {
                    return Err(refused(format!(
                        "run.json states seed {seed}, and the folder's name seed {}; rename the folder",
                        job.seed
                    )));
                }
                let recording = run.recording(self.name, job.seed, job.scene);
                return recording.map_err(|error| refused(error.to_string()));
            }
            return self.recording(job, None, 0.0);
        }
        let grains = starting_grains(job)?;
        self.prepare(job, input(job, &grains))?;
        let program = program_of(&self.description, &self.here);
        let arguments: Vec<OsString> = self.description.command[1..].iter().map(|word| self.word(word, job)).collect();
        let clock = Instant::now();
        Run {
            code: self.name,
            program: OsStr::new(&program),
            arguments: &arguments,
            folder: job.work_folder,
            log: job.work_folder.join("code.log"),
            own_logs: &[],
            limit: job.time_limit,
            watch: &|| {},
        }
        .execute()?;
        let wall_seconds = clock.elapsed().as_secs_f64();
        let recording = self.recording(job, Some(&grains), wall_seconds)?;
        (job.progress)(1.0);
        Ok(recording)
    }
}

/// Returns the program, with the folder of the description filled in.
fn program_of(description: &Manifest, here: &Path) -> String {
    description.command[0].replace("{here}", &here.display().to_string())
}

/// Reads and checks the file of a description; also returns its folder from the root.
///
/// # Errors
/// [`DescriptionError`].
fn read_description(file: &Path) -> Result<(Manifest, PathBuf), DescriptionError> {
    let fault = |problem: String| DescriptionError { file: file.to_path_buf(), problem };
    let mut description =
        Manifest::load(file).map_err(|ImportError { line, problem, .. }| fault(format!("line {line}: {problem}")))?;
    let name = description.name.as_deref().unwrap_or_default().trim().to_string();
    if name.is_empty() || CodeName::of(&name).is_ok() {
        return Err(fault(format!("'{name}' is no name for a code of your own; give another one")));
    }
    description.name = Some(name);
    if description.seed.is_some() {
        return Err(fault("seed: a code is run with the seeds of the scene; remove it".into()));
    }
    let patterns = description.grains.iter().chain(&description.contacts);
    patterns.map(FilePattern::text).try_for_each(check_pattern).map_err(fault)?;
    let here = std::path::absolute(file).map_err(|error| fault(error.to_string()))?;
    Ok((description, here.parent().unwrap_or(Path::new("/")).to_path_buf()))
}

/// Returns the number that ends the name of a folder.
fn seed_of(folder: &Path) -> Option<u64> {
    let name = folder.file_name()?.to_str()?;
    let digits = name.len() - name.trim_end_matches(|letter: char| letter.is_ascii_digit()).len();
    name[name.len() - digits..].parse().ok()
}

/// Names and contents of the input files of a code.
fn input(job: &Job<'_>, grains: &[Grain]) -> Vec<(String, Vec<u8>)> {
    let scene = job.scene;
    let smallest = grains.iter().map(|grain| grain.radius).fold(f64::INFINITY, f64::min);
    let row = |(id, grain): (usize, &Grain)| {
        let ([x, y, z], [u, v, w], [p, q, r]) = (grain.position, grain.velocity, grain.spin);
        let density = scene.material[&grain.material].density;
        (id, x, y, z, grain.radius, u, v, w, p, q, r, density, grain.material.clone())
    };
    let heads = ["id", "x", "y", "z", "radius", "vx", "vy", "vz", "wx", "wy", "wz", "density", "material"];
    let numbers = "rows of numbers and names make a table";
    let scene_text = serde_json::to_string_pretty(scene).expect("a scene holds only numbers, plain text and lists");
    let mut files = vec![
        ("scene.json".to_string(), scene_text.into_bytes()),
        ("grains.csv".to_string(), csv_below(&heads, grains.iter().enumerate().map(row)).expect(numbers)),
        ("frames.csv".to_string(), csv_below(&["time"], asked(scene).into_iter().map(|time| [time])).expect(numbers)),
    ];
    for (place, wall) in scene.wall.iter().enumerate() {
        let mesh = wall_mesh(&wall.shape, &scene.domain, smallest, FINE);
        if !mesh.triangles.is_empty() {
            files.push((format!("wall{place}.stl"), stl(&mesh).into_bytes()));
        }
    }
    files
}

#[cfg(test)]
#[path = "../../tests/unit/codes_external.rs"]
mod tests;
