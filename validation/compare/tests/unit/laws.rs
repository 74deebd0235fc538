//! Tests of the recorded rows of the laws (`validation/compare/laws`): their scenes are those of today, the laws hold, a row comes out bitwise equal.

use super::results::LEADING;
use super::{LAWS, Law, LawResult, Row, Values, run_cases};
use crate::study::RunCache;

/// Rows of each law as last recorded: the `rows.csv` of `makadam laws`.
const RECORDED: [&str; 4] = [
    include_str!("../../laws/janssen.csv"),
    include_str!("../../laws/beverloo.csv"),
    include_str!("../../laws/collapse.csv"),
    include_str!("../../laws/chute.csv"),
];

/// Every law with its recorded rows, tested as if they were measured now.
pub(crate) fn recorded() -> Vec<(&'static Law, LawResult)> {
    LAWS.iter().zip(RECORDED).map(|(law, text)| (law, LawResult::new(law, rows(text)))).collect()
}

/// Reads rows of a file; the columns behind the first seven are values, empty where a case has no such value.
fn rows(text: &str) -> Vec<Row> {
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let names = reader.headers().expect("recorded rows have a head").clone();
    let read = |record: csv::StringRecord| {
        let cell = |name: &str| {
            let place = names.iter().position(|known| known == name).expect("a column of recorded rows");
            record.get(place).expect("all rows are as long")
        };
        let number = |name: &str| cell(name).parse::<f64>().expect("a number");
        let values = names.iter().zip(&record).skip(LEADING.len());
        Row {
            case: cell("case").into(),
            seed: number("seed") as u64,
            values: values
                .filter(|(_, value)| !value.is_empty())
                .map(|(name, value)| (name.to_string(), value.parse().expect("a number")))
                .collect::<Values>(),
            scene_hash: cell("scene_hash").into(),
            makadam: cell("makadam").into(),
            grains: number("grains") as usize,
            steps: number("steps") as u64,
            wall_seconds: number("wall_seconds"),
        }
    };
    reader.records().map(|record| read(record.expect("a whole row"))).collect()
}

#[test]
fn what_is_recorded_is_of_the_scenes_that_would_be_run_now() {
    for (law, result) in recorded() {
        let found: Vec<(&str, &str)> =
            result.rows.iter().map(|row| (row.case.as_str(), row.scene_hash.as_str())).collect();
        let cases = (law.cases)(false);
        let wanted = cases.iter().map(|case| (case.name.as_str(), case.hash()));
        // One row a seed, the same number for every case.
        let seeds = found.len() / cases.len();
        for ((name, hash), rows) in wanted.zip(found.chunks(seeds)) {
            assert_eq!(rows, vec![(name, hash.as_str()); seeds], "run `makadam laws {}` again", law.name);
        }
        assert_eq!(found.len(), seeds * cases.len(), "{}", law.name);
    }
}

#[test]
fn the_recorded_laws_hold() {
    for (law, result) in recorded() {
        assert!(result.holds, "{}: {:?}", law.name, result.findings);
    }
}

#[test]
fn a_recorded_row_comes_out_with_the_same_bits_again() {
    let (law, result) = recorded().into_iter().find(|(law, _)| law.name == "collapse").unwrap();
    let cases: Vec<_> = (law.cases)(false).into_iter().filter(|case| case.name == "collapse-0.5-r8").collect();
    let folder = tempfile::tempdir().unwrap();
    let rows = run_cases(law, &cases, &[1], &RunCache::open(folder.path(), true).unwrap(), &|_| ()).unwrap();
    let row = result.rows.iter().find(|row| row.case == "collapse-0.5-r8").unwrap();
    assert_eq!((&rows[0].values, rows[0].steps, rows[0].grains), (&row.values, row.steps, row.grains));
}
