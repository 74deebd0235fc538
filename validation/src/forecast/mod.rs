//! Preflight summary of a run: grains, scales, step and stopping rule, memory and time.
//!
//! ```text
//! scene ─> grains placed ─> scales (bed, walls, contacts) ─> forecast ─> text, JSON
//! ```

mod pace;
mod scales;

use makadam::scene::{Finding, Reaction, Stop, populate};
use makadam::solve::{residual_text, residual_unit_name};
use makadam_frames::execution::threads_for;
use makadam_frames::plan::MeasuredScene;
use makadam_measure::observables::impossible;
pub use makadam_studies::effects::{Called, called};
use makadam_view::draw::numbers::{compact, count, duration, plural};
use makadam_view::draw::wrapped;
use nalgebra::Vector3;
use pace::{Pace, Work};
use scales::Bed;
use serde::Serialize;
use std::fmt::Write;

/// Preflight summary of a run.
#[derive(Clone, Debug, Serialize)]
pub struct Forecast {
    pub scene: String,
    pub description: String,
    pub grains: usize,
    /// Number of grains that come from sources by the end, unless they find no places.
    pub grains_to_come: usize,
    /// Smallest, mean and largest radius, m; absent without grains.
    pub radii: Option<[f64; 3]>,
    /// Mass of all grains, kg.
    pub mass: f64,
    /// Names of the moving walls, with their motion.
    pub moving_walls: Vec<String>,
    pub walls: usize,
    /// Names of the active physical effects.
    pub effects: Vec<&'static str>,
    /// Simulated time, s.
    pub seconds: f64,
    pub steps: u64,
    pub frames: u64,
    /// Step and stopping rule.
    pub solver: String,
    /// Characteristic numbers of the flow and the contacts; undefined ones are left out.
    pub scales: Vec<Scale>,
    /// Memory, bytes.
    pub bytes: u64,
    /// Wall time, s, at the pace of a small bed simulated on this machine just before; accurate to a factor of two.
    pub wall_seconds: f64,
    /// Default number of threads of a run.
    pub threads: usize,
    /// Causes of increased cost, with the setting to change.
    pub notes: Vec<String>,
    /// Preflight warnings.
    pub findings: Vec<Finding>,
}

/// Characteristic number of the flow or the contacts.
#[derive(Clone, Debug, Serialize)]
pub struct Scale {
    pub name: &'static str,
    pub value: f64,
    /// Unit; empty for plain numbers.
    pub unit: &'static str,
    pub formula: String,
}

impl Forecast {
    /// Summarises a scene; `text` is the text of its file.
    ///
    /// # Errors
    /// [`makadam::scene::SceneError`] if the grains cannot be placed.
    pub fn of(scene: &MeasuredScene, text: &str) -> Result<Forecast, makadam::scene::SceneError> {
        let grains = populate(scene, scene.seed)?;
        let bed = Bed::of(scene, &grains);
        let steps = scene.most_steps();
        let moving = scene.wall.iter().enumerate().filter_map(|(index, wall)| {
            let belt = Vector3::from(wall.surface_velocity).norm();
            let belt = (belt > 0.0).then(|| format!("runs at {belt} m/s"));
            let given = scene.stage.iter().any(|stage| stage.motion.contains_key(&wall.name));
            let of_stage = given.then(|| "moves in a stage".to_string());
            let words: Vec<String> =
                [scales::motion(&scene.course(index)), belt, of_stage].into_iter().flatten().collect();
            (!words.is_empty()).then(|| format!("{} {}", wall.name, words.join(", ")))
        });
        let active = called(scene, text).into_iter().filter(|called: &Called| called.on);
        let radii = || grains.iter().map(|grain| grain.radius);
        let mean = radii().sum::<f64>() / grains.len().max(1) as f64;
        let range = [radii().fold(f64::INFINITY, f64::min), mean, radii().fold(0.0, f64::max)];
        Ok(Forecast {
            scene: scene.name.clone(),
            description: scene.description.clone(),
            grains: grains.len(),
            grains_to_come: scene.most_grains() - grains.len(),
            radii: (!grains.is_empty()).then_some(range),
            mass: bed.mass,
            moving_walls: moving.collect(),
            walls: scene.wall.len(),
            effects: active.map(|called| called.effect).collect(),
            seconds: scene.duration,
            steps,
            frames: frames(scene),
            solver: chosen(scene),
            scales: bed.scales(scene, &grains),
            bytes: scene.memory(),
            wall_seconds: Pace::here().seconds(&Work::of(scene, scene.seed)),
            threads: threads_for(scene.most_grains()),
            notes: notes(scene),
            findings: scene.findings(Some(text)).into_iter().chain(impossible(scene, Some(text))).collect(),
        })
    }
}

/// Returns the number of frames on disk: at the start, at each due time, and at the end, at least one step apart.
fn frames(scene: &MeasuredScene) -> u64 {
    let interval = scene.output_interval().max(scene.solver.step);
    1 + (scene.duration / interval - 1e-6).ceil().max(1.0) as u64
}

/// Lists causes of increased cost, with the setting to change.
fn notes(scene: &MeasuredScene) -> Vec<String> {
    let ignores_escapes = scene.watch.on_escape == Reaction::Ignore || scene.watch.every == 0;
    let fall = "grains that leave the domain are simulated on, and the faster they fly, the more often contacts are searched: a wall \
                that catches them (a plane below the outlet) keeps steps cheap";
    let escapes = ignores_escapes.then(|| format!("watch.on_escape is ignored: {fall}"));
    escapes.into_iter().chain(outside_of_accuracy(scene)).collect()
}

/// Largest restitution of the measurements behind the bounds of an accuracy (`validation/docs/accuracy.md`).
const MEASURED_RESTITUTION: f64 = 0.3;

/// Returns a note about a scene whose accuracy is a target but no bound.
pub fn outside_of_accuracy(scene: &MeasuredScene) -> Option<String> {
    let restitution = scene.possible_contacts().map(|contact| contact.restitution).fold(0.0, f64::max);
    (scene.accuracy.is_some() && restitution > MEASURED_RESTITUTION).then(|| {
        format!(
            "the accuracy is no bound: it is one up to a restitution of {MEASURED_RESTITUTION}, and the scene has {restitution}; \
             compare with half of the step"
        )
    })
}

/// Formats step and stopping rule.
pub fn chosen(scene: &MeasuredScene) -> String {
    let step: f64 = format!("{:.2e}", scene.solver.step).parse().unwrap_or(scene.solver.step);
    format!("a step of {step:e} s and solves that end at {}", stop_of(scene))
}

fn stop_of(scene: &MeasuredScene) -> String {
    match &scene.solver.stop {
        Stop::Sweeps { sweeps } => format!("{sweeps} sweeps"),
        Stop::Residual { tolerance, max_sweeps } => {
            let bound = residual_text(*tolerance, residual_unit_name(scene.gravity_field().largest()));
            format!("residual below {bound}, at most {max_sweeps} sweeps")
        }
        Stop::TimeBudget { seconds, max_sweeps } => {
            format!("{seconds} s of wall time, at most {max_sweeps} sweeps: not reproducible")
        }
    }
}

impl Forecast {
    /// Formats the summary as a text of several lines.
    pub fn text(&self) -> String {
        let colon = if self.description.is_empty() { "" } else { ": " };
        let mut text = format!("{}{colon}{}\n\n", self.scene, self.description);
        let size = self.radii.map_or(String::new(), |[least, mean, most]| {
            let millimetres = |length: f64| compact(1e3 * length);
            format!(
                ", radius {} to {} mm, mean {} mm, {} kg",
                millimetres(least),
                millimetres(most),
                millimetres(mean),
                compact(self.mass)
            )
        });
        let to_come = match self.grains_to_come {
            0 => String::new(),
            some => format!("; {} come during the run", count(some)),
        };
        let _ = writeln!(text, "grains    {}{size}{to_come}", count(self.grains));
        let moving = if self.moving_walls.is_empty() { "all at rest".into() } else { self.moving_walls.join("; ") };
        let _ = writeln!(text, "walls     {}: {moving}", self.walls);
        let _ = writeln!(text, "effects   {}", self.effects.join(", "));
        let _ = writeln!(
            text,
            "run       {} s in {} steps, {} frames",
            self.seconds,
            count(self.steps as usize),
            count(self.frames as usize)
        );
        let _ = writeln!(text, "solver    {}", self.solver);
        let _ = writeln!(text, "memory    {:.1} MB", self.bytes as f64 / 1e6);
        let _ = writeln!(
            text,
            "wall time some {} on {}, at the pace of this machine now; good to a factor of two",
            duration(self.wall_seconds),
            plural(self.threads, "thread")
        );
        let rows = self.scales.iter().map(|scale| {
            let value = format!("{} {}", compact(scale.value), scale.unit);
            vec![scale.name.to_string(), value.trim_end().to_string(), scale.formula.clone()]
        });
        let head = ["number", "value", "how"].map(String::from).to_vec();
        let rows: Vec<Vec<String>> = [head].into_iter().chain(rows).collect();
        if !self.scales.is_empty() {
            let _ = write!(text, "\n{}", wrapped(&rows));
        }
        for note in &self.notes {
            let _ = write!(text, "\n\nnote: {note}");
        }
        if self.findings.is_empty() {
            let _ = write!(text, "\n\nno objection: the settings are expected to bear this scene");
        }
        text
    }
}

#[cfg(test)]
#[path = "../../tests/unit/forecast.rs"]
mod tests;
