//! Distances between two samples.

/// Two-sample Kolmogorov-Smirnov statistic: the largest difference of the cumulative shares, 0 to 1.
///
/// NaN if a sample is empty.
pub fn kolmogorov_smirnov(first: &[f64], second: &[f64]) -> f64 {
    match first.is_empty() || second.is_empty() {
        true => f64::NAN,
        false => steps(first, second).map(|(_, gap)| gap).fold(0.0, f64::max),
    }
}

/// Wasserstein-1 (earth mover's) distance: the area between the cumulative shares, in the unit of the values.
///
/// NaN if a sample is empty.
pub fn wasserstein(first: &[f64], second: &[f64]) -> f64 {
    match first.is_empty() || second.is_empty() {
        true => f64::NAN,
        false => steps(first, second).map(|(width, gap)| width * gap).sum(),
    }
}

/// Walks through the values of both samples in order: the way to the next value, and the difference of the
/// cumulative shares on that way.
fn steps(first: &[f64], second: &[f64]) -> impl Iterator<Item = (f64, f64)> {
    let share = |sample: &[f64], sign: f64| {
        let weight = sign / sample.len() as f64;
        sample.iter().map(move |value| (*value, weight)).collect::<Vec<_>>()
    };
    let mut values = share(first, 1.0);
    values.extend(share(second, -1.0));
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut sum, mut index) = (0.0, 0);
    std::iter::from_fn(move || {
        let here = values.get(index)?.0;
        // Equal values count at once: between them there is no way.
        while let Some((_, weight)) = values.get(index).filter(|(value, _)| *value == here) {
            sum += weight;
            index += 1;
        }
        let width = values.get(index).map_or(0.0, |(next, _)| next - here);
        Some((width, f64::abs(sum)))
    })
}
