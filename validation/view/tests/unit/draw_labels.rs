//! Unit tests of `src/draw/labels.rs`.

use super::*;

#[test]
fn words_of_a_crowd_of_points_lie_on_nothing_and_inside() {
    let frame = Area { low: [0.0, 0.0], high: [300.0, 200.0] };
    let mut room = Room::new(frame);
    let points: Vec<[f64; 2]> = (0..24).map(|k| [20.0 + 4.0 * f64::from(k % 6), 20.0 + 5.0 * f64::from(k)]).collect();
    let marks: Vec<Area> = points.iter().map(|point| Area::around(*point, [5.0, 5.0])).collect();
    marks.iter().for_each(|mark| room.take(*mark));
    let words: Vec<Area> = points.iter().map(|point| room.place(*point, [15.0, 11.0]).expect("room")).collect();
    for (place, one) in words.iter().enumerate() {
        assert!(frame.holds(one));
        assert!(!marks.iter().chain(&words[..place]).any(|other| other.meets(one)), "{one:?}");
    }
    assert_eq!(room.place([10.0, 10.0], [400.0, 11.0]), None);
}
