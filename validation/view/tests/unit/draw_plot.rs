//! Unit tests of `src/draw/plot.rs`.

use super::*;

#[test]
fn legends_break_their_line_before_the_edge() {
    let axes = || (Axis::linear("x", 0.0, 1.0), Axis::linear("y", 0.0, 1.0));
    let all = ["Makadam", "YADE", "LIGGGHTS", "LAMMPS"].map(Key::Code);
    let keys: Vec<Key<'_>> = all.into_iter().chain([Key::Line("literature", "Mueth 1998")]).collect();
    for (shown, lines) in [(3, 1), (4, 1), (5, 2)] {
        let (x, y) = axes();
        let svg = Plot::with_legend(x, y, &keys[..shown]).finish("a plot");
        let mut heights = Vec::new();
        for text in svg.split("<text class=\"key\" x=\"").skip(1) {
            let number = |text: &str| text.split('"').next().unwrap().parse::<f64>().unwrap();
            let label = text.split_once('>').unwrap().1.split('<').next().unwrap();
            heights.push(number(text.split_once("y=\"").unwrap().1));
            let end = number(text) + 7.6 * label.chars().count() as f64;
            assert!(end <= WIDTH, "{label} ends at {end}");
        }
        assert_eq!(heights.len(), shown);
        heights.dedup();
        assert_eq!(heights.len(), lines, "{shown} keys");
    }
}

#[test]
fn zero_has_no_place_on_a_logarithmic_axis() {
    for make in [Axis::logarithmic, Axis::fine, Axis::doublings] {
        for (low, high) in [(0.0, 2.0), (-1.0, 3e-3), (0.0, 0.0), (f64::NAN, f64::INFINITY)] {
            let axis = make("time", low, high);
            assert!(axis.low > 0.0 && axis.high > axis.low, "{low} {high}");
            assert!((1..100).contains(&axis.ticks(5).len()), "{low} {high}");
        }
    }
}

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
