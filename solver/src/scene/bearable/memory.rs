//! How much memory a scene takes, before it is asked for.

use crate::scene::Scene;

/// Bytes of a grain in a dense bed while it is simulated, candidate list and contacts included: `docs/memory.md`.
const OF_A_GRAIN: f64 = 1_000.0;
/// Bytes more of a grain at the process's peak, where the start is placed and frames are written: measured, 450 to 600.
const OF_A_START: f64 = 500.0;
/// Bytes of a site of the lattice that a population is placed on.
const OF_A_SITE: f64 = 24.0;

impl Scene {
    /// Memory that a simulation of the scene will take at its largest, bytes; an estimate for grains that lie in a dense bed.
    pub fn memory(&self) -> u64 {
        let grains =
            self.population.iter().map(|population| population.count as f64).sum::<f64>() + self.grain.len() as f64;
        let sites = self.population.iter().map(|population| population.sites()).fold(0.0, f64::max);
        (grains * (OF_A_GRAIN + OF_A_START) + sites * OF_A_SITE) as u64
    }
}
