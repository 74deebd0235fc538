//! Unit tests of `src/import/xml.rs`.

use super::*;
use crate::export::vtp::encode;
use crate::run_frames::columns::{Column, DOUBLE, DOUBLES, Part, REAL, VECTOR, WHOLE};

fn decode(bytes: &[u8]) -> Result<Content, String> {
    read(bytes, |_, _| true)
}

/// A frame as versions before compression wrote it.
fn uncompressed() -> String {
    let encode = |bytes: Vec<u8>| STANDARD.encode([&(bytes.len() as u64).to_le_bytes()[..], &bytes].concat());
    let radius = encode([0.5_f32, 0.25].iter().flat_map(|value| value.to_le_bytes()).collect());
    let points = encode((0..6).flat_map(|n| (n as f32).to_le_bytes()).collect());
    let time = encode(2.5_f64.to_le_bytes().to_vec());
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
             <PolyData>\n<FieldData>\n<DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"binary\">{time}\
             </DataArray>\n</FieldData>\n<Piece NumberOfPoints=\"2\" NumberOfVerts=\"2\" NumberOfLines=\"0\" NumberOfStrips=\"0\" \
             NumberOfPolys=\"0\">\n<PointData>\n<DataArray type=\"Float32\" Name=\"radius\" NumberOfComponents=\"1\" \
             format=\"binary\">{radius}</DataArray>\n</PointData>\n<Points>\n<DataArray type=\"Float32\" Name=\"Points\" \
             NumberOfComponents=\"3\" format=\"binary\">{points}</DataArray>\n</Points>\n</Piece>\n</PolyData>\n</VTKFile>\n"
    )
}

#[test]
fn frames_of_earlier_versions_are_read() {
    let file = decode(uncompressed().as_bytes()).unwrap();
    assert_eq!((file.time, file.count), (Some(2.5), 2));
    let points = Named::new("points", 3, Some(vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0]));
    assert_eq!(file.arrays, [points, Named::new("radius", 1, Some(vec![0.5, 0.25]))]);
}

#[test]
fn written_arrays_are_read_back() {
    // Several blocks of compression, a whole one, and a part of one.
    for points in [0, 1, 7, 65_536 / 12, 65_536 / 4, 50_000] {
        let noise = |n: usize| f64::from((n as u32).wrapping_mul(2_654_435_769)) / 4e9;
        let file = Part {
            corners_per_cell: 1,
            time: 1.25,
            points: Column::new("Points", VECTOR, (0..3 * points).map(noise)),
            corners: None,
            of_points: vec![
                Column::new("id", WHOLE, (0..points).map(|id| id as f64 - 3.0)),
                Column::new("mass", DOUBLE, (0..points).map(|n| 0.5 * n as f64)),
                Column::new("material", (Number::UInt8, 1), vec![7.0; points]),
            ],
            of_cells: Vec::new(),
            whole: vec![Column::new("gravity", DOUBLES, [0.0, 0.0, -9.81])],
            texts: vec![("materials", vec!["glass".into(), "a <b> & \"ü\"".into()])],
        };
        let found = decode(&encode(&file)).unwrap();
        assert_eq!((found.time, found.count), (Some(file.time), points));
        let named = |column: &Column| Named::new(column.name.to_lowercase(), column.width, Some(column.values.clone()));
        let wanted: Vec<Named> = std::iter::once(&file.points).chain(&file.of_points).map(named).collect();
        assert_eq!(found.arrays, wanted, "{points} points");
    }
}

#[test]
fn damaged_files_are_refused_with_a_reason() {
    let refused = |bytes: &[u8], reason: &str| {
        let error = decode(bytes).unwrap_err();
        assert!(error.contains(reason), "{error}");
    };
    let old = uncompressed();
    refused(b"", "no XML");
    refused(b"<VTKFile type=\"ImageData\"/>", "no polygonal data");
    refused(old.replace("NumberOfPoints=\"2\"", "NumberOfPoints=\"3\"").as_bytes(), "24 bytes in place of 36");
    refused(old.replace("Float32", "Float16").as_bytes(), "Float16");
    let new = encode(&Part {
        corners_per_cell: 1,
        time: 2.5,
        points: Column::new("Points", VECTOR, (0..6).map(f64::from)),
        corners: None,
        of_points: vec![Column::new("radius", REAL, [0.5, 0.25])],
        of_cells: Vec::new(),
        whole: Vec::new(),
        texts: Vec::new(),
    });
    assert!(decode(&new).is_ok());
    // Whatever byte is lost or changed, there is an answer and no panic.
    for end in 0..new.len() {
        let _ = decode(&new[..end]);
    }
    for place in 0..new.len() {
        let mut changed = new.clone();
        changed[place] ^= 0x55;
        let _ = decode(&changed);
    }
    // The first stream is that of the time.
    let place = new.windows(2).position(|bytes| bytes == [0x78, 0x01]).unwrap();
    let mut changed = new.clone();
    changed[place + 4] ^= 0xff;
    refused(&changed, "damaged");
}
