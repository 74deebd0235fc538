//! Validation statistics for given values.

use crate::convert::plain;
use crate::errors::exception;
use makadam_measure::statistics;
use pyo3::prelude::*;
use pyo3::types::PyDict;

fn sound(py: Python<'_>, what: &str, values: &[f64], least: usize) -> PyResult<()> {
    let problem = if values.len() < least {
        format!("{what} are {}; give at least {least}", values.len())
    } else if values.iter().any(|value| !value.is_finite()) {
        format!("{what} are not all finite")
    } else {
        return Ok(());
    };
    Err(exception(py, "JudgeError", &problem))
}

/// Mean of consecutive values of one run, and its standard error over blocks of time (method of batch means): a pair with None as
/// second entry for fewer than 8 values.
#[pyfunction]
pub fn block_average(py: Python<'_>, values: Vec<f64>) -> PyResult<(f64, Option<f64>)> {
    sound(py, "the values", &values, 1)?;
    let average = statistics::block_average(&values);
    Ok((average.mean, average.standard_error))
}

/// Mean and spread of one value per seed: a dict of `seeds`, `mean`, `standard_deviation` (n - 1 in the denominator) and `interval90`, the
/// 90% interval of the mean by Student's t, None for a single seed.
#[pyfunction]
pub fn ensemble(py: Python<'_>, values: Vec<f64>) -> PyResult<Bound<'_, PyAny>> {
    sound(py, "the values", &values, 1)?;
    let Some(found) = statistics::Ensemble::of(&values) else {
        return Err(exception(py, "JudgeError", "there are no values"));
    };
    let dict = plain(py, &found)?;
    dict.set_item("interval90", found.interval90().map(<(f64, f64)>::from))?;
    Ok(dict)
}

/// Tests the equivalence of two ensembles: two one-sided tests on the difference of their means (Welch; Schuirmann 1987).
///
/// Args:
///     first: One value per seed.
///     second: One value per seed of the compared ensemble.
///     margin: Margin of equivalence, in the unit of the values; without one there is no verdict.
///     codes: Total number of compared codes, which divides the significance.
///
/// Returns:
///     A dict of `difference` of the means, `interval90`, `interval_of_verdict`, `outcome` (`agree`, `disagree`, `undecided`, or None without
///     a margin) and `seeds_needed`.
#[pyfunction]
#[pyo3(signature = (first, second, margin=None, codes=2))]
pub fn equivalence(
    py: Python<'_>,
    first: Vec<f64>,
    second: Vec<f64>,
    margin: Option<f64>,
    codes: usize,
) -> PyResult<Bound<'_, PyDict>> {
    sound(py, "the first values", &first, 1)?;
    sound(py, "the second values", &second, 1)?;
    if margin.is_some_and(|margin| margin.is_nan() || margin <= 0.0) {
        return Err(exception(py, "JudgeError", "the margin is no number above 0"));
    }
    let (Some(one), Some(other)) = (statistics::Ensemble::of(&first), statistics::Ensemble::of(&second)) else {
        return Err(exception(py, "JudgeError", "there are no values"));
    };
    let found = statistics::equivalence(&one, &other, margin, codes);
    let dict = PyDict::new(py);
    dict.set_item("difference", found.difference)?;
    dict.set_item("interval90", found.interval90.map(<(f64, f64)>::from))?;
    dict.set_item("interval_of_verdict", found.interval_of_verdict.map(<(f64, f64)>::from))?;
    dict.set_item("outcome", plain(py, &found.outcome)?)?;
    dict.set_item("seeds_needed", found.seeds_needed)?;
    Ok(dict)
}
