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
