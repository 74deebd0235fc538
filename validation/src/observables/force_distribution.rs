//! Distribution of normal forces over their mean, pooled run by run.

use super::bed_surface::BedFields;
use super::bulk::Bulk;
use super::measured_frames;
use super::setting::Setting;
use super::view::View;
use crate::compare::ForceDistribution;
use crate::recording::Recording;
use makadam::scene::Scene;
use serde::{Deserialize, Serialize};

/// Width of a bin in which forces are counted, in mean forces.
const FINE: f64 = 0.01;

/// Forces of this many means and more share the last bin.
const LARGEST: f64 = 20.0;

/// Counts of normal forces of one code, over the mean force of their own frame.
///
/// Recordings are added one by one and need not be kept. Distances between two pools are exact but for the width of
/// the bins, a hundredth of the mean force.
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
    pub fn add_recording(&mut self, scene: &Scene, recording: &Recording) {
        let frames = measured_frames(scene, recording);
        if frames.is_empty() {
            return;
        }
        let setting = Setting::new(scene, frames[0]);
        let bed = setting.drum.as_ref().map(|drum| BedFields::new(&setting, drum, &frames));
        let bulk = Bulk::new(&setting, bed.as_ref(), &frames);
        for frame in frames {
            let view = View::new(&setting, &bulk, frame);
            let forces: Vec<f64> = view.bulk_contacts().iter().map(|contact| contact.normal_force).collect();
            self.add(&forces);
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

    /// Number of forces.
    pub fn samples(&self) -> usize {
        self.counts.iter().sum::<u64>() as usize
    }

    /// The density for a plot, in `bins` bins of `width` mean forces from 0 on.
    pub fn distribution(&self, bins: usize, width: f64) -> ForceDistribution {
        let samples = self.samples();
        let mut density = vec![0.0; bins];
        for (index, &count) in self.counts.iter().enumerate() {
            if let Some(bin) = density.get_mut(((index as f64 + 0.5) * FINE / width) as usize) {
                *bin += count as f64 / (samples.max(1) as f64 * width);
            }
        }
        let force = (0..bins).map(|bin| (bin as f64 + 0.5) * width).collect();
        ForceDistribution { code: self.code.clone(), force, density, samples }
    }

    /// Kolmogorov-Smirnov distance from another pool: the largest difference of the cumulative shares.
    pub fn kolmogorov_smirnov(&self, other: &ForcePool) -> f64 {
        self.gaps(other).fold(0.0, f64::max)
    }

    /// Wasserstein-1 distance from another pool, in mean forces: the area between the cumulative shares.
    pub fn wasserstein(&self, other: &ForcePool) -> f64 {
        self.gaps(other).sum::<f64>() * FINE
    }

    /// Difference of the cumulative shares at the upper border of each bin.
    fn gaps<'a>(&'a self, other: &'a ForcePool) -> impl Iterator<Item = f64> + 'a {
        let (here, there) = (self.samples().max(1) as f64, other.samples().max(1) as f64);
        self.counts.iter().zip(&other.counts).scan((0, 0), move |sums, (a, b)| {
            *sums = (sums.0 + a, sums.1 + b);
            Some((sums.0 as f64 / here - sums.1 as f64 / there).abs())
        })
    }
}

/// Distribution of normal forces of several runs of one code, in 32 bins of a quarter of the mean force.
pub fn force_distribution(scene: &Scene, recordings: &[Recording]) -> ForceDistribution {
    let mut pool = ForcePool::new(recordings.first().map_or("", |recording| &recording.code));
    recordings.iter().for_each(|recording| pool.add_recording(scene, recording));
    pool.distribution(32, 0.25)
}
