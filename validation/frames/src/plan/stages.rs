//! Stages of a scene: measured frames, and the same process as a scene without stages.

use super::MeasuredScene;
use makadam::Motion;
use makadam::scene::{GravityChange, Stage};
use makadam::snapshot::PresentStage;

impl MeasuredScene {
    /// Returns the time between frames on disk in a stage, s.
    pub fn output_interval_in(&self, stage: Option<usize>) -> f64 {
        let own = stage.and_then(|number| self.stage.get(number)?.output.interval);
        own.unwrap_or_else(|| self.output_interval())
    }

    /// Returns the scene of a stage, without stages: see [`makadam::Scene::in_stage`].
    pub fn in_stage(&self, number: usize) -> MeasuredScene {
        MeasuredScene { simulated: self.simulated.in_stage(number, &[]), ..self.clone() }
    }

    /// Returns true for a frame of the stage that is measured; every frame is without `measure.stage`.
    pub fn is_of_measured_stage(&self, stage: Option<PresentStage>) -> bool {
        self.measured_stage().is_none_or(|(number, _)| stage.is_some_and(|stage| stage.number as usize == number))
    }

    /// Returns true for a frame of the measured stage at or after `measure.from`, by its time (s) and its stage.
    pub fn covers(&self, time: f64, stage: Option<PresentStage>) -> bool {
        let start = self.measured_stage().and(stage).map_or(0.0, |stage| stage.start);
        self.is_of_measured_stage(stage) && self.measure.covers(time - start)
    }

    /// Returns true for the frame at a time (s) after `measure.from` in the measured stage, by the frame's time (s) and stage.
    pub fn is_at(&self, after: f64, time: f64, stage: Option<PresentStage>) -> bool {
        let start = self.measured_stage().and(stage).map_or(0.0, |stage| stage.start);
        let due = start + self.measure.from.unwrap_or(0.0) + after;
        self.is_of_measured_stage(stage) && (time - due).abs() <= self.measure.slack()
    }

    /// Returns the number of the stage that is measured, and the stage.
    pub(super) fn measured_stage(&self) -> Option<(usize, &Stage)> {
        let name = self.measure.stage.as_ref()?;
        self.stage.iter().enumerate().find(|(_, stage)| stage.name == *name)
    }

    /// Returns the same process as a scene without stages, for codes that know motions and gravity over time alone. Gravity changes within a
    /// step of the scene; the run ends with the measured stage.
    ///
    /// # Errors
    /// Message that names what such a scene cannot express, and the remedy.
    pub fn without_stages(&self) -> Result<MeasuredScene, String> {
        let mut plain = self.clone();
        let (stages, walls) = (std::mem::take(&mut plain.stage), &mut plain.simulated.wall);
        let (mut start, mut gravity, mut given) = (0.0, self.gravity, vec![false; walls.len()]);
        for stage in &stages {
            let refuse = |what: String| Err(format!("stage '{}' {what}", stage.name));
            let Some(duration) = stage.duration else {
                return refuse("ends by a condition; give it the duration that a run of Makadam prints".into());
            };
            if !stage.material.is_empty() {
                return refuse("changes materials, which a scene without stages cannot; leave that out".into());
            }
            let own = stage.gravity.unwrap_or(self.gravity);
            if own != gravity && !self.gravity_changes.is_empty() {
                return refuse("changes gravity, in addition to gravity_changes; leave one out".into());
            }
            if own != gravity && start == 0.0 {
                plain.simulated.gravity = own;
            } else if own != gravity {
                let changes = [(start, gravity), (start + self.solver.step, own)];
                plain.simulated.gravity_changes.extend(changes.map(|(time, gravity)| GravityChange { time, gravity }));
            }
            gravity = own;
            for (index, wall) in walls.iter_mut().enumerate() {
                let Some(motion) = stage.motion.get(&wall.name) else { continue };
                if *motion == Motion::Fixed && ends_at(&mut wall.motion, start) {
                    continue;
                }
                if given[index] || wall.motion != Motion::Fixed {
                    return refuse(format!("gives wall '{}' another motion than before; leave one out", wall.name));
                }
                (wall.motion, given[index]) = (later(motion, start), true);
            }
            let sources = plain.simulated.insert.iter_mut().map(|one| (&mut one.stage, &mut one.from, &mut one.until));
            let sinks = plain.simulated.remove.iter_mut().map(|one| (&mut one.stage, &mut one.from, &mut one.until));
            for (of, from, until) in sources.chain(sinks).filter(|(of, ..)| of.as_ref() == Some(&stage.name)) {
                *of = None;
                (*from, *until) = (*from + start, Some(until.unwrap_or(duration).min(duration) + start));
            }
            if self.measure.stage.as_ref() == Some(&stage.name) {
                plain.measure.from = self.measure.from.map(|from| from + start);
                start += duration;
                break;
            }
            start += duration;
        }
        plain.measure.stage = None;
        plain.simulated.duration = start;
        Ok(plain)
    }
}

/// Returns a motion with later times, s.
fn later(motion: &Motion, by: f64) -> Motion {
    let mut motion = motion.clone();
    if let Motion::Rotating { reverse, .. } = &mut motion {
        *reverse = reverse.map(|reverse| reverse + by);
    }
    match &mut motion {
        Motion::Fixed => {}
        Motion::List(parts) => parts.iter_mut().for_each(|part| *part = later(part, by)),
        Motion::Translating { start, stop, .. }
        | Motion::Rotating { start, stop, .. }
        | Motion::Vibrating { start, stop, .. }
        | Motion::Table { start, stop, .. } => (*start, *stop) = (*start + by, stop.map(|stop| stop + by)),
        Motion::ForceDriven { start, .. } | Motion::TorqueDriven { start, .. } => *start += by,
    }
    motion
}

/// Lets a motion end at a time (s) at the latest; false for a motion that has no end.
fn ends_at(motion: &mut Motion, time: f64) -> bool {
    match motion {
        Motion::Fixed => true,
        Motion::List(parts) => parts.iter_mut().all(|part| ends_at(part, time)),
        Motion::Translating { start, stop, .. }
        | Motion::Rotating { start, stop, .. }
        | Motion::Vibrating { start, stop, .. }
        | Motion::Table { start, stop, .. } => {
            *stop = Some(stop.map_or(time, |stop| stop.min(time)).max(*start));
            true
        }
        Motion::ForceDriven { .. } | Motion::TorqueDriven { .. } => false,
    }
}
