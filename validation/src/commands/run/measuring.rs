//! What a run measures: a row of the table of each frame, and the observables of all that the scene names at the end.

use crate::observables;
use crate::output::Measured;
use crate::provenance::VERSION;
use crate::recording::Recording;
use makadam::scene::Scene;
use makadam::snapshot::Snapshot;
use std::collections::BTreeMap;

/// The frames that observables are measured over: those from `measure.from` on, or the last one.
pub(super) struct Measuring<'a> {
    scene: &'a Scene,
    seed: u64,
    /// Simulated time at which the run began, s.
    started: f64,
    /// Frames with their numbers.
    kept: Vec<(usize, Snapshot)>,
}

/// What a run measured.
pub(super) struct Measurements {
    /// By name.
    pub observables: BTreeMap<String, Measured>,
    /// Why there are none, where the run ended before the state that the scene wants measured.
    pub not_measured: Option<String>,
}

impl<'a> Measuring<'a> {
    /// Nothing is measured yet.
    pub fn new(scene: &'a Scene, seed: u64, started: f64) -> Measuring<'a> {
        Measuring { scene, seed, started, kept: Vec::new() }
    }

    /// Takes up frames that an earlier part of the run has kept.
    pub fn go_on(self, kept: Vec<(usize, Snapshot)>) -> Measuring<'a> {
        Measuring { kept, ..self }
    }

    /// Takes a frame in.
    pub fn add(&mut self, number: usize, frame: Snapshot) {
        if !self.is_reached(&frame) {
            self.kept.clear();
        }
        self.kept.push((number, frame));
    }

    /// Frames that a checkpoint must keep, with their numbers.
    pub fn kept(&self) -> &[(usize, Snapshot)] {
        &self.kept
    }

    /// What the frames come to. `complete`: whether the run has reached its last step. `steps`: step length and wall time of the
    /// steps, s, and threads.
    pub fn finish(&mut self, complete: bool, (time_step, wall_seconds, threads): (f64, f64, usize)) -> Measurements {
        let ended = self.kept.last().map_or(self.started, |(_, frame)| frame.time) - self.started;
        let reached = match self.scene.measure.from {
            Some(_) => self.kept.last().is_some_and(|(_, frame)| self.is_reached(frame)),
            None => complete,
        };
        if !reached {
            let before = match self.scene.measure.from {
                Some(from) => format!("measure.from = {from} s"),
                None => "its last step".into(),
            };
            let not_measured = Some(format!("the run ended after {ended:.4} s, before {before}"));
            return Measurements { observables: BTreeMap::new(), not_measured };
        }
        let recording = Recording {
            time_step,
            threads,
            wall_seconds,
            simulated_seconds: ended,
            frames: std::mem::take(&mut self.kept).into_iter().map(|(_, frame)| frame).collect(),
            ..recording(self.scene, self.seed)
        };
        let measured = observables::measure(self.scene, &recording).into_iter().filter(|m| m.value.is_finite());
        let observables = measured
            .map(|m| (m.observable, Measured { value: m.value, standard_error: m.standard_error, unit: m.unit }));
        Measurements { observables: observables.collect(), not_measured: None }
    }

    fn is_reached(&self, frame: &Snapshot) -> bool {
        self.scene.measure.from.is_some_and(|from| frame.time - self.started >= from - 1e-9)
    }
}

/// What can be measured of one frame alone.
pub(super) fn instant(scene: &Scene, frame: &Snapshot) -> Vec<(String, f64)> {
    let mut scene = scene.clone();
    scene.measure.from = None;
    let recording = Recording { simulated_seconds: frame.time, frames: vec![frame.clone()], ..recording(&scene, 0) };
    let measured = observables::measure(&scene, &recording).into_iter();
    measured.filter(|m| m.value.is_finite()).map(|m| (m.observable, m.value)).collect()
}

/// A recording without frames.
fn recording(scene: &Scene, seed: u64) -> Recording {
    Recording {
        scene: scene.name.clone(),
        code: "Makadam".into(),
        version: VERSION.into(),
        seed,
        time_step: scene.solver.step,
        rayleigh_fraction: None,
        stiffness_factor: 1.0,
        threads: 1,
        wall_seconds: 0.0,
        simulated_seconds: 0.0,
        frames: Vec::new(),
    }
}
