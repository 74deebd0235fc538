//! Unit tests of `src/draw/numbers.rs`.

use super::*;

#[test]
fn digits_follow_the_size() {
    assert_eq!(two_digits(0.0917), "0.092");
    assert_eq!(two_digits(3.12), "3.1");
    assert_eq!(two_digits(9.96), "10.0");
    assert_eq!(two_digits(234.4), "234");
    assert_eq!(compact(5e-4), "5×10⁻⁴");
    assert_eq!(compact(0.006), "0.006");
    assert_eq!(compact(1.5), "1.5");
    assert_eq!(count(439_339), "439\u{202f}339");
    assert_eq!(duration(200.0), "3 min 20 s");
}

#[test]
fn values_are_rounded_by_their_error() {
    assert_eq!(with_error(31.6741, 0.3812), "31.67 ± 0.38");
    assert_eq!(with_error(0.59604, 0.0996), "0.60 ± 0.10");
    assert_eq!(with_error(1234.5678, 23.4), "1235 ± 23");
    assert_eq!(with_error(-0.5, 1.26), "-0.5 ± 1.3");
    assert_eq!(with_error(3.14159e-6, 2.5e-8), "(3.142 ± 0.025)e-6");
    assert_eq!(with_error(2.0, 0.0), "2 ± 0");
    assert_eq!(with_error(1.000000000000015, 9.2e-15), "1 ± 9.2×10⁻¹⁵");
    assert_eq!(with_error(0.312345, 1.5e-5), "0.312345 ± 0.000015");
}

#[test]
fn a_difference_that_rounds_to_zero_has_no_sign() {
    let rounding = Rounding::Decimals(2);
    assert_eq!(rounding.signed(-0.001), "0.00");
    assert_eq!(rounding.signed(-0.31), "−0.31");
    assert_eq!(rounding.signed(0.31), "+0.31");
    assert_eq!(Rounding::PowerOfTen(-5).signed(-3.1e-5), "−3.10");
    assert_eq!(Rounding::PowerOfTen(-5).factor(), "10⁻⁵");
    assert_eq!(Rounding::PowerOfTen(-5).margin(1e-6), "±0.1");
}

#[test]
fn ticks_are_round() {
    let (ticks, digits) = round_ticks(24.3, 31.2, 5);
    assert_eq!(ticks, [26.0, 28.0, 30.0]);
    assert_eq!(digits, 0);
    let (ticks, digits) = round_ticks(0.0, 1.0, 4);
    assert_eq!(ticks, [0.0, 0.25, 0.5, 0.75, 1.0]);
    assert_eq!(digits, 2);
}
