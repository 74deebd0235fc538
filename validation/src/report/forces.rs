//! Distribution of normal forces of all codes on a logarithmic axis, with the curve of the literature.

use crate::compare::Comparison;
use crate::draw::names;
use crate::draw::numbers::count;
use crate::draw::plot::{Axis, Key, Plot};
use crate::observables::ForceDistribution;

/// Probability density of a normal force over its mean after Mueth, Jaeger and Nagel (Phys. Rev. E 57, 3164, 1998):
/// `P(f) = 3 (1 - 0.75 exp(-f^2)) exp(-1.5 f)`.
fn mueth(force: f64) -> f64 {
    3.0 * (1.0 - 0.75 * (-force * force).exp()) * (-1.5 * force).exp()
}

/// Name of the curve of the literature.
const LITERATURE: &str = "Mueth 1998";

/// A point of a curve.
pub(super) struct Point {
    /// Normal force over its mean.
    pub(super) force: f64,
    /// Probability density.
    pub(super) density: f64,
    /// Lower and upper end of the counting error; absent on the curve of the literature.
    pub(super) error: Option<[f64; 2]>,
}

/// What the plot shows: the points of each code with its name, then those of the literature. Nothing if no code has forces.
pub(super) fn curves(comparison: &Comparison) -> Vec<(&str, Vec<Point>)> {
    let of_code = comparison.forces.iter().map(|one| (one.code.as_str(), points(one)));
    let mut curves: Vec<_> = of_code.filter(|(_, points)| !points.is_empty()).collect();
    if !curves.is_empty() {
        let right = right(&curves);
        let literature = (0..=200).map(|k| right * f64::from(k) / 200.0);
        let literature = literature.map(|force| Point { force, density: mueth(force), error: None }).collect();
        curves.push((LITERATURE, literature));
    }
    curves
}

/// The bins that hold forces.
fn points(distribution: &ForceDistribution) -> Vec<Point> {
    let half_bin = half_width(&distribution.force);
    let bins = distribution.force.iter().copied().zip(distribution.density.iter().copied());
    let held = bins.filter(|&(force, density)| force.is_finite() && density.is_finite() && density > 0.0);
    held.map(|(force, density)| {
        // The bin holds density x width x samples forces.
        let held = density * 2.0 * half_bin * distribution.samples as f64;
        let relative = 1.0 / held.sqrt();
        let error = (held > 0.0).then(|| [density * (1.0 - relative).max(1e-12), density * (1.0 + relative)]);
        Point { force, density, error }
    })
    .collect()
}

/// Right end of the axis. Beyond eight mean forces there are a handful of contacts in a scene.
fn right(curves: &[(&str, Vec<Point>)]) -> f64 {
    let forces = curves.iter().flat_map(|(_, points)| points.iter().map(|point| point.force));
    forces.fold(1.0, f64::max).clamp(1.0, 8.0)
}

/// The plot and its caption; none if no code has forces.
pub(super) fn figure(comparison: &Comparison) -> Option<(String, String)> {
    let curves = curves(comparison);
    let (literature, all) = curves.split_last()?;
    let right = right(all);
    let shown = || all.iter().flat_map(|(_, points)| points.iter()).filter(|p| p.force <= right).map(|p| p.density);
    let low = shown().fold(0.1, f64::min).max(1e-5);
    let high = shown().fold(1.0, f64::max);
    let mut keys: Vec<Key<'_>> = all.iter().map(|(code, _)| Key::Code(code)).collect();
    keys.push(Key::Line("literature", LITERATURE));
    let mut plot = Plot::with_legend(
        Axis::linear("normal force over its mean, f", 0.0, right),
        Axis::logarithmic("probability density P(f)", low, high),
        &keys,
    );
    let line = |points: &[Point]| points.iter().map(|point| [point.force, point.density]).collect::<Vec<_>>();
    plot.curve("literature", line(&literature.1).into_iter());
    for (code, points) in all {
        let style = names::code_style(code);
        let error = format!("{} error", style.class);
        plot.curve(&format!("{} curve thin", style.class), line(points).into_iter());
        for point in points {
            if let Some([low, high]) = point.error {
                plot.error_bar(&error, point.force, low, high);
            }
        }
    }
    for (code, points) in all {
        let style = names::code_style(code);
        points.iter().for_each(|point| plot.marker(style, point.force, point.density, 3.2));
    }
    let counted = comparison.forces.iter().filter(|one| all.iter().any(|(code, _)| *code == one.code));
    let samples: Vec<String> = counted.map(|one| format!("{} {}", one.code, count(one.samples))).collect();
    let caption = format!(
        "Distribution of normal forces over their mean. The codes should lie on one curve, flat below the mean and \
         exponential above it; the grey curve is the fit of Mueth et al. (1998) to forces at the walls of a packing of \
         glass beads, P(f) = 3 (1 − 0.75 exp(−f²)) exp(−1.5 f). Bars are the counting error of a bin, a lower bound, \
         since forces of one packing and of successive frames are correlated. Forces counted: {}.",
        super::qualification::join(&samples)
    );
    Some((plot.finish("distribution of normal forces"), caption))
}

/// Half the distance between the centres of two bins.
fn half_width(centres: &[f64]) -> f64 {
    match centres {
        [first, second, ..] => (second - first).abs() / 2.0,
        _ => 0.5,
    }
}

#[cfg(test)]
mod tests {
    use super::mueth;

    #[test]
    fn the_literature_curve_is_a_density_of_mean_one() {
        let step = 1e-3;
        let (mut total, mut mean) = (0.0, 0.0);
        for k in 0..40_000 {
            let f = (k as f64 + 0.5) * step;
            total += mueth(f) * step;
            mean += f * mueth(f) * step;
        }
        // The published coefficients are rounded: both come to one within 4%.
        assert!((total - 1.0).abs() < 0.04, "{total}");
        assert!((mean - 1.0).abs() < 0.04, "{mean}");
    }
}
