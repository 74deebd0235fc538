//! Distribution of normal forces over their mean, pooled run by run.

use super::frames::wrapped;
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

/// Width of a counting bin, in mean forces.
const FINE: f64 = 0.01;

/// Lower bound of the last bin, in mean forces.
const LARGEST: f64 = 20.0;

/// Counts of normal forces of one code, over the mean force of each frame.
///
/// Recordings are added one by one and need not be stored.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ForcePool {
    /// Name of the code.
    pub code: String,
    counts: Vec<u64>,
}

impl ForcePool {
    /// Makes an empty pool.
    pub fn new(code: &str) -> Self {
        Self { code: code.into(), counts: vec![0; (LARGEST / FINE) as usize] }
    }

    /// Adds the bulk contacts between grains of a recording's measured frames.
    pub fn add_recording(&mut self, scene: &MeasuredScene, recording: &Recording) {
        let properties = Properties::new(scene);
        for frame in measured_frames(scene, recording) {
            let frame = wrapped(&scene.domain, frame);
            let setting = Setting::new(&properties, &frame);
            let contacts = View::new(&setting, &frame).bulk_contacts();
            self.add(&contacts.iter().map(|contact| contact.normal_force).collect::<Vec<f64>>());
        }
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

    /// Returns the number of forces.
    pub fn samples(&self) -> usize {
        self.counts.iter().sum::<u64>() as usize
    }

    /// Returns the density for a plot, in `bins` bins of `width` mean forces from 0.
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

/// Returns the fraction of `samples` forces in a bin, over the bin's width.
fn density(count: u64, samples: usize, width: f64) -> f64 {
    count as f64 / (samples.max(1) as f64 * width)
}

/// Returns the distribution of normal forces of several runs of one code, in 32 bins of a quarter of the mean force.
pub fn force_distribution(scene: &MeasuredScene, recordings: &[Recording]) -> ForceDistribution {
    let mut pool = ForcePool::new(recordings.first().map_or("", |recording| &recording.code));
    recordings.iter().for_each(|recording| pool.add_recording(scene, recording));
    pool.distribution(32, 0.25)
}

#[cfg(test)]
#[path = "../../tests/unit/observables_force_distribution.rs"]
mod tests;
