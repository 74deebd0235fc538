//! Files by other writers (`tests/files`) are read with their right values, or refused by name.

use super::*;
use std::collections::BTreeMap;

/// Numbers of a grain in `values.csv`: type, x, y, z, radius, velocity, angular velocity.
type Grain = [f64; 11];

/// Columns of `values.csv` behind the id.
const COLUMNS: [Column; 11] = [
    Column::Kind,
    Column::Position(0),
    Column::Position(1),
    Column::Position(2),
    Column::Radius,
    Column::Velocity(0),
    Column::Velocity(1),
    Column::Velocity(2),
    Column::Spin(0),
    Column::Spin(1),
    Column::Spin(2),
];

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/files")
}

/// Right values: grains by id, of each frame.
fn values() -> Vec<BTreeMap<i64, Grain>> {
    let mut frames = vec![BTreeMap::new(), BTreeMap::new()];
    let mut reader = csv::Reader::from_path(folder().join("values.csv")).unwrap();
    for record in reader.deserialize() {
        let row: Vec<f64> = record.unwrap();
        frames[row[0] as usize].insert(row[1] as i64, row[2..].try_into().unwrap());
    }
    frames
}

/// One file of `files.csv`.
#[derive(serde::Deserialize)]
struct Entry {
    file: String,
    frames: String,
    states: String,
    times: String,
}

fn entries() -> Vec<Entry> {
    let mut reader = csv::Reader::from_path(folder().join("files.csv")).unwrap();
    reader.deserialize().map(Result::unwrap).collect()
}

fn read_file(name: &str, columns: &StatedColumns) -> Result<Vec<FrameTable>, ImportError> {
    let path = folder().join(name);
    parse(&path, std::fs::read(&path).unwrap(), columns)
}

/// Compares a frame with the right values in each column that the file states.
fn compare(name: &str, states: &[&str], frame: &FrameTable, values: &BTreeMap<i64, Grain>) {
    let places: Vec<Option<Column>> = frame.columns.iter().map(|column| column_of(column)).collect();
    let of = |column: Column| places.iter().position(|known| *known == Some(column));
    let from_zero = states.iter().any(|state| state.ends_with("-0"));
    let stated = |state: &str| states.iter().any(|known| known.trim_end_matches("-0") == state);
    assert_eq!(frame.rows().count(), values.len(), "{name}");
    for (row, cells) in frame.rows().enumerate() {
        assert_eq!(of(Column::Id).is_some(), stated("id"), "{name}: {:?}", frame.columns);
        let id = of(Column::Id).map_or(row as i64 + 1, |place| cells[place] as i64 + i64::from(from_zero));
        let right = values[&id];
        for (column, right) in COLUMNS.into_iter().zip(right) {
            let is_stated = match column {
                Column::Kind => stated("type"),
                Column::Radius => stated("radius"),
                Column::Velocity(_) => stated("v"),
                Column::Spin(_) => stated("w"),
                _ => true,
            };
            let diameter = || Some((of(Column::Diameter).filter(|_| column == Column::Radius)?, 0.5));
            let place = of(column).map(|place| (place, 1.0)).or_else(diameter);
            assert_eq!(place.is_some(), is_stated, "{name}: {column:?} among {:?}", frame.columns);
            let Some((place, factor)) = place else { continue };
            let right = right - f64::from(u8::from(column == Column::Kind && from_zero));
            let found = factor * cells[place];
            assert!((found - right).abs() <= 2e-6 * right.abs().max(1e-3), "{name}: {column:?} {found} for {right}");
        }
    }
}

#[test]
fn files_by_other_writers_have_their_right_values() {
    let values = values();
    let mut read = 0;
    for Entry { file, frames, states, times } in entries() {
        let listed: Vec<&str> = states.split_whitespace().collect();
        if frames.starts_with("contacts ") {
            continue;
        }
        let found = read_file(&file, &StatedColumns::default());
        if let Some(words) = frames.strip_prefix("refused: ") {
            let error = match found
                .and_then(|frames| assembled(&packing().0, &Tables { grains: frames, ..Tables::default() }))
            {
                Ok(_) => panic!("{file} is read"),
                Err(error) => error,
            };
            assert!(error.problem.starts_with(words) || error.problem.contains(words), "{file}: {error}");
            continue;
        }
        let found = found.unwrap_or_else(|error| panic!("{error}"));
        let wanted: Vec<usize> = frames.split_whitespace().map(|frame| frame.parse().unwrap()).collect();
        assert_eq!(found.len(), wanted.len(), "{file}");
        let times: Vec<f64> = times.split_whitespace().map(|time| time.parse().unwrap()).collect();
        assert_eq!(found.iter().filter_map(|frame| frame.time).collect::<Vec<_>>(), times, "{file}");
        let still = file.starts_with("hdf-still");
        for (place, (frame, wanted)) in found.iter().zip(wanted).enumerate() {
            compare(&file, &listed, frame, &values[wanted]);
            assert!(!still || place == wanted || frame.values == found[0].values, "{file}");
        }
        read += 1;
    }
    assert!(read > 45, "{read}");
}

/// Forces of the one contact of the state, as LIGGGHTS writes them in columns that it only numbers.
#[test]
fn numbered_columns_are_refused_with_the_option_that_names_them() {
    let (mut scene, _) = packing();
    scene.domain = serde_json::from_value(
        serde_json::json!({ "min": [-0.1, -0.1, -0.1], "max": [0.1, 0.1, 0.1], "periodic": ["x"] }),
    )
    .unwrap();
    let grains = read_file("liggghts.dump", &StatedColumns::default()).unwrap();
    let mut forces = Vec::new();
    for Entry { file, frames, .. } in entries() {
        let Some(option) = frames.strip_prefix("contacts ") else { continue };
        let contacts = |columns: &StatedColumns| {
            let contacts = read_file(&file, columns)?;
            assembled(&scene, &Tables { grains: grains.clone(), contacts, ..Tables::default() })
        };
        let error = contacts(&StatedColumns::default()).unwrap_err().to_string();
        assert!(error.contains(&format!("--contact-columns {option} (compute pair/gran/local ")), "{error}");
        let found = contacts(&option.parse().unwrap()).unwrap();
        let [contact] = &found.recording.frames[0].contacts[..] else { panic!("{file}") };
        assert_eq!((contact.first, contact.second), (0, Partner::Grain(1)), "{file}");
        forces.push(contact.force_on_partner());
    }
    assert_eq!(forces.len(), 2);
    assert!((forces[0] - forces[1]).norm() < 1e-5 * forces[0].norm() && forces[0].norm() > 1e-5, "{forces:?}");
}
