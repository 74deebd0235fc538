//! Statistics against closed forms, tables and values worked out by hand.

use approx::assert_abs_diff_eq;
use makadam_measure::statistics::Outcome;
use makadam_measure::statistics::{
    CONFIDENCE, Ensemble, block_average, confidence_of_each, equivalence, gini, prediction_interval, second_moment,
    seeds_needed, share_below_mean, student_quantile, weak_load_share,
};

fn ensemble(values: &[f64]) -> Ensemble {
    Ensemble::of(values).expect("values")
}

#[test]
fn student_quantiles_match_the_tables() {
    for (freedom, at95, at975) in
        [(1.0, 6.3138, 12.7062), (2.0, 2.9200, 4.3027), (4.0, 2.1318, 2.7764), (10.0, 1.8125, 2.2281)]
    {
        assert_abs_diff_eq!(student_quantile(0.95, freedom), at95, epsilon = 1e-4);
        assert_abs_diff_eq!(student_quantile(0.975, freedom), at975, epsilon = 1e-4);
    }
}

#[test]
fn ensemble_of_five() {
    // Mean 3, standard deviation sqrt(2.5); the 90% half width is 2.1318 sqrt(2.5 / 5).
    let five = ensemble(&[1.0, 2.0, 3.0, 4.0, 5.0]);
    assert_abs_diff_eq!(five.mean, 3.0, epsilon = 1e-15);
    assert_abs_diff_eq!(five.standard_deviation, 2.5_f64.sqrt(), epsilon = 1e-15);
    let [low, high] = five.interval90().expect("five seeds");
    assert_abs_diff_eq!(high - low, 2.0 * 2.131_847 * 0.5_f64.sqrt(), epsilon = 1e-5);
    assert_eq!(ensemble(&[2.0]).interval90(), None);
    assert_eq!(Ensemble::of(&[]), None);
}

#[test]
fn blocks_see_through_correlation() {
    // Forty values in five steps of eight: as frames they seem many, as blocks they are five.
    let values: Vec<f64> = (0..40).map(|n| f64::from(n / 8)).collect();
    let average = block_average(&values);
    assert_abs_diff_eq!(average.mean, 2.0, epsilon = 1e-15);
    assert_abs_diff_eq!(average.standard_error.expect("blocks"), (2.5_f64 / 5.0).sqrt(), epsilon = 1e-12);
    assert_eq!(block_average(&[1.0]).standard_error, None);
    assert_eq!(block_average(&[1.0; 7]).standard_error, None);
    assert_eq!(block_average(&[1.0; 8]).standard_error, Some(0.0));
}

#[test]
fn welch_interval_by_hand() {
    // s1^2/n1 = 1/3, s2^2/n2 = 4/3; difference -1; freedom = (5/3)^2 / ((1/9)/2 + (16/9)/2) = 50/17.
    let verdict = equivalence(&ensemble(&[1.0, 2.0, 3.0]), &ensemble(&[1.0, 3.0, 5.0]), None, 2);
    assert_abs_diff_eq!(verdict.difference, -1.0, epsilon = 1e-15);
    let half = student_quantile(0.95, 50.0 / 17.0) * (5.0_f64 / 3.0).sqrt();
    let [low, high] = verdict.interval90.expect("three seeds each");
    assert_abs_diff_eq!(low, -1.0 - half, epsilon = 1e-9);
    assert_abs_diff_eq!(high, -1.0 + half, epsilon = 1e-9);
    assert_eq!(verdict.interval_of_verdict, verdict.interval90);
    assert_eq!((verdict.outcome, verdict.seeds_needed), (None, None));
}

#[test]
fn three_outcomes() {
    let here = ensemble(&[1.00, 1.01, 0.99, 1.00]);
    let near = ensemble(&[1.02, 1.01, 1.03, 1.02]);
    let far = ensemble(&[2.00, 2.01, 1.99, 2.00]);
    let wide = ensemble(&[0.7, 1.4, 1.0, 0.9]);
    assert_eq!(equivalence(&here, &near, Some(0.1), 3).outcome, Some(Outcome::Agree));
    assert_eq!(equivalence(&here, &far, Some(0.1), 3).outcome, Some(Outcome::Disagree));
    assert_eq!(equivalence(&far, &here, Some(0.1), 3).outcome, Some(Outcome::Disagree));
    let undecided = equivalence(&here, &wide, Some(0.1), 2);
    assert_eq!(undecided.outcome, Some(Outcome::Undecided));
    let deviation = (0.5 * (here.standard_deviation.powi(2) + wide.standard_deviation.powi(2))).sqrt();
    assert_abs_diff_eq!(undecided.difference, 0.0, epsilon = 1e-12);
    let by_formula = 2.0 * (1.644_854 + 1.644_854_f64).powi(2) * (deviation / 0.1).powi(2);
    assert_eq!(undecided.seeds_needed, Some(by_formula.ceil() as usize));
    // A single seed decides nothing.
    let lone = equivalence(&ensemble(&[1.0]), &here, Some(0.1), 2);
    assert_eq!((lone.outcome, lone.interval90), (Some(Outcome::Undecided), None));
}

#[test]
fn more_codes_widen_the_interval_of_the_verdict() {
    let (a, b) = (ensemble(&[1.0, 2.0, 3.0, 2.0]), ensemble(&[2.0, 3.0, 1.0, 2.5]));
    let [two, three] = [2, 3].map(|codes| equivalence(&a, &b, Some(1.0), codes).interval_of_verdict.expect("seeds"));
    assert!(three[0] < two[0] && three[1] > two[1]);
    let [low, high] = equivalence(&a, &b, Some(1.0), 3).interval90.expect("seeds");
    assert_abs_diff_eq!(low, two[0], epsilon = 1e-12);
    assert_abs_diff_eq!(high, two[1], epsilon = 1e-12);
}

#[test]
fn seeds_by_the_formula() {
    // Equal codes, both sides at 95%: 2 (1.645 + 1.645)^2 = 21.64 for a margin of one standard deviation.
    assert_eq!(seeds_needed(1.0, 0.0, 1.0, 0.05), Some(22));
    assert_eq!(seeds_needed(0.5, 0.0, 1.5, 0.05), Some(3));
    assert_eq!(seeds_needed(0.0, 0.1, 1.5, 0.05), Some(2));
    // Far from equal only the nearer side counts: 2 (1.645 + 1.282)^2 / 0.5^2 = 68.5; the sign does not matter.
    assert_eq!(seeds_needed(1.0, 0.5, 1.0, 0.05), Some(69));
    assert_eq!(seeds_needed(1.0, -0.5, 1.0, 0.05), Some(69));
    // So near to the margin, or beyond it, that no count is honest.
    assert_eq!(seeds_needed(1.0, 0.9, 1.0, 0.05), None);
    assert_eq!(seeds_needed(1.0, -1.2, 1.0, 0.05), None);
    // Equal values without any spread agree, whatever the margin.
    let same = ensemble(&[1.0, 1.0]);
    assert_eq!(equivalence(&same, &same, Some(1e-9), 2).outcome, Some(Outcome::Agree));
}

#[test]
fn exponential_sample() {
    let count = 200_000;
    let values: Vec<f64> = (0..count).map(|n| -(1.0 - (f64::from(n) + 0.5) / f64::from(count)).ln()).collect();
    assert_abs_diff_eq!(share_below_mean(&values), 1.0 - (-1_f64).exp(), epsilon = 1e-4);
    assert_abs_diff_eq!(gini(&values), 0.5, epsilon = 1e-4);
    assert_abs_diff_eq!(second_moment(&values), 2.0, epsilon = 1e-3);
    assert_abs_diff_eq!(weak_load_share(&values), 1.0 - 2.0 * (-1_f64).exp(), epsilon = 1e-4);
}

#[test]
fn gini_of_small_samples() {
    assert_abs_diff_eq!(gini(&[2.0, 2.0, 2.0]), 0.0, epsilon = 1e-15);
    // Half the mean absolute difference over the mean: of 1 and 3, 1/2 * (0 + 2 + 2 + 0)/4 over 2.
    assert_abs_diff_eq!(gini(&[3.0, 1.0]), 0.25, epsilon = 1e-15);
}

#[test]
fn one_more_seed() {
    let recorded = [1.0, 2.0, 3.0, 4.0, 5.0];
    let [low, high] = prediction_interval(&recorded, 1, 0.95).expect("five seeds");
    let half = 2.776_445 * (2.5_f64 * 1.2).sqrt();
    assert_abs_diff_eq!(low, 3.0 - half, epsilon = 1e-5);
    assert_abs_diff_eq!(high, 3.0 + half, epsilon = 1e-5);
    assert_eq!(prediction_interval(&[1.0], 1, 0.99), None);
}

#[test]
fn many_live_values_share_the_confidence() {
    assert_eq!(confidence_of_each(1), CONFIDENCE);
    assert_abs_diff_eq!(confidence_of_each(18), 1.0 - 0.01 / 18.0, epsilon = 1e-15);
    let recorded = [1.0, 2.0, 3.0, 4.0, 5.0];
    let high = |confidence: f64| prediction_interval(&recorded, 1, confidence).expect("seeds")[1];
    assert!(high(CONFIDENCE) < 12.0 && 12.0 < high(confidence_of_each(18)));
}

#[test]
fn a_margin_ends_where_it_says() {
    let (one, other) = (ensemble(&[1.0, 1.1, 1.2, 1.3]), ensemble(&[1.05, 1.1, 1.3]));
    for (first, second) in [(&one, &other), (&other, &one)] {
        let [low, high] = equivalence(first, second, None, 3).interval_of_verdict.unwrap();
        let reach = high.max(-low);
        let outcome = |share: f64| equivalence(first, second, Some(share * reach), 3).outcome;
        assert_eq!(outcome(1.001), Some(Outcome::Agree));
        assert_eq!(outcome(0.999), Some(Outcome::Undecided));
    }
}
