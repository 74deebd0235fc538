//! The tests that a qualification makes, on record: one that is lost would make it pass more easily.

use crate::report::TestName;

/// Scene, observable and reference code of each test; a test is taken off here or not at all.
const RECORD: &str = include_str!("tests.csv");

/// The tests on record.
pub fn on_record() -> Vec<TestName> {
    let mut table = csv::Reader::from_reader(RECORD.as_bytes());
    table.deserialize().collect::<Result<_, _>>().expect("a test holds the record to its form")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_record_names_each_test_once() {
        let all = on_record();
        assert_eq!(all.len(), 26);
        assert!((1..all.len()).all(|place| !all[..place].contains(&all[place])));
    }
}
