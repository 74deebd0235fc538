//! Which settings are worth their time.

use super::front::pareto_front;
use super::rows::{Bound, Fastest, Point, Varied};
use crate::statistics::median;

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
    let pace = |point: &Point| point.wall_seconds_per_simulated_second;
    for point in points {
        let group = |other: &Point| other.code == point.code && other.stiffness_factor == point.stiffness_factor;
        if rows.iter().any(|row| row.code == point.code && row.stiffness_factor == point.stiffness_factor) {
            continue;
        }
        let within = points.iter().filter(|other| group(other) && other.within_bounds == Some(true));
        let best = within.min_by(|a, b| pace(a).total_cmp(&pace(b)));
        rows.push(Fastest {
            code: point.code.clone(),
            stiffness_factor: point.stiffness_factor,
            youngs_modulus: point.youngs_modulus,
            setting: best.map(|best| best.setting.clone()),
            wall_seconds_per_simulated_second: best.map(pace),
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

/// What each variation of the solver comes to, in the order of the plan, against settings that vary step and sweeps alone.
pub(super) fn variations(points: &[Point]) -> Vec<Varied> {
    let own = || points.iter().filter(|point| point.code == "Makadam" && point.stiffness_factor == 1.0);
    let best = |variation: Option<&str>| {
        let settings = own().filter(|point| point.variation.as_deref() == variation);
        let within = settings.filter(|point| point.within_bounds == Some(true));
        within.min_by(|a, b| a.wall_seconds_per_simulated_second.total_cmp(&b.wall_seconds_per_simulated_second))
    };
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
