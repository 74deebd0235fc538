//! What chance has in the choice of the fastest settings: with other seeds it could have been another one.

use super::rows::Fastest;
use rand_chacha::ChaCha8Rng;
use rand_core::{RngCore, SeedableRng};
use std::collections::{BTreeMap, BTreeSet};

/// Samples of the seeds that are drawn.
const SAMPLES: usize = 2_000;

/// Share of the samples that lies outside the interval, at either end.
const TAIL: f64 = 0.05;

/// A configuration that could be the fastest of its code.
pub(super) struct Candidate {
    /// The code.
    pub code: String,
    /// Factor on every Young's modulus.
    pub stiffness_factor: f64,
    /// Wall time over simulated time.
    pub pace: f64,
    /// Differences from the reference by seed, of every bounded observable, and the bound.
    pub differences: Vec<(BTreeMap<u64, f64>, f64)>,
}

impl Candidate {
    /// Whether the mean deviations over a sample of seeds keep their bounds.
    fn keeps_bounds(&self, sample: &[u64]) -> bool {
        self.differences.iter().all(|(by_seed, bound)| {
            let values: Vec<f64> = sample.iter().filter_map(|seed| by_seed.get(seed).copied()).collect();
            !values.is_empty() && (values.iter().sum::<f64>() / values.len() as f64).abs() <= *bound
        })
    }
}

/// Fills in the intervals of the ratios: seeds are drawn with replacement, the same for every configuration, since all start from
/// the same grains; each sample has its own fastest settings, and a code that has none is slower than any number (percentile
/// bootstrap, Efron and Tibshirani, An Introduction to the Bootstrap, 1993, chapter 13).
pub(super) fn fill_intervals(rows: &mut [Fastest], candidates: &[Candidate]) {
    let by_seed = candidates.iter().flat_map(|one| one.differences.iter()).map(|(by_seed, _)| by_seed);
    let seeds: BTreeSet<u64> = by_seed.flat_map(|by_seed| by_seed.keys().copied()).collect();
    let seeds: Vec<u64> = seeds.into_iter().collect();
    if seeds.len() < 2 {
        return;
    }
    let mut random = ChaCha8Rng::seed_from_u64(1);
    let mut ratios: Vec<Vec<f64>> = vec![Vec::with_capacity(SAMPLES); rows.len()];
    for _ in 0..SAMPLES {
        let sample: Vec<u64> = seeds.iter().map(|_| seeds[(random.next_u64() % seeds.len() as u64) as usize]).collect();
        let kept: Vec<&Candidate> = candidates.iter().filter(|one| one.keeps_bounds(&sample)).collect();
        let least = |code: &str, factor: f64| {
            let own = kept.iter().filter(|one| one.code == code && one.stiffness_factor == factor);
            own.map(|one| one.pace).fold(f64::INFINITY, f64::min)
        };
        for (row, ratios) in rows.iter().zip(&mut ratios) {
            ratios.push(least(&row.code, row.stiffness_factor) / least("Makadam", row.stiffness_factor));
        }
    }
    for (row, mut ratios) in rows.iter_mut().zip(ratios) {
        if row.code == "Makadam" || ratios.iter().any(|ratio| ratio.is_nan()) {
            continue;
        }
        ratios.sort_by(f64::total_cmp);
        let at = |share: f64| Some(ratios[(share * (SAMPLES - 1) as f64).round() as usize]).filter(|r| r.is_finite());
        [row.ratio_low, row.ratio_high] = [at(TAIL), at(1.0 - TAIL)];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(code: &str) -> Fastest {
        Fastest {
            code: code.into(),
            stiffness_factor: 1.0,
            youngs_modulus: 1e7,
            setting: None,
            wall_seconds_per_simulated_second: None,
            intervals_within_bounds: None,
            ratio_to_makadam: None,
            ratio_low: None,
            ratio_high: None,
        }
    }

    /// A setting that takes `pace` and has these errors, one a seed, against a bound of 1.
    fn candidate(code: &str, pace: f64, errors: &[f64]) -> Candidate {
        let by_seed = errors.iter().enumerate().map(|(seed, error)| (seed as u64 + 1, *error)).collect();
        Candidate { code: code.into(), stiffness_factor: 1.0, pace, differences: vec![(by_seed, 1.0)] }
    }

    fn interval(candidates: &[Candidate]) -> [Option<f64>; 2] {
        let mut rows = [row("Makadam"), row("YADE")];
        fill_intervals(&mut rows, candidates);
        assert_eq!([rows[0].ratio_low, rows[0].ratio_high], [None, None], "Makadam's own ratio is one");
        [rows[1].ratio_low, rows[1].ratio_high]
    }

    #[test]
    fn errors_without_spread_leave_chance_nothing() {
        let sure = [
            candidate("Makadam", 0.1, &[0.5; 4]),
            candidate("YADE", 2.0, &[-0.9; 4]),
            candidate("YADE", 1.0, &[1.1; 4]),
        ];
        assert_eq!(interval(&sure), [Some(20.0), Some(20.0)]);
    }

    #[test]
    fn a_setting_that_keeps_the_bound_by_luck_widens_the_interval() {
        // The fast setting's mean is 0.9: of samples of four seeds a fair share has one above 1.
        let lucky = candidate("Makadam", 0.1, &[0.0, 0.6, 1.2, 1.8]);
        let slow = candidate("Makadam", 0.5, &[0.0; 4]);
        assert_eq!(interval(&[lucky, slow, candidate("YADE", 2.0, &[0.0; 4])]), [Some(4.0), Some(20.0)]);
    }

    #[test]
    fn a_code_that_often_keeps_no_bound_has_no_upper_end() {
        let own = candidate("Makadam", 0.1, &[0.0; 4]);
        assert_eq!(interval(&[own, candidate("YADE", 2.0, &[0.0, 0.6, 1.2, 1.8])]), [Some(20.0), None]);
        let own = candidate("Makadam", 0.1, &[0.0; 4]);
        assert_eq!(interval(&[own, candidate("YADE", 2.0, &[1.5; 4])]), [None, None]);
    }

    #[test]
    fn seeds_are_drawn_together_for_all_settings() {
        // Errors of both codes rise and fall together: the slow settings are needed in the same samples.
        let errors = [0.0, 0.6, 1.2, 1.8];
        let both = ["Makadam", "YADE"].map(|code| {
            let pace = if code == "YADE" { 2.5 } else { 0.125 };
            [candidate(code, pace, &errors), candidate(code, 3.0 * pace, &[0.0; 4])]
        });
        assert_eq!(interval(&both.into_iter().flatten().collect::<Vec<_>>()), [Some(20.0), Some(20.0)]);
    }

    #[test]
    fn one_seed_says_nothing_of_chance() {
        assert_eq!(interval(&[candidate("Makadam", 0.1, &[0.0]), candidate("YADE", 2.0, &[0.0])]), [None, None]);
    }
}
