//! Unit tests of `src/report/bias.rs`.

use super::{Bias, biases, conditions, figure, rows, table};
use makadam_compare::compare::{Comparison, Row, comparison};
use makadam_frames::plan::MeasuredScene;
use std::path::Path;

/// Comparisons of scenes, each with the value of the code under test and those of two reference codes.
fn compared(scenes: &[(&str, f64, [f64; 2])]) -> Vec<Comparison> {
    let of_scene = |&(name, own, references): &(&str, f64, [f64; 2])| {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../reference-scenes").join(name).join("scene.toml");
        let row = |(code, reference): (&str, f64)| Row {
            scene: name.into(),
            observable: "coordination_number".into(),
            code: "Makadam".into(),
            mean: Some(own),
            reference_code: Some(code.into()),
            difference: Some(own - reference),
            ..Row::default()
        };
        let empty = comparison(&MeasuredScene::load(&file).unwrap(), &[], Vec::new());
        Comparison { rows: ["YADE", "LIGGGHTS"].into_iter().zip(references).map(row).collect(), ..empty }
    };
    scenes.iter().map(of_scene).collect()
}

fn assert_near(value: f64, expected: f64) {
    assert!((value - expected).abs() < 1e-9, "{value} instead of {expected}");
}

#[test]
fn bias_and_scatters_are_those_of_the_formulas() {
    // Expected values from a separate program.
    let all = compared(&[("packing", 1.0, [0.99, 1.01]), ("drum", 2.1, [1.98, 2.02])]);
    let [Bias { bias, error, scatter, scatter_of_references: Some(references), .. }] = biases(&all)[..] else {
        panic!("one observable")
    };
    assert_near(bias, 0.02501627349885882);
    assert_near(error, 0.024395082084715983);
    assert_near(scatter, 0.02695964135100516);
    assert_near(references, 0.014142607056538052);
    // The code under test lies in the middle of references that differ: its scatter cannot be shown to be smaller than theirs.
    let all = compared(&[("packing", 1.0, [0.9, 1.1]), ("drum", 2.0, [1.8, 2.2])]);
    let found = biases(&all);
    assert_near(found[0].scatter, found[0].scatter_of_references.unwrap());
}

#[test]
fn an_observable_needs_two_scenes_and_positive_values() {
    assert!(biases(&compared(&[("packing", 1.0, [0.9, 1.1])])).is_empty());
    assert!(biases(&compared(&[("packing", 1.0, [0.9, 1.1]), ("drum", -1.0, [-0.9, -1.1])])).is_empty());
    assert_eq!(figure(&[]), None);
}

#[test]
fn tables_and_figure_state_each_pair_and_the_conditions() {
    let all = compared(&[("packing", 1.0, [0.99, 1.01]), ("drum", 2.1, [1.98, 2.02])]);
    let found = biases(&all);
    let page = table(&found).html();
    assert!(page.contains("1: coordination number") && page.contains("drum, YADE"), "{page}");
    assert_eq!(rows(&all).len(), 4);
    assert!(figure(&found).unwrap().contains("svg"));
    let page = conditions(&all).html();
    // The drum turns at 1 rad/s and has a radius of 0.1 m: Froude number 0.0102.
    assert!(page.contains("Froude number") && page.contains("0.010"), "{page}");
}
