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

/// The plot and its caption; none if no code has forces.
pub(super) fn figure(comparison: &Comparison) -> Option<(String, String)> {
    let positive = |d: &ForceDistribution| {
        d.force
            .iter()
            .copied()
            .zip(d.density.iter().copied())
            .filter(|&(f, p)| f.is_finite() && p.is_finite() && p > 0.0)
            .collect::<Vec<_>>()
    };
    let all: Vec<(&ForceDistribution, Vec<(f64, f64)>)> =
        comparison.forces.iter().map(|d| (d, positive(d))).filter(|(_, points)| !points.is_empty()).collect();
    if all.is_empty() {
        return None;
    }
    let points = || all.iter().flat_map(|(_, points)| points.iter());
    // Beyond eight mean forces there are a handful of contacts in a scene.
    let right = points().map(|p| p.0).fold(1.0, f64::max).clamp(1.0, 8.0);
    let shown = || points().filter(move |p| p.0 <= right);
    let low = shown().map(|p| p.1).fold(0.1, f64::min).max(1e-5);
    let high = shown().map(|p| p.1).fold(1.0, f64::max);
    let mut plot = Plot::new(
        Axis::linear("normal force over its mean, f", 0.0, right),
        Axis::logarithmic("probability density P(f)", low, high),
    );
    plot.curve(
        "literature",
        (0..=200).map(|k| {
            let f = right * k as f64 / 200.0;
            [f, mueth(f)]
        }),
    );
    for (distribution, points) in &all {
        let style = names::code_style(&distribution.code);
        let error = format!("{} error", style.class);
        plot.curve(&format!("{} curve thin", style.class), points.iter().map(|&(f, p)| [f, p]));
        let half_bin = half_width(&distribution.force);
        for &(force, density) in points {
            // Counting error: the bin holds density x width x samples forces.
            let held = density * 2.0 * half_bin * distribution.samples as f64;
            if held > 0.0 {
                let relative = 1.0 / held.sqrt();
                plot.error_bar(&error, force, density * (1.0 - relative).max(1e-12), density * (1.0 + relative));
            }
        }
    }
    for (distribution, points) in &all {
        let style = names::code_style(&distribution.code);
        points.iter().for_each(|&(force, density)| plot.marker(style, force, density, 3.2));
    }
    let mut keys: Vec<Key<'_>> = all.iter().map(|(d, _)| Key::Code(&d.code)).collect();
    keys.push(Key::Line("literature", "Mueth 1998"));
    plot.legend(&keys);
    let samples: Vec<String> = all.iter().map(|(d, _)| format!("{} {}", d.code, count(d.samples))).collect();
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
