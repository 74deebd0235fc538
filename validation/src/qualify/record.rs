//! The tests that a qualification makes, on record: one that is lost would make it pass more easily.

use crate::report::TestOnRecord;

/// Each test with its margin and its seeds; a test is taken off, made wider or given fewer seeds here or not at all.
const RECORD: &str = include_str!("tests.csv");

/// The tests on record.
pub fn on_record() -> Vec<TestOnRecord> {
    let mut table = csv::Reader::from_reader(RECORD.as_bytes());
    table.deserialize().collect::<Result<_, _>>().expect("a test holds the record to its form")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_record_names_each_test_once() {
        let all = on_record();
        assert_eq!(all.len(), 28);
        let names: Vec<String> = all.iter().map(ToString::to_string).collect();
        assert!((1..all.len()).all(|place| !names[..place].contains(&names[place])));
        assert!(all.iter().all(|test| test.margin.is_some_and(|margin| margin > 0.0) && test.seeds >= 8));
    }
}
