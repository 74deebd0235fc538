//! Formats of files: those of other writers (`tests/files`) have their right values or are refused by name, and damage is refused.

use super::*;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::collections::BTreeMap;
use std::io::Write;

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
fn corpus_has_right_values() {
    let values = values();
    let mut read = 0;
    for Entry { file, frames, states, times } in entries() {
        let listed: Vec<&str> = states.split_whitespace().collect();
        if frames.starts_with("contacts ") {
            continue;
        }
        let found = read_file(&file, &StatedColumns::default());
        if let Some(words) = frames.strip_prefix("refused: ") {
            let grains = |frames| Tables { grains: frames, ..Tables::default() };
            let error = found.and_then(|frames| assembled(&packing().0, &grains(frames))).unwrap_err();
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
    assert!(read > 40, "{read}");
}

/// Forces of the one contact of the state, in columns that LIGGGHTS only numbers.
#[test]
fn numbered_columns_need_names() {
    let (mut scene, _) = packing();
    scene.domain = serde_json::from_value(
        serde_json::json!({ "min": [-0.1, -0.1, -0.1], "max": [0.1, 0.1, 0.1], "periodic": ["x"] }),
    )
    .unwrap();
    let radii = values()[0]
        .values()
        .map(|grain| grain[4])
        .fold([f64::INFINITY, 0.0], |[low, high], radius| [radius.min(low), radius.max(high)]);
    let (mean, spread) = ((radii[0] + radii[1]) / 2.0, (radii[1] - radii[0]) / (radii[1] + radii[0]));
    scene.population[0].radius =
        serde_json::from_value(serde_json::json!({ "kind": "uniform", "mean": mean, "spread": spread + 0.01 }))
            .unwrap();
    let kinds = [("1", "grain"), ("2", "grain")].map(|(kind, name)| (kind.to_string(), name.to_string()));
    let manifest = Manifest { kinds: kinds.into(), ..stated() };
    let grains = read_file("liggghts.dump", &StatedColumns::default()).unwrap();
    let mut forces = Vec::new();
    for Entry { file, frames, .. } in entries() {
        let Some(option) = frames.strip_prefix("contacts ") else { continue };
        let contacts = |columns: &StatedColumns| {
            let contacts = read_file(&file, columns)?;
            assemble(&scene, &manifest, &Tables { grains: grains.clone(), contacts, ..Tables::default() })
        };
        let error = contacts(&StatedColumns::default()).unwrap_err().to_string();
        let (compute, names) = option.split_once(':').unwrap();
        let line = format!("contact-columns.{compute} = [\"{}\"]", names.replace(',', "\", \""));
        assert!(error.contains(&format!("{line}   # where it is compute pair/gran/local ")), "{error}");
        let found = contacts(&option.parse().unwrap()).unwrap();
        let [contact] = &found.frames[0].contacts[..] else { panic!("{file}") };
        assert_eq!((contact.first, contact.second), (0, Partner::Grain(1)), "{file}");
        forces.push(contact.force_on_partner());
    }
    assert_eq!(forces.len(), 2);
    assert!((forces[0] - forces[1]).norm() < 1e-5 * forces[0].norm() && forces[0].norm() > 1e-5, "{forces:?}");
}

#[test]
fn other_formats_are_named() {
    let refused = |bytes: &[u8], words: &str| {
        let error = parse(Path::new("a"), bytes.to_vec(), &StatedColumns::default()).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    };
    refused(b"", "empty");
    refused(b"2\nProperties=species:S:1:pos:R:3\nA 0 0 0\nA 0 0 1\n", "XYZ");
    refused(b"LAMMPS data file via write_data, version 2 Aug 2023\n\n2 atoms\n1 atom types\n", "data file of LAMMPS");
    refused(b"\x28\xb5\x2f\xfd....", "zstd");
    refused(b"{\"frames\": []}", "JSON");
    refused(b"id\0x", "binary");
    assert!(parse(Path::new("a"), b"id,x,y,z\n1,0,0,0\n".to_vec(), &StatedColumns::default()).is_ok());
}

#[test]
fn damaged_gzip_is_refused() {
    let mut packer = GzEncoder::new(Vec::new(), Compression::fast());
    packer.write_all(b"id,x\n1,2\n").unwrap();
    let packed = packer.finish().unwrap();
    let read = |name: &str, bytes: &[u8]| parse(Path::new(name), bytes.to_vec(), &StatedColumns::default());
    assert_eq!(read("a", &packed).unwrap()[0].values, [1.0, 2.0]);
    let error = read("a.gz", &packed[..packed.len() - 6]).unwrap_err().to_string();
    assert!(error.contains("a.gz: line 1: gzip: ") && error.contains("cut off"), "{error}");
}

#[test]
fn dumps_are_in_si_units() {
    let read = |units: &str| {
        let frame = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ATOMS id x y z\n1 0 0 0\n";
        parse(Path::new("a.dump"), format!("{units}{frame}").into_bytes(), &StatedColumns::default())
    };
    let found = read("ITEM: UNITS\nsi\nITEM: TIME\n0.5\n").unwrap();
    assert_eq!((found.len(), found[0].time), (1, Some(0.5)));
    assert_eq!(read("").unwrap().len(), 1, "a dump without units is in SI");
    for units in ["cgs", "lj", "real", "metal", "micro", "SI "] {
        let error = read(&format!("ITEM: UNITS\n{units}\n")).unwrap_err().to_string();
        let wanted =
            format!("a.dump: line 2: the dump is in units '{}'; write the dump in SI units ('units si')", units.trim());
        assert_eq!(error, wanted);
    }
    assert!(read("ITEM: UNITS\nsi\nITEM: UNITS\ncgs\n").unwrap_err().to_string().contains("line 4"));
}

#[test]
fn several_vtk_pieces_are_refused() {
    let piece = |points: &str| {
        let count = points.split_whitespace().count() / 3;
        format!(
            "<Piece NumberOfPoints=\"{count}\" NumberOfCells=\"0\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" \
             format=\"ascii\">{points}</DataArray></Points></Piece>"
        )
    };
    let file = |pieces: &[&str]| {
        let pieces: String = pieces.iter().map(|points| piece(points)).collect();
        let text =
            format!("<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>{pieces}</UnstructuredGrid></VTKFile>");
        parse(Path::new("a.vtu"), text.into_bytes(), &StatedColumns::default())
    };
    assert_eq!(file(&["0 0 0 1 1 1"]).unwrap()[0].rows().count(), 2);
    assert_eq!(file(&["", "0 0 0 1 1 1"]).unwrap()[0].rows().count(), 2, "empty pieces are none");
    let error = file(&["0 0 0", "1 1 1"]).unwrap_err().to_string();
    assert!(error.contains("several pieces") && error.contains("Merge Blocks"), "{error}");
}

#[test]
fn legacy_vtk_fields_are_columns() {
    let file = |arrays: &str| {
        let text = format!(
            "# vtk DataFile Version 5.1\nLIGGGHTS\nASCII\nDATASET POLYDATA\nFIELD FieldData 1\nTIME 1 1 double\n0.5\nPOINTS 2 float\n\
             1 2 3 4 5 6\nMETADATA\nINFORMATION 2\nNAME L2_NORM_RANGE LOCATION vtkDataArray\nDATA 2 0 17\n\nVERTICES 3 2\nOFFSETS \
             vtktypeint64\n0 1 2\nCONNECTIVITY vtktypeint64\n0 1\nPOINT_DATA 2\n{arrays}"
        );
        parse(Path::new("a.vtk"), text.into_bytes(), &StatedColumns::default())
    };
    let two = "FIELD FieldData 2\nradius 1 2 double\n0.5 0.25\nMETADATA\nINFORMATION 0\n\nv 3 2 float\n1 2 3 4 5 6\n";
    let frames = file(two).unwrap();
    let rows: Vec<&[f64]> = frames[0].rows().collect();
    assert_eq!(rows, [[1.0, 2.0, 3.0, 0.5, 1.0, 2.0, 3.0], [4.0, 5.0, 6.0, 0.25, 4.0, 5.0, 6.0]]);
    let columns: Vec<Option<Column>> = frames[0].columns.iter().map(|name| column_of(name)).collect();
    let axes = |of: fn(usize) -> Column| (0..3).map(move |axis| Some(of(axis)));
    let wanted: Vec<_> = axes(Column::Position).chain([Some(Column::Radius)]).chain(axes(Column::Velocity)).collect();
    assert_eq!(columns, wanted);
    let error = file("POINT_DATA 3\n").unwrap_err().to_string();
    assert!(error.contains("data of 3 points, and there are 2"), "{error}");
    for (arrays, words) in [
        ("FIELD FieldData 1\nid 1 2 string\na\nb\n", "id has 2 rows of string"),
        ("FIELD FieldData 1\nradius 1 3 double\n1 2 3\n", "radius has 3 rows of double, and there are 2 points"),
        ("FIELD FieldData many\n", "no number of arrays"),
        ("FIELD FieldData 1\nradius one 2 double\n1 2\n", "'one' is no number of components"),
        ("FIELD FieldData 1\nradius 1 2 double\n1\n", "radius ends before its last number"),
    ] {
        let error = file(arrays).unwrap_err().to_string();
        assert!(error.contains(words), "{words}: {error}");
    }
}

#[test]
fn truncated_legacy_vtk_is_refused() {
    let whole = "# vtk DataFile Version 3.0\nx\nASCII\nDATASET POLYDATA\nPOINTS 2 double\n0 0 0\n0.1 0 0\nPOINT_DATA 2\n\
                 SCALARS radius double 1\nLOOKUP_TABLE default\n0.005\n0.005\nVECTORS v double\n0 0 0\n0 0 2.5\n";
    let read = |text: &str| parse(Path::new("a.vtk"), text.as_bytes().to_vec(), &StatedColumns::default());
    assert_eq!(read(whole).unwrap()[0].values[13], 2.5);
    let error = read(whole.strip_suffix("5\n").unwrap()).unwrap_err().to_string();
    assert!(error.contains("a.vtk: line 15: the last row has no line end"), "{error}");
    let error = read(whole.strip_suffix("2.5\n").unwrap()).unwrap_err().to_string();
    assert!(error.contains("a.vtk: line 15"), "{error}");
}

#[test]
fn dump_columns_by_their_code() {
    let text = dump("id type type x y z radius v_x f_y vx", &["1 2 2 0.1 0.2 0.3 0.005 7 8 9"]);
    let frames = parse(Path::new("a.dump"), text.into_bytes(), &StatedColumns::default()).unwrap();
    assert_eq!(frames[0].columns.join(" "), "id type x y z radius vx");
    assert_eq!(frames[0].values, [1.0, 2.0, 0.1, 0.2, 0.3, 0.005, 9.0]);
}

#[test]
fn rows_without_line_end_are_refused() {
    let dump = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\nITEM: ATOMS id x y z\n1 0 0 5.07";
    for (file, text, line) in [("a.csv", "id,x\n1,0\n2,1.5e", 3), ("a.dump", dump, 10)] {
        let error = tables(&[(file, text.into())], &[]).unwrap_err().to_string();
        assert!(error.starts_with(&format!("{file}: line {line}: the last row has no line end")), "{error}");
    }
    assert!(tables(&[("a.csv", "x,y\r\n1,2\r\n".into())], &[]).is_ok());
}

#[test]
fn yade_text_has_one_format() {
    let text = "#format x_y_z_r\n0 0 0 0.005\n#format r_x_y_z\n0.005 1 0 0\n";
    let error = tables(&[("a.txt", text.into())], &[]).unwrap_err().to_string();
    assert!(error.contains("a.txt: line 3: a second line #format"), "{error}");
}

fn read_csv(text: &str) -> Result<Vec<FrameTable>, String> {
    parse(Path::new("a.csv"), text.as_bytes().to_vec(), &StatedColumns::default()).map_err(|error| error.to_string())
}

#[test]
fn csv_separators() {
    for text in
        ["id,x\n1,0.5\n", "id;x\n1;0.5\n", "id\tx\n1\t0.5\n", "\u{feff}id,x\r\n1,0.5\r\n", "# by hand\nid;x\n1;0.5\n"]
    {
        assert_eq!(read_csv(text).unwrap()[0].values, [1.0, 0.5], "{text}");
    }
    let error = read_csv("id x y\n1 0 0\n").unwrap_err();
    assert!(error.contains("line 1: its columns are separated by spaces"), "{error}");
    let error = read_csv("id;x,y\n1;0,0\n").unwrap_err();
    assert!(error.contains("several of comma, semicolon and tab"), "{error}");
    let error = read_csv("id;x\n1;0,5\n").unwrap_err();
    assert!(error.contains("line 2: column x: '0,5' is not a number; write decimals behind a point"), "{error}");
}

#[test]
fn unread_columns_hold_anything() {
    let frames = read_csv("id,x,material,note,T\n1,0.5,glass,a b,nan\n2,1.5,3,,300\n").unwrap();
    let [frame] = &frames[..] else { panic!("{frames:?}") };
    assert_eq!(
        (&frame.columns[..], &frame.unread[..]),
        (&["id", "x", "material"].map(String::from)[..], &["note", "T"].map(String::from)[..])
    );
    assert_eq!((frame.word(0, 2), frame.word(1, 2), frame.values[5]), (Some("glass"), None, 3.0));
    let error = read_csv("id,x\n1,nan\n").unwrap_err();
    assert!(error.contains("line 2: column x: 'nan' is not finite"), "{error}");
}

#[test]
fn csv_frames_by_time() {
    let frames = read_csv("time,id,material\n0,1,glass\n1,1,glass\n-0,2,steel\n1,2,3\n").unwrap();
    let found: Vec<_> =
        frames.iter().map(|frame| (frame.time, frame.line, frame.rows().count(), frame.word(1, 2))).collect();
    assert_eq!(found, [(Some(0.0), 2, 2, Some("steel")), (Some(1.0), 3, 2, None)]);
    assert_eq!(frames[0].lines, [2, 4]);
    // A temperature is no time.
    assert_eq!(read_csv("id,T\n1,300\n2,310\n").unwrap().len(), 1);
}

/// Ten times as many frames take ten times as long; a search of all earlier frames would take a hundred times as long.
#[test]
fn csv_frames_in_linear_time() {
    let rows = |frames: usize| (0..frames * 50).map(|row| format!("{},{row}\n", row / 50)).collect::<String>();
    let seconds = |frames: usize| {
        let text = format!("time,id\n{}", rows(frames));
        let clock = std::time::Instant::now();
        assert_eq!(read_csv(&text).unwrap().len(), frames);
        clock.elapsed().as_secs_f64()
    };
    let (few, many) = (seconds(1000), seconds(10_000));
    assert!(many < 40.0 * few.max(1e-3), "{few} s for 1,000 frames, {many} s for 10,000");
}

#[test]
fn column_names_of_codes() {
    let same = |names: &[&str], column: Column| {
        for name in names {
            assert_eq!(column_of(name), Some(column), "{name}");
        }
    };
    same(&["x", "X", "xu", "position_x", "Points_0", "Points:0"], Column::Position(0));
    same(&["vz", "velocity_z", "velocity_2", "linVelVec_2"], Column::Velocity(2));
    same(&["omegay", "wy", "angular_velocity_y", "angVelVec_1", "omega[1]"], Column::Spin(1));
    same(&["radius", "r", "radii"], Column::Radius);
    same(&["id1", "first"], Column::First);
    same(&["fx", "force_x"], Column::Force(0));
    same(&["fny", "fn_y"], Column::NormalOnFirst(1));
    same(&["ftz"], Column::TangentialOnFirst(2));
    same(&["type", "material", "matId", "materialId"], Column::Kind);
    // A temperature, or a time: the name does not say which.
    for nothing in ["T", "t", "xs", "mass", "id3", "fn2", "", "c_pairs[4]", "_"] {
        assert_eq!(column_of(nothing), None, "{nothing}");
    }
}
