//! Unit tests of `src/commands/run/measured.rs`.

use super::*;
use makadam::Simulation;
use makadam_measure::observables::Measured;

const SCENE: &str = "../tests/scenes/smoke.toml";

/// Returns the small scene measured from 0.1 s on, and frames of it.
fn frames() -> (MeasuredScene, Vec<Snapshot>) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(SCENE);
    let mut scene = MeasuredScene::load(&file).unwrap();
    scene.measure.from = Some(0.1);
    let mut simulation = Simulation::new(&scene, 1).unwrap();
    let mut frames = Vec::new();
    while simulation.time() < 0.3 {
        frames.push(simulation.snapshot());
        for _ in 0..40 {
            simulation.step();
        }
    }
    (scene, frames)
}

fn in_memory(scene: &MeasuredScene, frames: &[Snapshot]) -> Measured {
    let late: Vec<&Snapshot> = frames.iter().filter(|frame| scene.covers(frame.time, frame.stage)).collect();
    let Ok(measured) = measure_frames(scene, &late[..]);
    measured.unwrap()
}

#[test]
fn stored_frames_measure_as_frames_in_memory() {
    for interval in [None, Some(1.0)] {
        let folder = tempfile::tempdir().unwrap();
        let (mut scene, frames) = frames();
        scene.output.get_or_insert_default().interval = interval;
        let expected = in_memory(&scene, &frames);
        let numbers = &expected.measurements;
        assert!(numbers.iter().any(|one| one.observable == "coordination_number" && one.frames > 8), "{expected:?}");
        let file = folder.path().join(RunFiles::FRAMES);
        let mut written = StoreWriter::create(&file, &scene).unwrap();
        let mut measured = MeasuredFrames::begin(folder.path(), &scene).unwrap();
        assert_eq!(measured.own.is_some(), interval.is_some());
        let properties = Properties::new(&scene);
        let push = |written: &mut StoreWriter, measured: &mut MeasuredFrames, frames: &[Snapshot]| {
            for frame in frames {
                if interval.is_none() {
                    written.append(frame).unwrap();
                }
                measured.push(&properties, frame.clone()).unwrap();
            }
        };
        push(&mut written, &mut measured, &frames[..3]);
        assert!(measured.measure(&scene, &written).unwrap().is_none(), "before the first measured frame");
        push(&mut written, &mut measured, &frames[3..9]);
        let marks = (written.mark(), measured.mark());
        push(&mut written, &mut measured, &frames[9..]);
        assert_eq!(measured.measure(&scene, &written).unwrap().unwrap(), expected);
        drop((written, measured));
        let mut written = StoreWriter::resume(&file, marks.0).unwrap();
        let mut measured = MeasuredFrames::resume(folder.path(), &scene, marks.1, &written).unwrap();
        assert_eq!(measured.measure(&scene, &written).unwrap().unwrap(), in_memory(&scene, &frames[..9]));
        push(&mut written, &mut measured, &frames[9..]);
        assert_eq!(measured.measure(&scene, &written).unwrap().unwrap(), expected);
        measured.clear();
        assert!(!folder.path().join(RunFiles::MEASURED).exists());
    }
}

#[test]
fn without_a_first_time_the_last_frame_is_measured() {
    let folder = tempfile::tempdir().unwrap();
    let (mut scene, frames) = frames();
    scene.measure.from = None;
    let written = StoreWriter::create(&folder.path().join(RunFiles::FRAMES), &scene).unwrap();
    let mut measured = MeasuredFrames::begin(folder.path(), &scene).unwrap();
    for frame in &frames {
        let alone = measured.push(&Properties::new(&scene), frame.clone()).unwrap();
        let Ok(expected) = measure_frames(&scene, &[frame][..]);
        assert_eq!(Some(alone), expected);
    }
    let resumed = MeasuredFrames::resume(folder.path(), &scene, measured.mark(), &written).unwrap();
    let Ok(expected) = measure_frames(&scene, &[&frames[frames.len() - 1]][..]);
    assert_eq!(resumed.measure(&scene, &written).unwrap(), expected);
}
