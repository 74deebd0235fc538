//! Unit tests of `src/wall/index.rs`.

use super::*;

/// Balls here and there, some of them beyond the domain of a period of 2 m.
fn balls(period: Period) -> Vec<Face> {
    let at = |number: usize, factor: usize| (number * factor % 1009) as f64 / 1009.0 * 3.0 - 1.5;
    let centre = |number: usize| Vector::new(at(number, 211), at(number, 367), 0.1 * at(number, 523));
    (0..500).map(|number| Face::Ball { centre: centre(number), radius: 0.03, period }).collect()
}

#[test]
fn every_face_that_is_near_is_found_and_few_others() {
    for repeats in [[false; 3], [true, true, false]] {
        let period = Period::new([2.0; 3], repeats);
        let faces = balls(period);
        let index = FaceIndex::new(&faces, 7, period).unwrap();
        let mut asked = 0;
        for (number, radius) in [(3, 0.01), (5, 0.05), (11, 0.3), (77, 1.5), (90, 0.0)] {
            let scale = if repeats[0] { 40.0 } else { 1.0 };
            let point = Vector::new((number as f64).sin() * scale, (number as f64).cos() * scale, 0.05);
            let mut found = Vec::new();
            index.for_each_near(&point, radius, |face| found.push(face));
            asked += found.len();
            found.sort_unstable();
            let near = |face: &Face| face.nearest(&point, Vector::zeros).0 < radius;
            let missed = (7..).zip(&faces).find(|(number, face)| near(face) && !found.contains(number));
            assert!(missed.is_none(), "{missed:?} is within {radius} of {point}");
        }
        assert!(asked < 1500, "{asked} were asked of 2500");
    }
}

#[test]
fn a_point_that_is_nowhere_is_near_to_nothing_and_ends_no_run() {
    let period = Period::new([2.0; 3], [true; 3]);
    let index = FaceIndex::new(&balls(period), 0, period).unwrap();
    index.for_each_near(&Vector::repeat(f64::NAN), 1.0, |_| panic!("found a face"));
    let mut found = 0;
    index.for_each_near(&Vector::repeat(1e300), f64::INFINITY, |_| found += 1);
    assert_eq!(found, 500);
}

#[test]
fn few_faces_and_endless_ones_have_no_index() {
    let plane = Face::Plane { point: Vector::zeros(), normal: Vector::z() };
    let period = Period::default();
    assert!(FaceIndex::new(&balls(period)[..FEWEST - 1], 0, period).is_none());
    let mut mixed = balls(period);
    mixed.push(plane);
    assert!(FaceIndex::new(&mixed, 0, period).is_none());
}
