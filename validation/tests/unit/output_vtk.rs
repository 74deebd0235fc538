//! Unit tests of `src/output/vtk.rs`.

use super::*;
use crate::output::outline_vtk as outline;

/// A file of every kind of array.
fn sample(points: usize) -> PolyData {
    let noise = |n: usize| f64::from((n as u32).wrapping_mul(2_654_435_769)) / 4e9;
    PolyData {
        time: 1.25,
        points: Array::floats("Points", 3, (0..3 * points).map(noise)),
        cells: Cells::Vertices,
        point_data: vec![
            Array::integers("id", (0..points as i32).map(|id| id - 3)),
            Array::doubles("mass", 1, (0..points).map(|n| 0.5 * n as f64)),
            Array { name: "material".into(), components: 1, kind: Kind::UInt8, bytes: vec![7; points] },
        ],
        cell_data: Vec::new(),
        field_data: vec![Array::doubles("gravity", 3, [0.0, 0.0, -9.81].into_iter())],
        texts: vec![("materials".into(), vec!["glass".into(), "a <b> & \"ü\"".into()])],
    }
}

#[test]
fn written_arrays_are_read_back() {
    for points in [0, 1, 7, BLOCK / 12, BLOCK / 4, 50_000] {
        let file = sample(points);
        let read = outline(&file.encode(), &|_, _| true).unwrap();
        assert_eq!((read.time, read.points, read.cells), (Some(file.time), points, points));
        let section = |name: &str| read.sections.iter().find(|(of, _)| *of == name).map(|(_, arrays)| arrays.clone());
        assert_eq!(section("PointData"), Some(file.point_data), "{points} points");
        assert_eq!(section("Points"), Some(vec![file.points]), "{points} points");
    }
}

#[test]
fn coordinates_far_from_the_origin_keep_their_places() {
    let at = |x: f64| Array::coordinates("Points", [x, 0.0, 0.0, x + 0.01, 0.0, 0.0].into_iter(), 0.005);
    let far = at(9e5);
    assert_eq!((far.kind, &far.values()[..]), (Kind::Float64, &[9e5, 0.0, 0.0, 9e5 + 0.01, 0.0, 0.0][..]));
    assert_eq!(at(0.2).kind, Kind::Float32, "near the origin single precision tells them apart");
}
