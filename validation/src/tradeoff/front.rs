//! Pareto fronts: settings that nothing beats in both time and error.

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
