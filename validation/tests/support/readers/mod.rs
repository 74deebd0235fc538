//! Every reader of bytes from outside, as one function of bytes that must accept or refuse them and never panic; shared by the
//! property tests, the long run and the fuzz targets.

pub mod damage;
mod documents;

use documents::{BED_SCENE, HEAP_SCENE, SMALL_SCENE, WALLED_SCENE};
use makadam::Simulation;
use makadam::checkpoint::seal;
use makadam::scene::{Region, Stop};
use makadam::snapshot::Snapshot;
use makadam_compare::codes::liggghts::loop_seconds;
use makadam_compare::codes::{driver, lammps, yade};
use makadam_compare::compare::{MeasuredRun, Reference};
use makadam_compare::study::unseal;
use makadam_frames::import::{Manifest, StatedColumns, Tables, assemble, parse};
use makadam_frames::plan::{MeasuredScene, physics_hash};
use makadam_frames::recording::Recording;
use makadam_measure::observables::{force_distribution, measure, series};
use std::io::{Error, ErrorKind};
use std::path::Path;
use std::sync::LazyLock;

/// A reader.
pub struct Reader {
    /// Its name, that of its fuzz target too.
    pub name: &'static str,
    /// Documents that it accepts.
    pub documents: fn() -> Vec<Vec<u8>>,
    /// Reads bytes and uses what they hold; whether they were accepted. Panics if the promise is broken.
    pub read: fn(&[u8]) -> bool,
}

/// All of them.
pub const READERS: [Reader; 11] = [
    Reader { name: "scene", documents: documents::scenes, read: scene },
    Reader { name: "checkpoint", documents: documents::checkpoints, read: checkpoint },
    Reader { name: "recording", documents: documents::recordings, read: recording },
    Reader { name: "yade_frames", documents: documents::yade_frames, read: yade_frames },
    Reader { name: "yade_driven_walls", documents: documents::yade_driven_walls, read: yade_driven_walls },
    Reader { name: "yade_result", documents: documents::yade_results, read: yade_result },
    Reader { name: "liggghts_log", documents: documents::liggghts_logs, read: liggghts_log },
    Reader { name: "foreign_frames", documents: documents::foreign_frames, read: foreign_frames },
    Reader { name: "lammps_log", documents: documents::lammps_logs, read: lammps_log },
    Reader { name: "reference", documents: documents::references, read: reference },
    Reader { name: "kept_run", documents: documents::kept_runs, read: kept_run },
];

/// The reader of a name.
pub fn named(name: &str) -> &'static Reader {
    READERS.iter().find(|reader| reader.name == name).unwrap_or_else(|| panic!("no reader {name}"))
}

static WALLED: LazyLock<MeasuredScene> = LazyLock::new(|| documents::scene(WALLED_SCENE));

/// Steps that an accepted scene or checkpoint takes.
const STEPS: usize = 3;

/// Checks a refusal: not empty, on one line, shorter than a page.
fn refused(message: &str) -> bool {
    assert!(!message.trim().is_empty(), "a refusal without words");
    false
}

/// A text scene: parsed, and where it is small placed and stepped.
fn scene(bytes: &[u8]) -> bool {
    let Ok(text) = std::str::from_utf8(bytes) else { return false };
    let file = Path::new("fuzzed.toml");
    let scene = match MeasuredScene::parse(text) {
        Ok(scene) => scene,
        Err(error) => {
            let message = error.in_file(file, Some(text)).to_string();
            assert!(message.starts_with("fuzzed.toml:"), "no file and line: {message}");
            return refused(&message);
        }
    };
    physics_hash(&scene);
    if is_small(&scene) {
        match Simulation::new(&scene, scene.seed) {
            Ok(mut simulation) => steps_stay_finite(&mut simulation),
            Err(error) => return refused(&error.to_string()),
        }
    }
    true
}

/// Returns true if a scene can be placed and stepped in a moment.
fn is_small(scene: &MeasuredScene) -> bool {
    let sites = scene.population.iter().map(|population| {
        let pitch = 2.0 * population.radius.bounds().1 * population.spacing;
        match &population.region {
            Region::Box { min, max } => (0..3).map(|axis| 1.0 + (max[axis] - min[axis]) / pitch).product::<f64>(),
            Region::Cylinder { radius, length, .. } => (1.0 + radius.max(*length) / pitch).powi(3) * 8.0,
        }
    });
    let listed = scene.population.iter().map(|population| population.count).sum::<usize>() + scene.grain.len();
    sites.sum::<f64>() < 1e5 && listed <= 200 && scene.wall.len() <= 20
}

/// Steps a few times, with few sweeps; every number stays one.
fn steps_stay_finite(simulation: &mut Simulation) {
    simulation.use_stop(Stop::Sweeps { sweeps: 3 });
    for _ in 0..STEPS {
        simulation.step();
    }
    let snapshot = simulation.snapshot();
    let finite = |vector: &[f64; 3]| vector.iter().all(|component| component.is_finite());
    for grain in &snapshot.particles {
        assert!([grain.position, grain.velocity, grain.spin].iter().all(finite), "{grain:?} after {STEPS} steps");
    }
    for contact in &snapshot.contacts {
        assert!(finite(&contact.normal) && contact.normal_force.is_finite(), "{contact:?} after {STEPS} steps");
    }
}

/// A checkpoint as it is, and once more with length and checksum made to fit, so that damage gets past the envelope.
fn checkpoint(bytes: &[u8]) -> bool {
    static SMALL: LazyLock<MeasuredScene> = LazyLock::new(|| documents::scene(SMALL_SCENE));
    let small = &*SMALL;
    let fitted = fitted(&documents::checkpoints().swap_remove(0), bytes);
    let mut accepted = false;
    for bytes in [bytes, &fitted] {
        for read in [Simulation::resume, Simulation::start_from] {
            match read(small, bytes) {
                Ok(mut simulation) => {
                    accepted = true;
                    // Speeds that only a forged checksum lets in may overflow in a step; no number may end the program.
                    for _ in 0..STEPS {
                        simulation.step();
                    }
                }
                Err(error) => {
                    refused(&error.to_string());
                }
            }
        }
    }
    accepted
}

/// Bytes with the mark of a sound document, and length and checksum made to fit, so that damage gets past the envelope.
fn fitted(sound: &[u8], bytes: &[u8]) -> Vec<u8> {
    const HEAD: usize = 24;
    let mark: [u8; 8] = std::array::from_fn(|place| sound[place]);
    seal(mark, bytes.get(HEAD..).unwrap_or(bytes))
}

/// A recording as it is, and once more made to fit, and all that can be measured of it: as one of a drum, of a heap, and of a
/// bed in a box.
fn recording(bytes: &[u8]) -> bool {
    let fitted = fitted(&documents::recordings().swap_remove(0), bytes);
    [bytes, &fitted].into_iter().filter(|bytes| recording_as_it_is(bytes)).count() > 0
}

fn recording_as_it_is(bytes: &[u8]) -> bool {
    static SCENES: LazyLock<[MeasuredScene; 3]> =
        LazyLock::new(|| [WALLED_SCENE, HEAP_SCENE, BED_SCENE].map(documents::scene));
    match Recording::parse(bytes) {
        Ok(recording) => {
            recording.frames.iter().for_each(documents::check_contacts);
            for scene in SCENES.iter() {
                for measured in measure(scene, &recording) {
                    assert!(measured.value.is_finite(), "{measured:?}");
                }
                for series in series(scene, &recording) {
                    assert!(series.value.iter().all(|value| value.is_finite()), "{series:?}");
                }
            }
            let forces = force_distribution(&SCENES[0], std::slice::from_ref(&recording));
            assert!(forces.density.iter().all(|density| density.is_finite()), "{forces:?}");
            true
        }
        Err(problem) => refused(&problem),
    }
}

fn yade_frames(bytes: &[u8]) -> bool {
    match driver::read_frames(bytes, &documents::RADII, 2) {
        Ok(frames) => {
            frames.iter().for_each(documents::check_contacts);
            true
        }
        Err(problem) => refused(&problem),
    }
}

/// Two walls in two frames.
fn yade_driven_walls(bytes: &[u8]) -> bool {
    let mut frames = [Snapshot::default(), Snapshot::default()];
    match yade::read_driven_walls(bytes, &[1, 3], &mut frames) {
        Ok(()) => {
            let walls = frames.iter().flat_map(|frame| &frame.driven_walls);
            assert!(walls.clone().all(|wall| wall.displacement.is_finite() && wall.rate.is_finite()));
            assert_eq!(walls.map(|wall| wall.wall).collect::<Vec<_>>(), [1, 3, 1, 3]);
            true
        }
        Err(problem) => refused(&problem),
    }
}

fn yade_result(bytes: &[u8]) -> bool {
    match driver::read_result(bytes) {
        Ok(result) => {
            assert!(result.seconds.is_finite());
            true
        }
        Err(problem) => refused(&problem),
    }
}

/// Files of any code: a document is read by itself, as grains and as contacts, and what comes of it is measured.
fn foreign_frames(bytes: &[u8]) -> bool {
    let file = Path::new("fuzzed-3.frames");
    let frames = match parse(file, bytes.to_vec(), &StatedColumns::default()) {
        Ok(frames) => frames,
        Err(error) => {
            let message = error.to_string();
            assert!(message.starts_with("fuzzed-3.frames: line "), "no file and line: {message}");
            return refused(&message);
        }
    };
    let time = (frames.len() == 1 && frames[0].time.is_none() && frames[0].step.is_none()).then_some(0.05);
    let manifest = Manifest { time_step: Some(0.05), time, contacts_complete: true, ..Manifest::default() };
    let rows: usize = frames.iter().map(|frame| frame.rows().count()).sum();
    if rows > 10_000 {
        return true;
    }
    let both = Tables { grains: frames.clone(), contacts: frames.clone(), ..Tables::default() };
    for tables in [Tables { grains: frames, ..Tables::default() }, both] {
        match assemble(&WALLED, &manifest, &tables) {
            Ok(imported) => {
                imported.frames.iter().for_each(documents::check_contacts);
                for measured in measure(&WALLED, &imported) {
                    assert!(measured.value.is_finite(), "{measured:?}");
                }
            }
            Err(error) => _ = refused(&error.to_string()),
        }
    }
    true
}

fn liggghts_log(bytes: &[u8]) -> bool {
    is_time(loop_seconds(&String::from_utf8_lossy(bytes)))
}

fn lammps_log(bytes: &[u8]) -> bool {
    is_time(lammps::loop_seconds(&String::from_utf8_lossy(bytes)))
}

/// Checks that a wall time was found, which is a number in any case.
fn is_time(seconds: f64) -> bool {
    assert!(seconds.is_finite() && seconds >= 0.0, "{seconds} s");
    seconds > 0.0
}

/// The files of a folder of references in one document, each behind a line that names it.
fn reference(bytes: &[u8]) -> bool {
    let parts = documents::parts(bytes);
    let give = |file: &Path| {
        let name = file.file_name().and_then(|name| name.to_str()).unwrap_or_default();
        parts.get(name).map(|part| part.to_vec()).ok_or_else(|| Error::from(ErrorKind::NotFound))
    };
    match Reference::read(Path::new("reference"), &give) {
        Ok(Some(reference)) => {
            for code in reference.codes() {
                assert!(reference.code(&code).is_some(), "{code} has runs");
            }
            true
        }
        Ok(None) => false,
        Err(error) => refused(&error.to_string()),
    }
}

fn kept_run(bytes: &[u8]) -> bool {
    match unseal::<MeasuredRun>(bytes, &documents::key()) {
        Some(kept) => {
            assert_eq!(kept, documents::kept(), "damage that the seal does not show");
            true
        }
        None => false,
    }
}
