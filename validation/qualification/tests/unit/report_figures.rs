//! Unit tests of `src/report/figures.rs`.

use super::mueth;

#[test]
fn literature_curve_is_a_density_of_mean_one() {
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
