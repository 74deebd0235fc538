//! Ranking of settings: Pareto fronts, the fastest settings within the bounds, and the effect of chance on that choice.

use super::rows::{Bound, Fastest, Point, Varied};
use makadam_measure::statistics::median;
use rand_chacha::ChaCha8Rng;
use rand_core::{RngCore, SeedableRng};
use std::collections::{BTreeMap, BTreeSet};

/// Marks the Pareto front of every code and observable at every stiffness. The reference is no point of it: its error
/// is zero by definition.
pub(super) fn mark_fronts(points: &mut [Point], names: &[(String, String)]) {
    let mut groups: Vec<(String, f64)> = Vec::new();
    for point in points.iter() {
        let group = (point.code.clone(), point.stiffness_factor);
        if !groups.contains(&group) {
            groups.push(group);
        }
    }
    for (code, factor) in groups {
        for (name, _) in names {
            let members: Vec<usize> = (0..points.len())
                .filter(|&place| {
                    let point = &points[place];
                    point.code == code
                        && point.stiffness_factor == factor
                        && !point.reference
                        && !point.failed
                        && point.deviation(name).is_some()
                })
                .collect();
            let deviation = |place: usize| points[place].deviation(name);
            // Seed noise: the smallest error that can be told from none.
            let noises: Vec<f64> =
                members.iter().filter_map(|&place| deviation(place)?.deviation_standard_error).collect();
            let floor = if noises.is_empty() { 0.0 } else { median(noises) };
            let coordinates: Vec<[f64; 2]> = members
                .iter()
                .map(|&place| {
                    let error = deviation(place).map_or(f64::NAN, |deviation| deviation.deviation.abs());
                    [points[place].wall_seconds_per_simulated_second, error]
                })
                .collect();
            for place in pareto_front(&coordinates, floor) {
                let point = &mut points[members[place]];
                point.deviations.iter_mut().filter(|d| d.observable == *name).for_each(|d| d.on_front = true);
            }
        }
    }
}

/// The fastest setting within all bounds, by stiffness and code in the order of the plan.
pub(super) fn fastest(points: &[Point], bounds: &[Bound]) -> Vec<Fastest> {
    let mut rows: Vec<Fastest> = Vec::new();
    if bounds.is_empty() {
        return rows;
    }
    for point in points {
        if rows.iter().any(|row| row.code == point.code && row.stiffness_factor == point.stiffness_factor) {
            continue;
        }
        let group = |other: &&Point| other.code == point.code && other.stiffness_factor == point.stiffness_factor;
        let best = fastest_within(points.iter().filter(group));
        rows.push(Fastest {
            code: point.code.clone(),
            stiffness_factor: point.stiffness_factor,
            youngs_modulus: point.youngs_modulus,
            setting: best.map(|best| best.setting.clone()),
            wall_seconds_per_simulated_second: best.map(|best| best.wall_seconds_per_simulated_second),
            intervals_within_bounds: best.and_then(|best| best.intervals_within_bounds),
            ratio_to_makadam: None,
            ratio_low: None,
            ratio_high: None,
        });
    }
    for place in 0..rows.len() {
        let own = rows[place].stiffness_factor;
        let makadam = rows.iter().find(|row| row.code == "Makadam" && row.stiffness_factor == own);
        let wall = makadam.and_then(|row| row.wall_seconds_per_simulated_second);
        rows[place].ratio_to_makadam =
            rows[place].wall_seconds_per_simulated_second.zip(wall).map(|(own, makadam)| own / makadam);
    }
    rows.sort_by(|a, b| a.stiffness_factor.total_cmp(&b.stiffness_factor));
    rows
}

/// The fastest of some points that keep all bounds.
fn fastest_within<'a>(points: impl Iterator<Item = &'a Point>) -> Option<&'a Point> {
    let pace = |point: &Point| point.wall_seconds_per_simulated_second;
    points.filter(|point| point.within_bounds == Some(true)).min_by(|a, b| pace(a).total_cmp(&pace(b)))
}

/// The best setting of each variation of the solver, in the order of the plan, over the best that varies step and sweeps alone.
pub(super) fn variations(points: &[Point]) -> Vec<Varied> {
    let own = || points.iter().filter(|point| point.code == "Makadam" && point.stiffness_factor == 1.0);
    let best = |variation: Option<&str>| fastest_within(own().filter(|point| point.variation.as_deref() == variation));
    let plain = best(None).map(|point| point.wall_seconds_per_simulated_second);
    let mut rows: Vec<Varied> = Vec::new();
    for variation in own().filter_map(|point| point.variation.as_deref()) {
        if rows.iter().any(|row| row.variation == variation) {
            continue;
        }
        let best = best(Some(variation));
        let wall = best.map(|best| best.wall_seconds_per_simulated_second);
        rows.push(Varied {
            variation: variation.into(),
            settings: own().filter(|point| point.variation.as_deref() == Some(variation)).count(),
            setting: best.map(|best| best.setting.clone()),
            wall_seconds_per_simulated_second: wall,
            intervals_within_bounds: best.and_then(|best| best.intervals_within_bounds),
            ratio_to_plain: wall.zip(plain).map(|(wall, plain)| wall / plain),
        });
    }
    rows
}

/// Places of the points that no other one beats, from the cheapest to the most accurate.
///
/// A point is its wall time and its error. Errors below `floor`, the error of the reference itself, cannot be told
/// apart and count as equal to it: the cheapest of them ends the front, not the luckiest.
pub fn pareto_front(points: &[[f64; 2]], floor: f64) -> Vec<usize> {
    let error = |place: &usize| points[*place][1].max(floor);
    let mut order: Vec<usize> =
        (0..points.len()).filter(|&place| points[place].iter().all(|x| x.is_finite())).collect();
    order.sort_by(|a, b| points[*a][0].total_cmp(&points[*b][0]).then(error(a).total_cmp(&error(b))));
    let mut least = f64::INFINITY;
    order.retain(|place| {
        let better = error(place) < least;
        least = least.min(error(place));
        better
    });
    order
}

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
    /// True if the mean deviations over a sample of seeds keep their bounds.
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
