//! The summary of a report, the table of every test.

use crate::support::sample;
use makadam_compare::compare::{Comparison, Row};
use makadam_qualification::report::write;
use roxmltree::{Document, Node, ParsingOptions};
use std::fs;

/// Its text, in a report of one scene.
fn summary(comparison: Comparison) -> String {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let page_file = write(&sample::qualification(vec![comparison]), folder.path()).expect("a report");
    let page = fs::read_to_string(&page_file).expect("the page");
    let options = ParsingOptions { allow_dtd: true, ..Default::default() };
    let document = Document::parse_with_options(&page, options).expect("well-formed markup");
    let is = |node: &Node<'_, '_>| node.attribute("class").is_some_and(|class| class.contains("summary"));
    let table = document.descendants().find(is).expect("a summary");
    table.descendants().filter_map(|node| node.text()).collect::<Vec<_>>().join(" ")
}

#[test]
fn of_several_other_codes_the_two_farthest_apart_are_the_floor() {
    let mut drum = sample::drum(false);
    let of_two = summary(drum.clone());
    assert!(of_two.contains("LIGGGHTS − YADE") && !of_two.contains("widest"), "{of_two}");
    let is_angle = |row: &&Row| row.code == "LIGGGHTS" && row.observable == "dynamic_angle_of_repose";
    let floor = drum.rows.iter().find(is_angle).expect("a floor").clone();
    for (code, difference) in [("YADE", -0.77), ("LIGGGHTS", -0.91)] {
        let reference_code = Some("LAMMPS".into());
        drum.rows.push(Row { code: code.into(), reference_code, difference: Some(difference), ..floor.clone() });
    }
    let of_three = summary(drum);
    assert!(of_three.contains("widest between the others") && of_three.contains("−0.91"), "{of_three}");
    assert!(of_three.contains("LIGGGHTS − LAMMPS") && !of_three.contains("−0.77"), "{of_three}");
}
