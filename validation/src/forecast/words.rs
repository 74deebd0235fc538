//! A forecast in words.

use super::Forecast;
use crate::draw::numbers::{compact, count, duration, plural};
use crate::draw::wrapped;
use std::fmt::Write;

impl Forecast {
    /// All of it, as a text of several lines.
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
        let _ = writeln!(text, "grains    {}{size}", count(self.grains));
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
        let _ = writeln!(text, "memory    {:.1} MB", self.bytes as f64 / 1e6);
        let _ = writeln!(
            text,
            "wall time some {} on {}, at the pace of this machine now; good to a factor of two",
            duration(self.wall_seconds),
            plural(self.threads, "thread")
        );
        let rows = self
            .settings
            .iter()
            .map(|setting| vec![setting.key.to_string(), setting.value.clone(), setting.why.clone()]);
        let head = |names: [&str; 3]| names.map(String::from).to_vec();
        let rows: Vec<Vec<String>> = [head(["setting", "value", "why"])].into_iter().chain(rows).collect();
        let _ = write!(text, "\n{}", wrapped(&rows));
        let rows = self.scales.iter().map(|scale| {
            let value = format!("{} {}", compact(scale.value), scale.unit);
            vec![scale.name.to_string(), value.trim_end().to_string(), scale.formula.clone()]
        });
        let rows: Vec<Vec<String>> = [head(["number", "value", "how"])].into_iter().chain(rows).collect();
        if !self.scales.is_empty() {
            let _ = write!(text, "\n\n{}", wrapped(&rows));
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
