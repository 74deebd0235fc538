//! Distribution of normal forces over their mean, pooled run by run.

use super::frames::{Frames, Wrapped};
use super::measured_frames;
use super::setting::{Properties, Setting};
use super::view::View;
use makadam_frames::plan::MeasuredScene;
use makadam_frames::recording::Recording;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Distribution of normal forces over their mean, all seeds of a code pooled.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ForceDistribution {
    /// The code.
    pub code: String,
    /// Centres of the bins, in mean forces.
    pub force: Vec<f64>,
    /// Probability density in the bins.
    pub density: Vec<f64>,
    /// Number of forces.
    pub samples: usize,
}

/// Width of a bin in which forces are counted, in mean forces.
const FINE: f64 = 0.01;

/// Forces of this many means and more share the last bin.
const LARGEST: f64 = 20.0;

/// Counts of normal forces of one code, over the mean force of their own frame.
///
/// Recordings are added one by one and need not be stored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ForcePool {
    /// The code.
    pub code: String,
    counts: Vec<u64>,
}

impl ForcePool {
    /// An empty pool.
    pub fn new(code: &str) -> Self {
        Self { code: code.into(), counts: vec![0; (LARGEST / FINE) as usize] }
    }

    /// Adds the bulk contacts between grains of a recording's measured frames.
    pub fn add_recording(&mut self, scene: &MeasuredScene, recording: &Recording) {
        let Ok(()) = self.add_frames(scene, &measured_frames(scene, recording)[..]);
    }

    /// Adds the bulk contacts between grains of these frames of one run.
    pub fn add_frames<F: Frames + ?Sized>(&mut self, scene: &MeasuredScene, frames: &F) -> Result<(), F::Error> {
        let (frames, properties) = (Wrapped::new(frames, &scene.domain), Properties::new(scene));
        frames.each(&mut |frame| {
            let setting = Setting::new(&properties, frame);
            let view = View::new(&setting, frame);
            let forces: Vec<f64> = view.bulk_contacts().iter().map(|contact| contact.normal_force).collect();
            self.add(&forces);
        })
    }

    /// Adds forces (any unit) over their own mean.
    pub fn add(&mut self, forces: &[f64]) {
        let mean = crate::statistics::mean(forces);
        if mean.is_nan() || mean <= 0.0 {
            return;
        }
        let last = self.counts.len() - 1;
        for force in forces {
            self.counts[((force / mean / FINE) as usize).min(last)] += 1;
        }
    }

    /// Adds another pool of the same code.
    pub fn merge(&mut self, other: &ForcePool) {
        for (count, more) in self.counts.iter_mut().zip(&other.counts) {
            *count += more;
        }
    }

    /// Number of forces.
    pub fn samples(&self) -> usize {
        self.counts.iter().sum::<u64>() as usize
    }

    /// The density for a plot, in `bins` bins of `width` mean forces from 0 on.
    pub fn distribution(&self, bins: usize, width: f64) -> ForceDistribution {
        let samples = self.samples();
        let mut counts = vec![0; bins];
        for (index, &count) in self.counts.iter().enumerate() {
            if let Some(bin) = counts.get_mut(((index as f64 + 0.5) * FINE / width) as usize) {
                *bin += count;
            }
        }
        let density = counts.into_iter().map(|count| density(count, samples, width)).collect();
        let force = (0..bins).map(|bin| (bin as f64 + 0.5) * width).collect();
        ForceDistribution { code: self.code.clone(), force, density, samples }
    }
}

/// Share of `samples` forces that fall into a bin, over the bin's width.
fn density(count: u64, samples: usize, width: f64) -> f64 {
    count as f64 / (samples.max(1) as f64 * width)
}

impl ForceDistribution {
    /// The distribution of the forces of both, as if they had been counted together; `None` where the bins differ.
    ///
    /// Each force was taken over the mean of its own frame, so the counts of two distributions simply add up. A count
    /// is density times samples times width, rounded to the whole number that it was: below four million samples the
    /// six digits to which densities are recorded suffice to find it, and nothing is lost however often runs are added.
    pub fn pooled(&self, other: &ForceDistribution) -> Option<ForceDistribution> {
        // Centres lie in the middle of equal bins, the first of which begins at 0.
        let width = 2.0 * self.force.first().filter(|_| self.force == other.force)?;
        let samples = self.samples + other.samples;
        let count = |distribution: &ForceDistribution, density: f64| {
            (density * distribution.samples as f64 * width).round() as u64
        };
        let pairs = self.density.iter().zip(&other.density);
        Some(ForceDistribution {
            code: self.code.clone(),
            force: self.force.clone(),
            density: pairs.map(|(&a, &b)| density(count(self, a) + count(other, b), samples, width)).collect(),
            samples,
        })
    }
}

/// Distribution of normal forces of several runs of one code, in 32 bins of a quarter of the mean force.
pub fn force_distribution(scene: &MeasuredScene, recordings: &[Recording]) -> ForceDistribution {
    let mut pool = ForcePool::new(recordings.first().map_or("", |recording| &recording.code));
    recordings.iter().for_each(|recording| pool.add_recording(scene, recording));
    pool.distribution(32, 0.25)
}

#[cfg(test)]
#[path = "../../tests/unit/observables_force_distribution.rs"]
mod tests;
