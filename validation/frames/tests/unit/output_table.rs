//! Unit tests of `src/output/table.rs`.

use super::*;

fn row(values: &[(&str, f64)]) -> Vec<(String, f64)> {
    values.iter().map(|(name, value)| (name.to_string(), *value)).collect()
}

#[test]
fn late_columns_leave_earlier_rows_empty() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.csv");
    let mut table = TimeTable::create(&path, &["time"]).unwrap();
    table.push(row(&[("time", 0.0)])).unwrap();
    table.push(row(&[("time", 0.5), ("angle", 31.0)])).unwrap();
    table.push(row(&[("time", 1.0), ("angle", 30.0)])).unwrap();
    assert_eq!(std::fs::read_to_string(path).unwrap(), "time,angle\n0.0,\n0.5,31.0\n1.0,30.0\n");
}

#[test]
fn a_name_with_a_comma_is_one_column() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.csv");
    let mut table = TimeTable::create(&path, &["time"]).unwrap();
    table.push(row(&[("time", 0.0), ("lid, upper_rate", 1.5)])).unwrap();
    table.push(row(&[("time", 0.5), ("late", 2.5)])).unwrap();
    let expected = "time,\"lid, upper_rate\",late\n0.0,1.5,\n0.5,,2.5\n";
    assert_eq!(std::fs::read_to_string(path).unwrap(), expected);
}

#[test]
fn a_table_goes_on_from_before_rows_and_columns_that_came_later() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.csv");
    let mut table = TimeTable::create(&path, &["time"]).unwrap();
    table.push(row(&[("time", 0.0)])).unwrap();
    let (written, before) = (table.written().clone(), std::fs::read(&path).unwrap());
    table.push(row(&[("time", 0.5)])).unwrap();
    drop(TimeTable::go_on(&path, written.clone()).unwrap());
    assert_eq!(std::fs::read(&path).unwrap(), before);
    let mut table = TimeTable::go_on(&path, written.clone()).unwrap();
    table.push(row(&[("time", 0.5), ("angle, mean", 31.0)])).unwrap();
    let mut table = TimeTable::go_on(&path, written.clone()).unwrap();
    assert_eq!(std::fs::read(&path).unwrap(), before);
    table.push(row(&[("time", 0.5), ("angle, mean", 31.0)])).unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "time,\"angle, mean\"\n0.0,\n0.5,31.0\n");

    std::fs::write(&path, "time,angle\n").unwrap();
    let refused = TimeTable::go_on(&path, written.clone()).err().unwrap().to_string();
    assert!(refused.contains("table.csv") && refused.contains("--restart"), "{refused}");
    std::fs::write(&path, "time\n").unwrap();
    assert!(TimeTable::go_on(&path, written).err().unwrap().to_string().contains("5 of 9 bytes"));
}

#[test]
fn an_altered_row_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.csv");
    let mut table = TimeTable::create(&path, &["time"]).unwrap();
    table.push(row(&[("time", 0.25)])).unwrap();
    let written = table.written().clone();
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("0.25", "0.75")).unwrap();
    let message = TimeTable::go_on(&path, written.clone()).err().unwrap().to_string();
    assert!(message.contains("table.csv") && message.contains("rows are others"), "{message}");
    std::fs::write(&path, text).unwrap();
    assert_eq!(*TimeTable::go_on(&path, written.clone()).unwrap().written(), written);
}
